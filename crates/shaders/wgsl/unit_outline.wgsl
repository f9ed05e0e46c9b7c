// An outline as the unit disk, or the square from -1 to 1. Twin: `unit_outline.rs`.

struct UnitOutline {
    is_disk: bool,
    middle: vec2f,
    // What takes offsets from the middle to that disk or square.
    unit_from_plane: mat2x2f,
    // Most that it lengthens anything along an axis of the square.
    growth: f32,
}

fn unit_disk(radius: f32) -> UnitOutline {
    let growth = 1.0 / max(radius, 1e-9);
    return UnitOutline(true, vec2f(0.0), mat2x2f(growth, 0.0, 0.0, growth), growth);
}

// Of the parallelogram with the half sides `a` and `b`.
fn unit_parallelogram(middle: vec2f, a: vec2f, b: vec2f) -> UnitOutline {
    let determinant = a.x * b.y - a.y * b.x;
    let scale = select(-1.0, 1.0, determinant >= 0.0) / max(abs(determinant), 1e-12);
    let unit_from_plane = mat2x2f(scale * b.y, -scale * a.y, -scale * b.x, scale * a.x);
    return UnitOutline(false, middle, unit_from_plane, abs(scale) * max(length(a), length(b)));
}

// How far a place lies from the middle of an outline of `scale` times its size: at its edge as far as that scale.
fn reach_in_outline(unit: UnitOutline, place: vec2f, scale: f32) -> f32 {
    let at = unit.unit_from_plane * (place - scale * unit.middle);
    return select(max(abs(at.x), abs(at.y)), length(at), unit.is_disk);
}
