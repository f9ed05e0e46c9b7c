//! What the middle of the window shows: the GPU's picture, the reference, or their difference.

use std::time::{Duration, Instant};

use eframe::egui::{ColorImage, Context, TextureHandle, TextureId, TextureOptions};
use eframe::egui_wgpu::RenderState;
use gnomon_picture::RgbImage;
use gnomon_picture::ldr::srgb8;
use gnomon_picture::tonemap::tone_mapped;
use gnomon_renderer::{PassTiming, wgpu};
use gnomon_studio::{Pace, SampledError, Studio, StudioError};

/// How long a picture has stood still before it is checked.
const STANDS_STILL: Duration = Duration::from_millis(500);

/// Which picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Shown {
    /// The GPU's.
    #[default]
    Gpu,
    /// The ray-traced reference, as far as it has come.
    Reference,
    /// The GPU's less the reference.
    Difference,
}

impl Shown {
    /// All of them, with names for people.
    pub const ALL: [(Self, &'static str); 3] =
        [(Self::Gpu, "GPU"), (Self::Reference, "reference"), (Self::Difference, "difference")];

    /// The one after this.
    pub fn next(self) -> Self {
        match self {
            Self::Gpu => Self::Reference,
            Self::Reference => Self::Difference,
            Self::Difference => Self::Gpu,
        }
    }
}

/// What is known of the reference.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Truth {
    /// So far.
    pub samples_per_pixel: u32,
    /// Of the GPU's picture against it, relative RMSE.
    pub error: f64,
    /// Its own relative noise, contained in the error.
    pub noise: f64,
}

/// A debug view, and the light that it is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DebugChoice {
    /// Place in [`gnomon_renderer::debug_view::DEBUG_VIEWS`].
    pub view: usize,
    /// From 0.
    pub light: usize,
}

/// The pictures, and what they took.
#[derive(Default)]
pub struct Picture {
    /// Which one is wanted.
    pub shown: Shown,
    /// In place of the GPU's picture.
    pub debug: Option<DebugChoice>,
    /// The reference, where one is traced.
    pub truth: Option<Truth>,
    /// How far the GPU's picture is from the truth, once it has stood still for a while.
    pub checked: Option<SampledError>,
    /// Time of a frame on the GPU [ms].
    pub frame_ms: f64,
    /// Times of its passes, where they are asked for.
    pub passes: Vec<PassTiming>,
    stale: bool,
    /// When the GPU's picture was drawn, where it may still be checked.
    drawn: Option<Instant>,
    size: [u32; 2],
    divisor: u32,
    debug_in_force: Option<DebugChoice>,
    texture: Option<TextureId>,
    /// The GPU's picture at `size`, read back.
    radiance: Option<RgbImage>,
    traced: Option<TextureHandle>,
    /// What `traced` was made of.
    traced_from: Option<(Shown, u32, [u32; 2])>,
}

impl Picture {
    /// The GPU's picture is out of date.
    pub fn touch(&mut self) {
        self.stale = true;
    }

    /// Whether the GPU's picture is out of date.
    pub fn is_stale(&self) -> bool {
        self.stale
    }

    /// Nothing is drawn yet, as with another device.
    pub fn reset(&mut self) {
        let Self { shown, debug, .. } = *self;
        *self = Self { shown, debug, stale: true, ..Self::default() };
    }

    /// Draws the GPU's picture where it is out of date, of so many pixels: those of the window over `divisor` a side.
    ///
    /// # Errors
    /// As [`Studio::submit`].
    pub fn draw(
        &mut self,
        studio: &mut Studio,
        state: &RenderState,
        (size, divisor): ([u32; 2], u32),
        pace: &mut Pace,
    ) -> Result<(), StudioError> {
        let debug = self.debug.filter(|_| self.shown == Shown::Gpu);
        if debug != self.debug_in_force {
            let choice = debug.unwrap_or(DebugChoice { view: 0, light: 0 });
            let view = gnomon_renderer::debug_view::DEBUG_VIEWS.get(choice.view);
            studio.renderer().set_debug_view(view.map_or("final", |view| view.name), choice.light)?;
            self.debug_in_force = debug;
            self.stale = true;
        }
        if !self.stale && self.size == size {
            return Ok(());
        }
        // A picture that cannot be drawn is not tried again until something changes.
        (self.stale, self.size, self.divisor, self.radiance) = (false, size, divisor, None);
        self.drawn = None;
        // What was compared with the picture before is no longer true.
        (self.truth, self.traced_from, self.checked) = (None, None, None);
        studio.stop_checking();
        let began = Instant::now();
        studio.submit(size[0], size[1])?;
        if !studio.renderer().times_come_late() {
            studio.renderer().wait().map_err(StudioError::from)?;
            self.frame_ms = began.elapsed().as_secs_f64() * 1e3;
            pace.drawn(divisor, self.frame_ms);
        }
        if let Some(view) = studio.renderer().display_view() {
            self.show(state, &view);
        }
        self.drawn = Some(Instant::now());
        Ok(())
    }

    /// Takes in the times of frames that were drawn some while ago.
    pub fn take_times(&mut self, studio: &mut Studio, pace: &mut Pace) {
        for frame in studio.take_times() {
            if studio.renderer().times_come_late() {
                self.frame_ms = frame.milliseconds();
                // Of a picture at another size nothing is learnt.
                if frame.size == self.size {
                    pace.drawn(self.divisor, self.frame_ms);
                }
            }
            self.passes = frame.passes;
        }
    }

    /// Egui samples encoded values, which is what the view gives.
    fn show(&mut self, state: &RenderState, view: &wgpu::TextureView) {
        let mut renderer = state.renderer.write();
        let filter = wgpu::FilterMode::Linear;
        match self.texture {
            Some(id) => renderer.update_egui_texture_from_wgpu_texture(&state.device, view, filter, id),
            None => self.texture = Some(renderer.register_native_texture(&state.device, view, filter)),
        }
    }

    /// Has the GPU's picture checked in the background once it has stood still for a moment.
    ///
    /// # Errors
    /// As [`Studio::check`].
    pub fn check(&mut self, studio: &mut Studio, ctx: &Context) -> Result<(), StudioError> {
        let Some(drawn) = self.drawn.filter(|_| !self.is_debug_view()) else { return Ok(()) };
        let left = STANDS_STILL.saturating_sub(drawn.elapsed());
        if left.is_zero() {
            // Neither what is known nor what cannot be found out is asked for again.
            let found = studio.check(self.size[0], self.size[1]);
            self.drawn = self.drawn.filter(|_| matches!(found, Ok(None)));
            self.checked = found?;
        }
        if self.drawn.is_some() {
            ctx.request_repaint_after(left.max(Duration::from_millis(100)));
        }
        Ok(())
    }

    /// Goes on with the reference, and makes a texture of what there is of it.
    ///
    /// # Errors
    /// As [`Studio::converge`], [`Studio::frame`].
    pub fn trace(&mut self, studio: &mut Studio, ctx: &Context) -> Result<(), StudioError> {
        let size = self.size;
        studio.converge(size[0], size[1])?;
        let Some(reference) = studio.reference()? else {
            (self.truth, self.traced_from) = (None, None);
            return Ok(());
        };
        let from = (self.shown, reference.samples_per_pixel, size);
        if self.traced_from == Some(from) {
            return Ok(());
        }
        if self.radiance.is_none() {
            self.radiance = Some(studio.frame(size[0], size[1])?.radiance);
        }
        let Some(radiance) = &self.radiance else { return Ok(()) };
        self.truth = Some(Truth {
            samples_per_pixel: reference.samples_per_pixel,
            error: reference.relative_rmse(radiance)?,
            noise: reference.noise,
        });
        let image = match self.shown {
            Shown::Difference => color_image(&reference.difference(radiance)?),
            _ => {
                let rule = studio.look().display.tone_mapping;
                color_image(&tone_mapped(&reference.mean, rule, studio.stage().exposure()))
            }
        };
        match &mut self.traced {
            Some(texture) => texture.set(image, TextureOptions::LINEAR),
            None => self.traced = Some(ctx.load_texture("reference", image, TextureOptions::LINEAR)),
        }
        self.traced_from = Some(from);
        Ok(())
    }

    /// No reference is wanted.
    pub fn forget_reference(&mut self, studio: &mut Studio) {
        studio.stop_converging();
        (self.truth, self.traced, self.traced_from) = (None, None, None);
    }

    /// What to show; the GPU's picture until there is a reference.
    pub fn texture(&self) -> Option<TextureId> {
        match (self.shown, &self.traced, self.traced_from) {
            (Shown::Reference | Shown::Difference, Some(traced), Some(_)) => Some(traced.id()),
            _ => self.texture,
        }
    }

    /// Whether the GPU's picture shows values in place of light.
    pub fn is_debug_view(&self) -> bool {
        self.debug_in_force.is_some()
    }

    /// Pixels of the picture that was drawn last.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }
}

/// Display-linear values as egui takes them.
fn color_image(picture: &RgbImage) -> ColorImage {
    ColorImage::from_rgb([picture.width() as usize, picture.height() as usize], &srgb8(picture))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_key_goes_through_all_pictures() {
        let mut shown = Shown::Gpu;
        for (expected, _) in Shown::ALL {
            assert_eq!(shown, expected);
            shown = shown.next();
        }
        assert_eq!(shown, Shown::Gpu);
    }

    #[test]
    fn values_of_any_kind_become_colours() {
        let values = [0.0, 1.0, 0.5, -1.0, f32::NAN, f32::INFINITY];
        let picture = RgbImage::from_fn(6, 1, |x, _| glam::Vec3::splat(values[x as usize]));
        let image = color_image(&picture);
        assert_eq!(image.size, [6, 1]);
        assert_eq!((image.pixels[0].r(), image.pixels[1].r(), image.pixels[2].r()), (0, 255, 188));
        assert_eq!((image.pixels[3].r(), image.pixels[5].r()), (0, 255));
    }
}
