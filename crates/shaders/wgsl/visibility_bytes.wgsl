// A buffer of visibilities: one byte for each pair of a light and a shading point, four lights of one point a word.

// Where the word of a pair lies, with room for `point_count` points.
fn visibility_word(light: u32, point: u32, point_count: u32) -> u32 {
    return light / 4u * point_count + point;
}
