//! What glossy surfaces reflect of the environment, and what the scene hides of it.

use gnomon_brdf::Surface;
use gnomon_options::choices;
use gnomon_shaders::layout;

use crate::bindings::{Binding, D2_ARRAY, set_groups};
use crate::lighting::Lighting;
use crate::ray_scene::{HitSurfaces, RayScene};
use crate::recorder::Recorder;
use crate::shading_points::{PointStage, ShadingPoints};
use crate::{Gpu, RenderError, sky_samples};

choices! {
    /// How glossy surfaces learn what the scene hides of their reflections.
    pub enum GlossPath {
        /// By rays where there are shadows and the adapter has room for the scene's triangles, else by lights.
        Auto = "auto",
        /// Rays by the surface's own lobe: the share of it that is open.
        Rays = "rays",
        /// Highlights of the lights, each with its light's shadow.
        Lights = "lights",
    }
}

choices! {
    /// What glossy surfaces reflect beside the lights and the environment.
    pub enum Reflections {
        /// The scene as it is in direct light.
        Scene = "scene",
        /// Nothing: what the scene hides of lights and environment is dark, as in direct light.
        Off = "off",
    }
}

impl GlossPath {
    /// Whether surfaces like these are traced, in a frame that rays suit or not.
    pub(crate) fn traces(self, surfaces: &[Surface], suits: bool) -> bool {
        let may = match self {
            Self::Auto => suits,
            Self::Rays => true,
            Self::Lights => false,
        };
        may && surfaces.iter().any(|surface| !surface.is_matte())
    }
}

/// Traces the lobes of glossy surfaces at shading points.
pub(crate) struct GlossPass {
    /// Whether they reflect the scene.
    pub mirrors_scene: bool,
    pipeline: wgpu::ComputePipeline,
    frame: wgpu::BindGroup,
    scene: wgpu::BindGroup,
}

impl GlossPass {
    /// A pass through a scene's triangles, which reflects what the rays meet where the scene knows it; `gbuffer` and `sums` are the layouts
    /// of what it reads and writes.
    pub fn new(
        gpu: &Gpu,
        view: &wgpu::Buffer,
        lighting: &Lighting,
        scene: &RayScene,
        [gbuffer, sums]: [&wgpu::BindGroupLayout; 2],
    ) -> Result<Self, RenderError> {
        let compute = wgpu::ShaderStages::COMPUTE;
        let read = Binding::Storage { read_only: true };
        let frame_layout =
            gpu.layout("environment of gloss", compute, &[(0, Binding::Uniform), (1, Binding::LOADED)]);
        let mut bindings = vec![(1, read), (2, read)];
        if scene.hits.is_some() {
            let colors = Binding::Texture { dimension: D2_ARRAY, filterable: true };
            let (loaded, sampler) = (Binding::LOADED, Binding::Sampler);
            bindings.extend([(3, Binding::UintTexture), (4, loaded), (5, colors), (6, sampler), (7, loaded)]);
        }
        let scene_layout = gpu.layout("scene of gloss", compute, &bindings);
        let reflections = if scene.hits.is_some() { "reflections_scene" } else { "reflections_off" };
        let module = gpu.shader("gloss", &[("reflections", reflections)])?;
        let groups = [
            (layout::GROUP_FRAME, &frame_layout),
            (layout::GROUP_SURFACE, gbuffer),
            (layout::GROUP_SHADOW, &scene_layout),
            (layout::GROUP_PASS, sums),
        ];
        let environment = wgpu::BindingResource::TextureView(&lighting.background);
        let frame = [(0, view.as_entire_binding()), (1, environment)];
        let mut bound = vec![(1, scene.nodes.as_entire_binding()), (2, scene.triangles.as_entire_binding())];
        let sky = scene.hits.as_ref().map(|_| sky_samples::upload(gpu, &lighting.sky_samples()));
        if let (Some(sky), Some(HitSurfaces { triangles, materials })) = (&sky, &scene.hits) {
            let texture = wgpu::BindingResource::TextureView;
            bound.extend([
                (3, texture(triangles)),
                (4, texture(&materials.table)),
                (5, texture(&materials.colors)),
            ]);
            bound.extend([(6, wgpu::BindingResource::Sampler(&materials.sampler)), (7, texture(sky))]);
        }
        Ok(Self {
            mirrors_scene: scene.hits.is_some(),
            pipeline: gpu.compute_pipeline(&module, "gloss", &groups),
            frame: gpu.bind_group("environment of gloss", &frame_layout, &frame),
            scene: gpu.bind_group("scene of gloss", &scene_layout, &bound),
        })
    }

    /// The points of a stage.
    pub fn encode(
        &self,
        recorder: &mut Recorder<'_>,
        gbuffer: &wgpu::BindGroup,
        points: &ShadingPoints,
        stage: &PointStage,
    ) {
        let mut pass = recorder.encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&self.pipeline);
        let groups = [
            (layout::GROUP_FRAME, &self.frame),
            (layout::GROUP_SURFACE, gbuffer),
            (layout::GROUP_SHADOW, &self.scene),
            (layout::GROUP_PASS, &stage.light_group),
        ];
        set_groups(&mut pass, &groups);
        pass.dispatch_workgroups_indirect(&points.work, stage.dispatch_offset);
    }
}
