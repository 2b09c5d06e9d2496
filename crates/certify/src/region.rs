//! Regions of attraction as sublevel sets of a Lyapunov function.

use bracketry_symbolic::Limit;

use crate::certificate::{Certificate, Conclusion};
use crate::levels::{Levels, first_rise, size};
use crate::linearization::{eigenvalues, lengths, lyapunov_of, quadratic};
use crate::lyapunov::global;
use crate::model::PolynomialModel;
use crate::reason::CertificateReason;
use crate::series::truncated;

/// Largest level that is tried where no point with V' ≥ 0 is found, over that of the unit ball.
const LARGEST: f64 = 1e6;

/// Factors γ of the series, over the reciprocal of the quadratic function's level.
const SERIES: [f64; 4] = [0.0, 0.1, 0.3, 0.7];

/// Most states of a series: the programs of its levels grow fast.
const MAX_STATES: usize = 3;

/// A sublevel set on which V falls: of the quadratic Lyapunov function of the linearization, or of a series of degree `largest`,
/// whichever set is the largest.
///
/// Where no rise of V is found, a function of degree at most `largest` on the whole space is sought first.
pub(crate) fn region(model: &PolynomialModel, largest: u32, limit: &Limit) -> Result<Certificate, CertificateReason> {
    let [_, on_axis, right] = eigenvalues(model);
    if right > 0 {
        return Err(CertificateReason::Unstable { eigenvalues: right });
    }
    if on_axis > 0 {
        return Err(CertificateReason::Critical);
    }
    let p = lyapunov_of(model).ok_or(CertificateReason::TooLarge)?;
    let v = quadratic(&p).ok_or(CertificateReason::NotConfirmed)?;
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
    let first = levels.largest(above).map_err(|why| CertificateReason::of(why, 2))?;
    let mut best = (size(&first), first);
    for factor in SERIES.iter().filter(|_| largest > 2 && model.dimension() <= MAX_STATES) {
        let certificate = truncated(model, &p, factor / above, largest).and_then(|v| {
            let levels = Levels { model, v: &v, limit, powers: powers.clone() };
            levels.largest(first_rise(model, &v)?).ok()
        });
        if let Some(certificate) = certificate {
            let size = size(&certificate);
            if size > best.0 {
                best = (size, certificate);
            }
        }
    }
    Ok(best.1)
}
