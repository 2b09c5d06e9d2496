//! The analysis as plain text.

use std::fmt::{self, Write as _};

use bracketry_lie::algebra::{Bracket, LieAlgebra};
use bracketry_lie::analysis::{Dimensions, Family, ModeReport, RequestedBracket};
use bracketry_lie::controllability::{
    InvolutiveClosureReport, PointReport, Subject, SwitchedReport, UncontrollableMode,
};
use bracketry_lie::observability::{Direction, ObservabilityReport, Undetermined};
use bracketry_lie::{Analysis, Answer, Function, Named, Report};

use super::affinization::changes;
use super::feedback_text::feedback;
use super::lists::joined;
use super::summary::{summary, wrapped};

/// The whole analysis.
pub fn text(analysis: &Analysis) -> String {
    let mut out = String::new();
    // Writing to a string does not fail.
    let _ = whole(&mut out, analysis);
    out
}

/// Ranks, growth vectors and verdicts of an affine system.
pub fn report_text(r: &Report) -> String {
    let mut out = String::new();
    let _ = report(&mut out, r);
    out
}

fn whole(f: &mut String, a: &Analysis) -> fmt::Result {
    writeln!(f, "{}", a.model)?;
    writeln!(f, "affine form: {}", a.affinization.why)?;
    let model = &a.affinization.system;
    let plural = |k: usize| if k == 1 { "" } else { "s" };
    writeln!(f, "  {} state{}: {}", a.states, plural(a.states), model.state_names().join(", "))?;
    if a.inputs == 0 {
        writeln!(f, "  no inputs")?;
    } else {
        writeln!(f, "  {} input{}: {}", a.inputs, plural(a.inputs), model.input_names().join(", "))?;
    }
    if let Some(r) = &a.family {
        writeln!(f, "  {}", family(r))?;
    }
    for change in changes(&a.affinization) {
        writeln!(f, "  {change}")?;
    }
    for eliminated in &model.eliminated {
        writeln!(f, "  note: {eliminated}")?;
    }
    for (s, e) in model.states.iter().zip(&model.dynamics) {
        writeln!(f, "  {}' = {}", model.pool.name(*s), model.pool.text(*e))?;
    }
    report(f, &a.report)?;
    writeln!(f)?;
    for line in wrapped(&summary(a), 110) {
        writeln!(f, "{line}")?;
    }
    Ok(())
}

fn report(f: &mut String, r: &Report) -> fmt::Result {
    if r.modes.iter().any(|m| m.signs.0.len() > 1) {
        writeln!(f, "modes are combinations of signs; whether each occurs is not checked")?;
    }
    // Modes that agree in everything but their signs are told together.
    let mut told: Vec<&ModeReport> = Vec::new();
    for mode in &r.modes {
        let same = |o: &&ModeReport| {
            o.dimensions == mode.dimensions
                && o.autonomous == mode.autonomous
                && o.involutive == mode.involutive
                && o.static_feedback_linearizable == mode.static_feedback_linearizable
                && o.brackets == mode.brackets
        };
        if told.iter().any(same) {
            continue;
        }
        told.push(mode);
        self::mode(f, mode)?;
        let others = r.modes.iter().filter(|o| same(o)).count() - 1;
        match others {
            0 => {}
            1 => writeln!(f, "  the same in 1 other mode")?,
            _ => writeln!(f, "  the same in {others} other modes")?,
        }
    }
    if let Some(d) = &r.switched {
        writeln!(f, "switching between all modes")?;
        switched(f, d)?;
    }
    if let Some(s) = &r.smoothed {
        writeln!(f, "smoothed, width {}", s.epsilon)?;
        dimensions(f, &s.dimensions)?;
    }
    match &r.at_point {
        Some(Answer::Known(p)) => {
            write!(f, "at the point of the model")?;
            if let Some(width) = p.epsilon {
                let verb = if p.vanishing.len() == 1 { "vanishes" } else { "vanish" };
                let vanishing = joined(&p.vanishing, ", ");
                write!(f, " ({vanishing} {verb} there); dimensions and linear statements smoothed with width {width}")?;
            }
            writeln!(f)?;
            point(f, p)?;
        }
        Some(Answer::Unknown(why)) => writeln!(f, "at the point of the model: unknown ({why})")?,
        None => {}
    }
    let of = if r.global_statements_of == Some(Subject::Smoothed) { "smoothed model: " } else { "" };
    if let Some(algebra) = &r.lie_algebra {
        writeln!(f, "Lie algebra: {}", lie_algebra(algebra))?;
    }
    writeln!(f, "{of}input fields involutive: {}", yes_no(&r.involutive))?;
    if !matches!(r.involutive, Answer::Known(true)) {
        let closure = match &r.involutive_closure {
            Answer::Known(closure) => involutive_closure(closure),
            Answer::Unknown(why) => format!("unknown ({why})"),
        };
        writeln!(f, "{of}involutive closure of the input fields: {closure}")?;
    }
    writeln!(
        f,
        "{of}linearizable by static feedback near a generic point: {}",
        yes_no(&r.static_feedback_linearizable)
    )?;
    feedback(f, &r.control)?;
    if let Some(o) = &r.observability {
        observability(f, o, of)?;
    }
    if !r.brackets.is_empty() {
        writeln!(f, "{of}brackets")?;
        brackets(f, &r.brackets)?;
    }
    if r.decided() && r.certificate.decisions() > 0 {
        let points = r.certificate.points();
        let noun = if points == 1 { "point" } else { "points" };
        let error = r.certificate.error_text();
        write!(f, "exact modulo 2^61-1 at {points} {noun}, error probability {error}; ")?;
    }
    writeln!(f, "{:.3} s", r.seconds)
}

fn mode(f: &mut String, r: &ModeReport) -> fmt::Result {
    if r.signs.0.is_empty() {
        writeln!(f, "at a generic point")?;
    } else {
        writeln!(f, "while {}", r.signs.condition())?;
    }
    dimensions(f, &r.dimensions)?;
    match &r.autonomous {
        Answer::Known(list) => {
            if !list.is_empty() {
                writeln!(f, "  no input influences    {}", joined(list, ",  "))?;
            }
            match r.autonomous_not_found {
                None => {}
                Some(1) => writeln!(f, "  and 1 more independent function, not found in closed form")?,
                Some(k) => {
                    writeln!(f, "  and {k} more independent functions, not found in closed form")?;
                }
            }
        }
        Answer::Unknown(why) => writeln!(f, "  no input influences    unknown ({why})")?,
    }
    if !r.signs.0.is_empty() {
        writeln!(f, "  involutive inputs      {}", yes_no(&r.involutive))?;
        writeln!(f, "  feedback linearizable  {}", yes_no(&r.static_feedback_linearizable))?;
    }
    brackets(f, &r.brackets)
}

fn switched(f: &mut String, r: &SwitchedReport) -> fmt::Result {
    dimensions(f, &r.dimensions)?;
    if r.accessible_by == r.strongly_accessible_by {
        writeln!(f, "  theorem                {}", r.accessible_by)?;
    } else {
        writeln!(f, "  theorem                {}; strongly: {}", r.accessible_by, r.strongly_accessible_by)?;
    }
    match &r.autonomous {
        Answer::Known(list) if !list.is_empty() => writeln!(f, "  nothing influences     {}", joined(list, ",  "))?,
        Answer::Known(_) => {}
        Answer::Unknown(why) => writeln!(f, "  nothing influences     unknown ({why})")?,
    }
    if let Some(k) = r.autonomous_not_found {
        let noun = if k == 1 { "function that was" } else { "functions that were" };
        writeln!(f, "  and {k} further independent {noun} not found in closed form")?;
    }
    match &r.only_by_switching {
        Answer::Known(list) => {
            for s in list {
                writeln!(f, "  only by switching      {}: by {}", s.function, s.reached_by)?;
            }
        }
        Answer::Unknown(why) => writeln!(f, "  only by switching      unknown ({why})")?,
    }
    Ok(())
}

fn point(f: &mut String, r: &PointReport) -> fmt::Result {
    dimensions(f, &r.dimensions)?;
    point_facts(r).into_iter().try_for_each(|(what, said)| writeln!(f, "  {what:<22} {said}"))
}

/// What holds at a point: what, and the answer. What belongs to the fact before is indented.
pub(super) fn point_facts(r: &PointReport) -> Vec<(&'static str, String)> {
    let mut facts = vec![("equilibrium", format!("{}{}", yes_no(&r.equilibrium), outside(r)))];
    facts.extend(r.linear_controllability_rank.map(|rank| ("linear rank", rank.to_string())));
    if let Some(s) = &r.stabilizable {
        let why = r.stabilizable_reason.as_ref().filter(|_| s.known().is_some());
        let said = format!("{}{}", yes_no(s), why.map_or(String::new(), |w| format!(": {w}")));
        facts.push(("stabilizable", said));
    }
    if let Some(modes) = r.uncontrollable_modes.as_ref().and_then(Answer::known).filter(|m| !m.is_empty()) {
        let modes: Vec<String> = modes.iter().map(eigenvalue).collect();
        facts.push(("uncontrollable modes", modes.join(";  ")));
    }
    if let Some(brockett) = &r.brockett_condition {
        let what = match brockett {
            Answer::Known(true) => "holds".to_owned(),
            Answer::Known(false) => "fails: no continuous state feedback stabilizes".to_owned(),
            Answer::Unknown(why) => format!("unknown ({why})"),
        };
        facts.push(("Brockett's condition", what));
    }
    facts.push(("small-time control", format!("{}: {}", r.stlc.verdict, r.stlc.reason)));
    let bounded = r.stlc.bounded.as_ref();
    facts.extend(bounded.map(|b| ("  bounded inputs", format!("{}: {}", b.verdict, b.reason))));
    let smoothed = r.smoothed_stlc.as_ref();
    facts.extend(smoothed.map(|s| ("  smoothed model", format!("{}: {}", s.verdict, s.reason))));
    facts.extend(r.relative_degree_defined.as_ref().map(|defined| ("vector relative degree", yes_no(defined))));
    facts
}

/// Why a point at which the right-hand side vanishes may be no equilibrium.
pub(crate) fn outside(r: &PointReport) -> String {
    match &r.outside_ranges[..] {
        [] => String::new(),
        [name] => format!(": the value of {name} at the point is outside of its range"),
        names => format!(": the values of {} at the point are outside of their ranges", names.join(", ")),
    }
}

fn dimensions(f: &mut String, r: &Dimensions) -> fmt::Result {
    dimension_line(f, "accessible", &r.accessible_dimension, &r.growth)?;
    span_line(f, &r.basis)?;
    dimension_line(f, "strongly accessible", &r.strongly_accessible_dimension, &r.strong_growth)?;
    if r.strong_basis != r.basis {
        span_line(f, &r.strong_basis)?;
    }
    match &r.growth_reason {
        Some(why) => {
            writeln!(f, "    by a controllable linearization at an equilibrium; the brackets were not closed ({why})")
        }
        None => Ok(()),
    }
}

/// The family of constant inputs beside the affine form.
pub(crate) fn family(r: &Family) -> String {
    let states = match r.integrators {
        0 => String::new(),
        1 => " with 1 more state".to_owned(),
        n => format!(" with {n} more states"),
    };
    let agrees = match &r.agrees {
        Answer::Known(true) => "agrees".to_owned(),
        Answer::Known(false) => "does not agree".to_owned(),
        Answer::Unknown(why) => format!("was not compared ({why})"),
    };
    format!(
        "family of constant inputs: accessible dimension {}, strongly accessible dimension {}; the affine form{states} {agrees}",
        r.accessible_dimension, r.strongly_accessible_dimension,
    )
}

fn eigenvalue(m: &UncontrollableMode) -> String {
    let imaginary = if m.im == 0.0 { String::new() } else { format!("{:+.6}i", m.im) };
    let times = if m.multiplicity > 1 { format!(" ({} times)", m.multiplicity) } else { String::new() };
    let along =
        if m.combinations.is_empty() { String::new() } else { format!(" along {}", joined(&m.combinations, ", ")) };
    let real = if m.re == 0.0 { "0".to_owned() } else { format!("{:.6}", m.re) };
    format!("{real}{imaginary}{times}{along}")
}

fn involutive_closure(r: &InvolutiveClosureReport) -> String {
    let integrals = if r.integrals.is_empty() {
        String::new()
    } else {
        format!(", functions constant along it: {}", joined(&r.integrals, ",  "))
    };
    let missing = r.integrals_not_found.map_or(String::new(), |k| {
        let which = if r.integrals.is_empty() { "of the functions constant along it" } else { "more" };
        format!(", {k} {which} not found in closed form")
    });
    format!("dimension {} (growth {}){integrals}{missing}", r.dimension, joined(&r.growth, ", "))
}

/// The Lie algebra over the constants.
pub(crate) fn lie_algebra(r: &LieAlgebra) -> String {
    let nilpotent = match r.nilpotent_length {
        Some(k) => format!("nilpotent: brackets longer than {k} vanish"),
        None => "not nilpotent".to_owned(),
    };
    format!("dimension {} over the constants, {nilpotent}", r.dimension)
}

fn direction(d: &Direction) -> String {
    d.symmetry.as_ref().map_or_else(|| d.field.to_string(), |s| format!("{} ({s})", d.field))
}

pub(crate) fn yes_no(answer: &Answer<bool>) -> String {
    match answer {
        Answer::Known(true) => "yes".to_owned(),
        Answer::Known(false) => "no".to_owned(),
        Answer::Unknown(why) => format!("unknown ({why})"),
    }
}

/// A dimension among n, with the growth that leads to it.
fn dimension_line(f: &mut String, label: &str, dimension: &Answer<usize>, growth: &[usize]) -> fmt::Result {
    let mut list: Vec<String> = growth.iter().map(ToString::to_string).collect();
    if list.len() > MAX_GROWTH {
        list.splice(MAX_GROWTH - 1..list.len() - 1, ["…".to_owned()]);
    }
    write!(f, "  {label:<22} {dimension}")?;
    if !list.is_empty() {
        write!(f, "   (growth {})", joined(&list, ", "))?;
    }
    writeln!(f)
}

/// A longer list of growing dimensions is told in part.
const MAX_GROWTH: usize = 24;

/// More names than this are told in part.
const MAX_NAMES: usize = 16;

/// The brackets that a dimension counts.
fn span_line(f: &mut String, basis: &[Bracket]) -> fmt::Result {
    if basis.is_empty() {
        return Ok(());
    }
    let told = &basis[..basis.len().min(MAX_NAMES)];
    let rest = if told.len() < basis.len() { ", …" } else { "" };
    writeln!(f, "    spanned by           {}{rest}", joined(told, ", "))
}

fn brackets(f: &mut String, brackets: &[RequestedBracket]) -> fmt::Result {
    for RequestedBracket { name, components, .. } in brackets {
        match components {
            Answer::Known(list) => {
                let list: Vec<String> = list.iter().map(Function::text).collect();
                writeln!(f, "  {name} = ({})", list.join(", "))?;
            }
            Answer::Unknown(why) => writeln!(f, "  {name} = unknown ({why})")?,
        }
    }
    Ok(())
}

/// What the outputs tell, naming the model that it is `of`.
fn observability(f: &mut String, r: &ObservabilityReport, of: &str) -> fmt::Result {
    writeln!(f, "{of}observability rank: {}", r.rank)?;
    outputs_tell(r).iter().try_for_each(|said| writeln!(f, "  {said}"))
}

/// What the outputs tell beside the rank, a line each.
pub(super) fn outputs_tell(r: &ObservabilityReport) -> Vec<String> {
    let mut out = Vec::new();
    if !r.unobservable.is_empty() {
        out.push(format!("not determined by the outputs: {}", joined(&r.unobservable, ", ")));
    }
    for d in &r.unobservable_directions {
        out.push(format!("no output changes along {}", direction(d)));
    }
    for (name, yes) in r.identifiable.iter().flat_map(|m| &m.0) {
        out.push(format!("parameter {name}: {}", if *yes { "locally identifiable" } else { "not identifiable" }));
    }
    if let Some(Undetermined { names, reason }) = &r.undecided_parameters {
        let noun = if names.len() == 1 { "parameter" } else { "parameters" };
        out.push(format!("{noun} {}: identifiability unknown ({reason})", joined(names, ", ")));
    }
    let hidden = |list: &Option<Named<bool>>| -> Vec<String> {
        list.iter().flat_map(|m| &m.0).filter(|v| !v.1).map(|v| v.0.clone()).collect()
    };
    let states = hidden(&r.identifiable_states);
    if !states.is_empty() {
        out.push(format!("states not determined while parameters are unknown: {}", joined(&states, ", ")));
    }
    if r.identifiable_without_inputs != r.identifiable {
        let names = hidden(&r.identifiable_without_inputs);
        if !names.is_empty() {
            out.push(format!("not identifiable with all inputs at zero: {}", joined(&names, ", ")));
        }
    }
    if let Some(why) = &r.undecided_without_inputs {
        out.push(format!("identifiability with all inputs at zero: unknown ({why})"));
    }
    for d in r.unidentifiable_directions.iter().filter(|d| !r.unobservable_directions.contains(d)) {
        out.push(format!("while parameters are unknown, no output changes along {}", direction(d)));
    }
    if let Some(why) = &r.undecided_directions {
        out.push(format!("directions along which no output changes: unknown ({why})"));
    }
    if let Some(fix) = &r.fix_to_identify {
        out.push(format!("to make all parameters locally identifiable, it suffices to know: {}", joined(fix, ", ")));
    }
    for (text, yes) in r.determined.iter().flat_map(|m| &m.0) {
        out.push(format!("{text}: {}", if *yes { "locally determined" } else { "not determined" }));
    }
    out
}
