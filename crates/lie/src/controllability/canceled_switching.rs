//! Switching that feedback cancels.

use bracketry_symbolic::{Expr, Pool};
use nalgebra::{DMatrix, DVector};
use rustc_hash::FxHashMap;

use crate::algebra::field::{Field, VectorFields, subtract};
use crate::algebra::span::{independent_rows, vanishes};
use crate::answer::Answer;
use crate::controllability::local_accessibility::Frame;
use crate::controllability::meeting::{Adjacent, AtSwitchPoint, CLEAR, Ranges, Verdicts, input_set, only_bounded};
use crate::controllability::point::{PointReport, point_report};
use crate::controllability::stlc::{BoundedStlc, Stlc, Verdict};
use crate::controllability::surface::Surface;
use crate::controllability::uninfluenced::Reach;
use crate::error::Error;
use crate::evidence::Evidence;
use crate::reason::{StabilizableReason, StlcReason};
use crate::undecided::Undecided;
use bracketry_numerics::eigen::svd;

/// Which verdicts on what is left are verdicts on the model.
struct Transfers {
    /// The feedback needs only values inside the ranges.
    yes: bool,
    /// All trajectories are those of what is left, with other inputs.
    no: bool,
}

/// What is left after feedback has canceled the difference of the modes.
pub(crate) struct Canceled {
    report: PointReport,
    transfers: Transfers,
    /// Whether that holds in all modes, so that trajectories may go far.
    far: bool,
    /// Whether the feedback vanishes at the point, so that small inputs suffice near it, or all inputs that it uses have finite ranges.
    small: bool,
    /// Whether the feedback is continuous and vanishes at the point.
    continuous: bool,
}

impl Canceled {
    /// Whether a verdict on what is left is one on the model.
    fn transfer(&self, verdict: Verdict) -> bool {
        match verdict {
            Verdict::Yes => self.transfers.yes,
            Verdict::No => self.transfers.no,
            Verdict::Inconclusive => false,
        }
    }

    /// Adds what follows to what is found; `stuck` says that the smallest inputs do not leave a surface.
    pub(crate) fn conclude(&self, found: &mut Verdicts, stuck: Option<StlcReason>) {
        let stlc = &self.report.stlc;
        let canceled = |reason: &StlcReason| StlcReason::Canceled(Box::new(reason.clone()));
        let of_bounded = stlc.bounded.as_ref().map_or((stlc.verdict, &stlc.reason), |b| (b.verdict, &b.reason));
        let bounded =
            self.transfer(of_bounded.0).then(|| BoundedStlc { verdict: of_bounded.0, reason: canceled(of_bounded.1) });
        if found.stlc.as_ref().is_none_or(|s| s.verdict == Verdict::Inconclusive) {
            if self.far && self.transfer(stlc.verdict) {
                let bounded = stlc.bounded.as_ref().and(bounded);
                found.stlc = Some(Stlc { reason: canceled(&stlc.reason), bounded, ..stlc.clone() });
            } else if let Some(bounded) = bounded {
                // Fewer inputs do already; but what bounded inputs do not reach, others may.
                found.stlc = Some(match bounded.verdict {
                    Verdict::Yes => Stlc::new(Verdict::Yes, bounded.reason),
                    _ => only_bounded(bounded),
                });
            }
            if let Some(yes) = found.stlc.as_mut().filter(|s| s.verdict == Verdict::Yes && !self.small) {
                // The feedback takes inputs as large as the difference of the modes.
                yes.bounded = Some(match stuck {
                    Some(reason) => BoundedStlc { verdict: Verdict::No, reason },
                    None => BoundedStlc { verdict: Verdict::Inconclusive, reason: StlcReason::Switches },
                });
            }
        }
        if let (Some(Answer::Known(answer)), Some(why)) = (&self.report.stabilizable, &self.report.stabilizable_reason)
            && (if *answer { self.transfers.yes } else { self.transfers.no })
        {
            found.stabilizable = Some((*answer, StabilizableReason::Canceled(Box::new(why.clone()))));
        }
        if let Some(Answer::Known(holds)) = self.report.brockett_condition
            && self.continuous
        {
            found.brockett = Some(holds);
        }
    }
}

/// Whether the input fields of all modes are those of the first.
fn same_inputs(pool: &mut Pool, modes: &[Adjacent], first: &Adjacent) -> bool {
    for mode in modes {
        for (a, b) in first.fields.controls.concat().into_iter().zip(mode.fields.controls.concat()) {
            let gap = pool.sub(a, b);
            if !vanishes(pool, gap, &first.fields.bindings) {
                return false;
            }
        }
    }
    true
}

/// Where the input fields are the same in all modes, independent at the point and span the differences of the drifts,
/// f_σ = f₀ + Σ β_σi g_i with smooth β_σi. Then u = w − β_σ makes all modes equal to x' = f₀ + Σ w_i g_i; f₀ is the mean
/// over the modes that meet at the point. Inputs without bounds may lead to `all` modes.
pub(crate) fn canceled(
    pool: &mut Pool,
    given: &AtSwitchPoint,
    adjacent: &[Adjacent],
    all: Option<&[Adjacent]>,
    ranges: &Ranges,
    evidence: &mut Evidence,
) -> Result<Option<Canceled>, Error> {
    let Some(first) = adjacent.first().filter(|a| same_inputs(pool, adjacent, a)) else { return Ok(None) };
    let (controls, bindings) = (&first.fields.controls, &first.fields.bindings);
    let count = pool.ratio(1, adjacent.len() as i64);
    let mut mean = Field::new();
    for i in 0..first.fields.states.len() {
        let terms: Vec<Expr> = adjacent.iter().map(|a| a.fields.drift[i]).collect();
        let sum = pool.sum(terms);
        let sum = pool.mul(count, sum);
        mean.push(pool.simplify(sum));
    }
    let rows = independent_rows(pool, controls, bindings, evidence)?;
    if first.frame.rank(pool, controls, evidence)? < rows.len() {
        return Ok(None);
    }
    let spans = |pool: &mut Pool, modes: &[Adjacent], evidence: &mut Evidence| -> Result<_, Undecided> {
        let gaps: Vec<Field> = modes.iter().map(|a| subtract(pool, &a.fields.drift, &mean)).collect();
        let both: Vec<Field> = controls.iter().chain(&gaps).cloned().collect();
        Ok((independent_rows(pool, &both, bindings, evidence)?.len() == rows.len()).then_some(gaps))
    };
    let Some(gaps) = spans(pool, adjacent, evidence)? else { return Ok(None) };
    let far = match all {
        None => true,
        Some(all) => !all.is_empty() && same_inputs(pool, all, first) && spans(pool, all, evidence)?.is_some(),
    };
    let vanish = first.frame.rank(pool, &gaps, evidence)? == 0;
    let Some(needed) = needed(pool, first, &rows, &gaps) else { return Ok(None) };
    let left = VectorFields::new(first.fields.states.clone(), mean, controls.clone(), bindings.clone())?;
    let set = input_set(given);
    let frame = Frame::new(pool, &left, &given.point.states, &given.point.inputs)?;
    let two_sided = set.sides(pool, &frame, &given.point.inputs).is_some_and(|s| s.iter().all(Option::is_none));
    let Some(inputs) = frame.numbers(pool, &given.point.inputs) else { return Ok(None) };
    // The inputs that make w the input at the point lie inside their ranges in every mode.
    let inside = (0..inputs.len()).all(|i| {
        let (lower, upper) = ranges.ends[i];
        needed.iter().all(|b| lower + CLEAR < inputs[i] - b[i] && inputs[i] - b[i] < upper - CLEAR)
    });
    let reach = Reach::of(pool, &left, pool.made(), evidence);
    let report = point_report(pool, &left, given.names, &reach, given.point, given.options, evidence)?;
    let finite = |i: usize| ranges.ends[i].0.is_finite() && ranges.ends[i].1.is_finite();
    let in_ranges = (0..inputs.len()).all(|i| finite(i) || needed.iter().all(|b| b[i] == 0.0));
    let rests = report.equilibrium == Answer::Known(true);
    let all_free = ranges.free.iter().all(|f| *f);
    Ok(Some(Canceled {
        transfers: Transfers {
            yes: all_free || rests && two_sided && inside,
            no: all_free || rests && two_sided && vanish,
        },
        far,
        small: vanish || in_ranges,
        continuous: vanish && is_continuous(pool, adjacent),
        report,
    }))
}

/// β_σ at the point, for each mode: one number per input, 0 for those that the independent ones make up.
fn needed(pool: &mut Pool, first: &Adjacent, rows: &[usize], gaps: &[Field]) -> Option<Vec<Vec<f64>>> {
    let n = first.fields.states.len();
    let at: FxHashMap<Expr, Expr> =
        first.fields.states.iter().zip(first.frame.point()).map(|(&s, &v)| (pool.sym(s), v)).collect();
    let mut all: Vec<Expr> = rows.iter().flat_map(|&i| first.fields.controls[i].clone()).collect();
    all.extend(gaps.concat());
    let all = pool.substitute_all(&all, &at);
    let values = first.frame.numbers(pool, &all)?;
    let (g, gaps) = values.split_at(rows.len() * n);
    let g = DMatrix::from_column_slice(n, rows.len(), g);
    let svd = svd(&g)?;
    let mut list = Vec::new();
    for gap in gaps.chunks(n) {
        let mut inputs = vec![0.0; first.fields.controls.len()];
        if gap.iter().any(|v| *v != 0.0) {
            let b = svd.solve(&DVector::from_column_slice(gap), CLEAR).ok()?;
            for (&i, &v) in rows.iter().zip(b.iter()) {
                inputs[i] = v;
            }
        }
        list.push(inputs);
    }
    Some(list)
}

/// Whether modes that differ in one sign agree on the surface between them.
fn is_continuous(pool: &mut Pool, adjacent: &[Adjacent]) -> bool {
    for (k, a) in adjacent.iter().enumerate() {
        for b in &adjacent[..k] {
            let differ: Vec<Expr> = a
                .vanishing
                .iter()
                .zip(&a.switches)
                .filter(|((_, sign), i)| {
                    let other = b.switches.iter().position(|j| j == *i).map(|p| b.vanishing[p].1);
                    other != Some(*sign)
                })
                .map(|((s, _), _)| *s)
                .collect();
            let [s] = differ[..] else { continue };
            let bindings = &a.fields.bindings;
            let Some(surface) = Surface::solve(pool, &a.fields.states, s, bindings) else { return false };
            let gap = subtract(pool, &a.fields.drift, &b.fields.drift);
            let gap = surface.restrict(pool, &gap);
            if !gap.into_iter().all(|e| vanishes(pool, e, bindings)) {
                return false;
            }
        }
    }
    true
}
