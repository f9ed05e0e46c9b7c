#import shadow_buffer

// Whether the samples of a pixel show one smooth surface of one material: it is then lit and composed as one.

// Samples may lie so far off the plane of one of them [pixels].
const SMOOTH_HEIGHT: f32 = 0.25;
// Least (n . n') to the power that resampling has.
const SMOOTH_NORMALS: f32 = 0.9;
// What textures multiply a material's numbers with may differ by so much.
const SMOOTH_CHANGE: f32 = 0.1;

fn base_color_factor(reflectance: vec4u) -> vec3f {
    return vec3f(unpack2x16float(reflectance.x), unpack2x16float(reflectance.y & 0x7fffu).x);
}

// Roots of roughness, and metallic.
fn gloss_factors(reflectance: vec4u) -> vec2f {
    return vec2f(f32((reflectance.y >> 15u) & 0x3ffu) / 1023.0, f32(reflectance.y >> 25u) / 127.0);
}

fn is_smooth(pixel: vec2u) -> bool {
    let side = view.supersample;
    let corner = pixel * side;
    let middle = corner + side / 2u;
    let depth = depth_at(middle);
    let geometry = textureLoad(gbuffer_geometry, gbuffer_texel(middle), 0);
    let reflectance = textureLoad(gbuffer_reflectance, gbuffer_texel(middle), 0);
    let n = unpack_normal(geometry.x);
    let position = position_at(middle, max(depth, 1e-20));
    let plane_normal = unpack_normal(geometry.y);
    // The distance from the plane of a homogeneous point, and its w, as products with the place in clip space.
    let plane = vec4f(plane_normal, -dot(plane_normal, position)) * view.world_from_clip;
    let w = vec4f(view.world_from_clip[0].w, view.world_from_clip[1].w, view.world_from_clip[2].w, view.world_from_clip[3].w);
    let height = SMOOTH_HEIGHT * f32(side) * sample_extent_at(position);
    let least_cosine = pow(SMOOTH_NORMALS, 1.0 / normal_power_at(middle));
    for (var y = 0u; y < side; y++) {
        for (var x = 0u; x < side; x++) {
            let sample = corner + vec2u(x, y);
            let texel = gbuffer_texel(sample);
            let other_depth = textureLoad(gbuffer_depth, texel, 0);
            if (other_depth == 0.0) != (depth == 0.0) {
                return false;
            }
            if depth == 0.0 {
                continue;
            }
            let other = textureLoad(gbuffer_geometry, texel, 0);
            let clip = vec4f(ndc_of(sample), other_depth, 1.0);
            if (other.z >> 16u) != (geometry.z >> 16u)
                || abs(dot(plane, clip)) > height * abs(dot(w, clip))
                || (other.x != geometry.x && dot(n, unpack_normal(other.x)) < least_cosine) {
                return false;
            }
        }
    }
    for (var i = 0u; i < 4u && depth > 0.0; i++) {
        let other = textureLoad(gbuffer_reflectance, gbuffer_texel(spread_sample(corner, side, i)), 0);
        if any(other != reflectance) {
            let color = base_color_factor(reflectance);
            let gloss = abs(gloss_factors(other) - gloss_factors(reflectance));
            if any(abs(base_color_factor(other) - color) > vec3f(SMOOTH_CHANGE * (1.0 + max_component(color))))
                || any(gloss > vec2f(SMOOTH_CHANGE)) || other.z != reflectance.z {
                return false;
            }
        }
    }
    return true;
}
