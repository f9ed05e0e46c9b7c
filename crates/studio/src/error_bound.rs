//! The cheapest settings whose picture is near enough to the truth.

use gnomon_metrics::SampledError;
use gnomon_options::Given;
use gnomon_renderer::{Frame, RenderError};

use crate::{Look, Studio, StudioError, Update};

/// How far a picture may be from the truth.
#[derive(Clone, Debug)]
pub struct ErrorBound {
    /// Relative root mean square error that it has at most, uncertainty included.
    pub most: f64,
    /// Pixels that pictures are checked by.
    pub pixels: usize,
    /// Options that stay as they are.
    pub given: Given,
}

/// What one try is drawn with.
struct Rung {
    lights: usize,
    /// Maps of wide and of sharp lights.
    shadow_resolutions: [u32; 2],
    /// Sampling of wide and of sharp lights.
    shadow_samplings: [u32; 2],
    supersample: u32,
    /// Rays to a light, where they are traced: in interiors, or everywhere.
    rays: u32,
    rays_everywhere: bool,
}

impl Rung {
    const fn maps(
        lights: usize,
        shadow_resolutions: [u32; 2],
        shadow_samplings: [u32; 2],
        supersample: u32,
        rays: u32,
    ) -> Self {
        Self { lights, shadow_resolutions, shadow_samplings, supersample, rays, rays_everywhere: false }
    }

    const fn rays(lights: usize, shadow_samplings: [u32; 2], rays: u32) -> Self {
        let shadow_resolutions = [256, 2048];
        Self { lights, shadow_resolutions, shadow_samplings, supersample: 4, rays, rays_everywhere: true }
    }
}

/// From cheap to dear; the third is what pictures are drawn with by default. Each is dearer in what left most of the error on the training scenes:
/// first edges and the shadows of small lights, then the number of lights, then what a map of one layer cannot tell.
const LADDER: [Rung; 7] = [
    Rung::maps(16, [128, 512], [16, 8], 2, 4),
    Rung::maps(32, [256, 1024], [8, 4], 2, 8),
    Rung::maps(48, [256, 2048], [8, 4], 4, 16),
    Rung::maps(96, [512, 4096], [4, 2], 4, 32),
    Rung::rays(96, [4, 2], 32),
    Rung::rays(200, [4, 2], 32),
    Rung::rays(400, [2, 1], 32),
];

impl Rung {
    fn look(&self, look: &Look, given: &Given) -> Look {
        let mut look = look.clone();
        (look.fit.light_count, look.fit.threshold) = (Some(self.lights), None);
        let techniques = &mut look.techniques;
        [techniques.shadow_resolution, techniques.sharp_shadow_resolution] = self.shadow_resolutions;
        [techniques.shadow_sampling, techniques.sharp_shadow_sampling] = self.shadow_samplings;
        techniques.supersample = self.supersample;
        techniques.shadow_settings.rays.samples = self.rays;
        if self.rays_everywhere {
            techniques.shadows = "rays".to_owned();
        }
        given.apply(&mut look);
        look
    }
}

impl ErrorBound {
    /// Whether an error surely keeps it.
    pub fn is_met(&self, error: &SampledError) -> bool {
        error.relative_rmse + error.uncertainty <= self.most
    }

    /// Looks to be tried in turn, from cheap to dear, each another than the one before.
    pub fn looks(&self, look: &Look) -> Vec<Look> {
        let mut looks: Vec<Look> = LADDER.iter().map(|rung| rung.look(look, &self.given)).collect();
        looks.dedup();
        looks
    }
}

impl Studio {
    /// Draws frames with one after another of [`ErrorBound::looks`] until one is within the bound, or is the last that the adapter can hold: then the
    /// error is above the bound. The look is that of the frame.
    ///
    /// # Errors
    /// As [`Studio::set_look`], [`Studio::frame`] and [`crate::Stage::check`].
    pub fn frame_within(&mut self, bound: &ErrorBound) -> Result<(Frame, SampledError), StudioError> {
        let [width, height] = self.look().picture.size;
        let mut drawn: Option<(Look, Frame, SampledError)> = None;
        for look in bound.looks(self.look()) {
            match self.checked_frame(look, [width, height], bound.pixels) {
                Ok((frame, error)) => drawn = Some((self.look().clone(), frame, error)),
                Err(StudioError::Render(RenderError::OverLimit { .. })) if drawn.is_some() => break,
                Err(error) => return Err(error),
            }
            if drawn.as_ref().is_some_and(|(_, _, error)| bound.is_met(error)) {
                break;
            }
        }
        let Some((look, frame, error)) = drawn else {
            return Err(StudioError::Request("there is nothing to try".to_owned()));
        };
        self.set_look(look)?;
        self.wait();
        Ok((frame, error))
    }

    fn checked_frame(
        &mut self,
        look: Look,
        [width, height]: [u32; 2],
        pixels: usize,
    ) -> Result<(Frame, SampledError), StudioError> {
        self.set_look(look)?;
        for update in self.wait() {
            if let Update::Failed(error) = update {
                return Err(error);
            }
        }
        let frame = self.frame(width, height)?;
        let error = self.stage().check(&frame.radiance, pixels)?;
        Ok((frame, error))
    }
}

#[cfg(test)]
mod tests {
    use gnomon_options::specs;
    use gnomon_renderer::TechniqueSettings;

    use super::*;

    #[test]
    fn what_is_given_stays_and_the_default_is_among_what_is_tried() {
        let bound = ErrorBound { most: 0.02, pixels: 256, given: Given::default() };
        let looks = bound.looks(&Look::default());
        assert_eq!(looks.len(), LADDER.len());
        let default = Look::default();
        assert!(looks.iter().any(|look| look.techniques == default.techniques), "the defaults have changed");
        let mut given = Given::default();
        for (name, text) in [("threshold", "0.1"), ("supersample", "3"), ("shadow-sampling", "2")] {
            let spec = specs::<Look>().into_iter().find(|spec| spec.name() == name).unwrap();
            given.parse(spec, text).unwrap();
        }
        let looks = ErrorBound { given: given.clone(), ..bound.clone() }.looks(&default);
        for look in &looks {
            let TechniqueSettings { supersample, shadow_sampling, .. } = look.techniques;
            assert_eq!((supersample, shadow_sampling), (3, 2));
            assert_eq!((look.fit.light_count, look.fit.threshold), (None, Some(0.1)));
        }
        for (name, text) in [
            ("shadow-resolution", "64"),
            ("sharp-shadow-resolution", "64"),
            ("sharp-shadow-sampling", "8"),
            ("shadows", "pcss"),
            ("rays-samples", "8"),
        ] {
            let spec = specs::<Look>().into_iter().find(|spec| spec.name() == name).unwrap();
            given.parse(spec, text).unwrap();
        }
        assert_eq!(ErrorBound { given, ..bound }.looks(&default).len(), 1, "nothing is left to choose");
    }

    #[test]
    fn the_uncertainty_counts() {
        let bound = ErrorBound { most: 0.02, pixels: 256, given: Given::default() };
        let error = |relative_rmse, uncertainty| SampledError { relative_rmse, uncertainty, pixels: 256 };
        assert!(bound.is_met(&error(0.017, 0.002)) && !bound.is_met(&error(0.019, 0.002)));
        assert!(!bound.is_met(&error(f64::NAN, 0.0)) && !bound.is_met(&error(f64::INFINITY, 0.0)));
    }
}
