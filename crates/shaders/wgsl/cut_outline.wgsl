#import form_factor

// What edges cut off a light's outline as a receiver sees it (Akenine-Moeller and Assarsson 2003), as irradiance instead of area: by Green's
// theorem a region's irradiance is a sum along its boundary, of Lambert's formula for each straight piece.
//
// All vectors are from the receiver. The outline is a convex polygon, cut at the receiver's horizon.

const MOST_CORNERS: u32 = 18u;

var<private> corner_total: u32;
// Corners, and normals of the planes through the receiver and the side that follows, inwards.
var<private> outline_corners: array<vec3f, MOST_CORNERS>;
var<private> outline_sides: array<vec3f, MOST_CORNERS>;
// Angle of each corner about the middle, from 0 at the first one, and Lambert's formula along the rim up to it; at last along all of it.
var<private> corner_angles: array<f32, MOST_CORNERS>;
var<private> rim_sums: array<f32, MOST_CORNERS + 1u>;
// A point within the outline, and axes about it.
var<private> outline_middle: vec3f;
var<private> middle_x: vec3f;
var<private> middle_y: vec3f;

// Cuts off what lies on the other side of a plane than its normal.
fn cut_corners(normal: vec3f) {
    let count = corner_total;
    var before = outline_corners;
    corner_total = 0u;
    for (var i = 0u; i < count; i++) {
        let a = before[i];
        let b = before[(i + 1u) % count];
        let heights = vec2f(dot(normal, a), dot(normal, b));
        if heights.x > 0.0 {
            outline_corners[corner_total] = a;
            corner_total++;
        }
        if (heights.x > 0.0) != (heights.y > 0.0) && corner_total < MOST_CORNERS {
            outline_corners[corner_total] = mix(a, b, heights.x / (heights.x - heights.y));
            corner_total++;
        }
    }
}

// Irradiance of all of it.
fn corners_form_factor(n: vec3f) -> f32 {
    var sum = 0.0;
    for (var i = 0u; i < corner_total; i++) {
        sum += edge_form_factor(n, outline_corners[i], outline_corners[(i + 1u) % corner_total]);
    }
    return sum;
}

// A point within.
fn middle_of_corners() -> vec3f {
    var sum = vec3f(0.0);
    for (var i = 0u; i < corner_total; i++) {
        sum += outline_corners[i];
    }
    return sum / f32(corner_total);
}

fn angle_about_middle(v: vec3f) -> f32 {
    let place = vec2f(dot(v, middle_x), dot(v, middle_y));
    let angle = atan2(place.y, select(place.x, 1e-30, place.x == 0.0));
    return select(angle, angle + TAU, angle < 0.0);
}

// Readies the outline for `cut_off`.
fn prepare_outline(n: vec3f, middle: vec3f) {
    outline_middle = middle;
    let axis = normalize(middle);
    let across = outline_corners[0] - middle;
    middle_x = normalize(across - axis * dot(axis, across));
    middle_y = cross(middle_x, axis);
    var sum = 0.0;
    for (var i = 0u; i < corner_total; i++) {
        let next = outline_corners[(i + 1u) % corner_total];
        outline_sides[i] = cross(next, outline_corners[i]);
        corner_angles[i] = select(angle_about_middle(outline_corners[i]), 0.0, i == 0u);
        rim_sums[i] = sum;
        sum += edge_form_factor(n, outline_corners[i], next);
    }
    rim_sums[corner_total] = sum;
}

// On which side of the line from a to b a direction passes. On the line it is tilted a little, always the same way, so that it passes on
// one side of each of two triangles that share an edge. The first product is that of `triangle_hit`.
fn side_of_line(a: vec3f, b: vec3f, direction: vec3f) -> f32 {
    let m = cross(a - b, a + b);
    let sides = sign(vec4f(dot(m, direction), m));
    if sides.x != 0.0 {
        return sides.x;
    }
    if sides.y != 0.0 {
        return sides.y;
    }
    return select(sides.w, sides.z, sides.z != 0.0);
}

// Where the ray from the middle through a place at an angle leaves the outline.
struct Rim {
    place: vec3f,
    // Lambert's formula along the rim from the first corner to there.
    sum: f32,
}

fn rim_at(n: vec3f, angle: f32) -> Rim {
    var side = 0u;
    for (var i = 1u; i < corner_total; i++) {
        side = select(side, i, corner_angles[i] <= angle);
    }
    let towards = cos(angle) * middle_x + sin(angle) * middle_y;
    let place = cross(cross(outline_middle, towards), outline_sides[side]);
    let ahead = select(-place, place, dot(place, outline_middle) > 0.0);
    return Rim(ahead, rim_sums[side] + edge_form_factor(n, outline_corners[side], ahead));
}

// The irradiance of the triangle of the middle and what lies of an edge within the outline, less that of the sector around it; 0 unless the edge cuts
// the outline. `k` is that of the light, whose plane bounds edges where `is_near`.
fn cut_off(a: vec3f, b: vec3f, n: vec3f, k: vec3f, is_near: bool) -> f32 {
    if !(dot(a, a) + dot(b, b) < 3e38) {
        return 0.0;
    }
    var reach = vec2f(0.0, 1.0);
    for (var i = 0u; i <= corner_total; i++) {
        var heights = vec2f(1.0) - vec2f(dot(k, a), dot(k, b));
        if i < corner_total {
            heights = vec2f(dot(outline_sides[i], a), dot(outline_sides[i], b));
        } else if !is_near {
            break;
        }
        if heights.x <= 0.0 && heights.y <= 0.0 {
            return 0.0;
        }
        let crossing = heights.x / (heights.x - heights.y);
        if heights.x < 0.0 {
            reach.x = max(reach.x, crossing);
        } else if heights.y < 0.0 {
            reach.y = min(reach.y, crossing);
        }
    }
    if reach.x >= reach.y {
        return 0.0;
    }
    let p = a + reach.x * (b - a);
    let q = a + reach.y * (b - a);
    let angles = vec2f(angle_about_middle(p), angle_about_middle(q));
    var turn = angles.y - angles.x;
    turn -= TAU * round(turn / TAU);
    // Half a turn goes round on the side that the ray to the middle passes.
    let side = -side_of_line(a, b, outline_middle);
    if abs(turn) > 0.25 * TAU && turn * side < 0.0 {
        turn += side * TAU;
    }
    let rim_p = rim_at(n, angles.x);
    let rim_q = rim_at(n, angles.y);
    // Past the first corner the sum along the rim begins anew.
    let rounds = round((angles.x + turn - angles.y) / TAU);
    let along_rim = rim_q.sum - rim_p.sum + rounds * rim_sums[corner_total];
    return edge_form_factor(n, p, q) + edge_form_factor(n, q, rim_q.place) + edge_form_factor(n, rim_p.place, p) - along_rim;
}
