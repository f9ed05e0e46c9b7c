#import frame
#import gbuffer_surface
#import lit_outline
#import ray_origin
#import ray_scene
#import sharpness

// Shadow rays: to points of a light from which as much of its light comes from each, weighted by the cosine. The importer binds `points`.

// A row for every light of the frame: points on the plane that `outline_from` spans; the number of rays to it (x) and, where the points tell
// where its light comes from and its outline does not, its solid angle (y), else 0; the points' least and greatest coordinates.
@group(GROUP_SHADOW) @binding(3) var light_points: texture_2d<f32>;

// Share of a ray's length that is left free before a light: what it hangs on.
const END_CLEARANCE: f32 = 1e-4;
// What a light that all rays miss counts of what its penumbra does: most are hidden by walls, and their penumbrae are far.
const DARK_SHARE: f32 = 0.03;
// Penumbrae count as at least so many tiles wide: in a corner a little of the light has none, and the rest stays grainy.
const LEAST_PENUMBRA: f32 = 2.0;

// Below so many rays each is followed by itself.
const LEAST_GATHERED: u32 = 4u;
// Directions between which rays are gathered reach so far beyond them, as a share of their length, for what arithmetic loses.
const GATHER_MARGIN: f32 = 1e-5;

// Middle and half extent of a light's points.
struct PointBounds {
    middle: vec2f,
    half_extent: vec2f,
}

fn point_bounds(row: u32) -> PointBounds {
    let low = textureLoad(light_points, vec2u(LIGHT_POINTS + 1u, row), 0).xy;
    let high = textureLoad(light_points, vec2u(LIGHT_POINTS + 2u, row), 0).xy;
    return PointBounds(0.5 * (low + high), 0.5 * (high - low));
}

// Gathers what rays to a light may meet; false where there is too much of it.
fn gather_to(origin: vec3f, outline: mat3x3f, bounds: PointBounds, offset: vec3f, reach: f32) -> bool {
    let middle = outline * vec3f(1.0, bounds.middle) + offset;
    let margin = GATHER_MARGIN * length(middle);
    let across = abs(outline[1]) * bounds.half_extent.x + abs(outline[2]) * bounds.half_extent.y + margin;
    return gather(origin, not_zero(middle - across), not_zero(middle + across), reach);
}

// Form factor of a distant light that the horizon of `n` cuts, by all of its points; below 0 of others: where the whole light is up, its mean
// direction tells the same.
fn form_factor_by_points(outline: mat3x3f, bounds: PointBounds, n: vec3f, row: u32, solid_angle: f32) -> f32 {
    let heights = n * outline;
    let middle = dot(heights, vec3f(1.0, bounds.middle));
    let reach = dot(abs(heights.yz), bounds.half_extent);
    if solid_angle == 0.0 || abs(middle) >= reach {
        return -1.0;
    }
    var sum = 0.0;
    for (var i = 0u; i < LIGHT_POINTS; i++) {
        let direction = outline * vec3f(1.0, textureLoad(light_points, vec2u(i, row), 0).xy);
        sum += max(dot(n, direction), 0.0) * inverseSqrt(dot(direction, direction));
    }
    return solid_angle * sum / f32(LIGHT_POINTS);
}

fn not_zero(direction: vec3f) -> vec3f {
    return select(direction, vec3f(LEAST_COMPONENT), abs(direction) < vec3f(LEAST_COMPONENT));
}

fn visibility(light: u32, point: u32, position_world: vec3f, normal_world: vec3f, n: vec3f) -> f32 {
    let origin = ray_origin(position_world, normal_world);
    let outline = outline_from(light, position_world);
    let is_distant = lights[light].kind == KIND_DISTANT;
    let reach = select(1.0 - END_CLEARANCE, 3.4e38, is_distant);
    let row = lights[light].number;
    let known = textureLoad(light_points, vec2u(LIGHT_POINTS, row), 0).xy;
    let rays = u32(known.x);
    let bounds = point_bounds(row);
    known_form_factor = form_factor_by_points(outline, bounds, n, row, known.y);
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
    // To the same places of a light that is not distant: a ray that ends behind them meets what the light hangs on.
    let offset = select(position_world - origin, vec3f(0.0), is_distant);
    let is_gathered = rays >= LEAST_GATHERED && gather_to(origin, outline, bounds, offset, reach);
    for (var i = 0u; i < rays; i++) {
        let place = textureLoad(light_points, vec2u((first + i) % LIGHT_POINTS, row), 0).xy;
        var direction = outline * vec3f(1.0, place);
        var weight = max(dot(n, direction), 0.0) * inverseSqrt(dot(direction, direction));
        if !is_distant {
            weight = irradiance_weight(outline, n, place);
            direction += offset;
        }
        weights += weight;
        if weight > 0.0 && dot(normal_world, direction) > 0.0 {
            let left = transmittance_through(origin, direction, reach, is_gathered);
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
