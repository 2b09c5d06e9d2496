//! What a statement on the affine form says of the original.

use std::cmp::Ordering;

use bracketry_symbolic::{Bindings, Expr, Function, Rational, Symbol};
use bracketry_system::{Affinization, AtPoint, InputRange, Method, NewInput, Range, System};

use crate::analysis::report::Report;
use crate::answer::Answer;
use crate::controllability::input_values::{InputValues, Side};
use crate::controllability::point::PointReport;
use crate::controllability::stlc::{BoundedStlc, Stlc, Verdict};
use crate::feedback::flatness_report::{FlatnessReport, FlatnessVerdict};
use crate::feedback::ruled::{GeneralSystem, not_ruled};
use crate::options::AnalysisOptions;
use crate::reason::{FlatnessReason, Reason, StabilizableReason, StlcReason};

/// Most derivatives of a new input that are looked at.
const MAX_ORDER: usize = 7;

/// The options with what is known of the inputs of the affine form.
pub(crate) fn with_input_ranges(
    options: &AnalysisOptions,
    affinization: &Affinization,
    original: &System,
) -> AnalysisOptions {
    let mut options = options.clone();
    if affinization.method == Method::None {
        options.ranges.extend(declared(original));
        options.one_sided.extend(at_an_end(original));
    } else {
        options.one_sided.extend(one_sided(affinization));
        options.ranges.extend(ranges(affinization));
    }
    options
}

/// New inputs that can move from their value at the point to one side only, as u² can at u = 0.
fn one_sided(affinization: &Affinization) -> Vec<(String, Side)> {
    let side = |v: &NewInput| match v.at_point {
        AtPoint::AtLower => Some(Side::Above),
        AtPoint::AtUpper => Some(Side::Below),
        AtPoint::Interior | AtPoint::Unknown => None,
    };
    affinization.input_change.iter().filter_map(|v| Some((v.name.clone(), side(v)?))).collect()
}

/// The ranges of a model's inputs.
fn declared(system: &System) -> Vec<(String, InputValues)> {
    let end = |e: &Option<Rational>, open: f64| e.as_ref().map_or(open, |e| e.to_f64().value());
    let values = |r: &InputRange| InputValues::Between(end(&r.min, f64::NEG_INFINITY), end(&r.max, f64::INFINITY));
    system.input_ranges.iter().map(|r| (system.symbol_name(r.input).to_owned(), values(r))).collect()
}

/// Inputs whose value at the point is an end of their range.
fn at_an_end(system: &System) -> Vec<(String, Side)> {
    let Some((_, inputs)) = system.point_values() else { return Vec::new() };
    let side = |r: &InputRange| {
        let value = *inputs.get(system.inputs.iter().position(|u| *u == r.input)?)?;
        let is = |e: &Option<Rational>| e.as_ref().is_some_and(|e| e.to_f64().value() == value);
        match (is(&r.min), is(&r.max)) {
            (true, _) => Some(Side::Above),
            (_, true) => Some(Side::Below),
            _ => None,
        }
    };
    let ranges = system.input_ranges.iter();
    ranges.filter_map(|r| Some((system.symbol_name(r.input).to_owned(), side(r)?))).collect()
}

/// The values of the affine form's inputs that do not take all real numbers: images of the ranges of the old inputs, and
/// ranges of inputs that stay.
fn ranges(affinization: &Affinization) -> Vec<(String, InputValues)> {
    let values = |v: &NewInput| match &v.values {
        Range::Onto => None,
        Range::Interval { lower, upper } => {
            let lower = lower.as_ref().map_or(f64::NEG_INFINITY, |b| b.value);
            Some(InputValues::Between(lower, upper.as_ref().map_or(f64::INFINITY, |b| b.value)))
        }
        Range::Unknown { .. } => Some(InputValues::Unknown),
    };
    let new = affinization.input_change.iter().filter_map(|v| Some((v.name.clone(), values(v)?)));
    let mut all: Vec<(String, InputValues)> = new.collect();
    let stay = declared(&affinization.system).into_iter();
    all.extend(stay.filter(|(name, _)| affinization.input_change.iter().all(|v| v.name != *name)));
    all
}

/// Whether a positive verdict on the affine system, in which each new input takes the values of its range by itself,
/// transfers to the original: the values that the new inputs take together must contain what it was concluded from.
struct Transfer {
    /// From small feedback of the new inputs: together they take all values near those at the point.
    feedback: bool,
    /// From new inputs in their ranges.
    in_ranges: bool,
    /// From jumps along the fields of new inputs that take all real numbers.
    jumps: bool,
}

impl Transfer {
    fn of(affinization: &Affinization, original: &System, equilibrium: bool) -> Transfer {
        let new = &affinization.input_change;
        // Where the point is no equilibrium, other values than that at the point hold it.
        let free = new.is_empty() || affinization.interior_at_point == Some(true) && equilibrium;
        let chosen = affinization.candidates.iter().find(|c| c.chosen);
        let independent = new.len() == 1 || chosen.and_then(|c| c.independent_ranges) == Some(true);
        // At one end of a range the other end is taken to be far away.
        let seen = |v: &NewInput| match (v.at_point, &v.values) {
            (AtPoint::Interior, _) => true,
            (AtPoint::AtLower, Range::Interval { upper, .. }) => upper.is_none(),
            (AtPoint::AtUpper, Range::Interval { lower, .. }) => lower.is_none(),
            _ => false,
        };
        // Small feedback needs the values themselves, not mixtures of them over short times.
        let feedback = new.is_empty() || affinization.covers_at_point == Some(true) && equilibrium;
        let onto = independent && new.iter().all(|v| matches!(v.values, Range::Onto));
        // An integrator in front of an input with a range makes it a state that does not leave the range.
        let jumps = original.input_ranges.is_empty() && (new.is_empty() || onto);
        Transfer { feedback, in_ranges: free || independent && new.iter().all(seen), jumps }
    }
}

/// Where the new inputs do not cover what a positive conclusion was drawn from, as u² at u = 0, it is open; what is
/// negative even with more inputs stays.
pub(crate) fn withhold_local_verdicts(report: &mut Report, affinization: &Affinization, original: &System) {
    let Some(Answer::Known(point)) = &mut report.at_point else { return };
    let (why, transfer) = if let Some((input, _)) = at_an_end(original).into_iter().next() {
        // One-sided inputs are known to the verdict on the model itself, not to one on an affine form of it.
        let as_it_is = affinization.method == Method::None;
        let transfer = Transfer { feedback: false, in_ranges: as_it_is, jumps: as_it_is };
        (Reason::EndOfRange { input }, transfer)
    } else {
        let function = |v: &NewInput| Function::new(&affinization.system.pool, v.function);
        let inputs = affinization.input_change.iter().map(|v| (v.name.clone(), function(v))).collect();
        let transfer = Transfer::of(affinization, original, point.equilibrium == Answer::Known(true));
        (Reason::InputsNotFree { inputs }, transfer)
    };
    let transfers = match point.stlc.reason.of_what_is_left() {
        StlcReason::Jumps => transfer.jumps || affinization.method == Method::None,
        _ => transfer.in_ranges,
    };
    if point.stlc.verdict == Verdict::Yes && !transfers {
        point.stlc = Stlc::inconclusive(StlcReason::Withheld(why.clone()));
    }
    let finite = |u: &Symbol| original.input_ranges.iter().any(|r| r.input == *u && r.min.is_some() && r.max.is_some());
    let unbounded = !original.inputs.iter().all(finite);
    if !unbounded {
        // The values of new inputs may have no bounds, those of the model have.
        point.stlc.bounded = None;
    }
    let regular = affinization.regular_at_point == Some(true) || is_onto_nearby(affinization, original);
    if !affinization.input_change.is_empty() && !regular {
        // Values of the new inputs near those at the point may take old inputs far from theirs.
        let far = affinization.input_change.iter().any(|v| v.at_point == AtPoint::Interior)
            || point.stlc.reason.holds_elsewhere();
        if point.stlc.verdict == Verdict::Yes && point.stlc.bounded.is_none() && far && unbounded {
            let reason = StlcReason::Withheld(why.clone());
            point.stlc.bounded = Some(BoundedStlc { verdict: Verdict::Inconclusive, reason });
        }
        if let Some(brockett @ Answer::Known(true)) = &mut point.brockett_condition {
            *brockett = Answer::Unknown(why.clone());
        }
    }
    withhold_of_held_inputs(point, affinization, original);
    if let Some(smoothed) = point.smoothed_stlc.as_mut().filter(|s| s.verdict == Verdict::Yes && !transfer.in_ranges) {
        *smoothed = Stlc::inconclusive(StlcReason::Withheld(why.clone()));
    }
    if transfer.feedback {
        return;
    }
    let resting = match &point.stabilizable_reason {
        Some(StabilizableReason::Stable | StabilizableReason::StableByItself) => true,
        // Values inside of the ranges, from which feedback moves the inputs to both sides.
        Some(StabilizableReason::OtherInputs { .. }) => affinization.method == Method::None,
        _ => false,
    };
    if let Some(stabilizable @ Answer::Known(true)) = &mut point.stabilizable
        && !resting
    {
        *stabilizable = Answer::Unknown(why.clone());
        point.stabilizable_reason = None;
    }
    if let Some(brockett @ Answer::Known(true)) = &mut point.brockett_condition {
        *brockett = Answer::Unknown(why);
    }
}

/// An integrator that the model does not have keeps an input near its value at the point, from which the model lets it jump: what is
/// negative for all values of the inputs stays, unless the equations switch with an input and other values lead to another mode.
fn withhold_of_held_inputs(point: &mut PointReport, affinization: &Affinization, original: &System) {
    if affinization.integrators.is_empty() || !original.input_derivatives.is_empty() {
        return;
    }
    let mut switching = original.clone();
    let switches = switching.switched_form().switches;
    let used = switching.pool.symbols_of(&switches.iter().map(|s| s.surface).collect::<Vec<_>>());
    let one_mode = original.inputs.iter().any(|u| used.contains(u));
    let holds = |why: &StabilizableReason| {
        !one_mode
            && matches!(
                why,
                StabilizableReason::Leaves { .. }
                    | StabilizableReason::UnstableQuotient
                    | StabilizableReason::Conserved(_)
            )
    };
    let names: Vec<String> = affinization.integrators.keys().cloned().collect();
    let may_jump = || Reason::InputsMayJump { inputs: names.clone() };
    if point.stabilizable == Some(Answer::Known(false)) && !point.stabilizable_reason.as_ref().is_some_and(holds) {
        point.stabilizable = Some(Answer::Unknown(may_jump()));
        point.stabilizable_reason = None;
    }
    if one_mode && point.brockett_condition == Some(Answer::Known(false)) {
        point.brockett_condition = Some(Answer::Unknown(may_jump()));
    }
}

/// Whether one new input, a function of one old input alone, takes all values near that at the point for values of the old one near its own:
/// the first derivative that does not vanish is of odd order.
fn is_onto_nearby(affinization: &Affinization, original: &System) -> bool {
    let ([v], Some(point)) = (&affinization.input_change[..], &original.point) else { return false };
    let mut pool = affinization.system.pool.clone();
    let used: Vec<Symbol> = pool.symbols_of(&[v.function]);
    let named = |s: &Symbol| original.inputs.iter().position(|&u| original.symbol_name(u) == pool.name(*s));
    let [symbol] = used[..] else { return false };
    let Some(i) = named(&symbol) else { return false };
    let Ok(values) = pool.import(&original.pool.export(&[point.inputs[i]])) else { return false };
    let at = std::iter::once((pool.sym(symbol), values[0])).collect();
    let mut derivative = v.function;
    for order in 1..=MAX_ORDER {
        derivative = pool.diff(derivative, symbol);
        let here = pool.substitute(derivative, &at);
        match pool.constant_sign(here, &Bindings::new()) {
            Some(Ordering::Equal) => {}
            Some(_) => return order % 2 == 1,
            None => return false,
        }
    }
    false
}

/// What is known of the flatness of a model that is not affine: what holds for the affine form, if its new inputs are
/// independent functions of the old ones, unless the velocities of the model exclude it.
pub(crate) fn flatness_of_original(report: &mut Report, affinization: &Affinization, original: &System) {
    let Some(flatness) = &mut report.control.flatness else { return };
    if flatness.reason == FlatnessReason::NotAccessible {
        return;
    }
    let mut bindings = Bindings::new();
    for p in &original.parameters {
        bindings.bind(p.symbol, p.value.clone());
    }
    let general = GeneralSystem {
        states: original.states.clone(),
        inputs: original.inputs.clone(),
        dynamics: original.dynamics.clone(),
    };
    if flatness.verdict != FlatnessVerdict::No && not_ruled(&mut original.pool.clone(), &general, &bindings) {
        *flatness = FlatnessReport::without_outputs(FlatnessVerdict::No, FlatnessReason::NotRuled);
    } else if !new_inputs_independent(affinization) {
        *flatness = FlatnessReport::without_outputs(FlatnessVerdict::Unknown, FlatnessReason::DependentInputs);
    }
}

/// Whether the new inputs are independent functions of the old ones.
fn new_inputs_independent(affinization: &Affinization) -> bool {
    let mut pool = affinization.system.pool.clone();
    let functions: Vec<Expr> = affinization.input_change.iter().map(|v| v.function).collect();
    let states = &affinization.system.states;
    let old: Vec<Symbol> = pool.symbols_of(&functions).into_iter().filter(|s| !states.contains(s)).collect();
    let jacobian = pool.jacobian(&functions, &old);
    let parameters = affinization.system.parameters.iter();
    let mut bindings = Bindings::new();
    for p in parameters {
        bindings.bind(p.symbol, p.value.clone());
    }
    functions.is_empty() || pool.rank(&jacobian, &bindings).is_ok_and(|r| r.rank == functions.len())
}
