//! Where the unshadowed light that shadows are taken from comes from, side by side on one interface (DeCoro and Rusinkiewicz 2008,
//! section 3.1).

use gnomon_brdf::Surface;
use gnomon_options::Choice;
use gnomon_shaders::layout::CachedLobe;

use crate::RenderError;

/// A source of unshadowed light.
#[derive(Debug, PartialEq, Eq)]
pub struct Unshadowed {
    /// Name for people and files.
    pub name: &'static str,
    /// One line for help texts.
    pub summary: &'static str,
    /// Matte surfaces take nine spherical harmonics instead of the irradiance map.
    pub(crate) spherical_harmonics: bool,
    /// Glossy lobes are sampled at every pixel.
    pub(crate) samples_lobes: bool,
    /// Lobes that the prefiltered environment is right for take the radiance cache instead.
    pub(crate) caches_prefiltered: bool,
}

impl Unshadowed {
    /// The lobes of a scene's surfaces that are looked up in the radiance cache, each once. The default material has none. Tables are none of
    /// them: what they hold may hang on the tangent, which the cache does not know, so that they are sampled at every pixel.
    pub(crate) fn cached_lobes(&self, surfaces: &[Surface]) -> Vec<CachedLobe> {
        let mut lobes: Vec<CachedLobe> = Vec::new();
        for surface in surfaces {
            let cached = !self.samples_lobes && (self.caches_prefiltered || !surface.model.is_prefiltered());
            let lobe = CachedLobe { model: surface.model as u32, shape: surface.shape() };
            if cached && !surface.model.is_tabulated() && !surface.is_matte() && !lobes.contains(&lobe) {
                lobes.push(lobe);
            }
        }
        lobes
    }
}

/// Every source.
pub const UNSHADOWED: &[Unshadowed] = &[
    Unshadowed {
        name: "auto",
        summary: "irradiance map; for gloss few samples of the lobe at every pixel, each of its own mip level (Krivanek and Colbert 2008)",
        spherical_harmonics: false,
        samples_lobes: true,
        caches_prefiltered: false,
    },
    Unshadowed {
        name: "prefiltered",
        summary: "irradiance map; for GGX the prefiltered environment, for other lobes a radiance cache made every frame",
        spherical_harmonics: false,
        samples_lobes: false,
        caches_prefiltered: false,
    },
    Unshadowed {
        name: "sh",
        summary: "irradiance from nine spherical harmonics (Ramamoorthi and Hanrahan 2001), else as auto",
        spherical_harmonics: true,
        samples_lobes: true,
        caches_prefiltered: false,
    },
    Unshadowed {
        name: "cache",
        summary: "a radiance cache made every frame for every lobe (DeCoro and Rusinkiewicz 2008)",
        spherical_harmonics: false,
        samples_lobes: false,
        caches_prefiltered: true,
    },
];

/// The same as choices of an option.
pub(crate) fn choices() -> Vec<Choice> {
    UNSHADOWED.iter().map(|source| Choice { name: source.name, summary: source.summary }).collect()
}

/// The source called `name`.
///
/// # Errors
/// [`RenderError::UnknownName`] lists the names there are.
pub fn by_name(name: &str) -> Result<&'static Unshadowed, RenderError> {
    UNSHADOWED.iter().find(|source| source.name == name).ok_or_else(|| RenderError::UnknownName {
        what: "source of unshadowed light",
        name: name.to_owned(),
        choices: UNSHADOWED.iter().map(|source| source.name).collect::<Vec<_>>().join(", "),
    })
}
