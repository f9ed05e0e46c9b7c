//! Holding a frame rate.

use std::collections::VecDeque;

use gnomon_renderer::lod::{FrameTimes, LevelOfDetail, LodController, LodError, LodRange, LodState};
use gnomon_renderer::{PassTiming, TimedFrame};

/// Frames without a change after which a choice stands.
const STEADY_FRAMES: u32 = 20;

/// A frame whose times have come.
#[derive(Clone, Debug)]
pub struct DrawnFrame {
    /// What it was drawn with.
    pub level: LevelOfDetail,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Whether it showed a debug view.
    pub is_debug_view: bool,
    /// Times of its passes.
    pub passes: Vec<PassTiming>,
}

impl DrawnFrame {
    /// The whole frame [ms].
    pub fn milliseconds(&self) -> f64 {
        self.passes.iter().map(|pass| pass.milliseconds).sum()
    }
}

/// Holds a time a frame by the level of detail, from the times of frames that were drawn some frames ago.
#[derive(Clone, Debug)]
pub struct FrameRate {
    controller: LodController,
    steady: u32,
}

impl FrameRate {
    /// For frames of `budget_ms` milliseconds.
    ///
    /// # Errors
    /// As [`LodController::new`].
    pub fn new(budget_ms: f64, range: LodRange) -> Result<Self, LodError> {
        Ok(Self { controller: LodController::new(budget_ms, range)?, steady: 0 })
    }

    /// What has become of the budget.
    pub fn state(&self) -> LodState {
        self.controller.state()
    }

    /// Whether the level of detail has stayed for some while.
    pub fn is_steady(&self) -> bool {
        self.steady >= STEADY_FRAMES
    }

    /// Takes in a frame's times. Gives another level for the next frames where there is one to be set: a fit may give fewer lights
    /// than it is asked for, and must not be asked again and again.
    pub(crate) fn follow(&mut self, drawn: &DrawnFrame, asked_for: LevelOfDetail) -> Option<LevelOfDetail> {
        let next = self.controller.next(drawn.level, &FrameTimes::from_passes(&drawn.passes));
        let is_change = next != drawn.level && next != asked_for;
        let is_steady = !is_change && self.state() != LodState::Settling;
        self.steady = if is_steady { self.steady + 1 } else { 0 };
        is_change.then_some(next)
    }

    /// What the first frame is to be drawn with.
    pub(crate) fn first(&self) -> LevelOfDetail {
        self.controller.level()
    }
}

/// Frames whose times are still to come, by number.
#[derive(Debug, Default)]
pub(crate) struct FramesInFlight(VecDeque<(u64, DrawnFrame)>);

impl FramesInFlight {
    pub fn add(&mut self, number: u64, frame: DrawnFrame) {
        self.0.push_back((number, frame));
    }

    /// The frame that times belong to. Those before it were not timed.
    pub fn take(&mut self, timed: TimedFrame) -> Option<DrawnFrame> {
        let (mut last, passes) = (None, timed.passes);
        while let Some(before) = self.0.pop_front_if(|(number, _)| *number <= timed.number) {
            last = Some(before);
        }
        last.filter(|(number, _)| *number == timed.number).map(|(_, frame)| DrawnFrame { passes, ..frame })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(lights: u32) -> DrawnFrame {
        let level = LevelOfDetail { lights, shadow_resolution: 256, shadow_sampling: 2 };
        DrawnFrame { level, size: [64, 48], is_debug_view: false, passes: Vec::new() }
    }

    fn timed(number: u64) -> TimedFrame {
        TimedFrame { number, passes: vec![PassTiming { name: "light", milliseconds: 1.0 }] }
    }

    #[test]
    fn late_times_find_the_frame_that_they_belong_to() {
        let mut frames = FramesInFlight::default();
        (1..6).for_each(|number| frames.add(number, drawn(number as u32)));
        let second = frames.take(timed(2)).unwrap();
        assert_eq!((second.level.lights, second.milliseconds()), (2, 1.0));
        assert!(frames.take(timed(1)).is_none(), "a frame is gone with the one after it");
        assert_eq!(frames.take(timed(5)).unwrap().level.lights, 5);
        assert!(frames.take(timed(6)).is_none());
    }

    #[test]
    fn every_new_level_is_set_and_none_twice() {
        let range = LodRange::default();
        let mut rate = FrameRate::new(100.0, range).unwrap();
        let mut asked_for = rate.first();
        let mut changes = 0;
        for _ in 0..200 {
            // A fit that gives fewer lights than it is asked for.
            let level = LevelOfDetail { lights: asked_for.lights - 1, ..asked_for };
            if let Some(next) =
                rate.follow(&DrawnFrame { level, passes: timed(0).passes, ..drawn(0) }, asked_for)
            {
                assert_ne!(next, asked_for);
                (asked_for, changes) = (next, changes + 1);
            }
        }
        assert!((1..20).contains(&changes), "{changes}");
        assert_eq!(asked_for, range.best, "a millisecond of a hundred is spent");
        assert!(rate.is_steady());
    }
}
