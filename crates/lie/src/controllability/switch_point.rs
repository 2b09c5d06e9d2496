//! Statements at a point where switching functions vanish, from the modes that meet there.

use bracketry_symbolic::{Expr, Pool, Rational};
use rustc_hash::FxHashMap;

use crate::algebra::field::{VectorFields, subtract};
use crate::answer::Answer;
use crate::controllability::canceled_switching::canceled;
use crate::controllability::cone::half_space_of_modes;
use crate::controllability::crossing::crossed;
use crate::controllability::meeting::{Adjacent, AtSwitchPoint, Ranges, Verdicts, adjacent, all_modes, only_bounded};
use crate::controllability::point::PointReport;
use crate::controllability::region::{Extent, Region};
use crate::controllability::sticking::{frozen, sticks};
use crate::controllability::stlc::{BoundedStlc, Stlc, Verdict};
use crate::error::Error;
use crate::evidence::Evidence;
use crate::reason::{AtSwitch, StabilizableReason, StlcReason};
use crate::undecided::Undecided;

/// Most modes that are looked at.
const MAX_MODES: usize = 64;

/// Replaces the statements of the smoothed model on local controllability and stabilization by those of the model.
///
/// No: where the fields of all modes together have too small a dimension; where a function is constant in every mode;
/// where a half-space is invariant in every mode; where both modes drive the motion onto a surface, whatever the
/// inputs. Yes, or no: where feedback cancels the difference of the modes, by what is left.
pub(crate) fn of_modes(
    pool: &mut Pool,
    given: &AtSwitchPoint,
    smoothed: PointReport,
    evidence: &mut Evidence,
) -> PointReport {
    let open = |reason: StlcReason| Verdicts {
        equilibrium: smoothed.equilibrium.clone(),
        stlc: Some(Stlc::inconclusive(reason)),
        stabilizable: None,
        brockett: None,
    };
    let verdicts = if given.unit_vector {
        open(StlcReason::UnitVector)
    } else {
        match decide(pool, given, &smoothed, evidence) {
            Ok(verdicts) => verdicts,
            Err(Error::Undecided(why)) => open(why.into()),
            Err(_) => open(StlcReason::Switches),
        }
    };
    let rests = verdicts.equilibrium != Answer::Known(false);
    let open = |why: AtSwitch| Answer::Unknown(why.into());
    let (stabilizable, stabilizable_reason) = match verdicts.stabilizable {
        Some((answer, why)) => (Answer::Known(answer), why),
        None => (open(AtSwitch::Stabilizable), StabilizableReason::Open(AtSwitch::Stabilizable.into())),
    };
    let stlc = verdicts.stlc.unwrap_or_else(|| Stlc::inconclusive(StlcReason::Switches));
    PointReport {
        equilibrium: verdicts.equilibrium,
        stabilizable: rests.then_some(stabilizable),
        stabilizable_reason: rests.then_some(stabilizable_reason),
        brockett_condition: rests.then(|| verdicts.brockett.map_or_else(|| open(AtSwitch::Brockett), Answer::Known)),
        smoothed_stlc: Some(smoothed.stlc),
        stlc,
        ..smoothed
    }
}

fn decide(
    pool: &mut Pool,
    given: &AtSwitchPoint,
    smoothed: &PointReport,
    evidence: &mut Evidence,
) -> Result<Verdicts, Error> {
    let adjacent = adjacent(pool, given)?;
    if adjacent.len() > MAX_MODES {
        let stlc = Some(Stlc::inconclusive(StlcReason::ManyModes(adjacent.len())));
        let equilibrium = smoothed.equilibrium.clone();
        return Ok(Verdicts { equilibrium, stlc, stabilizable: None, brockett: None });
    }
    let equilibrium = if smoothed.outside_ranges.is_empty() {
        equilibrium(pool, &adjacent, &smoothed.equilibrium, evidence)?
    } else {
        Answer::Known(false)
    };
    let mut found = Verdicts { equilibrium, stlc: None, stabilizable: None, brockett: None };
    let ranges = Ranges::new(given);
    // Bounded inputs stay near the point for a short time; others may lead to all modes.
    let all = match given.modes.len() {
        _ if ranges.bounded() => None,
        0..=MAX_MODES => Some(all_modes(pool, given)?),
        _ => Some(Vec::new()),
    };
    let near = Extent::near(Region::All);
    let one_way = half_space_of_modes(pool, given, &adjacent, near, evidence)?;
    let bounded = match &one_way {
        Some(reason) => Some(StlcReason::EveryMode(Box::new(reason.clone()))),
        None => negative(pool, given, &adjacent, &ranges, false, evidence)?,
    };
    let no = match &all {
        None => bounded.clone(),
        Some(all) => negative(pool, given, all, &ranges, true, evidence)?,
    };
    found.stlc = match (no, bounded.clone()) {
        (Some(reason), _) => Some(Stlc::new(Verdict::No, reason)),
        (None, Some(reason)) => Some(only_bounded(BoundedStlc { verdict: Verdict::No, reason })),
        (None, None) => None,
    };
    if let Some(StlcReason::HalfSpace { function, change, one_sided }) = one_way {
        found.stabilizable = Some((false, StabilizableReason::OneWay { function, change }));
        // Brockett's condition is about all values of the inputs near those at the point.
        found.brockett = (!one_sided).then_some(false);
        return Ok(found);
    }
    // What bounded inputs do not change keeps states near the point from it, under every feedback.
    found.stabilizable = match &bounded {
        Some(StlcReason::Invariant(function)) => Some((false, StabilizableReason::Conserved(function.clone()))),
        Some(StlcReason::Sticks(surface)) => frozen(pool, &adjacent, surface)
            .map(|kept| (false, StabilizableReason::Sticks { surface: surface.clone(), kept })),
        _ => None,
    };
    if found.stabilizable.is_some() {
        return Ok(found);
    }
    if found.stlc.is_none()
        && let Some(reason) = crossed(pool, given, &adjacent, evidence)?
    {
        found.stlc = Some(Stlc::new(Verdict::Yes, reason));
    }
    if let Some(left) = canceled(pool, given, &adjacent, all.as_deref(), &ranges, evidence)? {
        let stuck = match Ranges::smallest(pool, given, &adjacent) {
            Some(smallest) => sticks(pool, &adjacent, &smallest, false),
            None => None,
        };
        left.conclude(&mut found, stuck);
    }
    Ok(found)
}

/// Whether 0 lies among the mixtures of the rates of all modes at the point (Filippov).
fn equilibrium(
    pool: &mut Pool,
    adjacent: &[Adjacent],
    smoothed: &Answer<bool>,
    evidence: &mut Evidence,
) -> Result<Answer<bool>, Undecided> {
    let mut rests = Vec::new();
    for a in adjacent {
        rests.push(a.frame.is_equilibrium(pool, evidence)?);
    }
    if rests.contains(&true) {
        return Ok(Answer::Known(true));
    }
    let Some((first, others)) = adjacent.split_first() else { return Ok(smoothed.clone()) };
    let mut same = true;
    for other in others {
        let gap = subtract(pool, &other.frame.fields.drift, &first.frame.fields.drift);
        same &= first.frame.rank(pool, &[gap], evidence)? == 0;
    }
    if same {
        return Ok(Answer::Known(false));
    }
    // The smooth sign of 0 is 0, one of the mixtures.
    if *smoothed == Answer::Known(true) {
        return Ok(Answer::Known(true));
    }
    if let [a, b] = adjacent
        && let (at_a, at_b) = (values_at(pool, a), values_at(pool, b))
        && let (Some(p), Some(q)) = (a.frame.rationals(pool, &at_a), b.frame.rationals(pool, &at_b))
    {
        // 0 lies between p and q.
        let parallel = (0..p.len()).all(|i| (0..i).all(|j| p[i].clone() * &q[j] == p[j].clone() * &q[i]));
        let inner = p.iter().zip(&q).fold(Rational::ZERO, |s, (x, y)| s + x.clone() * y);
        return Ok(Answer::Known(parallel && inner < Rational::ZERO));
    }
    Ok(Answer::Unknown(AtSwitch::Equilibrium.into()))
}

/// The drift of the frame at the point.
fn values_at(pool: &mut Pool, a: &Adjacent) -> Vec<Expr> {
    let at: FxHashMap<Expr, Expr> =
        a.fields.states.iter().zip(a.frame.point()).map(|(&s, &v)| (pool.sym(s), v)).collect();
    pool.substitute_all(&a.frame.fields.drift, &at)
}

/// A reason why no neighborhood is reached, near the point or at all distances.
fn negative(
    pool: &mut Pool,
    given: &AtSwitchPoint,
    modes: &[Adjacent],
    ranges: &Ranges,
    everywhere: bool,
    evidence: &mut Evidence,
) -> Result<Option<StlcReason>, Error> {
    let Some(first) = modes.first() else { return Ok(None) };
    let n = first.fields.states.len();
    // Every trajectory, also one that slides, stays in an orbit of the fields of these modes (Nagano, Sussmann).
    let family: Vec<VectorFields> = modes.iter().map(|a| a.fields.clone()).collect();
    let all = VectorFields::switched(pool, &family)?;
    let dimension = all.accessibility(pool, evidence)?.dimension();
    if dimension < n {
        return Ok(Some(StlcReason::NotAccessible { dimension, states: n }));
    }
    for invariant in given.invariants {
        let mut defined = true;
        for a in modes {
            let Some(piece) = invariant.pieces.get(a.number) else { continue };
            let imported = pool.import(&piece.pool().export(&[piece.expr()]));
            let Some(piece) = imported.ok().and_then(|list| list.first().copied()) else { continue };
            let at: FxHashMap<Expr, Expr> =
                a.fields.states.iter().zip(&given.point.states).map(|(&s, &v)| (pool.sym(s), v)).collect();
            let value = pool.substitute(piece, &at);
            defined &= a.frame.numbers(pool, &[value]).is_some();
        }
        if defined {
            return Ok(Some(StlcReason::Invariant(invariant.whole.clone())));
        }
    }
    let extent = Extent { region: Region::Level, everywhere };
    if let Some(reason) = half_space_of_modes(pool, given, modes, extent, evidence)? {
        return Ok(Some(StlcReason::EveryMode(Box::new(reason))));
    }
    Ok(sticks(pool, modes, ranges, everywhere))
}
