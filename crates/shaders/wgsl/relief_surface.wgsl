#import gbuffer_surface

// What is known of the bumps at a sample, for passes over the screen.

@group(GROUP_SURFACE) @binding(7) var relief_frames: texture_2d<u32>;
@group(GROUP_SURFACE) @binding(8) var relief_lit: texture_2d<u32>;

struct Relief {
    // Whether there are any.
    covers: bool,
    // Normal of the surface under them, towards the viewer.
    n: vec3f,
    // Takes directions of the world to the field's own space.
    along_u: vec3f,
    along_v: vec3f,
    // See `PackedRelief`; of `lit` as many words as the lit directions' shape takes.
    lit: vec3u,
    scattering: vec4f,
    open: f32,
}

fn relief_at(sample: vec2u) -> Relief {
    let texel = gbuffer_texel(sample);
    let frame = textureLoad(relief_frames, texel, 0);
    let lit = textureLoad(relief_lit, texel, 0);
    var relief: Relief;
    relief.covers = (frame.y | frame.z) != 0u;
    relief.n = unpack_normal(frame.x);
    let about = frame_from_normal(relief.n);
    let u = unpack2x16float(frame.y);
    let v = unpack2x16float(frame.z);
    relief.along_u = u.x * about.t + u.y * about.b;
    relief.along_v = v.x * about.t + v.y * about.b;
    let even = unpack2x16float(frame.w);
    relief.scattering = vec4f(even.x, unpack2x16float(lit.w), even.y);
    relief.lit = lit.xyz;
    relief.open = unpack2x16float(lit.z).y;
    return relief;
}

// A direction of the world in the field's own space, unit.
fn relief_direction(relief: Relief, direction: vec3f) -> vec3f {
    return normalize(vec3f(dot(relief.along_u, direction), dot(relief.along_v, direction), dot(relief.n, direction)));
}
