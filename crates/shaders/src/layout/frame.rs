//! What a frame is seen and lit by.

use glam::{Mat4, UVec2, Vec2, Vec3, Vec4};

super::constants! {
    /// Bind group of the frame: binding 0 is the [`View`] wherever there is one.
    pub const GROUP_FRAME: u32 = 0;
    /// Bind group of surfaces: materials and their textures where they are drawn, the G-buffer in passes over the screen.
    pub const GROUP_SURFACE: u32 = 1;
    /// Bind group of the shadow technique.
    pub const GROUP_SHADOW: u32 = 2;
    /// Bind group of where the scene's triangles are drawn, in the place of the shadow technique's.
    pub const GROUP_PLACEMENTS: u32 = 2;
    /// Bind group of the pass's own inputs and outputs.
    pub const GROUP_PASS: u32 = 3;

    /// Invocations along the side of a workgroup of passes over a picture or map.
    pub const TILE: u32 = 8;
    /// Points a workgroup.
    pub const LIGHT_WORKGROUP: u32 = 64;

    /// [`View::flags`]: draw the environment behind the scene.
    pub const FLAG_BACKGROUND: u32 = 1;
    /// [`View::flags`]: matte surfaces take irradiance from [`View::full_sh`].
    pub const FLAG_SPHERICAL_HARMONICS: u32 = 2;
    /// [`View::flags`]: sums of specular light are kept.
    pub const FLAG_SPECULAR_SUMS: u32 = 4;
    /// [`View::flags`]: sums of the light of the scene's own lights are kept.
    pub const FLAG_NEAR_SUMS: u32 = 8;
    /// [`View::flags`]: the lights leave out what arrives nowhere or are no fit's: unshadowed light is theirs and not the whole environment's.
    pub const FLAG_OWN_LIGHT: u32 = 16;
    /// [`View::flags`]: light is summed with visibilities by few rays.
    pub const FLAG_GRAINY_SUMS: u32 = 32;
    /// [`View::flags`]: sums of the environment's specular light are of rays by the surfaces' lobes, not of the lights.
    pub const FLAG_TRACED_GLOSS: u32 = 64;
    /// [`View::flags`]: unshadowed specular light is that of samples of the lobe.
    pub const FLAG_SAMPLED_GLOSS: u32 = 128;
    /// [`View::flags`]: among the specular sums of near light is what lobes reflect of the scene.
    pub const FLAG_MIRRORED_SCENE: u32 = 256;
    /// [`View::flags`]: sums of light are kept in floats.
    pub const FLAG_WIDE_SUMS: u32 = 512;

    /// [`View::flags`]: bumps light each other.
    pub const FLAG_BUMP_SCATTER: u32 = 1024;
    /// [`View::flags`]: grainy sums are averaged over what shadows allow; there are no probes.
    pub const FLAG_EVENED_SUMS: u32 = 2048;

    /// [`Light::shape`] of a disk.
    pub const SHAPE_DISK: u32 = 0;
    /// [`Light::shape`] of a quadrilateral.
    pub const SHAPE_RECTANGLE: u32 = 1;
    /// [`Light::kind`] of a light infinitely far away.
    pub const KIND_DISTANT: u32 = 0;
    /// [`Light::kind`] of a flat light in the scene.
    pub const KIND_FLAT: u32 = 1;
    /// [`Light::kind`] of a sphere in the scene.
    pub const KIND_SPHERE: u32 = 2;
    /// [`Light::role`] of a light that lights.
    pub const ROLE_LIGHT: u32 = 0;
    /// [`Light::role`] of a light that only tells how much of the sky is open.
    pub const ROLE_PROBE: u32 = 1;
    /// [`Light::role`] of a distant light of the scene's own: it is no part of the environment's light.
    pub const ROLE_SUN: u32 = 2;
    /// [`Light::role`] of a light of the environment that the map which is mirrored does not show.
    pub const ROLE_TAKEN_OUT: u32 = 3;
    /// A flat light gives nothing to what is nearer to its plane than this share of its smaller half side: `gnomon_scene::FLAT_CLEARANCE`.
    pub const FLAT_CLEARANCE: f32 = 3e-4;
    /// Values of [`Light::profile`].
    pub const PROFILE_VALUES: u32 = 24;
    /// Most lights of a batch: what fits into the 64 KiB that every adapter allows a uniform buffer.
    pub const MAX_BATCH_LIGHTS: u32 = 160;
    /// [`Batch::flags`]: nothing has been summed before.
    pub const FLAG_FIRST: u32 = 1;
    /// [`Batch::group`]: all lights are let through.
    pub const ALL_GROUPS: u32 = u32::MAX;

    /// Words of the buffer that keeps account of points: points listed so far, by all stages.
    pub const WORK_POINTS: u32 = 0;
    /// Pixels whose samples are composed one by one.
    pub const WORK_EDGES: u32 = 1;
    /// For each stage [`WORK_STAGE`] words: arguments of an indirect dispatch (x, y, 1), the point after its last one, its first one.
    pub const WORK_STAGES: u32 = 4;
    /// See [`WORK_STAGES`].
    pub const WORK_STAGE: u32 = 8;
    /// Most stages: two for each of [`View::point_lists`].
    pub const MAX_POINT_STAGES: u32 = 4;
    /// Arguments of the dispatch over edge pixels, and their number.
    pub const WORK_EDGE_DISPATCH: u32 = 36;
    /// A word for every pixel that tells whether it is an edge pixel, then the list of those.
    pub const WORK_PIXELS: u32 = 40;

    /// Most tiles on each side that grainy sums are averaged over.
    pub const EVEN_REACH: u32 = 4;

    /// Index of no point.
    pub const NO_POINT: u32 = u32::MAX;

    /// Most lobes of the radiance cache.
    pub const MAX_CACHED_LOBES: u32 = 16;
    /// Most emitters of an environment.
    pub const MAX_EMITTERS: u32 = 32;
}

super::structs! {
    /// The camera and its picture.
    pub struct View {
        /// Reversed depth: 1 at the near plane, 0 at infinity.
        pub clip_from_world: Mat4,
        /// Its inverse.
        pub world_from_clip: Mat4,
        /// xyz: eye position (w = 1, perspective) or direction to the viewer (w = 0, parallel).
        pub eye_world: Vec4,
        /// Lists of shading points, the coarsest first; the picture is made of the last one. Uniform buffers
        /// have structs at multiples of 16 bytes.
        pub point_lists: [PointList; 2],
        /// Picture size in samples.
        pub size: UVec2,
        /// FLAG constants.
        pub flags: u32,
        /// Samples along the side of a pixel.
        pub supersample: u32,
        /// Distance in the world from a sample to the next, across the view at a distance of 1 or in a parallel view.
        pub sample_extent: f32,
        /// The G-buffer is drawn in so many parts a side, each with every so manyth sample: 1 or 2.
        pub interleave: u32,
        /// How many there are.
        pub point_list_count: u32,
        /// Samples of a glossy lobe.
        pub gloss_samples: u32,
        /// Whether heights bend normals: 0 or 1.
        pub bumps: u32,
        /// The list at which rough gloss is traced; smooth gloss is at the last one.
        pub rough_gloss_list: u32,
        /// What is kept in halves is multiplied by these: diffuse light, specular light, that of the scene's own lights.
        pub sum_scales: Vec3,
        /// Radiance of a 1 in what is seen of the environment.
        pub background_factor: Vec3,
        /// Radiance of a 1 in its maps, which light.
        pub environment_factor: Vec3,
        /// SH coefficients (rgb) of the residual's radiance, in the order of `Sh9`.
        pub residual_sh: [Vec4; 9],
        /// The same of the whole environment.
        pub full_sh: [Vec4; 9],
        /// Rotation of directions: the environment's maps and coefficients stay as they are when it turns.
        pub environment_from_world: Mat4,
        /// Middle of the ground that fades [m].
        pub ground_center: Vec3,
        /// Height of the environment's camera over it; 0 for one with a colour of its own [m].
        pub ground_camera_height: f32,
        /// Distances from the middle between which it fades [m].
        pub ground_fade: Vec2,
    }

    /// Shading points that some lights are summed at. A list takes the sums of the one before over and adds its own lights.
    pub struct PointList {
        /// Samples along the side of a tile that one point stands for.
        pub sampling: u32,
        /// Where its tiles begin in the buffer of all lists' tiles.
        pub first_tile: u32,
        /// The stage that lists its first points: [`WORK_STAGES`].
        pub first_stage: u32,
        /// Uniform arrays take steps of 16 bytes.
        pub reserved: u32,
    }

    /// A step of listing points, each followed by the sum of light there.
    pub struct PointStage {
        /// Place in [`View::point_lists`].
        pub list: u32,
        /// Place among all stages.
        pub stage: u32,
        /// Samples along the side of a block of which a sample may stand for others.
        pub block: u32,
        /// Least change of visibility between neighbouring points for which there are more.
        pub contrast: f32,
        /// Whether the pass is over edge pixels alone, not over the whole picture.
        pub over_edges: u32,
    }

    /// A uniform area light and its shadow map's frame. The outline of a light in the scene is given as it would look straight on from
    /// a distance of 1 m: then tangents of angles are metres.
    pub struct Light {
        /// From the scene towards the light: to the centre of a distant one, against the front's normal of a flat one, against the
        /// map's axis of a sphere.
        pub direction: Vec3,
        /// SHAPE constant.
        pub shape: u32,
        /// Axis of the tangent plane at `direction`, the same as the shadow map's u.
        pub tangent: Vec3,
        /// Disk only [rad].
        pub angular_radius: f32,
        /// The other axis, the map's v.
        pub bitangent: Vec3,
        /// Solid angle [sr]; of a light in the scene the emitting area that a direction sees at most [m^2].
        pub solid_angle: f32,
        /// Of every point.
        pub radiance: Vec3,
        /// Rectangle only: unit directions, counter-clockwise seen from the scene.
        pub corners: [Vec4; 4],
        /// xy in [-1, 1]. Orthographic for a distant light, z the linear depth in [0, 1] from near to far; else perspective, w the
        /// distance along the map's axis [m].
        pub light_from_world: Mat4,
        /// Edge length of the square shadow map [m]; of a perspective map at a distance of 1 m.
        pub map_width_world: f32,
        /// Distance from near to far plane [m].
        pub depth_range_world: f32,
        /// Distance by which a receiver is moved along its normal against self-shadowing [m]; in a perspective map at a distance
        /// of 1 m.
        pub normal_offset_world: f32,
        /// Distance of the near plane from a light in the scene [m].
        pub near_world: f32,
        /// Centre of a light in the scene [m].
        pub position: Vec3,
        /// KIND constant.
        pub kind: u32,
        /// Half width and height, a disk's and a sphere's radius in both: of a light in the scene [m], of a distant one at a distance of 1.
        pub half_extent: Vec2,
        /// ROLE constant.
        pub role: u32,
        /// How far what is drawn into the map may deviate from the scene [m].
        pub caster_deviation_world: f32,
        /// Distance from the eye from which on a distant light is this one [m]: in a large view it has others, with their own maps, elsewhere.
        pub from_distance: f32,
        /// Up to this one.
        pub to_distance: f32,
        /// What depths are compared with moves by so much of the technique's bias: a map may be small for its depths.
        pub bias_scale: f32,
        /// Lights with one number make one layer.
        pub group: u32,
        /// Of a distant rectangle at radiance 1 (Arvo 1994): times a normal that has all of it above the horizon, its form factor [sr].
        pub vector_irradiance: Vec3,
        /// Place in the frame's list of lights, whatever batch it is in.
        pub number: u32,
        /// Of a light in the scene, unit: the middle of what it sends its light to.
        pub front: Vec3,
        /// The last angle of its profile; 0 where it has none [rad].
        pub profile_end: f32,
        /// Shares of its radiance by the angle with its front, four a vector, see `profile_share`.
        pub profile: [Vec4; 6],
        /// What of its radiance it has in a direction: factor and summand of the cosine in `cone_share`.
        pub cone: Vec2,
    }

    /// A batch of lights whose maps are held together.
    pub struct Batch {
        /// First light that is summed.
        pub first_light: u32,
        /// One after the last.
        pub end_light: u32,
        /// FLAG constants.
        pub flags: u32,
        /// The [`Light::group`] whose light is let through, or [`ALL_GROUPS`].
        pub group: u32,
    }

    /// A small bright part of an environment, in its own frame: a disk of uniform radiance.
    pub struct Emitter {
        /// Unit vector to its middle.
        pub direction: Vec3,
        /// [rad].
        pub angular_radius: f32,
        /// Such that a surface that faces the disk gets the irradiance of the texels that it stands for.
        pub radiance: Vec3,
    }

    /// All of them.
    pub struct Emitters {
        /// How many there are.
        pub count: u32,
        /// The first of these.
        pub emitters: [Emitter; MAX_EMITTERS as usize],
    }

    /// Where light is summed. Only passes on the GPU write these.
    pub struct ShadingPoint {
        /// What is lit; not a vector, which would be padded.
        pub position_world: [f32; 3],
        /// Column in the lower 16 bits, row in the upper ones.
        pub sample: u32,
        /// Shading normal: octahedral, in halves.
        pub normal: u32,
    }

    /// What shapes a lobe of the radiance cache.
    pub struct CachedLobe {
        /// Reflectance model.
        pub model: u32,
        /// `Lobe::shape`. Uniform arrays take steps of 16 bytes.
        #[size(12)]
        pub shape: f32,
    }

    /// The radiance cache's frame, whose z axis points to the viewer, and its lobes.
    pub struct RadianceCache {
        /// x axis.
        pub right: Vec3,
        /// Number of lobes.
        pub count: u32,
        /// y axis.
        pub up: Vec3,
        /// Samples a texel.
        pub samples: u32,
        /// z axis.
        pub to_viewer: Vec3,
        /// As in [`View`].
        pub environment_from_world: Mat4,
        /// The first `count` are in use.
        pub lobes: [CachedLobe; MAX_CACHED_LOBES as usize],
    }
}
