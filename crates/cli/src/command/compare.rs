use std::path::{Path, PathBuf};

use clap::Args;
use gnomon::metrics::{
    Comparison, Exposure, Mask, Region, compare_displayed, flip_difference, signed_difference,
};
use gnomon::picture::{Decoded, read, read_mask};
use gnomon_terminal::{Terminal, print};
use serde::Serialize;
use serde_json::{Map, Value};

use crate::error::CliError;
use crate::output;

/// Say how far a picture is from a reference
///
/// Prints JSON: relative RMSE, MAE and bias of the linear radiance (against the mean of the reference), PSNR and FLIP of the
/// displayed pictures. FLIP's percentiles are weighted by error: pixels up to the weighted median carry half of the whole
/// error, so that a missing shadow stands out from faint noise everywhere.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  gnomon compare picture.exr reference.exr
  gnomon compare a.png b.png --difference flip.png
  gnomon compare a.exr b.exr --mask floor.png --region umbra=100,80,40x20")]
pub struct CompareArgs {
    /// The picture to judge (EXR, HDR, PNG or JPEG)
    #[arg(value_name = "A")]
    picture: PathBuf,

    /// The truth, equally large
    #[arg(value_name = "B")]
    reference: PathBuf,

    /// Compare only where this picture is white
    #[arg(long, value_name = "M.png")]
    mask: Option<PathBuf>,

    /// Measure a named rectangle too, inside the mask; may be repeated
    #[arg(long = "region", value_name = "NAME=X,Y,WxH")]
    regions: Vec<Region>,

    /// Write the FLIP error as a picture, black where equal to yellow where very different
    #[arg(long, value_name = "OUT.png")]
    difference: Option<PathBuf>,

    /// Write the signed difference as a picture: grey where equal, lighter where A is brighter; the reference's mean reaches
    /// white
    #[arg(long, value_name = "OUT.png")]
    signed_difference: Option<PathBuf>,

    /// Exposure of the displayed pictures, in stops [default: 0 for two 8-bit pictures, otherwise the reference's median
    /// luminance is shown as mid grey]
    #[arg(long, value_name = "EV", allow_negative_numbers = true, value_parser = crate::options::stops)]
    exposure: Option<f32>,
}

#[derive(Serialize)]
struct Report<'a> {
    picture: &'a Path,
    reference: &'a Path,
    #[serde(skip_serializing_if = "Option::is_none")]
    mask: Option<&'a Path>,
    #[serde(flatten)]
    comparison: Comparison,
    #[serde(skip_serializing_if = "Map::is_empty")]
    regions: Map<String, Value>,
}

/// Runs the command.
///
/// # Errors
/// Unreadable or unequal pictures, unwritable outputs.
pub fn run(args: &CompareArgs, terminal: Terminal) -> Result<(), CliError> {
    for path in [&args.difference, &args.signed_difference].into_iter().flatten() {
        output::check(path, &["png", "exr"])?;
    }
    let picture = load(&args.picture, terminal)?;
    let reference = load(&args.reference, terminal)?;
    let eight_bit = |decoded: &Decoded| matches!(decoded.format, "PNG" | "JPEG");
    if eight_bit(&picture) != eight_bit(&reference) {
        terminal.warn("one picture is 8-bit and displayed, the other linear radiance: expect large errors");
    }
    let exposure = match args.exposure {
        Some(stops) => Exposure::Stops(stops),
        None if eight_bit(&picture) && eight_bit(&reference) => Exposure::Stops(0.0),
        None => Exposure::Auto,
    };
    let (picture, reference) = (picture.image, reference.image);
    let mask = match &args.mask {
        Some(path) => Mask::from(read_mask(path)?),
        None => Mask::everything(reference.width(), reference.height()),
    };

    let spinner = terminal.spinner("comparing");
    let comparison = compare_displayed(&picture, &reference, Some(&mask), exposure)?;
    // Regions are displayed like the whole, or their figures could not be set beside each other.
    let shown = Exposure::Stops(comparison.exposure);
    let mut regions = Map::new();
    for region in &args.regions {
        let [right, bottom] = [(region.x, region.width), (region.y, region.height)]
            .map(|(first, count)| u64::from(first) + u64::from(count));
        if right > u64::from(mask.width()) || bottom > u64::from(mask.height()) {
            terminal.warn(&format!(
                "the region {} reaches beyond the picture of {} x {}: only what lies inside is measured",
                region.name,
                mask.width(),
                mask.height()
            ));
        }
        let inside = compare_displayed(&picture, &reference, Some(&mask.within(region)), shown)?;
        let figures = serde_json::to_value(inside).unwrap_or_default();
        regions.insert(region.name.clone(), figures);
    }
    if let Some(path) = &args.difference {
        gnomon::picture::write(path, &flip_difference(&picture, &reference, shown)?)?;
    }
    if let Some(path) = &args.signed_difference {
        let mean = comparison.reference_mean.iter().sum::<f64>() / 3.0;
        let scale = if mean > 0.0 { mean as f32 } else { 1.0 };
        gnomon::picture::write(path, &signed_difference(&picture, &reference, scale)?)?;
    }
    drop(spinner);
    Ok(print(&output::json(&Report {
        picture: &args.picture,
        reference: &args.reference,
        mask: args.mask.as_deref(),
        comparison,
        regions,
    }))?)
}

fn load(path: &Path, terminal: Terminal) -> Result<Decoded, CliError> {
    let decoded = read(path)?;
    for warning in &decoded.warnings {
        terminal.warn(&format!("{}: {warning}", path.display()));
    }
    Ok(decoded)
}
