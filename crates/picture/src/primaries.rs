//! Colours of other primaries as linear Rec. 709.

use glam::{DMat3, DVec2, DVec3, Mat3, Vec3};

use crate::picture::{LUMINANCE, rec709_from_xyz};

/// Chromaticities (CIE x, y) of what a file's red, green and blue stand for, and of its white.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Primaries {
    pub red: [f32; 2],
    pub green: [f32; 2],
    pub blue: [f32; 2],
    pub white: [f32; 2],
}

/// Primaries and white of Rec. 709.
const REC709: Primaries =
    Primaries { red: [0.64, 0.33], green: [0.30, 0.60], blue: [0.15, 0.06], white: [0.3127, 0.3290] };
/// Chromaticities that differ by less than this are the same.
const SAME: f32 = 0.005;
/// XYZ to the responses of cones (Lam 1985, as ICC.1:2022 annex E has it), by columns.
const BRADFORD: DMat3 = DMat3::from_cols(
    DVec3::new(0.8951, -0.7502, 0.0389),
    DVec3::new(0.2664, 1.7135, -0.0685),
    DVec3::new(-0.1614, 0.0367, 1.0296),
);

impl Primaries {
    fn each(&self) -> [[f32; 2]; 4] {
        [self.red, self.green, self.blue, self.white]
    }

    /// Whether `red`, `green` and `blue` are X, Y and Z themselves: such colours are absolute, and their white says nothing.
    fn is_xyz(&self) -> bool {
        [self.red, self.green, self.blue] == [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]]
    }

    /// Whether colours of these are those of Rec. 709.
    pub fn is_rec709(&self) -> bool {
        let near = |a: [f32; 2], b: [f32; 2]| (a[0] - b[0]).abs().max((a[1] - b[1]).abs()) < SAME;
        self.each().into_iter().zip(REC709.each()).all(|(own, other)| near(own, other))
    }

    /// White with Y = 1 as XYZ; `None` where it has no light.
    fn white_xyz(&self) -> Option<DVec3> {
        let [x, y] = self.white.map(f64::from);
        let white = DVec3::new(x / y, 1.0, (1.0 - x - y) / y);
        (white.is_finite() && y > 0.0).then_some(white)
    }

    /// XYZ of these colours, where equal amounts make the white; `None` for primaries that span no colours.
    fn xyz(&self) -> Option<DMat3> {
        let column = |[x, y]: [f32; 2]| {
            let at = DVec2::new(f64::from(x), f64::from(y));
            DVec3::new(at.x, at.y, 1.0 - at.x - at.y)
        };
        let columns = DMat3::from_cols(column(self.red), column(self.green), column(self.blue));
        // NaN is not above the bound either.
        if columns.determinant().abs() > 1e-6 {
            let amounts = columns.inverse() * self.white_xyz()?;
            Some(columns * DMat3::from_diagonal(amounts))
        } else {
            None
        }
    }

    /// What makes linear Rec. 709 of these colours; white stays white (Bradford's adaptation). `None` for primaries that span no colours.
    pub fn rec709(&self) -> Option<Mat3> {
        if self.is_xyz() {
            return Some(from_xyz());
        }
        let (from, to) = (BRADFORD * self.white_xyz()?, BRADFORD * REC709.white_xyz()?);
        let adapted = BRADFORD.inverse() * DMat3::from_diagonal(to / from) * BRADFORD;
        let matrix = (REC709.xyz()?.inverse() * adapted * self.xyz()?).as_mat3();
        matrix.is_finite().then_some(matrix)
    }

    /// What is done with these colours, for people.
    pub fn told(&self) -> String {
        let [[rx, ry], [gx, gy], [bx, by], [wx, wy]] = self.each();
        format!("colours converted from primaries R {rx} {ry}, G {gx} {gy}, B {bx} {by}, white {wx} {wy}")
    }

    /// Weights of red, green and blue in luminance, which add up to 1; Rec. 709's for primaries that span no colours.
    pub fn luminance(&self) -> Vec3 {
        let weights = self.xyz().map(|xyz| {
            let row = xyz.row(1);
            (row / row.element_sum()).as_vec3()
        });
        weights.filter(|weights| weights.is_finite() && weights.y != 0.0).unwrap_or(LUMINANCE)
    }
}

/// CIE XYZ to linear Rec. 709.
pub(crate) fn from_xyz() -> Mat3 {
    Mat3::from_cols(rec709_from_xyz(Vec3::X), rec709_from_xyz(Vec3::Y), rec709_from_xyz(Vec3::Z))
}

/// Applies a matrix; what leaves the range of a float is its largest.
pub(crate) fn converted(matrix: &Mat3, color: Vec3) -> Vec3 {
    let limit = Vec3::splat(f32::MAX);
    let color = *matrix * color;
    // `clamp` would take NaN for a bound.
    if color.is_nan() { color } else { color.clamp(-limit, limit) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const REC2020: Primaries = Primaries {
        red: [0.708, 0.292],
        green: [0.170, 0.797],
        blue: [0.131, 0.046],
        white: [0.3127, 0.3290],
    };
    const AP1: Primaries = Primaries {
        red: [0.713, 0.293],
        green: [0.165, 0.830],
        blue: [0.128, 0.044],
        white: [0.32168, 0.33767],
    };

    #[test]
    fn published_matrices_come_out() {
        // ITU-R BT.2087-0, from Rec. 2020; ACES' own for AP1 (aces-dev, RRTAndODTCommon: Bradford from D60 to D65).
        let expected = [
            (REC2020, [[1.6605, -0.5876, -0.0728], [-0.1246, 1.1329, -0.0083], [-0.0182, -0.1006, 1.1187]]),
            (AP1, [[1.7051, -0.6218, -0.0833], [-0.1302, 1.1408, -0.0106], [-0.0240, -0.1290, 1.1530]]),
        ];
        for (primaries, rows) in expected {
            let matrix = primaries.rec709().unwrap();
            for (index, row) in rows.into_iter().enumerate() {
                assert!((matrix.row(index) - Vec3::from_array(row)).abs().max_element() < 5e-4, "{matrix}");
            }
        }
    }

    #[test]
    fn white_stays_white_and_xyz_is_absolute() {
        let radiance = Primaries { green: [0.29, 0.60], white: [0.3333, 0.3333], ..REC709 };
        for primaries in [radiance, REC2020, AP1] {
            let white = primaries.rec709().unwrap() * Vec3::ONE;
            assert!((white - 1.0).abs().max_element() < 1e-5, "{white}");
        }
        let xyz = Primaries { red: [1.0, 0.0], green: [0.0, 1.0], blue: [0.0, 0.0], white: [1.0 / 3.0; 2] };
        assert_eq!(xyz.rec709(), Some(from_xyz()));
        assert!(REC709.is_rec709() && !AP1.is_rec709());
    }

    #[test]
    fn what_spans_no_colours_has_no_matrix() {
        let flat = Primaries { red: [0.3, 0.3], green: [0.3, 0.3], ..REC709 };
        let nan = Primaries { blue: [f32::NAN, 0.0], ..REC709 };
        let dark = Primaries { white: [0.3, 0.0], ..REC709 };
        for primaries in [flat, nan, dark] {
            assert_eq!(primaries.rec709(), None);
            assert_eq!(primaries.luminance(), LUMINANCE);
        }
        assert!((REC709.luminance() - LUMINANCE).abs().max_element() < 2e-4);
    }
}
