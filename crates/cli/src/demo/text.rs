//! The story in words.

use std::fmt::{self, Write as _};

use bracketry::diagnose::{Cause, NamedCause};
use bracketry::plate::area::AreaOutcome;
use bracketry::plate::recording::SyntheticLog;

use super::on_equations::MoveOnEquations;
use super::on_plant::MoveOnPlant;
use super::story::Story;
use bracketry::lie::analysis::RankChange;
use bracketry::report::rank_change_text;

/// What is simulated, and what the equations are taken from.
pub(super) const OPENING: &str = "\
The published model is that of M. Momeni Kelageri, Training and Research Activities Report, First Year, XXIX Cycle,
PhD in Information Technology and Electrical Engineering, Università degli Studi di Napoli Federico II, 2015, chapter 3.
`bracketry publication` gives a verdict on each of its equations.
No physical plate was available: the true plant is a simulation of contact over the whole footprint of the object,
and the logs are recorded from it, with simulated camera noise.
";
pub(super) const FIRST: &str = "1. From the published equations to what the inputs reach\n";
pub(super) const SECOND: &str = "2. Position and orientation together, on the published equations\n";
pub(super) const THIRD: &str = "3. The same controller on the true plant\n";
pub(super) const FOURTH: &str = "4. What the published model gets wrong\n";
pub(super) const FIFTH: &str = "5. What the extended model changes in what the inputs reach\n";
pub(super) const SIXTH: &str = "6. Control of the true plant with the extended model\n";

impl MoveOnEquations {
    /// Time to the target and final errors: what, together, in two steps.
    pub(super) fn errors(&self) -> [[String; 3]; 5] {
        let seconds = |t: Option<f64>| t.map_or("not reached".to_owned(), |t| format!("{t:.2} s"));
        let value = |v: Option<f64>, unit: &str| v.map_or("–".to_owned(), |v| format!("{v:+.2}{unit}"));
        let (a, [x, y, phi]) = (&self.arrival, self.two_step_errors());
        let mm = |v: Option<f64>| value(v.map(|v| 1e3 * v), " mm");
        let spin = |v: f64| value(Some(v), " °/s");
        [
            ["time to target".to_owned(), seconds(a.settled_s), seconds(self.two_step_time())],
            ["error in x".to_owned(), mm(Some(a.x_m)), mm(x)],
            ["error in y".to_owned(), mm(Some(a.y_m)), mm(y)],
            ["error in yaw".to_owned(), value(Some(a.phi_deg), "°"), value(phi, "°")],
            ["remaining spin".to_owned(), spin(a.spin_deg_s), spin(self.two.remaining_spin.to_degrees())],
        ]
    }
}

/// Header of a table of both methods.
pub(super) const METHODS: [&str; 3] = ["", "together (MPC)", "two steps"];

impl fmt::Display for MoveOnEquations {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let a = &self.arrival;
        let report = &self.together.run.report;
        if let Some(p) = &report.plan {
            writeln!(f, "plan: {} after {} quadratic programs in {:.2} s\n", p.status, p.programs, p.seconds)?;
        }
        writeln!(f, "{}", duration(self.shortest_s(), self.problem.ocp.steps as f64 * self.problem.ocp.dt))?;
        writeln!(f, "Final errors on the same plant with exact set-valued friction:\n")?;
        for r in std::iter::once(METHODS.map(str::to_owned)).chain(self.errors()) {
            writeln!(f, "  {:<16} {:>16} {:>16}", r[0], r[1], r[2])?;
        }
        writeln!(f)?;
        for s in &self.two.stages {
            let verdict = if s.met { "met" } else { "not met" };
            writeln!(
                f,
                "  two steps: experiment {} from {:.2} s to {:.2} s, target of this stage {verdict}",
                s.name, s.from, s.to
            )?;
        }
        if self.two.remaining_spin.abs() > 2f64.to_radians() {
            writeln!(
                f,
                "  The published model has no yaw friction: once turned, the object continues to spin while it is moved,\n  \
                 so the two-step time counts stages that met their targets, not a yaw that stays there."
            )?;
        }
        writeln!(
            f,
            "  The published inputs ignore the bounds on stroke, tilt, and accelerations, and the plate is assumed to stop\n  \
             and level instantaneously between stages."
        )?;
        let [linearize, qp, rest] = self.step_split();
        let (t, c) = (&report.solve_ms, &report.status);
        writeln!(f, "\n  bounds between samples: {}", bounds_kept(1e3 * a.stroke_excess_m, a.tilt_excess_deg))?;
        writeln!(
            f,
            "  control step: median {:.2} ms, 99 % below {:.2} ms, sampling period {:.0} ms; {:.1} × real time\n  \
             of which, medians: linearize {linearize:.2} ms, quadratic program {qp:.2} ms, rest {rest:.2} ms",
            t.median,
            t.p99,
            report.period_ms,
            self.real_time_factor()
        )?;
        writeln!(
            f,
            "  samples: {} solved, {} inaccurate, {} infeasible, {} fallback, {} at rest after the plan",
            c.solved, c.inaccurate, c.infeasible, c.fallback, c.played_out
        )
    }
}

impl MoveOnPlant {
    /// Final errors: what, closed loop, open loop.
    pub(super) fn errors(&self) -> [[String; 3]; 4] {
        let (a, p) = (&self.arrival, &self.plan_arrival);
        let row = |what: &str, closed: f64, alone: f64, unit: &str| {
            [what.to_owned(), format!("{closed:+.2}{unit}"), format!("{alone:+.2}{unit}")]
        };
        [
            row("error in x", 1e3 * a.x_m, 1e3 * p.x_m, " mm"),
            row("error in y", 1e3 * a.y_m, 1e3 * p.y_m, " mm"),
            row("error in yaw", a.phi_deg, p.phi_deg, "°"),
            row("remaining spin", a.spin_deg_s, p.spin_deg_s, " °/s"),
        ]
    }

    /// Whether the target is reached, and from when on.
    pub(super) fn outcome(&self) -> String {
        match self.arrival.settled_s.filter(|_| self.reached()) {
            Some(t) => format!("Reached: within ± 2 mm and ± 2° of the target from {t:.2} s on."),
            None => "Not reached: the object does not come to rest within ± 2 mm and ± 2° of its target.".to_owned(),
        }
    }
}

/// Header of a table of both loops.
pub(super) const LOOPS: [&str; 3] = ["", "closed loop", "open loop"];

impl fmt::Display for MoveOnPlant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "Final errors with predictions by the {}, on the plant with contact over the whole footprint:\n",
            self.model
        )?;
        for r in std::iter::once(LOOPS.map(str::to_owned)).chain(self.errors()) {
            writeln!(f, "  {:<16} {:>16} {:>16}", r[0], r[1], r[2])?;
        }
        let c = &self.run.report.status;
        let plan = self.run.report.plan.as_ref();
        if let Some(plan) = plan {
            writeln!(
                f,
                "\n  plan: {} after {} quadratic programs in {:.2} s",
                plan.status, plan.programs, plan.seconds
            )?;
        }
        writeln!(
            f,
            "  samples: {} solved, {} inaccurate, {} infeasible, {} fallback, {} at rest after the plan",
            c.solved, c.inaccurate, c.infeasible, c.fallback, c.played_out
        )?;
        writeln!(f, "  {}", duration(self.shortest_s, self.duration_s))?;
        writeln!(
            f,
            "  The controller receives the pose from a camera with noise of {:.1} mm and {:.1}°, one sample late. A moving-horizon\n  \
             estimator finds the rates.",
            1e3 * self.problem.conditions.noise[0],
            self.problem.conditions.noise[2].to_degrees()
        )?;
        for (what, stopped) in [("closed loop", &self.stopped), ("open loop", &self.plan_stopped)] {
            if let Some(reason) = stopped.as_ref().map(ended) {
                writeln!(f, "  The {what} ends early: {reason}. Its errors are those at that time.")?;
            }
        }
        writeln!(f, "  {}", self.outcome())
    }
}

/// How long a move takes, in words.
fn duration(shortest: Option<f64>, duration: f64) -> String {
    match shortest {
        Some(shortest) => format!(
            "The shortest plan that arrives takes {shortest:.2} s. The move takes {duration:.2} s, which leaves a reserve for feedback."
        ),
        None => format!("No shorter plan arrives. The move takes {duration:.2} s."),
    }
}

/// Names as a list in a sentence, in alphabetical order.
fn all_of(names: &[&str]) -> String {
    let mut names = names.to_vec();
    names.sort_unstable();
    match names.split_last() {
        Some((last, [])) => (*last).to_owned(),
        Some((last, [first])) => format!("{first} and {last}"),
        Some((last, rest)) => format!("{}, and {last}", rest.join(", ")),
        None => String::new(),
    }
}

/// Whether stroke and tilt stay within their bounds between samples, to the digits that are printed.
fn bounds_kept(stroke_mm: f64, tilt_deg: f64) -> String {
    if stroke_mm < 5e-4 && tilt_deg < 5e-5 {
        "all kept".to_owned()
    } else {
        format!("largest violation: stroke {stroke_mm:.3} mm, tilt {tilt_deg:.4}°")
    }
}

/// How contact ended, in words.
fn ended(outcome: &AreaOutcome) -> String {
    match outcome {
        AreaOutcome::Tipping { t, .. } => format!("at {t:.2} s the object starts to tip over its rim"),
        other => other.to_string(),
    }
}

/// What was recorded.
pub(super) fn of_logs(logs: &[SyntheticLog]) -> String {
    let mut out =
        "Logs of the true plant (the noisy pose of the object and the commanded motion of the plate):\n".to_owned();
    for SyntheticLog { log, outcome } in logs {
        let end = log.t.last().copied().unwrap_or(0.0);
        let _ = writeln!(out, "  {:<20} {end:.2} s, {} samples, {}", log.name, log.t.len(), ended(outcome));
    }
    out
}

/// What the extended model reaches.
pub(super) fn of_ranks(ranks: Option<&RankChange>, extended: bool) -> String {
    match ranks {
        Some(ranks) => {
            let (before, after) = (&ranks.before, &ranks.after);
            format!(
                "{}\nAs long as no friction direction changes, the inputs of the published model reach a set of dimension {} of {}\n\
                 at each time, and those of the extended model reach one of dimension {} of {}.\n",
                rank_change_text(ranks),
                before.least_in_a_mode,
                before.states,
                after.least_in_a_mode,
                after.states
            )
        }
        None if extended => "One of the two models cannot be analyzed.\n".to_owned(),
        None => "Nothing was found, so there is no extended model.\n".to_owned(),
    }
}

impl Story {
    /// How many times smaller the multi-step error on held-out data is with the extended than with the published model as it
    /// stands, by horizon (s).
    pub fn gain(&self) -> Vec<(f64, f64)> {
        let Some(gain) = &self.diagnosis.report.gain else { return Vec::new() };
        let pairs = gain.as_given.iter().zip(&gain.after);
        gain.horizons_s.iter().copied().zip(pairs.map(|(before, after)| before / after)).collect()
    }

    /// Whether the story ends as it should: the published model fails on the true plant, the extended one reaches the target.
    pub fn succeeded(&self) -> bool {
        self.on_equations.arrival.settled_s.is_some()
            && !self.as_published.reached()
            && self.extended.as_ref().is_some_and(MoveOnPlant::reached)
    }

    /// The outcome as a title.
    pub(super) fn title(&self) -> &'static str {
        match (self.as_published.reached(), &self.extended) {
            (false, Some(moved)) if moved.reached() => {
                "The vibrating plate: from published equations that do not match the plant to a controller that reaches \
                 its target"
            }
            (true, _) => "The vibrating plate: the published equations reach the target on the plant too",
            (false, Some(_)) => {
                "The vibrating plate: neither the published nor the extended equations reach the target"
            }
            (false, None) => {
                "The vibrating plate: the published equations do not match the plant, and the diagnosis names no cause"
            }
        }
    }

    /// The outcome in two sentences.
    pub(super) fn verdict(&self) -> String {
        let first = if self.as_published.reached() {
            "The controller based on the published model reaches its target on the true plant too."
        } else {
            "The controller based on the published model reaches its target on the model's own equations but misses it on the \
             true plant."
        };
        let (unnamed, named): (Vec<&NamedCause>, Vec<_>) =
            self.diagnosis.report.causes.iter().partition(|c| c.name == Cause::UnknownTerm);
        // One mention of a cause, with all its equations.
        let mut equations: Vec<(String, Vec<&str>)> = Vec::new();
        for c in named {
            let name = c.name.to_string();
            match equations.iter_mut().find(|(other, _)| *other == name) {
                Some((_, of)) if of.contains(&c.equation.as_str()) => {}
                Some((_, of)) => of.push(&c.equation),
                None => equations.push((name, vec![&c.equation])),
            }
        }
        let causes: Vec<String> = equations.iter().map(|(name, of)| format!("{name} in {}", all_of(of))).collect();
        let of: Vec<&str> = unnamed.iter().map(|c| c.equation.as_str()).collect();
        let unnamed = (!of.is_empty()).then(|| format!("an unnamed term in {}", of.join(", ")));
        let found = match (causes.is_empty(), unnamed) {
            (true, unnamed) => format!("adds {}", unnamed.unwrap_or_else(|| "nothing".to_owned())),
            (false, None) => format!("names these causes: {}", causes.join("; ")),
            (false, Some(unnamed)) => format!("names these causes: {}; it also adds {unnamed}", causes.join("; ")),
        };
        let second = match &self.extended {
            None => "The diagnosis of the logs names no cause.".to_owned(),
            Some(moved) => {
                let reached = if moved.reached() {
                    "reaches its target on the true plant"
                } else {
                    "misses its target there as well"
                };
                format!("The diagnosis {found}. With the model extended by these terms, the controller {reached}.")
            }
        };
        format!("{first} {second}")
    }

    /// What comes of it.
    pub(super) fn ending(&self) -> String {
        let mut out = String::new();
        if let Some(moved) = &self.extended {
            let _ = writeln!(out, "{moved}");
        }
        let _ = writeln!(out, "{}\n", self.verdict());
        out += "On the true plant:\n\n";
        let _ = writeln!(out, "  {:<34} {:>16} {:>16}", "", "published model", "extended model");
        for [what, published, extended] in self.comparison() {
            let _ = writeln!(out, "  {what:<34} {published:>16} {extended:>16}");
        }
        out
    }

    /// Rows of the last table: what, published model, extended model.
    pub(super) fn comparison(&self) -> Vec<[String; 3]> {
        let mut rows = Vec::new();
        if let Some(gain) = &self.diagnosis.report.gain {
            for (k, horizon) in gain.horizons_s.iter().enumerate() {
                let percent = |v: f64| format!("{:.1} %", 100.0 * v);
                let what = format!("prediction error {horizon} s ahead");
                rows.push([what, percent(gain.as_given[k]), percent(gain.after[k])]);
            }
        }
        let of = |value: &dyn Fn(&MoveOnPlant) -> String| {
            [value(&self.as_published), self.extended.as_ref().map_or("–".to_owned(), value)]
        };
        let mut push =
            |what: &str, [published, extended]: [String; 2]| rows.push([what.to_owned(), published, extended]);
        push("closed loop: error in x", of(&|m| format!("{:+.2} mm", 1e3 * m.arrival.x_m)));
        push("closed loop: error in y", of(&|m| format!("{:+.2} mm", 1e3 * m.arrival.y_m)));
        push("closed loop: error in yaw", of(&|m| format!("{:+.2}°", m.arrival.phi_deg)));
        push("open loop: error in x", of(&|m| format!("{:+.2} mm", 1e3 * m.plan_arrival.x_m)));
        push("open loop: error in y", of(&|m| format!("{:+.2} mm", 1e3 * m.plan_arrival.y_m)));
        push("open loop: error in yaw", of(&|m| format!("{:+.2}°", m.plan_arrival.phi_deg)));
        push(
            "within ± 2 mm, ± 2° from",
            of(&|m| match m.arrival.settled_s {
                Some(t) if m.reached() => format!("{t:.2} s"),
                _ if m.stopped.is_some() => "contact ends".to_owned(),
                _ => "not reached".to_owned(),
            }),
        );
        rows
    }
}
