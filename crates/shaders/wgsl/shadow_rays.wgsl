#import frame
#import gbuffer_surface
#import lit_outline
#import ray_scene

// Shadow rays: to points of a light from which as much of its light comes from each, weighted by the cosine. The importer binds `points`.

// A row for every light of the frame: points on the plane that `outline_from` spans, and the number of rays to it.
@group(GROUP_SHADOW) @binding(3) var light_points: texture_2d<f32>;

// Rays begin so many texels of the G-buffer before their surface, towards the viewer, who sees it: a rasterizer puts vertices on a grid of
// 1/256 of a texel, and what is seen so far beyond the edge of its surface lies behind another one, which the viewer may see at a small angle.
const TOWARDS_VIEWER: f32 = 0.125;
// Rounding of a position that was found from its depth, as a share of its distance from the eye, and of its coordinates.
const DEPTH_ROUNDING: f32 = 4e-6;
const ROUNDING: f32 = 2e-6;
// Share of a ray's length that is left free before a light: what it hangs on.
const END_CLEARANCE: f32 = 1e-4;

// Number of a pixel among 16, such that those around it on its own grid and on one of every second pixel have the others.
fn pixel_of_16(pixel: vec2u) -> u32 {
    let near = (pixel ^ (pixel >> vec2u(2u))) & vec2u(1u);
    let far = (pixel >> vec2u(1u)) & vec2u(1u);
    return 4u * (2u * (near.x ^ near.y) + near.y) + 2u * (far.x ^ far.y) + far.y;
}

fn visibility(light: u32, point: u32, position_world: vec3f, normal_world: vec3f, n: vec3f) -> f32 {
    let largest = max(max(abs(position_world.x), abs(position_world.y)), abs(position_world.z));
    let clearance = DEPTH_ROUNDING * distance(position_world, view.eye_world.xyz) * view.eye_world.w + ROUNDING * largest;
    let to_viewer = normalize(view.eye_world.xyz - position_world * view.eye_world.w);
    let step = TOWARDS_VIEWER * f32(view.interleave) * sample_extent_at(position_world);
    let origin = position_world + clearance * normal_world + step * to_viewer;
    let outline = outline_from(light, position_world);
    let is_distant = lights[light].kind == KIND_DISTANT;
    let reach = select(1.0 - END_CLEARANCE, 3.4e38, is_distant);
    let row = lights[light].number;
    let rays = u32(textureLoad(light_points, vec2u(LIGHT_POINTS, row), 0).x);
    // Neighbours take other points of a light, and lights do so in other orders.
    let sample = points[point].sample;
    let pixel = unpack_place(sample) / view.supersample;
    let first = rays * (pixel_of_16(pixel) + 7u * row);
    var lit = 0.0;
    var weights = 0.0;
    for (var i = 0u; i < rays; i++) {
        let place = textureLoad(light_points, vec2u((first + i) % LIGHT_POINTS, row), 0).xy;
        let direction = outline * vec3f(1.0, place);
        var weight = max(dot(n, direction), 0.0) * inverseSqrt(dot(direction, direction));
        if !is_distant {
            weight = irradiance_weight(outline, n, place);
        }
        weights += weight;
        if weight > 0.0 && dot(normal_world, direction) > 0.0 && !is_occluded(origin, direction, reach) {
            lit += weight;
        }
    }
    return lit / max(weights, 1e-9);
}
