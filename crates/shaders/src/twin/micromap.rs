//! `micromap.wgsl`.

/// Number of the small triangle, of `divisions` along an edge, that the point with the second and third barycentric coordinates `v` and `w`
/// lies in.
pub fn micro_triangle(v: f32, w: f32, divisions: u32) -> u32 {
    let (x, y) = (v.clamp(0.0, 1.0) * divisions as f32, w.clamp(0.0, 1.0) * divisions as f32);
    let (column, row) = ((x as u32).min(divisions - 1), (y as u32).min(divisions - 1));
    let beyond = u32::from(x - column as f32 + y - row as f32 > 1.0);
    2 * (row * divisions + column) + beyond
}
