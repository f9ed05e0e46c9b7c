//! `pyramid_meets_box.wgsl`.

use glam::Vec3;

/// Whether any ray from the origin, each component of whose direction lies between those of `least` and `most`, none of them 0, meets a box
/// before `reach`, in lengths of its direction. It may say so of a box beside all of them, never the opposite.
pub fn pyramid_meets_box(least: Vec3, most: Vec3, low: Vec3, high: Vec3, reach: f32) -> bool {
    let (before, behind) = (high / least, low / most);
    let zero = Vec3::ZERO;
    let enters =
        Vec3::select(least.cmplt(zero), before, zero).max(Vec3::select(most.cmpgt(zero), behind, zero));
    let whole = Vec3::splat(reach);
    let leaves =
        Vec3::select(least.cmpgt(zero), before, whole).min(Vec3::select(most.cmplt(zero), behind, whole));
    enters.max_element() <= leaves.min_element()
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    /// Evenly spread numbers in [0, 1) (Roberts 2018).
    fn spread(i: u32, axis: u32) -> f32 {
        ((f64::from(i) + 1.0) * 0.754_877_666_246_693_f64.powi(axis as i32 + 1) * 7.0).fract() as f32
    }

    /// Where a ray enters and leaves a box, by slabs in double precision.
    fn crossed(direction: DVec3, low: DVec3, high: DVec3) -> (f64, f64) {
        let (a, b) = (low / direction, high / direction);
        (a.min(b).max_element().max(0.0), a.max(b).min_element())
    }

    #[test]
    fn no_box_that_a_ray_meets_is_missed() {
        let (mut met, mut missed) = (0, 0);
        for i in 0..4000 {
            let random = |axis: u32| spread(i, axis);
            let vector = |axis: u32| Vec3::new(random(axis), random(axis + 1), random(axis + 2));
            let middle = vector(0) * 2.0 - 1.0;
            let width = 0.3 * vector(3) + 1e-3;
            let (least, most) = (middle - width, middle + width);
            let low = middle + vector(6) * 2.0 - 1.5;
            let high = low + 1.5 * vector(9);
            let reach = 2.0 * random(12) + 2.0;
            let says = pyramid_meets_box(least, most, low, high, reach);
            let any = (0..200).any(|j| {
                let u = Vec3::new(spread(j, 0), spread(j, 1), spread(j, 2));
                let direction = (least + u * (most - least)).as_dvec3();
                let (enters, leaves) = crossed(direction, low.as_dvec3(), high.as_dvec3());
                enters < leaves && enters < f64::from(reach)
            });
            assert!(says || !any, "{least} {most} {low} {high}");
            met += u32::from(says);
            missed += u32::from(!says);
        }
        assert!(met > 400 && missed > 400, "{met} {missed}: it tells boxes apart");
    }
}
