//! The section on what the outputs tell.

use bracketry_lie::observability::Direction;
use bracketry_lie::{Analysis, Answer, Named};

use super::blocks::{Block, Line, code, item, math, section, text};
use super::formulas::{function, symbol};

/// Observability, identifiability, and the symmetries that prevent them.
pub(super) fn observability(a: &Analysis, out: &mut Vec<Block>) {
    let Some(o) = &a.report.observability else { return };
    section(out, "Observability");
    let states = a.original.states.len();
    let name = "rank of the observability codistribution";
    let mut items = vec![match &o.rank {
        Answer::Known(r) => item(name, format!("{r} of {states}")),
        Answer::Unknown(why) => item(name, format!("unknown ({why})")),
    }];
    if !o.unobservable.is_empty() {
        let mut line = vec![text("not determined by the outputs: ")];
        line.extend(listed(o.unobservable.iter().map(|n| symbol(n))));
        items.push(line);
    }
    items.extend(o.unobservable_directions.iter().map(|d| direction("no output changes along ", d)));
    let told = |list: &Option<Named<bool>>, yes: bool| -> Vec<String> {
        list.iter().flat_map(|m| &m.0).filter(|(_, v)| *v == yes).map(|(n, _)| symbol(n)).collect()
    };
    let asked = |yes: bool| -> Vec<String> {
        let answers = o.determined.iter().flat_map(|m| &m.0).zip(&o.determined_functions);
        answers.filter(|((_, v), _)| *v == yes).map(|(_, f)| function(f)).collect()
    };
    for (found, words) in [
        (told(&o.identifiable, true), "locally identifiable parameters: "),
        (told(&o.identifiable, false), "parameters that are not identifiable: "),
        (told(&o.identifiable_states, false), "states that are not determined while parameters are unknown: "),
        (told(&o.identifiable_without_inputs, false), "not identifiable while all inputs are zero: "),
        (asked(true), "locally determined, while parameters are unknown: "),
        (asked(false), "not determined, while parameters are unknown: "),
    ] {
        if !found.is_empty() {
            let mut line = vec![text(words)];
            line.extend(listed(found));
            items.push(line);
        }
    }
    if let Some(open) = &o.undecided_parameters {
        let mut line = vec![text("parameters whose identifiability is unknown: ")];
        line.extend(listed(open.names.iter().map(|n| symbol(n))));
        line.push(text(format!(" ({})", open.reason)));
        items.push(line);
    }
    if let Some(why) = &o.undecided_without_inputs {
        items.push(vec![text(format!("identifiability while all inputs are zero: unknown ({why})"))]);
    }
    items.extend(
        o.unidentifiable_directions
            .iter()
            .map(|d| direction("while parameters are unknown, no output changes along ", d)),
    );
    if let Some(why) = &o.undecided_directions {
        items.push(vec![text(format!("directions along which no output changes: unknown ({why})"))]);
    }
    if let Some(fix) = o.fix_to_identify.as_ref().filter(|f| !f.is_empty()) {
        let mut line = vec![text("to make all parameters locally identifiable, it suffices to know: ")];
        line.extend(listed(fix.iter().map(|n| symbol(n))));
        items.push(line);
    }
    if let Some(why) = &o.reason {
        items.push(vec![text(why.to_string())]);
    }
    out.push(Block::List(items));
}

/// Formulas with commas between them.
pub(super) fn listed(formulas: impl IntoIterator<Item = String>) -> Line {
    let mut line = Vec::new();
    for (k, formula) in formulas.into_iter().enumerate() {
        if k > 0 {
            line.push(text(", "));
        }
        line.push(math(formula));
    }
    line
}

fn direction(words: &str, d: &Direction) -> Line {
    let mut line = vec![text(words), code(d.field.to_string())];
    if let Some(symmetry) = &d.symmetry {
        line.push(text(format!(" ({symmetry})")));
    }
    line
}
