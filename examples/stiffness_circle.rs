//! Mills a circle of radius 35 mm with a robot that bends, without and with compensation: the tables and figures of `docs/records/stiffness_circle.md`.
//!
//! `cargo run --release --example stiffness_circle [DIR]`
#![allow(clippy::print_stdout)]

use std::error::Error;
use std::path::{Path, PathBuf};

use bracketry::plot::{Color, Dash, Panel, Series, TimeSeries, XyChart};
use bracketry::report::stiffness::text;
use bracketry::stiffness::{
    CircleRun, CompensationError, Compensator, Deformation, JointSpring, Kinematics, MillingCircle, ResidualSample,
    Robot, RobotFile, Springs, Wrench, explain_residual,
};
use nalgebra::Vector3;
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};

/// Draws of the model for each error of stiffness.
const DRAWS: usize = 500;
/// Errors in the first figure are magnified so many times.
const MAGNIFIED: f64 = 40.0;
/// Noise of the tracker that measures the tool point (m).
const TRACKER: f64 = 10e-6;
/// Lost motion of one arc minute (rad), flanks engaged from 30 N·m on.
const GAP: f64 = 2.9e-4;

struct Mill {
    file: RobotFile,
    circle: MillingCircle,
    path: Vec<Vec<f64>>,
}

impl Mill {
    fn new(circle: MillingCircle) -> Result<Self, Box<dyn Error>> {
        let file = RobotFile::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("models/kr125.toml"))?;
        let path = circle.path(&file.robot, &[0.0, -0.3, 0.9, 0.0, 0.9, 0.0])?;
        Ok(Self { file, circle, path })
    }

    fn robot(&self) -> &Robot {
        &self.file.robot
    }

    /// The same with another lag to predict ahead of, and another error of stiffness to reckon with.
    fn reckoning(&self, lag: Option<f64>, stiffness_error: f64) -> Self {
        let mut file = self.file.clone();
        file.compensation.lag = lag;
        file.compensation.stiffness_error = stiffness_error;
        Self { file, circle: self.circle.clone(), path: self.path.clone() }
    }

    fn without(&self, truth: &Springs) -> Result<CircleRun, CompensationError> {
        self.circle.mill(self.robot(), &self.path, truth, None)
    }

    /// The sensor is weighed out in five poses of the wrist, then the circle is milled.
    fn with(&self, truth: &Springs, modeled: &Springs) -> Result<CircleRun, Box<dyn Error>> {
        let wrists = [[0.0, 0.0, 0.0], [0.8, -0.6, 0.5], [-0.8, 0.5, -0.5], [1.5, 0.0, 1.5], [-1.5, 0.3, 0.7]];
        let turned = wrists.map(|wrist| {
            let mut q = self.path[0].clone();
            q[3..].iter_mut().zip(wrist).for_each(|(q, by)| *q += by);
            q
        });
        let payload = self.circle.weigh(self.robot(), &turned, 250)?.payload;
        let robot = self.robot().clone();
        let compensator =
            Compensator::new(robot, modeled.clone(), self.circle.sensor, payload, self.file.compensation)?;
        Ok(self.circle.mill(self.robot(), &self.path, truth, Some(compensator))?)
    }

    /// Reductions of radial error (rms, largest) for several models, the least first.
    fn reductions(&self, truth: &Springs, models: &[Springs]) -> Result<[Vec<f64>; 2], String> {
        let before = self.without(truth).map_err(|e| e.to_string())?.radial();
        let reduce = |models: &[Springs]| -> Result<Vec<(f64, f64)>, String> {
            let one = |model| {
                let after = self.with(truth, model).map_err(|e| e.to_string())?.radial();
                Ok((after.reduction_from(&before), 1.0 - after.max / before.max))
            };
            models.iter().map(one).collect()
        };
        let (first, second) = models.split_at(models.len() / 2);
        let all = std::thread::scope(|scope| {
            let other = scope.spawn(|| reduce(second));
            let mut all = reduce(first)?;
            all.extend(other.join().map_err(|_| "a thread has died".to_owned())??);
            Ok::<_, String>(all)
        })?;
        let (mut rms, mut max): (Vec<f64>, Vec<f64>) = all.into_iter().unzip();
        rms.sort_by(f64::total_cmp);
        max.sort_by(f64::total_cmp);
        Ok([rms, max])
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let dir = std::env::args().nth(1).map_or_else(|| PathBuf::from("out"), PathBuf::from);
    std::fs::create_dir_all(&dir)?;
    let mill = Mill::new(MillingCircle::default())?;
    let truth = mill.file.springs.clone().ok_or("a robot file with springs")?;

    monte_carlo(&mill, &truth)?;
    process(&truth)?;
    let before = mill.without(&truth)?;
    let mut random = StdRng::seed_from_u64(3);
    let runs = [
        ("without compensation", before),
        ("stiffness wrong by up to 30 %", mill.with(&truth, &wrong(&truth, 0.3, &mut random))?),
        ("stiffness wrong by up to 10 %", mill.with(&truth, &wrong(&truth, 0.1, &mut random))?),
    ];
    println!(
        "\n| one draw | radial rms [µm] | radial max [µm] | point to point rms [µm] | max [µm] |\n|---|---|---|---|---|"
    );
    for (name, run) in &runs {
        row(name, run);
    }
    circle_figure(&mill, &runs, &dir)?;
    points_figure(&runs, &dir)?;
    lost_motion(&mill, &truth, &dir)?;
    write_log(&runs[0].1, &mill, &dir.join("circle_log.csv"))?;
    write_measurements(&mill, &truth, &dir.join("measurements.csv"))?;
    println!("\nfigures, circle_log.csv and measurements.csv in {}", dir.display());
    Ok(())
}

/// Springs whose stiffnesses are wrong by at most a share, at random for each joint.
fn wrong(springs: &Springs, share: f64, random: &mut StdRng) -> Springs {
    let factors: Vec<f64> = springs.joints.iter().map(|_| 1.0 + share * random.random_range(-1.0..1.0)).collect();
    springs.scaled(&factors)
}

fn row(name: &str, run: &CircleRun) {
    let (radial, point) = (run.radial(), run.point());
    let [a, b, c, d] = [radial.rms, radial.max, point.rms, point.max].map(|e| 1e6 * e);
    println!("| {name} | {a:.0} | {b:.0} | {c:.0} | {d:.0} |");
}

fn monte_carlo(mill: &Mill, truth: &Springs) -> Result<(), Box<dyn Error>> {
    println!(
        "Reduction of the radial error\n\n| stiffness of each joint wrong by | rms: worst | 5th percentile of {DRAWS} draws | median | largest error: worst | median | rms, reckoning with this error: worst |\n|---|---|---|---|---|---|---|"
    );
    let joints = truth.joints.len();
    let percent = |v: f64| format!("{:.0} %", 100.0 * v);
    for share in [0.0, 0.1, 0.2, 0.3] {
        let mut random = StdRng::seed_from_u64(1);
        let draws = if share > 0.0 { DRAWS } else { 2 };
        let models: Vec<Springs> = (0..draws).map(|_| wrong(truth, share, &mut random)).collect();
        let name =
            if share > 0.0 { format!("at most {} at random", percent(share)) } else { "true stiffness".to_owned() };
        reduced(mill, truth, &name, share, &models)?;
    }
    for share in [0.1, 0.3] {
        let corner = |signs: usize| -> Vec<f64> {
            (0..joints).map(|i| if signs >> i & 1 == 0 { 1.0 - share } else { 1.0 + share }).collect()
        };
        let models: Vec<Springs> = (0..1 << joints).map(|signs| truth.scaled(&corner(signs))).collect();
        let name = format!("exactly ±{}, all {} signs", percent(share), models.len());
        reduced(mill, truth, &name, share, &models)?;
    }
    laws(mill, truth)
}

/// A row of the table: with the settings of the file, and with a stiffness error as large as it is.
fn reduced(mill: &Mill, truth: &Springs, name: &str, share: f64, models: &[Springs]) -> Result<(), Box<dyn Error>> {
    let [rms, max] = mill.reductions(truth, models)?;
    let [stated, _] = mill.reckoning(mill.file.compensation.lag, share).reductions(truth, models)?;
    let middle = models.len() / 2;
    let numbers = [rms[0], rms[models.len() / 20], rms[middle], max[0], max[middle], stated[0]];
    let cells = numbers.map(|v| format!("{:.1} %", 100.0 * v));
    println!("| {name} | {} |", cells.join(" | "));
    Ok(())
}

/// What each part of the compensation is worth, with models whose joints are all wrong in the same direction.
fn laws(mill: &Mill, truth: &Springs) -> Result<(), Box<dyn Error>> {
    const WRONG: [f64; 5] = [1.0, 0.9, 1.1, 0.7, 1.3];
    println!(
        "\n| rms reduced by | true stiffness | all joints 10 % too soft | 10 % too stiff | 30 % too soft | 30 % too stiff | largest gain |\n|---|---|---|---|---|---|---|"
    );
    let before = mill.without(truth)?.radial();
    let lag = mill.file.compensation.lag;
    for (name, lag, stiffness_error) in [
        ("filtered wrench as it comes", None, 0.0),
        ("reckoning with 30 %", None, 0.3),
        ("predicted ahead", lag, 0.0),
        ("predicted ahead, reckoning with 10 %", lag, 0.1),
        ("predicted ahead, reckoning with 30 %", lag, 0.3),
    ] {
        let law = mill.reckoning(lag, stiffness_error);
        let gain = law.file.compensation.largest_gain();
        let reduced: Result<Vec<String>, Box<dyn Error>> = WRONG
            .iter()
            .map(|factor| {
                let after = law.with(truth, &truth.scaled(&[*factor; 6]))?.radial();
                Ok(format!("{:.1} %", 100.0 * after.reduction_from(&before)))
            })
            .collect();
        println!("| {name} | {} | {gain:.2} |", reduced?.join(" | "));
    }
    Ok(())
}

/// The same forces from a stiffer cut.
fn process(truth: &Springs) -> Result<(), Box<dyn Error>> {
    println!(
        "\n| depth of cut [mm] | ρ(K_p C) | ρ((1 + K_p C)⁻¹ K_p Ĉ), 30 % too soft | times the largest gain | radial rms without [µm] | true stiffness | all joints 10 % too soft | 30 % too soft | 30 % too stiff |\n|---|---|---|---|---|---|---|---|---|"
    );
    for stiffer in [1.0, 2.0, 4.0] {
        let mut circle = MillingCircle::default();
        let cutting = &mut circle.cutting;
        cutting.depth /= stiffer;
        for stiffness in [&mut cutting.radial, &mut cutting.tangential, &mut cutting.axial] {
            *stiffness *= stiffer;
        }
        let mill = Mill::new(circle)?;
        let soft = truth.scaled(&[0.7; 6]);
        let gains = mill.circle.stability(mill.robot(), &mill.path, truth, &soft)?;
        let before = mill.without(truth)?.radial();
        let reduction = |model: &Springs| -> Result<f64, Box<dyn Error>> {
            Ok(100.0 * mill.with(truth, model)?.radial().reduction_from(&before))
        };
        println!(
            "| {:.0} | {:.2} | {:.2} | {:.2} | {:.0} | {:.1} % | {:.1} % | {:.1} % | {:.1} % |",
            1e3 * mill.circle.cutting.depth,
            gains.process,
            gains.compensation,
            gains.compensation * mill.file.compensation.largest_gain(),
            1e6 * before.rms,
            reduction(truth)?,
            reduction(&truth.scaled(&[0.9; 6]))?,
            reduction(&soft)?,
            reduction(&truth.scaled(&[1.3; 6]))?
        );
    }
    Ok(())
}

fn angles(run: &CircleRun) -> Vec<f64> {
    run.samples.iter().map(|s| s.angle.to_degrees()).collect()
}

/// Means over 40 ms, in which the ripple of the teeth is lost.
fn smooth(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let values: Vec<f64> = values.collect();
    let around = |k: usize| &values[k.saturating_sub(5)..(k + 5).min(values.len())];
    (0..values.len()).map(|k| around(k).iter().sum::<f64>() / around(k).len() as f64).collect()
}

fn circle_figure(mill: &Mill, runs: &[(&str, CircleRun)], dir: &Path) -> Result<(), Box<dyn Error>> {
    let point = |angle: f64, radius: f64| (1e3 * radius * angle.cos(), 1e3 * radius * angle.sin());
    let (x, y): (Vec<f64>, Vec<f64>) = (0..=360).map(|k| point(f64::from(k).to_radians(), mill.circle.radius)).unzip();
    let mut panel = Panel::new("y [mm]").series(Series::new("circle", x, y).color(Color::INK).dash(Dash::Dashed));
    let mut largest: f64 = 1e3 * mill.circle.radius;
    for (k, (name, run)) in runs.iter().enumerate() {
        let errors = smooth(run.samples.iter().map(|s| s.radial_error));
        let magnified = run.samples.iter().zip(errors).map(|(s, e)| point(s.angle, mill.circle.radius + MAGNIFIED * e));
        let (x, y): (Vec<f64>, Vec<f64>) = magnified.unzip();
        largest = x.iter().chain(&y).fold(largest, |m, v| m.max(v.abs()));
        panel = panel.series(Series::new(*name, x, y).color(Color::series(k)));
    }
    let chart = XyChart::new("x [mm]", panel.limits(-1.08 * largest, 1.08 * largest).height(690.0));
    chart
        .title(format!("Milled circle, radial error magnified {MAGNIFIED} times (mean over 40 ms)"))
        .draw()?
        .save(dir.join("stiffness_circle"))?;
    Ok(())
}

fn points_figure(runs: &[(&str, CircleRun)], dir: &Path) -> Result<(), Box<dyn Error>> {
    let mut panel = Panel::new("distance from the reference [µm]");
    for (name, run) in runs {
        let errors = smooth(run.samples.iter().map(|s| 1e6 * s.point_error));
        panel = panel.series(Series::new(*name, angles(run), errors));
    }
    XyChart::new("angle along the circle [°]", panel)
        .title("Distance of the tool point from its reference (mean over 40 ms)")
        .draw()?
        .save(dir.join("stiffness_points"))?;
    Ok(())
}

/// Two joints with lost motion: what a linear model gains, why not more, and what the nonlinear model gains.
fn lost_motion(mill: &Mill, linear: &Springs, dir: &Path) -> Result<(), Box<dyn Error>> {
    let mut truth = linear.clone();
    for joint in [0, 4] {
        if let JointSpring::Linear { stiffness } = truth.joints[joint] {
            truth.joints[joint] = JointSpring::Backlash { stiffness, gap: GAP, engaged: 30.0 };
        }
    }
    let before = mill.without(&truth)?;
    let mut random = StdRng::seed_from_u64(7);
    let samples: Vec<ResidualSample> = before
        .samples
        .iter()
        .step_by(4)
        .map(|s| ResidualSample {
            coordinates: s.coordinates.clone(),
            wrench: s.wrench,
            displacement: s.displacement
                + Vector3::from_fn(|_, _| {
                    let z: f64 = StandardNormal.sample(&mut random);
                    TRACKER * z
                }),
        })
        .collect();
    let report = explain_residual(mill.robot(), linear, &samples)?;
    println!("\nlost motion of {:.2} mrad in joints 1 and 5, measured with a tracker of 10 µm:", 1e3 * GAP);
    println!("{}", text::lost_motion(&report));
    let runs = [
        ("linear model", mill.with(&truth, linear)?),
        ("nonlinear model, fitted", mill.with(&truth, &report.springs)?),
        ("nonlinear model, true", mill.with(&truth, &truth)?),
    ];
    println!(
        "| lost motion in two joints | radial rms [µm] | radial max [µm] | point to point rms [µm] | max [µm] |\n|---|---|---|---|---|"
    );
    row("without compensation", &before);
    for (name, run) in &runs {
        row(name, run);
    }
    let reductions =
        runs.iter().map(|(name, run)| format!("{name} {:.0} %", 100.0 * run.radial().reduction_from(&before.radial())));
    println!("\n{}", reductions.collect::<Vec<_>>().join(", "));

    let radial = |run: &CircleRun| run.samples.iter().map(|s| 1e6 * s.radial_error).collect::<Vec<f64>>();
    let errors = Panel::new("radial error [µm]")
        .height(240.0)
        .series(Series::new("without compensation", angles(&before), radial(&before)))
        .series(Series::new(runs[0].0, angles(&runs[0].1), radial(&runs[0].1)))
        .series(Series::new(runs[1].0, angles(&runs[1].1), radial(&runs[1].1)));
    let mut torques = Panel::new("torque [N·m]").height(150.0);
    for joint in [0, 4] {
        let torque: Result<Vec<f64>, Box<dyn Error>> = before
            .samples
            .iter()
            .map(|s| Ok(Kinematics::new(mill.robot(), &s.coordinates)?.torque(joint, &s.wrench)))
            .collect();
        torques = torques.series(Series::new(format!("joint {}", joint + 1), angles(&before), torque?));
    }
    TimeSeries::new()
        .title("Lost motion in joints 1 and 5")
        .time_label("angle along the circle [°]")
        .panel(errors)
        .panel(torques.named_bound("flanks engaged", 30.0).named_bound("", -30.0))
        .draw()?
        .save(dir.join("stiffness_lost_motion"))?;
    Ok(())
}

/// The circle without compensation as a log for `bracketry stiffness compensate`.
fn write_log(run: &CircleRun, mill: &Mill, path: &Path) -> Result<(), Box<dyn Error>> {
    let mut writer = csv::Writer::from_path(path)?;
    let joints = mill.robot().joints.len();
    let mut header = vec!["t".to_owned()];
    header.extend((1..=joints).map(|i| format!("q{i}")));
    header.extend(["Fx", "Fy", "Fz", "Mx", "My", "Mz"].map(String::from));
    writer.write_record(&header)?;
    for (k, s) in run.samples.iter().enumerate() {
        let mut values = vec![k as f64 * mill.circle.period];
        values.extend(&s.coordinates);
        values.extend(s.reading.iter());
        writer.write_record(values.iter().map(|v| format!("{v:.9}")))?;
    }
    writer.flush()?;
    Ok(())
}

/// Displacements under loads in 20 poses, with the noise of the robot file, for `bracketry stiffness identify`.
fn write_measurements(mill: &Mill, truth: &Springs, path: &Path) -> Result<(), Box<dyn Error>> {
    let mut random = StdRng::seed_from_u64(11);
    let mut writer = csv::Writer::from_path(path)?;
    let columns =
        ["q1", "q2", "q3", "q4", "q5", "q6", "Fx", "Fy", "Fz", "Mx", "My", "Mz", "dx", "dy", "dz", "rx", "ry", "rz"];
    writer.write_record(columns)?;
    let noise = &mill.file.noise;
    let deviations = [[noise.force, noise.moment], [noise.translation, noise.rotation]];
    for _ in 0..20 {
        let q: Vec<f64> = mill.path[0].iter().map(|q| q + random.random_range(-0.7..0.7)).collect();
        for _ in 0..10 {
            let load = Wrench::from_fn(|i, _| [1000.0, 60.0][i / 3] * random.random_range(-1.0..1.0));
            let moved = Deformation::equilibrium(mill.robot(), truth, &q, &load)?.tool;
            let mut values = q.clone();
            for (vector, deviation) in [(load, deviations[0]), (moved, deviations[1])] {
                values.extend(vector.iter().enumerate().map(|(i, v)| {
                    let z: f64 = StandardNormal.sample(&mut random);
                    v + deviation[i / 3] * z
                }));
            }
            writer.write_record(values.iter().map(|v| format!("{v:.9}")))?;
        }
    }
    writer.flush()?;
    Ok(())
}
