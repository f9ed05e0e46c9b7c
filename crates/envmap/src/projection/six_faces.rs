use glam::Vec3;
use gnomon_picture::EnvironmentAttribute;

use super::{Entry, Projection, Unfolded};
use crate::Equirect;
use crate::grid::{CubeGrid, Sampling};
use crate::resample::equirect_from_faces;

pub(super) const ENTRY: Entry = Entry {
    projection: Projection::SixFaces,
    shape: "1:6 or 6:1",
    attribute: Some(EnvironmentAttribute::Cube),
    fits: |width, height| size(width, height).is_some(),
    unfold: |image, sampling| {
        let size = size(image.width(), image.height())?;
        let column = image.height() > image.width();
        let corner = |face: u32| if column { (0, face * size) } else { (face * size, 0) };
        let texel = |face: u32, x: u32, y: u32| image.get(corner(face).0 + x, corner(face).1 + y);
        Some(Box::new(Faces::new(size, sampling, texel)))
    },
};

fn size(width: u32, height: u32) -> Option<u32> {
    let (short, long) = (width.min(height), width.max(height));
    (short > 0 && u64::from(long) == 6 * u64::from(short)).then_some(short)
}

/// Six faces in the order and orientation of [`crate::CubeMap`]; every cubic layout ends here.
pub(super) struct Faces {
    size: u32,
    sampling: Sampling,
    texels: Vec<Vec3>,
}

impl Faces {
    /// `texel(face, x, y)` for faces of `size` x `size` texels.
    pub(super) fn new(size: u32, sampling: Sampling, texel: impl Fn(u32, u32, u32) -> Vec3) -> Self {
        let rows = (0..6).flat_map(|face| (0..size).map(move |y| (face, y)));
        let texels = rows.flat_map(|(face, y)| (0..size).map(move |x| (face, x, y)));
        Self { size, sampling, texels: texels.map(|(face, x, y)| texel(face, x, y)).collect() }
    }
}

impl Unfolded for Faces {
    fn texels_mut(&mut self) -> &mut [Vec3] {
        &mut self.texels
    }

    fn into_equirect(self: Box<Self>) -> Equirect {
        let grid = CubeGrid::new(self.size, self.sampling);
        equirect_from_faces(&grid, &self.texels, 4 * self.size, 2 * self.size)
    }
}
