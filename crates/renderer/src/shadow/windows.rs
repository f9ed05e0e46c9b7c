//! Techniques that look at every texel of a depth map that may block a light, in a window that a min/max pyramid narrows.

use gnomon_options::{Group, number, settings, whole};
use gnomon_shaders::layout;

use super::ShadowSettings;
use super::depth_map::{MapFilter, MapShadows};
use super::depth_maps::{DepthMaps, MapDepth};
use super::min_max::MinMax;
use super::technique::{ShadowContext, ShadowMemory, ShadowResources, ShadowTechnique};
use crate::bindings::{Binding, D2_ARRAY};
use crate::recorder::Recorder;
use crate::{Gpu, RenderError};

static GROUP: Group = Group {
    table: "windows",
    heading: "Texels over the light (backprojection, bitmask)",
    condition: Some(("shadows", &["backprojection", "bitmask"])),
};

settings! {
    /// Parameters of backprojection and bitmask soft shadows.
    pub struct WindowSettings in GROUP {
        /// Texels along a side of the window that are looked at; in a larger window every second, third or so.
        texels: u32 = 16, whole(1, 256);
        /// Factor on the offset along the normal.
        normal_offset_scale: f32 = 0.35, number(0.0, 10.0);
        /// Distance towards the light by which a receiver is moved, as a share of the depth range.
        depth_bias: f32 = 0.001, number(0.0, 1.0);
    }
}

/// Backprojection (Guennebaud, Barthe and Paulin 2006).
pub(super) static BACKPROJECTION: Windows = Windows {
    name: "backprojection",
    summary: "every texel of the depth map as a box before the light, areas added (Guennebaud et al. 2006)",
    module: "shadow_backprojection",
};

/// Bitmask soft shadows (Schwarz and Stamminger 2007).
pub(super) static BITMASK: Windows = Windows {
    name: "bitmask",
    summary: "the same, with 64 points of the light, each covered or not (Schwarz and Stamminger 2007)",
    module: "shadow_bitmask",
};

/// Such a technique.
pub(super) struct Windows {
    name: &'static str,
    summary: &'static str,
    module: &'static str,
}

impl ShadowTechnique for Windows {
    fn name(&self) -> &'static str {
        self.name
    }

    fn summary(&self) -> &'static str {
        self.summary
    }

    fn module(&self, _: &ShadowSettings) -> &'static str {
        self.module
    }

    fn depth_maps(&self) -> Option<MapDepth> {
        Some(MapDepth::Linear)
    }

    fn memory(&self, _: &ShadowSettings, resolution: u32) -> ShadowMemory {
        let bytes = DepthMaps::bytes_per_light(resolution) + MinMax::bytes_per_light(resolution);
        ShadowMemory { per_light: bytes, per_pair: 0 }
    }

    fn layers_per_light(&self, _: &ShadowSettings) -> u32 {
        1
    }

    fn resources(&self, context: &ShadowContext<'_>) -> Result<Box<dyn ShadowResources>, RenderError> {
        MapShadows::boxed(context, MapDepth::Linear, |maps| {
            Ranges::new(context.gpu, &context.settings.windows, maps)
        })
    }
}

/// The maps' pyramid.
struct Ranges {
    pyramid: MinMax,
    layout: wgpu::BindGroupLayout,
    bind_group: wgpu::BindGroup,
}

impl Ranges {
    fn new(gpu: &Gpu, settings: &WindowSettings, maps: &DepthMaps) -> Result<Self, RenderError> {
        let &WindowSettings { texels, normal_offset_scale, depth_bias } = settings;
        let parameters = layout::WindowParameters { texels, normal_offset_scale, depth_bias };
        let parameters = gpu.shared_buffer("windows", &parameters, wgpu::BufferUsages::UNIFORM);
        let pyramid = MinMax::new(gpu, maps)?;
        let bindings = [
            (0, Binding::Uniform),
            (1, Binding::Depth { dimension: D2_ARRAY }),
            (2, Binding::Texture { dimension: D2_ARRAY, filterable: false }),
        ];
        let layout = gpu.layout("windows", wgpu::ShaderStages::COMPUTE, &bindings);
        let view = wgpu::BindingResource::TextureView;
        let resources =
            [(0, parameters.as_entire_binding()), (1, view(&maps.array)), (2, view(&pyramid.view))];
        let bind_group = gpu.bind_group("windows", &layout, &resources);
        Ok(Self { pyramid, layout, bind_group })
    }
}

impl MapFilter for Ranges {
    fn layout(&self) -> &wgpu::BindGroupLayout {
        &self.layout
    }

    fn bind_group(&self) -> &wgpu::BindGroup {
        &self.bind_group
    }

    fn encode(&self, recorder: &mut Recorder<'_>, light_count: u32) {
        let mut pass = recorder.encoder.begin_compute_pass(&Default::default());
        self.pyramid.encode(&mut pass, light_count);
    }
}
