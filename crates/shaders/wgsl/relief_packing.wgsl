#import math

// What is known of the bumps at a sample, as 32 bytes.

struct PackedRelief {
    // Normal of the surface under the bumps.
    n: vec3f,
    // Changes of x and y of the field's own space along the surface, in `frame_from_normal(n)`; all zero where there are no bumps.
    along_u: vec2f,
    along_v: vec2f,
    // Of an ellipse centre and shape (x x, x y), shape y y and the open share of the hemisphere; or eight horizons as t / (1 + t).
    lit_0: vec4f,
    lit_1: vec4f,
    // Share that does not depend on light's direction, its changes with x and y, and what a bounce has of the one before.
    scattering: vec4f,
}

fn pack_relief_frame(relief: PackedRelief) -> vec4u {
    return vec4u(
        pack2x16snorm(octahedral_encode(relief.n)),
        pack2x16float(relief.along_u),
        pack2x16float(relief.along_v),
        pack2x16float(relief.scattering.xw),
    );
}

// Share of the hemisphere above eight horizons.
fn open_share(lit_0: vec4f, lit_1: vec4f) -> f32 {
    let cosines_0 = (1.0 - lit_0) * (1.0 - lit_0) / ((1.0 - lit_0) * (1.0 - lit_0) + lit_0 * lit_0);
    let cosines_1 = (1.0 - lit_1) * (1.0 - lit_1) / ((1.0 - lit_1) * (1.0 - lit_1) + lit_1 * lit_1);
    return dot(cosines_0 + cosines_1, vec4f(0.125));
}

fn pack_relief_lit(relief: PackedRelief, shape: u32) -> vec4u {
    let slope = pack2x16float(relief.scattering.yz);
    if shape == RELIEF_HORIZONS {
        let open = pack2x16float(vec2f(0.0, open_share(relief.lit_0, relief.lit_1)));
        return vec4u(pack4x8unorm(relief.lit_0), pack4x8unorm(relief.lit_1), open, slope);
    }
    return vec4u(pack2x16float(relief.lit_0.xy), pack2x16float(relief.lit_0.zw), pack2x16float(relief.lit_1.xy), slope);
}
