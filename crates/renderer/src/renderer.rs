use std::sync::Arc;

use glam::Quat;
use gnomon_brdf::Surface;
use gnomon_envmap::Grade;
use gnomon_picture::RgbImage;
use gnomon_scene::{PlacedFade, PlacedLight, Scene};
use gnomon_shaders::layout;

use crate::bumps::{MaterialHeights, Relief, ReliefPass};
use crate::compose::Composed;
use crate::cryptomatte::Labels;
use crate::gbuffer::{GBuffer, GBufferPass};
use crate::geometry::{Geometry, TransformPass};
use crate::light_pass;
use crate::materials::Materials;
use crate::radiance_cache::{RadianceCache, RadianceCachePass};
use crate::ray_scene::{RayScene, RefitPass};
use crate::recorder::PassTiming;
use crate::resolve::{Output, ResolvePass};
use crate::seen::{SeenPass, SeenTarget};
use crate::settings::{Chosen, RenderSettings};
use crate::shading_points::{ShadingPoints, ShadingPointsPass};
use crate::shadow::depth_maps::ShadowMapPass;
use crate::shadow::technique::SharedPasses;
use crate::{Gpu, RenderError};

mod bands;
mod change;
mod debug;
mod display;
mod draw;
mod layers;
mod set;
mod state;
mod surfaces;
mod timing;

pub use change::{Change, LightingChange, SceneChange};
use state::{Lit, State};
use timing::FramesInFlight;
pub use timing::TimedFrame;

/// One finished picture.
pub struct Frame {
    /// Linear radiance, box-filtered.
    pub radiance: RgbImage,
    /// How much each pixel hides of what is behind the scene, row by row from the top: 1 where it shows the scene alone, less at its edges, and
    /// where it shows a catcher the share of light that shadows take. `radiance` is premultiplied by it where nothing is behind the scene.
    pub alpha: Vec<f32>,
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
    /// Where shadow technique or gloss trace rays.
    ray_scene: Option<RayScene>,
    /// Of changes, until they are asked for.
    warnings: Vec<String>,
    near_lights: Vec<PlacedLight>,
    ground: Option<PlacedFade>,
    /// Of every material.
    surfaces: Vec<Surface>,
    /// Of the materials that have them.
    heights: Vec<MaterialHeights>,
    /// What is prepared of them.
    relief: Option<Relief>,
    world_from_environment: Quat,
    grade: Grade,
    state: State,
    target: Option<Target>,
    /// Slices that the view of the last frame had.
    slice_count: usize,
    debug: Option<debug::Debug>,
    /// Made for the first layers.
    seen: Option<SeenPass>,
    /// Names of the scene's nodes and materials.
    labels: Arc<Labels>,
    /// Of each light by its place, which layer it is part of.
    light_groups: Vec<u32>,
    /// Whether light is summed in floats.
    has_wide_sums: bool,
    /// The frame before, for motion.
    before: Option<layers::Before>,
    in_flight: FramesInFlight,
    view: wgpu::Buffer,
    view_group: wgpu::BindGroup,
}

struct Passes {
    transform: TransformPass,
    gbuffer: GBufferPass,
    relief: ReliefPass,
    shared: SharedPasses,
    of_models: ModelPasses,
    refit: RefitPass,
    resolve: ResolvePass,
}

/// Those whose shaders know of reflectance models.
struct ModelPasses {
    points: ShadingPointsPass,
    cache: RadianceCachePass,
}

impl ModelPasses {
    fn new(gpu: &Gpu, gbuffer: &GBufferPass) -> Result<Self, RenderError> {
        let points = ShadingPointsPass::new(gpu, &gbuffer.view_layout, &gbuffer.read_layout)?;
        Ok(Self { points, cache: RadianceCachePass::new(gpu)? })
    }
}

/// What depends on the picture's size.
struct Target {
    gbuffer: GBuffer,
    /// Where lights are summed.
    points: ShadingPoints,
    composed: Composed,
    output: Output,
    seen: Option<SeenTarget>,
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
        let of_models = ModelPasses::new(gpu, &gbuffer)?;
        let passes = Passes {
            transform: TransformPass::new(gpu)?,
            shared: SharedPasses {
                shadow_map: ShadowMapPass::new(gpu, &gbuffer.material_layout)?,
                frame: light_pass::frame_layout(gpu),
                view: gbuffer.view_layout.clone(),
                gbuffer: gbuffer.read_layout.clone(),
            },
            relief: ReliefPass::new(gpu, [&gbuffer.view_layout, &gbuffer.material_layout])?,
            gbuffer,
            of_models,
            refit: RefitPass::new(gpu)?,
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
            materials: Materials::new(gpu, &passes.gbuffer.material_layout, &scene, None)?,
            passes,
            ray_scene: None,
            warnings: Vec::new(),
            near_lights: Vec::new(),
            ground: None,
            surfaces: Vec::new(),
            heights: Vec::new(),
            relief: None,
            world_from_environment: Quat::IDENTITY,
            grade: Grade::NONE,
            target: None,
            slice_count: 1,
            debug: None,
            seen: None,
            labels: Arc::default(),
            light_groups: Vec::new(),
            has_wide_sums: false,
            before: None,
            in_flight: FramesInFlight::default(),
            view,
            view_group,
        };
        scopes.finish()?;
        Ok(renderer)
    }
}
