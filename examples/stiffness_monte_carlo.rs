//! How well each estimator finds the stiffness of a KUKA KR 125 from noisy measurements; tables and a figure of
//! `docs/records/stiffness_identification.md`: `cargo run --release --example stiffness_monte_carlo --features measure -- docs/figures`.
#![allow(clippy::print_stdout)]

#[path = "../crates/stiffness/tests/main/common/kr125.rs"]
mod table;

use bracketry::plot::{Panel, Series, XyChart};
use bracketry::report::stiffness::text;
use bracketry::stiffness::{
    CartesianEstimator, Deformation, DeformationModel, Kinematics, Measurement, MeasurementNoise, MeasurementSet,
    Outliers, PoseInformation, Robot, SpringFit, SpringFitSettings, Springs, Wrench, compare, fit_springs,
    identify_cartesian, loaded_compliance,
};
use nalgebra::{Matrix6, Vector6};
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use std::error::Error;
use std::path::Path;
use table::{STIFFNESS, pose};

/// Standard deviations: 20 µm, 50 µrad, 2 N, 0.5 N·m.
const NOISE: [f64; 4] = [20e-6, 50e-6, 2.0, 0.5];
/// Loads are drawn evenly from ± 1000 N and ± 60 N·m.
const LOADS: [f64; 2] = [1000.0, 60.0];
/// Data sets for each figure.
const TRIALS: usize = 100;
/// Poses over which the joint springs are measured.
const POSES: usize = 20;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

fn kr125() -> (Robot, Springs) {
    (table::kr125(), Springs::linear(&STIFFNESS))
}

fn noise() -> MeasurementNoise {
    MeasurementNoise::from_std(NOISE[0], NOISE[1], NOISE[2], NOISE[3])
}

fn load(rng: &mut StdRng) -> Wrench {
    Wrench::from_fn(|i, _| LOADS[i / 3] * rng.random_range(-1.0..1.0))
}

/// A pose within ± 40° of the one of the reference.
fn random_pose(rng: &mut StdRng) -> Vec<f64> {
    pose().iter().map(|q| q + rng.random_range(-40.0f64..40.0).to_radians()).collect()
}

fn noisy(rng: &mut StdRng, value: Vector6<f64>, first: f64, last: f64) -> Vector6<f64> {
    let mut draw = || -> f64 { StandardNormal.sample(rng) };
    Vector6::from_fn(|i, _| value[i] + draw() * if i < 3 { first } else { last })
}

/// The robot measured under a load.
fn measured(rng: &mut StdRng, robot: &Robot, springs: &Springs, q: &[f64], wrench: Wrench) -> Result<Measurement> {
    let tool = Deformation::equilibrium(robot, springs, q, &wrench)?.tool;
    let displacement = noisy(rng, tool, NOISE[0], NOISE[1]);
    Ok(Measurement { q: q.to_vec(), wrench: noisy(rng, wrench, NOISE[2], NOISE[3]), displacement })
}

/// Makes every twentieth measurement wrong: a displacement or a load ten times as large as they are.
fn spoil(rng: &mut StdRng, measurements: &mut [Measurement]) {
    for (n, m) in measurements.iter_mut().enumerate().filter(|(n, _)| n % 20 == 7) {
        if n % 40 == 7 {
            m.displacement = Vector6::from_fn(|i, _| [5e-3, 5e-3][i / 3] * rng.random_range(-1.0..1.0));
        } else {
            m.wrench = 10.0 * load(rng);
        }
    }
}

fn set_at_one_pose(rng: &mut StdRng, count: usize, spoiled: bool) -> Result<MeasurementSet> {
    let (robot, springs) = kr125();
    let mut measurements = Vec::with_capacity(count);
    for _ in 0..count {
        let wrench = load(rng);
        measurements.push(measured(rng, &robot, &springs, &pose(), wrench)?);
    }
    if spoiled {
        spoil(rng, &mut measurements);
    }
    Ok(MeasurementSet::new(measurements, noise())?)
}

fn set_over_poses(rng: &mut StdRng, count: usize, spoiled: bool) -> Result<MeasurementSet> {
    let (robot, springs) = kr125();
    let poses: Vec<Vec<f64>> = (0..POSES.min(count)).map(|_| random_pose(rng)).collect();
    let mut measurements = Vec::with_capacity(count);
    for n in 0..count {
        let wrench = load(rng);
        measurements.push(measured(rng, &robot, &springs, &poses[n % poses.len()], wrench)?);
    }
    if spoiled {
        spoil(rng, &mut measurements);
    }
    Ok(MeasurementSet::new(measurements, noise())?)
}

fn joint_fit(set: &MeasurementSet, outliers: Outliers) -> Result<SpringFit> {
    let (robot, _) = kr125();
    let settings = SpringFitSettings { outliers, model: DeformationModel::Product, ..SpringFitSettings::default() };
    Ok(fit_springs(&robot, set, &Springs::linear(&[5e5; 6]), &settings)?)
}

fn stiffness_at_pose(springs: &Springs) -> Result<Matrix6<f64>> {
    let (robot, _) = kr125();
    let kinematics = Kinematics::new(&robot, &pose())?;
    let compliance = loaded_compliance(&robot, springs, &kinematics, &Wrench::zeros())?;
    compliance.try_inverse().ok_or_else(|| "the pose is singular".into())
}

fn relative(found: &Matrix6<f64>, truth: &Matrix6<f64>) -> f64 {
    (found - truth).norm() / truth.norm()
}

/// Relative errors of the six joints; infinite where one is not identified.
fn joint_errors(fit: &SpringFit) -> [f64; 6] {
    fit.springs().map_or([f64::INFINITY; 6], |springs| {
        std::array::from_fn(|j| (1.0 / (springs.joints[j].compliance(0.0) * STIFFNESS[j]) - 1.0).abs())
    })
}

fn root_mean_square(errors: &[f64]) -> f64 {
    (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Over the data sets: lower quartile, median and upper quartile of the error of K, median error of C, share of positive definite estimates.
fn cartesian(estimator: CartesianEstimator, count: usize, spoiled: bool, outliers: Outliers) -> Result<[f64; 5]> {
    let (_, springs) = kr125();
    let truth = stiffness_at_pose(&springs)?;
    let inverse = truth.try_inverse().ok_or("the pose is singular")?;
    let (mut k, mut c, mut definite) = (Vec::new(), Vec::new(), 0.0);
    for trial in 0..TRIALS {
        let set = set_at_one_pose(&mut StdRng::seed_from_u64(trial as u64), count, spoiled)?;
        let estimate = identify_cartesian(&set, estimator, outliers)?;
        k.push(relative(&estimate.stiffness, &truth));
        c.push(relative(&estimate.compliance, &inverse));
        definite += f64::from(u8::from(estimate.positive_definite)) / TRIALS as f64;
    }
    k.sort_by(f64::total_cmp);
    Ok([k[TRIALS / 4], k[TRIALS / 2], k[3 * TRIALS / 4], median(c), definite])
}

type Draw = fn(&mut StdRng, usize, bool) -> Result<MeasurementSet>;

/// Medians over the data sets: errors of K at the pose and of each joint's stiffness.
fn joints(count: usize, spoiled: bool, outliers: Outliers, draw: Draw) -> Result<(f64, [f64; 6])> {
    let (_, springs) = kr125();
    let truth = stiffness_at_pose(&springs)?;
    let (mut k, mut joints) = (Vec::new(), vec![Vec::new(); 6]);
    for trial in 0..TRIALS {
        let set = draw(&mut StdRng::seed_from_u64(trial as u64), count, spoiled)?;
        let fit = joint_fit(&set, outliers)?;
        k.push(match fit.springs() {
            Ok(springs) => relative(&stiffness_at_pose(springs)?, &truth),
            Err(_) => f64::INFINITY,
        });
        joints.iter_mut().zip(joint_errors(&fit)).for_each(|(all, error)| all.push(error));
    }
    Ok((median(k), std::array::from_fn(|j| median(joints[j].clone()))))
}

fn over_counts(folder: &Path) -> Result<()> {
    let counts = [20usize, 50, 100, 200, 500, 1000];
    let columns: Vec<String> = counts.iter().map(|n| format!("N = {n}")).collect();
    println!("\n| error of K, median of {TRIALS} data sets | {} |", columns.join(" | "));
    println!("|---|{}", "---|".repeat(counts.len()));
    let x: Vec<f64> = counts.iter().map(|n| (*n as f64).log10()).collect();
    let mut panel = Panel::new("median error of K [%]").limits(0.0, 100.0).height(330.0);
    let mut show = |name: &str, errors: &[f64]| {
        let cells: Vec<String> = errors.iter().map(|e| format!("{:.1} %", 100.0 * e)).collect();
        println!("| {name} | {} |", cells.join(" | "));
        let y: Vec<f64> = errors.iter().map(|e| 100.0 * e).collect();
        panel = panel.clone().series(Series::new(name, x.clone(), y).markers());
    };
    for estimator in CartesianEstimator::ALL {
        let mut errors = Vec::new();
        for count in counts {
            errors.push(cartesian(estimator, count, false, Outliers::Keep)?[1]);
        }
        // With the same noise for all it is the estimator above it.
        if estimator != CartesianEstimator::Weighted {
            show(&estimator.to_string(), &errors);
        }
    }
    let mut errors = Vec::new();
    for count in counts {
        errors.push(joints(count, false, Outliers::Keep, set_over_poses)?.0);
    }
    show("joint springs, 20 poses", &errors);
    let chart = XyChart::new("number of measurements N", panel)
        .beside()
        .x_ticks(counts.iter().zip(x).map(|(count, x)| (x, count.to_string())))
        .title("Stiffness of a KR 125 from N noisy measurements: error of K");
    chart.draw()?.save(folder.join("stiffness_identification"))?;
    Ok(())
}

fn at_two_hundred() -> Result<()> {
    println!(
        "\n| N = 200 | error of K (quartiles) | of C | definite | at N = 20 | of K, 5 % outliers kept | rejected |"
    );
    println!("|---|---|---|---|---|---|---|");
    let percent = |v: f64| format!("{:.1} %", 100.0 * v);
    for estimator in CartesianEstimator::ALL {
        let [low, k, high, c, definite] = cartesian(estimator, 200, false, Outliers::Keep)?;
        let few = 100.0 * cartesian(estimator, 20, false, Outliers::Keep)?[4];
        let kept = cartesian(estimator, 200, true, Outliers::Keep)?[1];
        let kept = if kept > 10.0 { "> 1000 %".to_owned() } else { percent(kept) };
        let rejected = percent(cartesian(estimator, 200, true, Outliers::Reject)?[1]);
        let quartiles = format!("{:.1} – {}", 100.0 * low, percent(high));
        let (k, c, definite) = (percent(k), percent(c), 100.0 * definite);
        println!("| {estimator} | {k} ({quartiles}) | {c} | {definite:.0} % | {few:.0} % | {kept} | {rejected} |");
    }
    println!("\n| N = 200, joint springs | error of K | k1 | k2 | k3 | k4 | k5 | k6 |");
    println!("|---|---|---|---|---|---|---|---|");
    for (name, spoiled, outliers, draw) in [
        ("1 pose", false, Outliers::Keep, set_at_one_pose as Draw),
        ("20 poses", false, Outliers::Keep, set_over_poses),
        ("20 poses, 5 % outliers kept", true, Outliers::Keep, set_over_poses),
        ("20 poses, 5 % outliers rejected", true, Outliers::Reject, set_over_poses),
    ] {
        let (k, each) = joints(200, spoiled, outliers, draw)?;
        let shown = |v: f64| if v.is_finite() { percent(v) } else { "not identified".to_owned() };
        println!("| {name} | {} | {} |", shown(k), each.map(shown).join(" | "));
    }
    Ok(())
}

/// What the size of the loads and the measure of the error do to least squares either way.
fn over_loads() -> Result<()> {
    let (robot, springs) = kr125();
    let truth = stiffness_at_pose(&springs)?;
    let spectral = |found: &Matrix6<f64>| (found - truth).singular_values().max() / truth.singular_values().max();
    println!(
        "\n| error of K, N = 200 | W on ΔX (published) | ΔX on W | its symmetric part | spectral norm: W on ΔX | ΔX on W |"
    );
    println!("|---|---|---|---|---|---|");
    for [force, moment] in
        [[500.0, 60.0], [1000.0, 50.0], [1000.0, 60.0], [1000.0, 75.0], [1000.0, 100.0], [1000.0, 200.0]]
    {
        let mut errors: [Vec<f64>; 5] = Default::default();
        for trial in 0..TRIALS {
            let mut rng = StdRng::seed_from_u64(trial as u64);
            let mut measurements = Vec::new();
            for _ in 0..200 {
                let wrench =
                    load(&mut rng).component_mul(&Wrench::from_fn(|i, _| [force, moment][i / 3] / LOADS[i / 3]));
                measurements.push(measured(&mut rng, &robot, &springs, &pose(), wrench)?);
            }
            let set = MeasurementSet::new(measurements, noise())?;
            let found = |estimator| identify_cartesian(&set, estimator, Outliers::Keep).map(|e| e.stiffness);
            let published = found(CartesianEstimator::WrenchOnDisplacement)?;
            let other = found(CartesianEstimator::DisplacementOnWrench)?;
            let each = [
                relative(&published, &truth),
                relative(&other, &truth),
                relative(&(0.5 * (other + other.transpose())), &truth),
                spectral(&published),
                spectral(&other),
            ];
            errors.iter_mut().zip(each).for_each(|(all, error)| all.push(error));
        }
        let cells = errors.map(|errors| format!("{:.1} %", 100.0 * median(errors)));
        println!("| loads to {force} N, {moment} N·m | {} |", cells.join(" | "));
    }
    Ok(())
}

/// Ten measurements chosen among 400 against ten at random.
fn chosen_poses() -> Result<()> {
    let (robot, springs) = kr125();
    let mut rng = StdRng::seed_from_u64(7);
    let candidates: Vec<(Vec<f64>, Wrench)> = (0..400).map(|_| (random_pose(&mut rng), load(&mut rng))).collect();
    let information = PoseInformation::new(&robot, &springs, &candidates, &noise())?;
    println!(
        "\n| 10 measurements of 400 candidates | expected error of k_j (worst joint) | measured error of k_j (root mean square) | condition |"
    );
    println!("|---|---|---|---|");
    let mut report = |name: &str, choices: &[Vec<usize>]| -> Result<()> {
        let (mut expected, mut found, mut condition) = (Vec::new(), Vec::new(), Vec::new());
        for choice in choices {
            let told = information.of(choice);
            expected.push(told.log_std.iter().fold(0.0f64, |a, b| a.max(*b)));
            condition.push(told.condition);
            for _ in 0..TRIALS / choices.len() {
                let mut measurements = Vec::new();
                for i in choice {
                    measurements.push(measured(&mut rng, &robot, &springs, &candidates[*i].0, candidates[*i].1)?);
                }
                let set = MeasurementSet::new(measurements, noise())?;
                found.push(root_mean_square(&joint_errors(&joint_fit(&set, Outliers::Keep)?)));
            }
        }
        let (expected, found) = (100.0 * median(expected), 100.0 * median(found));
        println!("| {name} | {expected:.1} % | {found:.1} % | {:.1} |", median(condition));
        Ok(())
    };
    report("D-optimal", &[information.choose(10)?.chosen])?;
    let mut draw = StdRng::seed_from_u64(8);
    let random: Vec<Vec<usize>> =
        (0..50).map(|_| rand::seq::index::sample(&mut draw, candidates.len(), 10).into_vec()).collect();
    report("at random (median of 50 choices)", &random)
}

fn main() -> Result<()> {
    let folder = std::env::args().nth(1).ok_or("give the folder for the figure, docs/figures")?;
    over_counts(Path::new(&folder))?;
    at_two_hundred()?;
    over_loads()?;
    chosen_poses()?;
    let (robot, _) = kr125();
    let set = set_at_one_pose(&mut StdRng::seed_from_u64(0), 200, true)?;
    let start = Springs::linear(&[5e5; 6]);
    let comparison = compare(&set, Some((&robot, &start, &SpringFitSettings::default())), Outliers::Reject)?;
    println!("\n{}", text::comparison(&comparison));
    Ok(())
}
