// Whether any ray from the origin, each component of whose direction lies between those of `least` and `most`, none of them 0, meets a box
// before `reach`, in lengths of its direction: slabs by intervals (Reshetov et al. 2005). It may say so of a box beside all of them, never the
// opposite.
fn pyramid_meets_box(least: vec3f, most: vec3f, low: vec3f, high: vec3f, reach: f32) -> bool {
    // Some ray is before the box's far sides where t * least <= high, and behind its near ones where t * most >= low.
    let before = high / least;
    let behind = low / most;
    let zero = vec3f(0.0);
    let enters = max(select(zero, before, least < zero), select(zero, behind, most > zero));
    let leaves = min(select(vec3f(reach), before, least > zero), select(vec3f(reach), behind, most < zero));
    return max(enters.x, max(enters.y, enters.z)) <= min(leaves.x, min(leaves.y, leaves.z));
}
