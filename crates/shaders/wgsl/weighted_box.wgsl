// Stand-in for a light's outline as it shines on one receiver: the box with mean and variance of the outline's points, each weighted
// by its cosine at the receiver. What lies below the receiver's horizon shines on nothing, and shadows of what is close
// above it cost little light: an even mean over the outline would count them in full.
struct WeightedBox {
    // From the outline's own centre, along its two axes.
    center: vec2f,
    half_extent: vec2f,
}

// For the points c + x a + y b of a box, |x| and |y| up to `half_extent`: `cosines` are n.c, n.a and n.b. Across the receiver's
// horizon the box counts as even.
fn weighted_box(cosines: vec3f, half_extent: vec2f) -> WeightedBox {
    let steepness = length(cosines.yz);
    if steepness < 1e-4 {
        return WeightedBox(vec2f(0.0), half_extent);
    }
    let variances = half_extent * half_extent / 3.0;
    let across = cosines.yz / steepness;
    let variance = max(dot(across * across, variances), 1e-20);
    // From the horizon, or the outline's lower end, up to its upper end; weights rise linearly between.
    let upper = sqrt(3.0 * variance);
    let lower = clamp(-cosines.x / steepness, -upper, upper);
    let low_weight = max(cosines.x + steepness * lower, 0.0);
    let high_weight = max(cosines.x + steepness * upper, 0.0);
    let sum = max(low_weight + high_weight, 1e-9);
    let length = upper - lower;
    let mean = lower + length * (low_weight + 2.0 * high_weight) / (3.0 * sum);
    let product = low_weight * high_weight / (sum * sum);
    let left = length * length * (1.0 + 2.0 * product) / 18.0;
    // Regression of each axis on the direction across the horizon.
    let along = across * variances / variance;
    let rest = max(variances - (variance - left) * along * along, vec2f(0.0));
    return WeightedBox(mean * along, sqrt(3.0 * rest));
}
