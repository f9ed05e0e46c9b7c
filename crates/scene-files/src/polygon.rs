//! Polygons cut into triangles.

use earcut::Earcut;
use glam::{DVec2, DVec3};

/// Cuts polygons of any shape. It keeps its memory from one to the next.
pub struct Cutter {
    earcut: Earcut<f64>,
    flat: Vec<DVec2>,
    indices: Vec<u32>,
    triangles: Vec<[u32; 3]>,
    too_large: usize,
}

/// Corners of a polygon whose ears are cut: the time for an outline of many spikes grows with the square of their number, to a second here.
const MOST_CORNERS: usize = 1 << 15;

impl Default for Cutter {
    fn default() -> Self {
        Self {
            earcut: Earcut::new(),
            flat: Vec::new(),
            indices: Vec::new(),
            triangles: Vec::new(),
            too_large: 0,
        }
    }
}

impl Cutter {
    /// Triangles over the polygon's corners, by their numbers, which turn as it does: a fan where that fills its outline, as with convex ones,
    /// and else its ears, cut on the plane that fits it best; but one of too many corners becomes a fan ([`Cutter::warning`]). Every polygon of at least three corners has some: one without area, or with
    /// corners that are not finite, becomes a fan. Fewer corners have none.
    pub fn cut(&mut self, corners: &[DVec3]) -> &[[u32; 3]] {
        self.triangles.clear();
        let count = corners.len() as u32;
        let is_fan = corners.len() < 4 || !self.flatten(corners) || fills_outline(&self.flat);
        if !is_fan && corners.len() > MOST_CORNERS {
            self.too_large += 1;
        } else if !is_fan {
            self.earcut.earcut(self.flat.iter().map(|corner| corner.to_array()), &[], &mut self.indices);
            let (ears, _) = self.indices.as_chunks::<3>();
            self.triangles.extend(ears.iter().map(|&[a, b, c]| {
                let [p, q, r] = [a, b, c].map(|corner| self.flat[corner as usize]);
                if (q - p).perp_dot(r - p) < 0.0 { [a, c, b] } else { [a, b, c] }
            }));
        }
        if self.triangles.is_empty() {
            self.triangles.extend((2..count).map(|last| [0, last - 1, last]));
        }
        &self.triangles
    }

    /// What is to be said of polygons that became fans for their size alone.
    pub fn warning(&self) -> Option<String> {
        let (count, most) = (self.too_large, MOST_CORNERS);
        (count > 0).then(|| {
            format!("{count} polygons of more than {most} corners may be filled beyond their outlines")
        })
    }

    /// Projects the corners onto the polygon's plane, where it turns counter-clockwise; false where it has none.
    fn flatten(&mut self, corners: &[DVec3]) -> bool {
        let first = corners[0];
        // Twice its area vector (Newell's method), about a corner, so that far coordinates keep their digits.
        let pairs = corners.iter().zip(corners.iter().cycle().skip(1));
        let area: DVec3 = pairs.map(|(a, b)| (*a - first).cross(*b - first)).sum();
        let Some(normal) = area.try_normalize() else { return false };
        let (right, up) = normal.any_orthonormal_pair();
        self.flat.clear();
        self.flat.extend(corners.iter().map(|corner| {
            let offset = *corner - first;
            DVec2::new(offset.dot(right), offset.dot(up))
        }));
        self.flat.iter().all(|corner| corner.is_finite())
    }
}

/// Whether a fan from the first corner covers a counter-clockwise polygon once: its triangles turn as it does, and go less than once around.
fn fills_outline(flat: &[DVec2]) -> bool {
    let first = flat[0];
    let mut angle = 0.0;
    flat[1..].windows(2).all(|pair| {
        let (a, b) = (pair[0] - first, pair[1] - first);
        let turn = a.perp_dot(b);
        angle += turn.atan2(a.dot(b));
        // Corners in line are as good as convex, whatever rounding makes of them.
        turn >= -1e-12 * (a.length_squared() + b.length_squared()) && angle <= std::f64::consts::TAU
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// The outline on a plane that leans, far from the origin.
    fn placed(outline: &[[f64; 2]]) -> Vec<DVec3> {
        let (right, up) = DVec3::new(1.0, 2.0, -0.5).normalize().any_orthonormal_pair();
        outline.iter().map(|[x, y]| DVec3::new(5e5, 40.0, 4.5e6) + *x * right + *y * up).collect()
    }

    fn area_vector(corners: &[DVec3]) -> DVec3 {
        let first = corners[0];
        corners.windows(2).map(|pair| 0.5 * (pair[0] - first).cross(pair[1] - first)).sum()
    }

    /// Sum of the triangles' areas, and of their area vectors.
    fn areas(corners: &[DVec3]) -> (f64, DVec3) {
        let mut cutter = Cutter::default();
        let vectors =
            cutter.cut(corners).iter().map(|t| area_vector(&t.map(|corner| corners[corner as usize])));
        vectors.fold((0.0, DVec3::ZERO), |(area, sum), vector| (area + vector.length(), sum + vector))
    }

    const U: [[f64; 2]; 8] =
        [[0.0, 0.0], [3.0, 0.0], [3.0, 3.0], [2.0, 3.0], [2.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]];

    #[test]
    fn polygons_are_cut_inside_their_outline_from_every_corner() {
        let arrow = [[0.0, 0.0], [2.0, -1.0], [0.0, 2.0], [0.5, 0.0]];
        let comb: Vec<[f64; 2]> = (0..40)
            .map(|i| [f64::from(i), f64::from(i % 2) * 5.0])
            .chain([[39.0, -1.0], [0.0, -1.0]])
            .collect();
        let doubled: Vec<[f64; 2]> = U.iter().flat_map(|corner| [*corner, *corner]).collect();
        let collinear: Vec<[f64; 2]> = (0..U.len())
            .flat_map(|i| [U[i], [0, 1].map(|axis| 0.5 * (U[i][axis] + U[(i + 1) % 8][axis]))])
            .collect();
        for outline in [&U[..], &arrow, &comb, &doubled, &collinear] {
            let mut outline = outline.to_vec();
            for _ in 0..outline.len() {
                outline.rotate_left(1);
                for corners in [placed(&outline), placed(&outline.iter().rev().copied().collect::<Vec<_>>())]
                {
                    let whole = area_vector(&corners);
                    let (area, sum) = areas(&corners);
                    assert!(
                        (area - whole.length()).abs() < 1e-6 * area,
                        "{area}, not {}: {outline:?}",
                        whole.length()
                    );
                    assert!(sum.distance(whole) < 1e-6 * area, "it turns the other way: {outline:?}");
                }
            }
        }
    }

    #[test]
    fn convex_polygons_become_fans() {
        let square = placed(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
        assert_eq!(Cutter::default().cut(&square), [[0, 1, 2], [0, 2, 3]]);
    }

    #[test]
    fn polygons_that_are_none_are_defined() {
        let nothing = [DVec3::ONE; 5];
        let line: Vec<DVec3> = (0..5).map(|i| f64::from(i) * DVec3::X).collect();
        let broken = [DVec3::ZERO, DVec3::X, DVec3::NAN, DVec3::Y, DVec3::splat(f64::INFINITY)];
        for corners in [&nothing[..], &line, &broken] {
            assert_eq!(Cutter::default().cut(corners), [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
        }
        assert!(Cutter::default().cut(&nothing[..2]).is_empty());
        let spikes: Vec<DVec3> = (0..=MOST_CORNERS)
            .map(|i| DVec2::from_angle(i as f64 * 1e-4) * if i % 2 == 0 { 1.0 } else { 1.1 })
            .map(|corner| corner.extend(0.0))
            .collect();
        let mut cutter = Cutter::default();
        assert!(cutter.cut(&spikes).len() == MOST_CORNERS - 1 && cutter.warning().is_some());
    }

    proptest! {
        #[test]
        fn any_corners_end_in_triangles_over_them(places in prop::collection::vec(0..27_usize, 3..24)) {
            let corners: Vec<DVec3> = places
                .iter()
                .map(|place| DVec3::new((place % 3) as f64, (place / 3 % 3) as f64, (place / 9) as f64))
                .collect();
            let mut cutter = Cutter::default();
            let triangles = cutter.cut(&corners);
            prop_assert!(!triangles.is_empty() && triangles.len() <= corners.len() - 2);
            prop_assert!(triangles.iter().flatten().all(|&corner| (corner as usize) < corners.len()));
        }
    }
}
