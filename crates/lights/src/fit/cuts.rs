use super::faces::{Faces, TexelRect, luminance};
use super::growth::ROUNDING;

/// A rectangle of a face that becomes one uniform light.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    pub(super) face: usize,
    pub(super) rect: TexelRect,
}

/// Divides what is left on all faces into `count` rectangles by the cuts that most reduce the [`discrepancy`], and further until none is wider than `max_extent` [rad]. Black faces get none.
pub(super) fn cut_faces(faces: &Faces, count: usize, max_extent: f64) -> Vec<Cell> {
    let sums: Vec<FaceSums> = (0..6).map(|face| FaceSums::new(faces, face)).collect();
    let planned = |cell: Cell| {
        let too_wide = faces.extent(cell.rect).map(|angle| angle > max_extent);
        (cell, sums[cell.face].best_cut(cell.rect, too_wide))
    };
    let mut cells: Vec<(Cell, Option<Cut>)> = (0..6)
        .filter(|face| faces.flux[*face].iter().any(|flux| luminance(*flux) > 0.0))
        .map(|face| planned(Cell { face, rect: TexelRect::face(faces.size) }))
        .collect();
    loop {
        let room = count.saturating_sub(cells.len());
        let next = cells
            .iter()
            .enumerate()
            .filter_map(|(index, (_, cut))| {
                let cut = (*cut).as_ref()?;
                // Too wide goes first, whatever the count.
                let priority = if cut.forced { f64::INFINITY } else { cut.gain };
                (cut.forced || cut.parts.len() - 1 <= room).then_some((priority, index))
            })
            .max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
        let Some((_, index)) = next else { break };
        let (cell, cut) = cells.remove(index);
        let parts = cut.map(|cut| cut.parts).unwrap_or_default();
        cells.extend(parts.into_iter().map(|rect| planned(Cell { face: cell.face, rect })));
    }
    cells.into_iter().map(|(cell, _)| cell).collect()
}

/// A cut of a cell into smaller ones.
struct Cut {
    /// How much it reduces the discrepancy, for each light that it adds.
    gain: f64,
    /// Whether the cell is too wide.
    forced: bool,
    parts: Vec<TexelRect>,
}

/// Luminous flux and solid angle of any rectangle of one face, by summed-area tables.
struct FaceSums {
    size: usize,
    /// `(size + 1)^2` sums over all texels above and to the left: flux, solid angle.
    table: Vec<[f64; 2]>,
}

impl FaceSums {
    fn new(faces: &Faces, face: usize) -> Self {
        let (size, stride) = (faces.size, faces.size + 1);
        let mut table = vec![[0.0; 2]; stride * stride];
        for y in 0..size {
            let mut row = [0.0; 2];
            for x in 0..size {
                let texel = y * size + x;
                row[0] += luminance(faces.flux[face][texel]);
                row[1] += faces.solid_angle[texel];
                let above = table[y * stride + x + 1];
                table[(y + 1) * stride + x + 1] = [above[0] + row[0], above[1] + row[1]];
            }
        }
        Self { size, table }
    }

    fn sum(&self, rect: TexelRect) -> [f64; 2] {
        let at = |x: usize, y: usize| self.table[y * (self.size + 1) + x];
        let ([x0, y0], [x1, y1]) = (rect.min, rect.max);
        [0, 1].map(|i| at(x1, y1)[i] - at(x0, y1)[i] - at(x1, y0)[i] + at(x0, y0)[i])
    }

    /// How badly one uniform light stands for a rectangle: over all straight cuts along its two axes, the sum of the
    /// squared error of the flux on one side. That is what an occluder's edge across the light does to irradiance.
    fn discrepancy(&self, rect: TexelRect) -> f64 {
        let [flux, solid_angle] = self.sum(rect);
        let mean = flux / solid_angle;
        (0..2)
            .flat_map(|axis| (rect.min[axis] + 1..rect.max[axis]).map(move |at| (axis, at)))
            .map(|(axis, at)| {
                let [flux, solid_angle] = self.sum(rect.split(axis, at)[0]);
                (flux - mean * solid_angle).powi(2)
            })
            .sum()
    }

    /// The cut that gains most; only across the axes that are `too_wide`, if any is. `None` where there is nothing to
    /// gain beyond rounding.
    fn best_cut(&self, rect: TexelRect, too_wide: [bool; 2]) -> Option<Cut> {
        let forced = too_wide[0] || too_wide[1];
        let whole = self.discrepancy(rect);
        let [face_flux, _] = self.sum(TexelRect::face(self.size));
        let flat = whole <= (ROUNDING * face_flux).powi(2);
        if flat && !forced {
            return None;
        }
        let cut = |parts: Vec<TexelRect>| {
            let rest: f64 = parts.iter().map(|part| self.discrepancy(*part)).sum();
            Cut { gain: (whole - rest) / (parts.len() - 1) as f64, forced, parts }
        };
        if flat {
            // Across both axes at once: nothing tells one from the other.
            let mut parts = vec![rect];
            for axis in (0..2).filter(|axis| too_wide[*axis]) {
                // Of the two middles of an odd number of texels, the one nearer the face's: turned faces agree on it.
                let ends = rect.min[axis] + rect.max[axis];
                let middle = if ends < self.size { ends.div_ceil(2) } else { ends / 2 };
                if middle > rect.min[axis] && middle < rect.max[axis] {
                    parts = parts.into_iter().flat_map(|part| part.split(axis, middle)).collect();
                }
            }
            return (parts.len() > 1).then(|| cut(parts));
        }
        (0..2)
            .filter(|axis| !forced || too_wide[*axis])
            .flat_map(|axis| {
                let (min, max) = (rect.min[axis], rect.max[axis]);
                // Slivers do not make a wide cell narrow.
                let margin = if forced { ((max - min) / 4).max(1) } else { 1 };
                (min + margin..=max - margin).map(move |at| (axis, at))
            })
            .map(|(axis, at)| cut(rect.split(axis, at).to_vec()))
            .max_by(|a, b| a.gain.total_cmp(&b.gain))
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use gnomon_envmap::Equirect;
    use gnomon_image::RgbImage;

    use super::*;

    fn faces(f: impl FnMut(u32, u32) -> Vec3) -> Faces {
        Faces::new(&Equirect::new(RgbImage::from_fn(256, 128, f)), 32)
    }

    fn covered(cells: &[Cell], faces: &Faces) -> usize {
        cells.iter().map(|cell| cell.rect.texels(faces.size).count()).sum()
    }

    #[test]
    fn cells_tile_every_lit_face_and_meet_the_count() {
        let faces = faces(|x, y| Vec3::splat(1.0 + ((x * 7 + y * 13) % 11) as f32));
        for count in [6, 7, 20, 61] {
            let cells = cut_faces(&faces, count, 9.0);
            assert_eq!((cells.len(), covered(&cells, &faces)), (count, 6 * 32 * 32));
        }
    }

    #[test]
    fn a_cut_falls_where_the_radiance_changes() {
        // Bright above the horizon: every side face is best cut in the middle of its height.
        let faces = faces(|_, y| Vec3::splat(if y < 64 { 10.0 } else { 1.0 }));
        let cells = cut_faces(&faces, 10, 9.0);
        let halves = cells.iter().filter(|cell| cell.rect.max[1] - cell.rect.min[1] == 16).count();
        assert_eq!(halves, 8);
    }

    #[test]
    fn a_largest_extent_overrules_the_count() {
        let faces = faces(|_, _| Vec3::ONE);
        let cells = cut_faces(&faces, 6, 0.9);
        assert!(cells.iter().all(|cell| faces.extent(cell.rect).into_iter().all(|angle| angle <= 0.9)));
        assert_eq!(covered(&cells, &faces), 6 * 32 * 32);
    }
}
