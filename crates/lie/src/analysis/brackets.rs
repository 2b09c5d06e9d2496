//! Brackets that are asked for by name, and the names of those behind a rank.

use std::sync::Arc;

use bracketry_symbolic::{Function, Pool};
use bracketry_system::System;

use crate::algebra::field::{VectorFields, subtract};
use crate::algebra::word::{Bracket, Generator, Word, generators, parse_named};
use crate::answer::Answer;
use crate::error::Error;
use crate::reason::Reason;
use serde::Serializer;

/// The brackets with these names, in the generators f, g1 … gm or by the names of the inputs.
///
/// # Errors
/// [`Error::Bracket`] for text that is none.
pub(crate) fn read(system: &System, texts: &[String]) -> Result<Vec<(String, Word)>, Error> {
    let inputs: Vec<String> = system.inputs.iter().map(|&u| system.pool.name(u).to_owned()).collect();
    texts.iter().map(|t| Ok((t.trim().to_owned(), parse_named(t, &inputs)?))).collect()
}

/// A bracket that was asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct RequestedBracket {
    /// As it was written.
    pub name: String,
    /// The bracket.
    pub bracket: Bracket,
    /// One simplified component per state.
    pub components: Answer<Vec<Function>>,
}

/// Writes brackets as one object of components, these without a limit on their length.
pub(crate) fn by_name<S: Serializer>(list: &[RequestedBracket], serializer: S) -> Result<S::Ok, S::Error> {
    let texts = |list: Vec<Function>| list.iter().map(Function::text).collect::<Vec<_>>();
    serializer.collect_map(list.iter().map(|b| (&b.name, b.components.clone().map(texts))))
}

/// The components of each bracket, simplified.
pub(crate) fn components(pool: &mut Pool, fields: &VectorFields, words: &[(String, Word)]) -> Vec<RequestedBracket> {
    let generators = generators(fields.controls.len());
    let mut of = |word: &Word| -> Answer<Vec<Function>> {
        let field = match fields.brackets(pool, std::slice::from_ref(word)) {
            Ok(fields) => fields.concat(),
            Err(why) => return Answer::Unknown(why.into()),
        };
        let simple: Vec<_> = field.into_iter().map(|e| pool.simplify(e)).collect();
        if simple.iter().all(|&e| pool.is_printable(e)) {
            Answer::Known(Function::list(pool, &simple))
        } else {
            Answer::Unknown(Reason::Unprintable)
        }
    };
    let requested = |(name, word): &(String, Word)| RequestedBracket {
        name: name.clone(),
        bracket: Bracket { word: word.clone(), generators: generators.clone() },
        components: of(word),
    };
    words.iter().map(requested).collect()
}

/// The generators of [`VectorFields::switched`]: those that are the same in all modes, else with the number of the
/// mode; differences of drifts.
pub(crate) fn family_generators(pool: &mut Pool, family: &[VectorFields], all: &VectorFields) -> Arc<[Generator]> {
    let Some(first) = family.first() else { return generators(all.controls.len()) };
    let drift = (!family.iter().all(|m| m.drift == first.drift)).then_some(1);
    let mut list = vec![Generator::Drift { mode: drift }];
    for field in &all.controls {
        let place = family.iter().zip(1..).find_map(|(m, k)| {
            let i = m.controls.iter().position(|g| g == field)?;
            let everywhere = family.iter().all(|o| o.controls.get(i) == Some(field));
            Some(Generator::Input { input: i + 1, mode: (!everywhere).then_some(k) })
        });
        let mut difference = || {
            let k = family.iter().position(|m| subtract(pool, &m.drift, &first.drift) == *field);
            Generator::DriftDifference { mode: k.unwrap_or_default() + 1 }
        };
        list.push(place.unwrap_or_else(&mut difference));
    }
    list.into()
}
