//! Rates that count for more or less in the limit surface of a contact.

use bracketry_symbolic::{Directed, Expr, Pool};
use rustc_hash::FxHashMap;

use super::names::ModelNames;
use super::replace::under_inverse_root;
use super::terms::factors as factors_of;
use crate::effect::{Change, Effect};
use crate::error::DiagnoseError;

/// What stands for the components of the unit vector over the root of `square`, `rate/√S`, where each rate is `length` times as
/// long: with D the diagonal matrix of the lengths, the friction acts along `D² v/|D v|`, so that dissipation is greatest among all
/// forces within the ellipsoid (Moreau's principle).
///
/// The `spins`, each as many times as long as its length, come under the root, and this stands for the root of their own friction,
/// `unit(length*spin, slips)`.
///
/// The components of the `slips` come before those of other rates, and those with a length before those without: a product of a
/// spin and a slip over one root means the direction of the slip.
///
/// # Errors
/// [`DiagnoseError::Term`] for an expression that cannot be read.
pub(super) fn stretched(
    pool: &mut Pool,
    names: &mut ModelNames,
    square: &str,
    slips: &[String],
    lengths: &[(String, String)],
    spins: &[(String, String)],
) -> Result<Vec<(Expr, Expr)>, DiagnoseError> {
    let square = names.read(pool, square)?;
    let mut longer = FxHashMap::default();
    let mut factors: Vec<(Expr, Option<Expr>)> = Vec::new();
    let lengthened = lengths.iter().map(|(rate, length)| (rate, Some(length)));
    let rest = slips.iter().filter(|slip| lengths.iter().all(|l| l.0 != **slip)).map(|slip| (slip, None));
    let (along, others): (Vec<_>, Vec<_>) = lengthened.chain(rest).partition(|(rate, _)| slips.contains(rate));
    for (rate, length) in along.into_iter().chain(others) {
        let rate = names.read(pool, rate)?;
        let length = length.map(|text| names.read(pool, text)).transpose()?;
        if let Some(length) = length {
            longer.insert(rate, pool.mul(length, rate));
        }
        factors.push((rate, length.map(|length| pool.powi(length, 2))));
    }
    let mut stretched = pool.substitute(square, &longer);
    let mut replaced = vec![square];
    for (rate, length) in spins {
        let component = names.read(pool, &format!("unit({length}*{rate}, {})", slips.join(", ")))?;
        // The root of the spin's own friction becomes the same.
        replaced.extend(factors_of(pool, component).into_iter().find_map(|f| under_inverse_root(pool, f)));
        let [rate, length] = [names.read(pool, rate)?, names.read(pool, length)?];
        let own = pool.mul(length, rate);
        let own = pool.powi(own, 2);
        stretched = pool.add(stretched, own);
        pool.set_directed(stretched, Directed::Written);
    }
    let mut inverse_root = |e| {
        let root = pool.sqrt(e);
        pool.powi(root, -1)
    };
    let new = inverse_root(stretched);
    let roots: Vec<Expr> = replaced.into_iter().map(&mut inverse_root).collect();
    let mut pairs: Vec<(Expr, Expr)> = Vec::new();
    for (rate, factor) in factors {
        let image = pool.mul(rate, new);
        let image = factor.map_or(image, |factor| pool.mul(factor, image));
        pairs.push((pool.mul(rate, roots[0]), image));
    }
    pairs.extend(roots.into_iter().map(|root| (root, new)));
    Ok(pairs)
}

/// The effects with those that stretch the same limit surface made one: lengths are factors of each other.
pub(super) fn merged(effects: &[Effect]) -> Vec<Effect> {
    let mut merged: Vec<Effect> = Vec::with_capacity(effects.len());
    for effect in effects {
        let Change::Stretch { square, lengths, spins, .. } = &effect.change else {
            merged.push(effect.clone());
            continue;
        };
        let same = merged.iter_mut().find_map(|other| match &mut other.change {
            Change::Stretch { square: s, lengths, spins, .. } if s == square => {
                Some((lengths, spins, &mut other.coefficients))
            }
            _ => None,
        });
        let Some((present, present_spins, coefficients)) = same else {
            merged.push(effect.clone());
            continue;
        };
        coefficients.extend(effect.coefficients.iter().cloned());
        present_spins.extend(spins.iter().cloned());
        for (rate, length) in lengths {
            match present.iter_mut().find(|(r, _)| r == rate) {
                Some((_, l)) => *l = format!("{l}*{length}"),
                None => present.push((rate.clone(), length.clone())),
            }
        }
    }
    merged
}
