#import math

// Size of a level. Some drivers answer a query for a level that differs between invocations with one invocation's level.
fn equirect_size(map: texture_2d<f32>, level: i32) -> vec2i {
    return max(vec2i(textureDimensions(map, 0)) >> vec2u(u32(level)), vec2i(1));
}

// Texel of an equirect map whose columns wrap, for one width beyond either side, and whose rows continue over the poles.
fn equirect_texel(map: texture_2d<f32>, x: i32, y: i32, level: i32) -> vec3f {
    let size = equirect_size(map, level);
    var column = x;
    var row = y;
    if row < 0 {
        row = -1 - row;
        column += size.x / 2;
    } else if row >= size.y {
        row = 2 * size.y - 1 - row;
        column += size.x / 2;
    }
    // Not by remainders: a whole division costs as much as the texel.
    column += select(0, size.x, column < 0);
    column -= select(0, size.x, column >= size.x);
    return textureLoad(map, vec2i(column, clamp(row, 0, size.y - 1)), level).rgb;
}

// Bilinear lookup without a seam: `Equirect::lookup`. Loads, not samples: radiance is 32-bit, and a sampler has a seam.
fn equirect_lookup(map: texture_2d<f32>, direction: vec3f, level: i32) -> vec3f {
    let position = uv_from_direction(direction) * vec2f(equirect_size(map, level)) - 0.5;
    let corner = vec2i(floor(position));
    let t = position - floor(position);
    let top = mix(equirect_texel(map, corner.x, corner.y, level), equirect_texel(map, corner.x + 1, corner.y, level), t.x);
    let bottom =
        mix(equirect_texel(map, corner.x, corner.y + 1, level), equirect_texel(map, corner.x + 1, corner.y + 1, level), t.x);
    return mix(top, bottom, t.y);
}

fn equirect_lookup_level(map: texture_2d<f32>, direction: vec3f, level: f32) -> vec3f {
    let last = f32(textureNumLevels(map) - 1u);
    let clamped = clamp(level, 0.0, last);
    let low = floor(clamped);
    let high = min(low + 1.0, last);
    return mix(equirect_lookup(map, direction, i32(low)), equirect_lookup(map, direction, i32(high)), clamped - low);
}
