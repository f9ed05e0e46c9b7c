//! Width of a soft shadow's edge along a line of pixels.

use std::f32::consts::PI;

/// Distance between the last crossings of two levels along a profile that rises from umbra to light, in samples
/// (interpolated linearly between them).
///
/// `visibility` is the fraction of the light that is seen, 0 in the umbra and 1 in full light; it may be noisy, so the
/// lower level counts from its first crossing and the upper one from the first crossing after it. A falling profile is
/// read backwards. `None` where a level is not crossed, or the levels are not `0 <= low < high <= 1`.
pub fn width_between(visibility: &[f32], low: f32, high: f32) -> Option<f32> {
    if !(0.0..1.0).contains(&low) || high <= low || high > 1.0 {
        return None;
    }
    let (first, last) = (visibility.first()?, visibility.last()?);
    let rising: Vec<f32> =
        if first <= last { visibility.to_vec() } else { visibility.iter().rev().copied().collect() };
    let start = crossing(&rising, 0.0, low)?;
    let end = crossing(&rising, start, high)?;
    Some(end - start)
}

/// First position at or after `from` where the profile reaches `level`.
fn crossing(profile: &[f32], from: f32, level: f32) -> Option<f32> {
    profile.windows(2).enumerate().skip(from as usize).find_map(|(index, pair)| {
        let reaches = pair[0] < level && pair[1] >= level;
        reaches.then(|| index as f32 + (level - pair[0]) / (pair[1] - pair[0]))
    })
}

/// Full penumbra width of a profile, from the distance between its 10 % and 90 % levels, for a uniform disk light cut
/// by a straight edge ([`disk_visibility`]), in samples.
pub fn disk_penumbra_width(visibility: &[f32]) -> Option<f32> {
    width_between(visibility, 0.1, 0.9).map(|width| width / DISK_10_TO_90)
}

/// Part of the full penumbra of a disk light that lies between the 10 % and 90 % levels.
const DISK_10_TO_90: f32 = 0.687_049;

/// Fraction of a uniform disk light that is seen past a straight edge. `position` is the receiver's place across the
/// penumbra, 0 where it begins (umbra) and 1 where it ends (full light); clamped outside.
///
/// The area of a unit circle to one side of a chord at signed distance `s`: `acos(s) - s sqrt(1 - s^2)`, over `pi`.
pub fn disk_visibility(position: f32) -> f32 {
    let s = (1.0 - 2.0 * position).clamp(-1.0, 1.0);
    (s.acos() - s * (1.0 - s * s).max(0.0).sqrt()) / PI
}

#[cfg(test)]
mod tests {
    use super::*;

    fn disk_profile(width: f32) -> Vec<f32> {
        (0..200).map(|x| disk_visibility((x as f32 - 100.0) / width + 0.5)).collect()
    }

    #[test]
    fn a_linear_ramp_has_its_own_width() {
        let ramp: Vec<f32> = (0..101).map(|x| (x as f32 / 100.0).clamp(0.0, 1.0)).collect();
        assert!((width_between(&ramp, 0.1, 0.9).unwrap() - 80.0).abs() < 1e-3);
        let falling: Vec<f32> = ramp.iter().rev().copied().collect();
        assert!((width_between(&falling, 0.25, 0.75).unwrap() - 50.0).abs() < 1e-3);
    }

    #[test]
    fn disk_visibility_has_its_closed_form_values() {
        assert_eq!(disk_visibility(-1.0), 0.0);
        assert_eq!(disk_visibility(2.0), 1.0);
        assert!((disk_visibility(0.5) - 0.5).abs() < 1e-6);
        // A chord at half the radius cuts off (pi/3 - sqrt(3)/4) / pi of the disk.
        assert!((disk_visibility(0.25) - 0.195_501).abs() < 1e-5);
    }

    #[test]
    fn disk_penumbra_width_is_recovered_and_a_wrong_one_is_seen() {
        for width in [10.0, 40.0, 90.0] {
            let measured = disk_penumbra_width(&disk_profile(width)).unwrap();
            assert!((measured / width - 1.0).abs() < 0.01, "{measured} for {width}");
        }
        let doubled = disk_penumbra_width(&disk_profile(80.0)).unwrap();
        assert!((doubled / 40.0 - 1.0).abs() > gnomon_testing::tolerances::PENUMBRA_WIDTH);
    }

    #[test]
    fn profiles_without_a_penumbra_have_no_width() {
        assert_eq!(disk_penumbra_width(&[]), None);
        assert_eq!(disk_penumbra_width(&[1.0; 10]), None);
        assert_eq!(disk_penumbra_width(&[0.0, 0.05, 0.3]), None);
        assert_eq!(disk_penumbra_width(&[f32::NAN; 5]), None);
        assert_eq!(width_between(&[0.0, 1.0], 0.9, 0.1), None);
        // A hard edge: the whole step lies between two samples.
        assert!(disk_penumbra_width(&[0.0, 0.0, 1.0, 1.0]).unwrap() < 1.2);
    }
}
