//! The values of options: texts and numbers that have a meaning.

use std::path::{Path, PathBuf};

use super::option_text::{Problem, number, numbers, problem};
use super::point_table::rows;
use super::setup::PlateModel;
use crate::experiment::AmplitudeStep;
use crate::{Friction, Shape};

/// Longest time between rows, in seconds: rows give time to target, shares and extremes.
const MAX_SAMPLE: f64 = 0.02;
/// Longest step of area contact, in seconds.
const MAX_STEP: f64 = 0.01;

/// Which of the published experiments.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExperimentKind {
    /// 1, [`Experiment::orientation`](crate::experiment::Experiment::orientation).
    Orientation,
    /// 2, [`Experiment::translation_x`](crate::experiment::Experiment::translation_x).
    TranslationX,
    /// 3, [`Experiment::translation_y`](crate::experiment::Experiment::translation_y).
    TranslationY,
}

/// A law of friction without its coefficient of sliding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FrictionLaw {
    /// Nothing else.
    Coulomb,
    /// A higher level at rest.
    StaticLevel {
        /// Coefficient of sticking.
        mu_static: f64,
    },
    /// A level that falls with speed.
    Stribeck {
        /// Coefficient at rest.
        mu_static: f64,
        /// Stribeck velocity in m/s.
        velocity: f64,
    },
    /// Another coefficient across.
    Anisotropic {
        /// Coefficient of slip along the plate's y axis.
        mu_across: f64,
    },
    /// A part that grows with speed.
    Viscous {
        /// Force per load and speed, in s/m.
        coefficient: f64,
    },
}

impl FrictionLaw {
    /// The law with a coefficient of sliding.
    pub fn sliding_at(self, mu: f64) -> Friction {
        match self {
            Self::Coulomb => Friction::Coulomb { mu },
            Self::StaticLevel { mu_static } => Friction::StaticLevel { mu, mu_static },
            Self::Stribeck { mu_static, velocity } => Friction::Stribeck { mu, mu_static, velocity },
            Self::Anisotropic { mu_across } => Friction::Anisotropic { mu_along: mu, mu_across },
            Self::Viscous { coefficient } => Friction::Viscous { mu, coefficient },
        }
    }
}

pub(super) fn experiment(text: &str) -> Result<ExperimentKind, Problem> {
    match text {
        "1" => Ok(ExperimentKind::Orientation),
        "2" => Ok(ExperimentKind::TranslationX),
        "3" => Ok(ExperimentKind::TranslationY),
        other => Err(problem(
            format!("there is no experiment `{other}`"),
            "name 1 (orientation), 2 (along x), 3 (along y), or a scenario file that exists",
        )),
    }
}

pub(super) fn omega(value: f64) -> Result<u32, Problem> {
    if value.fract() == 0.0 && (1.0..=20.0).contains(&value) {
        return Ok(value as u32);
    }
    Err(problem(format!("omega = {value} is not a whole number from 1 to 20"), "give ω in units of π, such as 3 or 4"))
}

pub(super) fn model(text: &str) -> Result<PlateModel, Problem> {
    PlateModel::ALL.into_iter().find(|model| model.name() == text).ok_or_else(|| {
        let known = PlateModel::ALL.map(PlateModel::name).join(", ");
        problem(format!("there is no model `{text}`"), format!("name one of {known}"))
    })
}

pub(super) fn amplitude_step(text: &str) -> Result<AmplitudeStep, Problem> {
    match text {
        "world" => Ok(AmplitudeStep::WorldFixed),
        "smooth" => Ok(AmplitudeStep::Smooth),
        other => Err(problem(
            format!("`{other}` is not an amplitude step"),
            "give world (the plate jumps, the object keeps its place in the inertial frame) or smooth (no jump)",
        )),
    }
}

pub(super) fn friction(text: &str) -> Result<FrictionLaw, Problem> {
    let (kind, rest) = text.split_once(':').unwrap_or((text, ""));
    match (kind.trim(), numbers(rest)?.as_slice()) {
        ("coulomb", []) => Ok(FrictionLaw::Coulomb),
        ("static", &[mu_static]) => Ok(FrictionLaw::StaticLevel { mu_static }),
        ("stribeck", &[mu_static, velocity]) => Ok(FrictionLaw::Stribeck { mu_static, velocity }),
        ("anisotropic", &[mu_across]) => Ok(FrictionLaw::Anisotropic { mu_across }),
        ("viscous", &[coefficient]) => Ok(FrictionLaw::Viscous { coefficient }),
        _ => Err(problem(
            format!("`{text}` is not a friction law"),
            "give coulomb, static:MU_S, stribeck:MU_S,VELOCITY, anisotropic:MU_ALONG_Y, or viscous:COEFFICIENT",
        )),
    }
}

pub(super) fn start(text: &str) -> Result<[f64; 3], Problem> {
    match numbers(text)?.as_slice() {
        &[x, y, phi] => Ok([x, y, phi]),
        &[x, y] => Ok([x, y, 0.0]),
        other => Err(problem(
            format!("`{text}` has {} numbers", other.len()),
            "give x,y,phi in meters and radians, such as 0.3,0,0 or 0.3,0,45deg",
        )),
    }
}

pub(super) fn shape(text: &str) -> Result<Shape, Problem> {
    let unknown = || {
        problem(
            format!("`{text}` is not a shape"),
            "give disk:RADIUS, ellipse:AxB (semi-axes), rectangle:AxB (full sides), or polygon:FILE.csv, in meters",
        )
    };
    let (kind, rest) = text.split_once(':').ok_or_else(unknown)?;
    let lengths = || -> Result<[f64; 2], Problem> {
        let (a, b) = rest.split_once(['x', '×']).ok_or_else(unknown)?;
        Ok([number(a)?, number(b)?])
    };
    let shape = match kind.trim() {
        "disk" => Shape::Disk { radius: number(rest)? },
        "ellipse" => lengths().map(|[a, b]| Shape::Ellipse { a, b })?,
        "rectangle" => lengths().map(|[a, b]| Shape::Rectangle { a: 0.5 * a, b: 0.5 * b })?,
        "polygon" => polygon(&PathBuf::from(rest))?,
        _ => return Err(unknown()),
    };
    shape.validate().map_err(|e| problem(e.to_string(), "give lengths in meters greater than zero"))?;
    Ok(shape)
}

/// A polygon from a table with columns x and y, or two columns without names, in meters.
fn polygon(path: &Path) -> Result<Shape, Problem> {
    let remedy = "give a table with a row x,y in meters for each vertex, in order around the outline";
    let mut vertices = rows(path, ["x", "y"], remedy)?;
    // An outline that is closed by repeating its first vertex.
    if vertices.len() > 3 && vertices.first() == vertices.last() {
        vertices.pop();
    }
    Shape::polygon(&vertices).map_err(|e| problem(format!("{}: {e}", path.display()), remedy))
}

pub(super) fn restitution(value: f64) -> Result<f64, Problem> {
    let message = || format!("restitution = {value} is outside 0 to 1");
    checked(value, (0.0..=1.0).contains(&value), message, "give 0 (no rebound) to 1")
}

pub(super) fn points(value: f64) -> Result<usize, Problem> {
    let count = value.fract() == 0.0 && (4.0..=100_000.0).contains(&value);
    let message = || format!("points = {value} is not a count from 4 to 100000");
    checked(value, count, message, "48 are usually enough").map(|v| v as usize)
}

pub(super) fn positive(name: &str, value: f64, unit: &str) -> Result<f64, Problem> {
    let message = || format!("{name} = {value} must be positive");
    let remedy = format!("give a number of {unit} greater than zero");
    checked(value, value.is_finite() && value > 0.0, message, &remedy)
}

pub(super) fn not_negative(name: &str, value: f64, unit: &str) -> Result<f64, Problem> {
    let message = || format!("{name} = {value} must not be negative");
    let of_unit = if unit.is_empty() { String::new() } else { format!(" of {unit}") };
    checked(value, value.is_finite() && value >= 0.0, message, &format!("give a number{of_unit}, 0 or greater"))
}

pub(super) fn step(value: f64) -> Result<f64, Problem> {
    at_most("dt", value, MAX_STEP)
}

pub(super) fn sample(value: f64) -> Result<f64, Problem> {
    at_most("sample", value, MAX_SAMPLE)
}

fn at_most(name: &str, value: f64, most: f64) -> Result<f64, Problem> {
    let message = || format!("{name} = {value} is not between 0 and {most} s");
    let remedy = "give a number of seconds, greater than zero and within this limit";
    checked(value, value > 0.0 && value <= most, message, remedy)
}

fn checked(value: f64, holds: bool, message: impl Fn() -> String, remedy: &str) -> Result<f64, Problem> {
    if holds { Ok(value) } else { Err(problem(message(), remedy)) }
}
