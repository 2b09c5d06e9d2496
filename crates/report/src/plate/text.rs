//! A run on the plate in words.

use std::fmt::Write as _;

use bracketry_plate::area::AreaOutcome;
use bracketry_plate::experiment::AmplitudeStep;
use bracketry_plate::object::Bearing;
use bracketry_plate::run::{Assumption, PlateModel, PlateOutcome, PlateRun, PlateSetup, PlateStop};
use bracketry_plate::{Friction, PlateExperiment, Shape};
use bracketry_system::counted;

use super::comparison::write_comparison;

const DEGREES: f64 = 180.0 / std::f64::consts::PI;

/// The report of a run for a reader.
pub fn text(ran: &PlateExperiment) -> String {
    let mut out = format!("{}\n", headline(ran));
    let assumed = ran.assumptions().into_iter().map(|said| ("assumed", assumption(said).to_owned()));
    for (what, said) in setup(ran).into_iter().chain(assumed).chain(result(ran)) {
        let _ = writeln!(out, "  {what:<11} {said}");
    }
    out + &compared(ran)
}

/// What was run.
pub(super) fn headline(ran: &PlateExperiment) -> String {
    let motion = if ran.driven_by_log { "log" } else { "formula" };
    let (name, model) = (&ran.setup.experiment.name, ran.setup.model.name());
    format!("Experiment {name}, model {model}, plate driven by the {motion}")
}

/// The paragraph on a log; empty without one.
pub(super) fn compared(ran: &PlateExperiment) -> String {
    let mut out = String::new();
    // Writing into a string cannot fail.
    let _ = ran.comparison.as_ref().map_or(Ok(()), |c| write_comparison(&mut out, c));
    out
}

/// What was simulated: what, and its value.
pub(super) fn setup(ran: &PlateExperiment) -> Vec<(&'static str, String)> {
    let setup = &ran.setup;
    let object = &setup.object;
    let body = format!("{}; {} m thick, {} kg", shape(&object.shape), 2.0 * object.height, object.mass);
    let mut facts = vec![("object", body)];
    if object.bearing != Bearing::Footprint || object.center_of_mass != [0.0; 2] {
        let [x, y] = object.center_of_mass.map(round);
        facts.push(("bearing", format!("{}; center of mass at {x}, {y} m", bearing(&object.bearing))));
    }
    facts.push(("friction", friction(&setup.friction)));
    let [x, y, phi] = setup.start;
    facts.push(("start", format!("x {} m, y {} m, φ {:.2}°", round(x), round(y), phi * DEGREES)));
    facts.push(("numerics", numerics(setup)));
    if setup.model == PlateModel::Published {
        let said = "the torque of this model has the wrong sign, and nothing brakes the spin: see `bracketry publication 3.16`";
        facts.push(("note", said.to_owned()));
    }
    facts
}

fn numerics(setup: &PlateSetup) -> String {
    match setup.model {
        PlateModel::Area => format!("{} points, steps of {} s", setup.points, setup.dt),
        PlateModel::Body => format!("steps of {} s, restitution {}", setup.dt, setup.restitution),
        PlateModel::Published | PlateModel::Point | PlateModel::Reduced => "events located, adaptive steps".to_owned(),
    }
}

/// What came of it: what, and its value.
pub(super) fn result(ran: &PlateExperiment) -> Vec<(&'static str, String)> {
    let (setup, run) = (&ran.setup, &ran.run);
    let mut facts = vec![("target", target(ran))];
    if let Some(stop) = &run.stopped {
        facts.push(("outcome", stopped(stop)));
    }
    if ran.outcome() == PlateOutcome::NotFlat {
        let said = "the object does not lie flat at the end: it tips, has overturned, or is in flight";
        facts.push(("outcome", said.to_owned()));
    }
    let last = &run.rows[run.rows.len() - 1];
    let units = [1e3, 1e3, DEGREES];
    let [x, y, phi]: [f64; 3] = std::array::from_fn(|k| without_sign(last.state[k] * units[k]));
    facts.push(("final", format!("x {x:.2} mm, y {y:.2} mm, φ {phi:.2}° at t = {:.3} s", last.t)));
    let [x, y, phi]: [f64; 3] = std::array::from_fn(|k| without_sign((last.state[k] - setup.start[k]) * units[k]));
    facts.push(("moved", format!("x {x:+.2} mm, y {y:+.2} mm, φ {phi:+.2}°")));
    facts.extend(contact(run));
    facts
}

/// Whether the target is reached, and when.
pub(super) fn target(ran: &PlateExperiment) -> String {
    let setup = &ran.setup;
    let (unit, scale) = if setup.coordinate() == 2 { ("°", DEGREES) } else { (" mm", 1e3) };
    let goal = format!("{} = {:.1}{unit}", setup.experiment.coordinate.name(), setup.experiment.target * scale);
    match ran.run.reached {
        Some(t) => format!("{goal} reached after {t:.3} s"),
        None => format!("{goal} not reached"),
    }
}

fn contact(run: &PlateRun) -> Vec<(&'static str, String)> {
    let events = run.events.map_or(String::new(), |n| format!("{}, ", counted(n, "event", "events")));
    let gap = run.largest_gap();
    let gap = if gap > 1e-6 { format!(", gap up to {:.3} mm", 1e3 * gap) } else { String::new() };
    let sticking = 100.0 * run.stick_share();
    let force = run.least_normal_force();
    let said = format!("{events}{sticking:.0} % sticking on average, normal force at least {force:.3} N{gap}");
    let mut facts = vec![("contact", said)];
    if !run.jumps.is_empty() {
        let times = counted(run.jumps.len(), "time", "times");
        facts.push(("plate", format!("jumped {times} under the object")));
    }
    if let Some(closure) = run.energy_closure {
        let said = format!("balance of the discrete equations closes to {closure:.1e} of the energy exchanged");
        facts.push(("energy", said));
    }
    let simulated = run.rows[run.rows.len() - 1].t - run.rows[0].t;
    let factor = two_digits(simulated / run.wall_seconds.max(1e-9));
    facts.push(("speed", format!("{:.3} s, {factor} times real time", run.wall_seconds)));
    facts
}

/// What is assumed, in a sentence.
pub(super) fn assumption(assumption: Assumption) -> &'static str {
    match assumption {
        Assumption::LoggedMotion => {
            "the plate moves as in the log, smoothed according to its noise; where it jumps, the object keeps its \
             place in the inertial frame"
        }
        Assumption::TimeConstant => "tau = 1 s; the inputs start with the run",
        Assumption::HeldAmplitude => {
            "the amplitude follows e = q - q_desired, read at the start of each period and held over it"
        }
        Assumption::AmplitudeStep(AmplitudeStep::WorldFixed) => {
            "where the amplitude changes, the plate jumps and the object keeps its place in the inertial frame: the \
             jump is subtracted from x' and x"
        }
        Assumption::AmplitudeStep(AmplitudeStep::Smooth) => {
            "where the amplitude changes, the plate continues without the jump"
        }
        Assumption::StartAtRest => "the object starts at rest on the plate",
        Assumption::TimeToTarget => "time to target: first time at 98 % of the distance",
    }
}

/// Why a run ended early, in a sentence.
pub(super) fn stopped(stop: &PlateStop) -> String {
    match stop {
        PlateStop::NoLoad { t } => format!(
            "lift-off by t = {t:.3} s: the normal force became negative, which this model does not cover; use \
             --model body"
        ),
        PlateStop::Departed(outcome) => format!("the object {}; --model body continues from there", departed(outcome)),
        PlateStop::Overturned { t } => {
            format!("the object has overturned and lies on its upper face at t = {t:.6} s")
        }
        PlateStop::StepLimit { t } => format!("too many steps of the free body at t = {t:.6} s"),
        PlateStop::NotFinite { t } => format!("numbers out of range at t = {t:.6} s"),
        PlateStop::Rocking { t } => format!("the object rocks too fast to be simulated at t = {t:.6} s"),
        PlateStop::Integration { t, reason } => format!("stopped at t = {t:.6} s: {reason}"),
        PlateStop::Canceled { t } => format!("canceled at t = {t:.3} s"),
    }
}

fn departed(outcome: &AreaOutcome) -> String {
    match outcome {
        AreaOutcome::LiftOff { t } => format!("lifts off at t = {t:.6} s: the contact force would have to pull"),
        AreaOutcome::Tipping { t, .. } => format!("tips at t = {t:.6} s: the center of pressure reaches the rim"),
        AreaOutcome::Finished | AreaOutcome::NotFinite { .. } => outcome.to_string(),
    }
}

fn bearing(bearing: &Bearing) -> String {
    match bearing {
        Bearing::Footprint => "the whole footprint".to_owned(),
        Bearing::Scaled(scale) => format!("the footprint scaled by {scale}"),
        Bearing::Ring(scale) => format!("a ring, the rim scaled by {scale}"),
        Bearing::Feet(points) => counted(points.len(), "foot", "feet"),
        Bearing::Map(points) => format!("a map of {}", counted(points.len(), "point", "points")),
    }
}

fn shape(shape: &Shape) -> String {
    match shape {
        Shape::Disk { radius } => format!("disk, radius {} m", round(*radius)),
        Shape::Ellipse { a, b } => format!("ellipse, semi-axes {a:?} m and {b:?} m"),
        Shape::Rectangle { a, b } => format!("rectangle, sides {:?} m and {:?} m", 2.0 * a, 2.0 * b),
        Shape::Polygon { vertices } => format!("polygon, {} vertices, area {} m²", vertices.len(), round(shape.area())),
    }
}

fn friction(law: &Friction) -> String {
    let (name, numbers): (&str, Vec<(&str, f64)>) = match *law {
        Friction::Coulomb { mu } => ("coulomb", vec![("mu", mu)]),
        Friction::StaticLevel { mu, mu_static } => ("static", vec![("mu", mu), ("mu_static", mu_static)]),
        Friction::Stribeck { mu, mu_static, velocity } => {
            ("stribeck", vec![("mu", mu), ("mu_static", mu_static), ("velocity", velocity)])
        }
        Friction::Anisotropic { mu_along, mu_across } => {
            ("anisotropic", vec![("mu_along", mu_along), ("mu_across", mu_across)])
        }
        Friction::Viscous { mu, coefficient } => ("viscous", vec![("mu", mu), ("coefficient", coefficient)]),
    };
    numbers.into_iter().fold(name.to_owned(), |text, (name, value)| format!("{text}, {name} {}", round(value)))
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
