//! What the plate does under the methods that others are compared with: cycles that follow each other, and coming to rest.

use bracketry_plate::control::{Command, Measurement, PlateController, PlateLimits};
use bracketry_plate::{GRAVITY, Object, PlateKinematics, PlateMotion};
use bracketry_trials::{Cycle, Trial, TrialFile, TrialSetup, TwoStepController};

const CORNERS: [f64; 2] = [-1.0, 1.0];

fn cycles() -> impl Iterator<Item = Cycle> {
    let corners = |a: f64| CORNERS.into_iter().flat_map(move |b| CORNERS.map(move |c| Cycle::drifting([a, b, c])));
    CORNERS.into_iter().flat_map(corners).chain([Cycle::default()])
}

#[test]
fn a_cycle_that_follows_itself_is_its_periodic_motion() {
    for cycle in cycles() {
        let mut motion = cycle.motion().drive().unwrap().motion().unwrap();
        for t in [0.0, 0.13, 0.4] {
            let (a, b) = (cycle.after(&cycle, t), motion.at(t));
            assert!((a.displacement - b.displacement).abs() < 1e-15 && (a.tilt - b.tilt).abs() < 1e-15);
            assert!((a.acceleration - b.acceleration).abs() < 1e-12);
            assert!((a.tilt_acceleration - b.tilt_acceleration).abs() < 1e-12);
        }
    }
}

#[test]
fn any_cycle_may_follow_any_other_without_a_jump_and_within_the_bounds() {
    let limits = PlateLimits::default();
    let duration = 1.0 / Cycle::default().motion().frequency;
    for before in cycles() {
        for cycle in cycles() {
            let (end, next) = (cycle.after(&before, duration), Cycle::default().after(&cycle, 0.0));
            for (a, b) in [
                (end.displacement, next.displacement),
                (end.velocity, next.velocity),
                (end.tilt, next.tilt),
                (end.tilt_rate, next.tilt_rate),
            ] {
                assert!((a - b).abs() < 1e-12);
            }
            for k in 0..=80 {
                let (t, h) = (duration * f64::from(k) / 80.0, 1e-5);
                let plate = cycle.after(&before, t);
                assert!(plate.displacement.abs() < limits.stroke && plate.tilt.abs() < limits.tilt);
                assert!(plate.acceleration.abs() < limits.displacement_acceleration, "{plate:?}");
                assert!(plate.tilt_acceleration.abs() < limits.tilt_acceleration, "{plate:?}");
                if k > 0 && k < 80 {
                    let (a, b) = (cycle.after(&before, t - h), cycle.after(&before, t + h));
                    assert!((plate.velocity - (b.displacement - a.displacement) / (2.0 * h)).abs() < 1e-6);
                    assert!((plate.tilt_acceleration - (b.tilt_rate - a.tilt_rate) / (2.0 * h)).abs() < 1e-4);
                }
            }
        }
    }
}

/// The two-step controller, which first brings the plate to rest, of an object that is at its target. `mu` sets its bound of the
/// displacement's acceleration, 0.4 μ g; that of the tilt's is 50 rad/s².
fn two_step(mu: f64, delay: usize) -> TwoStepController {
    let scenario = &TrialFile::parse(include_str!("../../../../models/plate_trials.toml")).unwrap().cases["nominal"];
    let trial = Trial { target: [0.0; 3], model_mu: mu, delay, ..scenario.trial(1, 0) };
    TwoStepController::new(&trial, &TrialSetup::new(&Object::REFERENCE, scenario)).unwrap()
}

/// A start of displacement and tilt.
fn plate([displacement, velocity, tilt, tilt_rate]: [f64; 4]) -> PlateKinematics {
    PlateKinematics { displacement, velocity, tilt, tilt_rate, ..PlateKinematics::default() }
}

/// The least time to rest from x and v with accelerations up to a: v/a + 2 √(x/a + v²/2a²), x and v counted toward the side of
/// x + v|v|/2a.
fn least_time(x: f64, v: f64, a: f64) -> f64 {
    let side = (x + v * v.abs() / (2.0 * a)).signum();
    side * v / a + 2.0 * (side * x / a + 0.5 * (v / a).powi(2)).sqrt()
}

#[test]
fn the_plate_comes_to_rest_at_zero_within_the_bound_and_in_little_more_than_the_least_time() {
    let bounds = [0.4 * (2.0 / (0.4 * GRAVITY)) * GRAVITY, 50.0];
    for (start, rate) in [(0.1, 0.0), (-0.03, 0.3), (0.0, -0.5), (1e-4, 0.0), (0.08, 0.4)] {
        // The tilt from a state that is mirrored and has the same least time.
        let scale = bounds[1] / bounds[0];
        let mut now = plate([start, rate, -scale * start, -scale * rate]);
        let mut controller = two_step(2.0 / (0.4 * GRAVITY), 0);
        let period = controller.period();
        let (mut steps, mut arrived) = (0, [None; 2]);
        while steps < 1000 && arrived.iter().any(Option::is_none) {
            let command = controller.command(&Measurement { object: [0.0; 3], plate: now }).unwrap();
            assert!(command.displacement_acceleration.abs() <= bounds[0]);
            assert!(command.tilt_acceleration.abs() <= bounds[1]);
            now = command.applied_to(&now).after(period);
            steps += 1;
            let rests = |value: f64, rate: f64| value.abs() <= 1e-9 && rate.abs() <= 1e-9;
            for (k, rests) in
                [rests(now.displacement, now.velocity), rests(now.tilt, now.tilt_rate)].into_iter().enumerate()
            {
                arrived[k] = if rests { arrived[k].or(Some(steps)) } else { None };
            }
        }
        for (k, arrived) in arrived.into_iter().enumerate() {
            let factor = if k == 0 { 1.0 } else { -scale };
            let least = least_time(factor * start, factor * rate, bounds[k]);
            let time = period * f64::from(arrived.unwrap());
            assert!(time < 1.3 * least + 6.0 * period, "{start} {rate}: {time} {least}");
        }
    }
}

/// What is commanded with a delay of two samples is what would be commanded without at the plate that it meets.
#[test]
fn a_delayed_command_meets_the_plate_that_was_predicted() {
    let (mut delayed, mut prompt) = (two_step(0.3, 2), two_step(0.3, 0));
    let period = delayed.period();
    let mut now = plate([0.1, -0.2, 0.05, 1.0]);
    // Nothing acts in the first two periods.
    let mut later = now.after(period).after(period);
    let mut waiting = [None; 2];
    for k in 0..200 {
        let command = delayed.command(&Measurement { object: [0.0; 3], plate: now }).unwrap();
        assert_eq!(command, prompt.command(&Measurement { object: [0.0; 3], plate: later }).unwrap(), "{k}");
        later = command.applied_to(&later).after(period);
        let acting: Option<Command> = waiting[k % 2].replace(command);
        now = acting.map_or(now, |acting| acting.applied_to(&now)).after(period);
    }
    assert!(now.displacement.abs() < 1e-9 && now.tilt.abs() < 1e-9, "{now:?}");
}
