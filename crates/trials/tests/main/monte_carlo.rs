//! Trials: what they simulate, how the random ones are drawn, what counts as being at the target.

use bracketry_plate::area::{AreaContact, AreaSettings};
use bracketry_plate::control::{Command, Measurement, PlateController};
use bracketry_plate::experiment::{Establishing, mean_velocity};
use bracketry_plate::{AreaObject, Friction, Object, PlateError, PlateKinematics, Shape};
use bracketry_trials::{
    AveragedController, Cycle, CycleGrid, CycleMap, Scenario, Share, Trial, TrialError, TrialFile, TrialOutcome,
    TrialReport, TrialSample, TrialSetup, TrialSummary, TwoStepController, Utilization, median_time_ratio, quantile,
    run_trial, run_trials, time_to_target,
};
use std::ops::ControlFlow;
use std::sync::Arc;

/// Commands in order, then nothing.
struct Script {
    commands: Vec<Command>,
    next: usize,
    seen: Vec<Measurement>,
}

impl Script {
    fn new(commands: &[[f64; 2]]) -> Self {
        let command = |[a, b]: &[f64; 2]| Command { displacement_acceleration: *a, tilt_acceleration: *b };
        Self { commands: commands.iter().map(command).collect(), next: 0, seen: Vec::new() }
    }
}

impl PlateController for Script {
    fn period(&self) -> f64 {
        0.02
    }

    fn command(&mut self, measurement: &Measurement) -> Result<Command, PlateError> {
        self.seen.push(*measurement);
        self.next += 1;
        Ok(self.commands.get(self.next - 1).copied().unwrap_or_default())
    }

    fn finished(&self) -> bool {
        self.next >= self.commands.len()
    }
}

fn file() -> TrialFile {
    TrialFile::parse(include_str!("../../../../models/plate_trials.toml")).unwrap()
}

/// The disk with few contact points, over a short time.
fn setup(scenario: &Scenario, duration: f64) -> TrialSetup {
    let object = Object { shape: Shape::REFERENCE_DISK, ..Object::REFERENCE };
    TrialSetup {
        area: AreaSettings::default().with_step(2e-3).with_points(8),
        duration,
        ..TrialSetup::new(&object, scenario)
    }
}

fn trial(start: [f64; 3], target: [f64; 3]) -> Trial {
    Trial { start, target, plant_mu: 0.3, pushes: Vec::new(), ..file().cases["nominal"].trial(1, 0) }
}

/// A sample at time `t` with the error `(x, phi)` and the plate's velocity.
fn sample(t: f64, x: f64, phi: f64, velocity: f64) -> TrialSample {
    let plate = PlateKinematics { velocity, ..PlateKinematics::default() };
    TrialSample { t, object: [x, 0.0, phi, 0.0, 0.0, 0.0], plate }
}

#[test]
fn an_object_is_there_from_when_on_it_stays_within_the_tolerance_of_a_plate_at_rest() {
    let tolerance = file().cases["robust"].tolerance();
    let time = |course: &[TrialSample]| time_to_target(course, [0.0; 3], tolerance);
    let there = |t| sample(t, 0.0019, -0.03, 0.0);
    assert_eq!(time(&[sample(0.0, 0.1, 0.0, 0.0), there(0.1), there(0.2)]), Some(0.1));
    // It left again and came back.
    assert_eq!(time(&[there(0.0), sample(0.1, 0.0021, 0.0, 0.0), there(0.2)]), Some(0.2));
    // It left and stayed away, by the yaw alone.
    assert_eq!(time(&[there(0.0), sample(0.1, 0.0, 0.04, 0.0)]), None);
    // The plate moved while it arrived.
    assert_eq!(time(&[sample(0.0, 0.0, 0.0, 0.1), there(0.1)]), Some(0.1));
    assert_eq!(time(&[there(0.0), sample(0.1, 0.0, 0.0, 0.1)]), None);
    // A whole turn makes no difference.
    assert_eq!(time(&[sample(0.0, 0.0, std::f64::consts::TAU, 0.0)]), Some(0.0));
    assert_eq!(time(&[]), None);
}

#[test]
fn the_plate_moves_by_the_closed_form_of_its_commands() {
    // x'' = 5 for 20 ms, −5 for 20 ms, rest: X = a T².
    let (a, b, period) = (5.0, 20.0, 0.02);
    let mut script = Script::new(&[[a, b], [-a, -b]]);
    let run = run_trial(&trial([0.0; 3], [0.0; 3]), &setup(&file().cases["nominal"], 0.2), &mut script).unwrap();
    for s in &run.samples {
        let (u, v) = ((s.t / period).min(1.0) * period, (s.t - period).clamp(0.0, period));
        let way = 0.5 * u * u + period * v - 0.5 * v * v;
        assert!((s.plate.displacement - a * way).abs() < 1e-15 && (s.plate.tilt - b * way).abs() < 1e-15);
        assert!((s.plate.velocity - a * (u - v)).abs() < 1e-14 && (s.plate.tilt_rate - b * (u - v)).abs() < 1e-14);
    }
    let share = Utilization {
        stroke: a * period * period / 0.1,
        tilt: b * period * period / 20f64.to_radians(),
        displacement_acceleration: a / 15.0,
        tilt_acceleration: b / 60.0,
    };
    assert!((run.utilization.stroke - share.stroke).abs() < 1e-12 && (run.utilization.tilt - share.tilt).abs() < 1e-12);
    assert_eq!(run.utilization.greatest(), share.displacement_acceleration);
}

#[test]
fn a_delayed_command_acts_one_period_later_and_is_foretold_by_the_measured_acceleration() {
    let mut delayed = trial([0.0; 3], [0.0; 3]);
    delayed.delay = 1;
    let mut script = Script::new(&[[1.0, 0.0], [-1.0, 0.0], [0.0, 0.0]]);
    run_trial(&delayed, &setup(&file().cases["nominal"], 0.1), &mut script).unwrap();
    for (m, (velocity, acceleration)) in script.seen.iter().zip([(0.0, 0.0), (0.0, 1.0), (0.02, -1.0), (0.0, 0.0)]) {
        assert!((m.plate.velocity - velocity).abs() < 1e-15 && m.plate.acceleration == acceleration);
    }
}

#[test]
fn a_servo_lags_by_its_time_constant_and_a_camera_by_its_latency() {
    // Under a constant command u from rest: X' = u (t − T (1 − exp(−t/T))).
    let (a, bandwidth) = (5.0, 20.0);
    let lag = 1.0 / (std::f64::consts::TAU * bandwidth);
    let mut script = Script::new(&[[a, 0.0]; 10]);
    let slow = TrialSetup { servo_bandwidth: bandwidth, latency: 0.03, ..setup(&file().cases["nominal"], 0.2) };
    let run = run_trial(&trial([0.0; 3], [0.0; 3]), &slow, &mut script).unwrap();
    for s in &run.samples {
        let gone = 1.0 - (-s.t / lag).exp();
        let way = 0.5 * s.t * s.t - lag * s.t + lag * lag * gone;
        assert!((s.plate.velocity - a * (s.t - lag * gone)).abs() < 1e-13);
        assert!((s.plate.displacement - a * way).abs() < 1e-13);
    }
    let then = |t: f64| run.samples.iter().find(|s| (s.t - t).abs() < 1e-9).unwrap().object[0];
    assert!(then(0.13) != then(0.1));
    for (k, t) in [(0, 0.0), (1, 0.0), (5, 0.07), (8, 0.13)] {
        assert!((script.seen[k].object[0] - then(t)).abs() < 1e-5, "{k}");
    }
}

#[test]
fn a_push_is_a_velocity_change_at_its_instant() {
    let mut pushed = trial([0.0; 3], [0.0; 3]);
    let push = |t, v| bracketry_trials::Push { t, velocity: [v, 0.0, 0.0] };
    pushed.pushes = vec![push(0.033, 0.3), push(0.3, -0.6)];
    let run = run_trial(&pushed, &setup(&file().cases["nominal"], 1.0), &mut Script::new(&[])).unwrap();
    // v²/2μg each.
    let way = |v: f64| v * v / (2.0 * 0.3 * 9.81);
    assert!((run.final_error[0] - (way(0.3) - way(0.6))).abs() < 1e-5, "{:?}", run.final_error);
    let first = run.samples.iter().find(|s| s.object[3] != 0.0).unwrap();
    assert!(first.t > 0.033 && first.t <= 0.035 + 1e-12);
}

#[test]
fn lost_samples_are_not_numbers_and_noise_has_its_deviation() {
    let noisy = Trial { lost: 0.25, position_noise: 1e-3, angle_noise: 0.01, ..trial([0.05, 0.0, 1.0], [0.0; 3]) };
    let mut script = Script::new(&vec![[0.0; 2]; 4000]);
    run_trial(&noisy, &setup(&file().cases["nominal"], 80.0), &mut script).unwrap();
    let kept: Vec<[f64; 3]> =
        script.seen.iter().map(|m| m.object).filter(|q| q.iter().all(|v| v.is_finite())).collect();
    let lost = 1.0 - kept.len() as f64 / script.seen.len() as f64;
    // Five standard errors of 4000 samples.
    assert!((lost - 0.25).abs() < 5.0 * (0.25f64 * 0.75 / 4000.0).sqrt());
    for (i, (mean, deviation)) in [(0.05, 1e-3), (0.0, 1e-3), (1.0, 0.01)].into_iter().enumerate() {
        let count = kept.len() as f64;
        let sum: f64 = kept.iter().map(|q| (q[i] - mean) / deviation).sum();
        let square: f64 = kept.iter().map(|q| ((q[i] - mean) / deviation).powi(2)).sum();
        assert!((sum / count).abs() < 5.0 / count.sqrt() && (square / count - 1.0).abs() < 5.0 * (2.0 / count).sqrt());
    }
}

#[test]
fn tipping_and_refused_commands_are_outcomes() {
    // At 500 rad/s² the plate pulls away under what lies 0.1 m from the axis.
    let away = trial([0.0, 0.1, 0.0], [0.0; 3]);
    let fast =
        run_trial(&away, &setup(&file().cases["nominal"], 0.5), &mut Script::new(&[[0.0, -500.0], [0.0; 2]])).unwrap();
    assert!(matches!(fast.outcome, TrialOutcome::Tipping { .. } | TrialOutcome::LiftOff { .. }), "{:?}", fast.outcome);
    let none = run_trial(&away, &setup(&file().cases["nominal"], 0.5), &mut Script::new(&[[f64::NAN, 0.0], [0.0; 2]]))
        .unwrap();
    assert!(matches!(none.outcome, TrialOutcome::ControllerFailed { time: 0.0, .. }));
    let missed = run_trial(&away, &setup(&file().cases["nominal"], 0.5), &mut Script::new(&[])).unwrap();
    assert_eq!(missed.outcome, TrialOutcome::Missed { position: false, angle: true, at_rest: true });
}

#[test]
fn a_trial_that_moves_nothing_ends_after_the_rest_it_has_to_stay_for() {
    let run =
        run_trial(&trial([0.0; 3], [0.0; 3]), &setup(&file().cases["nominal"], 60.0), &mut Script::new(&[])).unwrap();
    assert_eq!(run.outcome, TrialOutcome::Reached { time: 0.0 });
    assert!((run.samples.last().unwrap().t - 0.52).abs() < 1e-9);
}

/// Reports without wall times.
fn timeless(reports: Vec<TrialReport>) -> Vec<(Trial, TrialOutcome, [f64; 3], f64)> {
    reports.into_iter().map(|r| (r.trial, r.outcome, r.final_error, r.simulated)).collect()
}

#[test]
fn the_same_seed_gives_the_same_results_on_any_number_of_threads_and_in_any_company() {
    let scenario = &file().cases["disturbed"];
    let setup = setup(scenario, 0.4);
    let shake = |_: &Trial| Ok(Script::new(&[[12.0, 30.0], [-12.0, -30.0], [-12.0, -30.0], [12.0, 30.0]]));
    let run = |threads: usize, trials: &[Trial]| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let reports = pool.install(|| run_trials(trials, &setup, shake, |_| ControlFlow::Continue(())));
        timeless(reports.unwrap())
    };
    let trials = scenario.trials(7, 6);
    let alone = run(1, &trials);
    assert_eq!(alone, run(3, &trials));
    assert_eq!(alone[4..5], run(1, &[scenario.trial(7, 4)]));
    assert_ne!(alone[4].0.start, scenario.trial(8, 4).start);
}

#[test]
fn trials_lie_in_the_ranges_of_their_scenario() {
    let scenario = &file().cases["disturbed"];
    let trials = scenario.trials(3, 500);
    let all = |f: &dyn Fn(&Trial) -> f64| {
        let values: Vec<f64> = trials.iter().map(f).collect();
        (quantile(&values, 0.0).unwrap(), quantile(&values, 0.5).unwrap(), quantile(&values, 1.0).unwrap())
    };
    for i in 0..2 {
        for (low, middle, high) in [all(&|t| t.start[i]), all(&|t| t.target[i])] {
            assert!((-0.1..-0.098).contains(&low) && middle.abs() < 0.015 && (0.098..0.1).contains(&high));
        }
    }
    let (low, _, high) = all(&|t| t.plant_mu);
    assert!((0.24..0.243).contains(&low) && (0.357..0.36).contains(&high));
    let (low, _, high) = all(&|t| t.pushes[0].velocity[0].hypot(t.pushes[0].velocity[1]));
    assert!((0.1..0.11).contains(&low) && (0.39..0.4).contains(&high));
}

#[test]
fn files_with_numbers_without_meaning_are_refused_by_name() {
    let text = include_str!("../../../../models/plate_trials.toml");
    let refused = |from: &str, to: &str| TrialFile::parse(&text.replacen(from, to, 1)).unwrap_err().to_string();
    assert!(refused("mu_factor = [0.8, 1.2]", "mu_factor = [1.2, 0.8]").starts_with("mu_factor = [1.2, 0.8]"));
    assert!(refused("lost = 0.1", "lost = 1.5").starts_with("lost = "));
    assert!(refused("duration = 60.0", "duration = 0.0").starts_with("duration = 0"));
    assert!(refused("delay = 1", "delai = 1").contains("delai"));
}

#[test]
fn statistics_have_their_known_values() {
    // Wilson's interval from its formula in another language (Python).
    for (count, of, low, high) in [(10, 10, 0.722467, 1.0), (0, 10, 0.0, 0.277533), (190, 200, 0.910422, 0.972617)] {
        let share = Share::new(count, of);
        assert!((share.low - low).abs() < 1e-6 && (share.high - high).abs() < 1e-6, "{share:?}");
    }
    assert_eq!((Share::new(0, 0).low, Share::new(0, 0).high), (0.0, 1.0));
    // numpy.quantile([1, 2, 4, 8], 0.9).
    assert!((quantile(&[8.0, 1.0, 4.0, 2.0], 0.9).unwrap() - 6.8).abs() < 1e-12);
    assert_eq!(quantile(&[], 0.5), None);
}

#[test]
fn trials_without_arrival_count_as_infinitely_long() {
    let scenario = &file().cases["nominal"];
    let setup = setup(scenario, 0.1);
    let reports = run_trials(&scenario.trials(1, 4), &setup, |_| Ok(Script::new(&[])), |_| ControlFlow::Continue(()));
    let mut reports = reports.unwrap();
    for (report, time) in reports.iter_mut().zip([1.0, 2.0, 4.0]) {
        report.outcome = TrialOutcome::Reached { time };
    }
    let summary = TrialSummary::of(&reports);
    assert_eq!((summary.reached.count, summary.time.p50, summary.time.max), (3, Some(3.0), None));
    let mut slower = reports.clone();
    for (report, time) in slower.iter_mut().zip([4.0, 4.0]) {
        report.outcome = TrialOutcome::Reached { time };
    }
    slower[2].outcome = TrialOutcome::Tipping { time: 0.1 };
    // 1/4, 2/4, 4/∞ and none.
    assert_eq!(median_time_ratio(&reports, &slower), Some(0.25));
}

#[test]
fn still_trials_leave_the_object_where_the_plant_would() {
    // Steps are skipped only where nothing moves: a plant that is stepped all the way gives the same.
    let (scenario, push) = (&file().cases["nominal"], [0.2, 0.1, 3.0]);
    let setup = setup(scenario, 0.6);
    let mut pushed = trial([0.0, 0.02, 0.3], [0.0; 3]);
    pushed.pushes = vec![bracketry_trials::Push { t: 0.2, velocity: push }];
    let run = run_trial(&pushed, &setup, &mut Script::new(&[[0.0; 2]; 100])).unwrap();
    let law = Friction::Coulomb { mu: 0.3 };
    let mut plant = AreaContact::new(&setup.object, &law, &setup.area).unwrap();
    plant.set_state([0.0, 0.02, 0.3, push[0], push[1], push[2]]).unwrap();
    plant.advance(&mut |_| PlateKinematics::default(), 0.4).unwrap();
    let end = run.samples.last().unwrap().object;
    assert!(end.iter().zip(plant.state()).all(|(a, b)| (a - b).abs() < 1e-9), "{end:?} {:?}", plant.state());
}

#[test]
fn two_steps_bring_the_disk_to_a_pose_near_by() {
    let scenario = &file().cases["robust"];
    let setup = TrialSetup { area: AreaSettings::default().with_step(2e-3).with_points(8), ..setup(scenario, 20.0) };
    let near = trial([0.01, 0.0, 0.1], [-0.015, 0.012, 0.0]);
    let mut controller = TwoStepController::new(&near, &setup).unwrap();
    let run = run_trial(&near, &setup, &mut controller).unwrap();
    assert!(run.outcome.time().is_some_and(|t| t > 1.0), "{:?} {:?}", run.outcome, run.final_error);
    assert!(setup.tolerance.holds(run.final_error) == [true, true]);
}

#[test]
fn the_map_of_cycles_holds_the_mean_velocities_and_the_ways_of_bursts() {
    let disk = Object { shape: Shape::REFERENCE_DISK, ..Object::REFERENCE };
    let area = AreaSettings::default().with_step(4e-3).with_points(8);
    let grid = CycleGrid { y: vec![0.0], yaws: 3, area: area.clone() };
    assert_eq!(CycleMap::count(&disk, &grid), 27);
    let map = CycleMap::new(&disk, 0.3, &grid, |_| ControlFlow::Continue(())).unwrap();
    let contact = AreaContact::new(&disk, &Friction::Coulomb { mu: 0.3 }, &area).unwrap();
    let mean = |drift: [f64; 3]| {
        let mut plant = AreaObject::new(contact.clone()).unwrap();
        let establishing = Establishing { periods: 8, tolerance: 1e-3 };
        mean_velocity(&mut plant, &Cycle::drifting(drift).motion(), [0.0; 3], establishing).unwrap().mean
    };
    // At the nodes it is exact; between them, that of the lines between the nodes.
    for drift in [[1.0, 0.0, 0.0], [0.0, 1.0, -1.0], [-1.0, -1.0, 1.0]] {
        let (table, truth) = (map.velocity(drift, 0.0, 0.4), mean(drift));
        assert!((0..3).all(|i| (table[i] - truth[i]).abs() < 1e-12), "{table:?} {truth:?}");
    }
    let halves = [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(mean);
    assert!((map.velocity([0.0, 0.5, 0.0], 0.0, 0.0)[1] - 0.5 * (halves[0][1] + halves[1][1])).abs() < 1e-12);
    // A mean tilt lets the object slide down, and the swing of the tilt in time with the shaking turns it.
    assert!(map.velocity([0.0, 1.0, 0.0], 0.0, 0.0)[1] < -0.02);
    let turns = [1.0, -1.0].map(|swing| map.velocity([0.0, 0.0, swing], 0.0, 0.0)[2]);
    assert!(turns[0].abs() > 0.2 && (turns[0] + turns[1]).abs() < 1e-6, "{turns:?}");
    // Mirroring y mirrors a burst.
    let (way, mirrored) = (map.burst([0.5, 0.4, 0.3], 0.0, 0.0), map.burst([0.5, -0.4, -0.3], 0.0, 0.0));
    assert!((way[0] - mirrored[0]).abs() < 1e-4 && (way[1] + mirrored[1]).abs() < 1e-4 && way[1] < -0.005);
}

#[test]
fn a_map_without_places_or_broken_off_is_an_error() {
    let area = AreaSettings::default().with_step(4e-3).with_points(8);
    let map = |y: Vec<f64>, go_on: ControlFlow<()>| {
        CycleMap::new(&Object::REFERENCE, 0.3, &CycleGrid { y, yaws: 1, area: area.clone() }, |_| go_on).unwrap_err()
    };
    assert_eq!(map(vec![], ControlFlow::Continue(())), TrialError::NoGrid);
    assert_eq!(map(vec![0.1, 0.0], ControlFlow::Continue(())), TrialError::NoGrid);
    assert_eq!(map(vec![0.0], ControlFlow::Break(())), TrialError::Canceled);
}

#[test]
fn cycles_bring_the_disk_to_a_pose_while_friction_is_another_one() {
    let scenario = &file().cases["robust"];
    let setup = setup(scenario, 12.0);
    let grid = CycleGrid { y: vec![0.0], yaws: 1, area: AreaSettings::default().with_step(4e-3).with_points(8) };
    let map = Arc::new(CycleMap::new(&setup.object, 0.3, &grid, |_| ControlFlow::Continue(())).unwrap());
    let turn = Trial { plant_mu: 0.26, delay: 1, ..trial([0.02, 0.01, 0.3], [-0.02, 0.03, 0.0]) };
    let run = run_trial(&turn, &setup, &mut AveragedController::new(map, &turn, &setup)).unwrap();
    assert!(run.outcome.time().is_some(), "{:?} {:?}", run.outcome, run.final_error);
    assert!(run.utilization.keeps());
}
