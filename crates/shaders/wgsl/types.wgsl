// Structs shared with Rust (`layout.rs`). A test compares every offset.

struct View {
    // Reversed depth: 1 at the near plane, 0 at infinity.
    clip_from_world: mat4x4f,
    world_from_clip: mat4x4f,
    // xyz: eye position (w = 1, perspective) or direction to the viewer (w = 0, parallel).
    eye_world: vec4f,
    // Picture size in samples.
    size: vec2u,
    // Bit 0: draw the environment behind the scene. Bit 1: matte surfaces take irradiance from `full_sh`.
    flags: u32,
    // Samples of the picture along the side of a tile of the shadow buffer.
    shadow_sampling: u32,
    // Distance in the world from a sample to the next, across the view at a distance of 1 or in a parallel view.
    sample_extent: f32,
    // The G-buffer is drawn in so many parts a side, each with every so manyth sample: 1 or 2.
    interleave: u32,
    padding_0: f32,
    padding_1: f32,
    // SH coefficients (rgb) of radiance, in the order of `Sh9`: the residual's, the whole environment's.
    residual_sh: array<vec4f, 9>,
    full_sh: array<vec4f, 9>,
    // Rotation of directions: the environment's maps and coefficients stay as they are when it turns.
    environment_from_world: mat4x4f,
}

const SHAPE_DISK: u32 = 0u;
const SHAPE_RECTANGLE: u32 = 1u;

// Where a light is: infinitely far away; in the scene and flat; a sphere in the scene.
const KIND_DISTANT: u32 = 0u;
const KIND_FLAT: u32 = 1u;
const KIND_SPHERE: u32 = 2u;

// What a light is for: light, or to tell how much of the sky is open.
const ROLE_LIGHT: u32 = 0u;
const ROLE_PROBE: u32 = 1u;

// A uniform area light and its shadow map's frame. The outline of a light in the scene is given as it would look straight on from a
// distance of 1 m: then tangents of angles are metres.
struct Light {
    // From the scene towards the light: to the centre of a distant one, against the front's normal of a flat one, against the
    // map's axis of a sphere.
    direction: vec3f,
    shape: u32,
    // Axes of the tangent plane at `direction`, the same as the shadow map's u and v.
    tangent: vec3f,
    // Disk only [rad].
    angular_radius: f32,
    bitangent: vec3f,
    // [sr]; of a light in the scene the emitting area that a direction sees at most [m^2].
    solid_angle: f32,
    radiance: vec3f,
    padding_2: f32,
    // Rectangle only: unit directions, counter-clockwise seen from the scene.
    corners: array<vec4f, 4>,
    // xy in [-1, 1]. Orthographic for a distant light, z the linear depth in [0, 1] from near to far; else perspective, w the
    // distance along the map's axis [m].
    light_from_world: mat4x4f,
    // Edge length of the square shadow map [m]; of a perspective map at a distance of 1 m.
    map_width_world: f32,
    // Distance from near to far plane [m].
    depth_range_world: f32,
    // Distance by which a receiver is moved along its normal against self-shadowing [m]; in a perspective map at a distance
    // of 1 m.
    normal_offset_world: f32,
    // Distance of the near plane from a light in the scene [m].
    near_world: f32,
    // Centre of a light in the scene [m].
    position: vec3f,
    kind: u32,
    // Half width and height, a disk's and a sphere's radius in both: of a light in the scene [m], of a distant one at a distance of 1.
    half_extent: vec2f,
    role: u32,
    // How far what is drawn into the map may deviate from the scene [m].
    caster_deviation_world: f32,
    // Of a distant rectangle at radiance 1 (Arvo 1994): times a normal that has all of it above the horizon, its form factor [sr].
    vector_irradiance: vec3f,
    padding_1: f32,
}

// Most lights of a batch: what fits into the 64 KiB that every adapter allows a uniform buffer.
const MAX_BATCH_LIGHTS: u32 = 160u;

// A batch of lights whose maps are held together.
struct Batch {
    // Lights from the first that is summed to the one after the last.
    first_light: u32,
    end_light: u32,
    // Bit 0: the first of the frame.
    flags: u32,
    padding_0: u32,
}

const FLAG_FIRST: u32 = 1u;

// Where light is summed.
struct ShadingPoint {
    position_world: vec3f,
    // Row times the picture's width plus column.
    sample: u32,
    normal: vec3f,
    padding: u32,
}

// Index of no point.
const NO_POINT: u32 = 0xffffffffu;
// Points a workgroup.
const LIGHT_WORKGROUP: u32 = 64u;

// What the lights of the batches so far give one point: irradiance, and specular radiance.
struct LightSums {
    diffuse_unshadowed: vec3f,
    // Projected solid angle of the probes: of all, and of what is visible of them.
    probed: f32,
    diffuse_shadowed: vec3f,
    probed_open: f32,
    specular_unshadowed: vec3f,
    padding_0: f32,
    specular_shadowed: vec3f,
    padding_1: f32,
    // Of lights in the scene, shadowed: the environment's compositing rule does not concern them.
    diffuse_near: vec3f,
    padding_2: f32,
    specular_near: vec3f,
    padding_3: f32,
}

// Most lobes of the radiance cache.
const MAX_CACHED_LOBES: u32 = 16u;

// What shapes a lobe of the radiance cache.
struct CachedLobe {
    model: u32,
    // Roughness, shininess or slope.
    parameter: f32,
    padding_0: u32,
    padding_1: u32,
}

// The radiance cache's frame, whose z axis points to the viewer, and its lobes.
struct RadianceCache {
    right: vec3f,
    count: u32,
    up: vec3f,
    // Samples a texel.
    samples: u32,
    to_viewer: vec3f,
    padding: u32,
    // As in `View`.
    environment_from_world: mat4x4f,
    lobes: array<CachedLobe, MAX_CACHED_LOBES>,
}

// One vertex as it lies in its mesh.
struct MeshVertex {
    position: vec3f,
    // Index into the instance transforms.
    instance: u32,
    normal: vec3f,
    tangent_sign: f32,
    tangent: vec3f,
    // Where its record of joints and morph targets begins; 0 for a vertex that only follows its instance.
    record: u32,
}

// Rigid or affine placement of a mesh.
struct Instance {
    world_from_mesh: mat4x4f,
    // Cofactors: for normals, and for the tangents of normal maps, as the reference does it.
    normal_from_mesh: mat4x4f,
    // Of its skin, among all joints; NO_SKIN without.
    first_joint: u32,
    // Of its morph targets, among all weights.
    first_weight: u32,
    padding: vec2u,
}

const NO_SKIN: u32 = 0xffffffffu;

// Factors of a material; textures multiply them.
struct Material {
    base_color: vec4f,
    emissive: vec3f,
    metallic: f32,
    specular_color: vec3f,
    specular: f32,
    roughness: f32,
    ior: f32,
    normal_scale: f32,
    // Alpha below this is a hole; 0 for opaque materials.
    alpha_cutoff: f32,
    // Reflectance model, a number of `brdf_reflectance.wgsl`, and of all but metallic-roughness what shapes its lobe.
    model: u32,
    lobe_parameter: f32,
    padding_0: u32,
    padding_1: u32,
    // Rows of uv_from_mesh (xyz) and the coordinate set (w), two vectors a texture, in the order of the bindings.
    uv_rows: array<vec4f, 12>,
}

// Parameters of hard shadow maps, stored or linear.
struct HardParameters {
    // Receiver depth is moved towards the light by this much, in the depth that is compared.
    depth_bias: f32,
    padding_0: f32,
    padding_1: f32,
    padding_2: f32,
}

// Parameters of percentage-closer filtering.
struct PcfParameters {
    samples: u32,
    // Radius of the kernel as a share of the map's side.
    radius_uv: f32,
    // Receiver depth is moved towards the light by this much, in linear depth.
    depth_bias: f32,
    // Factor on the lights' offset along the normal.
    normal_offset_scale: f32,
}

// Parameters of percentage-closer soft shadows.
struct PcssParameters {
    search_samples: u32,
    filter_samples: u32,
    // Receiver depth is moved towards the light by this much, in linear depth.
    depth_bias: f32,
    // Factor on the lights' offset along the normal.
    normal_offset_scale: f32,
    // Not 0: every point of the scene turns the point sets by noise of its own.
    rotate_per_pixel: u32,
    padding_0: u32,
    padding_1: u32,
    padding_2: u32,
}

// Parameters of moment soft shadow maps.
struct MomentParameters {
    // Edge length of the shadow map in texels.
    resolution: f32,
    // Coarsest mip level.
    max_level: f32,
    // Share of a wide distribution mixed into every lookup.
    moment_bias: f32,
    // Receiver depth is moved towards the light by this much, in linear depth.
    depth_bias: f32,
    // The same per kernel width and slope of the receiver.
    slope_bias: f32,
    // Factor on every kernel's width.
    footprint_scale: f32,
    // Factor on the shadow, whose reconstruction is a lower bound.
    intensity_scale: f32,
    // Factor on the lights' offset along the normal.
    normal_offset_scale: f32,
}

// Parameters of convolution shadows (Annen et al. 2008).
struct ConvolutionParameters {
    // Terms of the series, M.
    order: u32,
    // RGBA layers a light needs for M terms.
    groups: u32,
    // Edge length of the shadow map in texels.
    resolution: f32,
    // Coarsest mip level.
    max_level: f32,
    // Ringing suppression: value of the series that becomes 0, and that becomes 1.
    black_point: f32,
    white_point: f32,
    // Sharpening p = 1 + A exp(-B (d - z_avg)).
    sharpening_a: f32,
    sharpening_b: f32,
    // Receiver depth is moved towards the light by this much, in scaled light depth: in the final lookup, and where blocker
    // depth is averaged.
    depth_bias: f32,
    average_bias: f32,
    // Widens kernels by what ringing suppression narrows penumbrae.
    footprint_scale: f32,
    // Times the shadow map's plane is put at the average blocker depth.
    plane_iterations: u32,
    // Places of the depth map looked at for blockers near the receiver, 0 for none.
    contact_samples: u32,
    // How near those are, in linear depth.
    contact_reach: f32,
    padding_0: u32,
    padding_1: u32,
    // Basis at the far plane, group by group: of texels that nothing blocks.
    far_sin: array<vec4f, 4>,
    far_cos: array<vec4f, 4>,
}

struct ResolveParameters {
    // Samples along a pixel's side.
    samples: u32,
    // 2^EV.
    exposure: f32,
    // 0 clip, 1 Khronos PBR Neutral.
    tone_mapping: u32,
    padding: u32,
}

// What a debug view shows, and how.
struct DebugParameters {
    // One of the VIEW constants of `debug_view.wgsl`.
    view: u32,
    // The light shown, within its batch, and whether it is of this batch.
    light: u32,
    has_light: u32,
    // Whether depth maps are drawn at all.
    has_maps: u32,
    // Direction to the viewer, along which depth is measured.
    to_viewer: vec3f,
    // Lights of the batches before.
    lights_before: u32,
    // Of what is seen [m].
    least_depth: f32,
    depth_range: f32,
    // Factor of the exposure in force.
    exposure: f32,
    // Of this batch.
    light_count: u32,
}
