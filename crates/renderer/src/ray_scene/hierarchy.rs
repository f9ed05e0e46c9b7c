//! The hierarchy of boxes around a mesh's triangles, or around instances.

use glam::Vec3;
use gnomon_scene::Bounds;

/// Most triangles of a leaf.
const MOST_IN_LEAF: usize = 4;
/// Places at which a cut is tried along an axis.
const BINS: usize = 16;

/// A node. Nodes lie in depth-first order: an inner node's first child follows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Node {
    pub bounds: Bounds,
    /// The node after all that lie below this one.
    pub skip: u32,
    /// Where a leaf's members begin in [`Hierarchy::order`].
    pub first: u32,
    /// Number of a leaf's members, 0 of an inner node.
    pub count: u32,
}

/// A binary tree of boxes, by the surface area heuristic over bins (Wald 2007).
#[derive(Debug, Default)]
pub(super) struct Hierarchy {
    pub nodes: Vec<Node>,
    /// Indices of the boxes that it was built around, leaf after leaf.
    pub order: Vec<u32>,
}

impl Hierarchy {
    pub fn new(boxes: &[Bounds], most_in_leaf: usize) -> Self {
        let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
        let mut nodes = Vec::with_capacity(boxes.len());
        // Parts that are still to be divided, the next one last, and nodes whose parts are done behind them.
        let mut open = vec![Step::Divide(0..order.len())];
        while let Some(step) = open.pop() {
            match step {
                Step::Close(node) => {
                    let skip = nodes.len() as u32;
                    let closed: &mut Node = &mut nodes[node];
                    closed.skip = skip;
                }
                Step::Divide(range) if range.is_empty() => {}
                Step::Divide(range) => {
                    let members = &mut order[range.clone()];
                    let bounds = members.iter().fold(EMPTY, |around, &i| union(around, boxes[i as usize]));
                    let middle = if members.len() > most_in_leaf { divide(boxes, members) } else { 0 };
                    let count = if middle == 0 { range.len() as u32 } else { 0 };
                    open.push(Step::Close(nodes.len()));
                    nodes.push(Node { bounds, skip: 0, first: range.start as u32, count });
                    if middle > 0 {
                        open.push(Step::Divide(range.start + middle..range.end));
                        open.push(Step::Divide(range.start..range.start + middle));
                    }
                }
            }
        }
        Self { nodes, order }
    }

    /// Around triangles.
    pub fn of_triangles(positions: &[Vec3], triangles: &[[u32; 3]]) -> Self {
        let bounds = |triangle: &[u32; 3]| {
            triangle.iter().fold(EMPTY, |around, &vertex| {
                let at = positions[vertex as usize];
                union(around, Bounds { min: at, max: at })
            })
        };
        let boxes: Vec<Bounds> = triangles.iter().map(bounds).collect();
        Self::new(&boxes, MOST_IN_LEAF)
    }

    /// Of every node the length of the longest way down to a leaf.
    pub fn heights(&self) -> Vec<u32> {
        let mut heights = vec![0; self.nodes.len()];
        for (i, node) in self.nodes.iter().enumerate().rev().filter(|(_, node)| node.count == 0) {
            let second = self.nodes[i + 1].skip as usize;
            debug_assert!(second < node.skip as usize);
            heights[i] = 1 + u32::max(heights[i + 1], heights[second]);
        }
        heights
    }
}

enum Step {
    Divide(std::ops::Range<usize>),
    Close(usize),
}

const EMPTY: Bounds = Bounds { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

fn union(a: Bounds, b: Bounds) -> Bounds {
    Bounds { min: a.min.min(b.min), max: a.max.max(b.max) }
}

fn half_area(bounds: Bounds) -> f32 {
    let side = (bounds.max - bounds.min).max(Vec3::ZERO);
    side.x * side.y + side.y * side.z + side.z * side.x
}

/// Brings members of one part before those of the other and tells how many it has, which is never none or all.
fn divide(boxes: &[Bounds], members: &mut [u32]) -> usize {
    let center = |i: u32| 0.5 * (boxes[i as usize].min + boxes[i as usize].max);
    let centers =
        members.iter().fold(EMPTY, |around, &i| union(around, Bounds { min: center(i), max: center(i) }));
    let size = centers.max - centers.min;
    let bin = |i: u32, axis: usize| {
        let place = (center(i)[axis] - centers.min[axis]) / size[axis];
        ((place * BINS as f32) as usize).min(BINS - 1)
    };
    let mut best: Option<(f32, usize, usize)> = None;
    for axis in (0..3).filter(|&axis| size[axis] > 0.0) {
        let mut bins = [(EMPTY, 0); BINS];
        for &i in members.iter() {
            let (around, count) = &mut bins[bin(i, axis)];
            (*around, *count) = (union(*around, boxes[i as usize]), *count + 1);
        }
        let mut behind = [(EMPTY, 0); BINS + 1];
        for cut in (0..BINS).rev() {
            behind[cut] = (union(behind[cut + 1].0, bins[cut].0), behind[cut + 1].1 + bins[cut].1);
        }
        let mut before = (EMPTY, 0);
        for cut in 1..BINS {
            before = (union(before.0, bins[cut - 1].0), before.1 + bins[cut - 1].1);
            if before.1 == 0 || behind[cut].1 == 0 {
                continue;
            }
            let cost = |(around, count): (Bounds, usize)| half_area(around) * count as f32;
            let cost = cost(before) + cost(behind[cut]);
            if best.is_none_or(|(least, ..)| cost < least) {
                best = Some((cost, axis, cut));
            }
        }
    }
    // All in one place: any halves will do.
    let Some((_, axis, cut)) = best else { return members.len() / 2 };
    let mut middle = 0;
    for i in 0..members.len() {
        if bin(members[i], axis) < cut {
            members.swap(i, middle);
            middle += 1;
        }
    }
    middle
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scattered(count: usize) -> Vec<Bounds> {
        let at = |i: usize, step: f64| ((i as f64 + 1.0) * step).fract() as f32;
        let place = |i| Vec3::new(at(i, 0.819_172_5), at(i, 0.671_043_6), at(i, 0.549_700_5));
        (0..count).map(|i| Bounds { min: place(i), max: place(i) + 0.1 * place(i + count) }).collect()
    }

    #[test]
    fn every_box_is_in_one_leaf_and_within_all_nodes_above_it() {
        let mut boxes = scattered(300);
        // Many in one place cannot be told apart.
        boxes.extend([boxes[7]; 40]);
        for most in [1, 4] {
            let Hierarchy { nodes, order } = Hierarchy::new(&boxes, most);
            let mut seen = order.clone();
            seen.sort_unstable();
            assert_eq!(seen, (0..boxes.len() as u32).collect::<Vec<_>>());
            assert_eq!(nodes[0].skip as usize, nodes.len());
            let mut covered = 0;
            for (i, node) in nodes.iter().enumerate() {
                let below = &nodes[i + 1..node.skip as usize];
                assert_eq!(node.count == 0, !below.is_empty());
                assert!(below.iter().all(|other| union(node.bounds, other.bounds) == node.bounds));
                for &member in &order[node.first as usize..(node.first + node.count) as usize] {
                    assert_eq!(union(node.bounds, boxes[member as usize]), node.bounds);
                    covered += 1;
                }
                assert!(node.count as usize <= most);
            }
            assert_eq!(covered, boxes.len());
        }
    }

    #[test]
    fn children_are_lower_than_their_parents() {
        let hierarchy = Hierarchy::new(&scattered(100), 4);
        let heights = hierarchy.heights();
        for (i, node) in hierarchy.nodes.iter().enumerate() {
            if node.count == 0 {
                let second = hierarchy.nodes[i + 1].skip as usize;
                assert_eq!(heights[i], 1 + heights[i + 1].max(heights[second]));
            } else {
                assert_eq!(heights[i], 0);
            }
        }
        assert!(Hierarchy::new(&[], 4).nodes.is_empty());
    }
}
