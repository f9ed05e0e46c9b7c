//! The controller against frames whose cost is known, on a simulated clock.

use super::*;

/// What frames cost: any number of terms that the controller's own model need not have.
#[derive(Clone, Copy)]
struct Machine {
    fixed: f64,
    /// [ms] per light, and per light and 256 x 256 texels.
    maps: [f64; 2],
    filter: f64,
    /// [ms] per light, and per light and sample of the full picture.
    light: [f64; 2],
    compose: f64,
    /// Samples at edges, over all, for each sample of the shadow buffer's side.
    edges: f64,
    /// Lights of the scene itself, which the controller does not choose.
    own_lights: f64,
    /// Maps are this many times smaller than asked for with many lights: what wide and narrow lights do.
    is_graded: bool,
    /// Standard deviation of each pass's time over its mean.
    noise: f64,
    seed: u64,
    frame: u64,
}

const MACHINE: Machine = Machine {
    fixed: 2.0,
    maps: [0.03, 0.05],
    filter: 0.06,
    light: [0.02, 1.2],
    compose: 0.7,
    edges: 0.0,
    own_lights: 0.0,
    is_graded: false,
    noise: 0.0,
    seed: 1,
    frame: 0,
};

impl Machine {
    fn exact(&self, level: LevelOfDetail) -> FrameTimes {
        let lights = f64::from(level.lights) + self.own_lights;
        let grade = if self.is_graded { 1.0 / (1.0 + (lights / 40.0).floor()) } else { 1.0 };
        let texels = (f64::from(level.shadow_resolution) / 256.0).powi(2) * grade;
        // Edges are refined: some samples stay however coarse the buffer is, or even more.
        let side = f64::from(level.shadow_sampling);
        let samples = (1.0 / (side * side)).max(0.01) + self.edges * side;
        FrameTimes {
            fixed: self.fixed,
            shadow_maps: lights * (self.maps[0] + self.maps[1] * texels),
            shadow_filter: lights * self.filter * texels,
            light: lights * (self.light[0] + self.light[1] * samples),
            compose: self.compose,
        }
    }

    fn measure(&mut self, level: LevelOfDetail) -> FrameTimes {
        self.frame += 1;
        let mut pass = 0;
        let mut noisy = |time: f64| {
            pass += 1;
            // The sum of twelve uniform numbers is nearly normal, with variance 1.
            let sum: f64 = (0..12).map(|i| uniform(self.seed, (self.frame * 8 + pass) * 12 + i)).sum();
            time * (1.0 + self.noise * (sum - 6.0)).max(0.1)
        };
        let exact = self.exact(level);
        FrameTimes {
            fixed: noisy(exact.fixed),
            shadow_maps: noisy(exact.shadow_maps),
            shadow_filter: noisy(exact.shadow_filter),
            light: noisy(exact.light),
            compose: noisy(exact.compose),
        }
    }
}

/// SplitMix64.
fn uniform(seed: u64, index: u64) -> f64 {
    let mut z = seed.wrapping_mul(0xd129_0c3f_5b5a_9b11) ^ index.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}

/// Draws frames and returns the level of each.
fn run(controller: &mut LodController, machine: &mut Machine, frames: usize) -> Vec<LevelOfDetail> {
    (0..frames)
        .map(|_| {
            let level = controller.level();
            controller.next(level, &machine.measure(level));
            level
        })
        .collect()
}

/// Time of a frame without noise over the budget.
fn share(controller: &LodController, machine: &Machine, budget: f64) -> f64 {
    machine.exact(controller.level()).total() / budget
}

fn changes(levels: &[LevelOfDetail]) -> usize {
    levels.windows(2).filter(|pair| pair[0] != pair[1]).count()
}

/// Machines that differ in which pass is dear.
fn machines() -> [Machine; 4] {
    [
        MACHINE,
        Machine { maps: [1.0, 0.3], filter: 1.0, light: [0.1, 20.0], fixed: 15.0, compose: 5.0, ..MACHINE },
        Machine { light: [0.001, 0.05], maps: [0.2, 0.02], edges: 0.0005, ..MACHINE },
        Machine { is_graded: true, edges: 0.001, ..MACHINE },
    ]
}

#[test]
fn a_cold_start_reaches_the_band_within_60_frames_and_stays_there() {
    for (index, machine) in machines().into_iter().enumerate() {
        for budget in [1.5, 3.0, 10.0].map(|factor| factor * machine.exact(LodRange::default().least).total())
        {
            for noise in [0.0, 0.05, 0.1] {
                for seed in [1, 2, 3] {
                    let mut machine = Machine { noise, seed, ..machine };
                    let mut controller = LodController::new(budget, LodRange::default()).unwrap();
                    run(&mut controller, &mut machine, 60);
                    let name = format!("machine {index}, {budget} ms, noise {noise}, seed {seed}");
                    let settled = controller.level();
                    let found = share(&controller, &machine, budget);
                    assert!(
                        (0.9..=1.1).contains(&found) || settled == LodRange::default().best,
                        "{name}: {found}"
                    );
                    let after = run(&mut controller, &mut machine, 500);
                    assert!(changes(&after) <= 3, "{name}: {} changes", changes(&after));
                    let found = share(&controller, &machine, budget);
                    assert!(
                        (0.9..=1.1).contains(&found) || settled == LodRange::default().best,
                        "{name}: {found}"
                    );
                }
            }
        }
    }
}

#[test]
fn the_checker_sees_a_controller_that_chases_every_frame() {
    let (mut machine, mut lights) = (Machine { noise: 0.05, ..MACHINE }, 40.0);
    let chased: Vec<LevelOfDetail> = (0..500)
        .map(|_| {
            let level = LevelOfDetail { lights: lights as u32, shadow_resolution: 256, shadow_sampling: 4 };
            lights *= 20.0 / machine.measure(level).total();
            level
        })
        .collect();
    assert!(changes(&chased) > 100, "{}", changes(&chased));
}

#[test]
fn the_band_is_held_when_the_scenes_lights_double_and_when_everything_does() {
    for noise in [0.0, 0.05] {
        let budget = 33.0;
        let mut machine = Machine { own_lights: 10.0, noise, ..MACHINE };
        let mut controller = LodController::new(budget, LodRange::default()).unwrap();
        run(&mut controller, &mut machine, 60);
        assert!((0.9..=1.1).contains(&share(&controller, &machine, budget)));
        let dearer = |machine: &Machine| Machine {
            maps: machine.maps.map(|cost| 2.0 * cost),
            light: machine.light.map(|cost| 2.0 * cost),
            filter: 2.0 * machine.filter,
            fixed: 2.0 * machine.fixed,
            ..*machine
        };
        for change in [
            |m: &Machine| Machine { own_lights: 20.0, ..*m },
            dearer,
            |m: &Machine| Machine { own_lights: 5.0, ..*m },
        ] {
            machine = change(&machine);
            run(&mut controller, &mut machine, 60);
            let found = share(&controller, &machine, budget);
            assert!((0.9..=1.1).contains(&found), "{found} with noise {noise}");
            let after = run(&mut controller, &mut machine, 300);
            assert!(changes(&after) <= 3, "{} changes with noise {noise}", changes(&after));
        }
    }
}

#[test]
fn the_band_is_held_when_twice_as_many_lights_are_asked_for() {
    let mut machine = Machine { noise: 0.05, ..MACHINE };
    let with = |lights| {
        let LodRange { least, best } = LodRange::default();
        LodRange {
            least: LevelOfDetail { lights, ..least },
            best: LevelOfDetail { lights: 2 * lights, ..best },
        }
    };
    let mut controller = LodController::new(25.0, with(32)).unwrap();
    for lights in [32, 64, 32] {
        controller.retarget(25.0, with(lights)).unwrap();
        run(&mut controller, &mut machine, 60);
        let found = share(&controller, &machine, 25.0);
        assert!((0.9..=1.1).contains(&found), "{found} with {lights}: {:?}", controller.level());
        assert!((lights..=2 * lights).contains(&controller.level().lights));
        assert!(changes(&run(&mut controller, &mut machine, 300)) <= 2);
    }
}

#[test]
fn a_budget_that_nothing_meets_ends_at_the_least_detail_and_one_that_all_meets_at_the_best() {
    for noise in [0.0, 0.05] {
        let mut machine = Machine { noise, ..MACHINE };
        let mut controller = LodController::new(1.0, LodRange::default()).unwrap();
        run(&mut controller, &mut machine, 60);
        assert_eq!(
            (controller.level(), controller.state()),
            (LodRange::default().least, LodState::BudgetTooLow)
        );
        let levels = run(&mut controller, &mut machine, 200);
        assert_eq!(changes(&levels), 0);
        controller.retarget(1e5, LodRange::default()).unwrap();
        run(&mut controller, &mut machine, 100);
        assert_eq!((controller.level(), controller.state()), (LodRange::default().best, LodState::Best));
        assert_eq!(changes(&run(&mut controller, &mut machine, 200)), 0);
    }
}

#[test]
fn the_same_times_give_the_same_levels_and_others_give_others() {
    let levels = |seed| {
        let mut machine = Machine { noise: 0.1, seed, ..MACHINE };
        run(&mut LodController::new(20.0, LodRange::default()).unwrap(), &mut machine, 300)
    };
    assert_eq!(levels(7), levels(7));
    assert_ne!(levels(7), levels(8));
}

#[test]
fn slow_frames_now_and_then_and_times_that_are_none_do_not_disturb() {
    let mut machine = Machine { noise: 0.03, ..MACHINE };
    let mut controller = LodController::new(20.0, LodRange::default()).unwrap();
    run(&mut controller, &mut machine, 60);
    let settled = controller.level();
    for frame in 0..200 {
        let mut times = machine.measure(settled);
        match frame % 20 {
            5 => times.light *= 20.0,
            12 => times.fixed = f64::NAN,
            _ => {}
        }
        controller.next(controller.level(), &times);
    }
    assert_eq!(controller.level(), settled);
}

#[test]
fn coarse_knobs_are_turned_before_the_picture_loses_its_lights() {
    let mut machine = MACHINE;
    let mut controller = LodController::new(15.0, LodRange::default()).unwrap();
    run(&mut controller, &mut machine, 100);
    let level = controller.level();
    assert!(level.lights >= 30 && level.shadow_sampling > 1, "{level:?}");
}

#[test]
fn what_makes_no_sense_is_refused() {
    let range = LodRange::default();
    for budget in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(LodController::new(budget, range).is_err(), "{budget}");
    }
    let LodRange { least, best } = range;
    for wrong in [
        LodRange { least: best, best: least },
        LodRange { least: LevelOfDetail { lights: 0, ..least }, best },
        LodRange { least: LevelOfDetail { shadow_sampling: 24, ..least }, best },
        LodRange { least, best: LevelOfDetail { shadow_resolution: 100, ..best } },
        LodRange { least, best: LevelOfDetail { shadow_sampling: 0, ..best } },
    ] {
        assert!(LodController::new(10.0, wrong).is_err(), "{wrong:?}");
    }
}
