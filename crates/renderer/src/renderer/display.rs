//! What a window needs of a renderer.

use super::Renderer;
use crate::Gpu;

impl Renderer {
    /// The picture that was drawn last, exposed, tone-mapped and sRGB-encoded, as it lies on the GPU; `None` before the first.
    ///
    /// The view's format is `Rgba8Unorm`: sampling it gives encoded values, which is what egui wants and what a target without
    /// sRGB in its format takes as they are. An sRGB target encodes once more: decode first, as [`crate::Presenter`] does.
    /// Another picture size makes another texture. Of a picture that [`Renderer::render`] had to draw in bands it is the last band.
    pub fn display_view(&self) -> Option<wgpu::TextureView> {
        self.target.as_ref().map(|target| target.output.display.create_view(&Default::default()))
    }

    /// The device that the renderer draws with.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }
}
