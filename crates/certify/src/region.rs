//! Regions of attraction as sublevel sets of a Lyapunov function.

use crate::certificate::{Certificate, Conclusion};
use crate::expand::expanded;
use crate::levels::{Levels, first_rise};
use crate::linearization::{eigenvalues, lengths, lyapunov_of, quadratic};
use crate::lyapunov::global;
use crate::model::PolynomialModel;
use crate::reason::Reason;
use crate::semidefinite::Limit;

/// Largest level that is tried where no point with V' ≥ 0 is found, over that of the unit ball.
const LARGEST: f64 = 1e6;

/// A sublevel set on which V falls: first of the quadratic Lyapunov function of the linearization, then of functions of degree at most
/// `largest` whose sets contain it.
///
/// Where no rise of V is found, a function of degree at most `largest` on the whole space is sought first.
pub(crate) fn region(model: &PolynomialModel, largest: u32, limit: &Limit) -> Result<Certificate, Reason> {
    let [_, on_axis, right] = eigenvalues(model);
    if right > 0 {
        return Err(Reason::Unstable { eigenvalues: right });
    }
    if on_axis > 0 {
        return Err(Reason::Critical);
    }
    let p = lyapunov_of(model).ok_or(Reason::NotConfirmed)?;
    let v = quadratic(&p).ok_or(Reason::NotConfirmed)?;
    let rise = first_rise(model, &v);
    if rise.is_none()
        && let Ok(certificate) = global(model, largest, limit)
        && certificate.verify() == Ok(Conclusion::GloballyAsymptoticallyStable)
    {
        return Ok(certificate);
    }
    let above = rise.unwrap_or(LARGEST);
    let powers = lengths(&p, above);
    let levels = Levels { model, v: &v, limit, powers: powers.clone() };
    let first = levels.largest(above).map_err(|why| Reason::of(why, 2))?;
    Ok(expanded(model, &first, &powers, largest, limit).unwrap_or(first))
}
