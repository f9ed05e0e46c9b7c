//! Wall-clock times of rivals.

use std::time::Instant;

use crate::LabError;

/// How long to measure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimingPlan {
    /// Most rounds; every rival runs once a round.
    pub rounds: usize,
    /// No new round begins after so many seconds once there are `least_rounds`.
    pub seconds: f64,
    /// Fewest rounds, at least 1.
    pub least_rounds: usize,
}

/// What the rounds of one rival took [ms].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Shortest.
    pub minimum: f64,
    /// A quarter of the rounds took no longer.
    pub first_quartile: f64,
    /// Median.
    pub median: f64,
    /// Three quarters of the rounds took no longer.
    pub third_quartile: f64,
    /// Rounds.
    pub rounds: usize,
}

impl Spread {
    /// Of times in any order; `None` for none.
    pub fn of(mut times: Vec<f64>) -> Option<Self> {
        times.sort_by(f64::total_cmp);
        let last = times.len().checked_sub(1)?;
        // Between the two nearest, so that a median of four rounds is the mean of the middle two.
        let quantile = |share: f64| {
            let place = share * last as f64;
            let below = place.floor() as usize;
            let above = (below + 1).min(last);
            times[below] + (place - below as f64) * (times[above] - times[below])
        };
        Some(Self {
            minimum: times[0],
            first_quartile: quantile(0.25),
            median: quantile(0.5),
            third_quartile: quantile(0.75),
            rounds: times.len(),
        })
    }
}

/// Something to time: draws one frame and waits for it.
pub type Rival<'a> = Box<dyn FnMut() -> Result<(), LabError> + 'a>;

/// Times rivals in turns: one run of each to warm up, then rounds in which every rival runs once, the first of a round
/// being another each time. A load on the machine, a clock that drops, and what the one before left in caches then meet all
/// of them alike. One spread a rival, in order.
///
/// # Errors
/// The first that a rival reports.
pub fn interleaved(rivals: &mut [Rival<'_>], plan: &TimingPlan) -> Result<Vec<Spread>, LabError> {
    for rival in rivals.iter_mut() {
        rival()?;
    }
    let mut times = vec![Vec::new(); rivals.len()];
    let start = Instant::now();
    let count = rivals.len();
    for round in 0..plan.rounds.max(1) {
        if round >= plan.least_rounds.max(1) && start.elapsed().as_secs_f64() > plan.seconds {
            break;
        }
        for turn in 0..count {
            let index = (round + turn) % count;
            let before = Instant::now();
            rivals[index]()?;
            times[index].push(1e3 * before.elapsed().as_secs_f64());
        }
    }
    Ok(times.into_iter().filter_map(Spread::of).collect())
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;
    use std::time::Duration;

    use super::*;

    #[test]
    fn quartiles_of_known_times() {
        let spread = Spread::of(vec![5.0, 1.0, 3.0, 2.0, 4.0]).unwrap();
        let expected =
            Spread { minimum: 1.0, first_quartile: 2.0, median: 3.0, third_quartile: 4.0, rounds: 5 };
        assert_eq!(spread, expected);
        assert_eq!(Spread::of(vec![1.0, 2.0]).unwrap().median, 1.5);
        assert_eq!(Spread::of(Vec::new()), None);
    }

    #[test]
    fn rivals_take_turns_and_each_begins_a_round() {
        let order = RefCell::new(String::new());
        let rival = |name: char| -> Rival<'_> {
            let order = &order;
            Box::new(move || {
                order.borrow_mut().push(name);
                Ok(())
            })
        };
        let plan = TimingPlan { rounds: 3, seconds: 10.0, least_rounds: 1 };
        let spreads = interleaved(&mut [rival('a'), rival('b'), rival('c')], &plan).unwrap();
        assert_eq!(*order.borrow(), "abcabcbcacab");
        assert!(spreads.iter().all(|spread| spread.rounds == 3));
        assert!(interleaved(&mut [], &plan).unwrap().is_empty());
    }

    #[test]
    fn time_ends_the_rounds_but_not_before_the_least() {
        let slow = || -> Rival<'static> {
            Box::new(|| {
                std::thread::sleep(Duration::from_millis(2));
                Ok(())
            })
        };
        let plan = TimingPlan { rounds: 1000, seconds: 0.0, least_rounds: 2 };
        let spreads = interleaved(&mut [slow()], &plan).unwrap();
        assert!(spreads[0].rounds == 2 && spreads[0].minimum >= 2.0);
    }

    #[test]
    fn a_failing_rival_ends_it() {
        let fail: Rival<'_> = Box::new(|| Err(LabError::Request("planted".to_owned())));
        let plan = TimingPlan { rounds: 1, seconds: 1.0, least_rounds: 1 };
        assert!(interleaved(&mut [fail], &plan).is_err());
    }
}
