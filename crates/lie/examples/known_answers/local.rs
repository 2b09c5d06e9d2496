//! Classes of systems with known answers about small-time local controllability, ranges and kinks.

use crate::hide::Hide;
use crate::model::Model;
use crate::random::Random;

/// States with these rates; `x`, `y`, `z`, `w` stand for the states, `u`, `v` for the inputs.
fn written(rates: &[&str], inputs: usize) -> Model {
    let mut model = Model::default();
    let inputs: Vec<String> = (0..inputs).map(|_| model.input()).collect();
    let states: Vec<usize> = rates.iter().map(|_| model.state()).collect();
    let names: Vec<String> = states.iter().map(|&s| model.name(s)).collect();
    for (&s, rate) in states.iter().zip(rates) {
        let parts: Vec<String> = words(rate)
            .iter()
            .map(|w| match w.as_str() {
                "x" => names[0].clone(),
                "y" => names[1].clone(),
                "z" => names[2].clone(),
                "w" => names[3].clone(),
                "u" => inputs[0].clone(),
                "v" => inputs[1].clone(),
                other => other.to_owned(),
            })
            .collect();
        model.rate(s, parts.concat());
    }
    model
}

/// Names and what stands between them.
fn words(text: &str) -> Vec<String> {
    let mut list: Vec<String> = Vec::new();
    for c in text.chars() {
        match list.last_mut() {
            Some(last) if c.is_alphabetic() && last.chars().all(char::is_alphabetic) => last.push(c),
            _ => list.push(c.to_string()),
        }
    }
    list
}

/// z' is a quadratic form of two states that the inputs move: definite or not.
pub(crate) fn quadratic(random: &mut Random) -> (Model, Hide) {
    let mut model = written(&["u", "v", "0"], 2);
    let (a, b, c) = loop {
        let pick = |random: &mut Random| random.below(7) as i64 - 3;
        let form = (pick(random), pick(random), pick(random));
        if form != (0, 0, 0) {
            break form;
        }
    };
    model.rate(2, format!("{a}*s1^2 + {b}*s1*s2 + {c}*s2^2"));
    // Indefinite where a x² + b x y + c y² takes both signs.
    let indefinite = b * b - 4 * a * c > 0;
    model.is("modes.0.strongly_accessible_dimension", 3);
    model.is("at_point.accessible_dimension", 3);
    model.is("at_point.linear_controllability_rank", 2);
    model.is("at_point.stlc.verdict", if indefinite { "yes" } else { "no" });
    model.is("at_point.brockett_condition", indefinite);
    if !indefinite {
        model.is("at_point.stabilizable", false);
    }
    (model, Hide::Nonlinear)
}

/// Forms with the number of inputs, the verdict for inputs without bounds, and that for bounded ones.
const FORMS: [(&[&str], usize, bool, bool); 13] = [
    (&["u", "x^2"], 1, false, false),
    (&["u", "x^3"], 1, true, true),
    (&["u", "x^2 + x^3"], 1, true, false),
    (&["u", "x^4"], 1, false, false),
    (&["u", "x^5"], 1, true, true),
    (&["u", "x", "x^2"], 1, false, false),
    (&["u", "x", "x^3"], 1, true, true),
    (&["u", "x", "y^2"], 1, false, false),
    (&["u", "x", "y^3"], 1, true, true),
    (&["u", "x*u"], 1, false, false),
    (&["u", "v", "x*v"], 2, true, true),
    (&["u", "v", "x*y^2"], 2, true, true),
    (&["u", "v", "x*v", "y*u*x"], 2, true, true),
];

/// Normal forms of one and two inputs, with ranges around zero or without.
pub(crate) fn stlc(random: &mut Random) -> (Model, Hide) {
    let (rates, inputs, free, bounded) = FORMS[random.below(FORMS.len())];
    let mut model = written(rates, inputs);
    let with_ranges = random.once_in(2);
    if with_ranges {
        model.ranges = model.inputs.iter().map(|u| (u.clone(), -1, 1)).collect();
    }
    let yes = if with_ranges { bounded } else { free };
    model.is("at_point.stlc.verdict", if yes { "yes" } else { "no" });
    (model, Hide::Coordinates)
}

/// Inputs of which some are at an end of their range.
pub(crate) fn ranges(random: &mut Random) -> (Model, Hide) {
    type Form = (&'static [&'static str], &'static [(i64, i64)], bool);
    const FORMS: [Form; 10] = [
        (&["y", "u"], &[(0, 1)], false),
        (&["y", "u"], &[(-1, 2)], true),
        (&["u - v"], &[(0, 1), (0, 2)], true),
        (&["y", "u - v"], &[(0, 1), (0, 2)], true),
        (&["u", "v"], &[(0, 1), (-1, 1)], false),
        (&["u", "v - x^2"], &[(-1, 1), (0, 1)], true),
        (&["u", "v + x^2"], &[(-1, 1), (0, 1)], false),
        (&["u + 2*v", "x"], &[(0, 1), (-1, 1)], true),
        (&["u", "x", "v"], &[(-1, 1), (0, 3)], false),
        (&["u - 2*v", "x", "y"], &[(0, 1), (0, 1)], true),
    ];
    let (rates, ends, yes) = FORMS[random.below(FORMS.len())];
    let mut model = written(rates, ends.len());
    model.ranges = model.inputs.iter().zip(ends).map(|(u, e)| (u.clone(), e.0, e.1)).collect();
    model.is("at_point.stlc.verdict", if yes { "yes" } else { "no" });
    (model, Hide::Coordinates)
}

/// Dry friction and kinks, with the dimension that all modes reach together.
pub(crate) fn kinks(random: &mut Random) -> (Model, Hide) {
    // Rates, inputs, dimension in each mode (0 where the modes differ), in all together, and the verdict at the origin where it is known.
    type Form = (&'static [&'static str], usize, usize, Option<bool>);
    const FORMS: [Form; 8] = [
        (&["y", "u - sign(y)"], 2, 2, None),
        (&["y", "u - 2*sign(y)", "w", "sign(y - w)"], 2, 4, None),
        (&["u", "u*abs(x)"], 1, 1, Some(false)),
        (&["u", "u*sign(x)"], 1, 1, Some(false)),
        (&["u", "max(x, 0)"], 0, 2, Some(false)),
        (&["u", "x + abs(x)"], 0, 2, Some(false)),
        (&["y", "u - 2*max(x, 0) - 3*min(x, 0)", "u*y"], 2, 2, Some(false)),
        (&["u", "abs(x)"], 2, 2, Some(false)),
    ];
    let (rates, mode, together, stlc) = FORMS[random.below(FORMS.len())];
    let mut model = written(rates, 1);
    if mode > 0 {
        model.is("modes.0.strongly_accessible_dimension", mode);
        model.is("modes.1.strongly_accessible_dimension", mode);
    }
    model.is("switched.strongly_accessible_dimension", together);
    if let Some(yes) = stlc {
        model.is("at_point.stlc.verdict", if yes { "yes" } else { "no" });
    }
    (model, Hide::Coordinates)
}
