//! What a run on the plate is told about.

use std::fmt;

use bracketry_plate::{Friction, Shape};
use bracketry_system::counted;
use serde::Serialize;
use serde_json::{Value, json};

use super::{Comparison, PlateExperiment};

const DEGREES: f64 = 180.0 / std::f64::consts::PI;

/// All there is to say of an experiment: the JSON object of `bracketry plate --json`, and the report for a reader.
#[derive(Clone, Debug, Serialize)]
pub struct PlateReport {
    experiment: String,
    model: &'static str,
    motion: &'static str,
    shape: Value,
    thickness: f64,
    mass: f64,
    friction: Value,
    start: State,
    seconds: f64,
    points: usize,
    dt: f64,
    restitution: f64,
    sample: f64,
    assumptions: Vec<String>,
    coordinate: &'static str,
    target: f64,
    /// Seconds after the start; absent if not reached.
    reached: Option<f64>,
    /// Why the run ended early.
    stopped: Option<String>,
    /// `reached`, `not reached`, `stopped`, or `not flat` where the body has left the plate with its lower face.
    pub outcome: &'static str,
    t_final: f64,
    #[serde(rename = "final")]
    last: State,
    velocity_final: [f64; 3],
    /// Final less first position of the coordinates that should stay, and the yaw where it is not to be turned.
    drift: State,
    events: Option<usize>,
    plate_jumps: usize,
    stick_share: f64,
    least_normal_force: f64,
    largest_gap: f64,
    energy_closure: Option<f64>,
    wall_seconds: f64,
    times_real_time: f64,
    comparison: Option<Comparison>,
}

/// Metres and radians.
#[derive(Clone, Debug, Serialize)]
struct State {
    x: f64,
    y: f64,
    phi: f64,
}

impl State {
    fn new([x, y, phi]: [f64; 3]) -> Self {
        Self { x, y, phi }
    }
}

impl PlateReport {
    /// What there is to say of an experiment.
    pub fn new(ran: &PlateExperiment) -> Self {
        let (setup, run) = (&ran.setup, &ran.run);
        let rows = &run.rows;
        let (first, last) = (&rows[0], &rows[rows.len() - 1]);
        let pose = [last.state[0], last.state[1], last.state[2]];
        let simulated = last.t - first.t;
        Self {
            experiment: setup.experiment.name.clone(),
            model: setup.model.name(),
            motion: if ran.driven_by_log { "log" } else { "formula" },
            shape: shape(&setup.object.shape),
            thickness: 2.0 * setup.object.height,
            mass: setup.object.mass,
            friction: friction(&setup.friction),
            start: State::new(setup.start),
            seconds: setup.seconds,
            points: setup.points,
            dt: setup.dt,
            restitution: setup.restitution,
            sample: setup.sample,
            assumptions: run.assumptions.clone(),
            coordinate: setup.experiment.coordinate,
            target: setup.experiment.target,
            reached: run.reached,
            stopped: run.stopped.clone(),
            outcome: match (&run.stopped, run.flat, run.reached) {
                (Some(_), _, _) => "stopped",
                (None, false, _) => "not flat",
                (None, true, Some(_)) => "reached",
                (None, true, None) => "not reached",
            },
            t_final: last.t,
            last: State::new(pose),
            velocity_final: [last.state[3], last.state[4], last.state[5]],
            drift: State::new([0, 1, 2].map(|k| pose[k] - setup.start[k])),
            events: run.events,
            plate_jumps: run.jumps.len(),
            stick_share: mean_of_known(rows.iter().map(|r| r.stick_fraction)),
            least_normal_force: rows.iter().map(|r| r.normal_force).fold(f64::INFINITY, f64::min),
            largest_gap: rows.iter().map(|r| r.gap).fold(0.0, f64::max),
            energy_closure: run.energy_closure,
            wall_seconds: run.wall_seconds,
            times_real_time: simulated / run.wall_seconds.max(1e-9),
            comparison: ran.comparison.clone(),
        }
    }
}

/// Mean of the values that are numbers.
fn mean_of_known(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.filter(|v| !v.is_nan()).fold((0.0, 0usize), |(sum, n), v| (sum + v, n + 1));
    sum / count.max(1) as f64
}

fn shape(shape: &Shape) -> Value {
    match shape {
        Shape::Disk { radius } => json!({"kind": "disk", "radius": radius}),
        Shape::Ellipse { a, b } => json!({"kind": "ellipse", "semi_axes": [a, b]}),
        Shape::Rectangle { a, b } => json!({"kind": "rectangle", "sides": [2.0 * a, 2.0 * b]}),
        Shape::Polygon { .. } => {
            let area = shape.area();
            json!({"kind": "polygon", "vertices": shape.rim(0), "area": area})
        }
    }
}

fn friction(law: &Friction) -> Value {
    match law {
        Friction::Coulomb { mu } => json!({"law": "coulomb", "mu": mu}),
        Friction::StaticLevel { mu, mu_static } => json!({"law": "static", "mu": mu, "mu_static": mu_static}),
        Friction::Stribeck { mu, mu_static, velocity } => {
            json!({"law": "stribeck", "mu": mu, "mu_static": mu_static, "velocity": velocity})
        }
        Friction::Anisotropic { mu_along, mu_across } => {
            json!({"law": "anisotropic", "mu_along": mu_along, "mu_across": mu_across})
        }
        Friction::Viscous { mu, coefficient } => json!({"law": "viscous", "mu": mu, "coefficient": coefficient}),
    }
}

/// The entries of a JSON object in a row.
fn in_words(value: &Value) -> String {
    let Value::Object(entries) = value else { return value.to_string() };
    let mut words = Vec::new();
    for (key, value) in entries {
        match value {
            Value::String(text) => words.push(text.clone()),
            Value::Array(list) if list.len() > 2 => words.push(format!("{} {key}", list.len())),
            Value::Number(n) => words.push(format!("{key} {}", round(n.as_f64().unwrap_or(f64::NAN)))),
            other => words.push(format!("{key} {other}")),
        }
    }
    words.join(", ")
}

/// Two significant digits, whole numbers from 10 on.
fn two_digits(v: f64) -> String {
    if v >= 9.95 { format!("{v:.0}") } else { format!("{}", format!("{v:.1e}").parse::<f64>().unwrap_or(v)) }
}

/// A number that is printed with two decimals, without the sign that would be left of a small one: −0.00.
fn without_sign(v: f64) -> f64 {
    if v.abs() < 0.005 { 0.0 } else { v }
}

/// At most six significant digits.
fn round(v: f64) -> f64 {
    format!("{v:.5e}").parse().unwrap_or(v)
}

impl fmt::Display for PlateReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "Experiment {}, model {}, plate driven by the {}", self.experiment, self.model, self.motion)?;
        writeln!(f, "  object      {}; {} m thick, {} kg", in_words(&self.shape), self.thickness, self.mass)?;
        writeln!(f, "  friction    {}", in_words(&self.friction))?;
        let s = &self.start;
        writeln!(f, "  start       x {} m, y {} m, φ {:.2}°", round(s.x), round(s.y), s.phi * DEGREES)?;
        match self.model {
            "area" => writeln!(f, "  numerics    {} points, steps of {} s", self.points, self.dt)?,
            "body" => writeln!(f, "  numerics    steps of {} s, restitution {}", self.dt, self.restitution)?,
            _ => writeln!(f, "  numerics    events located, adaptive steps")?,
        }
        for said in &self.assumptions {
            writeln!(f, "  assumed     {said}")?;
        }
        let (unit, scale) = if self.coordinate == "phi" { ("°", DEGREES) } else { (" mm", 1e3) };
        let goal = format!("{} = {:.1}{unit}", self.coordinate, self.target * scale);
        match self.reached {
            Some(t) => writeln!(f, "  target      {goal} reached after {t:.3} s")?,
            None => writeln!(f, "  target      {goal} not reached")?,
        }
        if let Some(stopped) = &self.stopped {
            writeln!(f, "  outcome     {stopped}")?;
        }
        if self.outcome == "not flat" {
            writeln!(f, "  outcome     the object does not lie flat at the end: it tips, has toppled or flies")?;
        }
        let l = &self.last;
        writeln!(
            f,
            "  final       x {:.2} mm, y {:.2} mm, φ {:.2}° at t = {:.3} s",
            without_sign(1e3 * l.x),
            without_sign(1e3 * l.y),
            without_sign(l.phi * DEGREES),
            self.t_final
        )?;
        let d = &self.drift;
        let moved = [1e3 * d.x, 1e3 * d.y, d.phi * DEGREES].map(without_sign);
        writeln!(f, "  moved       x {:+.2} mm, y {:+.2} mm, φ {:+.2}°", moved[0], moved[1], moved[2])?;
        let events = self.events.map_or(String::new(), |n| format!("{}, ", counted(n, "event", "events")));
        writeln!(
            f,
            "  contact     {events}{:.0} % sticking on average, normal force at least {:.3} N{}",
            100.0 * self.stick_share,
            self.least_normal_force,
            if self.largest_gap > 1e-6 {
                format!(", gap up to {:.3} mm", 1e3 * self.largest_gap)
            } else {
                String::new()
            }
        )?;
        if self.plate_jumps > 0 {
            writeln!(f, "  plate       jumped {} under the object", counted(self.plate_jumps, "time", "times"))?;
        }
        if let Some(closure) = self.energy_closure {
            writeln!(
                f,
                "  energy      balance of the stepped equations closes to {closure:.1e} of the energy exchanged"
            )?;
        }
        writeln!(f, "  speed       {:.3} s, {} times real time", self.wall_seconds, two_digits(self.times_real_time))?;
        if let Some(c) = &self.comparison {
            writeln!(f, "  compared    with {} from {} to {} s, {} rows (run − log):", c.log, c.from, c.to, c.rows)?;
            for (name, unit, d) in [("x", "mm", &c.x_mm), ("y", "mm", &c.y_mm), ("φ", "°", &c.phi_deg)] {
                let percent = match (name, c.phi_percent) {
                    ("φ", Some(p)) => format!(" ({p:+.2} % of the turn)"),
                    _ => String::new(),
                };
                writeln!(
                    f,
                    "    {name}  rms {:.3} {unit}, largest {:+.3} {unit}, at the end {:+.3} {unit}{percent}",
                    d.rms, d.largest, d.at_end
                )?;
            }
        }
        Ok(())
    }
}
