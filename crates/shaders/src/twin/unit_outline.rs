//! An outline as the unit disk or a square. Twin of `unit_outline.wgsl`.

use glam::{Mat2, Vec2};

/// See the module of the same name.
#[derive(Clone, Copy, Debug)]
pub struct UnitOutline {
    is_disk: bool,
    middle: Vec2,
    unit_from_plane: Mat2,
    /// Most that offsets from the middle grow by along an axis of the square.
    pub growth: f32,
}

/// Of a disk about the origin.
pub fn unit_disk(radius: f32) -> UnitOutline {
    let growth = 1.0 / radius.max(1e-9);
    UnitOutline {
        is_disk: true,
        middle: Vec2::ZERO,
        unit_from_plane: Mat2::from_diagonal(Vec2::splat(growth)),
        growth,
    }
}

/// Of the parallelogram with the half sides `a` and `b`.
pub fn unit_parallelogram(middle: Vec2, a: Vec2, b: Vec2) -> UnitOutline {
    let determinant = a.perp_dot(b);
    let sign = if determinant >= 0.0 { 1.0 } else { -1.0 };
    let scale = sign / determinant.abs().max(1e-12);
    let unit_from_plane = Mat2::from_cols_array(&[b.y, -a.y, -b.x, a.x]) * scale;
    UnitOutline { is_disk: false, middle, unit_from_plane, growth: scale.abs() * a.length().max(b.length()) }
}

/// How far a place lies from the middle of an outline of `scale` times its size: at its edge as far as that scale.
pub fn reach_in_outline(unit: &UnitOutline, place: Vec2, scale: f32) -> f32 {
    let at = unit.unit_from_plane * (place - scale * unit.middle);
    if unit.is_disk { at.length() } else { at.abs().max_element() }
}
