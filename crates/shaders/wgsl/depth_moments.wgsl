// Four filtered moments of depth, and what they tell about the depths behind them (Peters and Klein 2015). Of all distributions
// with these moments none has less weight in front of a depth d than the one of three atoms that has one of them at d
// (Hamburger's moment problem).

struct ThreeAtoms {
    // The first is d.
    depths: vec3f,
    weights: vec3f,
}

// Moments 1 to 4 of one depth in [-1, 1].
fn depth_moments(depth: f32) -> vec4f {
    let square = depth * depth;
    return vec4f(depth, square, square * depth, square * square);
}

// Moments moved by `bias` towards those of a wide distribution (Muenstermann et al. 2018, table 1: for depths in [-1, 1]).
// Rounding may have left moments that no distribution has, and those of fewer than three depths determine no three atoms.
fn biased_moments(moments: vec4f, bias: f32) -> vec4f {
    return mix(moments, vec4f(0.0, 0.375, 0.0, 0.375), bias);
}

// The distribution with the biased moments `b` and an atom at `d` (Peters and Klein 2015, algorithm 3).
fn three_atoms(b: vec4f, d: f32) -> ThreeAtoms {
    // Cholesky factors of the Hankel matrix (1 b.x b.y; b.x b.y b.z; b.y b.z b.w): L D L^T. Rounding must not end at 0.
    let d22 = max(b.y - b.x * b.x, 1e-10);
    let l32 = (b.z - b.x * b.y) / d22;
    let d33 = max(b.w - b.y * b.y - l32 * l32 * d22, 1e-10);
    // Hankel matrix x c = (1, d, d^2).
    var c = vec3f(1.0, d - b.x, 0.0);
    c.z = (d * d - b.y - l32 * c.y) / d33;
    c.y = c.y / d22 - l32 * c.z;
    c.x -= b.x * c.y + b.y * c.z;
    let weight = 1.0 / dot(c, vec3f(1.0, d, d * d));
    // The other two are the roots of c.x + c.y z + c.z z^2; where c.z is 0, one of them is infinitely far and weighs nothing.
    c.z = select(c.z, 1e-6, abs(c.z) < 1e-6);
    let root = sqrt(max(c.y * c.y - 4.0 * c.z * c.x, 0.0));
    let q = -0.5 * (c.y + select(-root, root, c.y >= 0.0));
    let z1 = q / c.z;
    let z2 = c.x / q;
    // Total weight 1 and mean b.x.
    let rest = 1.0 - weight;
    let weight_2 = (b.x - weight * d - rest * z1) / (z2 - z1);
    return ThreeAtoms(vec3f(d, z1, z2), vec3f(weight, rest - weight_2, weight_2));
}

// Least weight in front of d that any distribution with the same moments has (x), and the depth of its centre (y; `d` where
// there is none: Peters et al. 2016, section 4).
fn blockers_in_front(atoms: ThreeAtoms) -> vec2f {
    let d = atoms.depths.x;
    let in_front = select(vec2f(0.0), clamp(atoms.weights.yz, vec2f(0.0), vec2f(1.0)), atoms.depths.yz < vec2f(d));
    let weight = in_front.x + in_front.y;
    let sum = dot(in_front, clamp(atoms.depths.yz, vec2f(-1.0), vec2f(1.0)));
    return vec2f(min(weight, 1.0), select(d, sum / weight, weight > 0.0));
}
