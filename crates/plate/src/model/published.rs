//! The published model of the plate.

use super::parameters::set_positive;
use crate::{PlateError, Shape};
use bracketry_system::System;

const ELLIPSE: &str = include_str!("../../models/plate_published.toml");
const DISK: &str = include_str!("../../models/plate_published_disk.toml");

/// The published model for a shape and a friction coefficient:
///
/// ```text
/// x'' = −X'' − sgn(x') μ g
/// y'' = −g sin θ − sgn(y') μ (g cos θ + y θ'')
/// I φ'' = −sgn(x') μ Syy(φ) θ''
/// ```
///
/// with states `x, y, phi, vx, vy, w` and inputs `X, theta` (`models/plate_published.toml`).
///
/// The model knows of a shape only its second moments: a rectangle or polygon is given as the ellipse with the same ones.
///
/// # Errors
/// [`PlateError::BadNumber`] if a length or the coefficient is not a positive finite number, [`PlateError::TurnedAxes`] for a
/// polygon whose principal axes are not its own.
///
/// ```
/// use bracketry_plate::{published, Shape};
/// let system = published(&Shape::REFERENCE_ELLIPSE, 0.3).unwrap();
/// assert_eq!(system.state_names(), ["x", "y", "phi", "vx", "vy", "w"]);
/// ```
pub fn published(shape: &Shape, mu: f64) -> Result<System, PlateError> {
    let ellipse = |a, b| ("plate_published.toml", ELLIPSE, vec![("a", a), ("b", b)]);
    shape.validate()?;
    let (file, text, lengths) = match *shape {
        Shape::Ellipse { a, b } => ellipse(a, b),
        Shape::Rectangle { .. } | Shape::Polygon { .. } => {
            let angle = shape.principal_angle();
            if angle != 0.0 {
                return Err(PlateError::TurnedAxes { angle });
            }
            let (sa, sb) = shape.second_moments();
            ellipse(2.0 * sa.sqrt(), 2.0 * sb.sqrt())
        }
        Shape::Disk { radius } => ("plate_published_disk.toml", DISK, vec![("r", radius)]),
    };
    let mut system = System::parse(file, text)?;
    for (name, value) in lengths.into_iter().chain([("mu", mu)]) {
        set_positive(&mut system, name, value)?;
    }
    Ok(system)
}
