//! Pictures as they are decoded: whole, or, where they are large, averaged down on the way.

use std::sync::Arc;

use glam::Vec3;
use gnomon_picture::{DecodeError, Description, EnvironmentAttribute, RgbImage, TexelSink, decode_into};

use crate::grid::Sampling;
use crate::load::CleanReport;
use crate::resample::shares_of_equirect;
use crate::{Backdrop, Equirect, Projection};

/// Largest map that light is worked out from, in texels: finer ones are averaged down to it. A texel is then a fifth of the sun wide.
const MAX_WORKING: [u32; 2] = [4096, 2048];
/// Largest picture of a projection other than equirect, in texels: resampling takes some 100 bytes for each.
pub(crate) const MAX_RESAMPLED_TEXELS: u64 = 1 << 24;

/// What became of a picture.
pub(crate) enum Taken {
    /// It is of no use: of no known shape, or too large to be resampled.
    Nothing,
    /// All of it, as its file has it.
    Whole(RgbImage),
    /// Cleaned, and averaged down.
    Averaged(Box<Averaged>),
}

/// A picture, its size, and what its file says of its projection.
pub(crate) struct Intake {
    pub taken: Taken,
    pub size: (u32, u32),
    pub environment: Option<EnvironmentAttribute>,
    pub projection: Option<Projection>,
    forced: Option<Projection>,
    /// What an infinite channel becomes.
    infinity: f32,
}

/// Decodes a picture to serve as an environment.
///
/// # Errors
/// As [`decode_into`].
pub(crate) fn take(
    bytes: &[u8],
    forced: Option<Projection>,
    layer: Option<&str>,
) -> Result<(Intake, Description), DecodeError> {
    let run = |infinity: f32| {
        let (size, environment, projection) = ((0, 0), None, None);
        let mut intake = Intake { taken: Taken::Nothing, size, environment, projection, forced, infinity };
        let description = decode_into(bytes, layer, &mut intake)?;
        Ok((intake, description))
    };
    let (intake, description) = run(0.0)?;
    match &intake.taken {
        // What infinity stands for is known once all has been seen.
        Taken::Averaged(averaged) if averaged.report.infinite > 0 => {
            let largest = averaged.largest;
            drop(intake);
            run(largest)
        }
        _ => Ok((intake, description)),
    }
}

impl TexelSink for Intake {
    fn begin(&mut self, width: u32, height: u32, environment: Option<EnvironmentAttribute>) {
        self.size = (width, height);
        self.environment = environment;
        self.projection = self.forced.or_else(|| Projection::detect(width, height, environment));
        let factor = width.div_ceil(MAX_WORKING[0]).max(height.div_ceil(MAX_WORKING[1]));
        self.taken = match self.projection {
            Some(Projection::Equirect) if factor > 1 => {
                let sampling = Projection::Equirect.sampling(environment);
                let size = [width, height].map(|side| side.div_ceil(factor));
                Taken::Averaged(Box::new(Averaged::new([width, height], sampling, size, self.infinity)))
            }
            Some(projection)
                if projection == Projection::Equirect
                    || u64::from(width) * u64::from(height) <= MAX_RESAMPLED_TEXELS =>
            {
                Taken::Whole(RgbImage::filled(width, height, Vec3::ZERO))
            }
            _ => Taken::Nothing,
        };
    }

    fn texels(&mut self, x: u32, y: u32, texels: &[Vec3]) {
        match &mut self.taken {
            Taken::Nothing => {}
            Taken::Whole(image) => image.row_mut(y)[x as usize..][..texels.len()].copy_from_slice(texels),
            Taken::Averaged(averaged) => averaged.take(x, y, texels),
        }
    }
}

/// A large map: what light is worked out from, and what is seen of it.
pub(crate) struct Averaged {
    /// By column and by row of the picture: those of the map that it overlaps, and with which share of theirs.
    columns: Vec<[(u32, f32); 2]>,
    rows: Vec<[(u32, f32); 2]>,
    map: RgbImage,
    backdrop: Backdrop,
    pub report: CleanReport,
    /// Largest finite channel.
    largest: f32,
    infinity: f32,
    row: Vec<Vec3>,
}

impl Averaged {
    fn new([width, height]: [u32; 2], sampling: Sampling, size: [u32; 2], infinity: f32) -> Self {
        let [columns, rows] = shares_of_equirect([width, height], sampling, size);
        Self {
            columns: by_source(width, &columns),
            rows: by_source(height, &rows),
            map: RgbImage::filled(size[0], size[1], Vec3::ZERO),
            // Samples from edge to edge lie half a texel off at most.
            backdrop: Backdrop::new(width, height),
            report: CleanReport::default(),
            largest: 0.0,
            infinity,
            row: Vec::new(),
        }
    }

    fn take(&mut self, x: u32, y: u32, texels: &[Vec3]) {
        self.row.clear();
        for &texel in texels {
            let largest = if texel.is_finite() {
                texel.max_element()
            } else {
                texel.to_array().into_iter().filter(|channel| channel.is_finite()).fold(0.0, f32::max)
            };
            self.largest = self.largest.max(largest);
            self.row.push(self.report.clean(texel, self.infinity));
        }
        self.backdrop.put(x, y, &self.row);
        for (row, share_of_row) in self.rows[y as usize] {
            if share_of_row == 0.0 {
                continue;
            }
            let sums = self.map.row_mut(row);
            for (texel, columns) in self.row.iter().zip(&self.columns[x as usize..]) {
                for &(column, share) in columns.iter().filter(|(_, share)| *share != 0.0) {
                    sums[column as usize] += *texel * (share * share_of_row);
                }
            }
        }
    }

    /// The map, with its backdrop.
    pub fn finish(self) -> (Equirect, CleanReport) {
        (Equirect::new(self.map).with_backdrop(Arc::new(self.backdrop)), self.report)
    }
}

/// Turns the shares of each target round, where no source overlaps more than two of them.
fn by_source(count: u32, shares: &[Vec<(u32, f64)>]) -> Vec<[(u32, f32); 2]> {
    let mut turned = vec![[(0, 0.0); 2]; count as usize];
    for (target, sources) in (0..).zip(shares) {
        for &(source, share) in sources {
            let slots = &mut turned[source as usize];
            let slot = usize::from(slots[0].1 != 0.0);
            if share > 0.0 {
                slots[slot] = (target, share as f32);
            }
        }
    }
    turned
}
