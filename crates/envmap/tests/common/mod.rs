//! What the tests of this crate share.

use glam::{DVec3, Vec3};
use gnomon_envmap::Equirect;
use gnomon_picture::RgbImage;

/// Every map of the test data that is an environment, except those meant to be odd.
#[allow(dead_code, reason = "each test file is a crate of its own")]
pub const MAPS: [&str; 20] = [
    "cc0_kiara_1_dawn_1k.hdr",
    "cc0_pmndrs_city_dwab.exr",
    "cc0_pmndrs_sky_dwab.exr",
    "cc0_rooitou_park_1k.hdr",
    "cc0_spiaggia_di_mondello_1k.hdr",
    "cc0_studio_small_03_1k.hdr",
    "debevec_galileo_cross.hdr",
    "debevec_grace_cross.hdr",
    "debevec_kitchen_cross.hdr",
    "debevec_rnl_cross.hdr",
    "debevec_stpeters_cross.hdr",
    "oiio_uffizi_latlong_env-128_expected.exr",
    "oiio_uffizi_probe-128_angular.exr",
    "openexr_KernerEnvCube.exr",
    "openexr_KernerEnvLatLong.exr",
    "openexr_OrientationLatLong.exr",
    "openexr_WavyLinesCube.exr",
    "openexr_WavyLinesLatLong.exr",
    "probulator_grace_256x128.hdr",
    "uffizi_latlong_1200x600.hdr",
];

/// A map of smooth and sharp parts, bright and dark, without symmetry.
#[allow(dead_code, reason = "each test file is a crate of its own")]
pub fn uneven(width: u32, height: u32) -> Equirect {
    let grid = Equirect::new(RgbImage::filled(width, height, Vec3::ZERO));
    let texel = |x: u32, y: u32| {
        let d = grid.texel_direction(x, y);
        let lamp = if d.dot(Vec3::new(0.6, 0.64, 0.48)) > 0.97 { 300.0 } else { 0.0 };
        let stripes = ((x / 3 + y / 2) % 2) as f32;
        Vec3::new(1.2 + d.x, 1.1 + d.y * d.z + lamp, 0.2 + stripes)
    };
    Equirect::new(RgbImage::from_fn(width, height, texel))
}

/// Largest relative difference of two fluxes.
#[allow(dead_code, reason = "each test file is a crate of its own")]
pub fn flux_error(a: DVec3, b: DVec3) -> f64 {
    ((a - b) / b).abs().max_element()
}

/// Root mean square difference over the sphere, relative to that of `b`.
#[allow(dead_code, reason = "each test file is a crate of its own")]
pub fn rms(a: &Equirect, b: &Equirect) -> f64 {
    assert_eq!((a.width(), a.height()), (b.width(), b.height()));
    let (mut difference, mut square) = (0.0, 0.0);
    for y in 0..a.height() {
        for x in 0..a.width() {
            let (p, q) = (a.radiance().get(x, y).as_dvec3(), b.radiance().get(x, y).as_dvec3());
            difference += a.texel_solid_angle(y) * (p - q).length_squared();
            square += a.texel_solid_angle(y) * q.length_squared();
        }
    }
    (difference / square).sqrt()
}
