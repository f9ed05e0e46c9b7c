#import blocker_window

// Backprojection (Guennebaud, Barthe and Paulin 2006): every texel of the depth map that is nearer than the receiver covers a box of the light,
// and the boxes' areas add up, so that blockers behind one another count twice.

fn visibility(light: u32, point: u32, position_world: vec3f, normal_world: vec3f, n: vec3f) -> f32 {
    let window = blocker_window(light, position_world, normal_world, n);
    if window.known >= 0.0 {
        return window.known;
    }
    var covered = 0.0;
    for (var y = window.low.y; y < window.high.y; y += window.step) {
        for (var x = window.low.x; x < window.high.x; x += window.step) {
            let z = blocker_depth(window, vec2i(x, y));
            if z < 1.0 {
                let box = saturate(covered_box(window, vec2i(x, y), z));
                covered += (box.z - box.x) * (box.w - box.y);
            }
        }
    }
    return 1.0 - saturate(covered);
}
