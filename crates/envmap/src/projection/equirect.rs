use glam::Vec3;
use gnomon_picture::{EnvironmentAttribute, RgbImage};

use super::{Entry, Projection, Unfolded};
use crate::Equirect;
use crate::grid::Sampling;
use crate::resample::equirect_from_picture;

pub(super) const ENTRY: Entry = Entry {
    projection: Projection::Equirect,
    shape: "2:1",
    attribute: Some(EnvironmentAttribute::LatLong),
    // Some programs round one side, and cut a row.
    fits: |width, height| height > 0 && (f64::from(width) / f64::from(height) - 2.0).abs() <= 0.02,
    unfold: |image, sampling| {
        let filled = image.width() > 0 && image.height() > 0;
        filled.then(|| Box::new(Texels { image, sampling }) as Box<dyn Unfolded>)
    },
};

struct Texels {
    image: RgbImage,
    sampling: Sampling,
}

impl Unfolded for Texels {
    fn texels_mut(&mut self) -> &mut [Vec3] {
        self.image.texels_mut()
    }

    fn into_equirect(self: Box<Self>) -> Equirect {
        let (width, height) = (self.image.width(), self.image.height());
        match self.sampling {
            Sampling::Areas => Equirect::new(self.image),
            Sampling::EdgeToEdge => equirect_from_picture(&self.image, self.sampling, width, height),
        }
    }
}
