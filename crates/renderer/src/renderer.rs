use glam::Quat;

use gnomon_envmap::Equirect;
use gnomon_lights::LightSet;
use gnomon_picture::RgbImage;
use gnomon_scene::{Bounds, PlacedLight, Scene};
use gnomon_shaders::layout;

use crate::gbuffer::{GBuffer, GBufferPass};
use crate::geometry::{Geometry, TransformPass};
use crate::light_pass;
use crate::lighting::PreparedLighting;
use crate::lod::LevelOfDetail;
use crate::materials::Materials;
use crate::radiance_cache::{RadianceCache, RadianceCachePass};
use crate::recorder::PassTiming;
use crate::resolve::{Output, ResolvePass};
use crate::settings::{Chosen, RenderSettings};
use crate::shading_points::{ShadingPoints, ShadingPointsPass};
use crate::shadow::depth_maps::ShadowMapPass;
use crate::shadow::technique::SharedPasses;
use crate::{Gpu, RenderError};

mod bands;
mod debug;
mod display;
mod draw;
mod live;
mod materials;
mod state;
mod timing;

use state::{Lit, State};
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
    passes: Passes,
    geometry: Geometry,
    materials: Materials,
    bounds: Option<Bounds>,
    near_lights: Vec<PlacedLight>,
    /// Whether any material is.
    is_glossy: bool,
    world_from_environment: Quat,
    state: State,
    target: Option<Target>,
    debug: Option<debug::Debug>,
    in_flight: FramesInFlight,
    view: wgpu::Buffer,
    view_group: wgpu::BindGroup,
}

struct Passes {
    transform: TransformPass,
    gbuffer: GBufferPass,
    points: ShadingPointsPass,
    shared: SharedPasses,
    cache: RadianceCachePass,
    resolve: ResolvePass,
}

/// What depends on the picture's size.
struct Target {
    gbuffer: GBuffer,
    /// Where lights are summed.
    points: ShadingPoints,
    /// Values along a pixel's side of what is composed: 1, or the samples of a debug view.
    composed: u32,
    output: Output,
}

impl Renderer {
    /// A renderer of an empty scene without light.
    ///
    /// # Errors
    /// A setting names nothing or is out of range, or the device failed.
    pub fn new(gpu: &Gpu, settings: RenderSettings) -> Result<Self, RenderError> {
        let scopes = gpu.catch_errors();
        let chosen = Chosen::new(gpu, settings)?;
        let gbuffer = GBufferPass::new(gpu)?;
        let points = ShadingPointsPass::new(gpu, &gbuffer.view_layout, &gbuffer.read_layout)?;
        let passes = Passes {
            transform: TransformPass::new(gpu)?,
            shared: SharedPasses {
                shadow_map: ShadowMapPass::new(gpu, &gbuffer.material_layout)?,
                frame: light_pass::frame_layout(gpu),
                gbuffer: gbuffer.read_layout.clone(),
            },
            gbuffer,
            points,
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
            state: State {
                compose: passes.compose(gpu, &chosen)?,
                cache: RadianceCache::new(gpu, Vec::new(), 1, 1),
                chosen,
                lit: None,
            },
            geometry: Geometry::new(gpu, &passes.transform, &scene, None)?,
            materials: Materials::new(gpu, &passes.gbuffer.material_layout, &scene)?,
            passes,
            bounds: None,
            near_lights: Vec::new(),
            is_glossy: false,
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
        let geometry = Geometry::new(&self.gpu, &self.passes.transform, scene, Some(&self.geometry))?;
        let materials = Materials::new(&self.gpu, &self.passes.gbuffer.material_layout, scene)?;
        self.set_near_lights(scene)?;
        self.geometry = geometry;
        self.take_materials(materials);
        self.bounds = self.geometry.bounds();
        self.take_lobes(scene);
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
        self.set_prepared_lighting(PreparedLighting::new(map, set, self.settings())?)
    }

    /// Takes another level of detail over: `set` is another fit to the environment that was given last, with as many lights as
    /// `level` says.
    ///
    /// # Errors
    /// [`RenderError::Option`] for a setting that [`RenderSettings`] does not allow, otherwise as [`Renderer::set_lighting`].
    pub fn set_level_of_detail(&mut self, level: LevelOfDetail, set: &LightSet) -> Result<(), RenderError> {
        let LevelOfDetail { shadow_resolution, shadow_sampling, .. } = level;
        let techniques = &self.settings().techniques;
        let sharp = (shadow_sampling * techniques.sharp_shadow_sampling / techniques.shadow_sampling).clamp(1, 32);
        let chosen = Chosen::new(
            &self.gpu,
            self.settings().clone().with(|s| {
                s.techniques.shadow_resolution = shadow_resolution;
                s.techniques.shadow_sampling = shadow_sampling;
                s.techniques.sharp_shadow_sampling = sharp;
            }),
        )?;
        let scopes = self.gpu.catch_errors();
        let Some(lit) = &self.state.lit else {
            return Err(RenderError::Device("no lighting was set".to_owned()));
        };
        let ambient = chosen.ambient.lights(set, chosen.settings.lighting.ambient_cells)?;
        let lighting = lit.lighting.clone().with_lights(&self.gpu, ambient);
        let lit = self.lit(&chosen, (&self.state.compose, &self.state.cache), lighting, &self.near_lights)?;
        self.state.chosen = chosen;
        self.take_lit(lit);
        scopes.finish()
    }
}
