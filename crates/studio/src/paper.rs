//! The papers' own methods, each by its name: what it chooses of every option.

use gnomon_options::{Given, choices};
use gnomon_renderer::GlossPath;
use gnomon_renderer::shadow::ConvolutionSettings;

use crate::Look;

choices! {
    /// A paper whose method is drawn. Options that are given beside it go before what it chooses.
    pub enum Paper {
        /// None: Gnomon's own defaults.
        None = "none",
        /// Arbree, Walter and Bala: disks, penumbra wedges, the rest of the map without shadows, light added up.
        Arbree2005 = "arbree2005",
        /// Annen et al.: squares that hold the whole map, convolution soft shadows of order 4, sharpened and without a look at the depth map,
        /// light added up.
        Annen2008 = "annen2008",
        /// DeCoro and Rusinkiewicz: structured samples, shadow volumes, shadows subtracted from unshadowed light.
        Decoro2008 = "decoro2008",
    }
}

impl Paper {
    /// What it chooses.
    pub fn given(self) -> Given {
        let mut look = Look::default();
        match self {
            Self::None => {}
            Self::Arbree2005 => {
                look.fit.method = "disks".to_owned();
                look.lighting.ambient = "unshadowed".to_owned();
                look.techniques.shadows = "wedges".to_owned();
                look.techniques.compositing = "additive".to_owned();
                look.techniques.unshadowed = "prefiltered".to_owned();
                look.techniques.gloss = GlossPath::Lights;
            }
            Self::Annen2008 => {
                look.fit.method = "squares".to_owned();
                look.lighting.ambient = "unshadowed".to_owned();
                look.techniques.shadows = "convolution".to_owned();
                look.techniques.compositing = "additive".to_owned();
                look.techniques.gloss = GlossPath::Lights;
                // Every triangle, into a map of 512 x 512 for every light.
                look.techniques.caster_deviation = 0.0;
                look.techniques.shadow_resolution = 512;
                look.techniques.sharp_shadow_resolution = 512;
                look.techniques.shadow_settings.convolution = ConvolutionSettings {
                    sharpening_a: Some(30.0),
                    sharpening_b: 10.0,
                    ..ConvolutionSettings::paper()
                };
            }
            Self::Decoro2008 => {
                look.fit.method = "samples".to_owned();
                look.fit.sampler = Some("structured".to_owned());
                look.fit.light_count = Some(100);
                look.lighting.ambient = "unshadowed".to_owned();
                look.techniques.shadows = "stencil".to_owned();
                look.techniques.compositing = "subtractive".to_owned();
                look.techniques.unshadowed = "cache".to_owned();
                look.techniques.gloss = GlossPath::Lights;
            }
        }
        Given::changes(&Look::default(), &look)
    }
}

#[cfg(test)]
mod tests {
    use gnomon_options::Options;

    use super::*;

    #[test]
    fn papers_choose_what_there_is_and_give_way() {
        for paper in Paper::ALL {
            let mut look = Look::default();
            paper.given().apply(&mut look);
            look.check().unwrap();
            look.fit.fit(false).unwrap();
            assert_eq!(look == Look::default(), *paper == Paper::None);
            let own = Look::default();
            let asked = Look {
                fit: gnomon_lights::fit::FitSettings { light_count: Some(7), ..own.fit.clone() },
                ..own
            };
            let given = paper.given().with(&Given::changes(&Look::default(), &asked));
            let mut look = Look::default();
            given.apply(&mut look);
            assert_eq!(look.fit.light_count, Some(7));
        }
    }
}
