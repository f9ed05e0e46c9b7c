//! How much of the light from every direction arrives at what is seen of a scene.

use glam::{Vec2, Vec3};
use gnomon_envmap::CubeMap;

use super::faces::Faces;

/// Texels along a cube face's edge.
const SIZE: usize = 16;
/// Below this share of open sky a scene is an interior, or as good as one: a porch, a street between high houses. Lights then go to what arrives.
/// In the open, where most of it does, they stay where they are best for surfaces of any kind, so that neither camera nor pose changes them.
const INTERIOR_BELOW: f64 = 0.5;

/// Share of the light of every direction that arrives at receivers, on cube faces in the order of [`CubeMap`].
#[derive(Clone, Debug, PartialEq)]
pub struct Arrival {
    /// From 0 to 1, the largest being 1; row by row, face by face.
    weights: Vec<f64>,
}

impl Arrival {
    /// Number of directions that it is made of.
    pub const DIRECTIONS: usize = 6 * SIZE * SIZE;

    /// A direction of texel `index`, at `u` in the unit square within it; not normalised.
    pub fn direction(index: usize, u: Vec2) -> Vec3 {
        let (face, texel) = (index / (SIZE * SIZE), index % (SIZE * SIZE));
        let place = (Vec2::new((texel % SIZE) as f32, (texel / SIZE) as f32) + u) / SIZE as f32;
        CubeMap::point_on_face(face, 2.0 * place - 1.0)
    }

    /// For an interior: of `arrives` and `offered`, sums over receivers of the cosine of every direction with and without shadows.
    /// `None` where much of the sky is open, or nothing is offered.
    pub fn of_interior(arrives: &[f64], offered: &[f64]) -> Option<Self> {
        let (arriving, sum): (f64, f64) = (arrives.iter().sum(), offered.iter().sum());
        if !(sum > 0.0 && arriving < INTERIOR_BELOW * sum) {
            return None;
        }
        let mean = sum / offered.len().max(1) as f64;
        // Few receivers face some directions: they count as if the average number did.
        let shares: Vec<f64> =
            arrives.iter().zip(offered).map(|(arrives, offered)| arrives / offered.max(mean)).collect();
        let most = shares.iter().copied().fold(0.0, f64::max);
        // By roots, lights are small as well where they reach few receivers. What a few rays may have missed lies beside what they found.
        let root = |face: usize, x: usize, y: usize| (shares[(face * SIZE + y) * SIZE + x] / most).sqrt();
        let around = |at: usize| at.saturating_sub(1)..(at + 2).min(SIZE);
        let widened = |index: usize| {
            let (face, x, y) = (index / (SIZE * SIZE), index % SIZE, index / SIZE % SIZE);
            let beside = around(y).flat_map(|y| around(x).map(move |x| (x, y)));
            let most_beside = beside.map(|(x, y)| root(face, x, y)).fold(0.0, f64::max);
            root(face, x, y).max(0.5 * most_beside)
        };
        (most > 0.0).then(|| Self { weights: (0..shares.len()).map(widened).collect() })
    }

    /// Weight of a place on a face, in [-1, 1]: bilinear within the face.
    fn weight(&self, face: usize, s: f64, t: f64) -> f64 {
        let at = |place: f64| (0.5 * (place + 1.0) * SIZE as f64 - 0.5).clamp(0.0, (SIZE - 1) as f64);
        let (x, y) = (at(s), at(t));
        let (x0, y0) = (x as usize, y as usize);
        let (x1, y1) = ((x0 + 1).min(SIZE - 1), (y0 + 1).min(SIZE - 1));
        let texel = |x: usize, y: usize| self.weights[face * SIZE * SIZE + y * SIZE + x];
        let (fx, fy) = (x - x0 as f64, y - y0 as f64);
        let row = |y| (1.0 - fx) * texel(x0, y) + fx * texel(x1, y);
        (1.0 - fy) * row(y0) + fy * row(y1)
    }

    /// What of a map arrives.
    pub(super) fn weighted(&self, faces: &Faces) -> Faces {
        let middle = |index: usize| faces.edge(index) + 1.0 / faces.size as f64;
        let weights = |face: usize| {
            (0..faces.size * faces.size)
                .map(move |texel| self.weight(face, middle(texel % faces.size), middle(texel / faces.size)))
        };
        Faces {
            size: faces.size,
            solid_angle: faces.solid_angle.clone(),
            flux: std::array::from_fn(|face| {
                faces.flux[face].iter().zip(weights(face)).map(|(flux, weight)| flux * weight).collect()
            }),
            moments: std::array::from_fn(|face| {
                faces.moments[face]
                    .iter()
                    .zip(weights(face))
                    .map(|(moments, weight)| moments.lit(weight))
                    .collect()
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use gnomon_envmap::Equirect;
    use gnomon_picture::RgbImage;

    use super::super::{FitOptions, by_name};
    use super::*;

    /// A window about +x; a quarter of the receivers that see its half towards +z see the other half.
    fn window() -> Arrival {
        let arrives: Vec<f64> = (0..Arrival::DIRECTIONS)
            .map(|index| {
                let towards = Arrival::direction(index, Vec2::splat(0.5)).normalize();
                match towards.x > 0.9 {
                    true if towards.z > 0.0 => 1.0,
                    true => 0.25,
                    false => 0.0,
                }
            })
            .collect();
        Arrival::of_interior(&arrives, &vec![1.0; Arrival::DIRECTIONS]).unwrap()
    }

    #[test]
    fn open_scenes_are_no_interiors() {
        let ones = vec![1.0; Arrival::DIRECTIONS];
        assert!(Arrival::of_interior(&ones, &ones).is_none());
        assert!(Arrival::of_interior(&vec![0.55; Arrival::DIRECTIONS], &ones).is_none());
        assert!(Arrival::of_interior(&vec![0.0; Arrival::DIRECTIONS], &ones).is_none(), "nothing arrives");
        assert!(
            Arrival::of_interior(&vec![0.0; Arrival::DIRECTIONS], &vec![0.0; Arrival::DIRECTIONS]).is_none()
        );
    }

    #[test]
    fn lights_go_to_the_window_with_the_radiance_of_the_map() {
        let map = Equirect::new(RgbImage::from_fn(128, 64, |x, y| {
            Vec3::new(1.0 + 0.5 * (0.3 * x as f32).sin(), 1.0, 0.5 + 0.01 * y as f32)
        }));
        for method in ["partition", "optimized"] {
            let fitted = |arrival| {
                let options = FitOptions { light_count: Some(48), arrival, ..FitOptions::default() };
                by_name(method, &options).unwrap().fit(&map).unwrap().lights
            };
            let within = |lights: &[crate::DistantLight]| {
                lights
                    .iter()
                    .filter(|light| light.direction.x > 0.85)
                    .map(|light| light.flux())
                    .collect::<Vec<_>>()
            };
            let (plain, seen) = (fitted(None), fitted(Some(std::sync::Arc::new(window()))));
            assert!(within(&plain).len() < 8, "{method}");
            assert!(within(&seen).len() > 24, "{method}: {}", within(&seen).len());
            // The light of the window is the map's, not what a weight has left of it, and with it that of two texels around at most.
            let flux = within(&seen).iter().sum::<glam::DVec3>().y / (0.1 * std::f64::consts::TAU);
            assert!((0.95..2.0).contains(&flux), "{method}: {flux}");
            let side = |sign: f32| {
                let lights =
                    seen.iter().filter(|light| light.direction.x > 0.85 && sign * light.direction.z > 0.0);
                lights.map(|light| light.flux().y).sum::<f64>()
            };
            // Where less of it arrives cells are wider, and those at the edge hold what lies beside it.
            assert!((0.7..1.5).contains(&(side(-1.0) / side(1.0))), "{method}: {}", side(-1.0) / side(1.0));
        }
    }
}
