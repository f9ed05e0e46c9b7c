// Levels of a prefiltered environment. The first is a mirror's, the last that of GGX alpha = 1; alpha doubles from the second on.

// The level, with a fraction, of which linear interpolation between levels has the lobe's height for `alpha`: that goes with
// 1 / alpha^2.
fn prefiltered_level(alpha: f32, last: f32) -> f32 {
    let first = exp2(1.0 - last);
    let clamped = saturate(alpha);
    if last < 1.0 {
        return 0.0;
    }
    if clamped < first {
        let ratio = clamped / first;
        return ratio * ratio;
    }
    let below = floor(log2(clamped / first));
    let ratio = first * exp2(below) / clamped;
    return min(1.0 + below + 4.0 / 3.0 * (1.0 - ratio * ratio), last);
}
