#import bumps

// Lit directions as an ellipse in the plane that they are projected to: 1 - l'x^2 / r1^2 - l'y^2 / r2^2 >= 0 (Heidrich 2001, section 3.1).

fn lit_share(relief: Relief, direction: vec3f, spread: f32) -> f32 {
    let center = unpack2x16float(relief.lit.x);
    let shape = unpack2x16float(relief.lit.y);
    let yy = unpack2x16float(relief.lit.z).x;
    // By the inverse of the shape's matrix.
    let p = direction.xy - center;
    let determinant = max(shape.x * yy - shape.y * shape.y, 1e-9);
    let squared = max((yy * p.x * p.x - 2.0 * shape.y * p.x * p.y + shape.x * p.y * p.y) / determinant, 1e-9);
    // Distance from the edge along the line from the centre.
    let distance = (inverseSqrt(squared) - 1.0) * length(p);
    return select(saturate(0.5 + 0.5 * distance / spread), 1.0, squared < 1e-4);
}
