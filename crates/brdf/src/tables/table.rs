use glam::Vec3;

/// Values at evenly spaced arguments, interpolated linearly between them.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    pub(super) columns: usize,
    /// Row by row.
    pub(super) values: Vec<Vec3>,
}

impl Table {
    /// `value(x, y)` at every texel, x and y running from 0 to 1. Both sizes are at least 1; the only texel of a row stands for 0.
    pub fn from_fn(columns: usize, rows: usize, value: impl Fn(f32, f32) -> Vec3) -> Self {
        let place = |i: usize, count: usize| i as f32 / (count.max(2) - 1) as f32;
        let texels =
            (0..columns * rows).map(|i| value(place(i % columns, columns), place(i / columns, rows)));
        Self { columns, values: texels.collect() }
    }

    /// A table of rows of so many values; `None` where they do not fill rows, or there is none.
    pub fn of_rows(columns: usize, values: Vec<Vec3>) -> Option<Self> {
        (columns > 0 && !values.is_empty() && values.len().is_multiple_of(columns))
            .then_some(Self { columns, values })
    }

    /// Values a row.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Rows.
    pub fn rows(&self) -> usize {
        self.values.len() / self.columns
    }

    /// Row by row.
    pub fn values(&self) -> &[Vec3] {
        &self.values
    }

    pub(super) fn scale(&mut self, by: f32) {
        self.values.iter_mut().for_each(|value| *value *= by);
    }

    /// Interpolated at x and y from 0 to 1. Where it is `periodic`, the first row follows after the last one.
    pub fn at(&self, x: f32, y: f32, periodic: bool) -> Vec3 {
        let rows = self.rows();
        let x = x.clamp(0.0, 1.0) * (self.columns - 1) as f32;
        let y = y.clamp(0.0, 1.0) * if periodic { rows } else { rows - 1 } as f32;
        let (left, low) = ((x as usize).min(self.columns - 1), (y as usize).min(rows - 1));
        let right = (left + 1).min(self.columns - 1);
        let high = if low + 1 < rows {
            low + 1
        } else if periodic {
            0
        } else {
            low
        };
        let row = |row: usize| {
            let of_row = &self.values[row * self.columns..];
            of_row[left].lerp(of_row[right], x - left as f32)
        };
        row(low).lerp(row(high), y - low as f32)
    }
}

/// Where in a table an argument in `[0, 1]` lies: half of the columns are for arguments below `scale / (1 + 2 scale)`, about `scale` where
/// that is small. 0 spreads nothing.
pub fn spread_place(argument: f32, scale: f32) -> f32 {
    if scale > 0.0 { argument * (1.0 + scale) / (argument + scale) } else { argument }
}

/// The argument that [`spread_place`] puts there.
pub fn unspread_place(place: f32, scale: f32) -> f32 {
    if scale > 0.0 { scale * place / (1.0 + scale - place) } else { place }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_inverse() {
        for scale in [0.0, 0.01, 0.3, 2.0] {
            for i in 0..=20 {
                let argument = i as f32 / 20.0;
                assert!((unspread_place(spread_place(argument, scale), scale) - argument).abs() < 1e-5);
            }
        }
    }

    #[test]
    fn rows_go_round() {
        let table = Table::of_rows(1, vec![Vec3::ZERO, Vec3::ONE]).unwrap();
        assert_eq!(table.at(0.0, 0.75, true), Vec3::splat(0.5));
        assert_eq!(table.at(0.0, 0.75, false), Vec3::splat(0.75));
        assert_eq!(table.at(2.0, 1.0, true), Vec3::ZERO);
        assert!(Table::of_rows(2, vec![Vec3::ZERO; 3]).is_none());
    }
}
