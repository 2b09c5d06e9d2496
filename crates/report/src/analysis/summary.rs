//! What the ranks mean, in plain language.

use std::fmt::Write as _;

use bracketry_lie::analysis::Dimensions;
use bracketry_lie::controllability::{SwitchedReport, SwitchingTheorem};
use bracketry_lie::{Analysis, Answer, Function};

use super::lists::{joined, series};

/// One paragraph for who does not know the terms.
pub fn summary(a: &Analysis) -> String {
    let delays = about_delays(a).map_or(String::new(), |delays| format!(" {delays}"));
    plain_language(a) + &delays + &about_outputs(a)
}

/// The answer in a sentence.
pub(super) fn verdict(a: &Analysis) -> String {
    let known = |d: &Dimensions| d.strongly_accessible_dimension.known().copied();
    let least = a.report.modes.iter().map(|m| known(&m.dimensions)).min().flatten();
    let (Some(inside), true) = (least, a.inputs > 0) else { return plain_language(a) };
    let n = a.states;
    let set = if inside == n { "a set of full dimension" } else { "a set of dimension" };
    let has_modes = a.report.modes.iter().any(|m| !m.signs.0.is_empty());
    let all = a.report.switched.as_ref().and_then(|s| known(&s.dimensions)).filter(|all| *all > inside);
    let switching = all.map_or_else(String::new, |all| format!("; with switching between all modes, {all} of {n}"));
    let when = if has_modes { " while no switching function changes sign" } else { "" };
    format!("At each time, the inputs reach {set} {inside} of {n}{when}{switching}.")
}

/// What about the outputs is undecided.
fn about_outputs(a: &Analysis) -> String {
    let Some(o) = &a.report.observability else { return String::new() };
    let mut open = Vec::new();
    if o.rank.known().is_none() {
        open.push("which states the outputs determine".to_owned());
    }
    if let Some(parameters) = &o.undecided_parameters {
        open.push(format!("whether they determine {}", joined(&parameters.names, ", ")));
    }
    if open.is_empty() {
        return String::new();
    }
    format!(" Undecided, for the reason given in the report: {}.", open.join("; "))
}

/// What delays of inputs change of all this.
fn about_delays(a: &Analysis) -> Option<String> {
    if a.input_delays.is_empty() {
        return None;
    }
    let unit = a.affinization.system.quantities.time_unit;
    let list: Vec<String> = a.input_delays.iter().map(|(name, d)| format!("{name} by {}", unit.text(d))).collect();
    Some(format!(
        "Inputs act later than they are commanded ({}). All statements refer to the inputs as they arrive: ranks and \
         dimensions do not change, and the inputs reach the same sets, only later by the delay. State feedback, as for \
         linearization or stabilization, has to predict the state over the delay.",
        list.join(", ")
    ))
}

/// What the ranks mean, in one paragraph.
fn plain_language(a: &Analysis) -> String {
    let n = a.states;
    if a.inputs == 0 {
        return "There are no inputs: the state cannot be controlled, only observed through the outputs.".to_owned();
    }
    let Some(worst) = a.report.modes.iter().min_by_key(|m| m.dimensions.strongly_accessible_dimension.known().copied())
    else {
        return String::new();
    };
    let Some(&inside) = worst.dimensions.strongly_accessible_dimension.known() else {
        return "What the inputs reach is undecided; the report above gives the reason.".to_owned();
    };
    let functions = worst.autonomous.known().cloned().unwrap_or_default();
    let missing = worst.autonomous_not_found.unwrap_or(0);
    let full = |d: &Dimensions| d.strongly_accessible_dimension.known().copied();
    if worst.signs.0.is_empty() {
        return if inside == n {
            format!(
                "From almost every state, and at every later time, the states that the inputs reach contain an open set of \
                 the {n}-dimensional state space."
            )
        } else {
            format!(
                "At each time, the states that the inputs reach form a set of dimension only {inside}, out of {n}. {}",
                fixed_functions(&functions, missing, "")
            )
        };
    }
    let signs = worst.signs.condition();
    let mut text = if inside == n {
        format!("Even while no switching function changes sign, the inputs reach a set of full dimension {n}.")
    } else {
        format!(
            "While no switching function changes sign (here: {signs}), the states that the inputs reach at each time form \
             a set of dimension only {inside}, out of {n}. {}",
            fixed_functions(&functions, missing, " there")
        )
    };
    if let Some(switched) = &a.report.switched {
        text += &together(switched, inside, n);
    }
    if let Some(s) = &a.report.smoothed
        && let Some(all) = full(&s.dimensions).filter(|all| *all > inside)
    {
        let _ = write!(
            text,
            " The smoothed model, in which sign(σ) is tanh(σ/{}), has dimension {all} in a single mode, because the \
             smooth sign depends on the state and so couples the directions. That rank holds for the smoothed model \
             only: exact dry friction sticks where the inputs do not overcome it.",
            s.epsilon
        );
    }
    if worst.signs.0.len() > 1 {
        text += " Modes are combinations of signs; whether each of them occurs is not checked.";
    }
    text
}

/// What switching adds to the dimension `inside` of a mode.
fn together(switched: &SwitchedReport, inside: usize, n: usize) -> String {
    match &switched.dimensions.strongly_accessible_dimension {
        Answer::Known(all) if *all <= inside => String::new(),
        Answer::Known(all) if switched.strongly_accessible_by == SwitchingTheorem::SurfaceClosure => format!(
            " Where the motion crosses from one mode to another, it continues in other directions, and it may return. \
             Over all modes together, the dimension is {all} of {n}, provided that the motion can cross the surfaces \
             between the modes repeatedly."
        ),
        Answer::Known(all) => format!(
            " Where the mode changes, the drift changes, and the difference of two drifts acts like an additional \
             input. With all modes together, the dimension is {all} of {n}: switching reaches directions that a \
             single mode does not. With dry friction, this means sliding back and forth, where the inputs overcome \
             the friction."
        ),
        Answer::Unknown(why) => format!(" What switching between the modes adds is undecided: {why}."),
    }
}

/// `missing` further functions have no closed form that was found.
fn fixed_functions(functions: &[Function], missing: usize, place: &str) -> String {
    let found = match functions.len() {
        0 => String::new(),
        1 => format!("The function {} evolves{place} as if there were no input.", functions[0]),
        _ => format!("The functions {} evolve{place} as if there were no input.", series(functions)),
    };
    let rest = match (missing, functions.is_empty()) {
        (0, _) => return found,
        (1, true) => format!("One function evolves{place} as if there were no input; it was not found in closed form."),
        (k, true) => {
            format!("{k} independent functions evolve{place} as if there were no input; none was found in closed form.")
        }
        (1, false) => "One more was not found in closed form.".to_owned(),
        (k, false) => format!("{k} more were not found in closed form."),
    };
    [found, rest].into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join(" ")
}

/// Lines of at most `width` characters, broken at spaces.
pub(crate) fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}
