#import math

// Number of the small triangle, of `divisions` along an edge, that the point with the second and third barycentric coordinates `v` and `w`
// lies in.
fn micro_triangle(v: f32, w: f32, divisions: u32) -> u32 {
    let place = saturate(vec2f(v, w)) * f32(divisions);
    let cell = min(vec2u(place), vec2u(divisions - 1u));
    let within = place - vec2f(cell);
    return 2u * (cell.y * divisions + cell.x) + select(0u, 1u, within.x + within.y > 1.0);
}
