//! Less detail while something moves, all of it at rest.

use gnomon_renderer::TechniqueSettings;
use gnomon_renderer::lod::{LevelOfDetail, LodRange};
use gnomon_studio::{FrameRate, Look, Studio};

use crate::error::PageError;

/// Frames a second that are held where the page says nothing.
const FRAMES_A_SECOND: f64 = 30.0;

/// Holds a frame rate by maps and samples while something moves. The number of lights stays: another one needs another fit.
pub struct Detail {
    /// Frames a second; 0 holds none.
    wanted: f64,
    /// What is drawn at rest, while less is drawn.
    at_rest: Option<TechniqueSettings>,
}

impl Default for Detail {
    fn default() -> Self {
        Self::holding(FRAMES_A_SECOND)
    }
}

impl Detail {
    pub fn holding(frames_a_second: f64) -> Self {
        Self { wanted: frames_a_second, at_rest: None }
    }

    /// Whether less is drawn than at rest.
    pub fn is_held(&self) -> bool {
        self.at_rest.is_some()
    }

    /// Draws less where something begins to move, and all again where it rests; whether that is another picture.
    pub fn follow(&mut self, studio: &mut Studio, moving: bool) -> Result<bool, PageError> {
        // Lights that are fitted meanwhile would be counted with the times of those before.
        if moving == self.is_held() || studio.is_busy() || !(self.wanted > 0.0 && self.wanted.is_finite()) {
            return Ok(false);
        }
        if !moving {
            return self.restore(studio).map(|()| true);
        }
        let techniques = studio.look().techniques.clone();
        let lights = studio.lights().lights.len() as u32;
        let best = LevelOfDetail::of(&techniques, studio.look().fit.light_count.map_or(lights, |n| n as u32));
        let mut range = LodRange::up_to(best);
        range.least.lights = best.lights;
        let frame_rate = FrameRate::new(1000.0 / self.wanted, range)
            .map_err(|error| PageError::Request(error.to_string()))?;
        studio.hold_frame_rate(Some(frame_rate))?;
        self.at_rest = Some(techniques);
        Ok(true)
    }

    /// Draws all that is wanted.
    pub fn restore(&mut self, studio: &mut Studio) -> Result<(), PageError> {
        let Some(techniques) = self.at_rest.take() else { return Ok(()) };
        studio.hold_frame_rate(None)?;
        Ok(studio.edit(|look| look.techniques = techniques)?)
    }

    /// Changes the look that is drawn at rest, where techniques change at once.
    pub fn edit(&mut self, studio: &mut Studio, change: impl FnOnce(&mut Look)) -> Result<(), PageError> {
        let mut look = studio.look().clone();
        let drawn = look.techniques.clone();
        self.put_back(&mut look);
        let wanted = look.techniques.clone();
        change(&mut look);
        if look.techniques != wanted {
            self.at_rest = None;
            studio.hold_frame_rate(None)?;
        } else {
            look.techniques = drawn;
        }
        Ok(studio.set_look(look)?)
    }

    /// Makes of a look what is drawn at rest.
    pub fn put_back(&self, look: &mut Look) {
        if let Some(techniques) = &self.at_rest {
            look.techniques.clone_from(techniques);
        }
    }

    /// What is drawn now, for people.
    pub fn words(&self, studio: &Studio) -> String {
        let techniques = &studio.look().techniques;
        let LevelOfDetail { shadow_resolution, shadow_sampling, .. } = LevelOfDetail::of(techniques, 0);
        format!(
            "shadow maps of {shadow_resolution}, a sum of light for {shadow_sampling} x {shadow_sampling} samples"
        )
    }
}
