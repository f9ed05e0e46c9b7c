//! Exact overlaps of small spherical patches with the texels of a cube map. On a face's plane great circles are straight
//! lines, so a patch is a convex quadrilateral there and is cut along the edges of the texels.

use glam::{DVec2, DVec3};

use crate::grid::CubeGrid;

/// A quadrilateral gains at most one corner with each of the eight lines that bound a face and a texel in it.
const MAX_CORNERS: usize = 16;

/// A convex polygon on a face's plane, in texels from the face's top left corner.
#[derive(Clone, Copy)]
struct Polygon {
    corners: [DVec2; MAX_CORNERS],
    count: usize,
}

impl Polygon {
    const EMPTY: Self = Self { corners: [DVec2::ZERO; MAX_CORNERS], count: 0 };

    fn push(&mut self, corner: DVec2) {
        if self.count < MAX_CORNERS {
            self.corners[self.count] = corner;
            self.count += 1;
        }
    }

    fn corners(&self) -> &[DVec2] {
        &self.corners[..self.count]
    }

    /// Parts below and above the line where coordinate `axis` is `at` (Sutherland and Hodgman 1974).
    fn split(&self, axis: usize, at: f64) -> (Self, Self) {
        let (mut below, mut above) = (Self::EMPTY, Self::EMPTY);
        let Some(&last) = self.corners().last() else { return (below, above) };
        let mut previous = last;
        for &corner in self.corners() {
            let (from, to) = (previous[axis] - at, corner[axis] - at);
            if from * to < 0.0 {
                let crossing = previous + (corner - previous) * (from / (from - to));
                below.push(crossing);
                above.push(crossing);
            }
            if to <= 0.0 {
                below.push(corner);
            }
            if to >= 0.0 {
                above.push(corner);
            }
            previous = corner;
        }
        (below, above)
    }

    fn area(&self) -> f64 {
        let Some(&origin) = self.corners().first() else { return 0.0 };
        let triangle = |pair: &[DVec2]| (pair[0] - origin).perp_dot(pair[1] - origin);
        0.5 * self.corners().windows(2).map(triangle).sum::<f64>().abs()
    }

    fn middle(&self) -> DVec2 {
        self.corners().iter().sum::<DVec2>() / self.count.max(1) as f64
    }

    /// Whole numbers below the least and above the largest coordinate.
    fn span(&self, axis: usize) -> (usize, usize) {
        let coordinates = || self.corners().iter().map(|corner| corner[axis]);
        let (low, high) =
            coordinates().fold((f64::MAX, 0.0), |(low, high), c| (f64::min(low, c), f64::max(high, c)));
        // A float converts to an integer by clipping at 0.
        (low as usize, (high.ceil() as usize).max(low as usize + 1))
    }
}

/// Calls `add` with every texel of the cube that a patch overlaps, and the overlap's solid angle [sr].
pub(crate) fn overlaps(patch: [DVec3; 4], cube: &CubeGrid, mut add: impl FnMut(usize, f64)) {
    let faces = patch.map(face_of);
    for (index, &face) in faces.iter().enumerate() {
        if faces[..index].contains(&face) {
            continue;
        }
        let whole = faces.iter().all(|&other| other == face);
        let Some(polygon) = project(face, &patch, cube, whole) else { continue };
        cut(polygon, face, cube, &mut add);
    }
}

fn face_of(direction: DVec3) -> usize {
    let a = direction.abs();
    let (axis, value) = if a.x >= a.y && a.x >= a.z {
        (0, direction.x)
    } else if a.y >= a.z {
        (2, direction.y)
    } else {
        (4, direction.z)
    };
    axis + usize::from(value < 0.0)
}

/// The patch on a face's plane, clipped to the face unless it is known to lie on it as a `whole`.
fn project(face: usize, patch: &[DVec3; 4], cube: &CubeGrid, whole: bool) -> Option<Polygon> {
    let (low, high) = cube.range();
    let mut polygon = Polygon::EMPTY;
    for d in patch {
        // The inverse of `CubeMap::point_on_face`.
        let (right, down, depth) = match face {
            0 => (d.z, -d.y, d.x),
            1 => (-d.z, -d.y, -d.x),
            2 => (d.x, -d.z, d.y),
            3 => (d.x, d.z, -d.y),
            4 => (-d.x, -d.y, d.z),
            _ => (d.x, -d.y, -d.z),
        };
        if depth <= 0.0 {
            return None;
        }
        polygon.push((DVec2::new(right, down) / depth + 1.0) * (0.5 * (high - low)) + low);
    }
    if !whole {
        for axis in 0..2 {
            polygon = polygon.split(axis, low).1.split(axis, high).0;
        }
    }
    Some(polygon)
}

/// Cuts a polygon along the edges of texels.
fn cut(polygon: Polygon, face: usize, cube: &CubeGrid, add: &mut impl FnMut(usize, f64)) {
    let (low, high) = cube.range();
    let texel_size = 2.0 / (high - low);
    let mut emit = |x: usize, y: usize, piece: &Polygon| {
        let area = piece.area();
        if area > 0.0 {
            let middle = (piece.middle() - low) * texel_size - 1.0;
            // Solid angle of an area element at (s, t) on the plane z = 1.
            let density = (1.0 + middle.length_squared()).powi(3).sqrt().recip();
            add(cube.texel(face, x, y), area * texel_size * texel_size * density);
        }
    };
    let (first_x, end_x) = polygon.span(0);
    let mut rest = polygon;
    for x in first_x..end_x {
        let column = if x + 1 < end_x {
            let (below, above) = rest.split(0, (x + 1) as f64);
            rest = above;
            below
        } else {
            rest
        };
        if column.count < 3 {
            continue;
        }
        let (first_y, end_y) = column.span(1);
        let mut rest = column;
        for y in first_y..end_y {
            if y + 1 < end_y {
                let (below, above) = rest.split(1, (y + 1) as f64);
                rest = above;
                emit(x, y, &below);
            } else {
                emit(x, y, &rest);
            }
        }
    }
}
