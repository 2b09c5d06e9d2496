//! The sections of the report.

use bracketry_lie::analysis::{Dimensions, ModeReport};
use bracketry_lie::controllability::Switchable;
use bracketry_lie::{Analysis, Answer};
use bracketry_symbolic::{Expr, Symbol};
use bracketry_system::{AffineForm, Candidate, Parameter, System};

use super::blocks::{Block, Line, Span, code, math, section, text, words};
use super::formulas::{bracket, column, condition, expression, function, list, shortened, symbol};
use super::outputs::listed;
use super::{control, local, outputs};
use crate::analysis::affinization::method_name;
use crate::analysis::summary::summary;
use crate::analysis::text::{family, lie_algebra};
use crate::notation::rate;

/// The whole report.
pub(super) fn document(a: &Analysis) -> Vec<Block> {
    let mut out = vec![Block::Heading(1, format!("Analysis of {}", a.model)), words(summary(a))];
    model(a, &mut out);
    affine_form(a, &mut out);
    reach(a, &mut out);
    local::at_the_point(a, &mut out);
    control::input_output(a, &mut out);
    control::linearization(a, &mut out);
    outputs::observability(a, &mut out);
    certificate(a, &mut out);
    out
}

fn equations(system: &System) -> Block {
    let equation = |(&s, &e): (&Symbol, &Expr)| {
        format!("\\dot{{{}}} &= {}", symbol(system.symbol_name(s)), shortened(&system.pool, e, &rate(system, e)))
    };
    Block::Display(system.states.iter().zip(&system.dynamics).map(equation).collect())
}

fn model(a: &Analysis, out: &mut Vec<Block>) {
    section(out, "Model");
    let system = &a.original;
    let mut line = vec![text("States ")];
    line.extend(listed(system.state_names().iter().map(|n| symbol(n))));
    line.push(text(if system.inputs.is_empty() { ", no inputs" } else { "; inputs " }));
    line.extend(listed(system.input_names().iter().map(|n| symbol(n))));
    line.push(text("."));
    out.push(Block::Paragraph(line));
    out.push(equations(system));
    if !system.parameters.is_empty() {
        let header = ["parameter", "value", "unit", "about"].map(|h| vec![text(h)]).to_vec();
        let row = |p: &Parameter| {
            vec![
                vec![math(symbol(system.symbol_name(p.symbol)))],
                vec![text(p.value.to_f64().value().to_string())],
                vec![text(p.unit.clone().unwrap_or_default())],
                vec![text(p.about.clone().unwrap_or_default())],
            ]
        };
        out.push(Block::Table(header, system.parameters.iter().map(row).collect()));
    }
    // Outputs that are states by their own name say nothing as an equation.
    let formulas = system.outputs.iter().map(|(name, e)| (symbol(name), expression(&system.pool, *e)));
    let (plain, defined): (Vec<_>, Vec<_>) = formulas.partition(|(name, formula)| name == formula);
    if !plain.is_empty() {
        let list: Vec<String> = plain.into_iter().map(|p| p.0).collect();
        out.push(Block::Paragraph(vec![text("Outputs "), math(list.join(",\\ ")), text(".")]));
    }
    if !defined.is_empty() {
        out.push(words("Outputs:"));
        out.push(Block::Display(defined.into_iter().map(|(name, formula)| format!("{name} &= {formula}")).collect()));
    }
}

fn affine_form(a: &Analysis, out: &mut Vec<Block>) {
    section(out, "Affine form");
    out.push(Block::Paragraph(capital(vec![text(format!("{}.", a.affinization.why))])));
    for v in &a.affinization.input_change {
        let mut line = vec![
            text("New input "),
            math(format!("{} = {}", symbol(&v.name), expression(&a.affinization.system.pool, v.function))),
        ];
        if let Some(range) = v.range() {
            line.push(text(format!(", limited to {range}")));
        }
        line.push(text("."));
        out.push(Block::Paragraph(line));
    }
    for z in &a.affinization.coordinate_change {
        out.push(Block::Paragraph(vec![
            text("New state "),
            math(format!("{} = {}", symbol(&z.name), function(&z.function))),
            text(" in place of "),
            math(format!("{} = {}", symbol(&z.replaces), function(&z.inverse))),
            text("."),
        ]));
    }
    if let Some(r) = &a.family {
        out.push(Block::Paragraph(capital(vec![text(format!("{}.", family(r)))])));
    }
    candidates(a, out);
    let affine = &a.affinization.system;
    if !a.affine {
        out.push(equations(affine));
    }
    if let Ok(Some(AffineForm { pool, drift, fields })) = affine.affine_form() {
        let inputs = affine.input_names();
        let driftless = drift.iter().all(|&e| pool.is_zero(e));
        let mut sum: Vec<String> = if driftless { Vec::new() } else { vec!["f".to_owned()] };
        sum.extend((1..=fields.len()).map(|i| format!("g_{{{i}}} {}", symbol(&inputs[i - 1]))));
        let column = |e: &[Expr]| column(&e.iter().map(|&e| expression(&pool, e)).collect::<Vec<_>>());
        let mut definitions = vec![format!("\\dot x &= {}", if sum.is_empty() { "0".into() } else { sum.join(" + ") })];
        if !driftless {
            definitions.push(format!("f &= {}", column(&drift)));
        }
        definitions.extend(fields.iter().enumerate().map(|(i, g)| format!("g_{{{}}} &= {}", i + 1, column(g))));
        out.push(words("Drift and input fields:"));
        out.push(Block::Display(definitions));
    }
}

/// The candidates, where there was a choice.
fn candidates(a: &Analysis, out: &mut Vec<Block>) {
    if a.affine || a.affinization.candidates.len() < 2 {
        return;
    }
    let row = |c: &Candidate| {
        let verdict = match (c.chosen, c.is_accepted()) {
            (true, _) => "taken",
            (false, true) => "possible",
            (false, false) => "rejected",
        };
        let states = if c.is_accepted() { vec![math(c.added_states.to_string())] } else { Vec::new() };
        vec![vec![text(method_name(c.method))], states, vec![text(verdict)], vec![text(c.why.to_string())]]
    };
    let header = ["method", "added states", "", "why"].map(|h| vec![text(h)]).to_vec();
    out.push(Block::Table(header, a.affinization.candidates.iter().map(row).collect()));
}

fn dimension(d: &Answer<usize>) -> Line {
    match d {
        Answer::Known(d) => vec![math(d.to_string())],
        Answer::Unknown(_) => vec![text("unknown")],
    }
}

fn rank_row(what: Line, d: &Dimensions) -> Vec<Line> {
    vec![
        what,
        dimension(&d.accessible_dimension),
        vec![math(list(&d.growth))],
        dimension(&d.strongly_accessible_dimension),
        vec![math(list(&d.strong_growth))],
    ]
}

fn mode_name(m: &ModeReport) -> Line {
    if m.signs.0.is_empty() {
        return vec![text("at a generic point")];
    }
    vec![text("while "), math(condition(&m.signs.condition()))]
}

fn reach(a: &Analysis, out: &mut Vec<Block>) {
    section(out, "What the inputs reach");
    out.push(Block::Paragraph(vec![
        text("Dimension of the span of all iterated brackets of "),
        math("f, g_1, \\dots"),
        text(" (accessible: the set reached up to some time) and of those that contain an input field (strongly accessible: the set reached at a given time), out of "),
        math(a.states.to_string()),
        text(". The growth gives the dimension after each round of brackets."),
    ]));
    let header = ["", "accessible", "growth", "strongly accessible", "growth"].map(|h| vec![text(h)]).to_vec();
    let report = &a.report;
    let mut rows: Vec<Vec<Line>> = report.modes.iter().map(|m| rank_row(mode_name(m), &m.dimensions)).collect();
    if let Some(s) = &report.switched {
        rows.push(rank_row(vec![text("all modes together")], &s.dimensions));
    }
    if let Some(s) = &report.smoothed {
        rows.push(rank_row(vec![text("smoothed, width "), math(s.epsilon.to_string())], &s.dimensions));
    }
    if let Some(Answer::Known(p)) = &report.at_point {
        rows.push(rank_row(vec![text("at the point")], &p.dimensions));
    }
    out.push(Block::Table(header, rows));
    brackets(a, out);
    algebra(a, out);
    let alike = |m: &ModeReport| {
        let first = &report.modes[0];
        m.autonomous == first.autonomous && m.autonomous_not_found == first.autonomous_not_found
    };
    match &report.modes[..] {
        [first, _, ..] if report.modes.iter().all(alike) => autonomous(vec![text("In every mode")], first, out),
        modes => modes.iter().for_each(|m| autonomous(capital(mode_name(m)), m, out)),
    }
    by_switching(a, out);
}

/// The brackets that span what is reached, and those that were asked for.
fn brackets(a: &Analysis, out: &mut Vec<Block>) {
    let report = &a.report;
    let mut items = Vec::new();
    let mut spanned = |what: Line, d: &Dimensions| {
        if !d.basis.is_empty() {
            let list: Vec<String> = d.basis.iter().map(bracket).collect();
            items.push([what, vec![text(": "), math(list.join(",\\ "))]].concat());
        }
    };
    for (k, m) in report.modes.iter().enumerate() {
        // Modes that are spanned alike are told once.
        if report.modes[..k].iter().all(|other| other.dimensions.basis != m.dimensions.basis) {
            spanned(mode_name(m), &m.dimensions);
        }
    }
    if let Some(d) = &report.switched {
        spanned(vec![text("all modes together (upper numbers: the mode)")], &d.dimensions);
    }
    if let Some(s) = &report.smoothed {
        spanned(vec![text("smoothed")], &s.dimensions);
    }
    if !items.is_empty() {
        out.push(words("Brackets that span it:"));
        out.push(Block::List(items));
    }
    let asked: Vec<String> = report
        .brackets
        .iter()
        .filter_map(|b| {
            let components: Vec<String> = b.components.known()?.iter().map(function).collect();
            Some(format!("{} &= {}", bracket(&b.bracket), column(&components)))
        })
        .collect();
    if !asked.is_empty() {
        out.push(words("Requested brackets:"));
        out.push(Block::Display(asked));
    }
}

fn capital(mut line: Line) -> Line {
    if let Some(Span::Text(t)) = line.first_mut()
        && let Some(first) = t.get(..1).map(str::to_uppercase)
    {
        t.replace_range(..1, &first);
    }
    line
}

/// The functions that no input influences `when` a mode lasts.
fn autonomous(when: Line, m: &ModeReport, out: &mut Vec<Block>) {
    let mut line = when;
    match &m.autonomous {
        Answer::Known(functions) if functions.is_empty() && m.autonomous_not_found.is_none() => return,
        Answer::Known(functions) => {
            line.push(text(", no input influences "));
            line.extend(listed(functions.iter().map(function)));
            if let Some(k) = m.autonomous_not_found {
                let and = if functions.is_empty() { "" } else { " and " };
                line.push(text(format!("{and}{k} independent functions that were not found in closed form")));
            }
            line.push(text("."));
        }
        Answer::Unknown(why) => line.push(text(format!(", what no input influences is unknown ({why})."))),
    }
    out.push(Block::Paragraph(line));
}

/// What single modes leave alone and switching between them reaches.
fn by_switching(a: &Analysis, out: &mut Vec<Block>) {
    let Some(switched) = &a.report.switched else { return };
    out.push(words(format!(
        "Theorem for all modes together: {}; for strong accessibility: {}.",
        switched.accessible_by, switched.strongly_accessible_by
    )));
    match &switched.only_by_switching {
        Answer::Known(list) if list.is_empty() => {}
        Answer::Known(list) => {
            let row = |s: &Switchable| {
                let modes: Vec<String> = s.modes.iter().map(ToString::to_string).collect();
                vec![
                    vec![math(function(&s.function))],
                    vec![text(modes.join(", "))],
                    vec![code(s.reached_by.to_string())],
                ]
            };
            let header = ["reached only by switching", "not reached in modes", "reached first by"];
            out.push(Block::Table(header.map(|h| vec![text(h)]).to_vec(), list.iter().map(row).collect()));
        }
        Answer::Unknown(why) => out.push(words(format!("What only switching reaches is unknown ({why})."))),
    }
}

/// The Lie algebra over the constants, where it is finite-dimensional.
fn algebra(a: &Analysis, out: &mut Vec<Block>) {
    if let Some(algebra) = &a.report.lie_algebra {
        out.push(words(format!("Lie algebra generated by the fields: {}.", lie_algebra(algebra))));
    }
}

fn certificate(a: &Analysis, out: &mut Vec<Block>) {
    section(out, "Certificate");
    let c = &a.report.certificate;
    let time = format!("{:.3} s", a.report.seconds);
    if c.decisions() == 0 {
        out.push(words(format!("No test was needed; {time}.")));
        return;
    }
    out.push(Block::Paragraph(vec![
        text("Zero and rank are decided exactly modulo the prime "),
        math("2^{61}-1"),
        text(format!(
            " at {} random point{}; the probability that any of the {} decisions is wrong is ",
            c.points(),
            if c.points() == 1 { "" } else { "s" },
            c.decisions()
        )),
        code(c.error_text()),
        text(format!(". {time}.")),
    ]));
}
