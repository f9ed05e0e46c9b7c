use super::faces::{Faces, TexelRect, luminance};
use super::rectangles::Outline;

/// Relative differences of flux below this come from resampling in single precision.
pub(super) const ROUNDING: f64 = 1e-5;
/// Shares this close count as equal.
const TIE: f64 = 1e-9;

/// When a light stops growing.
#[derive(Clone, Copy, Debug)]
pub(super) struct Growth {
    pub(super) outline: Outline,
    /// A side grows while it adds more than this share of the grown light's flux.
    pub(super) threshold: f64,
    /// Largest angular width and height [rad].
    pub(super) max_extent: f64,
}

impl Growth {
    /// The light that grows from one texel (Annen et al. 2008, section 4.2): of all growths that the threshold allows,
    /// the one that adds the largest share goes first, so that the result does not hang on the order of the sides.
    /// `flux` is the luminous flux of the face's texels, and `original` what it was before any light was taken out: it
    /// decides between growths into flat residue that share the same symmetry.
    pub(super) fn grow(&self, faces: &Faces, flux: &[f64], original: &[f64], seed: usize) -> TexelRect {
        let size = faces.size;
        let sum = |rect: TexelRect| rect.texels(size).map(|texel| flux[texel]).sum::<f64>();
        let originally = |rect: TexelRect| rect.texels(size).map(|texel| original[texel]).sum::<f64>();
        let corner = [seed % size, seed / size];
        let mut rect = TexelRect { min: corner, max: corner.map(|c| c + 1) };
        let mut total = sum(rect);
        // A corner grows two sides at once, each of which has to earn its share.
        let threshold = match self.outline {
            Outline::Rectangle => self.threshold,
            Outline::Square => 2.0 * self.threshold,
        };
        loop {
            let mut best: Option<(f64, f64, f64, TexelRect)> = None;
            for grown in self.grown(rect, size) {
                if faces.extent(grown).into_iter().any(|angle| angle > self.max_extent) {
                    continue;
                }
                let strips = added_strips(rect, grown);
                let added: f64 = strips.into_iter().map(sum).sum();
                let share = if total + added > 0.0 { added / (total + added) } else { 1.0 };
                if share <= threshold {
                    continue;
                }
                let before: f64 = strips.into_iter().map(originally).sum();
                let wins = |(most, most_before, ..): (f64, f64, f64, TexelRect)| {
                    share > most + TIE || (share >= most - TIE && before > most_before)
                };
                if best.is_none_or(wins) {
                    best = Some((share, before, added, grown));
                }
            }
            let Some((.., added, grown)) = best else { return rect };
            rect = grown;
            total += added;
        }
    }

    /// The rectangle after every growth by one texel that stays on the face.
    fn grown(&self, rect: TexelRect, size: usize) -> impl Iterator<Item = TexelRect> {
        // Steps of the low and high side of each axis.
        let steps: [[[usize; 2]; 2]; 4] = match self.outline {
            Outline::Rectangle => [[[1, 0], [0, 0]], [[0, 1], [0, 0]], [[0, 0], [1, 0]], [[0, 0], [0, 1]]],
            Outline::Square => [[[1, 0], [1, 0]], [[0, 1], [1, 0]], [[1, 0], [0, 1]], [[0, 1], [0, 1]]],
        };
        steps.into_iter().filter_map(move |step| {
            let mut grown = rect;
            for (axis, [low, high]) in step.into_iter().enumerate() {
                grown.min[axis] = rect.min[axis].checked_sub(low)?;
                grown.max[axis] = rect.max[axis] + high;
            }
            (grown.max[0] <= size && grown.max[1] <= size).then_some(grown)
        })
    }
}

/// The texels that `grown` has and `rect` has not, as up to four rectangles.
fn added_strips(rect: TexelRect, grown: TexelRect) -> [TexelRect; 4] {
    let columns = |from, to| TexelRect { min: [from, grown.min[1]], max: [to, grown.max[1]] };
    let rows = |from, to| TexelRect { min: [rect.min[0], from], max: [rect.max[0], to] };
    [
        columns(grown.min[0], rect.min[0]),
        columns(rect.max[0], grown.max[0]),
        rows(grown.min[1], rect.min[1]),
        rows(rect.max[1], grown.max[1]),
    ]
}

/// Takes a light's flux out of a rectangle of a face and leaves every texel at `residue` radiance, or at the
/// rectangle's mean in a channel where that is lower. Returns the flux taken.
pub(super) fn take(faces: &mut Faces, face: usize, rect: TexelRect, residue: glam::DVec3) -> glam::DVec3 {
    let solid_angle: f64 = rect.texels(faces.size).map(|texel| faces.solid_angle[texel]).sum();
    let total = faces.rect_flux(face, rect);
    let left = residue.min(total / solid_angle);
    for texel in rect.texels(faces.size) {
        faces.flux[face][texel] = left * faces.solid_angle[texel];
    }
    (total - left * solid_angle).max(glam::DVec3::ZERO)
}

/// Luminous flux of every texel of a face.
pub(super) fn luminous(faces: &Faces, face: usize) -> Vec<f64> {
    faces.flux[face].iter().map(|flux| luminance(*flux)).collect()
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, Vec3};
    use gnomon_envmap::Equirect;
    use gnomon_picture::RgbImage;

    use super::*;

    fn constant(size: usize) -> Faces {
        Faces::new(&Equirect::new(RgbImage::filled(64, 32, Vec3::ONE)), size)
    }

    fn growth(outline: Outline, threshold: f64, max_extent: f64) -> Growth {
        Growth { outline, threshold, max_extent }
    }

    /// A face with flux 1 on the texels of `rect` and nothing elsewhere.
    fn lit(size: usize, rect: TexelRect) -> Vec<f64> {
        let mut flux = vec![0.0; size * size];
        rect.texels(size).for_each(|texel| flux[texel] = 1.0);
        flux
    }

    #[test]
    fn a_rectangle_grows_to_a_bright_patch_and_no_further() {
        let patch = TexelRect { min: [3, 5], max: [11, 8] };
        let rect = growth(Outline::Rectangle, 0.05, 9.0).grow(
            &constant(16),
            &lit(16, patch),
            &lit(16, patch),
            6 * 16 + 4,
        );
        assert_eq!(rect, patch);
    }

    #[test]
    fn a_square_stays_square_and_on_the_face() {
        let patch = TexelRect { min: [9, 1], max: [16, 8] };
        let rect = growth(Outline::Square, 0.02, 9.0).grow(
            &constant(16),
            &lit(16, patch),
            &lit(16, patch),
            3 * 16 + 12,
        );
        assert_eq!(rect, patch);
    }

    #[test]
    fn growth_stops_at_the_largest_extent_and_at_the_threshold() {
        let faces = constant(32);
        let flux = luminous(&faces, 0);
        let rect = growth(Outline::Rectangle, 1e-3, 0.5).grow(&faces, &flux, &flux, 16 * 32 + 16);
        assert!(faces.extent(rect).into_iter().all(|angle| angle <= 0.5 && angle > 0.4));
        // A uniform light of s texels gains 1 / (s + 1) by another column, so it stops near s = 1 / t.
        let rect = growth(Outline::Rectangle, 0.1, 9.0).grow(&faces, &flux, &flux, 16 * 32 + 16);
        assert!((8..=12).contains(&(rect.max[0] - rect.min[0])), "{rect:?}");
    }

    #[test]
    fn taking_a_light_out_keeps_the_flux_and_leaves_the_residue() {
        let mut faces = constant(8);
        let rect = TexelRect { min: [2, 2], max: [5, 4] };
        let before: DVec3 = faces.flux[1].iter().sum();
        let taken = take(&mut faces, 1, rect, DVec3::new(0.25, 0.5, 2.0));
        let after: DVec3 = faces.flux[1].iter().sum();
        assert!((before - after - taken).length() < 1e-12);
        // Residue above what is there: nothing is taken, nothing is added.
        assert!(taken.x > 0.0 && taken.z.abs() < 1e-12);
        let texel = faces.flux[1][3 * 8 + 3] / faces.solid_angle[3 * 8 + 3];
        assert!((texel - DVec3::new(0.25, 0.5, 1.0)).length() < 1e-4);
    }
}
