use gnomon_options::{Group, settings, whole};

use super::ShadowSettings;
use super::depth_maps::MapDepth;
use super::technique::{Bound, ShadowContext, ShadowMemory, ShadowResources, ShadowTechnique};
use crate::RenderError;
use crate::bindings::Binding;

static GROUP: Group =
    Group { table: "rays", heading: "Shadow rays (rays)", condition: Some(("shadows", &["auto", "rays"])) };

settings! {
    /// Parameters of shadow rays.
    pub struct RaySettings in GROUP {
        /// Rays to a light from every point; up to four times as many to one that gives more light than the others and to the scene's own, fewer to one that gives
        /// less.
        samples: u32 = 16, whole(1, 64);
    }
}

/// Rays through the scene's triangles.
pub(super) struct Rays;

impl ShadowTechnique for Rays {
    fn name(&self) -> &'static str {
        "rays"
    }

    fn summary(&self) -> &'static str {
        "shadow rays through the scene's triangles: no map and no bias, at more cost"
    }

    fn module(&self, _: &ShadowSettings) -> &'static str {
        "shadow_rays"
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

    fn is_grainy(&self) -> bool {
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
        let read = Binding::Storage { read_only: true };
        let layout = gpu.layout(
            "shadow rays",
            wgpu::ShaderStages::COMPUTE,
            &[(1, read), (2, read), (3, Binding::LOADED)],
        );
        let Some(targets) = &context.rays else {
            return Err(RenderError::Device("there is no scene for rays".to_owned()));
        };
        let resources = [
            (1, targets.scene.nodes.as_entire_binding()),
            (2, targets.scene.triangles.as_entire_binding()),
            (3, wgpu::BindingResource::TextureView(targets.light_points)),
        ];
        let bind_group = gpu.bind_group("shadow rays", &layout, &resources);
        Ok(Box::new(Bound { layout, bind_group }))
    }
}
