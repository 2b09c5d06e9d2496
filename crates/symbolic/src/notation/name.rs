//! Names of models as letters with indices.

use super::tree::{Joint, Notation};

/// Greek letters by their names.
const GREEK: [(&str, char); 32] = [
    ("alpha", 'α'),
    ("beta", 'β'),
    ("gamma", 'γ'),
    ("delta", 'δ'),
    ("epsilon", 'ε'),
    ("zeta", 'ζ'),
    ("eta", 'η'),
    ("theta", 'θ'),
    ("iota", 'ι'),
    ("kappa", 'κ'),
    ("lambda", 'λ'),
    ("mu", 'μ'),
    ("nu", 'ν'),
    ("xi", 'ξ'),
    ("rho", 'ρ'),
    ("sigma", 'σ'),
    ("tau", 'τ'),
    ("upsilon", 'υ'),
    ("phi", 'φ'),
    ("chi", 'χ'),
    ("psi", 'ψ'),
    ("omega", 'ω'),
    ("Gamma", 'Γ'),
    ("Delta", 'Δ'),
    ("Theta", 'Θ'),
    ("Lambda", 'Λ'),
    ("Xi", 'Ξ'),
    ("Sigma", 'Σ'),
    ("Upsilon", 'Υ'),
    ("Phi", 'Φ'),
    ("Psi", 'Ψ'),
    ("Omega", 'Ω'),
];

/// The letter that a name stands for.
pub(super) fn greek(name: &str) -> Option<char> {
    GREEK.iter().find(|(n, _)| *n == name).map(|g| g.1)
}

/// Whether a name is one letter or digit.
pub(super) fn is_single(name: &str) -> bool {
    name.chars().count() == 1 && name.chars().all(char::is_alphanumeric)
}

/// `theta_1`, `theta1` → θ₁; `F_x_max` → F with the indices x, max.
pub(super) fn spelled(name: &str) -> Notation {
    let letters = |text: &str| Notation::Letters(text.to_owned());
    let mut parts = name.split('_').filter(|p| !p.is_empty());
    let Some(head) = parts.next() else { return letters(name) };
    let stem = head.trim_end_matches(|c: char| c.is_ascii_digit());
    let (stem, digits) = if stem.is_empty() { (head, "") } else { head.split_at(stem.len()) };
    let index = |part: &str| {
        let number = part.chars().all(|c| c.is_ascii_digit());
        if number { Notation::Number(part.to_owned()) } else { spelled(part) }
    };
    let indices: Vec<Notation> = Some(digits).into_iter().filter(|d| !d.is_empty()).chain(parts).map(index).collect();
    if indices.is_empty() { letters(stem) } else { letters(stem).subscript(Notation::List(Joint::Tight, indices)) }
}

/// Whether a formula starts with a digit, so that it would run together with a number before it.
pub(super) fn starts_with_digit(formula: &Notation) -> bool {
    match formula {
        Notation::Number(_) => true,
        Notation::Symbol(name) => starts_with_digit(&spelled(name)),
        Notation::Letters(name) => is_single(name) && name.starts_with(|c: char| c.is_ascii_digit()),
        Notation::Row(list) | Notation::Sum(list) | Notation::Product(list) | Notation::List(_, list) => {
            list.first().is_some_and(starts_with_digit)
        }
        Notation::Superscript(two) | Notation::Subscript(two) | Notation::Relation(two, _) => {
            starts_with_digit(&two[0])
        }
        _ => false,
    }
}
