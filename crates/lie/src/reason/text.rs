//! Lists in the text of reasons.

use std::fmt;

use bracketry_symbolic::Function;

/// Such as `w1, the integral of w2, the square of the integral of w3`.
pub(super) fn integrals(integrators: &[usize], squared: &[bool]) -> String {
    let one = |((&count, &squared), i): ((&usize, &bool), usize)| {
        let of = match count {
            0 => format!("w{i}"),
            1 => format!("the integral of w{i}"),
            _ => format!("the integral, of order {count}, of w{i}"),
        };
        if squared { format!("the square of {of}") } else { of }
    };
    let list: Vec<String> = integrators.iter().zip(squared).zip(1..).map(one).collect();
    list.join(", ")
}

pub(super) fn texts(list: &[impl fmt::Display]) -> String {
    list.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}

pub(super) fn equations(list: &[(String, Function)]) -> String {
    texts(&list.iter().map(|(name, e)| format!("{name} = {e}")).collect::<Vec<_>>())
}
