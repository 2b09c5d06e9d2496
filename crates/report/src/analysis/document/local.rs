//! The section on what holds at the point of the model.

use bracketry_lie::controllability::{PointReport, Stlc, UncontrollableMode, Vanishing};
use bracketry_lie::{Analysis, Answer};

use super::blocks::{Block, Line, item, math, section, text, words};
use super::formulas::{bracket, complex, function};
use crate::analysis::text::{outside, yes_no};

/// Statements at the point of the model.
pub(super) fn at_the_point(a: &Analysis, out: &mut Vec<Block>) {
    let Some(point) = &a.report.at_point else { return };
    section(out, "At the point");
    if let Some(p) = &a.original.point {
        let mut system = a.original.clone();
        let mut entries = Vec::new();
        let symbols = a.original.states.iter().chain(&a.original.inputs);
        for (&s, &v) in symbols.zip(p.states.iter().chain(&p.inputs)) {
            if !system.pool.is_zero(v) {
                let s = system.pool.sym(s);
                entries.push(format!("{} = {}", system.pool.latex(s), system.pool.latex(v)));
            }
        }
        let place = if entries.is_empty() {
            vec![text("The origin.")]
        } else {
            vec![math(entries.join(",\\ ")), text("; all others are 0.")]
        };
        out.push(Block::Paragraph(place));
    }
    match point {
        Answer::Unknown(why) => out.push(words(format!("Nothing is decided there: {why}."))),
        Answer::Known(p) => local(p, out),
    }
}

fn local(p: &PointReport, out: &mut Vec<Block>) {
    if let Some(width) = p.epsilon {
        let mut line = vec![text("At the point ")];
        for (k, s) in p.vanishing.iter().enumerate() {
            if k > 0 {
                line.push(text(", "));
            }
            line.push(math(match s {
                Vanishing::Switch(surface) => function(surface),
                unit_vector @ Vanishing::UnitVector(_) => format!("\\text{{{unit_vector}}}"),
            }));
        }
        let verb = if p.vanishing.len() == 1 { "vanishes" } else { "vanish" };
        line.push(text(format!(" {verb}. Dimensions and linear statements are of the smoothed model, width ")));
        line.push(math(width.to_string()));
        line.push(text("; all others are of the model."));
        out.push(Block::Paragraph(line));
    }
    let mut items = vec![item("equilibrium", format!("{}{}", yes_no(&p.equilibrium), outside(p)))];
    if let Some(rank) = p.linear_controllability_rank {
        items.push(item("rank of the controllability matrix of the linearization", rank.to_string()));
    }
    if let Some(s) = &p.stabilizable {
        let why = p.stabilizable_reason.as_ref().filter(|_| s.known().is_some());
        items.push(item("stabilizable", format!("{}{}", yes_no(s), why.map_or(String::new(), |w| format!(" ({w})")))));
    }
    if let Some(modes) = &p.uncontrollable_modes {
        items.push(uncontrollable(modes));
    }
    if let Some(brockett) = &p.brockett_condition {
        let means = match brockett {
            Answer::Known(true) => "holds",
            Answer::Known(false) => "fails, so no continuous state feedback makes the point asymptotically stable",
            Answer::Unknown(_) => "unknown",
        };
        items.push(item("Brockett's necessary condition", means));
    }
    if let Some(defined) = &p.relative_degree_defined {
        items.push(item("the outputs have a vector relative degree at the point", yes_no(defined)));
    }
    items.push(item("small-time locally controllable", format!("{} ({})", p.stlc.verdict, p.stlc.reason)));
    if let Some(bounded) = &p.stlc.bounded {
        let verdict = format!("{} ({})", bounded.verdict, bounded.reason);
        items.push(item("with bounded inputs", verdict));
    }
    if let Some(smoothed) = &p.smoothed_stlc {
        let verdict = format!("{} ({})", smoothed.verdict, smoothed.reason);
        items.push(item("that of the smoothed model", verdict));
    }
    items.extend(general_condition(&p.stlc));
    out.push(Block::List(items));
}

fn uncontrollable(modes: &Answer<Vec<UncontrollableMode>>) -> Line {
    let name = "uncontrollable eigenvalues of the linearization: ";
    let modes = match modes {
        Answer::Unknown(why) => return vec![text(format!("{name}unknown ({why})"))],
        Answer::Known(modes) if modes.is_empty() => return vec![text(format!("{name}none"))],
        Answer::Known(modes) => modes,
    };
    let mut line = vec![text(name)];
    for (k, m) in modes.iter().enumerate() {
        line.push(text(if k > 0 { "; " } else { "" }));
        line.push(math(complex(m.re, m.im)));
        if m.multiplicity > 1 {
            line.push(text(format!(" ({} times)", m.multiplicity)));
        }
        if !m.combinations.is_empty() {
            let list: Vec<String> = m.combinations.iter().map(function).collect();
            line.push(text(" along "));
            line.push(math(list.join(",\\ ")));
        }
    }
    line
}

/// What Sussmann's general condition says, with the weights or the bracket that obstructs it.
fn general_condition(stlc: &Stlc) -> Vec<Line> {
    let tuple = |weights: &[u32]| {
        let weights: Vec<String> = weights.iter().map(ToString::to_string).collect();
        math(format!("({})", weights.join(", ")))
    };
    let mut items = Vec::new();
    if let Some(weights) = &stlc.weights {
        items.push(vec![
            text("Sussmann's general condition holds with the weights "),
            tuple(weights),
            text(" of drift and inputs"),
        ]);
    }
    if let Some(o) = &stlc.obstruction {
        items.push(vec![
            text("Sussmann's general condition is obstructed by the bad bracket "),
            math(bracket(&o.bracket)),
            text(", with the weights "),
            tuple(&o.weights),
        ]);
    }
    items
}
