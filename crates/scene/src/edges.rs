//! Edges between a mesh's triangles, and what kind of surface these make: what shadows from geometry are made of.
//!
//! Triangles that face a light bound what it does not see. Seen from the light they may be counted on any mesh, whatever is wrong with it;
//! only how the two sides of a surface add up depends on what the surface is ([`SurfaceKind`]).

use glam::DVec3;

use crate::Mesh;
use crate::parts::{first_vertices, root_of};

/// Where a surface is open but the sum of its triangles' area vectors is at most this share of their areas, it is a shell around something:
/// that sum is 0 for a closed surface, and as large as the areas for a flat one.
const SHELL: f64 = 0.1;

/// The same from which on an open surface is flat, so that no part of it lies behind another.
const FLAT: f64 = 0.999;

/// How the sides of a connected surface block light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SurfaceKind {
    /// Its outer side, and as well its inner side, covers all that it blocks: the one that covers more counts. Exact for closed surfaces,
    /// where both cover the same; what is meant for shells with holes.
    Solid,
    /// Every triangle blocks light from both sides. Where the surface lies behind itself it counts twice.
    Sheet,
}

/// A triangle of a mesh as an edge sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wing {
    /// Index into the mesh's triangles.
    pub triangle: u32,
    /// The edge runs from this corner of it to the next.
    pub corner: u32,
}

/// An edge with one triangle or two. Where more meet, there are several edges in one place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    /// The edge runs in the sense of this triangle.
    pub first: Wing,
    /// `None` at an open end.
    pub second: Option<Wing>,
    /// Whether it runs in the sense of the second one, too: one of them is inside out.
    pub same_sense: bool,
}

/// What a triangle is part of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Side {
    /// Of its surface.
    pub kind: SurfaceKind,
    /// Whether it has to be turned to agree with most others of its surface.
    pub is_turned: bool,
}

/// The edges of a mesh. Vertices in one place count as one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshEdges {
    /// In no order.
    pub edges: Vec<Edge>,
    /// Of every triangle.
    pub sides: Vec<Side>,
    /// What is wrong with it.
    pub faults: EdgeFaults,
}

/// What keeps a mesh from being closed and wound consistently. Flat surfaces are left out: nothing is wrong with those.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EdgeFaults {
    /// Edges of one triangle.
    pub open: usize,
    /// Edges where more than two triangles meet and do not make pairs.
    pub forked: usize,
    /// Triangles that are inside out.
    pub turned: usize,
    /// Surfaces of which both sides block light by themselves.
    pub sheets: usize,
}

impl EdgeFaults {
    /// Whether there are none.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }
}

impl std::fmt::Display for EdgeFaults {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let counts = [
            (self.open, "edges of one triangle"),
            (self.forked, "edges of three or more"),
            (self.turned, "triangles inside out"),
        ];
        let parts: Vec<String> =
            counts.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{n} {what}")).collect();
        let treated = if self.sheets > 0 { "both sides of it block light" } else { "it counts as closed" };
        write!(f, "{}: {treated}", parts.join(", "))
    }
}

/// A triangle's side by the vertices at its ends.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct HalfEdge {
    ends: [u32; 2],
    is_reversed: bool,
    triangle: u32,
    corner: u32,
}

impl HalfEdge {
    fn wing(self) -> Wing {
        Wing { triangle: self.triangle, corner: self.corner }
    }
}

impl Mesh {
    /// Its edges. Triangles with two corners in one place have fewer.
    pub fn edges(&self) -> MeshEdges {
        let half_edges = half_edges(self);
        let groups = || half_edges.chunk_by(|a, b| a.ends == b.ends);
        let mut surfaces = Surfaces::new(self.triangles.len());
        let mut edges = Vec::with_capacity(half_edges.len() / 2);
        for group in groups() {
            // Those that run one way come first: what remains when they are paired with the others runs the same way.
            let (forth, back) = group.split_at(group.partition_point(|half| !half.is_reversed));
            let paired = forth.len().min(back.len());
            let pairs = forth.iter().zip(back).map(|(&a, &b)| (a, Some(b), false));
            let rest = forth[paired..].iter().chain(&back[paired..]);
            let rest = rest.collect::<Vec<_>>();
            let rest = rest.chunks(2).map(|two| (*two[0], two.get(1).map(|half| **half), true));
            for (first, second, same_sense) in pairs.chain(rest) {
                let same_sense = same_sense && second.is_some();
                edges.push(Edge { first: first.wing(), second: second.map(HalfEdge::wing), same_sense });
            }
            // Of two triangles that run the same way along their edge one is inside out. Of more nobody knows: they are what they are given as.
            for pair in group.windows(2) {
                let is_turned = group.len() == 2 && pair[0].is_reversed == pair[1].is_reversed;
                surfaces.join(pair[0].triangle, pair[1].triangle, is_turned);
            }
        }
        let (sides, faults) = surfaces.sides(self, groups());
        MeshEdges { edges, sides, faults }
    }
}

/// All sides of triangles, those between the same places behind one another.
fn half_edges(mesh: &Mesh) -> Vec<HalfEdge> {
    let places = first_vertices(&mesh.positions);
    let mut half_edges = Vec::with_capacity(3 * mesh.triangles.len());
    for (triangle, vertices) in (0..).zip(&mesh.triangles) {
        let corners = vertices.map(|vertex| places[vertex as usize] as u32);
        for corner in 0..3u32 {
            let [from, to] = [corner, (corner + 1) % 3].map(|i| corners[i as usize]);
            if from != to {
                let (ends, is_reversed) = ([from.min(to), from.max(to)], from > to);
                half_edges.push(HalfEdge { ends, is_reversed, triangle, corner });
            }
        }
    }
    half_edges.sort_unstable();
    half_edges
}

/// Triangles that hang together, in a union-find forest of nodes of which each triangle has two: itself and itself turned. What joins two
/// triangles joins the nodes that agree; a surface that has no two sides joins both nodes of each.
struct Surfaces {
    parents: Vec<usize>,
}

/// What is summed of a connected surface, by the root of one of its triangles' nodes.
#[derive(Clone, Copy, Default)]
struct Sums {
    triangles: usize,
    turned: usize,
    area: f64,
    area_vector: DVec3,
    open: usize,
    forked: usize,
}

impl Surfaces {
    fn new(triangles: usize) -> Self {
        Self { parents: (0..2 * triangles).collect() }
    }

    fn join(&mut self, a: u32, b: u32, turned: bool) {
        for side in [0, 1] {
            let root_a = root_of(&mut self.parents, 2 * a as usize + side);
            let root_b = root_of(&mut self.parents, 2 * b as usize + (side ^ usize::from(turned)));
            // The earlier one stays: which side is the outer one is then up to the first triangle.
            let (low, high) = (root_a.min(root_b), root_a.max(root_b));
            self.parents[high] = low;
        }
    }

    /// The lower one of a triangle's roots stands for its surface; whether that is the root of its turned node; and whether
    /// both are the same, so that the surface has no two sides.
    fn place(&mut self, triangle: usize) -> (usize, bool, bool) {
        let roots = [2 * triangle, 2 * triangle + 1].map(|node| root_of(&mut self.parents, node));
        (roots[0].min(roots[1]), roots[1] < roots[0], roots[0] == roots[1])
    }

    fn sides<'a>(
        mut self,
        mesh: &Mesh,
        groups: impl Iterator<Item = &'a [HalfEdge]>,
    ) -> (Vec<Side>, EdgeFaults) {
        let mut sums = vec![Sums::default(); self.parents.len()];
        for (index, triangle) in mesh.triangles.iter().enumerate() {
            let (root, is_turned, _) = self.place(index);
            let [a, b, c] = triangle.map(|vertex| mesh.positions[vertex as usize].as_dvec3());
            let area = (b - a).cross(c - a);
            let sum = &mut sums[root];
            sum.triangles += 1;
            sum.turned += usize::from(is_turned);
            if area.is_finite() {
                sum.area += area.length();
                sum.area_vector += if is_turned { -area } else { area };
            }
        }
        for group in groups {
            let mut balance = 0i64;
            for half in group {
                let (_, is_turned, _) = self.place(half.triangle as usize);
                balance += if is_turned == half.is_reversed { 1 } else { -1 };
            }
            let sum = &mut sums[self.place(group[0].triangle as usize).0];
            match (balance, group.len()) {
                (0, _) => {}
                (_, 1) => sum.open += 1,
                _ => sum.forked += 1,
            }
        }
        let mut faults = EdgeFaults::default();
        let mut sides = Vec::with_capacity(mesh.triangles.len());
        for index in 0..mesh.triangles.len() {
            let (root, is_turned, is_one_sided) = self.place(index);
            let sum = &mut sums[root];
            let flatness = sum.area_vector.length() / sum.area.max(f64::MIN_POSITIVE);
            let is_closed = sum.open + sum.forked == 0 && !is_one_sided;
            let is_shell = !is_one_sided && flatness <= SHELL;
            let kind = if is_closed || is_shell { SurfaceKind::Solid } else { SurfaceKind::Sheet };
            if sum.triangles > 0 {
                // Once a surface.
                let is_flat = !is_one_sided && flatness >= FLAT;
                faults.turned += sum.turned.min(sum.triangles - sum.turned);
                if !is_closed && !is_flat {
                    faults.open += sum.open;
                    faults.forked += sum.forked;
                    faults.sheets += usize::from(kind == SurfaceKind::Sheet);
                }
                sum.triangles = 0;
            }
            sides.push(Side { kind, is_turned });
        }
        (sides, faults)
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::builtin::by_name;

    fn tetrahedron() -> Mesh {
        Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z],
            triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
            ..Mesh::default()
        }
    }

    fn kinds(mesh: &Mesh) -> (Vec<SurfaceKind>, EdgeFaults) {
        let MeshEdges { sides, faults, .. } = mesh.edges();
        (sides.iter().map(|side| side.kind).collect(), faults)
    }

    #[test]
    fn a_closed_surface_has_no_faults_however_its_vertices_are_split() {
        let mesh = tetrahedron();
        let MeshEdges { edges, sides, faults } = mesh.edges();
        assert!(faults.is_none() && edges.len() == 6);
        assert!(edges.iter().all(|edge| edge.second.is_some() && !edge.same_sense));
        assert!(sides.iter().all(|side| *side == Side { kind: SurfaceKind::Solid, is_turned: false }));
        let split = Mesh {
            positions: mesh.triangles.iter().flatten().map(|v| mesh.positions[*v as usize]).collect(),
            triangles: (0..4).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
            ..Mesh::default()
        };
        // In another order, and seen from the other wing first.
        let unordered = |edges: Vec<Edge>| {
            let wings = |edge: &Edge| {
                let [a, b] = [Some(edge.first), edge.second].map(|w| w.map(|w| (w.triangle, w.corner)));
                if a < b { (a, b) } else { (b, a) }
            };
            let mut wings: Vec<_> = edges.iter().map(wings).collect();
            wings.sort_unstable();
            wings
        };
        let of_split = split.edges();
        assert_eq!((of_split.sides, of_split.faults), (sides, faults));
        assert_eq!(unordered(of_split.edges), unordered(edges));
        for mesh in by_name("three-boxes").unwrap().meshes.iter().chain(&by_name("column").unwrap().meshes) {
            let edges = mesh.edges();
            assert!(edges.faults.is_none(), "{}", edges.faults);
        }
    }

    #[test]
    fn a_triangle_inside_out_is_turned() {
        let mut mesh = tetrahedron();
        mesh.triangles[2].swap(0, 1);
        let MeshEdges { edges, sides, faults } = mesh.edges();
        assert_eq!(faults, EdgeFaults { turned: 1, ..EdgeFaults::default() });
        assert_eq!(sides.iter().map(|side| side.is_turned).collect::<Vec<_>>(), [false, false, true, false]);
        assert_eq!(edges.iter().filter(|edge| edge.same_sense).count(), 3);
        assert!(faults.to_string().contains("1 triangles inside out"), "{faults}");
    }

    #[test]
    fn open_surfaces_are_shells_or_sheets() {
        let mut open = tetrahedron();
        open.triangles.truncate(3);
        let (open, faults) = kinds(&open);
        assert!(
            open.iter().all(|kind| *kind == SurfaceKind::Sheet) && faults.open == 3 && faults.sheets == 1
        );
        // A flat one blocks light from both sides, and nothing is wrong with it.
        let mut flat = Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        };
        assert_eq!(kinds(&flat), (vec![SurfaceKind::Sheet; 2], EdgeFaults::default()));
        // With its other side it is closed.
        flat.triangles.extend([[2, 1, 0], [3, 2, 0]]);
        assert_eq!(kinds(&flat), (vec![SurfaceKind::Solid; 4], EdgeFaults::default()));
        // A sphere with a small hole.
        let mut shell = by_name("column")
            .unwrap()
            .meshes
            .iter()
            .max_by_key(|m| m.triangles.len())
            .unwrap()
            .as_ref()
            .clone();
        shell.triangles.pop();
        let (shell, faults) = kinds(&shell);
        assert!(shell.iter().all(|kind| *kind == SurfaceKind::Solid) && faults.open == 3, "{faults}");
    }

    #[test]
    fn edges_of_three_triangles_and_no_numbers_are_borne() {
        let mut mesh = tetrahedron();
        mesh.positions.extend([Vec3::ONE, Vec3::NAN]);
        mesh.triangles.extend([[0, 1, 4], [1, 1, 2], [3, 4, 5]]);
        let MeshEdges { edges, sides, faults } = mesh.edges();
        assert!(faults.forked >= 1 && faults.open >= 2 && sides.len() == 7);
        let halves: usize = edges.iter().map(|edge| 1 + usize::from(edge.second.is_some())).sum();
        assert_eq!(halves, 3 * 6 + 2);
    }
}
