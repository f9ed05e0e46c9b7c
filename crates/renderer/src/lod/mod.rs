//! Level of detail that holds a frame time: how many lights, how large their maps, how many samples, chosen from the measured times
//! of the passes (DeCoro and Rusinkiewicz 2008, section 2, call the first and the last illumination and sampling detail).
//!
//! [`LodController`] reads no clock and draws no random numbers: the same times give the same choices, so that a recorded run can be
//! replayed.

mod control;
mod cost;
mod expected_error;
#[cfg(test)]
mod simulation;

use crate::{PassTiming, TechniqueSettings};

pub use control::{LodController, LodError, LodState};

/// What a frame's shadows are drawn with. Fields as in [`crate::RenderSettings`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LevelOfDetail {
    /// Lights of the environment that cast shadows.
    pub lights: u32,
    /// Texels along the side of the largest shadow map: a power of two.
    pub shadow_resolution: u32,
    /// Samples of the picture for one of the shadow buffer, along a side: a power of two.
    pub shadow_sampling: u32,
}

impl LevelOfDetail {
    /// What these techniques draw so many lights with.
    pub fn of(techniques: &TechniqueSettings, lights: u32) -> Self {
        Self {
            lights,
            shadow_resolution: techniques.shadow_resolution,
            shadow_sampling: techniques.shadow_sampling,
        }
    }

    /// Takes all but the number of lights over. Sharp lights are summed at tiles half as wide.
    pub fn set(&self, techniques: &mut TechniqueSettings) {
        techniques.sharp_shadow_sampling = (self.shadow_sampling / 2).max(1);
        techniques.shadow_resolution = self.shadow_resolution;
        techniques.shadow_sampling = self.shadow_sampling;
    }
}

/// Between which settings a controller may choose, knob by knob.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LodRange {
    /// Least detail.
    pub least: LevelOfDetail,
    /// Most detail.
    pub best: LevelOfDetail,
}

impl Default for LodRange {
    /// From 6 to 200 lights, maps from 64 to 512, and shadow buffers of all samples to one in 1024.
    fn default() -> Self {
        Self {
            least: LevelOfDetail { lights: 6, shadow_resolution: 64, shadow_sampling: 32 },
            best: LevelOfDetail { lights: 200, shadow_resolution: 512, shadow_sampling: 1 },
        }
    }
}

impl LodRange {
    /// From the least detail up to `best`.
    pub fn up_to(best: LevelOfDetail) -> Self {
        let least = Self::default().least;
        let least = LevelOfDetail {
            lights: least.lights.min(best.lights),
            shadow_resolution: least.shadow_resolution.min(best.shadow_resolution),
            shadow_sampling: least.shadow_sampling.max(best.shadow_sampling),
        };
        Self { least, best }
    }
}

/// Measured times of one frame [ms].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrameTimes {
    /// Passes that no setting of the level of detail changes.
    pub fixed: f64,
    /// Drawing shadow maps.
    pub shadow_maps: f64,
    /// Making the technique's images of them.
    pub shadow_filter: f64,
    /// Summing the lights at every point of the shadow buffer.
    pub light: f64,
    /// Resampling and compositing.
    pub compose: f64,
}

impl FrameTimes {
    /// The times of a frame whose passes are timed, see [`crate::MeasureSettings::profile`].
    pub fn from_passes(passes: &[PassTiming]) -> Self {
        let mut times = Self::default();
        for pass in passes {
            *match pass.name {
                "shadow maps" => &mut times.shadow_maps,
                "shadow filter" => &mut times.shadow_filter,
                "light" | "visibility" => &mut times.light,
                "compose" => &mut times.compose,
                _ => &mut times.fixed,
            } += pass.milliseconds;
        }
        times
    }

    /// The whole frame [ms].
    pub fn total(&self) -> f64 {
        self.to_array().iter().sum()
    }

    fn to_array(self) -> [f64; PASSES] {
        [self.fixed, self.shadow_maps, self.shadow_filter, self.light, self.compose]
    }
}

/// Passes that are told apart.
const PASSES: usize = 5;
