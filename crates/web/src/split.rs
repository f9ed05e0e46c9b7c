//! The same scene without shadows, on a canvas beside.

use gnomon_renderer::Gpu;
use gnomon_studio::{Look, Stage, Studio};
use web_sys::OffscreenCanvas;

use crate::canvas::{Canvas, Device};
use crate::error::PageError;

/// Ordinary image-based lighting of what a session shows.
pub struct Split {
    canvas: Canvas,
    studio: Studio,
}

/// A look without lights: all of the environment is ambient and unshadowed.
fn without_shadows(look: &Look) -> Look {
    let mut look = look.clone();
    look.fit.method = "none".to_owned();
    (look.fit.light_count, look.fit.threshold) = (None, None);
    look.lighting.ambient = "unshadowed".to_owned();
    look.techniques.shadows = "none".to_owned();
    look
}

impl Split {
    pub fn new(device: &Device, canvas: OffscreenCanvas, of: &Studio) -> Result<Self, PageError> {
        Self::on(device, Canvas::new(device, canvas)?, of)
    }

    /// The same canvas after another scene or environment has come, or another device.
    pub fn reopened(self, device: &Device, of: &Studio) -> Result<Self, PageError> {
        Self::on(device, self.canvas.reopened(device)?, of)
    }

    fn on(device: &Device, canvas: Canvas, of: &Studio) -> Result<Self, PageError> {
        let mut stage = Stage::clone(of.stage());
        stage.set_look(without_shadows(of.look()))?;
        Ok(Self { canvas, studio: Studio::new(&device.gpu, stage)? })
    }

    /// Draws the session's picture of so many pixels over so many of the canvas.
    pub fn draw(
        &mut self,
        gpu: &Gpu,
        of: &Studio,
        (size, over): ([u32; 2], [u32; 2]),
    ) -> Result<(), PageError> {
        self.studio.set_look(without_shadows(of.look()))?;
        // The environment comes with a session of its own.
        self.studio.poll();
        self.studio.submit(size[0], size[1])?;
        self.canvas.show(gpu, self.studio.renderer(), over)
    }
}
