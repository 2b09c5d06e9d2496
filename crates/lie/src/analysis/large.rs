//! Systems of very many states, of which only the dimensions are determined.

use std::time::Instant;

use bracketry_symbolic::Pool;
use bracketry_system::System;

use crate::algebra::krylov::Krylov;
use crate::analysis::report::{Effort, ModeReport, Report};
use crate::answer::Answer;
use crate::controllability::point::Subject;
use crate::dimensions::Dimensions;
use crate::evidence::Evidence;
use crate::feedback::report::ControlReport;
use crate::modes::ModeFields;
use crate::observability::report::{ObservabilityReport, Undetermined};
use crate::reason::Reason;
use crate::undecided::Undecided;

/// Fields of more states would take too much memory: a basis of n of them has n² entries.
pub(crate) const MAX_STATES: usize = 5000;

fn why() -> Undecided {
    Undecided::TooManyStates { states: MAX_STATES }
}

fn unknown<T>() -> Answer<T> {
    Answer::Unknown(why().into())
}

/// The report on a system with more states than [`MAX_STATES`]: dimensions of each mode that is linear, and nothing else.
pub(crate) fn large_report(system: &mut System, modes: &[ModeFields], start: Instant) -> Report {
    let mut evidence = Evidence::default();
    let first = system.pool.made();
    let modes: Vec<ModeReport> = modes.iter().map(|m| mode_report(&mut system.pool, m, &mut evidence)).collect();
    let smooth = modes.len() == 1 && modes[0].signs.0.is_empty();
    let names = system.parameters.iter().map(|p| system.symbol_name(p.symbol).to_owned());
    let open = Undetermined { names: names.collect(), reason: why().into() };
    let observability = ObservabilityReport {
        rank: unknown(),
        undecided_parameters: Some(open).filter(|open| !open.names.is_empty()),
        reason: Some(why().into()),
        ..ObservabilityReport::default()
    };
    Report {
        modes,
        switched: None,
        smoothed: None,
        at_point: system.point.is_some().then(unknown),
        at_point_reason: system.point.is_some().then(|| Reason::from(why())),
        global_statements_of: (!smooth).then_some(Subject::Smoothed),
        lie_algebra: None,
        involutive: unknown(),
        involutive_closure: unknown(),
        static_feedback_linearizable: unknown(),
        control: ControlReport::default(),
        observability: (!system.outputs.is_empty()).then_some(observability),
        brackets: Vec::new(),
        reach: Vec::new(),
        certificate: evidence,
        effort: Effort { expressions: system.pool.made() - first },
        seconds: start.elapsed().as_secs_f64(),
    }
}

fn mode_report(pool: &mut Pool, mode: &ModeFields, evidence: &mut Evidence) -> ModeReport {
    let linear = Krylov::of(pool, &mode.fields);
    let mut growth = |with_drift: bool| match &linear {
        Some(linear) => linear.growth(pool, with_drift, evidence),
        None => Err(why()),
    };
    let (all, strong) = (growth(true), growth(false));
    let dimension = |growth: &Result<Vec<usize>, Undecided>| -> Answer<usize> {
        growth.as_ref().map(|g| g.last().copied().unwrap_or(0)).map_err(Clone::clone).into()
    };
    let (dimension, strong_dimension) = (dimension(&all), dimension(&strong));
    let (all, strong) = (all.unwrap_or_default(), strong.unwrap_or_default());
    ModeReport {
        signs: mode.signs.clone(),
        dimensions: Dimensions::new(all, dimension, strong, strong_dimension),
        autonomous: unknown(),
        autonomous_not_found: None,
        involutive: unknown(),
        static_feedback_linearizable: unknown(),
        brackets: Vec::new(),
    }
}
