// Two colours in three words of halves.

const LARGEST_HALF: f32 = 65504.0;

struct ColorPair {
    first: vec3f,
    second: vec3f,
}

fn pack_color_pair(first: vec3f, second: vec3f) -> vec3u {
    let a = min(first, vec3f(LARGEST_HALF));
    let b = min(second, vec3f(LARGEST_HALF));
    return vec3u(pack2x16float(a.xy), pack2x16float(vec2f(a.z, b.x)), pack2x16float(b.yz));
}

fn unpack_color_pair(words: vec3u) -> ColorPair {
    let low = unpack2x16float(words.x);
    let middle = unpack2x16float(words.y);
    return ColorPair(vec3f(low, middle.x), vec3f(middle.y, unpack2x16float(words.z)));
}
