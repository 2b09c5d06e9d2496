//! The analysis of a control-affine system.

use std::time::Instant;

use bracketry_symbolic::{Expr, Function, Pool, Undecided as Exact};
use bracketry_system::System;

use crate::algebra::closure::Closure;
use crate::algebra::field::VectorFields;
use crate::algebra::integrals::search::Among;
use crate::algebra::word::generators;
use crate::analysis::brackets;
use crate::analysis::influence::{ReachTable, Reached, influence};
use crate::analysis::large::{MAX_STATES, large_report};
use crate::analysis::report::{Effort, ModeReport, Report, SmoothedReport};
use crate::answer::Answer;
use crate::budget::{check_analysis, release};
use crate::controllability::meeting::{AtSwitchPoint, only_bounded};
use crate::controllability::occurrence::Occurrence;
use crate::controllability::point::Vanishing;
use crate::controllability::point::{PointReport, Regime, Subject, of_smoothed, point_report, regime};
use crate::controllability::stlc::{BoundedStlc, Stlc, Verdict};
use crate::controllability::switch_point::of_modes;
use crate::controllability::switched::{AllModes, Invariant, SwitchedReport, switched_report};
use crate::controllability::uninfluenced::Reach;
use crate::error::Error;
use crate::evidence::Evidence;
use crate::feedback::relative_degree::RelativeDegree;
use crate::feedback::report::{ControlReport, control_report};
use crate::feedback::static_linearization::LinearizationFlag;
use crate::modes::Signs;
use crate::modes::{ModeFields, mode_fields};
use crate::observability::report::{read_functions, report};
use crate::options::AnalysisOptions;
use crate::reason::{Reason, StlcReason};
use crate::regular::regular_at;
use crate::undecided::Undecided;

/// Analyzes a system that is affine in its inputs (see `System::affinize`).
///
/// Statements at the point are made of the mode that holds there; where a switching function
/// vanishes at the point, of the smoothed model.
///
/// # Errors
/// [`Error::NotAffine`], [`Error::NoStates`], [`Error::Modes`], [`Error::Bracket`], [`Exact::Stopped`] once the stop flag
/// of the system's pool is raised; what an exact test cannot decide becomes an unknown of the report instead.
pub fn analyze_affine(system: &System, options: &AnalysisOptions) -> Result<Report, Error> {
    let start = Instant::now();
    let mut evidence = Evidence::default();
    let mut system = system.clone();
    system.pool.set_deadline(options.deadline(start, &system.pool));
    let asked = read_functions(&mut system, &options.determined)?;
    let words = brackets::read(&system, &options.brackets)?;
    check_inputs(&system, options)?;
    let modes = mode_fields(&mut system)?;
    if system.states.len() > MAX_STATES {
        return Ok(large_report(&mut system, &modes, start));
    }
    let smooth = modes.len() == 1 && modes[0].signs.0.is_empty();
    let pool = &mut system.pool;
    let first = pool.made();
    let point = system.point.as_ref().filter(|_| smooth);
    let reach: Vec<Reach> =
        modes.iter().map(|m| Reach::of_model(pool, &m.fields, point, first, &mut evidence)).collect();
    let flags: Vec<Result<LinearizationFlag, Undecided>> = modes
        .iter()
        .map(|m| check_analysis(pool, first).and_then(|()| m.fields.linearization_flag(pool, &mut evidence)))
        .collect();
    let (mut mode_reports, autonomous): (Vec<ModeReport>, Vec<Vec<Expr>>) = modes
        .iter()
        .zip(reach.iter().zip(&flags))
        .map(|(m, (r, flag))| mode_report(pool, m, r, flag, first, &mut evidence))
        .unzip();
    let (mut together, mut smoothed) = (None, None);
    let (mut control, mut degree) = (ControlReport::default(), None);
    if smooth {
        let strong = reach[0].strong.as_ref().ok().map(Closure::dimension);
        let parts = (first, options.flatness);
        (control, degree) = control_report(&mut system, &modes[0].fields, &flags[0], strong, parts, &mut evidence);
    } else {
        for (mode, report) in modes.iter().zip(&mut mode_reports) {
            report.brackets = brackets::components(pool, &mode.fields, &words);
        }
        together = Some(switching(pool, &modes, &reach, &autonomous, first, &mut evidence)?);
        smoothed = Some(Smoothed::of(&mut system, options, first, &mut evidence)?);
    }
    let smoothed_report = smoothed.as_ref().map(|s| s.report(options));
    let invariants = together.as_ref().map_or(&[][..], |t| &t.0.invariants);
    let over_all = together.as_ref().and_then(|t| t.0.dimensions.accessible_dimension.known().copied());
    let generic = Generic { modes: &modes, reach: &reach, over_all, degree: degree.as_ref(), invariants, first };
    let at_point = generic.at_point(&mut system, smoothed.as_mut(), options, &mut evidence)?;
    let (of, fields, among) = match &mut smoothed {
        // Smoothed signs have no elementary integrals in general.
        Some(s) => (&mut s.system, &s.fields, Among::States),
        None => (&mut system, &modes[0].fields, Among::All),
    };
    let before = of.pool.len();
    let observability = (!of.outputs.is_empty()).then(|| report(of, fields, &[], &asked, &mut evidence));
    let pool = &mut of.pool;
    let known = smooth.then(|| &mode_reports[0]);
    let (involutive, static_feedback_linearizable) = static_feedback(pool, fields, known, first, &mut evidence);
    let involutive_closure =
        check_analysis(pool, first).and_then(|()| fields.involutive_closure_report(pool, among, &mut evidence)).into();
    release(pool, before, &mut []);
    let brackets = brackets::components(pool, fields, &words);
    let algebra = smooth.then(|| check_analysis(pool, first));
    let algebra = algebra.map(|room| room.and_then(|()| fields.lie_algebra(pool, &options.limits, &mut evidence)));
    let (switched, rows) = together.unzip();
    let reach = reach_tables(&mut system.pool, &modes[0], &reach[0], &autonomous[0], &mode_reports, rows.flatten());
    let of_smoothed = smoothed.as_ref().map_or(0, |s| s.system.pool.made() - s.before);
    let expressions = system.pool.made() - first + of_smoothed;
    // Whatever is unknown now, it is not for a reason of its own.
    if system.pool.stop_flag().is_raised() {
        return Err(Undecided::from(Exact::Stopped).into());
    }
    Ok(Report {
        modes: mode_reports,
        switched,
        smoothed: smoothed_report,
        at_point_reason: at_point.as_ref().and_then(Answer::reason).cloned(),
        at_point,
        global_statements_of: (!smooth).then_some(Subject::Smoothed),
        lie_algebra: algebra.and_then(Result::unwrap_or_default),
        involutive,
        involutive_closure,
        static_feedback_linearizable,
        control,
        observability,
        brackets,
        reach,
        certificate: evidence,
        effort: Effort { expressions },
        seconds: start.elapsed().as_secs_f64(),
    })
}

/// Options name inputs of the system.
fn check_inputs(system: &System, options: &AnalysisOptions) -> Result<(), Error> {
    let names = system.input_names();
    let mut told = options.ranges.iter().map(|r| &r.0).chain(options.one_sided.iter().map(|o| &o.0));
    match told.find(|name| !names.contains(name)) {
        Some(name) => Err(Error::UnknownInput { name: name.clone() }),
        None => Ok(()),
    }
}

/// Whether the distribution of the inputs is involutive, and whether static feedback linearizes; the report of a single mode
/// knows it already.
fn static_feedback(
    pool: &mut Pool,
    fields: &VectorFields,
    known: Option<&ModeReport>,
    first: usize,
    evidence: &mut Evidence,
) -> (Answer<bool>, Answer<bool>) {
    if let Some(report) = known {
        return (report.involutive.clone(), report.static_feedback_linearizable.clone());
    }
    let involutive = check_analysis(pool, first).and_then(|()| fields.is_involutive(pool, evidence)).into();
    let linearizable =
        check_analysis(pool, first).and_then(|()| fields.static_feedback_linearizable(pool, evidence)).into();
    (involutive, linearizable)
}

/// What holds at almost every point.
struct Generic<'a> {
    modes: &'a [ModeFields],
    reach: &'a [Reach],
    /// Dimension that all modes reach together, where there are several and it is known.
    over_all: Option<usize>,
    /// Relative degree of a smooth system's outputs.
    degree: Option<&'a RelativeDegree>,
    /// Continuous functions that no mode changes.
    invariants: &'a [Invariant],
    /// Nodes of the pool when the analysis began.
    first: usize,
}

impl Generic<'_> {
    /// The statements at the point of the system; absent without one.
    fn at_point(
        &self,
        system: &mut System,
        smoothed: Option<&mut Smoothed>,
        options: &AnalysisOptions,
        evidence: &mut Evidence,
    ) -> Result<Option<Answer<PointReport>>, Error> {
        let Some(point) = system.point.clone() else { return Ok(None) };
        let regime = regime(system, &point, self.modes);
        let is_unit_vector = |v: &Vanishing| matches!(v, Vanishing::UnitVector(_));
        // A unit vector that vanishes has no value, but many.
        let many = matches!(&regime, Ok(Regime::Switching(vanishing)) if vanishing.iter().any(is_unit_vector));
        if !many && let Err(why) = regular_at(system, &point) {
            return Ok(Some(Answer::Unknown(why.into())));
        }
        let names = system.input_names();
        Ok(Some(match (regime, smoothed) {
            (Ok(Regime::Mode(mode)), _) => {
                let (pool, fields) = (&mut system.pool, &self.modes[mode].fields);
                let mut report = point_report(pool, fields, &names, &self.reach[mode], &point, options, evidence);
                if let Ok(report) = &mut report
                    && self.modes.len() > 1
                    && !all_finite(&names, options)
                {
                    let same = self.over_all.is_some_and(|d| d < fields.states.len());
                    report.stlc = near_the_point(report.stlc.clone(), same);
                }
                if let (Ok(report), Some(degree)) = (&mut report, self.degree) {
                    let rank = degree.rank_at(pool, fields, &point.states, evidence);
                    report.relative_degree_defined = Some(rank.map(|rank| rank == degree.degrees.len()).into());
                }
                report.into()
            }
            (Ok(Regime::Switching(vanishing)), of_smoothed) => {
                let unit_vector = vanishing.iter().any(is_unit_vector);
                let report = match of_smoothed {
                    Some(s) => s.at_point(&names, options, vanishing, evidence),
                    // Smooth but where a unit vector vanishes, as it does here.
                    None => Smoothed::of(system, options, self.first, evidence)?
                        .at_point(&names, options, vanishing, evidence),
                };
                let (modes, invariants) = (self.modes, self.invariants);
                let given = AtSwitchPoint { modes, point: &point, names: &names, options, invariants, unit_vector };
                Answer::Known(of_modes(&mut system.pool, &given, report, evidence))
            }
            (Err(why), _) => Answer::Unknown(why.into()),
        }))
    }
}

/// Whether all inputs have finite ranges.
fn all_finite(names: &[String], options: &AnalysisOptions) -> bool {
    names.iter().all(|n| options.ranges.iter().any(|r| r.0 == *n && r.1.finite().is_some()))
}

/// What the equations of one mode tell of inputs without bounds, which may lead to other modes: a "yes" near the point; a "no" only if the
/// accessible dimension is too small in all modes together, which `same` says.
fn near_the_point(stlc: Stlc, same: bool) -> Stlc {
    match (stlc.verdict, &stlc.reason) {
        (Verdict::Yes, StlcReason::Jumps) => {
            Stlc { bounded: stlc.bounded, ..Stlc::inconclusive(StlcReason::Unbounded) }
        }
        (Verdict::No, _) if same => stlc,
        (Verdict::No, _) => only_bounded(BoundedStlc { verdict: Verdict::No, reason: stlc.reason }),
        _ => stlc,
    }
}

/// What all modes together reach, and in which round where their fields act together.
fn switching(
    pool: &mut Pool,
    modes: &[ModeFields],
    reaches: &[Reach],
    autonomous: &[Vec<Expr>],
    first: usize,
    evidence: &mut Evidence,
) -> Result<(SwitchedReport, Option<Vec<Reached>>), Error> {
    let before = pool.len();
    let occurrence = Occurrence::of(pool, modes, &modes[0].fields.bindings.clone());
    // Modes that cannot occur add nothing, but keep their numbers.
    let possible = occurrence.impossible.iter().position(|&i| !i).unwrap_or(0);
    let counted = |k: usize| if occurrence.impossible[k] { possible } else { k };
    let family: Vec<VectorFields> = (0..modes.len()).map(|k| modes[counted(k)].fields.clone()).collect();
    let all = VectorFields::switched(pool, &family)?;
    let generators = brackets::family_generators(pool, &family, &all);
    let union = Reach::of(pool, &all, first, evidence);
    let given = AllModes {
        modes,
        reaches,
        all: &all,
        union: &union,
        generators: &generators,
        occurrence: &occurrence,
        in_modes: autonomous,
    };
    let report = switched_report(pool, &given, evidence);
    let strong = union.strong.as_ref().ok().filter(|s| report.dimensions.strong_growth == s.growth);
    let rows = strong.and_then(|s| influence(pool, &all.states, s, &autonomous[0], &all.bindings));
    release(pool, before, &mut []);
    Ok((report, rows))
}

/// The model with every switching function replaced by a smooth one.
struct Smoothed {
    system: System,
    fields: VectorFields,
    reach: Reach,
    /// How many nodes its pool had made when it was taken from that of the model.
    before: usize,
}

impl Smoothed {
    /// `first` is how many nodes the pool had made when the analysis began.
    fn of(
        system: &mut System,
        options: &AnalysisOptions,
        first: usize,
        evidence: &mut Evidence,
    ) -> Result<Self, Error> {
        let width = system.pool.rational(options.epsilon.clone());
        let before = system.pool.made();
        let mut system = system.smoothed(width);
        let fields = mode_fields(&mut system)?.remove(0).fields;
        let reach = Reach::of(&mut system.pool, &fields, first, evidence);
        Ok(Smoothed { system, fields, reach, before })
    }

    fn report(&self, options: &AnalysisOptions) -> SmoothedReport {
        let dimensions = self.reach.dimensions(&generators(self.fields.controls.len()));
        SmoothedReport { epsilon: options.epsilon.to_f64().value(), dimensions }
    }

    /// The statements at the point, where these functions vanish.
    fn at_point(
        &mut self,
        names: &[String],
        options: &AnalysisOptions,
        vanishing: Vec<Vanishing>,
        evidence: &mut Evidence,
    ) -> PointReport {
        let report = match self.system.point.clone() {
            Some(point) => {
                point_report(&mut self.system.pool, &self.fields, names, &self.reach, &point, options, evidence)
                    .unwrap_or_else(|why| PointReport::undecided(why.into()))
            }
            None => PointReport::undecided(Reason::NoPoint),
        };
        of_smoothed(report, vanishing, &options.epsilon)
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
    let before = pool.len();
    let strong = reach.strong.as_ref().map_err(Clone::clone);
    let found = strong.and_then(|s| mode.fields.autonomous(pool, &s.basis, evidence));
    let missing = found.as_ref().map_or(0, |a| a.missing);
    let mut functions = found.as_ref().map(|a| a.functions.clone()).unwrap_or_default();
    let report = ModeReport {
        signs: mode.signs.clone(),
        dimensions: reach.dimensions(&generators(mode.fields.controls.len())),
        autonomous: found.map(|a| Function::list(pool, &a.functions)).into(),
        autonomous_not_found: (missing > 0).then_some(missing),
        involutive: check_analysis(pool, first).and_then(|()| mode.fields.is_involutive(pool, evidence)).into(),
        static_feedback_linearizable: flag.as_ref().map(LinearizationFlag::linearizable).map_err(Clone::clone).into(),
        brackets: Vec::new(),
    };
    release(pool, before, std::slice::from_mut(&mut functions));
    (report, functions)
}

/// The table of the first mode and, where the system switches, that of all modes together.
fn reach_tables(
    pool: &mut Pool,
    mode: &ModeFields,
    reach: &Reach,
    functions: &[Expr],
    reports: &[ModeReport],
    together: Option<Vec<Reached>>,
) -> Vec<ReachTable> {
    let fields = &mode.fields;
    let rows = reach.strong.as_ref().ok().and_then(|s| influence(pool, &fields.states, s, functions, &fields.bindings));
    let alike = |m: &&ModeReport| {
        m.dimensions.strong_growth == reports[0].dimensions.strong_growth && m.autonomous == reports[0].autonomous
    };
    let alike = reports.iter().filter(alike).count();
    let first = rows.map(|rows| ReachTable { signs: mode.signs.clone(), all_modes: false, alike, rows });
    let together = together.map(|rows| ReachTable { signs: Signs::default(), all_modes: true, alike: 1, rows });
    first.into_iter().chain(together).collect()
}
