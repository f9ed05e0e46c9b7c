use gnomon_options::{Group, number, settings};
use gnomon_shaders::layout;

use super::ShadowSettings;
use super::buffered::Buffered;
use super::depth_maps::MapDepth;
use super::silhouettes::Silhouettes;
use super::technique::{FrameInputs, ShadowContext, ShadowMemory, ShadowResources, ShadowTechnique};
use crate::RenderError;
use crate::bindings::Binding;
use crate::recorder::Recorder;

static GROUP: Group =
    Group { table: "wedges", heading: "Penumbra wedges (wedges)", condition: Some(("shadows", &["wedges"])) };

settings! {
    /// Parameters of penumbra wedges.
    pub struct WedgeSettings in GROUP {
        /// Factor on the width and height of lights where they cast shadows: narrower penumbrae cost less (Arbree et al. 2005, section 5).
        light_size: f32 = 1.0, number(0.0, 1.0);
    }
}

/// Penumbra wedges (Akenine-Moeller and Assarsson 2002, 2003).
pub(super) static WEDGES: Buffered = Buffered::new(&Wedges);

struct Wedges;

impl ShadowTechnique for Wedges {
    fn name(&self) -> &'static str {
        "wedges"
    }

    fn summary(&self) -> &'static str {
        "penumbra wedges: soft shadows from the silhouettes of geometry; neither map nor grain"
    }

    fn module(&self, _: &ShadowSettings) -> &'static str {
        "shadow_wedges"
    }

    fn depth_maps(&self) -> Option<MapDepth> {
        None
    }

    fn has_sharp_maps(&self) -> bool {
        false
    }

    fn traces_rays(&self) -> bool {
        true
    }

    fn needs_edges(&self) -> bool {
        true
    }

    fn memory(&self, _: &ShadowSettings, _resolution: u32) -> ShadowMemory {
        ShadowMemory::default()
    }

    fn layers_per_light(&self, _: &ShadowSettings) -> u32 {
        0
    }

    fn resources(&self, context: &ShadowContext<'_>) -> Result<Box<dyn ShadowResources>, RenderError> {
        let gpu = context.gpu;
        let (silhouettes, edges) = Silhouettes::new(context)?;
        let read = Binding::Storage { read_only: true };
        let bindings =
            [(0, Binding::Uniform), (1, read), (2, read), (3, read), (4, read), (5, Binding::Uniform)];
        let layout = gpu.layout("wedges", wgpu::ShaderStages::COMPUTE, &bindings);
        let parameters = layout::WedgeParameters { light_size: context.settings.wedges.light_size };
        let parameters = gpu.shared_buffer("wedges", &parameters, wgpu::BufferUsages::UNIFORM);
        let buffers = [
            &parameters,
            edges.nodes,
            edges.triangles,
            &edges.scene.edges,
            &silhouettes.marks,
            &silhouettes.counts,
        ];
        let resources: Vec<_> =
            (0..).zip(buffers).map(|(number, buffer)| (number, buffer.as_entire_binding())).collect();
        let bind_group = gpu.bind_group("wedges", &layout, &resources);
        Ok(Box::new(Resources { silhouettes, layout, bind_group }))
    }
}

struct Resources {
    silhouettes: Silhouettes,
    layout: wgpu::BindGroupLayout,
    bind_group: wgpu::BindGroup,
}

impl ShadowResources for Resources {
    fn layout(&self) -> &wgpu::BindGroupLayout {
        &self.layout
    }

    fn bind_group(&self) -> &wgpu::BindGroup {
        &self.bind_group
    }

    fn prepare(&self, recorder: &mut Recorder<'_>, frame: &FrameInputs<'_>) -> Result<(), RenderError> {
        self.silhouettes.encode(recorder, frame)
    }
}
