//! Ray-traced truth: direct light on a scene, as the mean and the variance of every pixel.
//!
//! [`render`] lights the scene by the environment itself, a map with or without lights beside it ([`Sky`]); [`render_lights`] by a fitted [`gnomon_lights::LightSet`], which
//! tells the error of a fit from that of a shadow technique; [`trace_pixels`] traces single pixels of [`render`]'s picture. All add
//! the scene's own area lights. None shares code with the GPU renderer beyond the scene, the map lookup and the reflectance models.
//!
//! What counts as the truth:
//! - Light arrives directly, from infinity or from the scene's area lights; nothing is reflected twice. Emission of
//!   materials is seen by the camera but lights nothing.
//! - Area lights are not seen by the camera and block nothing, but mirrors show them.
//! - A pixel is the mean over its area; the camera sees the environment behind the scene, bilinearly interpolated.
//! - Every surface is seen, lit and casts shadows from both sides, single-sided materials too. The shading normal is turned
//!   to the side of the triangle that the viewer sees.
//! - Light from under the triangle's plane does not arrive, wherever an interpolated normal points.
//! - Holes of an alpha mask let camera and shadow rays pass.
//!
//! Every estimate is unbiased, depends on the seed and not on the number of threads, and starts anew from the scene that
//! it is given, so that an animation is one call a pose.

mod arrival;
mod bumps;
mod camera_ray;
mod environment;
mod error;
mod illumination;
mod near_light;
mod pixels;
mod progressive;
mod relief;
mod render;
mod sampler;
mod shade;
mod spherical_rectangle;
mod traced_scene;
mod welford;

pub use arrival::{MOST_UNASKED_TRIANGLES, interior_arrival};
pub use camera_ray::{Ray, camera_ray};
pub use error::ReferenceError;
pub use pixels::trace_pixels;
pub use progressive::Progressive;
pub use render::{
    Estimate, MAX_PIXELS, ReferenceOptions, ResidualShadows, Sky, render, render_lights, render_with_alpha,
};
