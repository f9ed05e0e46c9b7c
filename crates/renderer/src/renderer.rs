use glam::{Mat4, Quat};

use gnomon_envmap::Equirect;
use gnomon_lights::LightSet;
use gnomon_picture::RgbImage;
use gnomon_picture::tonemap::ToneMapping;
use gnomon_scene::{Bounds, Camera, PlacedLight, Scene};
use gnomon_shaders::layout;

use crate::ambient::{self, Ambient};
use crate::camera::CameraMatrices;
use crate::compose::{ComposePass, RADIANCE_FORMAT};
use crate::composite::{self, Compositing};
use crate::depth_maps::{MapView, ShadowMapPass};
use crate::gbuffer::{GBuffer, GBufferPass};
use crate::geometry::{Geometry, TransformPass};
use crate::light_pass;
use crate::lighting::PreparedLighting;
use crate::lod::LevelOfDetail;
use crate::materials::Materials;
use crate::radiance_cache::{RadianceCache, RadianceCachePass};
use crate::recorder::{Clock, FrameTimings, PassTiming, Recorder};
use crate::resolve::{Output, ResolvePass};
use crate::settings::{RenderSettings, in_range};
use crate::shading_points::{ShadingPoints, ShadingPointsPass};
use crate::shadow::{self, ShadowTechnique};
use crate::unshadowed::{self, Unshadowed};
use crate::{Gpu, RenderError};

mod bands;
mod debug;
mod display;
mod lit;
mod live;
mod materials;
mod timing;

use bands::Band;
use lit::Lit;
use timing::FramesInFlight;
pub use timing::TimedFrame;

/// One finished picture.
pub struct Frame {
    /// Linear radiance, box-filtered.
    pub radiance: RgbImage,
    /// Exposed, tone-mapped and sRGB-encoded: RGBA, 8 bits, top row first.
    pub display: Vec<[u8; 4]>,
    /// Time of every pass, where [`crate::MeasureSettings::profile`] is on.
    pub timings: Vec<PassTiming>,
}

/// Draws a scene under an environment. Everything that depends on geometry happens in every frame.
pub struct Renderer {
    gpu: Gpu,
    settings: RenderSettings,
    technique: &'static dyn ShadowTechnique,
    ambient: &'static Ambient,
    compositing: &'static Compositing,
    unshadowed: &'static Unshadowed,
    passes: Passes,
    geometry: Geometry,
    materials: Materials,
    bounds: Option<Bounds>,
    near_lights: Vec<PlacedLight>,
    cache: RadianceCache,
    lighting: Option<Lit>,
    world_from_environment: Quat,
    target: Option<Target>,
    debug: Option<debug::Debug>,
    in_flight: FramesInFlight,
    view: wgpu::Buffer,
    view_group: wgpu::BindGroup,
}

struct Passes {
    transform: TransformPass,
    shadow_map: ShadowMapPass,
    gbuffer: GBufferPass,
    points: ShadingPointsPass,
    frame_layout: wgpu::BindGroupLayout,
    compose: ComposePass,
    cache: RadianceCachePass,
    resolve: ResolvePass,
}

/// What depends on the picture's size.
struct Target {
    size: [u32; 2],
    gbuffer: GBuffer,
    points: ShadingPoints,
    output: Output,
}

/// Samples of a lobe for every texel of the radiance cache.
const CACHE_SAMPLES: u32 = 128;

impl Renderer {
    /// A renderer of an empty scene without light.
    ///
    /// # Errors
    /// A setting names nothing or is out of range, or the device failed.
    pub fn new(gpu: &Gpu, settings: RenderSettings) -> Result<Self, RenderError> {
        settings.check()?;
        let scopes = gpu.catch_errors();
        let technique = shadow::usable(gpu, &settings.techniques.shadows)?;
        let ambient = ambient::by_name(&settings.lighting.ambient)?;
        let compositing = composite::by_name(&settings.techniques.compositing)?;
        let unshadowed = unshadowed::by_name(&settings.techniques.unshadowed)?;
        let gbuffer = GBufferPass::new(gpu)?;
        let points = ShadingPointsPass::new(gpu, &gbuffer.view_layout, &gbuffer.read_layout)?;
        let compose = ComposePass::new(gpu, &gbuffer.read_layout, &points.compose_layout, compositing)?;
        let passes = Passes {
            transform: TransformPass::new(gpu)?,
            shadow_map: ShadowMapPass::new(gpu)?,
            gbuffer,
            points,
            frame_layout: light_pass::frame_layout(gpu),
            compose,
            cache: RadianceCachePass::new(gpu)?,
            resolve: ResolvePass::new(gpu)?,
        };
        let scene = Scene::default();
        let view = gpu.empty_buffer(
            "view",
            layout::size::<layout::View>(),
            wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        );
        let view_group = passes.gbuffer.view_group(gpu, &view);
        let renderer = Self {
            gpu: gpu.clone(),
            technique,
            ambient,
            compositing,
            unshadowed,
            cache: RadianceCache::new(gpu, Vec::new(), 1, 1),
            geometry: Geometry::new(gpu, &passes.transform, &scene)?,
            materials: Materials::new(gpu, &passes.gbuffer.material_layout, &scene)?,
            passes,
            settings,
            bounds: None,
            near_lights: Vec::new(),
            lighting: None,
            world_from_environment: Quat::IDENTITY,
            target: None,
            debug: None,
            in_flight: FramesInFlight::default(),
            view,
            view_group,
        };
        scopes.finish()?;
        Ok(renderer)
    }

    /// Takes a scene over: its triangles, materials, textures and area lights.
    ///
    /// # Errors
    /// [`RenderError::OverLimit`] where the adapter cannot hold it; the scene before it then stays.
    pub fn set_scene(&mut self, scene: &Scene) -> Result<(), RenderError> {
        let scopes = self.gpu.catch_errors();
        let geometry = Geometry::new(&self.gpu, &self.passes.transform, scene)?;
        let materials = Materials::new(&self.gpu, &self.passes.gbuffer.material_layout, scene)?;
        self.set_near_lights(scene)?;
        (self.geometry, self.materials) = (geometry, materials);
        self.bounds = self.geometry.bounds();
        self.cache_lobes(scene);
        scopes.finish()
    }

    /// Takes a new pose of the scene that was set last (node transforms, joints, morph weights) without an upload of its meshes.
    /// A scene with other meshes is taken over whole.
    ///
    /// Vertices move on the GPU. What the CPU needs of a deformed mesh, the place of its shadow maps, follows from boxes around
    /// each joint's vertices: it may be larger than the mesh, and its shadows somewhat coarser than those of a rigid one.
    ///
    /// # Errors
    /// As [`Renderer::set_scene`].
    pub fn move_scene(&mut self, scene: &Scene) -> Result<(), RenderError> {
        let scopes = self.gpu.catch_errors();
        if !self.geometry.take_pose(&self.gpu, scene)? {
            return self.set_scene(scene);
        }
        self.bounds = self.geometry.bounds();
        self.set_near_lights(scene)?;
        scopes.finish()
    }

    /// Takes an environment over: `map` is what the camera sees and mirrors reflect, `set` how it casts light and shadow.
    ///
    /// # Errors
    /// [`RenderError::OverLimit`] where the adapter cannot hold that many lights or so large a map.
    pub fn set_lighting(&mut self, map: &Equirect, set: &LightSet) -> Result<(), RenderError> {
        self.set_prepared_lighting(PreparedLighting::new(map, set, &self.settings)?)
    }

    /// Takes another level of detail over: `set` is another fit to the environment that was given last, with as many lights as
    /// `level` says.
    ///
    /// # Errors
    /// [`RenderError::OutOfRange`] for a setting that [`RenderSettings`] does not allow, otherwise as [`Renderer::set_lighting`].
    pub fn set_level_of_detail(&mut self, level: LevelOfDetail, set: &LightSet) -> Result<(), RenderError> {
        let LevelOfDetail { shadow_resolution, shadow_sampling, .. } = level;
        let settings = self.settings.clone().with(|s| {
            s.techniques.shadow_resolution = shadow_resolution;
            s.techniques.shadow_sampling = shadow_sampling;
        });
        settings.check()?;
        let scopes = self.gpu.catch_errors();
        let ambient = self.ambient.lights(set, self.settings.lighting.ambient_cells)?;
        let Some(lit) = &self.lighting else {
            return Err(RenderError::Device("no lighting was set".to_owned()));
        };
        let lighting = lit.lighting.clone().with_lights(&self.gpu, ambient);
        let before = std::mem::replace(&mut self.settings, settings);
        if let Err(error) = self.light_up(lighting) {
            self.settings = before;
            return Err(error);
        }
        if before.techniques.shadow_sampling != shadow_sampling {
            self.target = None;
        }
        scopes.finish()
    }

    fn check_size(&self, [width, height]: [u32; 2]) -> Result<(), RenderError> {
        let largest =
            self.gpu.device.limits().max_texture_dimension_2d / self.settings.techniques.supersample;
        in_range("picture width", width, 1..=largest)?;
        in_range("picture height", height, 1..=largest)?;
        Ok(())
    }

    /// Records the rows of a band of a picture of `width` x `height` pixels, top row first.
    fn record_band(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        camera: &Camera,
        [width, height]: [u32; 2],
        band: &Band,
        clock: Clock,
    ) -> Result<FrameTimings, RenderError> {
        let rows = band.drawn.clone();
        let is_first = band.kept.start == 0;
        let gpu = &self.gpu;
        gpu.check()?;
        let size = [width, rows.len() as u32];
        if self.target.as_ref().is_none_or(|target| target.size != size) {
            self.target = Some(self.new_target(size)?);
        }
        let (Some(lit), Some(target)) = (&self.lighting, &self.target) else {
            return Err(RenderError::Device("no lighting was set".to_owned()));
        };
        let samples = self.settings.techniques.supersample;
        let sample_size = size.map(|side| side * samples);
        let matrices = CameraMatrices::new(camera, width as f32 / height as f32, self.bounds);
        let matrices = matrices.cropped(height, rows);
        let map_views = self.write_uniforms(lit, camera, &matrices, sample_size, target.gbuffer.interleave);

        let mut recorder = Recorder::new(gpu, encoder, clock);
        if is_first {
            self.passes.transform.encode(&mut recorder, &self.geometry);
        }
        recorder.end_pass("transform")?;
        self.passes.gbuffer.encode(
            &mut recorder,
            &target.gbuffer,
            &self.view_group,
            &self.geometry,
            &self.materials,
        );
        recorder.end_pass("gbuffer")?;
        let gbuffer_group = &target.gbuffer.group;
        self.passes.points.encode(&mut recorder, &target.points, &self.view_group, gbuffer_group);
        recorder.end_pass("points")?;
        lit.batches.encode(
            &mut recorder,
            (&self.passes.shadow_map, &lit.light),
            (&self.geometry, &map_views),
            &lit.frame_groups,
            (gbuffer_group, &target.points),
            is_first,
        )?;
        let (mut exposure, mut tone_mapping) =
            (self.settings.display.exposure.unwrap_or(0.0), self.settings.display.tone_mapping);
        if let Some(debug) = &self.debug {
            self.encode_debug_view(&mut recorder, debug, (lit, target, &map_views), camera, sample_size);
            recorder.end_pass("debug view")?;
            (exposure, tone_mapping) = (0.0, ToneMapping::Linear);
        } else {
            if is_first {
                self.passes.cache.encode(&mut recorder, &self.cache, &lit.environment.cache);
            }
            recorder.end_pass("radiance cache")?;
            let groups = [
                (layout::GROUP_FRAME, &lit.environment.compose),
                (layout::GROUP_SURFACE, gbuffer_group),
                (layout::GROUP_PASS, &target.points.compose_group),
            ];
            self.passes.compose.encode(&mut recorder, groups, sample_size);
            recorder.end_pass("compose")?;
        }
        self.passes.resolve.encode(&mut recorder, &target.output, samples, exposure, tone_mapping);
        recorder.end_pass("resolve")?;
        Ok(recorder.finish())
    }

    fn write_uniforms(
        &self,
        lit: &Lit,
        camera: &Camera,
        matrices: &CameraMatrices,
        [width, height]: [u32; 2],
        interleave: u32,
    ) -> Vec<Vec<MapView>> {
        let environment_from_world = Mat4::from_quat(self.world_from_environment.inverse());
        let flag = |on, flag| if on { flag } else { 0 };
        let view = layout::View {
            clip_from_world: matrices.clip_from_world,
            world_from_clip: matrices.world_from_clip,
            eye_world: matrices.eye_world,
            size: [width, height].into(),
            flags: flag(self.settings.display.background, layout::FLAG_BACKGROUND)
                | flag(self.unshadowed.spherical_harmonics, layout::FLAG_SPHERICAL_HARMONICS),
            shadow_sampling: self.settings.techniques.shadow_sampling,
            sample_extent: matrices.view_width / width as f32,
            interleave,
            residual_sh: lit.lighting.residual_sh,
            full_sh: lit.lighting.full_sh,
            environment_from_world,
        };
        self.gpu.write(&self.view, &view);
        let to_viewer = camera.world_from_camera.z_axis.truncate().normalize();
        self.cache.write(&self.gpu, to_viewer, environment_from_world);
        let offset = self.settings.techniques.normal_offset;
        let only = self.debug.as_ref().and_then(|debug| debug.only_light(lit));
        lit.batches.write_lights(&self.gpu, &lit.lighting, &self.near_lights, &self.geometry, offset, only)
    }

    fn new_target(&self, size: [u32; 2]) -> Result<Target, RenderError> {
        let gpu = &self.gpu;
        let sample_size = size.map(|side| side * self.settings.techniques.supersample);
        let usage = wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::TEXTURE_BINDING;
        let [width, height] = sample_size;
        let samples = gpu
            .texture("samples", [width, height, 1], 1, RADIANCE_FORMAT, usage)
            .create_view(&Default::default());
        Ok(Target {
            size,
            gbuffer: self.passes.gbuffer.target(gpu, sample_size, self.settings.techniques.supersample),
            points: self.passes.points.points(
                gpu,
                sample_size,
                self.settings.techniques.shadow_sampling,
                &samples,
            )?,
            output: self.passes.resolve.output(gpu, &samples, size),
        })
    }
}
