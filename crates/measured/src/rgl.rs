//! The RGL's files (Dupuy and Jakob 2018, "An adaptive parameterization for efficient material acquisition and rendering"): values over
//! the unit square of samples of the visible normals, which warp it to half vectors.

use std::f32::consts::{FRAC_2_PI, TAU};

use glam::Vec3;

use crate::error::{MeasuredError, invalid};

mod tensor;
mod warp;

use tensor::{Tensor, read};
use warp::{Grid, Parameters, Warp};

/// A measurement.
#[derive(Clone, Debug)]
pub struct Rgl {
    description: String,
    /// Azimuth and angle of the view that slices stand for [rad].
    parameters: Parameters,
    ndf: Grid,
    sigma: Grid,
    vndf: Warp,
    /// A slice a view and channel.
    rgb: Grid,
    is_isotropic: bool,
    /// Parts of a turn that the views are of: the others are alike.
    reduction: u32,
}

/// Place of an angle against the normal: its root is even.
fn place_of_angle(theta: f32) -> f32 {
    (theta * FRAC_2_PI).max(0.0).sqrt()
}

/// Place of an azimuth in `[0, 1)`.
fn place_of_azimuth(phi: f32) -> f32 {
    let place = phi / TAU + 0.5;
    place - place.floor()
}

/// Angle to the normal, which keeps its digits near it.
fn angle(w: Vec3) -> f32 {
    2.0 * (0.5 * w.distance(Vec3::Z)).clamp(-1.0, 1.0).asin()
}

impl Rgl {
    /// A file.
    ///
    /// # Errors
    /// [`MeasuredError::Invalid`] for what it lacks, and for sizes and numbers that cannot be.
    pub fn parse(bytes: &[u8]) -> Result<Self, MeasuredError> {
        let tensors = read(bytes)?;
        let find = |name: &str| -> Result<&Tensor, MeasuredError> {
            let found = tensors.iter().find(|tensor| tensor.name == name);
            found.ok_or_else(|| {
                invalid(format!("the file has no '{name}': only files with RGB values are read"))
            })
        };
        let floats = |name: &str, dimensions: usize| -> Result<(&[usize], Vec<f32>), MeasuredError> {
            let tensor = find(name)?;
            let values = tensor.floats()?;
            if tensor.shape.len() != dimensions || values.is_empty() {
                return Err(invalid(format!("'{name}' must have {dimensions} dimensions")));
            }
            Ok((&tensor.shape, values))
        };
        let (_, phi) = floats("phi_i", 1)?;
        let (_, theta) = floats("theta_i", 1)?;
        let (ndf_shape, ndf) = floats("ndf", 2)?;
        let (sigma_shape, sigma) = floats("sigma", 2)?;
        let (vndf_shape, vndf) = floats("vndf", 4)?;
        let (rgb_shape, rgb) = floats("rgb", 5)?;
        let views = [phi.len(), theta.len()];
        if vndf_shape[..2] != views || rgb_shape[..2] != views || rgb_shape[2] != 3 {
            return Err(invalid(
                "'vndf' and 'rgb' must have a slice for every view of 'phi_i' and 'theta_i'",
            ));
        }
        let description = find("description").map(Tensor::text).unwrap_or_default();
        let is_isotropic = phi.len() <= 2;
        let range = phi[phi.len() - 1] - phi[0];
        let reduction = if is_isotropic { 1 } else { (TAU / range.max(1e-3)).round().clamp(1.0, 4.0) as u32 };
        Ok(Self {
            description,
            parameters: Parameters::new(phi, theta)?,
            ndf: Grid::new([ndf_shape[1], ndf_shape[0]], ndf)?,
            sigma: Grid::new([sigma_shape[1], sigma_shape[0]], sigma)?,
            vndf: Warp::new(Grid::new([vndf_shape[3], vndf_shape[2]], vndf)?),
            rgb: Grid::new([rgb_shape[4], rgb_shape[3]], rgb)?,
            is_isotropic,
            reduction,
        })
    }

    /// What the file says of the material.
    pub fn description(&self) -> &str {
        &self.description
    }

    /// Whether it was measured from one azimuth.
    pub fn is_isotropic(&self) -> bool {
        self.is_isotropic
    }

    /// Reflectance [1/sr] between two directions above the surface. Directions of the file's first kind, whose views it has slices of, are
    /// `wo` here.
    pub(crate) fn value(&self, wo: Vec3, wi: Vec3) -> Vec3 {
        self.value_times_cosine(wo, wi) / wi.z
    }

    /// The same times the cosine of `wi`, as the authors' loader gives it.
    pub fn value_times_cosine(&self, mut wo: Vec3, mut wi: Vec3) -> Vec3 {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return Vec3::ZERO;
        }
        if self.reduction >= 2 {
            // To the part of the turn that was measured: azimuths from -pi on.
            let flip_y = wo.y > 0.0;
            let flip_x = if self.reduction == 4 { wo.x > 0.0 } else { flip_y };
            for w in [&mut wo, &mut wi] {
                *w = Vec3::new(if flip_x { -w.x } else { w.x }, if flip_y { -w.y } else { w.y }, w.z);
            }
        }
        let h = (wo + wi).normalize_or(Vec3::Z);
        let phi_o = wo.y.atan2(wo.x);
        let theta_o = angle(wo);
        let phi_h = h.y.atan2(h.x) - if self.is_isotropic { phi_o } else { 0.0 };
        let of_view = [place_of_angle(theta_o), place_of_azimuth(phi_o)];
        let of_half = [place_of_angle(angle(h)), place_of_azimuth(phi_h)];
        let slices = self.parameters.slices(phi_o, theta_o);
        let sample = self.vndf.inverted(of_half, &slices);
        let channels = [0, 1, 2].map(|channel| {
            let of_slice = |(slice, weight): (usize, f32)| weight * self.rgb.at(3 * slice + channel, sample);
            slices.iter().map(|&slice| of_slice(slice)).sum::<f32>().max(0.0)
        });
        let sigma = self.sigma.at(0, of_view);
        if sigma <= 0.0 {
            return Vec3::ZERO;
        }
        Vec3::from_array(channels) * (self.ndf.at(0, of_half) / (4.0 * sigma))
    }
}
