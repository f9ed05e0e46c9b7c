//! What a shadow technique is to the renderer: it is given a frame and tells how much of each light every shading point sees.
//!
//! Visibility of a (light, point) pair comes *inline*, from the technique's own WGSL function, or *through a buffer* that the technique
//! fills and the module `shadow_buffered` reads. Nothing here presumes depth maps: those that draw them share `depth_map.rs`.

use gnomon_shaders::layout;

use super::ShadowSettings;
use super::depth_maps::{DepthMaps, MapDepth, ShadowMapPass};
use crate::casters::DrawnCasters;
use crate::gbuffer::GBuffer;
use crate::geometry::Geometry;
use crate::materials::Materials;
use crate::ray_scene::RayScene;
use crate::recorder::Recorder;
use crate::shading_points::{PointStage, ShadingPoints};
use crate::{Gpu, RenderError};

/// A way to tell how much of a light a point sees.
pub(crate) trait ShadowTechnique: Sync {
    /// Name for people and files.
    fn name(&self) -> &'static str;
    /// One line for help texts.
    fn summary(&self) -> &'static str;
    /// WGSL module with `visibility(light, point, position_world, normal_world, n) -> f32`: of a light of the batch, at a shading point by its
    /// number, place, geometric and shading normal. `shadow_buffered` for a technique that fills a buffer.
    fn module(&self, settings: &ShadowSettings) -> &'static str;
    /// Features of the device that it needs beyond WebGPU's core.
    fn needed_features(&self) -> wgpu::Features {
        wgpu::Features::empty()
    }
    /// What the lights' depth maps hold; `None` where it needs none. Only lights with maps differ in the size of them.
    fn depth_maps(&self) -> Option<MapDepth>;
    /// Whether sharp lights have larger maps than the usual ones (`sharp_shadow_resolution`). Images that are filtered of a map take many
    /// times its memory.
    fn has_sharp_maps(&self) -> bool {
        true
    }
    /// Whether anything is hidden from light.
    fn casts_shadows(&self) -> bool {
        true
    }
    /// Whether it needs [`ShadowContext::rays`].
    fn traces_rays(&self) -> bool {
        false
    }
    /// Whether neighbouring points are given shares that differ by chance.
    fn is_grainy(&self) -> bool {
        false
    }
    /// Whether it needs the edges between the triangles that rays are traced through ([`RayScene::edges`]).
    fn needs_edges(&self) -> bool {
        false
    }
    /// Whether it always fills a buffer.
    fn fills_buffer(&self) -> bool {
        false
    }
    /// Whether grounds cast shadows of lights of which they block nothing, too.
    fn draws_grounds(&self) -> bool {
        false
    }
    /// GPU memory for what it keeps of lights with maps of a resolution.
    fn memory(&self, settings: &ShadowSettings, resolution: u32) -> ShadowMemory;
    /// Layers that one light needs in the technique's largest texture array, 0 where it has none.
    fn layers_per_light(&self, settings: &ShadowSettings) -> u32;
    /// Buffers, images and bindings for a batch of lights.
    ///
    /// # Errors
    /// [`RenderError::OutOfRange`] for a setting.
    fn resources(&self, context: &ShadowContext<'_>) -> Result<Box<dyn ShadowResources>, RenderError>;
}

/// What a technique keeps on the GPU for one batch at a time.
pub(crate) trait ShadowResources: Send {
    /// Layout of bind group 2 of the pass that sums light.
    fn layout(&self) -> &wgpu::BindGroupLayout;
    /// That bind group.
    fn bind_group(&self) -> &wgpu::BindGroup;
    /// Encodes whatever the visibility of the frame's lights needs.
    fn prepare(&self, recorder: &mut Recorder<'_>, frame: &FrameInputs<'_>) -> Result<(), RenderError>;
    /// The depth maps, to be looked at.
    fn depth_maps(&self) -> Option<&DepthMaps> {
        None
    }
}

/// Resources of which nothing is made for a frame.
pub(super) struct Bound {
    pub layout: wgpu::BindGroupLayout,
    pub bind_group: wgpu::BindGroup,
}

impl ShadowResources for Bound {
    fn layout(&self) -> &wgpu::BindGroupLayout {
        &self.layout
    }

    fn bind_group(&self) -> &wgpu::BindGroup {
        &self.bind_group
    }

    fn prepare(&self, _: &mut Recorder<'_>, _: &FrameInputs<'_>) -> Result<(), RenderError> {
        Ok(())
    }
}

/// GPU memory that a technique needs [bytes].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct ShadowMemory {
    /// For each light of a batch.
    pub per_light: u64,
    /// For each pair of a light of the batch and a shading point.
    pub per_pair: u64,
}

/// What resources are made with and for.
pub(crate) struct ShadowContext<'a> {
    pub gpu: &'a Gpu,
    pub settings: &'a ShadowSettings,
    pub shared: &'a SharedPasses,
    pub size: BatchSize,
    /// Where the technique traces rays.
    pub rays: Option<RayTargets<'a>>,
    /// Module for slot `bumps`.
    pub bumps: &'static str,
}

/// What rays are traced through, and to.
#[derive(Clone, Copy)]
pub(crate) struct RayTargets<'a> {
    pub scene: &'a RayScene,
    /// A row of points for every light of the frame, and the number of rays to it.
    pub light_points: &'a wgpu::TextureView,
}

/// The most that a batch may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct BatchSize {
    pub lights: u32,
    /// Texels along the side of a light's map.
    pub resolution: u32,
    pub points: u64,
}

/// Layouts and passes that techniques have in common.
pub(crate) struct SharedPasses {
    pub shadow_map: ShadowMapPass,
    /// Layouts of bind groups 0 (`frame.wgsl`) and 1 (`gbuffer_surface.wgsl`) of passes over shading points.
    pub frame: wgpu::BindGroupLayout,
    /// Of the view alone, where it is drawn.
    pub view: wgpu::BindGroupLayout,
    pub gbuffer: wgpu::BindGroupLayout,
}

/// A frame, for one batch of lights.
#[derive(Clone, Copy)]
pub(crate) struct FrameInputs<'a> {
    /// The scene in world space: positions, indices, boxes.
    pub geometry: &'a Geometry,
    /// Its materials.
    pub materials: &'a Materials,
    /// Bind group 0 of passes over points: view, lights, batch.
    pub frame: &'a wgpu::BindGroup,
    /// Bind group 1: what the camera sees.
    pub gbuffer: &'a wgpu::BindGroup,
    /// The same as images, and bind group 0 of passes that draw what the camera may see.
    pub seen: &'a GBuffer,
    pub view: &'a wgpu::BindGroup,
    /// Where these lights are summed.
    pub points: &'a ShadingPoints,
    /// Those of them that are lit now.
    pub stage: &'a PointStage,
    pub lights: FrameLights<'a>,
    /// Whether scene and lights are what they were in the call before, so that only what depends on view and points is to be made: more
    /// points, another band of the same picture.
    pub same_lights: bool,
}

/// The lights of a batch.
#[derive(Clone, Copy)]
pub(crate) struct FrameLights<'a> {
    pub uniforms: &'a [layout::Light],
    /// What may block each of them.
    pub casters: &'a [DrawnCasters],
    /// Bind group of the lights for passes that draw them.
    pub group: &'a wgpu::BindGroup,
}
