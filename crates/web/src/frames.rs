//! Frames that the GPU is at, one at a time, and how long they take.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use gnomon_renderer::Gpu;

/// A frame that has been drawn.
pub struct Ended {
    /// Pixels of the canvas along the side of one of the picture.
    pub divisor: u32,
    /// From its submission.
    pub milliseconds: f64,
}

struct InFlight {
    is_done: Arc<AtomicBool>,
    began: f64,
    divisor: u32,
}

/// The frames of a session.
#[derive(Default)]
pub struct Frames {
    in_flight: Option<InFlight>,
    size: [u32; 2],
    count: u64,
    milliseconds: f64,
}

impl Frames {
    /// A frame of so many pixels was submitted at a time of the page's clock.
    pub fn submitted(&mut self, gpu: &Gpu, now: f64, size: [u32; 2], divisor: u32) {
        let is_done = Arc::new(AtomicBool::new(false));
        let told = Arc::clone(&is_done);
        gpu.queue().on_submitted_work_done(move || told.store(true, Ordering::Relaxed));
        self.in_flight = Some(InFlight { is_done, began: now, divisor });
        self.size = size;
    }

    /// The frame that has ended since this was asked last.
    pub fn take_ended(&mut self, now: f64) -> Option<Ended> {
        let ended = self.in_flight.take_if(|frame| frame.is_done.load(Ordering::Relaxed))?;
        self.count += 1;
        self.milliseconds = now - ended.began;
        Some(Ended { divisor: ended.divisor, milliseconds: self.milliseconds })
    }

    /// Whether the GPU is at one.
    pub fn are_waited_for(&self) -> bool {
        self.in_flight.is_some()
    }

    /// Pixels of the last one.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Frames that have ended.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Time of the last one.
    pub fn milliseconds(&self) -> f64 {
        self.milliseconds
    }
}
