//! Rectangles of even radiance in the place of a flat part: its picture.

use glam::{DVec3, UVec2, Vec2, Vec3};

/// Bins of a picture along its longer side, and places that are looked at along a side of each.
const BINS: u32 = 64;
const PLACES: u32 = 2;

/// A picture is even where the root mean square of what its rectangles leave is below this share of its mean.
const EVEN: f64 = 0.03;

/// Part of a rectangle, from its lower left corner, in shares of its sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cell {
    pub min: Vec2,
    pub max: Vec2,
    /// Mean over it.
    pub radiance: Vec3,
}

/// Radiance of bins of one size, row by row from the lower left.
pub(super) struct Picture {
    size: UVec2,
    bins: Vec<DVec3>,
}

/// Bins of a picture, the end excluded.
#[derive(Clone, Copy)]
struct Piece {
    from: UVec2,
    to: UVec2,
}

/// Of some bins: number, sum and sum of squares.
#[derive(Clone, Copy, Default)]
struct Sums {
    count: f64,
    sum: DVec3,
    squares: f64,
}

impl Sums {
    fn and(self, other: Self) -> Self {
        Self {
            count: self.count + other.count,
            sum: self.sum + other.sum,
            squares: self.squares + other.squares,
        }
    }

    fn without(self, part: Self) -> Self {
        Self {
            count: self.count - part.count,
            sum: self.sum - part.sum,
            squares: self.squares - part.squares,
        }
    }

    /// Sum of squared differences from the mean.
    fn spread(&self) -> f64 {
        (self.squares - self.sum.length_squared() / self.count.max(1.0)).max(0.0)
    }
}

impl Picture {
    /// Of a rectangle of this size, by the radiance at shares of its sides.
    pub fn new(size: Vec2, radiance: impl Fn(Vec2) -> Vec3) -> Self {
        let bins = (BINS as f32 * size / size.max_element()).ceil().as_uvec2().max(UVec2::ONE);
        let at = |bin: UVec2| {
            let places = (0..PLACES * PLACES).map(|i| UVec2::new(i % PLACES, i / PLACES));
            let share =
                |place: UVec2| (bin.as_vec2() + (place.as_vec2() + 0.5) / PLACES as f32) / bins.as_vec2();
            places.map(|place| radiance(share(place)).as_dvec3()).sum::<DVec3>() / f64::from(PLACES * PLACES)
        };
        let places = (0..bins.y).flat_map(|y| (0..bins.x).map(move |x| UVec2::new(x, y)));
        Self { size: bins, bins: places.map(at).collect() }
    }

    /// Mean over all of it.
    pub fn mean(&self) -> Vec3 {
        (self.sums(self.whole()).sum / self.bins.len() as f64).as_vec3()
    }

    fn whole(&self) -> Piece {
        Piece { from: UVec2::ZERO, to: self.size }
    }

    fn sums(&self, Piece { from, to }: Piece) -> Sums {
        let rows = (from.y..to.y).map(|y| (y * self.size.x) as usize);
        let bins = rows.flat_map(|row| &self.bins[row + from.x as usize..row + to.x as usize]);
        bins.fold(Sums::default(), |sums, bin| {
            sums.and(Sums { count: 1.0, sum: *bin, squares: bin.length_squared() })
        })
    }

    /// At most so many rectangles that together are the picture: the one in which radiance spreads most is cut where that leaves least,
    /// until all is even.
    pub fn cells(&self, most: usize) -> Vec<Cell> {
        let all = self.sums(self.whole());
        let even = (EVEN * all.sum.length() / all.count).powi(2) * all.count;
        let mut pieces = vec![(self.whole(), self.best_cut(self.whole()))];
        while pieces.len() < most {
            let spread: f64 = pieces.iter().map(|(piece, _)| self.sums(*piece).spread()).sum();
            let gains = pieces.iter().enumerate().filter_map(|(i, (_, cut))| Some((i, cut.as_ref()?.1)));
            let Some((index, _)) = gains.max_by(|a, b| a.1.total_cmp(&b.1)).filter(|_| spread > even) else {
                break;
            };
            if let (_, Some((parts, _))) = pieces.swap_remove(index) {
                pieces.extend(parts.map(|part| (part, self.best_cut(part))));
            }
        }
        let share = |bin: UVec2| bin.as_vec2() / self.size.as_vec2();
        let cell = |(piece, _): &(Piece, _)| {
            let Sums { count, sum, .. } = self.sums(*piece);
            Cell { min: share(piece.from), max: share(piece.to), radiance: (sum / count).as_vec3() }
        };
        pieces.iter().map(cell).collect()
    }

    /// The two parts that leave least, and by how much less that is; `None` for a single bin.
    fn best_cut(&self, piece: Piece) -> Option<([Piece; 2], f64)> {
        let all = self.sums(piece);
        let cuts = [UVec2::X, UVec2::Y].into_iter().flat_map(|axis| {
            let mut before = Sums::default();
            let (first, last) = ((piece.from * axis).element_sum(), (piece.to * axis).element_sum());
            (first + 1..last).map(move |at| {
                let place = |corner: UVec2, at: u32| corner * (UVec2::ONE - axis) + axis * at;
                let slice = Piece { from: place(piece.from, at - 1), to: place(piece.to, at) };
                before = before.and(self.sums(slice));
                let parts = [
                    Piece { to: place(piece.to, at), ..piece },
                    Piece { from: place(piece.from, at), ..piece },
                ];
                (parts, all.spread() - before.spread() - all.without(before).spread())
            })
        });
        cuts.max_by(|a, b| a.1.total_cmp(&b.1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_are_told_apart_and_keep_their_light() {
        let picture =
            Picture::new(Vec2::new(2.0, 1.0), |at| if at.x < 0.25 { Vec3::X * 8.0 } else { Vec3::Y });
        let cells = picture.cells(16);
        assert_eq!(cells.len(), 2, "{cells:?}");
        let left = cells.iter().find(|cell| cell.min == Vec2::ZERO).unwrap();
        assert!((left.max - Vec2::new(0.25, 1.0)).length() < 1e-6 && (left.radiance.x - 8.0).abs() < 1e-5);
        assert!((picture.mean() - Vec3::new(2.0, 0.75, 0.0)).length() < 1e-5);
    }

    #[test]
    fn a_ramp_becomes_as_many_as_there_may_be_and_all_of_it() {
        let picture = Picture::new(Vec2::ONE, |at| Vec3::splat(at.x + at.y * at.y));
        let cells = picture.cells(12);
        let area = |cell: &Cell| (cell.max - cell.min).element_product();
        let flux: Vec3 = cells.iter().map(|cell| cell.radiance * area(cell)).sum();
        assert_eq!(cells.len(), 12);
        assert!((cells.iter().map(area).sum::<f32>() - 1.0).abs() < 1e-5);
        assert!((flux - picture.mean()).length() < 1e-5);
        let even = Picture::new(Vec2::ONE, |_| Vec3::ONE);
        assert_eq!(even.cells(16).len(), 1);
    }
}
