//! Where the refitted model is wrong.

use std::collections::BTreeMap;

use bracketry_system::System;

use crate::gain::force_residuals;
use crate::report::Place;
use crate::{DiagnoseError, Fit, Record};

/// A rate below this share of its root mean square counts as near rest.
const NEAR_REST: f64 = 0.1;
/// Places that are listed at most.
const MOST: usize = 6;

/// Shares of the squared residual force by equation and by what its state does: near rest (sticking and reversals) or moving
/// either way. Equations count by their residual relative to the force applied in them, so that units do not matter.
///
/// # Errors
/// [`DiagnoseError`] if the model cannot be evaluated.
pub(super) fn places(system: &System, records: &[Record], fit: &Fit) -> Result<Vec<Place>, DiagnoseError> {
    let residuals = force_residuals(system, &fit.effects, &fit.values, records)?;
    let mean_square = |values: &mut dyn Iterator<Item = f64>| {
        let (sum, count) = values.fold((0.0, 0.0), |(sum, count), v| (sum + v * v, count + 1.0));
        if count > 0.0 { sum / count } else { 0.0 }
    };
    let mut squares: BTreeMap<(String, String), f64> = BTreeMap::new();
    let mut names: Vec<&str> = residuals.iter().map(|r| r.equation.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    for name in names {
        let of = || residuals.iter().filter(|r| r.equation == name);
        let rest = NEAR_REST * mean_square(&mut of().flat_map(|r| r.state.iter().copied())).sqrt();
        let applied = mean_square(&mut of().flat_map(|r| r.reference.iter().copied()));
        if applied <= 0.0 {
            continue;
        }
        for (value, state) in of().flat_map(|r| r.values.iter().zip(&r.state)) {
            let regime = if state.abs() <= rest {
                format!("near rest, |{name}| < {rest:.2e}")
            } else if *state > 0.0 {
                format!("moving, {name} > 0")
            } else {
                format!("moving, {name} < 0")
            };
            *squares.entry((name.to_owned(), regime)).or_insert(0.0) += value * value / applied;
        }
    }
    let total: f64 = squares.values().sum();
    let mut places: Vec<Place> = squares
        .into_iter()
        .map(|((equation, regime), square)| Place { equation, regime, share: square / total })
        .filter(|p| p.share.is_finite())
        .collect();
    places.sort_by(|a, b| b.share.total_cmp(&a.share));
    places.truncate(MOST);
    Ok(places)
}
