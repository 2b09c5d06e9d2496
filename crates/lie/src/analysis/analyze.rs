//! The whole analysis of a control-affine system.

use std::time::Instant;

use bracketry_symbolic::{Expr, Pool};
use bracketry_system::System;

use crate::algebra::closure::Closure;
use crate::algebra::field::VectorFields;
use crate::algebra::integrals::search::Among;
use crate::algebra::word::generator_names;
use crate::analysis::brackets;
use crate::analysis::report::{ModeReport, Report, SmoothedReport};
use crate::answer::Answer;
use crate::budget::{check_analysis, release};
use crate::controllability::accessibility::Reach;
use crate::controllability::point::{PointReport, Regime, Subject, of_smoothed, point_report, regime};
use crate::controllability::switched::switched_report;
use crate::error::Error;
use crate::evidence::Evidence;
use crate::feedback::report::{ControlReport, control_report};
use crate::feedback::static_linearization::LinearizationFlag;
use crate::modes::{ModeFields, mode_fields};
use crate::named::Named;
use crate::observability::report::{read_functions, report};
use crate::options::Options;
use crate::undecided::Undecided;

/// Analyzes a system that is affine in its inputs (see `System::affinize`).
///
/// Statements at the point are made of the mode that holds there; where a switching function
/// vanishes at the point, of the smoothed model.
///
/// # Errors
/// [`Error::NotAffine`], [`Error::NoStates`], [`Error::Modes`], [`Error::Bracket`], [`Undecided::Stopped`] once the stop flag
/// of the system's pool is raised; what an exact test cannot decide becomes an unknown of the report instead.
pub fn analyze(system: &System, options: &Options) -> Result<Report, Error> {
    let begin = Instant::now();
    let mut evidence = Evidence::default();
    let mut system = system.clone();
    let asked = read_functions(&mut system, &options.determined)?;
    let words = brackets::read(&system, &options.brackets)?;
    for name in options.ranges.iter().map(|r| &r.0).chain(options.one_sided.iter().map(|o| &o.0)) {
        if !system.inputs.iter().any(|&u| system.pool.name(u) == name) {
            return Err(Error::UnknownInput { name: name.clone() });
        }
    }
    let modes = mode_fields(&mut system)?;
    let smooth = modes.len() == 1 && modes[0].signs.is_empty();
    let pool = &mut system.pool;
    let first = pool.made();
    let reach: Vec<Reach> = modes.iter().map(|m| Reach::of(pool, &m.fields, first, &mut evidence)).collect();
    let flags: Vec<Result<LinearizationFlag, Undecided>> = modes
        .iter()
        .map(|m| check_analysis(pool, first).and_then(|()| m.fields.linearization_flag(pool, &mut evidence)))
        .collect();
    let (mut mode_reports, autonomous): (Vec<ModeReport>, Vec<Vec<Expr>>) = modes
        .iter()
        .zip(reach.iter().zip(&flags))
        .map(|(m, (r, flag))| {
            let before = pool.len();
            let (report, mut functions) = mode_report(pool, m, r, flag, first, &mut evidence);
            release(pool, before, std::slice::from_mut(&mut functions));
            (report, functions)
        })
        .unzip();
    if !smooth {
        for (mode, report) in modes.iter().zip(&mut mode_reports) {
            report.brackets = brackets::components(pool, &mode.fields, &words);
        }
    }
    let switched = if smooth {
        None
    } else {
        let before = pool.len();
        let family: Vec<VectorFields> = modes.iter().map(|m| m.fields.clone()).collect();
        let all = VectorFields::switched(pool, &family)?;
        let names = brackets::family_names(pool, &family, &all);
        let together = Reach::of(pool, &all, first, &mut evidence);
        let dimensions = together.dimensions(&names);
        let strong = together.strong.as_ref();
        let report = switched_report(pool, dimensions, &all, strong, &names, &autonomous, &mut evidence);
        release(pool, before, &mut []);
        Some(report)
    };
    let (control, degree) = if smooth {
        let strong = reach[0].strong.as_ref().ok().map(Closure::dimension);
        control_report(&mut system, &modes[0].fields, &flags[0], strong, first, &mut evidence)
    } else {
        (ControlReport::default(), None)
    };
    let mut smoothed_system = None;
    let smoothed = if smooth {
        None
    } else {
        let width = system.pool.rational(options.epsilon.clone());
        let mut s = system.smoothed(width);
        let mut modes = mode_fields(&mut s)?;
        let fields = modes.remove(0).fields;
        let reach = Reach::of(&mut s.pool, &fields, first, &mut evidence);
        let dimensions = reach.dimensions(&generator_names(fields.controls.len()));
        smoothed_system = Some((s, fields, reach));
        Some(SmoothedReport { epsilon: options.epsilon.to_f64().value(), dimensions })
    };
    let names: Vec<String> = system.inputs.iter().map(|&u| system.pool.name(u).to_owned()).collect();
    let at_point: Option<Answer<PointReport>> = match &system.point.clone() {
        None => None,
        Some(point) => Some(match (regime(&mut system, point, &modes), &mut smoothed_system) {
            (Ok(Regime::Mode(mode)), _) => {
                let fields = &modes[mode].fields;
                let pool = &mut system.pool;
                let mut report = point_report(pool, fields, &names, &reach[mode], point, options, &mut evidence);
                if let (Ok(report), Some(degree)) = (&mut report, &degree) {
                    let rank = degree.rank_at(pool, fields, &point.states, &mut evidence);
                    report.relative_degree_defined = Some(rank.map(|rank| rank == degree.degrees.len()).into());
                }
                report.into()
            }
            (Ok(Regime::Switching(vanishing)), Some((s, fields, reach))) => {
                smoothed_point(s, fields, &names, reach, options, vanishing, &mut evidence)
            }
            // Smooth but where a unit vector vanishes, as it does here.
            (Ok(Regime::Switching(vanishing)), None) => {
                let width = system.pool.rational(options.epsilon.clone());
                let mut s = system.smoothed(width);
                let fields = mode_fields(&mut s)?.remove(0).fields;
                let reach = Reach::of(&mut s.pool, &fields, first, &mut evidence);
                smoothed_point(&mut s, &fields, &names, &reach, options, vanishing, &mut evidence)
            }
            (Err(why), _) => Answer::Unknown(why.to_string()),
        }),
    };
    let marks = (system.pool.len(), smoothed_system.as_ref().map_or(0, |s| s.0.pool.len()));
    let observability = if system.outputs.is_empty() {
        None
    } else {
        Some(match &mut smoothed_system {
            Some((s, fields, _)) => report(s, fields, &[], &asked, &mut evidence),
            None => report(&mut system, &modes[0].fields, &[], &asked, &mut evidence),
        })
    };
    let (involutive, linearizable) = match &mut smoothed_system {
        Some((s, fields, _)) => (
            check_analysis(&s.pool, first).and_then(|()| fields.is_involutive(&mut s.pool, &mut evidence)).into(),
            check_analysis(&s.pool, first)
                .and_then(|()| fields.static_feedback_linearizable(&mut s.pool, &mut evidence))
                .into(),
        ),
        None => (mode_reports[0].involutive.clone(), mode_reports[0].static_feedback_linearizable.clone()),
    };
    let involutive_closure = match &mut smoothed_system {
        // Smoothed signs have no elementary integrals in general.
        Some((s, fields, _)) => check_analysis(&s.pool, first)
            .and_then(|()| fields.involutive_closure_report(&mut s.pool, Among::States, &mut evidence)),
        None => check_analysis(&system.pool, first)
            .and_then(|()| modes[0].fields.involutive_closure_report(&mut system.pool, Among::All, &mut evidence)),
    };
    release(&mut system.pool, marks.0, &mut []);
    if let Some((s, ..)) = &mut smoothed_system {
        release(&mut s.pool, marks.1, &mut []);
    }
    let brackets = match &mut smoothed_system {
        Some((s, fields, _)) => brackets::components(&mut s.pool, fields, &words),
        None => brackets::components(&mut system.pool, &modes[0].fields, &words),
    };
    let lie_algebra = if smooth {
        check_analysis(&system.pool, first)
            .and_then(|()| modes[0].fields.lie_algebra(&mut system.pool, &options.limits, &mut evidence))
            .unwrap_or_default()
    } else {
        None
    };
    // Whatever is unknown now, it is not for a reason of its own.
    if system.pool.stop_flag().is_raised() {
        return Err(Undecided::Stopped.into());
    }
    Ok(Report {
        modes: mode_reports,
        switched,
        smoothed,
        at_point_reason: at_point.as_ref().and_then(Answer::reason).map(str::to_owned),
        at_point,
        global_statements_of: (!smooth).then_some(Subject::Smoothed),
        lie_algebra,
        involutive,
        involutive_closure: involutive_closure.into(),
        static_feedback_linearizable: linearizable,
        control,
        observability,
        brackets,
        certificate: evidence,
        seconds: begin.elapsed().as_secs_f64(),
    })
}

/// The statements at the point of a smoothed model.
fn smoothed_point(
    smoothed: &mut System,
    fields: &VectorFields,
    names: &[String],
    reach: &Reach,
    options: &Options,
    vanishing: Vec<String>,
    evidence: &mut Evidence,
) -> Answer<PointReport> {
    match smoothed.point.clone() {
        Some(point) => point_report(&mut smoothed.pool, fields, names, reach, &point, options, evidence)
            .map(|p| of_smoothed(p, vanishing, &options.epsilon))
            .into(),
        None => Answer::Unknown("the smoothed model has no point".to_owned()),
    }
}

/// The report on a mode, with the functions that no input influences there.
fn mode_report(
    pool: &mut Pool,
    mode: &ModeFields,
    reach: &Reach,
    flag: &Result<LinearizationFlag, Undecided>,
    first: usize,
    evidence: &mut Evidence,
) -> (ModeReport, Vec<Expr>) {
    let strong = reach.strong.as_ref().map_err(Clone::clone);
    let found = strong.and_then(|s| mode.fields.autonomous(pool, &s.basis, evidence));
    let missing = found.as_ref().map_or(0, |a| a.missing);
    let functions = found.as_ref().map(|a| a.functions.clone()).unwrap_or_default();
    let report = ModeReport {
        signs: Named(mode.signs.clone()),
        dimensions: reach.dimensions(&generator_names(mode.fields.controls.len())),
        autonomous: found.map(|a| a.functions.iter().map(|&e| pool.text(e)).collect::<Vec<_>>()).into(),
        autonomous_not_found: (missing > 0).then_some(missing),
        involutive: check_analysis(pool, first).and_then(|()| mode.fields.is_involutive(pool, evidence)).into(),
        static_feedback_linearizable: flag.as_ref().map(LinearizationFlag::linearizable).into(),
        brackets: Named(Vec::new()),
    };
    (report, functions)
}
