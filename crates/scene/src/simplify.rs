//! Coarser triangles over a mesh's own vertices, for whatever cannot tell them apart: shadow maps.

use std::ops::AddAssign;

use glam::{DVec3, IVec3, Vec3Swizzles};

use crate::parts::{first_vertices, root_of};
use crate::{Bounds, Mesh};

/// Deviation of the finest triangles, as a share of the longest side of the box around the mesh, and of the coarsest.
const FINEST: f64 = 1.0 / 2048.0;
const COARSEST: f64 = 1.0 / 64.0;

/// From one to the next, deviations grow by this factor, and cells.
const COARSER: f64 = std::f64::consts::SQRT_2;

/// Triangles that are more than this share of those before them are not worth their memory.
const WORTH: f64 = 0.75;

/// Vertices whose triangles' mean normal is shorter than this stay apart: they lie around something thin, that would vanish. The corner of
/// a box has 0.58.
const LEAST_MEAN_NORMAL: f64 = 0.5;

/// There are no coarser triangles once a connected part has less than this share of its area.
const LEAST_AREA: f64 = 0.85;

/// A larger grid is tried as long as the one before left out this share of the triangles.
const PROGRESS: f64 = 0.02;

/// A mesh of fewer triangles is drawn as it is.
const FEW_TRIANGLES: usize = 1024;

/// Weight of the distance to the triangles' middles beside that to their planes: it decides where all vertices of a flat region lie in
/// its plane, and is small enough not to count as a deviation.
const MIDDLE: f64 = 1e-6;

/// A mesh's triangles with vertices merged.
#[derive(Clone, Debug, PartialEq)]
pub struct SimplerTriangles {
    /// Root mean square distance between a vertex and the planes of all triangles that it stands for, at most, in the mesh's
    /// space [m]. The middle of a triangle lies up to four times as far from a curved surface.
    pub deviation: f32,
    /// Indices of the mesh's vertices.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// Ever coarser triangles, the finest first: vertices that hang together within a cell of a grid become that one of them which lies nearest
    /// to the planes of all their triangles, where it lies near enough (the clusters of Rossignac and Borrel 1993 with the quadrics of Garland and
    /// Heckbert 1997). Sheets that only lie close to each other stay apart, open edges stay as they are, so that neighbouring meshes
    /// still meet, and what is thin does not vanish. None for a mesh of few triangles. Morph targets and joints are not looked at.
    pub fn simplifications(&self) -> Vec<SimplerTriangles> {
        let mut found: Vec<SimplerTriangles> = Vec::new();
        let mut left = self.triangles.len();
        let used = self.triangles.iter().flatten().map(|v| self.positions[*v as usize]);
        let Some(around) = Bounds::around(used) else { return found };
        let longest_side = f64::from((around.max - around.min).max_element());
        if left < FEW_TRIANGLES || !longest_side.is_finite() {
            return found;
        }
        let mut clusters = Clusters::new(self);
        let mut deviation = FINEST * longest_side;
        while left >= FEW_TRIANGLES && deviation < COARSEST * longest_side {
            clusters.simplify(deviation, longest_side);
            if clusters.least_area_left() < LEAST_AREA {
                break;
            }
            if clusters.triangles.len() as f64 <= WORTH * left as f64 {
                left = clusters.triangles.len();
                found.push(SimplerTriangles { deviation: deviation as f32, triangles: clusters.triangles() });
            }
            deviation *= COARSER;
        }
        found
    }
}

/// Vertices that stand for those merged into them, and what is left of the triangles.
struct Clusters {
    vertices: Vec<Vertex>,
    /// Places in `vertices`.
    triangles: Vec<[u32; 3]>,
    /// Number of grids so far.
    grids: u32,
    /// Area of every connected part of the mesh.
    areas: Vec<f64>,
}

#[derive(Clone, Copy)]
struct Vertex {
    /// Index in the mesh.
    index: u32,
    /// From the least corner of the mesh's box.
    position: DVec3,
    quadric: Quadric,
    /// Lies on an edge that one triangle or more than two have.
    is_fixed: bool,
    /// Its connected part.
    part: u32,
}

/// Vertices that may become one.
struct Group {
    quadric: Quadric,
    /// Of the vertex chosen to stand for all, weighted by areas.
    squares: f64,
    chosen: usize,
}

/// In no group.
const ALONE: usize = usize::MAX;

impl Clusters {
    fn new(mesh: &Mesh) -> Self {
        let first = first_vertices(&mesh.positions);
        let triangles = mesh.triangles.iter().map(|triangle| triangle.map(|v| first[v as usize] as u32));
        let triangles: Vec<[u32; 3]> = triangles.filter(has_area).collect();
        let corner = Bounds::around(mesh.positions.iter().copied()).map_or(DVec3::ZERO, |b| b.min.as_dvec3());
        let mut parts = first;
        for triangle in &triangles {
            let [a, b, c] = triangle.map(|v| root_of(&mut parts, v as usize));
            parts[b] = a;
            let c = root_of(&mut parts, c);
            parts[c] = a;
        }
        let parts: Vec<usize> = (0..parts.len()).map(|v| root_of(&mut parts, v)).collect();
        let vertex = |(index, position): (usize, &glam::Vec3)| Vertex {
            index: index as u32,
            position: position.as_dvec3() - corner,
            quadric: Quadric::ZERO,
            is_fixed: false,
            part: parts[index] as u32,
        };
        let vertices = mesh.positions.iter().enumerate().map(vertex).collect();
        let mut clusters = Self { vertices, triangles, grids: 0, areas: Vec::new() };
        for triangle in &clusters.triangles {
            let quadric = Quadric::of_triangle(triangle.map(|v| clusters.vertices[v as usize].position));
            for v in triangle {
                clusters.vertices[*v as usize].quadric += quadric;
            }
        }
        clusters.fix_open_edges();
        clusters.areas = clusters.areas_of_parts(parts.len());
        clusters.drop_unused();
        clusters
    }

    /// An edge that is not two triangles' alone keeps its vertices.
    fn fix_open_edges(&mut self) {
        let key = |[a, b]: [u32; 2]| u64::from(a.min(b)) << 32 | u64::from(a.max(b));
        let mut edges: Vec<u64> = self.triangles.iter().flat_map(edges_of).map(key).collect();
        edges.sort_unstable();
        for same in edges.chunk_by(|a, b| a == b).filter(|same| same.len() != 2) {
            for v in [same[0] >> 32, same[0] & u64::from(u32::MAX)] {
                self.vertices[v as usize].is_fixed = true;
            }
        }
    }

    fn areas_of_parts(&self, count: usize) -> Vec<f64> {
        let mut areas = vec![0.0; count];
        for triangle in &self.triangles {
            let [a, b, c] = triangle.map(|v| self.vertices[v as usize].position);
            areas[self.vertices[triangle[0] as usize].part as usize] += 0.5 * (b - a).cross(c - a).length();
        }
        areas
    }

    /// Of its former area, what the part has that has lost most.
    fn least_area_left(&self) -> f64 {
        let now = self.areas_of_parts(self.areas.len());
        let left = now.iter().zip(&self.areas).filter(|(_, before)| **before > 0.0);
        left.map(|(now, before)| now / before).fold(f64::INFINITY, f64::min)
    }

    /// Indices of the mesh's vertices.
    fn triangles(&self) -> Vec<[u32; 3]> {
        self.triangles.iter().map(|triangle| triangle.map(|v| self.vertices[v as usize].index)).collect()
    }

    fn simplify(&mut self, deviation: f64, longest_side: f64) {
        let mut cell = self.mean_edge();
        while cell > 0.0 && cell <= 0.25 * longest_side {
            let before = self.triangles.len() as f64;
            self.merge(cell, deviation);
            if self.triangles.len() as f64 > (1.0 - PROGRESS) * before {
                break;
            }
            cell *= COARSER;
        }
    }

    fn mean_edge(&self) -> f64 {
        let place = |v: u32| self.vertices[v as usize].position;
        let lengths = self.triangles.iter().flat_map(edges_of).map(|[a, b]| place(a).distance(place(b)));
        lengths.sum::<f64>() / (3 * self.triangles.len()).max(1) as f64
    }

    /// Merges what hangs together within cells of a grid and deviates no more than that.
    fn merge(&mut self, cell: f64, deviation: f64) {
        // No two grids have their planes at the same places.
        self.grids += 1;
        let shift = (f64::from(self.grids) * std::f64::consts::SQRT_2).fract();
        let cells: Vec<IVec3> =
            self.vertices.iter().map(|v| (v.position / cell + shift).floor().as_ivec3()).collect();
        let mut parents: Vec<usize> = (0..self.vertices.len()).collect();
        for [a, b] in self.triangles.iter().flat_map(edges_of).map(|edge| edge.map(|v| v as usize)) {
            if cells[a] == cells[b] && !self.vertices[a].is_fixed && !self.vertices[b].is_fixed {
                let root = root_of(&mut parents, a);
                let other = root_of(&mut parents, b);
                parents[other] = root;
            }
        }
        // Most vertices are alone: only those that are not are looked at.
        let roots: Vec<usize> = (0..parents.len()).map(|v| root_of(&mut parents, v)).collect();
        let mut groups: Vec<Group> = Vec::new();
        let mut group_of = vec![ALONE; roots.len()];
        for (v, root) in roots.iter().enumerate().filter(|(v, root)| v != *root) {
            if group_of[*root] == ALONE {
                group_of[*root] = groups.len();
                groups.push(Group {
                    quadric: self.vertices[*root].quadric,
                    squares: f64::INFINITY,
                    chosen: v,
                });
            }
            group_of[v] = group_of[*root];
            groups[group_of[v]].quadric += self.vertices[v].quadric;
        }
        let grouped = || group_of.iter().copied().enumerate().filter(|(_, group)| *group != ALONE);
        for (v, group) in grouped() {
            let group = &mut groups[group];
            let squares = group.quadric.squared_distances(self.vertices[v].position);
            if squares < group.squares {
                (group.squares, group.chosen) = (squares, v);
            }
        }
        let mut stands_for: Vec<u32> = (0..roots.len() as u32).collect();
        for (v, group) in grouped() {
            let group = &groups[group];
            if group.squares <= deviation * deviation * group.quadric.area && !group.quadric.is_around() {
                stands_for[v] = group.chosen as u32;
                self.vertices[group.chosen].quadric = group.quadric;
            }
        }
        for triangle in &mut self.triangles {
            *triangle = triangle.map(|v| stands_for[v as usize]);
        }
        self.triangles.retain(has_area);
        self.drop_unused();
    }

    fn drop_unused(&mut self) {
        const UNUSED: u32 = u32::MAX;
        let mut places = vec![UNUSED; self.vertices.len()];
        let mut kept = Vec::new();
        for v in self.triangles.iter_mut().flatten() {
            let place = &mut places[*v as usize];
            if *place == UNUSED {
                *place = kept.len() as u32;
                kept.push(self.vertices[*v as usize]);
            }
            *v = *place;
        }
        self.vertices = kept;
    }
}

/// Sum of squared distances to planes, weighted by the triangles' areas.
#[derive(Clone, Copy, Debug)]
struct Quadric {
    /// The symmetric matrix: its diagonal, and yz, zx, xy.
    diagonal: DVec3,
    mixed: DVec3,
    linear: DVec3,
    constant: f64,
    area: f64,
    /// Sum of the triangles' normals, each as long as its area.
    normal: DVec3,
}

impl Quadric {
    const ZERO: Self = Self {
        diagonal: DVec3::ZERO,
        mixed: DVec3::ZERO,
        linear: DVec3::ZERO,
        constant: 0.0,
        area: 0.0,
        normal: DVec3::ZERO,
    };

    fn of_triangle([a, b, c]: [DVec3; 3]) -> Self {
        let across = (b - a).cross(c - a);
        let area = 0.5 * across.length();
        let (normal, middle) = (across.normalize_or_zero(), (a + b + c) / 3.0);
        let offset = -normal.dot(a);
        Self {
            diagonal: (normal * normal + MIDDLE) * area,
            mixed: normal.yzx() * normal.zxy() * area,
            linear: (offset * normal - MIDDLE * middle) * area,
            constant: (offset * offset + MIDDLE * middle.length_squared()) * area,
            area,
            normal: 0.5 * across,
        }
    }

    /// Whether the triangles lie around something rather than on one side of it.
    fn is_around(&self) -> bool {
        self.normal.length() < LEAST_MEAN_NORMAL * self.area
    }

    fn squared_distances(&self, p: DVec3) -> f64 {
        let mixed = self.mixed.dot(p.yzx() * p.zxy());
        self.diagonal.dot(p * p) + 2.0 * (mixed + self.linear.dot(p)) + self.constant
    }
}

impl AddAssign for Quadric {
    fn add_assign(&mut self, other: Self) {
        self.diagonal += other.diagonal;
        self.mixed += other.mixed;
        self.linear += other.linear;
        self.constant += other.constant;
        self.area += other.area;
        self.normal += other.normal;
    }
}

fn edges_of(triangle: &[u32; 3]) -> [[u32; 2]; 3] {
    let [a, b, c] = *triangle;
    [[a, b], [b, c], [c, a]]
}

fn has_area([a, b, c]: &[u32; 3]) -> bool {
    a != b && b != c && c != a
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use glam::Vec3;

    use super::*;

    /// A sphere of radius 1 of `2 * rows * rows` quadrilaterals, a seam and two poles of many vertices at the same place.
    fn sphere(rows: u32) -> Mesh {
        let columns = 2 * rows;
        let at = |row: u32, column: u32| {
            let polar = std::f32::consts::PI * row as f32 / rows as f32;
            let angle = std::f32::consts::TAU * (column % columns) as f32 / columns as f32;
            let radius = if row.is_multiple_of(rows) { 0.0 } else { polar.sin() };
            Vec3::new(radius * angle.cos(), polar.cos(), radius * angle.sin())
        };
        sheet(rows, columns, at)
    }

    /// A grid of vertices, each place of which is told by a function of row and column.
    fn sheet(rows: u32, columns: u32, at: impl Fn(u32, u32) -> Vec3) -> Mesh {
        let places = (0..=rows).flat_map(|row| (0..=columns).map(move |column| (row, column)));
        let positions = places.map(|(row, column)| at(row, column)).collect();
        let quads = (0..rows).flat_map(|row| (0..columns).map(move |column| row * (columns + 1) + column));
        let halves = |v: u32| [[v, v + columns + 1, v + 1], [v + 1, v + columns + 1, v + columns + 2]];
        Mesh { positions, triangles: quads.flat_map(halves).collect(), ..Mesh::default() }
    }

    fn corners<'a>(mesh: &'a Mesh, triangles: &'a [[u32; 3]]) -> impl Iterator<Item = [Vec3; 3]> + 'a {
        triangles.iter().map(|triangle| triangle.map(|v| mesh.positions[v as usize]))
    }

    #[test]
    fn a_sphere_stays_one_with_fewer_triangles() {
        let mesh = sphere(64);
        let levels = mesh.simplifications();
        let within = |deviation| levels.iter().rfind(|level| level.deviation <= deviation).unwrap();
        // 2108; a half more where not the nearest vertex of each cell stays.
        assert!(within(2.001 / 512.0).triangles.len() < 2500);
        let mut before = mesh.triangles.len();
        for SimplerTriangles { deviation, triangles } in &levels {
            assert!(triangles.len() as f64 <= WORTH * before as f64 && !triangles.is_empty());
            before = triangles.len();
            // Chords lie inside; how far, the deviation of their ends tells roughly.
            let deepest = corners(&mesh, triangles).map(|[a, b, c]| 1.0 - ((a + b + c) / 3.0).length());
            let deepest = deepest.fold(0.0, f32::max);
            assert!(deepest < 4.0 * deviation, "{deepest} {deviation}");
            let volume: f32 = corners(&mesh, triangles).map(|[a, b, c]| a.cross(b).dot(c) / 6.0).sum();
            let sphere = 4.0 / 3.0 * std::f32::consts::PI;
            assert!((volume.abs() / sphere - 1.0).abs() < 6.0 * deviation + 2e-3, "{volume} {deviation}");
            // Closed: at every edge as many triangles end as begin.
            let mut edges: BTreeMap<[u32; 2], i32> = BTreeMap::new();
            for [a, b] in triangles.iter().flat_map(edges_of) {
                *edges.entry([a.min(b), a.max(b)]).or_default() += if a < b { 1 } else { -1 };
            }
            assert!(edges.values().all(|count| *count == 0));
        }
    }

    #[test]
    fn what_is_flat_becomes_a_few_triangles_with_the_same_outline() {
        let mesh = sheet(40, 40, |row, column| Vec3::new(row as f32, 0.0, column as f32));
        let coarsest = mesh.simplifications().pop().unwrap();
        // The outline alone has 160 vertices.
        assert!(coarsest.triangles.len() < 400, "{}", coarsest.triangles.len());
        let area: f32 =
            corners(&mesh, &coarsest.triangles).map(|[a, b, c]| 0.5 * (b - a).cross(c - a).y).sum();
        assert!((area.abs() - 1600.0).abs() < 0.1, "{area}");
        let is_rim = |v: &u32| mesh.positions[*v as usize].to_array().contains(&40.0);
        let mut rim: Vec<u32> = coarsest.triangles.iter().flatten().copied().filter(is_rim).collect();
        rim.sort_unstable();
        rim.dedup();
        assert_eq!(rim.len(), 81);
    }

    #[test]
    fn a_crease_keeps_its_place() {
        let mesh =
            sheet(40, 40, |row, column| Vec3::new(row as f32, (column as f32 - 20.0).abs(), column as f32));
        for SimplerTriangles { deviation, triangles } in mesh.simplifications() {
            let lowest = |[a, b, c]: [Vec3; 3]| {
                let middle = (a + b + c) / 3.0;
                (middle.y - (middle.z - 20.0).abs()).abs()
            };
            let error = corners(&mesh, &triangles).map(lowest).fold(0.0, f32::max);
            assert!(error <= 2.0 * deviation, "{error} {deviation}");
        }
    }

    #[test]
    fn sheets_that_lie_close_to_each_other_stay_apart() {
        let mut mesh = sphere(32);
        let inner: Vec<Vec3> = mesh.positions.iter().map(|p| *p * 0.999).collect();
        let count = mesh.positions.len() as u32;
        let triangles = mesh.triangles.clone();
        mesh.positions.extend(inner);
        mesh.triangles.extend(triangles.iter().map(|triangle| triangle.map(|v| v + count)));
        let coarsest = mesh.simplifications().pop().unwrap();
        let sides = coarsest.triangles.iter().map(|triangle| triangle.map(|v| v < count));
        let [outer, inner]: [Vec<_>; 2] =
            [true, false].map(|side| sides.clone().filter(|s| *s == [side; 3]).collect());
        assert_eq!(outer.len() + inner.len(), coarsest.triangles.len());
        assert!(outer.len() > 50 && inner.len() > 50);
    }

    fn area(mesh: &Mesh, triangles: &[[u32; 3]]) -> f32 {
        corners(mesh, triangles).map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length()).sum()
    }

    /// Many copies of a mesh, turned and strewn over a cube of side 1.
    fn strewn(piece: &Mesh, count: u32) -> Mesh {
        let mut mesh = Mesh::default();
        for i in 0..count {
            let random =
                |k: u32| ((f64::from(i) + 0.5) * [0.7548, 0.5698, 0.3247, 0.8191][k as usize]).fract() as f32;
            let turn =
                glam::Quat::from_rotation_y(7.0 * random(3)) * glam::Quat::from_rotation_x(9.0 * random(0));
            let place = Vec3::from_array([0, 1, 2].map(random));
            let first = mesh.positions.len() as u32;
            mesh.positions.extend(piece.positions.iter().map(|p| turn * *p + place));
            mesh.triangles.extend(piece.triangles.iter().map(|triangle| triangle.map(|v| v + first)));
        }
        mesh
    }

    /// A cylinder of radius 1 and height 1 with caps, of so many sides: four make a box.
    fn cylinder(sides: u32) -> Mesh {
        let at = |row: u32, column: u32| {
            let angle = std::f32::consts::TAU * (column % sides) as f32 / sides as f32;
            let radius = if row.is_multiple_of(3) { 0.0 } else { 1.0 };
            Vec3::new(radius * angle.cos(), if row < 2 { 0.0 } else { 1.0 }, radius * angle.sin())
        };
        sheet(3, sides, at)
    }

    #[test]
    fn what_is_thin_does_not_vanish() {
        let scaled = |mesh: Mesh, scale: Vec3| Mesh {
            positions: mesh.positions.iter().map(|p| *p * scale).collect(),
            ..mesh
        };
        let both_sides = |mut mesh: Mesh| {
            let back: Vec<_> = mesh.triangles.iter().map(|[a, b, c]| [*c, *b, *a]).collect();
            mesh.triangles.extend(back);
            mesh
        };
        let flat = |cells: u32, side: f32| {
            sheet(cells, cells, |row, column| Vec3::new(row as f32, 0.0, column as f32) * side / cells as f32)
        };
        for (name, mesh) in [
            ("sheet", both_sides(flat(40, 1.0))),
            ("leaves", strewn(&both_sides(flat(1, 0.05)), 400)),
            ("plates", strewn(&scaled(cylinder(4), Vec3::new(0.01, 1e-4, 0.01)), 300)),
            ("thick plates", strewn(&scaled(cylinder(4), Vec3::new(0.01, 5e-4, 0.01)), 300)),
            ("needles", strewn(&scaled(sphere(16), Vec3::new(2e-4, 0.1, 2e-4)), 20)),
            ("wires", strewn(&scaled(cylinder(8), Vec3::new(2e-4, 0.2, 2e-4)), 100)),
            ("crumbs", strewn(&scaled(sphere(8), Vec3::splat(5e-4)), 20)),
        ] {
            let before = area(&mesh, &mesh.triangles);
            for SimplerTriangles { deviation, triangles } in mesh.simplifications() {
                let left = area(&mesh, &triangles) / before;
                assert!(left > 0.84, "{name}, {deviation}: {left}");
            }
        }
        // Of what hangs on a ball by one triangle each, the whole mesh's area does not tell.
        for (name, piece) in [
            ("thorn", scaled(sphere(16), Vec3::new(1e-3, 0.1, 1e-3))),
            ("scale", scaled(cylinder(4), Vec3::new(0.02, 2e-4, 0.02))),
        ] {
            let pieces = strewn(&piece, 40);
            let mut mesh = sphere(64);
            let [own, of_piece] = [&mesh, &piece].map(|mesh| mesh.positions.len() as u32);
            mesh.positions.extend(&pieces.positions);
            mesh.triangles.extend(pieces.triangles.iter().map(|triangle| triangle.map(|v| v + own)));
            mesh.triangles.extend((0..40).map(|i| own + i * of_piece).map(|v| [0, v, v + of_piece / 2]));
            for SimplerTriangles { deviation, triangles } in mesh.simplifications() {
                let of_pieces: Vec<[u32; 3]> =
                    triangles.iter().copied().filter(|t| t.iter().all(|v| *v >= own)).collect();
                let left = area(&mesh, &of_pieces) / area(&pieces, &pieces.triangles);
                assert!(left > 0.84, "{name}, {deviation}: {left}");
            }
        }
    }

    #[test]
    fn meshes_that_are_broken_or_small_come_to_an_end() {
        assert!(Mesh::default().simplifications().is_empty());
        assert!(sphere(8).simplifications().is_empty());
        let spoilt = |value: f32| {
            let mut mesh = sphere(32);
            mesh.positions.iter_mut().step_by(7).for_each(|p| p.x = value);
            mesh
        };
        for value in [f32::NAN, f32::INFINITY, f32::MAX, 1e-30] {
            let mesh = spoilt(value);
            let found = mesh.simplifications();
            let indices = found.iter().flat_map(|simpler| simpler.triangles.iter().flatten());
            assert!(indices.into_iter().all(|v| (*v as usize) < mesh.positions.len()), "{value}");
        }
        let mut point = sphere(32);
        point.positions.fill(Vec3::ONE);
        assert!(point.simplifications().is_empty());
    }
}
