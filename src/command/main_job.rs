//! The main job: the plate, from its published equations to position and orientation controlled together.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use bracketry::lie::Options;
use bracketry::mpc::{ControlProblem, SolveTimes, Timings};
use bracketry::plate::{AmplitudeStep, Experiment, Shape, TwoStep, published, two_step};
use bracketry::sim::{Settings, Trajectory};
use bracketry::{Arrival, Controlled, control, plate_move};
use serde_json::{Value, json};

use super::output::{self, csv, folder, json, write};
use super::{Outcome, OutputArgs, analyze};

mod figures;

/// Samples after the move, in which object and plate must stay at rest.
const REST_SAMPLES: usize = 30;
/// Distance of the rows of the trajectories (s).
const CSV_STEP: f64 = 5e-3;
/// Longest time of one stage of the two-step way (s).
const STAGE_LIMIT: f64 = 30.0;

/// Collects the report and prints it as it grows.
struct Report {
    text: String,
    quiet: bool,
}

impl Report {
    fn line(&mut self, line: &str) -> anyhow::Result<()> {
        self.text += line;
        self.text.push('\n');
        if self.quiet { Ok(()) } else { output::line(line) }
    }
}

/// Runs everything and writes `out/`.
pub(crate) fn run(options: &OutputArgs) -> anyhow::Result<Outcome> {
    let begin = Instant::now();
    let out = options.out.clone().unwrap_or_else(|| PathBuf::from("out"));
    folder(&out)?;
    let mut report = Report { text: String::new(), quiet: options.json };
    let (shape, mu) = (Shape::REFERENCE_ELLIPSE, 0.3);
    let model = published(&shape, mu)?;

    report.line("1. From the published equations to what the inputs reach\n")?;
    let analysis = with_spinner("brackets and ranks", || bracketry::analyze(&model, &Options::default()))?;
    analyze::save(&analysis, &out)?;
    report.line(&analysis.to_string())?;

    report.line("2. Position and orientation together\n")?;
    let mut problem = plate_move(&shape, mu)?;
    // Afterwards everything has to stay where it is.
    problem.samples += REST_SAMPLES;
    let together = with_spinner("plan, then closed loop on exact stick–slip friction", || control(&problem))?;
    let two = with_spinner("the published two-step way on the same plant", || published_way(&shape, mu, &problem))?;
    let job = Job { shape, arrival: Arrival::of(&problem, &together), problem, together, two };
    report.line(&job.table())?;

    with_spinner("figures", || figures::draw(&out, &job));
    job.write_trajectories(&out)?;
    let summary = job.summary(begin.elapsed());
    write(&out.join("main.json"), &json(&summary)?)?;
    report.line(&format!(
        "written to {}: report.txt, main.json, analysis.json, analysis.txt, analysis.md, affine.toml, simultaneous.csv, two_step.csv\n\
         and the figures closed_loop, comparison, plan_view, growth, reach (svg and png); {:.1} s in all",
        out.display(),
        begin.elapsed().as_secs_f64()
    ))?;
    write(&out.join("report.txt"), &report.text)?;
    if options.json {
        output::print(&json(&summary)?)?;
    }
    Ok(if job.arrival.settled_s.is_some() { Outcome::Done } else { Outcome::Negative })
}

/// Runs `work` while a spinner turns.
fn with_spinner<T>(message: &str, work: impl FnOnce() -> T) -> T {
    let progress = output::spinner(message);
    let result = work();
    progress.finish_and_clear();
    result
}

/// First orientation, then x, then y, with the published inputs. The published torque turns clockwise, so the tilt of
/// experiment 1 is turned round to aim at +90°.
fn published_way(shape: &Shape, mu: f64, problem: &ControlProblem) -> anyhow::Result<TwoStep> {
    let along_x = Experiment::translation_x(3).with_amplitude_step(AmplitudeStep::Smooth);
    let stages = [Experiment::orientation().with_reversed_tilt(), along_x, Experiment::translation_y()];
    // x, y, phi, vx, vy, w: the affine model's states without those of the plate.
    let start = &problem.x0[..6];
    Ok(two_step(&published(shape, mu)?, &stages, start, STAGE_LIMIT, &Settings::default())?)
}

/// What the main job computed.
struct Job {
    shape: Shape,
    problem: ControlProblem,
    together: Controlled,
    arrival: Arrival,
    two: TwoStep,
}

impl Job {
    /// When the last stage was stopped, if every stage met its target.
    fn two_step_time(&self) -> Option<f64> {
        self.two.stages.iter().all(|s| s.met).then(|| self.two.stages.last().map_or(0.0, |s| s.to))
    }

    /// Errors of x (m), y (m) and yaw (deg) at the end of the two-step way, whose stages go yaw, x, y.
    fn two_step_errors(&self) -> [Option<f64>; 3] {
        let error = |i: usize| self.two.final_errors.get(i).copied();
        [error(1), error(2), error(0).map(f64::to_degrees)]
    }

    /// Medians of linearisation, quadratic program and rest over the solved samples (ms).
    fn split(&self) -> [f64; 3] {
        let of = |f: fn(&Timings) -> f64| {
            let solved = self.together.run.closed_loop.steps.iter().map(|s| &s.timings).filter(|t| t.total() > 0.0);
            SolveTimes::of(&solved.map(f).collect::<Vec<_>>()).median
        };
        [of(|t| t.linearise), of(|t| t.qp), of(|t| t.rest)]
    }

    /// Sampling periods in which a program was solved over the time that this took.
    fn real_time_factor(&self) -> f64 {
        let steps = &self.together.run.closed_loop.steps;
        let times: Vec<f64> = steps.iter().map(|s| s.timings.total()).filter(|t| *t > 0.0).collect();
        times.len() as f64 * self.problem.ocp.dt / times.iter().sum::<f64>()
    }

    fn summary(&self, elapsed: Duration) -> Value {
        let report = &self.together.run.report;
        let [linearise, qp, rest] = self.split();
        let plate = &self.together.recording.trajectory.final_state()[6..];
        let [x, y, phi] = self.two_step_errors();
        json!({
            "target_error": {"x_m": self.arrival.x_m, "y_m": self.arrival.y_m, "phi_deg": self.arrival.phi_deg},
            "spin_deg_s": self.arrival.spin_deg_s,
            "time_s": self.arrival.settled_s,
            "two_step_time_s": self.two_step_time(),
            "step_ms": report.solve_ms,
            "real_time_factor": self.real_time_factor(),
            "step_split_ms": {"linearise": linearise, "qp": qp, "rest": rest},
            "sampling_period_ms": report.period_ms,
            "move_s": self.problem.ocp.steps as f64 * self.problem.ocp.dt,
            "simulated_s": self.together.recording.trajectory.end(),
            "status": report.status,
            "plate_at_end": {"X_m": plate[0], "Xd_m_s": plate[1], "theta_deg": plate[2].to_degrees(),
                             "thetad_deg_s": plate[3].to_degrees()},
            "bound_excess": {"stroke_m": self.arrival.stroke_excess_m, "tilt_deg": self.arrival.tilt_excess_deg},
            "plan": report.plan,
            "two_step": {"x_m": x, "y_m": y, "phi_deg": phi, "spin_deg_s": self.two.remaining_spin.to_degrees(),
                         "stages": self.two.stages.iter().map(|s| json!({"name": s.name, "from_s": s.from,
                             "to_s": s.to, "met": s.met})).collect::<Vec<_>>()},
            "seconds": elapsed.as_secs_f64(),
        })
    }

    fn table(&self) -> String {
        let seconds = |t: Option<f64>| t.map_or("not reached".to_owned(), |t| format!("{t:.2} s"));
        let value = |v: Option<f64>, unit: &str| v.map_or("–".to_owned(), |v| format!("{v:+.2} {unit}"));
        let (a, [x, y, phi]) = (&self.arrival, self.two_step_errors());
        let mm = |v: Option<f64>| value(v.map(|v| 1e3 * v), "mm");
        let rows = [
            [String::new(), "together (MPC)".to_owned(), "two steps".to_owned()],
            ["time to target".to_owned(), seconds(a.settled_s), seconds(self.two_step_time())],
            ["error in x".to_owned(), mm(Some(a.x_m)), mm(x)],
            ["error in y".to_owned(), mm(Some(a.y_m)), mm(y)],
            ["error in yaw".to_owned(), value(Some(a.phi_deg), "°"), value(phi, "°")],
            [
                "remaining spin".to_owned(),
                value(Some(a.spin_deg_s), "°/s"),
                value(Some(self.two.remaining_spin.to_degrees()), "°/s"),
            ],
        ];
        let report = &self.together.run.report;
        let mut out: Vec<String> = Vec::new();
        if let Some(p) = &report.plan {
            out.push(format!("plan: {} after {} quadratic programs in {:.2} s\n", p.status, p.programs, p.seconds));
        }
        out.push("On the same plant with exact set-valued friction, errors at the end:\n".to_owned());
        for r in rows {
            out.push(format!("  {:<16} {:>16} {:>16}", r[0], r[1], r[2]));
        }
        out.push(String::new());
        for s in &self.two.stages {
            let verdict = if s.met { "met" } else { "not met" };
            out.push(format!(
                "  two steps: experiment {} from {:.2} s to {:.2} s, target {verdict}",
                s.name, s.from, s.to
            ));
        }
        if self.two.remaining_spin.abs() > 2f64.to_radians() {
            out.push(
                "  The published model has no yaw friction: once turned, the object goes on spinning while it is moved,\n  \
                 so the two-step time counts stages that met their targets, not a yaw that stays there."
                    .to_owned(),
            );
        }
        out.push(
            "  The published inputs keep no bounds on stroke, tilt or accelerations, and the plate is taken to stop and\n  \
             level at once between stages."
                .to_owned(),
        );
        let [linearise, qp, rest] = self.split();
        let (t, c) = (&report.solve_ms, &report.status);
        out.push(format!(
            "\n  bounds between samples: stroke exceeded by {:.3} mm, tilt by {:.4}° at most",
            1e3 * a.stroke_excess_m,
            a.tilt_excess_deg
        ));
        out.push(format!(
            "  control step: median {:.2} ms, 99 % below {:.2} ms, sampling period {:.0} ms; {:.1} × real time\n  \
             of which, medians: linearise {linearise:.2} ms, quadratic program {qp:.2} ms, rest {rest:.2} ms",
            t.median,
            t.p99,
            report.period_ms,
            self.real_time_factor()
        ));
        out.push(format!(
            "  samples: {} solved, {} inaccurate, {} infeasible, {} fallback, {} at rest after the plan\n",
            c.solved, c.inaccurate, c.infeasible, c.fallback, c.played_out
        ));
        out.join("\n")
    }

    /// Both trajectories as CSV, every 5 ms.
    fn write_trajectories(&self, out: &Path) -> anyhow::Result<()> {
        let sampled = |trajectory: &Trajectory| -> Vec<Vec<f64>> {
            let count = (trajectory.end() / CSV_STEP).round() as usize;
            let times = (0..=count).map(|k| k as f64 * CSV_STEP);
            times.map(|t| std::iter::once(t).chain(trajectory.sample(t)).collect()).collect()
        };
        let mut header = vec!["t".to_owned()];
        header.extend(self.problem.plant.state_names());
        header.extend(self.problem.plant.input_names());
        let mut rows = sampled(&self.together.recording.trajectory);
        let run = &self.together.run.closed_loop;
        for row in &mut rows {
            let k = run.t.partition_point(|&t| t <= row[0] + 1e-9).clamp(1, run.u.len());
            row.extend(&run.u[k - 1]);
        }
        csv(&out.join("simultaneous.csv"), &header, rows.iter().map(Vec::as_slice))?;
        let header = ["t", "x", "y", "phi", "vx", "vy", "w"].map(str::to_owned);
        csv(&out.join("two_step.csv"), &header, sampled(&self.two.trajectory).iter().map(Vec::as_slice))
    }
}
