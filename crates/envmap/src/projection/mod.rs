//! How a picture covers the sphere of directions. A new projection is one file here, its variant of [`Projection`] and its line in
//! [`PROJECTIONS`].

mod angular_probe;
mod cross;
mod equirect;
mod six_faces;

use glam::Vec3;
use gnomon_options::choices;
use gnomon_picture::{EnvironmentAttribute, RgbImage};

use crate::Equirect;
use crate::grid::Sampling;

choices! {
    /// How an environment picture is laid out; `CONVENTIONS.md` gives the axes of each.
    pub enum Projection {
        /// Latitude-longitude, 2 wide to 1 high.
        Equirect = "equirect",
        /// Six faces as a cross 3 wide and 4 high (Debevec).
        VerticalCross = "vertical-cross",
        /// Six faces as a cross 4 wide and 3 high.
        HorizontalCross = "horizontal-cross",
        /// Six faces in a column or a row (OpenEXR).
        SixFaces = "six-faces",
        /// Angular map of a mirror ball: the whole sphere in a disc (Debevec).
        AngularProbe = "angular-probe",
        /// The same with front and back exchanged (OpenImageIO); only by name.
        MirroredProbe = "mirrored-probe",
    }
}

/// What one projection provides.
struct Entry {
    projection: Projection,
    /// Its shape, for people.
    shape: &'static str,
    /// The `envmap` attribute that announces it.
    attribute: Option<EnvironmentAttribute>,
    /// Whether a picture of this width and height looks like it.
    fits: fn(u32, u32) -> bool,
    /// Takes the picture apart, if its size allows.
    unfold: fn(RgbImage, Sampling) -> Option<Box<dyn Unfolded>>,
}

/// Every projection; the first that fits a picture's shape is taken.
const PROJECTIONS: &[Entry] = &[
    equirect::ENTRY,
    cross::VERTICAL,
    cross::HORIZONTAL,
    six_faces::ENTRY,
    angular_probe::ENTRY,
    angular_probe::MIRRORED,
];

/// The texels of a picture that belong to the map, free of layout.
pub(crate) trait Unfolded {
    /// The texels, to clean them.
    fn texels_mut(&mut self) -> &mut [Vec3];
    /// The map they make, resampled with every channel's flux kept.
    fn into_equirect(self: Box<Self>) -> Equirect;
}

impl Projection {
    /// The shape that announces it, for people.
    pub fn shape(self) -> &'static str {
        self.entry().map_or("", |entry| entry.shape)
    }

    /// The projection that an EXR file's `envmap` attribute or else the picture's shape announces.
    pub fn detect(width: u32, height: u32, attribute: Option<EnvironmentAttribute>) -> Option<Self> {
        let by_attribute =
            PROJECTIONS.iter().find(|entry| attribute.is_some() && entry.attribute == attribute);
        let by_shape = || PROJECTIONS.iter().find(|entry| (entry.fits)(width, height));
        by_attribute.or_else(by_shape).map(|entry| entry.projection)
    }

    /// One line that names every projection with its shape.
    pub(crate) fn list() -> String {
        let one = |entry: &Entry| format!("{} ({})", entry.projection.name(), entry.shape);
        PROJECTIONS.iter().map(one).collect::<Vec<_>>().join(", ")
    }

    /// Takes a picture apart; `None` if its size does not allow this projection.
    pub(crate) fn unfold(
        self,
        image: RgbImage,
        attribute: Option<EnvironmentAttribute>,
    ) -> Option<Box<dyn Unfolded>> {
        (self.entry()?.unfold)(image, self.sampling(attribute))
    }

    /// What the texels of a picture with this attribute stand for.
    pub(crate) fn sampling(self, attribute: Option<EnvironmentAttribute>) -> Sampling {
        let announced = self.entry().is_some_and(|entry| attribute.is_some() && entry.attribute == attribute);
        if announced { Sampling::EdgeToEdge } else { Sampling::Areas }
    }

    fn entry(self) -> Option<&'static Entry> {
        PROJECTIONS.iter().find(|entry| entry.projection == self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_projection_is_registered_once_and_found_by_name() {
        for &projection in Projection::ALL {
            assert_eq!(Projection::from_name(projection.name()), Some(projection));
            assert_eq!(PROJECTIONS.iter().filter(|entry| entry.projection == projection).count(), 1);
        }
        assert_eq!(Projection::from_name("mercator"), None);
    }

    #[test]
    fn shapes_are_recognised() {
        let shapes = [
            (1024, 512, Some(Projection::Equirect)),
            (1000, 499, Some(Projection::Equirect)),
            (2, 1, Some(Projection::Equirect)),
            (768, 1024, Some(Projection::VerticalCross)),
            (1024, 768, Some(Projection::HorizontalCross)),
            (256, 1536, Some(Projection::SixFaces)),
            (1536, 256, Some(Projection::SixFaces)),
            (128, 128, Some(Projection::AngularProbe)),
            (1, 1, Some(Projection::AngularProbe)),
            (1000, 100, None),
            (1, 1000, None),
            (0, 0, None),
        ];
        for (width, height, expected) in shapes {
            assert_eq!(Projection::detect(width, height, None), expected, "{width} x {height}");
        }
        let cube = Some(EnvironmentAttribute::Cube);
        assert_eq!(Projection::detect(256, 1536, cube), Some(Projection::SixFaces));
    }
}
