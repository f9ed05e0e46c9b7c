//! Unfolded cubes. In both crosses the face towards -z sits in the middle with +x to its right and +y above, so every face
//! but one is already in OpenEXR's orientation.

use super::six_faces::Faces;
use super::{Entry, Projection, Unfolded};

/// Debevec's: rows `+y`; `-x -z +x`; `-y`; `+z` turned by half.
pub(super) const VERTICAL: Entry = Entry {
    projection: Projection::VerticalCross,
    shape: "3:4",
    attribute: None,
    fits: |width, height| size(width, height, 3, 4).is_some(),
    unfold: |image, sampling| {
        let size = size(image.width(), image.height(), 3, 4)?;
        let texel = |face: u32, x: u32, y: u32| match face {
            4 => image.get(2 * size - 1 - x, 4 * size - 1 - y),
            _ => {
                let (column, row) = [(2, 1), (0, 1), (1, 0), (1, 2), (1, 3), (1, 1)][face as usize];
                image.get(column * size + x, row * size + y)
            }
        };
        Some(Box::new(Faces::new(size, sampling, texel)) as Box<dyn Unfolded>)
    },
};

/// `+y` above and `-y` below the second face of the row `-x -z +x +z`.
pub(super) const HORIZONTAL: Entry = Entry {
    projection: Projection::HorizontalCross,
    shape: "4:3",
    attribute: None,
    fits: |width, height| size(width, height, 4, 3).is_some(),
    unfold: |image, sampling| {
        let size = size(image.width(), image.height(), 4, 3)?;
        let texel = |face: u32, x: u32, y: u32| {
            let (column, row) = [(2, 1), (0, 1), (1, 0), (1, 2), (3, 1), (1, 1)][face as usize];
            image.get(column * size + x, row * size + y)
        };
        Some(Box::new(Faces::new(size, sampling, texel)) as Box<dyn Unfolded>)
    },
};

fn size(width: u32, height: u32, columns: u32, rows: u32) -> Option<u32> {
    let size = width / columns;
    (size > 0 && size * columns == width && u64::from(size) * u64::from(rows) == u64::from(height))
        .then_some(size)
}
