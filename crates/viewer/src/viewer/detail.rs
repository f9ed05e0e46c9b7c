//! The level of detail that holds a frame rate.

use gnomon_renderer::lod::{FrameTimes, LevelOfDetail};

use super::Viewer;

impl Viewer {
    /// Lets the level of detail follow a frame's times.
    pub(super) fn choose_detail(&mut self) {
        let (Some(controller), Some(studio)) = (&mut self.controller, &self.studio) else { return };
        if studio.is_busy() || self.picture.passes.is_empty() || self.picture.is_debug_view() {
            return;
        }
        let look = studio.look();
        let drawn = LevelOfDetail {
            lights: studio.lights().lights.len() as u32,
            shadow_resolution: look.techniques.shadow_resolution,
            shadow_sampling: look.techniques.shadow_sampling,
        };
        let asked_for = LevelOfDetail {
            lights: look.fit.light_count.map_or(drawn.lights, |count| count as u32),
            ..drawn
        };
        let next = controller.next(drawn, &FrameTimes::from_passes(&self.picture.passes));
        if is_change(drawn, asked_for, next) {
            self.edit(|look| {
                look.fit.light_count = Some(next.lights as usize);
                look.techniques.shadow_resolution = next.shadow_resolution;
                look.techniques.shadow_sampling = next.shadow_sampling;
            });
        }
    }
}

/// Whether another level is to be set. A fit may give fewer lights than it is asked for, and must not be asked again and again.
fn is_change(drawn: LevelOfDetail, asked_for: LevelOfDetail, next: LevelOfDetail) -> bool {
    next != drawn && next != asked_for
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_new_level_is_set_and_none_twice() {
        let drawn = LevelOfDetail { lights: 30, shadow_resolution: 256, shadow_sampling: 2 };
        let asked_for = LevelOfDetail { lights: 32, ..drawn };
        assert!(!is_change(drawn, asked_for, drawn));
        assert!(!is_change(drawn, asked_for, asked_for), "a fit that gave fewer lights is asked again");
        assert!(is_change(drawn, asked_for, LevelOfDetail { lights: 40, ..drawn }));
        for next in [
            LevelOfDetail { shadow_resolution: 128, ..asked_for },
            LevelOfDetail { shadow_sampling: 4, ..asked_for },
            LevelOfDetail { shadow_sampling: 4, ..drawn },
        ] {
            assert!(is_change(drawn, asked_for, next), "{next:?} is lost");
        }
    }
}
