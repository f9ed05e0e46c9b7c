//! Pictures that are too large for one buffer of light sums, in bands of rows.

use std::ops::Range;
use std::sync::Arc;

use bytemuck::pod_collect_to_vec;
use gnomon_picture::RgbImage;

use super::{Frame, Renderer};
use gnomon_shaders::layout;

use crate::cryptomatte::Labels;
use crate::gpu::TextureReadBack;
use crate::layers::{RenderedLayer, RenderedLayers};
use crate::recorder::{FrameTimings, add_times};
use crate::shading_points::samplings;
use crate::{Gpu, RenderError};

/// Rows of a picture that are drawn at once.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Band {
    /// With the neighbours that samples near the edge look at.
    pub(super) drawn: Range<u32>,
    /// Of these: the part that becomes the picture's.
    pub(super) kept: Range<u32>,
}

impl Band {
    pub(super) fn whole(height: u32) -> Self {
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
    pub(super) fn bands(&self, [width, height]: [u32; 2]) -> Vec<Band> {
        let techniques = &self.settings().techniques;
        let samples = techniques.supersample;
        let sampling = samplings(techniques).into_iter().max().unwrap_or(1);
        let fits = |rows: u32| self.point_plan([width, rows]).largest_buffer() <= self.gpu.largest_storage();
        // Samples look at the tiles around their own, and those at what the list before has around them; points that are evened out look
        // at tiles that were, too. So many pixels hold a whole number of tiles.
        let evened = if self.sum_planes().evened { 2 * layout::EVEN_REACH + 1 } else { 0 };
        let overlap = ((3 + evened) * sampling).div_ceil(samples).next_multiple_of(sampling);
        let tiles = (1..=height.div_ceil(sampling)).rev();
        let most = || tiles.map(|tiles| tiles * sampling).find(|rows| fits(rows + 2 * overlap));
        let whole = Band::whole(height);
        if self.debug.is_some() || fits(height) {
            return vec![whole];
        }
        // Where not even one row of tiles fits, the error is that of the whole picture.
        most().map_or(vec![whole], |kept| cut(height, kept, overlap))
    }
}

/// A picture that is being drawn and read back.
pub(super) struct BandsInFlight {
    pub(super) gpu: Gpu,
    pub(super) size: [u32; 2],
    pub(super) bands: Vec<BandInFlight>,
    /// Without pixels yet.
    pub(super) layers: Vec<RenderedLayer>,
    /// What their mattes are of.
    pub(super) labels: Arc<Labels>,
}

/// A band of it, on its way.
pub(super) struct BandInFlight {
    pub(super) band: Band,
    pub(super) radiance: TextureReadBack,
    pub(super) display: TextureReadBack,
    /// Those of the picture, in order, of a matte one for each sample.
    pub(super) layers: Vec<Vec<TextureReadBack>>,
    pub(super) timings: FrameTimings,
}

impl BandsInFlight {
    /// The picture and its layers, once everything is there.
    pub(super) async fn frame(self) -> Result<(Frame, RenderedLayers), RenderError> {
        let Self { gpu, size: [width, height], bands, mut layers, labels } = self;
        let (mut radiance, mut alpha) = (Vec::new(), Vec::new());
        let (mut display, mut timings) = (Vec::new(), Vec::new());
        for BandInFlight { band, radiance: texels, display: bytes, layers: of_layers, timings: of_band } in
            bands
        {
            let texels: Vec<[f32; 4]> = pod_collect_to_vec(&texels.texels().await?);
            let bytes: Vec<[u8; 4]> = pod_collect_to_vec(&bytes.texels().await?);
            let before = ((band.kept.start - band.drawn.start) * width) as usize;
            let count = (band.kept.len() as u32 * width) as usize;
            let kept = texels.iter().skip(before).take(count);
            alpha.extend(kept.clone().map(|texel| texel[3]));
            radiance.extend(kept.map(|&[r, g, b, _]| glam::Vec3::new(r, g, b)));
            display.extend(bytes.into_iter().skip(before).take(count));
            for (layer, reads) in layers.iter_mut().zip(of_layers) {
                let mut samples: Vec<Vec<[u32; 4]>> = Vec::new();
                for read in reads {
                    samples.push(pod_collect_to_vec(&read.texels().await?));
                }
                let kept: Vec<&[[u32; 4]]> = samples
                    .iter()
                    .map(|words| words.get(before..before + count).unwrap_or_default())
                    .collect();
                match (layer.layer.names(&labels), kept.as_slice()) {
                    (Some(_), samples) => layer.extend_matte(samples, &labels),
                    (None, &[words]) => layer.extend(words),
                    (None, _) => {}
                }
            }
            add_times(&mut timings, of_band.passes().await?);
        }
        gpu.check()?;
        let pixels = radiance.iter().filter(|radiance| !radiance.is_finite()).count();
        if pixels > 0 {
            return Err(RenderError::NotFinite { pixels, adapter: gpu.adapter().name.clone() });
        }
        for layer in &layers {
            layer.check(&gpu.adapter().name)?;
        }
        let radiance = RgbImage::from_texels(width, height, radiance)
            .ok_or_else(|| RenderError::Device("the picture read back has another size".to_owned()))?;
        Ok((Frame { radiance, alpha, display, timings }, RenderedLayers { size: [width, height], layers }))
    }
}

#[cfg(test)]
mod tests {
    use gnomon_lights::fit::{FitOptions, by_name};
    use gnomon_scene::builtin;

    use super::super::layers::LayerTask;
    use super::*;
    use crate::layers::{Layer, LayerValues};
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

    /// Number of values that are others.
    fn layers_differ(a: &RenderedLayers, b: &RenderedLayers) -> usize {
        let pairs = a.layers.iter().zip(&b.layers);
        let differ = |(a, b): (&RenderedLayer, &RenderedLayer)| match (&a.values, &b.values) {
            (LayerValues::Labels(a), LayerValues::Labels(b)) => {
                assert_eq!(a.len(), b.len());
                a.iter().zip(b).filter(|(a, b)| a != b).count()
            }
            (LayerValues::Floats(a), LayerValues::Floats(b)) => {
                assert_eq!(a.len(), b.len());
                a.iter().zip(b).filter(|(a, b)| (*a - *b).abs() > 1e-4).count()
            }
            _ => usize::MAX,
        };
        pairs.map(differ).sum()
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
                s.techniques.supersample = 2;
                s.techniques.shadow_sampling = sampling;
                s.techniques.shadows = shadows.to_owned();
                s.techniques.shadow_memory = memory;
                s.techniques.shadow_sizing = crate::ShadowSizing::Uniform;
            });
            let mut renderer = Renderer::new(&gpu, settings).unwrap();
            renderer.set_scene(&scene).unwrap();
            renderer.set_lighting(&map, &lights).unwrap();
            assert_eq!(renderer.shadow_batches() > 1, memory == 1);
            let size = [64, 50];
            let task = |layer: Layer| LayerTask { layer, name: None, source: layer.source().unwrap() };
            let tasks = [task(Layer::Object), task(Layer::Position)];
            let mut drawn = |bands: &[Band]| {
                let bands = renderer.begin_bands(&scene.cameras[0], size, bands, &tasks).unwrap();
                gpu.wait_for(bands.frame()).unwrap()
            };
            let (whole, layers) = drawn(&[Band::whole(50)]);
            let mut differences = |overlap: u32| {
                let (banded, of_bands) = drawn(&cut(50, 12, overlap));
                assert_eq!(banded.display.len(), whole.display.len());
                assert!(layers_differ(&layers, &of_bands) <= 4);
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
            // Without overlap seams are seen where tiles are larger than pixels.
            assert!(sampling <= 2 || differences(0) > 20, "{sampling}");
        }
    }
}
