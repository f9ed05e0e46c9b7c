//! What casts shadows: boxes around it, and simpler triangles in place of many.

use std::ops::Range;

use glam::{Affine3A, Vec3};
use gnomon_lights::DistantLight;
use gnomon_scene::Bounds;

use crate::geometry::Draw;
use crate::ground::Ground;

/// What lies so far on the other side of a plane lies in it, as a share of the longest side of the box around everything.
const IN_PLANE: f32 = 1e-4;

/// Box around some triangles of an instance, in its mesh's space.
#[derive(Clone, Debug)]
pub(crate) struct InstanceBox {
    pub bounds: Bounds,
    /// Of these triangles alone, where they lie side by side.
    pub indices: Option<Range<u32>>,
    /// What may be drawn in place of `indices`, the finest first.
    pub simpler: Vec<SimplerIndices>,
    pub instance: usize,
    /// That its triangles are drawn at, 0 in world space.
    pub placement: u32,
    pub world_from_mesh: Affine3A,
    /// Whether it blocks light.
    pub casts: bool,
}

/// Of coarser triangles.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SimplerIndices {
    /// That of [`gnomon_scene::SimplerTriangles`] [m in the mesh's space].
    pub deviation: f32,
    pub indices: Range<u32>,
}

impl InstanceBox {
    /// The eight corners in world space.
    pub fn corners(&self) -> [Vec3; 8] {
        self.bounds.corners().map(|corner| self.world_from_mesh.transform_point3(corner))
    }
}

/// The boxes of a pose in world space, as shadow maps are fitted around them.
#[derive(Clone, Debug, Default)]
pub(crate) struct PlacedBoxes {
    pub boxes: Vec<PlacedBox>,
    /// Around all of them.
    pub around: Option<Bounds>,
    /// What is no farther from a plane lies in it [m].
    pub tolerance: f32,
}

#[derive(Clone, Debug)]
pub(crate) struct PlacedBox {
    /// Place of what it is around among the placed meshes.
    pub instance: usize,
    placement: u32,
    pub corners: [Vec3; 8],
    pub indices: Option<Range<u32>>,
    pub simpler: Vec<SimplerIndices>,
    /// Most by which lengths grow from the mesh to the world.
    scale: f32,
    /// Whether it blocks light.
    pub casts: bool,
    /// Where it is flat and everything else lies on one side of it.
    pub ground: Option<Ground>,
}

impl PlacedBoxes {
    pub fn new(boxes: &[InstanceBox]) -> Self {
        let all_corners: Vec<[Vec3; 8]> = boxes.iter().map(InstanceBox::corners).collect();
        let around = Bounds::around(all_corners.iter().flatten().copied());
        let tolerance = IN_PLANE * around.map_or(0.0, |around| (around.max - around.min).max_element());
        let placed = |(index, corners): (usize, &[Vec3; 8])| PlacedBox {
            instance: boxes[index].instance,
            placement: boxes[index].placement,
            corners: *corners,
            indices: boxes[index].indices.clone(),
            simpler: boxes[index].simpler.clone(),
            scale: greatest_scale(&boxes[index].world_from_mesh),
            casts: boxes[index].casts,
            ground: Ground::of(&boxes[index], index, &all_corners, tolerance),
        };
        Self { boxes: all_corners.iter().enumerate().map(placed).collect(), around, tolerance }
    }

    /// What can cast a shadow: of all indices in world space, which end at `end`, and the simpler ones behind them, and of copies.
    pub fn casters(&self, wanted: &Casters<'_>, end: u32) -> DrawnCasters {
        let blocks_nothing = |place: &PlacedBox| match (place.ground, wanted.above) {
            _ if !place.casts => true,
            (Some(ground), Some(light)) => ground.blocks_nothing_of(light),
            _ => false,
        };
        let is_enough = |place: &PlacedBox, simpler: &SimplerIndices| {
            simpler.deviation * place.scale <= wanted.deviation_world
        };
        let mut replaced: Vec<Range<u32>> = Vec::new();
        let mut simpler: Vec<Range<u32>> = Vec::new();
        let mut copies: Vec<Draw> = Vec::new();
        let mut deviation_world = 0.0f32;
        for place in &self.boxes {
            let Some(own) = &place.indices else { continue };
            let blocks_nothing = blocks_nothing(place);
            let found = place.simpler.iter().take_while(|s| !blocks_nothing && is_enough(place, s)).last();
            if let Some(found) = found {
                deviation_world = deviation_world.max(found.deviation * place.scale);
            }
            let found = found.map(|found| found.indices.clone());
            if place.placement == 0 {
                if blocks_nothing || found.is_some() {
                    replaced.push(own.clone());
                }
                simpler.extend(found);
            } else if !blocks_nothing {
                let indices = found.unwrap_or_else(|| own.clone());
                match copies.last_mut() {
                    Some(last) if last.indices == indices && last.placements.end == place.placement => {
                        last.placements.end += 1;
                    }
                    _ => copies.push(Draw { indices, placements: place.placement..place.placement + 1 }),
                }
            }
        }
        replaced.sort_by_key(|range| range.start);
        simpler.sort_by_key(|range| range.start);
        let starts = std::iter::once(0).chain(replaced.iter().map(|own| own.end));
        let ends = replaced.iter().map(|own| own.start).chain([end]);
        let whole = starts.zip(ends).map(|(start, end)| start..end);
        let mut indices: Vec<Range<u32>> = Vec::new();
        for range in whole.chain(simpler).filter(|range| !range.is_empty()) {
            match indices.last_mut() {
                Some(last) if last.end == range.start => last.end = range.end,
                _ => indices.push(range),
            }
        }
        let draws = indices.into_iter().map(Draw::in_world).chain(copies).collect();
        DrawnCasters { draws, deviation_world }
    }

    pub fn corners(&self) -> impl Iterator<Item = Vec3> + '_ {
        self.boxes.iter().flat_map(|place| place.corners)
    }
}

/// What a shadow map needs of the scene.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Casters<'a> {
    /// Grounds of which this light shines on the side that bears everything are not drawn: a kernel that reached one below a wall would
    /// take it for a blocker.
    pub above: Option<&'a DistantLight>,
    /// Simpler triangles of no more than this deviation are as good [m].
    pub deviation_world: f32,
}

/// What a shadow map shows of the scene.
#[derive(Clone, Debug)]
pub(crate) struct DrawnCasters {
    pub draws: Vec<Draw>,
    /// The greatest deviation among them [m].
    pub deviation_world: f32,
}

/// Most by which a placement lengthens anything; a bound where it shears (Gershgorin's of the matrix times its transpose).
fn greatest_scale(world_from_mesh: &Affine3A) -> f32 {
    let squares = world_from_mesh.matrix3.transpose() * world_from_mesh.matrix3;
    let sum = |row: glam::Vec3A| row.abs().element_sum();
    sum(squares.x_axis).max(sum(squares.y_axis)).max(sum(squares.z_axis)).sqrt()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// An axis-aligned box at its place.
    pub(crate) fn placed(min: Vec3, max: Vec3) -> InstanceBox {
        let bounds = Bounds { min, max };
        InstanceBox {
            bounds,
            indices: None,
            simpler: Vec::new(),
            instance: 0,
            placement: 0,
            world_from_mesh: Affine3A::IDENTITY,
            casts: true,
        }
    }

    fn in_world(draw: &Draw) -> (u32, u32) {
        assert_eq!(draw.placements, 0..1);
        (draw.indices.start, draw.indices.end)
    }

    #[test]
    fn copies_are_drawn_at_their_placements_each_as_coarse_as_it_may_be() {
        let p = Vec3::new;
        let copy = |placement: u32, scale: f32| InstanceBox {
            indices: Some(6..12),
            simpler: vec![SimplerIndices { deviation: 0.01, indices: 20..23 }],
            instance: placement as usize,
            placement,
            world_from_mesh: Affine3A::from_scale(Vec3::splat(scale)),
            ..placed(p(-1.0, 0.0, -1.0), p(1.0, 2.0, 1.0))
        };
        let own = InstanceBox { indices: Some(0..6), ..placed(p(-4.0, 0.0, -4.0), p(4.0, 1.0, 4.0)) };
        let catcher = InstanceBox { casts: false, ..copy(6, 1.0) };
        let boxes = [
            own,
            copy(1, 1.0),
            copy(2, 1.0),
            copy(3, 9.0),
            copy(4, 9.0),
            copy(5, 1.0),
            catcher,
            copy(7, 1.0),
        ];
        let drawn = PlacedBoxes::new(&boxes).casters(&Casters { above: None, deviation_world: 0.02 }, 6);
        let draw = |indices, placements| Draw { indices, placements };
        let whole = [draw(0..6, 0..1), draw(20..23, 1..3), draw(6..12, 3..5), draw(20..23, 5..6)];
        assert_eq!(drawn.draws, [&whole[..], &[draw(20..23, 7..8)]].concat());
        assert_eq!(drawn.deviation_world, 0.01);
    }

    #[test]
    fn a_ground_casts_no_shadow_of_a_light_above_it() {
        let p = Vec3::new;
        let ground = InstanceBox { indices: Some(6..12), ..placed(p(-4.0, 0.0, -4.0), p(4.0, 0.0, 4.0)) };
        let model = InstanceBox { indices: None, ..placed(p(-1.0, 0.0, -1.0), p(1.0, 2.0, 1.0)) };
        let scene = PlacedBoxes::new(&[ground.clone(), model.clone()]);
        let of = |scene: &PlacedBoxes, towards: glam::DVec3| {
            let light = DistantLight::disk(towards.normalize(), 0.3, glam::DVec3::ONE);
            let drawn = scene.casters(&Casters { above: Some(&light), deviation_world: 0.0 }, 20);
            drawn.draws.iter().map(in_world).collect::<Vec<_>>()
        };
        let casters = |towards| of(&scene, towards);
        let d = glam::DVec3::new;
        assert_eq!(casters(d(0.2, 1.0, 0.0)), [(0, 6), (12, 20)]);
        for partly_below in [d(1.0, 0.2, 0.0), d(1.0, -0.2, 0.0), d(0.2, -1.0, 0.0)] {
            assert_eq!(casters(partly_below), [(0, 20)], "{partly_below}");
        }
        let catcher = InstanceBox { casts: false, ..ground.clone() };
        assert_eq!(of(&PlacedBoxes::new(&[catcher, model.clone()]), d(0.2, -1.0, 0.0)), [(0, 6), (12, 20)]);
        // Triangles that lie among others, and a ground that something hangs below, are drawn.
        let mixed = PlacedBoxes::new(&[InstanceBox { indices: None, ..ground.clone() }, model]);
        let hanging = PlacedBoxes::new(&[ground, placed(p(-1.0, -2.0, -1.0), p(1.0, 2.0, 1.0))]);
        assert_eq!([&mixed, &hanging].map(|scene| of(scene, d(0.0, 1.0, 0.0))), [[(0, 20)], [(0, 20)]]);
    }

    #[test]
    fn the_coarsest_triangles_that_are_near_enough_take_the_place_of_a_mesh() {
        let p = Vec3::new;
        let ground = InstanceBox { indices: Some(0..6), ..placed(p(-4.0, 0.0, -4.0), p(4.0, 0.0, 4.0)) };
        let simpler = |deviation, indices| SimplerIndices { deviation, indices };
        let model = InstanceBox {
            indices: Some(6..12),
            simpler: vec![simpler(0.01, 20..26), simpler(0.02, 26..29)],
            world_from_mesh: Affine3A::from_scale(p(2.0, 1.0, 1.0)),
            ..placed(p(-1.0, 0.0, -1.0), p(1.0, 2.0, 1.0))
        };
        let scene = PlacedBoxes::new(&[ground, model]);
        let light = DistantLight::disk(glam::DVec3::Y, 0.3, glam::DVec3::ONE);
        let drawn = |above, deviation_world| {
            let drawn = scene.casters(&Casters { above, deviation_world }, 20);
            assert!(deviation_world.is_nan() || drawn.deviation_world <= deviation_world);
            drawn.draws.iter().map(in_world).collect::<Vec<_>>()
        };
        // In the world the simpler ones deviate by twice as much.
        assert_eq!(drawn(None, 0.0), [(0, 20)]);
        assert_eq!(drawn(None, 0.0199), [(0, 20)]);
        assert_eq!(drawn(None, 0.021), [(0, 6), (12, 26)]);
        assert_eq!(drawn(None, 1.0), [(0, 6), (12, 20), (26, 29)]);
        assert_eq!(drawn(Some(&light), 1.0), [(12, 20), (26, 29)]);
        // Across the diagonal of a shear lengths grow more than along any axis.
        let shear = Affine3A::from_mat3(glam::Mat3::from_cols(Vec3::X, p(1.0, 1.0, 0.0), Vec3::Z));
        assert!(
            greatest_scale(&shear) >= 1.618
                && (greatest_scale(&Affine3A::from_rotation_x(0.7)) - 1.0).abs() < 1e-6
        );
        // Nothing is near enough to what is no number.
        assert_eq!(drawn(None, f32::NAN), [(0, 20)]);
    }
}
