//! Measured reflectance: files of the RGL and of MERL, their values between any two directions, and tables that stand for them
//! (`gnomon_brdf::Tables`), which are a file of their own.

mod document;
mod error;
mod factorize;
mod fit_error;
mod homomorphic;
mod merl;
mod rgl;

use glam::Vec3;
use gnomon_brdf::Tables;

pub use document::{parse, to_text};
pub use error::MeasuredError;
pub use factorize::factorize;
pub use fit_error::{FitError, fit_error};
pub use homomorphic::homomorphic;
pub use merl::Merl;
pub use rgl::Rgl;

/// Terms of a factorisation that nothing else is said of.
pub const DEFAULT_TERMS: usize = 3;
/// Most terms of a factorisation: further ones are smaller than the noise of measurements.
pub const MAX_TERMS: usize = 8;

/// Largest reflectance that is taken [1/sr]: mirrors are not measured.
pub const MOST: f32 = 1e6;

/// Ends of the names of files that [`load`] reads.
pub const EXTENSIONS: &[&str] = &["bsdf", "binary", "json"];

/// A measurement.
#[derive(Clone, Debug)]
pub enum Measurement {
    /// Of the RGL (Dupuy and Jakob 2018).
    Rgl(Box<Rgl>),
    /// Of MERL (Matusik et al. 2003).
    Merl(Box<Merl>),
}

impl Measurement {
    /// A file by the end of its name, `bsdf` or `binary`.
    ///
    /// # Errors
    /// [`MeasuredError`] for what it is not.
    pub fn parse(extension: &str, bytes: &[u8]) -> Result<Self, MeasuredError> {
        match extension {
            "bsdf" => Rgl::parse(bytes).map(|rgl| Self::Rgl(Box::new(rgl))),
            "binary" => Merl::parse(bytes).map(|merl| Self::Merl(Box::new(merl))),
            other => Err(MeasuredError::Extension(gnomon_messages::quoted(other))),
        }
    }

    /// Reflectance [1/sr], at most [`MOST`], without the cosine, between two unit vectors in the tangent frame; 0 where either is under the
    /// surface.
    pub fn value(&self, wo: Vec3, wi: Vec3) -> Vec3 {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return Vec3::ZERO;
        }
        let value = match self {
            Self::Rgl(rgl) => rgl.value(wo, wi),
            Self::Merl(merl) => merl.value(wo, wi),
        };
        // Factors of a damaged file may be anything.
        value.map(|channel| if channel > 0.0 { channel.min(MOST) } else { 0.0 })
    }

    /// Whether a turn about the normal changes nothing.
    pub fn is_isotropic(&self) -> bool {
        match self {
            Self::Rgl(rgl) => rgl.is_isotropic(),
            Self::Merl(_) => true,
        }
    }
}

/// Tables of a file by the end of its name: those of a table file, or a factorisation of a measurement in [`DEFAULT_TERMS`]. With a warning
/// where they had to be scaled so as not to give back more light than they get.
///
/// # Errors
/// [`MeasuredError`] for what the file is not.
pub fn load(extension: &str, bytes: &[u8]) -> Result<(Tables, Option<String>), MeasuredError> {
    let tables = match extension {
        "json" => parse(bytes)?,
        _ => factorize(&Measurement::parse(extension, bytes)?, DEFAULT_TERMS),
    };
    Ok(within_energy(tables))
}

/// The same tables, scaled where they reflect more than they get.
pub fn within_energy(tables: Tables) -> (Tables, Option<String>) {
    let most = tables.most();
    if most <= 1.0 {
        return (tables, None);
    }
    let warning = format!("the tables reflect up to {most:.3} of the light that they get: scaled to 1");
    (tables.normalized(1.0), Some(warning))
}
