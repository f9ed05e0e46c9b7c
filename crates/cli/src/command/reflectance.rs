use std::path::{Path, PathBuf};

use clap::Args;
use glam::{Vec2, Vec3, Vec4};
use gnomon::brdf::{Lobe, Model, Surface, Tables};
use gnomon::measured::{self, Measurement};
use gnomon::picture::RgbImage;
use gnomon::scene::ReflectanceSettings;
use gnomon_terminal::{Terminal, print};

use crate::error::CliError;
use crate::output;

/// Make tables of a measured reflectance, or of a model, and say how far they are from it
///
/// For every number of terms of the separable factorisation (Kautz and McCool 1999), and for the homomorphic one (McCool, Ang and Ahmad 2001),
/// a line tells the error over all pairs of directions, the most that is reflected of uniform light, and the bytes. Tables that give back
/// more light than they get are scaled.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  gnomon reflectance paint.bsdf
  gnomon reflectance gold-metallic-paint.binary --terms 4 -o paint.json --plot lobes.png
  gnomon reflectance ward:slope=0.1,aspect=4,specular=1 --plot lobes.png")]
pub struct ReflectanceArgs {
    /// File of the RGL (.bsdf), of MERL (.binary) or of tables (.json), or a model as --reflectance takes it
    #[arg(value_name = "FILE")]
    file: String,

    /// Most terms of the factorisation; tables that are written have so many
    #[arg(long, value_name = "N", default_value_t = measured::DEFAULT_TERMS as u8, value_parser = clap::value_parser!(u8).range(1..=measured::MAX_TERMS as i64))]
    terms: u8,

    /// Write positive tables of one product instead, as the homomorphic factorisation makes them of what is isotropic
    #[arg(long)]
    homomorphic: bool,

    /// Write the tables, which the material of a scene file names
    #[arg(short, long, value_name = "TABLES.json")]
    output: Option<PathBuf>,

    /// Draw the lobes in the plane of incidence, the root of their length: the measurement white, tables red, green and blue for views at 0, 30
    /// and 60 degrees
    #[arg(long, value_name = "OUT.png")]
    plot: Option<PathBuf>,
}

/// Runs the command.
///
/// # Errors
/// Files that are unreadable or damaged, unwritable outputs.
pub fn run(args: &ReflectanceArgs, terminal: Terminal) -> Result<(), CliError> {
    if let Some(path) = &args.output {
        output::check(path, &["json"])?;
    }
    if let Some(path) = &args.plot {
        output::check(path, &["png", "exr"])?;
    }
    let path = Path::new(&args.file);
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
    let extension = extension.filter(|extension| measured::EXTENSIONS.contains(&extension.as_str()));
    let (measurement, tables) = match extension.as_deref() {
        None => (None, of_model(&args.file)?),
        Some("json") => {
            (None, measured::parse(&gnomon::picture::read_bytes(path)?).map_err(|error| at(path, error))?)
        }
        Some(extension) => {
            let bytes = gnomon::picture::read_bytes(path)?;
            let measurement = Measurement::parse(extension, &bytes).map_err(|error| at(path, error))?;
            let tables = factorized(&measurement, args, terminal)?;
            (Some(measurement), tables)
        }
    };
    let (tables, warning) = measured::within_energy(tables);
    if let Some(warning) = warning {
        terminal.warn(&warning);
    }
    if measurement.is_none() {
        print(&described("tables", None, &tables))?;
    }
    if let Some(path) = &args.plot {
        gnomon::picture::write(path, &plot(measurement.as_ref(), &tables))?;
    }
    match &args.output {
        Some(path) => output::write_text(path, &measured::to_text(&tables)),
        None => Ok(()),
    }
}

fn at(path: &Path, error: impl std::fmt::Display) -> CliError {
    CliError::usage(format!("cannot read {}: {error}", path.display()))
}

fn of_model(text: &str) -> Result<Tables, CliError> {
    let settings: ReflectanceSettings = text.parse()?;
    let mut surface = Surface::default();
    settings.apply(&mut surface);
    let none = || CliError::usage(format!("{} is no tabulated model, and no file", surface.model.name()));
    surface.tables().ok_or_else(none)
}

/// Tables of a measurement. Tells of those with fewer terms, too.
fn factorized(
    measurement: &Measurement,
    args: &ReflectanceArgs,
    terminal: Terminal,
) -> Result<Tables, CliError> {
    let mut last = measured::factorize(measurement, 1);
    for terms in 1..=usize::from(args.terms) {
        let spinner = terminal.spinner("factorising");
        last = measured::factorize(measurement, terms);
        let line = described(
            &format!("{terms} {}", if terms == 1 { "term" } else { "terms" }),
            Some(measurement),
            &last,
        );
        drop(spinner);
        print(&line)?;
    }
    if measurement.is_isotropic() {
        let homomorphic = measured::homomorphic(measurement);
        print(&described("homomorphic", Some(measurement), &homomorphic))?;
        if args.homomorphic {
            return Ok(homomorphic);
        }
    } else if args.homomorphic {
        return Err(CliError::usage("the homomorphic factorisation is of isotropic measurements"));
    }
    Ok(last)
}

fn described(what: &str, measurement: Option<&Measurement>, tables: &Tables) -> String {
    let error = measurement.map_or(String::new(), |measurement| {
        let error = measured::fit_error(measurement, tables);
        format!("relative L2 {:.4}, mean error {:.4}, ", error.relative_l2, error.mean)
    });
    format!(
        "{what}: {error}reflects at most {:.3}, as wide as GGX of roughness {:.2}, {} bytes",
        tables.most(),
        tables.roughness(),
        tables.bytes()
    )
}

/// Angles of the view that lobes are drawn for [degrees], and their colours.
const VIEWS: [(f32, Vec3); 3] =
    [(0.0, Vec3::new(1.0, 0.35, 0.2)), (30.0, Vec3::new(0.3, 0.8, 0.3)), (60.0, Vec3::new(0.35, 0.55, 1.0))];
const PLOT: [u32; 2] = [720, 400];
/// Pixels around the lobes.
const MARGIN: f32 = 30.0;

/// Polar lobes in the plane of incidence, their length the square root of luminance times the light's cosine.
fn plot(measurement: Option<&Measurement>, tables: &Tables) -> RgbImage {
    let lobe = Lobe { model: Model::Measured, shape: 0.0, tint: Vec4::ONE, tables: Some(tables) };
    let of_plane = |degrees: f32| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        Vec3::new(sin, 0.0, cos)
    };
    let length =
        |value: Vec3, wi: Vec3| (value.dot(Vec3::new(0.2126, 0.7152, 0.0722)) * wi.z).max(0.0).sqrt();
    let angles = || (0..=1780).map(|i| of_plane(0.1 * i as f32 - 89.0));
    let curve = |value: &dyn Fn(Vec3) -> Vec3| -> Vec<Vec2> {
        angles().map(|wi| Vec2::new(wi.x, wi.z) * length(value(wi), wi)).collect()
    };
    let mut curves = Vec::new();
    for (degrees, color) in VIEWS {
        let wo = of_plane(-degrees);
        if let Some(measurement) = measurement {
            curves.push((curve(&|wi| measurement.value(wo, wi)), Vec3::splat(0.9)));
        }
        curves.push((curve(&|wi| lobe.value(wo, wi)), color));
    }
    let [width, height] = PLOT.map(|side| side as f32);
    let reach = curves
        .iter()
        .flat_map(|(points, _)| points)
        .fold(Vec2::splat(1e-6), |most, point| most.max(point.abs()));
    let scale = ((0.5 * width - MARGIN) / reach.x).min((height - 2.0 * MARGIN) / reach.y);
    let mut picture = RgbImage::filled(PLOT[0], PLOT[1], Vec3::splat(0.02));
    let mut dot = |at: Vec2, color: Vec3| {
        let place = Vec2::new(0.5 * width + scale * at.x, height - MARGIN - scale * at.y);
        let [x, y] = [place.x.max(0.0) as u32, place.y.max(0.0) as u32];
        if x < PLOT[0] && y < PLOT[1] {
            *picture.get_mut(x, y) = color;
        }
    };
    for (points, color) in &curves {
        for pair in points.windows(2) {
            let steps = (scale * pair[0].distance(pair[1])).ceil().max(1.0) as u32;
            (0..steps).for_each(|step| dot(pair[0].lerp(pair[1], step as f32 / steps as f32), *color));
        }
    }
    picture
}
