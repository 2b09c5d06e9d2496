//! Where an object presses and where its mass is, as options.

use std::path::Path;

use super::option_text::{Problem, number, numbers, problem};
use super::point_table::rows;
use crate::area::Footprint;
use crate::object::Bearing;
use crate::{Object, Shape};

/// Points that exceed the outline by less than this share of the way are on it.
const ROUNDING: f64 = 1e-9;

/// `footprint`, `scaled:F`, `ring:S`, `feet:x,y;x,y;…` or `map:FILE.csv`.
pub(super) fn bearing(text: &str) -> Result<Bearing, Problem> {
    let unknown = || {
        problem(
            format!("`{text}` is not a bearing"),
            "give footprint, scaled:0.5 (the inner half), ring:1 (the rim), feet:x,y;x,y;…, or map:FILE.csv, in meters",
        )
    };
    let (kind, rest) = text.split_once(':').unwrap_or((text, ""));
    let scale = || -> Result<f64, Problem> {
        let scale = number(rest)?;
        let remedy = "give a number greater than zero, 1 for the outline itself";
        if scale > 0.0 { Ok(scale) } else { Err(problem(format!("the scale {scale} is not positive"), remedy)) }
    };
    match kind.trim() {
        "footprint" if rest.is_empty() => Ok(Bearing::Footprint),
        "scaled" => Ok(Bearing::Scaled(scale()?)),
        "ring" => Ok(Bearing::Ring(scale()?)),
        "feet" => Ok(Bearing::Feet(rest.split(';').map(point).collect::<Result<_, _>>()?)),
        "map" => map(Path::new(rest)),
        _ => Err(unknown()),
    }
}

/// `x,y`.
pub(super) fn center_of_mass(text: &str) -> Result<[f64; 2], Problem> {
    point(text)
}

fn point(text: &str) -> Result<[f64; 2], Problem> {
    match numbers(text)?.as_slice() {
        &[x, y] => Ok([x, y]),
        other => Err(problem(
            format!("`{text}` has {} numbers, not 2", other.len()),
            "give a point as x,y in meters from the center of the shape",
        )),
    }
}

/// A map of pressure from a table with columns x, y and weight, or three columns without names.
fn map(path: &Path) -> Result<Bearing, Problem> {
    let remedy =
        "give a table with a row x,y,weight for each point, in meters from the center of the shape, weights above zero";
    let points = rows(path, ["x", "y", "weight"], remedy)?;
    if let Some([x, y, weight]) = points.iter().find(|p| p[2] <= 0.0) {
        let message = format!("{}: the weight {weight} at {x},{y} is not positive", path.display());
        return Err(problem(message, remedy));
    }
    Ok(Bearing::Map(points))
}

/// Checks that the bearing of an object lies within its outline and can carry it, for an area model with `points` points.
pub(super) fn check_bearing(object: &Object, points: usize) -> Result<(), Problem> {
    let listed: Vec<[f64; 2]> = match &object.bearing {
        Bearing::Footprint | Bearing::Scaled(_) | Bearing::Ring(_) => Vec::new(),
        Bearing::Feet(points) => points.clone(),
        Bearing::Map(points) => points.iter().map(|[x, y, _]| [*x, *y]).collect(),
    };
    listed.iter().try_for_each(|p| within(&object.shape, *p, "the point"))?;
    Footprint::new(object, points).map(drop).map_err(|e| {
        problem(
            format!("the bearing cannot carry the object: {e}"),
            "give at least three points that do not lie on one line, each once",
        )
    })
}

/// Checks that the center of mass lies within the outline of an object.
pub(super) fn check_center_of_mass(object: &Object) -> Result<(), Problem> {
    within(&object.shape, object.center_of_mass, "the center of mass")
}

fn within(shape: &Shape, point: [f64; 2], what: &str) -> Result<(), Problem> {
    if shape.rim_share(point) <= 1.0 + ROUNDING {
        return Ok(());
    }
    let [x, y] = point;
    Err(problem(
        format!("{what} {x},{y} lies beyond the outline of the object"),
        "give meters from the center of the shape, within the outline of --shape",
    ))
}
