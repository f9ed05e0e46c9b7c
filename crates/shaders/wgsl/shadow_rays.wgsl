#import frame
#import gbuffer_surface
#import lit_outline
#import ray_origin
#import ray_scene
#import sharpness

// Shadow rays: to points of a light from which as much of its light comes from each, weighted by the cosine. The importer binds `points`.

// A row for every light of the frame: points on the plane that `outline_from` spans, and the number of rays to it.
@group(GROUP_SHADOW) @binding(3) var light_points: texture_2d<f32>;

// Share of a ray's length that is left free before a light: what it hangs on.
const END_CLEARANCE: f32 = 1e-4;
// What a light that all rays miss counts of what its penumbra does: most are hidden by walls, and their penumbrae are far.
const DARK_SHARE: f32 = 0.03;
// Penumbrae count as at least so many tiles wide: in a corner a little of the light has none, and the rest stays grainy.
const LEAST_PENUMBRA: f32 = 2.0;

fn visibility(light: u32, point: u32, position_world: vec3f, normal_world: vec3f, n: vec3f) -> f32 {
    let origin = ray_origin(position_world, normal_world);
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
    var sharpness = 0.0;
    let extent = 2.0 * box_half_extent(light);
    let light_width = min(extent.x, extent.y);
    let least_penumbra = LEAST_PENUMBRA * f32(view.point_lists[0].sampling) * sample_extent_at(position_world);
    for (var i = 0u; i < rays; i++) {
        let place = textureLoad(light_points, vec2u((first + i) % LIGHT_POINTS, row), 0).xy;
        var direction = outline * vec3f(1.0, place);
        var weight = max(dot(n, direction), 0.0) * inverseSqrt(dot(direction, direction));
        if !is_distant {
            weight = irradiance_weight(outline, n, place);
            // To the same place of the light: a ray that ends behind it meets what the light hangs on.
            direction += position_world - origin;
        }
        weights += weight;
        if weight > 0.0 && dot(normal_world, direction) > 0.0 {
            let left = transmittance(origin, direction, reach);
            lit += weight * left;
            if left < 1.0 {
                // Of a distant light.
                let penumbra = light_width * last_distance * length(direction);
                sharpness += weight / (penumbra * penumbra + least_penumbra * least_penumbra);
            }
        }
    }
    let visible = lit / max(weights, 1e-9);
    shadow_sharpness = sharpness / max(weights, 1e-9);
    // Of few rays none may have passed by chance.
    if rays >= 4u && visible == 0.0 {
        shadow_sharpness *= DARK_SHARE;
    }
    // An edge cuts a row of parts of the light, each with one ray. Whatever these have met: averages would lean to what is surer.
    let count = f32(rays);
    shadow_variance = 0.25 * min(count, 2.0 * sqrt(count)) / (count * count);
    return visible;
}
