//! Exact overlaps of small spherical patches with the texels of a cube map. On a face's plane great circles are straight
//! lines, so a patch is a convex quadrilateral there and is cut along the edges of the texels.

use glam::{DVec2, DVec3};

use crate::grid::CubeGrid;

/// A quadrilateral gains at most one corner with each of the eight lines that bound a face and a texel in it.
const MAX_CORNERS: usize = 12;

/// A convex polygon on a face's plane, in texels from the face's top left corner.
#[derive(Clone, Copy)]
struct Polygon {
    corners: [DVec2; MAX_CORNERS],
    count: usize,
}

impl Polygon {
    fn new(corners: &[DVec2; 4]) -> Self {
        let mut polygon = Self::EMPTY;
        polygon.corners[..4].copy_from_slice(corners);
        polygon.count = 4;
        polygon
    }

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

    /// Makes `below` and `above` the parts on either side of the line where coordinate `axis` is `at` (Sutherland and
    /// Hodgman 1974).
    fn split(&self, axis: usize, at: f64, below: &mut Self, above: &mut Self) {
        (below.count, above.count) = (0, 0);
        let Some(mut previous) = self.corners().last() else { return };
        for corner in self.corners() {
            let (from, to) = (previous[axis] - at, corner[axis] - at);
            if from * to < 0.0 {
                let crossing = *previous + (*corner - *previous) * (from / (from - to));
                below.push(crossing);
                above.push(crossing);
            }
            if to <= 0.0 {
                below.push(*corner);
            }
            if to >= 0.0 {
                above.push(*corner);
            }
            previous = corner;
        }
    }

    /// Keeps what lies between `low` and `high` in both coordinates.
    fn clip(&mut self, low: f64, high: f64) {
        let (mut kept, mut lost) = (Self::EMPTY, Self::EMPTY);
        for axis in 0..2 {
            self.split(axis, low, &mut lost, &mut kept);
            kept.split(axis, high, self, &mut lost);
        }
    }

    /// Whole numbers below the least and above the largest coordinate.
    fn span(&self, axis: usize) -> (usize, usize) {
        let coordinates = || self.corners().iter().map(|corner| corner[axis]);
        let wider = |(low, high), c| (f64::min(low, c), f64::max(high, c));
        let (low, high) = coordinates().fold((f64::MAX, 0.0), wider);
        // A float converts to an integer by clipping at 0.
        if self.count < 3 { (0, 0) } else { (low as usize, (high.ceil() as usize).max(low as usize + 1)) }
    }
}

/// Calls `add` with every texel of the cube that a patch overlaps, and the overlap's solid angle [sr].
pub(crate) fn overlaps(patch: [DVec3; 4], cube: &CubeGrid, mut add: impl FnMut(usize, f64)) {
    let faces = patch.map(face_of);
    if faces == [faces[0]; 4] {
        if let Some(corners) = project(faces[0], &patch, cube) {
            let cell = |corner: DVec2| (corner.x as usize, corner.y as usize);
            let first = cell(corners[0]);
            if corners[1..].iter().all(|&corner| cell(corner) == first) {
                emit(faces[0], first, &corners, cube, &mut add);
            } else {
                cut(&Polygon::new(&corners), faces[0], cube, &mut add);
            }
        }
        return;
    }
    let (low, high) = cube.range();
    for (index, &face) in faces.iter().enumerate() {
        if faces[..index].contains(&face) {
            continue;
        }
        if let Some(corners) = project(face, &patch, cube) {
            let mut polygon = Polygon::new(&corners);
            polygon.clip(low, high);
            cut(&polygon, face, cube, &mut add);
        }
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

/// The patch on a face's plane, in texels; `None` if it reaches behind the face.
fn project(face: usize, patch: &[DVec3; 4], cube: &CubeGrid) -> Option<[DVec2; 4]> {
    let (low, high) = cube.range();
    let half = 0.5 * (high - low);
    let mut in_front = true;
    let corners = patch.map(|d| {
        // The inverse of `CubeMap::point_on_face`.
        let (right, down, depth) = match face {
            0 => (d.z, -d.y, d.x),
            1 => (-d.z, -d.y, -d.x),
            2 => (d.x, -d.z, d.y),
            3 => (d.x, d.z, -d.y),
            4 => (-d.x, -d.y, d.z),
            _ => (d.x, -d.y, -d.z),
        };
        in_front &= depth > 0.0;
        let scale = half / depth;
        DVec2::new(right * scale, down * scale) + (half + low)
    });
    in_front.then_some(corners)
}

fn emit(
    face: usize,
    (x, y): (usize, usize),
    corners: &[DVec2],
    cube: &CubeGrid,
    add: &mut impl FnMut(usize, f64),
) {
    let Some((&origin, rest)) = corners.split_first() else { return };
    let triangle = |pair: &[DVec2]| (pair[0] - origin).perp_dot(pair[1] - origin);
    let area = 0.5 * rest.windows(2).map(triangle).sum::<f64>().abs();
    if area > 0.0 {
        let (low, high) = cube.range();
        let texel_size = 2.0 / (high - low);
        let middle = corners.iter().sum::<DVec2>() / corners.len() as f64;
        let length_squared = 1.0 + ((middle - low) * texel_size - 1.0).length_squared();
        // Solid angle of an area element at (s, t) on the plane z = 1: (1 + s^2 + t^2)^(-3/2).
        let density = 1.0 / (length_squared * length_squared.sqrt());
        add(cube.texel(face, x, y), area * texel_size * texel_size * density);
    }
}

/// Calls `take` with the parts of a polygon that lie between whole coordinates along `axis`, and the coordinate below. What
/// lies beyond the last edge by a rounding error belongs to the last part.
fn slice(polygon: &Polygon, axis: usize, mut take: impl FnMut(usize, &Polygon)) {
    let (first, end) = polygon.span(axis);
    if first + 1 == end {
        return take(first, polygon);
    }
    let (mut rest, mut below, mut above) = (*polygon, Polygon::EMPTY, Polygon::EMPTY);
    for index in first..end {
        if index + 1 < end {
            rest.split(axis, (index + 1) as f64, &mut below, &mut above);
            take(index, &below);
            std::mem::swap(&mut rest, &mut above);
        } else {
            take(index, &rest);
        }
    }
}

/// Cuts a polygon along the edges of texels.
fn cut(polygon: &Polygon, face: usize, cube: &CubeGrid, add: &mut impl FnMut(usize, f64)) {
    slice(polygon, 0, |x, column| {
        slice(column, 1, |y, cell| emit(face, (x, y), cell.corners(), cube, add));
    });
}
