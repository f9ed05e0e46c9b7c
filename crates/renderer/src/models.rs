//! Which reflectance models shaders are compiled for: each costs time before the first picture, and time of every sample on processors that take
//! all branches.

use gnomon_brdf::{Model, Surface};

/// A set of [`Model`]s, by their places among all, and whether anything lies on one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Models(u32);

/// The bit of surfaces on whose base anything lies.
const FINISH: u32 = 1 << 31;

impl Default for Models {
    /// What files have unless they say otherwise, and the cheapest: few scenes need others.
    fn default() -> Self {
        Self(0).with_model(Model::default()).with_model(Model::Lambert)
    }
}

impl Models {
    /// All that there are.
    pub fn all() -> Self {
        Model::ALL.iter().fold(Self(FINISH), |models, model| models.with_model(*model))
    }

    /// The same and those of these surfaces.
    pub fn with(self, surfaces: &[Surface]) -> Self {
        surfaces.iter().fold(self, |models, surface| {
            let finish = if surface.finish().is_present() { FINISH } else { 0 };
            Self(models.with_model(surface.model).0 | finish)
        })
    }

    /// For the slot `brdf_models`.
    pub fn names(self) -> String {
        let used = Model::ALL.iter().filter(|model| self == self.with_model(**model));
        let finish = (self.0 & FINISH != 0).then_some("finish");
        used.map(|model| model.name()).chain(finish).collect::<Vec<_>>().join(" ")
    }

    fn with_model(self, model: Model) -> Self {
        let place = Model::ALL.iter().position(|other| *other == model);
        Self(self.0 | place.map_or(0, |place| 1 << place))
    }
}
