//! Brackets that are asked for by name, and the names of those behind a rank.

use bracketry_symbolic::Pool;
use bracketry_system::System;

use crate::algebra::field::{VectorFields, subtract};
use crate::algebra::word::{Word, generator_names, parse_named};
use crate::answer::Answer;
use crate::error::Error;
use crate::named::Named;

/// The brackets with these names, in the generators f, g1 … gm or by the names of the inputs.
///
/// # Errors
/// [`Error::Bracket`] for text that is none.
pub(crate) fn read(system: &System, texts: &[String]) -> Result<Vec<(String, Word)>, Error> {
    let inputs: Vec<String> = system.inputs.iter().map(|&u| system.pool.name(u).to_owned()).collect();
    texts.iter().map(|t| Ok((t.trim().to_owned(), parse_named(t, &inputs)?))).collect()
}

/// The components of each bracket, simplified.
pub(crate) fn components(
    pool: &mut Pool,
    fields: &VectorFields,
    words: &[(String, Word)],
) -> Named<Answer<Vec<String>>> {
    let list = words.iter().map(|(name, word)| {
        let found = fields.brackets(pool, std::slice::from_ref(word)).map_err(|why| why.to_string());
        let texts = found.and_then(|fields| {
            let simple: Vec<_> = fields.concat().into_iter().map(|e| pool.simplify(e)).collect();
            if simple.iter().all(|&e| pool.is_printable(e)) {
                Ok(simple.iter().map(|&e| pool.text(e)).collect())
            } else {
                Err("too long to print".to_owned())
            }
        });
        (name.clone(), texts.into())
    });
    Named(list.collect())
}

/// Names of the generators of [`VectorFields::switched`]: `f` and `g1` … where these are the same in all modes,
/// else with the number of the mode, from 1, as in `g1(2)`; differences of drifts as `f(2)-f(1)`.
pub(crate) fn family_names(pool: &mut Pool, family: &[VectorFields], all: &VectorFields) -> Vec<String> {
    let Some(first) = family.first() else { return generator_names(all.controls.len()) };
    let drift = if family.iter().all(|m| m.drift == first.drift) { "f" } else { "f(1)" };
    let mut names = vec![drift.to_owned()];
    for field in &all.controls {
        let place = family.iter().enumerate().find_map(|(k, m)| {
            let i = m.controls.iter().position(|g| g == field)?;
            let everywhere = family.iter().all(|o| o.controls.get(i) == Some(field));
            Some(if everywhere { format!("g{}", i + 1) } else { format!("g{}({})", i + 1, k + 1) })
        });
        let difference = || {
            let k = family.iter().position(|m| subtract(pool, &m.drift, &first.drift) == *field);
            format!("f({})-f(1)", k.unwrap_or_default() + 1)
        };
        names.push(place.unwrap_or_else(difference));
    }
    names
}
