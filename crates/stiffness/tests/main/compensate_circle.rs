//! A milled circle of radius 35 mm: what the compensation gains, and why less where joints have lost motion.

use crate::common::{
    STIFFNESS,
    milling::{START, circle, compensator, compensator_with, robot, wrong},
    rng,
};
use bracketry_stiffness::{
    CircleRun, CompensationSettings, JointSpring, MillingCircle, ResidualSample, Robot, Springs, explain_residual,
};
use nalgebra::Vector3;
use rand::rngs::StdRng;
use rand_distr::{Distribution, StandardNormal};

struct Mill {
    robot: Robot,
    circle: MillingCircle,
    path: Vec<Vec<f64>>,
}

impl Mill {
    fn new(seed: u64) -> Self {
        let (robot, circle) = (robot(), circle(seed));
        let path = circle.path(&robot, &START).unwrap();
        Self { robot, circle, path }
    }

    fn without(&self, springs: &Springs) -> CircleRun {
        self.circle.mill(&self.robot, &self.path, springs, None).unwrap()
    }

    fn with(&self, springs: &Springs, modeled: &Springs) -> CircleRun {
        let compensator = compensator(&self.circle, &self.robot, modeled.clone());
        self.circle.mill(&self.robot, &self.path, springs, Some(compensator)).unwrap()
    }

    /// Reductions of the radial error over random models, the least first.
    fn reductions(&self, share: f64, draws: usize, seed: u64) -> Vec<f64> {
        let springs = Springs::linear(&STIFFNESS);
        let before = self.without(&springs).radial();
        let mut random = rng(seed);
        let models: Vec<Springs> = (0..draws).map(|_| wrong(&springs, share, &mut random)).collect();
        let reduce = |models: &[Springs]| -> Vec<f64> {
            models.iter().map(|m| self.with(&springs, m).radial().reduction_from(&before)).collect()
        };
        let (first, second) = models.split_at(draws / 2);
        let mut all = std::thread::scope(|scope| {
            let other = scope.spawn(|| reduce(second));
            let mut all = reduce(first);
            all.extend(other.join().unwrap());
            all
        });
        all.sort_by(f64::total_cmp);
        all
    }
}

/// Lost motion of one arc minute in two joints that carry no weight in this pose.
fn with_backlash() -> Springs {
    let mut springs = Springs::linear(&STIFFNESS);
    for i in [0, 4] {
        springs.joints[i] = JointSpring::Backlash { stiffness: STIFFNESS[i], gap: 2.9e-4, engaged: 30.0 };
    }
    springs
}

/// What a tracker with 10 µm of noise measures.
fn measured(run: &CircleRun, random: &mut StdRng) -> Vec<ResidualSample> {
    let noise = |random: &mut StdRng| {
        Vector3::from_fn(|_, _| {
            let z: f64 = StandardNormal.sample(random);
            10e-6 * z
        })
    };
    let take = |s: &bracketry_stiffness::CircleSample, random: &mut StdRng| ResidualSample {
        coordinates: s.coordinates.clone(),
        wrench: s.wrench,
        displacement: s.displacement + noise(random),
    };
    run.samples.iter().step_by(4).map(|s| take(s, random)).collect()
}

#[test]
fn ten_percent_of_stiffness_error_leave_four_fifths_of_the_gain() {
    let reductions = Mill::new(1).reductions(0.1, 100, 11);
    assert!(reductions[0] >= 0.8, "{}", reductions[0]);
    assert!(reductions[50] >= 0.88, "{}", reductions[50]);
}

#[test]
fn thirty_percent_of_stiffness_error_leave_half_of_the_gain() {
    let reductions = Mill::new(2).reductions(0.3, 100, 12);
    assert!(reductions[0] >= 0.5, "{}", reductions[0]);
    // A poor model does gain less.
    assert!(reductions[50] <= 0.88, "{}", reductions[50]);
}

#[test]
fn a_predicted_wrench_and_a_stiffness_error_reckoned_with_gain_whatever_the_sign_of_the_error() {
    let mill = Mill::new(5);
    let springs = Springs::linear(&STIFFNESS);
    let before = mill.without(&springs).radial();
    let gain = |factor: f64, lag: Option<f64>, stiffness_error: f64| {
        let settings = CompensationSettings { lag, stiffness_error, ..CompensationSettings::default() };
        let modeled = springs.scaled(&[factor; 6]);
        let compensator = compensator_with(&mill.circle, &mill.robot, modeled, settings);
        let run = mill.circle.mill(&mill.robot, &mill.path, &springs, Some(compensator)).unwrap();
        run.radial().reduction_from(&before)
    };
    // All joints wrong in the same direction, the worst there is.
    for (factor, share, least) in [(0.7, 0.3, 0.5), (1.3, 0.3, 0.5), (0.9, 0.1, 0.8), (1.1, 0.1, 0.8)] {
        let found = gain(factor, Some(mill.circle.lag), share);
        assert!(found >= least, "{factor}: {found}");
    }
    // What turns with the tool comes undelayed, which a model that is too soft needs most; the smaller correction does the rest.
    let (late, ahead) = (gain(0.7, None, 0.0), gain(0.7, Some(mill.circle.lag), 0.0));
    assert!(late < 0.42 && ahead > late + 0.05, "{late} {ahead}");
    assert!(gain(0.7, Some(mill.circle.lag), 0.3) > ahead + 0.1);
    assert!(gain(1.0, Some(mill.circle.lag), 0.0) > gain(1.0, None, 0.0) + 0.02);
}

#[test]
fn the_error_without_compensation_is_the_compliance_times_the_force() {
    let mill = Mill::new(3);
    let run = mill.without(&Springs::linear(&STIFFNESS));
    for sample in run.samples.iter().step_by(100) {
        let bent = bracketry_stiffness::Deformation::equilibrium(
            &mill.robot,
            &Springs::linear(&STIFFNESS),
            &sample.coordinates,
            &sample.wrench,
        )
        .unwrap();
        let moved: Vector3<f64> = bent.tool.fixed_rows::<3>(0).into();
        assert!((moved - sample.displacement).norm() < 1e-10);
        // The force is that of the depth of cut where the tool really is.
        let depth = mill.circle.cutting.depth + sample.radial_error;
        let cutting = &mill.circle.cutting;
        let per_depth = Vector3::new(cutting.radial, cutting.tangential, cutting.axial).norm() * depth;
        let share = sample.wrench.fixed_rows::<3>(0).norm() / per_depth;
        assert!((share - 1.0).abs() <= cutting.ripple + 1e-6, "{share}");
    }
    assert_eq!(run.limited(), 0);
    // One turn.
    let [first, last] = [&run.samples[0], &run.samples[run.samples.len() - 1]];
    assert!((last.angle - first.angle - std::f64::consts::TAU).abs() < 0.01);
}

#[test]
fn the_loop_through_the_cut_is_stable_with_a_margin() {
    let mill = Mill::new(4);
    let springs = Springs::linear(&STIFFNESS);
    let soft = Springs::linear(&STIFFNESS.map(|k| 0.7 * k));
    let gains = mill.circle.stability(&mill.robot, &mill.path, &springs, &soft).unwrap();
    assert!(gains.holds() && gains.process < 0.2 && gains.compensation < 0.2, "{gains:?}");
    // Twenty times the cutting stiffness: the process is stiffer than the robot.
    let mut heavy = mill.circle.clone();
    heavy.cutting.radial *= 20.0;
    heavy.cutting.tangential *= 20.0;
    assert!(!heavy.stability(&mill.robot, &mill.path, &springs, &soft).unwrap().holds());
}

#[test]
fn lost_motion_is_found_and_the_nonlinear_model_recovers_the_gain() {
    let mill = Mill::new(5);
    let (truth, linear) = (with_backlash(), Springs::linear(&STIFFNESS));
    let before = mill.without(&truth);
    let with_linear = mill.with(&truth, &linear).radial().reduction_from(&before.radial());
    let with_truth = mill.with(&truth, &truth).radial().reduction_from(&before.radial());
    assert!(with_linear < with_truth - 0.15, "{with_linear} {with_truth}");

    let report = explain_residual(&mill.robot, &linear, &measured(&before, &mut rng(13))).unwrap();
    let joints: Vec<usize> = report.lost_motion.iter().map(|l| l.joint).collect();
    assert_eq!(joints, [1, 5], "{report:?}");
    for lost in &report.lost_motion {
        assert!((lost.gap - 2.9e-4).abs() < 0.1 * 2.9e-4, "{report:?}");
        assert!((lost.engaged - 30.0).abs() < 10.0, "{report:?}");
        assert!(lost.reversals >= 2);
    }
    // More than a third of the residual is nothing that a linear model explains; after the fit the tracker's noise remains.
    assert!(report.unexplained() > 0.33, "{report:?}");
    assert!(report.nonlinear < 1.05 * 10e-6 * 3f64.sqrt(), "{report:?}");

    let with_fit = mill.with(&truth, &report.springs).radial().reduction_from(&before.radial());
    assert!(with_fit > with_truth - 0.01, "{with_fit} {with_truth}");
    assert!(with_fit > 0.85, "{with_fit}");
}

#[test]
fn a_robot_without_lost_motion_is_not_accused_of_it() {
    let mill = Mill::new(6);
    let truth = Springs::linear(&STIFFNESS);
    let before = mill.without(&truth);
    let modeled = wrong(&truth, 0.3, &mut rng(14));
    let report = explain_residual(&mill.robot, &modeled, &measured(&before, &mut rng(15))).unwrap();
    assert!(report.lost_motion.is_empty(), "{report:?}");
    // All of the residual is a wrong stiffness.
    assert!(report.linear < 1.05 * 10e-6 * 3f64.sqrt(), "{report:?}");
    let with_fit = mill.with(&truth, &report.springs).radial().reduction_from(&before.radial());
    let with_model = mill.with(&truth, &modeled).radial().reduction_from(&before.radial());
    assert!(with_fit > with_model && with_fit > 0.88, "{with_fit} {with_model}");
}

#[test]
fn too_few_samples_are_refused() {
    let mill = Mill::new(7);
    let springs = Springs::linear(&STIFFNESS);
    let run = mill.without(&springs);
    let few: Vec<ResidualSample> = measured(&run, &mut rng(16)).into_iter().take(10).collect();
    let message = explain_residual(&mill.robot, &springs, &few).unwrap_err().to_string();
    assert!(message.contains("10 samples") && message.contains("72"), "{message}");
}
