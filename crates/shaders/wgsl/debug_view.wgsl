#import light_sums
#import relief_surface
#import equirect_texture
#import outline_angle
#import tonemap

// What a frame is made of, in place of the picture: values as they are to be displayed, linear.

@group(GROUP_FRAME) @binding(1) var<uniform> parameters: DebugParameters;
@group(GROUP_FRAME) @binding(2) var background: texture_2d<f32>;
@group(GROUP_FRAME) @binding(3) var depth_maps: texture_depth_2d_array;
@group(GROUP_FRAME) @binding(4) var<uniform> lights: array<Light, MAX_BATCH_LIGHTS>;

@group(GROUP_PASS) @binding(7) var picture: texture_storage_2d<rgba32float, write>;

// Around what is shown, and where there is nothing to show.
const EMPTY: vec3f = vec3f(0.01, 0.012, 0.016);
// Where a question has no answer, as the visibility of a light below the horizon.
const NOT_ASKED: vec3f = vec3f(0.03, 0.04, 0.09);

// Displayed value of a share: what looks half as bright is half.
fn grey(share: f32) -> vec3f {
    return vec3f(srgb_decode(share));
}

fn share_seen(shadowed: f32, unshadowed: f32) -> vec3f {
    if unshadowed <= 0.0 {
        return NOT_ASKED;
    }
    return grey(shadowed / unshadowed);
}

fn points_of(sample: vec2u) -> vec3f {
    let of_tile = neighbour_point(view.point_list_count - 1u, sample, 4);
    if of_tile != NO_POINT && points[of_tile].sample == pack_place(sample) {
        return vec3f(1.0);
    }
    if own_point(sample) != NO_POINT {
        return vec3f(1.0, 0.12, 0.01);
    }
    let albedo = luminance(base_color_at(sample));
    return vec3f(0.02 + 0.08 * albedo);
}

fn surface_view(sample: vec2u, depth: f32) -> vec3f {
    let position_world = position_at(sample, depth);
    let n = normal_at(sample);
    switch parameters.view {
        case VIEW_NORMALS: {
            let encoded = 0.5 + 0.5 * n;
            return vec3f(srgb_decode(encoded.x), srgb_decode(encoded.y), srgb_decode(encoded.z));
        }
        case VIEW_DEPTH: {
            let along = -dot(position_world, parameters.to_viewer);
            return grey(1.0 - 0.9 * saturate((along - parameters.least_depth) / parameters.depth_range));
        }
        case VIEW_BASE_COLOR: {
            return base_color_at(sample);
        }
        case VIEW_SHADOW_BUFFER: {
            let sums = sums_at(sample, position_world, n);
            return share_seen(luminance(sums.diffuse_shadowed), luminance(sums.diffuse_unshadowed));
        }
        case VIEW_VISIBILITY: {
            // The only light summed, and as a probe: its visibility weighed by its form factor.
            let sums = sums_at(sample, position_world, n);
            return share_seen(sums.probed_open, sums.probed);
        }
        case VIEW_BUMPS: {
            let relief = relief_at(sample);
            return select(NOT_ASKED, grey(relief.open), relief.covers);
        }
        case VIEW_SCATTERED: {
            let relief = relief_at(sample);
            let albedo = diffuse_color_at(sample);
            let scattered = relief.scattering.x * albedo / (1.0 - albedo * min(relief.scattering.w, 0.95));
            return select(NOT_ASKED, scattered, relief.covers);
        }
        default: {
            return points_of(sample);
        }
    }
}

// Place within the largest rectangle of an aspect in the picture's middle: in [0, 1], or outside of it.
fn letterboxed(sample: vec2f, aspect: f32) -> vec2f {
    let size = vec2f(view.size);
    let height = min(size.y, size.x / aspect);
    return 0.5 + (sample - 0.5 * size) / vec2f(aspect * height, height);
}

fn shadow_map_view(sample: vec2u) -> vec3f {
    let uv = letterboxed(vec2f(sample) + 0.5, 1.0);
    if parameters.has_light == 0u || parameters.has_maps == 0u || any(uv < vec2f(0.0)) || any(uv >= vec2f(1.0)) {
        return EMPTY;
    }
    let side = f32(textureDimensions(depth_maps).x);
    let depth = textureLoad(depth_maps, vec2i(uv * side), parameters.light, 0);
    return select(grey(1.0 - 0.9 * depth), NOT_ASKED, depth >= 1.0);
}

fn signed_angle(light: u32, w: vec3f) -> f32 {
    if lights[light].shape == SHAPE_DISK {
        return disk_signed_angle(w, lights[light].direction, lights[light].angular_radius);
    }
    return rectangle_signed_angle(w, lights[light].corners);
}

fn direction_at(sample: vec2f) -> vec3f {
    let uv = letterboxed(sample, 2.0);
    return direction_from_uv(vec2f(uv.x, saturate(uv.y)));
}

// Distance from a light's outline [samples]: the angle over its gradient, which is right wherever the map stretches the sphere.
fn samples_from_outline(light: u32, sample: vec2f) -> f32 {
    let step = 0.5;
    let gradient = vec2f(
        signed_angle(light, direction_at(sample + vec2f(step, 0.0))) - signed_angle(light, direction_at(sample - vec2f(step, 0.0))),
        signed_angle(light, direction_at(sample + vec2f(0.0, step))) - signed_angle(light, direction_at(sample - vec2f(0.0, step))),
    ) / (2.0 * step);
    return abs(signed_angle(light, direction_at(sample))) / max(length(gradient), 1e-9);
}

// Largest angle between a light's centre and its outline, as its cosine.
fn cosine_of_reach(light: u32) -> f32 {
    if lights[light].shape == SHAPE_DISK {
        return cos(lights[light].angular_radius);
    }
    var cosine = 1.0;
    for (var i = 0u; i < 4u; i++) {
        cosine = min(cosine, dot(lights[light].corners[i].xyz, lights[light].direction));
    }
    return cosine;
}

// Neighbouring numbers get hues far apart: steps of the golden ratio.
fn light_color(number: u32) -> vec3f {
    let hue = fract(f32(number) * 0.618034) * 6.0;
    let channel = vec3f(abs(hue - 3.0) - 1.0, 2.0 - abs(hue - 2.0), 2.0 - abs(hue - 4.0));
    return 0.15 + 0.85 * saturate(channel);
}

// The environment over the sphere with the outlines of this batch's lights; the first batch draws the map itself.
fn lights_view(id: vec2u) {
    let sample = vec2f(id) + 0.5;
    let uv = letterboxed(sample, 2.0);
    let outside = any(uv < vec2f(0.0)) || any(uv >= vec2f(1.0));
    let w = direction_at(sample);
    if parameters.lights_before == 0u {
        // Filmic shoulder x / (1 + x).
        let w_environment = (view.environment_from_world * vec4f(w, 0.0)).xyz;
        let radiance = max(equirect_lookup(background, w_environment, 0) * view.background_factor, vec3f(0.0)) * parameters.exposure;
        textureStore(picture, id, vec4f(select(radiance / (1.0 + radiance), EMPTY, outside), 1.0));
    }
    if outside {
        return;
    }
    // Four samples across the map.
    let margin = 8.0 * PI / f32(view.size.x);
    for (var light = 0u; light < parameters.light_count; light++) {
        if lights[light].kind != KIND_DISTANT || lights[light].role == ROLE_PROBE || lights[light].role == ROLE_SUN {
            continue;
        }
        let reach = acos(clamp(cosine_of_reach(light), -1.0, 1.0)) + margin;
        if dot(w, lights[light].direction) < cos(min(reach, PI)) {
            continue;
        }
        let chosen = parameters.has_light != 0u && light == parameters.light;
        let width = select(1.0, 2.0, chosen) * f32(view.size.x) / 1024.0;
        if samples_from_outline(light, sample) < max(width, 0.75) {
            textureStore(picture, id, vec4f(select(light_color(parameters.lights_before + light), vec3f(1.0), chosen), 1.0));
        }
    }
}

@compute @workgroup_size(TILE, TILE)
fn debug_view(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= view.size) {
        return;
    }
    if parameters.view == VIEW_LIGHTS {
        lights_view(id.xy);
        return;
    }
    var color = EMPTY;
    if parameters.view == VIEW_SHADOW_MAP {
        color = shadow_map_view(id.xy);
    } else {
        let depth = depth_at(id.xy);
        if depth > 0.0 {
            color = surface_view(id.xy, depth);
        }
    }
    textureStore(picture, id.xy, vec4f(color, 1.0));
}
