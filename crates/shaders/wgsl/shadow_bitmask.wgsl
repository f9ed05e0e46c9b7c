#import blocker_window
#import light_bits

// Bitmask soft shadows (Schwarz and Stamminger 2007): every texel of the depth map that is nearer than the receiver covers points of the light, a bit
// each, so that blockers behind one another count once.

fn visibility(light: u32, point: u32, position_world: vec3f, normal_world: vec3f, n: vec3f) -> f32 {
    let window = blocker_window(light, position_world, normal_world, n);
    if window.known >= 0.0 {
        return window.known;
    }
    var covered = vec2u(0u);
    for (var y = window.low.y; y < window.high.y; y += window.step) {
        for (var x = window.low.x; x < window.high.x; x += window.step) {
            let z = blocker_depth(window, vec2i(x, y));
            if z < 1.0 {
                let box = covered_box(window, vec2i(x, y), z);
                let across = bits_left_of(box.z) & ~bits_left_of(box.x);
                covered |= across & bits_above(box.w) & ~bits_above(box.y);
            }
        }
    }
    let bits = countOneBits(covered);
    return 1.0 - f32(bits.x + bits.y) / 64.0;
}
