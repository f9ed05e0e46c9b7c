#import math

// The normals of a triangle's corners in the lower 60 of 64 bits. Twin: `hit_normals.rs`.

// A unit vector in 20 bits, never 0; a zero vector is 0.
fn pack_20(n: vec3f) -> u32 {
    if dot(n, n) == 0.0 {
        return 0u;
    }
    let q = vec2u(floor((octahedral_encode(n) * 0.5 + 0.5) * 1022.0 + 1.5));
    return q.x | (q.y << 10u);
}

fn unpack_20(bits: u32) -> vec3f {
    if bits == 0u {
        return vec3f(0.0);
    }
    let q = vec2f(vec2u(bits, bits >> 10u) & vec2u(0x3ffu));
    return octahedral_decode((q - 1.0) / 1022.0 * 2.0 - 1.0);
}

fn pack_thirds(a: vec3f, b: vec3f, c: vec3f) -> vec2u {
    let middle = pack_20(b);
    return vec2u(pack_20(a) | (middle << 20u), (middle >> 12u) | (pack_20(c) << 8u));
}

// One of the three.
fn unpack_third(words: vec2u, which: u32) -> vec3f {
    let of_three = array(words.x & 0xfffffu, (words.x >> 20u) | ((words.y & 0xffu) << 12u), (words.y >> 8u) & 0xfffffu);
    return unpack_20(of_three[which]);
}
