//! How many pixels are drawn while the user moves something.

/// A frame that takes this long still feels like moving [ms].
const SMOOTH_MS: f64 = 50.0;
/// Coarsest picture: one pixel for so many of the window along a side.
const COARSEST: u32 = 4;

/// Divides the picture's size while something moves, so that frames stay short; whole again at rest.
#[derive(Clone, Debug, Default)]
pub struct Pace {
    /// Milliseconds of a frame at full size, as last predicted.
    full_ms: Option<f64>,
}

impl Pace {
    /// Pixels of the window along the side of one of the picture.
    pub fn divisor(&self, moving: bool) -> u32 {
        let Some(full_ms) = self.full_ms.filter(|_| moving) else { return 1 };
        let wanted = (full_ms / SMOOTH_MS).sqrt().ceil();
        wanted.clamp(1.0, f64::from(COARSEST)) as u32
    }

    /// Takes in the time of a frame that was drawn with a divisor.
    pub fn drawn(&mut self, divisor: u32, milliseconds: f64) {
        if !(milliseconds.is_finite() && milliseconds >= 0.0) {
            return;
        }
        // Time is taken to go with the number of pixels. Where it does not, a frame at full size corrects it.
        let full = milliseconds * f64::from(divisor.max(1)).powi(2);
        self.full_ms = Some(match self.full_ms {
            Some(before) if divisor > 1 => 0.7 * before + 0.3 * full.min(before),
            _ => full,
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slow_frames_are_smaller_while_moving_and_whole_at_rest() {
        let mut pace = Pace::default();
        assert_eq!(pace.divisor(true), 1, "nothing is known before the first frame");
        pace.drawn(1, 160.0);
        assert_eq!((pace.divisor(true), pace.divisor(false)), (2, 1));
        pace.drawn(1, 5000.0);
        assert_eq!(pace.divisor(true), COARSEST);
        pace.drawn(1, 8.0);
        assert_eq!(pace.divisor(true), 1);
    }

    #[test]
    fn costs_that_do_not_go_with_pixels_make_no_spiral() {
        let mut pace = Pace::default();
        pace.drawn(1, 100.0);
        for _ in 0..50 {
            let divisor = pace.divisor(true);
            // Half of the time is shadow maps, whatever the picture's size.
            pace.drawn(divisor, 50.0 + 50.0 / f64::from(divisor).powi(2));
        }
        assert!(pace.divisor(true) <= 2);
        pace.drawn(2, f64::NAN);
        assert!(pace.divisor(true) <= 2);
    }
}
