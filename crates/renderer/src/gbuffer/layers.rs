use crate::Gpu;
use crate::bindings::{Binding, D2, array_view};
use crate::recorder::Recorder;
use crate::shadow::depth_maps::DEPTH_FORMAT;

/// Of a layer's opacities.
pub(super) const OPACITY_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R8Unorm;

/// Surfaces that light passes in part, the nearest ones of every sample: depth peeling (Everitt 2001) over what is opaque.
pub(crate) struct Layers {
    pub count: u32,
    /// Of each layer.
    pub(super) opacities: Vec<wgpu::TextureView>,
    /// Of all.
    pub opacity_array: wgpu::TextureView,
    /// Depth of the layer before, and of what is opaque.
    peeled: wgpu::Texture,
    opaque: wgpu::Texture,
    /// Own bind group of what draws a layer.
    pub(super) group: wgpu::BindGroup,
}

impl Layers {
    /// Layout of their bind group.
    pub fn layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
        let depth = Binding::Depth { dimension: D2 };
        gpu.layout("layers", wgpu::ShaderStages::FRAGMENT, &[(0, depth), (1, depth)])
    }

    /// So many for a picture of `size` samples; without any, textures of one texel are bound in their place.
    pub fn new(gpu: &Gpu, layout: &wgpu::BindGroupLayout, size: [u32; 2], count: u32) -> Self {
        let [width, height] = if count == 0 { [1, 1] } else { size };
        let read = wgpu::TextureUsages::TEXTURE_BINDING;
        let drawn = read | wgpu::TextureUsages::RENDER_ATTACHMENT;
        let depth = |label| {
            gpu.texture(label, [width, height, 1], 1, DEPTH_FORMAT, drawn | wgpu::TextureUsages::COPY_DST)
        };
        let [peeled, opaque] = ["peeled depth", "opaque depth"].map(depth);
        let opacities = gpu.texture("opacities", [width, height, count.max(1)], 1, OPACITY_FORMAT, drawn);
        let layers = (0..count).map(|layer| {
            opacities.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(D2),
                base_array_layer: layer,
                array_layer_count: Some(1),
                ..Default::default()
            })
        });
        let views = [&peeled, &opaque].map(|texture| texture.create_view(&Default::default()));
        let resources = views.each_ref().map(wgpu::BindingResource::TextureView);
        let resources: Vec<_> = (0..).zip(resources).collect();
        Self {
            count,
            opacities: layers.collect(),
            opacity_array: array_view(&opacities),
            group: gpu.bind_group("layers", layout, &resources),
            peeled,
            opaque,
        }
    }

    /// Nothing is peeled off yet, and `depth` is that of what is opaque.
    pub(super) fn begin(&self, recorder: &mut Recorder<'_>, depth: &wgpu::Texture) {
        copy(recorder, depth, &self.opaque);
        let peeled = self.peeled.create_view(&Default::default());
        recorder.encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("nothing peeled"),
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &peeled,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(1.0),
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
    }

    /// What is no farther than `depth` is peeled off from now on.
    pub(super) fn peel(&self, recorder: &mut Recorder<'_>, depth: &wgpu::Texture) {
        copy(recorder, depth, &self.peeled);
    }
}

fn copy(recorder: &mut Recorder<'_>, from: &wgpu::Texture, to: &wgpu::Texture) {
    recorder.encoder.copy_texture_to_texture(from.as_image_copy(), to.as_image_copy(), to.size());
}
