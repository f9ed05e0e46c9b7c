//! Pictures that are too large for one buffer of light sums, in bands of rows.

use std::ops::Range;

use bytemuck::pod_collect_to_vec;
use gnomon_picture::RgbImage;
use gnomon_scene::Camera;

use super::{Frame, Renderer};
use crate::gpu::TextureReadBack;
use crate::recorder::{Clock, FrameTimings, add_times, new_encoder};
use crate::settings::TechniqueSettings;
use crate::{Gpu, RenderError, shading_points};

/// Rows of a picture that are drawn at once.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Band {
    /// With the neighbours that samples near the edge look at.
    pub(super) drawn: Range<u32>,
    /// Of these: the part that becomes the picture's.
    pub(super) kept: Range<u32>,
}

impl Band {
    fn whole(height: u32) -> Self {
        Self { drawn: 0..height, kept: 0..height }
    }
}

/// A picture of `height` rows in bands of `kept` rows that overlap by `overlap`, both whole multiples of a tile.
fn cut(height: u32, kept: u32, overlap: u32) -> Vec<Band> {
    let starts = (0..height).step_by(kept.max(1) as usize);
    starts
        .map(|start| {
            let end = (start + kept).min(height);
            let drawn = start.saturating_sub(overlap)..(end + overlap).min(height);
            Band { drawn, kept: start..end }
        })
        .collect()
}

impl Renderer {
    /// How a picture has to be cut: one band where the adapter allows buffers for all of its samples. Debug views are never cut.
    fn bands(&self, [width, height]: [u32; 2]) -> Vec<Band> {
        let TechniqueSettings { supersample: samples, shadow_sampling: sampling, .. } =
            self.settings.techniques;
        let fits = |rows: u32| {
            let sums = shading_points::sum_bytes([width * samples, rows * samples], sampling);
            sums <= self.gpu.device.limits().max_storage_buffer_binding_size
        };
        // Samples look at the tiles around their own. So many pixels hold a whole number of tiles.
        let overlap = (2 * sampling).div_ceil(samples).next_multiple_of(sampling);
        let tiles = (1..=height.div_ceil(sampling)).rev();
        let most = || tiles.map(|tiles| tiles * sampling).find(|rows| fits(rows + 2 * overlap));
        let whole = Band::whole(height);
        if self.debug.is_some() || fits(height) {
            return vec![whole];
        }
        // Where not even one row of tiles fits, the error is that of the whole picture.
        most().map_or(vec![whole], |kept| cut(height, kept, overlap))
    }

    /// Draws one frame of `width` x `height` pixels and waits for it: [`Renderer::render_async`], waited for.
    ///
    /// # Errors
    /// As [`Renderer::render_async`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn render(&mut self, camera: &Camera, width: u32, height: u32) -> Result<Frame, RenderError> {
        let frame = self.render_async(camera, width, height);
        self.gpu.wait_for(frame)
    }

    /// Draws one frame of `width` x `height` pixels and reads it back. When this returns everything is recorded and submitted, and the
    /// renderer is free for the next frame; the future is ready once the GPU has drawn it and the device was polled after that
    /// ([`wgpu::Device::poll`], [`wgpu::Queue::submit`]; browsers do so by themselves).
    ///
    /// Where the adapter allows no buffer for the light of all its samples the picture is drawn in bands of rows;
    /// [`Renderer::display_view`] then shows the last one.
    ///
    /// # Errors
    /// [`RenderError::OutOfRange`] for an empty or too large picture, [`RenderError::Device`] where the device failed,
    /// [`RenderError::NotFinite`] where it drew what is no picture.
    pub fn render_async(
        &mut self,
        camera: &Camera,
        width: u32,
        height: u32,
    ) -> impl Future<Output = Result<Frame, RenderError>> + Send + use<> {
        let size = [width, height];
        let begun = self.check_size(size).and_then(|()| self.begin_bands(camera, size, &self.bands(size)));
        async move { begun?.frame().await }
    }

    /// Submits every band with its read-back: each is copied before the next one is drawn in its place.
    fn begin_bands(
        &mut self,
        camera: &Camera,
        size: [u32; 2],
        bands: &[Band],
    ) -> Result<BandsInFlight, RenderError> {
        let gpu = self.gpu.clone();
        let mut in_flight = BandsInFlight { gpu: gpu.clone(), size, bands: Vec::new() };
        for band in bands {
            let scopes = gpu.catch_errors();
            self.judge_clocks(camera, size, band)?;
            let mut encoder = new_encoder(&gpu);
            let timings = self.record_band(&mut encoder, camera, size, band, self.clock())?;
            let Some(target) = &self.target else {
                return Err(RenderError::Device("no frame was drawn".to_owned()));
            };
            let mut read = |texture, bytes| TextureReadBack::new(&gpu, &mut encoder, texture, bytes);
            let (radiance, display) = (read(&target.output.radiance, 16), read(&target.output.display, 4));
            in_flight.bands.push(BandInFlight { band: band.clone(), radiance, display, timings });
            gpu.queue.submit([encoder.finish()]);
            scopes.finish()?;
        }
        Ok(in_flight)
    }

    /// Draws one frame without reading it back, in bands as [`Renderer::render`] does, and waits until the device is idle: what a
    /// benchmark times.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn draw(
        &mut self,
        camera: &Camera,
        width: u32,
        height: u32,
    ) -> Result<Vec<crate::PassTiming>, RenderError> {
        let size = [width, height];
        self.check_size(size)?;
        let mut times = Vec::new();
        for band in self.bands(size) {
            let timings = self.submit_band(camera, size, &band, self.settings.measure.profile)?;
            self.gpu.wait()?;
            add_times(&mut times, self.gpu.wait_for(timings.passes())?);
        }
        Ok(times)
    }

    /// Draws one frame without waiting for it: for a window, which shows [`Renderer::display_view`]. Gives the frame's number, under
    /// which [`Renderer::take_times`] tells its times later where they are asked for ([`crate::MeasureSettings::profile`]).
    ///
    /// # Errors
    /// As [`Renderer::render`], and [`RenderError::OverLimit`] for a picture that would have to be drawn in bands; faults of the device
    /// may come only with a later call.
    pub fn submit(&mut self, camera: &Camera, width: u32, height: u32) -> Result<u64, RenderError> {
        let size = [width, height];
        self.check_size(size)?;
        let is_timed = self.settings.measure.profile && self.in_flight.has_room();
        let timings = self.submit_band(camera, size, &Band::whole(height), is_timed)?;
        Ok(self.in_flight.add(is_timed.then_some(timings)))
    }

    /// Records one frame into an encoder of the embedding program, which submits it: for a program that draws everything in one
    /// submission. What changes from frame to frame is uploaded through the device's queue at once, so that an encoder can hold one
    /// frame of a renderer, and it is to be submitted before the renderer draws another. Passes are not timed.
    ///
    /// # Errors
    /// As [`Renderer::submit`].
    pub fn record(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        camera: &Camera,
        width: u32,
        height: u32,
    ) -> Result<(), RenderError> {
        let size = [width, height];
        self.check_size(size)?;
        let scopes = self.gpu.catch_errors();
        self.record_band(encoder, camera, size, &Band::whole(height), Clock::Off)?;
        scopes.finish()
    }

    fn submit_band(
        &mut self,
        camera: &Camera,
        size: [u32; 2],
        band: &Band,
        is_timed: bool,
    ) -> Result<FrameTimings, RenderError> {
        let scopes = self.gpu.catch_errors();
        self.judge_clocks(camera, size, band)?;
        let clock = if is_timed { self.clock() } else { Clock::Off };
        let mut encoder = new_encoder(&self.gpu);
        let timings = self.record_band(&mut encoder, camera, size, band, clock)?;
        self.gpu.queue.submit([encoder.finish()]);
        scopes.finish()?;
        Ok(timings)
    }

    /// Waits until everything that was submitted is drawn.
    ///
    /// # Errors
    /// [`RenderError::Device`] where the device failed.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn wait(&self) -> Result<(), RenderError> {
        self.gpu.wait()
    }
}

/// A picture that is being drawn and read back.
struct BandsInFlight {
    gpu: Gpu,
    size: [u32; 2],
    bands: Vec<BandInFlight>,
}

struct BandInFlight {
    band: Band,
    radiance: TextureReadBack,
    display: TextureReadBack,
    timings: FrameTimings,
}

impl BandsInFlight {
    async fn frame(self) -> Result<Frame, RenderError> {
        let Self { gpu, size: [width, height], bands } = self;
        let (mut radiance, mut display, mut timings) = (Vec::new(), Vec::new(), Vec::new());
        for BandInFlight { band, radiance: texels, display: bytes, timings: of_band } in bands {
            let texels: Vec<[f32; 4]> = pod_collect_to_vec(&texels.texels().await?);
            let bytes: Vec<[u8; 4]> = pod_collect_to_vec(&bytes.texels().await?);
            let before = ((band.kept.start - band.drawn.start) * width) as usize;
            let count = (band.kept.len() as u32 * width) as usize;
            let kept = texels.iter().skip(before).take(count);
            radiance.extend(kept.map(|&[r, g, b, _]| glam::Vec3::new(r, g, b)));
            display.extend(bytes.into_iter().skip(before).take(count));
            add_times(&mut timings, of_band.passes().await?);
        }
        gpu.check()?;
        let pixels = radiance.iter().filter(|radiance| !radiance.is_finite()).count();
        if pixels > 0 {
            return Err(RenderError::NotFinite { pixels, adapter: gpu.adapter().name.clone() });
        }
        let radiance = RgbImage::from_texels(width, height, radiance)
            .ok_or_else(|| RenderError::Device("the picture read back has another size".to_owned()))?;
        Ok(Frame { radiance, display, timings })
    }
}

#[cfg(test)]
mod tests {
    use gnomon_lights::fit::{FitOptions, by_name};
    use gnomon_scene::builtin;

    use super::*;
    use crate::{GpuOptions, RenderSettings};

    #[test]
    fn bands_keep_every_row_once_and_overlap() {
        for (height, kept, overlap) in [(100, 32, 4), (96, 32, 8), (5, 32, 4), (33, 1, 2)] {
            let bands = cut(height, kept, overlap);
            let rows: Vec<u32> = bands.iter().flat_map(|band| band.kept.clone()).collect();
            assert_eq!(rows, (0..height).collect::<Vec<_>>());
            for Band { drawn, kept } in &bands {
                assert!(drawn.start == 0 || drawn.start + overlap == kept.start);
                assert!(drawn.end == height || drawn.end == kept.end + overlap);
            }
        }
    }

    #[test]
    fn a_picture_in_bands_is_the_whole_picture() {
        let Ok(gpu) = Gpu::new(&GpuOptions::default()) else {
            gnomon_testing::skip("no adapter");
            return;
        };
        let scene = builtin::by_name("three-boxes").unwrap();
        let map = gnomon_envmap::builtin::sized("room", 128, 64).unwrap();
        let options = FitOptions { light_count: Some(8), ..FitOptions::default() };
        let lights = by_name("partition", &options).unwrap().fit(&map).unwrap();
        // With 1 MiB for maps, batches of lights take turns.
        for (sampling, shadows, memory) in [(1, "pcss", 64), (2, "convolution", 64), (4, "pcss", 1)] {
            let settings = RenderSettings::default().with(|s| {
                s.techniques.shadow_sampling = sampling;
                s.techniques.shadows = shadows.to_owned();
                s.techniques.shadow_memory = memory;
                s.techniques.shadow_sizing = crate::ShadowSizing::Uniform;
            });
            let mut renderer = Renderer::new(&gpu, settings).unwrap();
            renderer.set_scene(&scene).unwrap();
            renderer.set_lighting(&map, &lights).unwrap();
            assert_eq!(renderer.lighting.as_ref().unwrap().batches.len() > 1, memory == 1);
            let size = [64, 50];
            let whole = renderer.render(&scene.cameras[0], size[0], size[1]).unwrap();
            let mut differences = |overlap: u32| {
                let bands = renderer.begin_bands(&scene.cameras[0], size, &cut(50, 12, overlap)).unwrap();
                let banded = gpu.wait_for(bands.frame()).unwrap();
                assert_eq!(banded.display.len(), whole.display.len());
                let pairs = whole.radiance.texels().iter().zip(banded.radiance.texels());
                // Directions are rounded a little differently, which bright places of the environment show.
                let differs = |(a, b): &(&glam::Vec3, &glam::Vec3)| {
                    (**a - **b).abs().max_element() > 2e-3 * a.max_element().max(1.0)
                };
                pairs.filter(differs).count()
            };
            // An edge may fall on the other side of a sample's centre.
            let found = differences(4);
            assert!(found <= 4, "{sampling}: {found}");
            // Without overlap seams are seen.
            assert!(sampling == 1 || differences(0) > 20, "{sampling}");
        }
    }
}
