//! The answer: friction cones first, then loops.

use bracketry_symbolic::Limit;
use bracketry_system::System;

use super::bounds::{Bound, Span, derivative_name};
use super::displacement::{Displaced, Plant};
use super::driven;
use super::error::FromRestError;
use super::grid::{Family, grid};
use super::held::{Held, Motion, Test, Where};
use super::meeting::{Meeting, Return};
use super::model::{Channel, RestModel};
use super::reason::FromRestReason;
use super::result::{Answer, CoordinateAnswer, Displacement, FromRest, FromRestOptions, Proof, Stroke};
use super::span::{ROUNDING, Spanned, is_displaced, sizes, spanned};
use super::strokes::{self, Loop};

const EVIDENCE: Answer = Answer::Yes { proof: Proof::Evidence };
/// A little shorter.
const SLIGHTLY: f64 = 0.995;
/// Durations of loops, relative to the full ones, at which displacements are computed.
const SHORTER: [f64; 4] = [0.9, 0.5, 0.25, 0.125];

/// Whether inputs within their bounds move the coordinates of a model from rest to rest, near its point.
///
/// # Errors
/// [`FromRestError`] for bounds that do not fit the model, and for models that cannot be simulated.
pub fn from_rest(system: &System, options: &FromRestOptions) -> Result<FromRest, FromRestError> {
    let limit = Limit::new(options.time_limit, &options.stop);
    match RestModel::new(system, &options.bounds)? {
        Ok(mut model) => {
            model.system.pool.set_limit(limit.clone());
            let mut plant = Plant::new(&model, &options.stop)?;
            Ok(decided(&system.name, &mut model, &mut plant, Depth::Full, &limit))
        }
        Err(reason) => Ok(FromRest::without_answer(&system.name, reason)),
    }
}

/// How much is computed.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Depth {
    /// All loops, also shorter ones.
    Full,
    /// Only what the answers need.
    Answers,
}

/// The answer for a model with its bounds. Where the loops that span the coordinates are no evidence, all are tried.
pub(crate) fn decided(name: &str, model: &mut RestModel, plant: &mut Plant, depth: Depth, limit: &Limit) -> FromRest {
    let found = decided_at(name, model, plant, depth, limit);
    if depth == Depth::Answers && found.reason == Some(FromRestReason::NoReturn) {
        return decided_at(name, model, plant, Depth::Full, limit);
    }
    found
}

fn decided_at(name: &str, model: &mut RestModel, plant: &mut Plant, depth: Depth, limit: &Limit) -> FromRest {
    let home: Vec<Vec<Span>> = model.channels.iter().map(Channel::at_home).collect();
    let at_home = Test::new(model, &home, Where::Anywhere).run();
    if at_home.motions.iter().any(|m| *m != Motion::Never) {
        // What is not seen in time is not known to be at rest.
        let why = if limit.is_reached() { FromRestReason::Stopped } else { FromRestReason::NotAtRest };
        return FromRest::without_answer(name, why);
    }
    let held = global(model);
    let mut strokes = Vec::new();
    let mut loops = Vec::new();
    let at: Vec<f64> = model.at.iter().map(|e| e.value).collect();
    let (mut tried, mut stopped) = (0, false);
    let open: Vec<usize> = (0..held.motions.len()).filter(|&c| held.motions[c] != Motion::Never).collect();
    let slow = if open.is_empty() { Vec::new() } else { strokes::slow_accelerations(model) };
    for make in [strokes::single, strokes::pairs] {
        if open.is_empty() || stopped || depth == Depth::Answers && is_spanned(&strokes, &open) {
            break;
        }
        for stroke in make(model, &slow) {
            if limit.is_reached() {
                stopped = true;
                break;
            }
            tried += 1;
            // A motion that the simulator cannot follow is tried a little shorter.
            let tried = [1.0, SLIGHTLY].into_iter().map(|scale| stroke.scaled(scale));
            let run = tried.into_iter().find_map(|s| Some((plant.displaced(model, &at, &s, 1.0)?, s)));
            let Some((whole, stroke)) = run else { continue };
            if let Some(found) = examined(model, plant, &stroke, whole, depth) {
                strokes.push(found);
                loops.push(stroke.clone());
            }
            if depth == Depth::Answers && stroke.moved.len() > 1 && is_spanned(&strokes, &open) {
                break;
            }
        }
    }
    let mut found = answered(name, model, held, strokes, tried, stopped);
    let is_evidence = found.coordinates.iter().any(|c| c.answer == EVIDENCE);
    if (depth == Depth::Full || is_evidence) && !found.moving.is_empty() {
        let changes: Vec<Vec<f64>> = found.strokes.iter().map(|s| s.displacements[0].change.clone()).collect();
        let of = Family {
            model,
            loops: &loops,
            changes: &changes,
            sizes: &found.sizes,
            moving: &found.moving,
            shorter: &SHORTER,
        };
        found.grid = grid(&of, plant, || limit.is_reached());
        if let Some(grid) = &found.grid {
            let used: Vec<Loop> = grid.loops.iter().map(|&k| loops[k].clone()).collect();
            let is_over = || limit.is_reached();
            let mut meeting = Meeting { model, plant, loops: &used, sizes: &found.sizes, is_over: &is_over };
            let back = meeting.returned(&at, &found.moving);
            found.back = back.map(|back| Return { loops: grid.loops.clone(), ..back });
        }
        found.withdraw_evidence(stopped);
    }
    found
}

/// What friction holds for all admissible inputs.
pub(crate) fn global(model: &mut RestModel) -> Held {
    let inputs: Vec<Vec<Span>> = model.channels.iter().map(|c| c.spans.clone()).collect();
    Test::new(model, &inputs, Where::Anywhere).run()
}

/// What a loop does with this displacement; `None` if it moves nothing.
fn examined(model: &mut RestModel, plant: &mut Plant, stroke: &Loop, whole: Displaced, depth: Depth) -> Option<Stroke> {
    let at: Vec<f64> = model.at.iter().map(|e| e.value).collect();
    let mut displacements = vec![Displacement { scale: 1.0, change: whole.change.clone() }];
    for &scale in if depth == Depth::Full { &SHORTER[..] } else { &[] } {
        let Some(found) = plant.displaced(model, &at, stroke, scale) else { break };
        displacements.push(Displacement { scale, change: found.change });
    }
    let full = displacements.first()?;
    if !is_displaced(&full.change, &at) {
        return None;
    }
    let proven = if stroke.moved.len() == 1 {
        let inputs = whole.closed.spans(model);
        let motions = Test::new(model, &inputs, Where::Near).run().motions;
        let mut moved = motions.iter().enumerate().filter(|(_, m)| **m != Motion::Never);
        match (moved.next(), moved.next()) {
            (Some((c, Motion::OnlyUp)), None) if full.change[c] > ROUNDING => Some((c, 1.0)),
            (Some((c, Motion::OnlyDown)), None) if full.change[c] < -ROUNDING => Some((c, -1.0)),
            _ => None,
        }
    } else {
        driven::proven(model, &whole.closed, &full.change)
    };
    Some(Stroke {
        inputs: stroke.moved.iter().map(|&j| model.channels[j].name.clone()).collect(),
        shape: stroke.shape.clone(),
        duration: stroke.duration(),
        displacements,
        proven,
        signals: whole.signals,
    })
}

fn answered(name: &str, model: &RestModel, held: Held, strokes: Vec<Stroke>, tried: usize, stopped: bool) -> FromRest {
    let count = model.coordinates.len();
    let open: Vec<usize> = (0..count).filter(|&c| held.motions[c] != Motion::Never).collect();
    let (sizes, Spanned { moving, directions, margin }) = span_of(&strokes, count, &open);
    let proven = |c: usize, sign: f64| strokes.iter().any(|s| s.proven == Some((c, sign)));
    let both = |c: usize| proven(c, 1.0) && proven(c, -1.0);
    let all_proven = open.iter().all(|&c| both(c));
    let answer = |c: usize| match held.motions[c] {
        Motion::Never | Motion::OnlyUp | Motion::OnlyDown => Answer::No,
        Motion::Open if both(c) => Answer::Yes { proof: Proof::Proven },
        Motion::Open if moving.contains(&c) => Answer::Yes { proof: Proof::Evidence },
        Motion::Open => Answer::Unknown,
    };
    let names = model.coordinate_names();
    let coordinates: Vec<CoordinateAnswer> = (0..count)
        .map(|c| CoordinateAnswer {
            name: names[c].clone(),
            at: model.at[c].value,
            motion: held.motions[c],
            answer: answer(c),
        })
        .collect();
    let any = |a: Answer| coordinates.iter().any(|c| c.answer == a);
    let total = if any(Answer::No) {
        Answer::No
    } else if any(Answer::Unknown) {
        Answer::Unknown
    } else {
        Answer::Yes { proof: if all_proven { Proof::Proven } else { Proof::Evidence } }
    };
    let reason =
        any(Answer::Unknown).then_some(if stopped { FromRestReason::Stopped } else { FromRestReason::Loops { tried } });
    FromRest {
        model: name.to_owned(),
        answer: total,
        reason,
        coordinates,
        bounds: bounds(model),
        cones: held.cones,
        strokes,
        moving,
        sizes,
        directions,
        margin,
        grid: None,
        back: None,
    }
}

/// The sizes of displacements by coordinate, and what the loops span.
fn span_of(strokes: &[Stroke], count: usize, open: &[usize]) -> (Vec<f64>, Spanned) {
    let changes: Vec<&[f64]> = strokes.iter().map(|s| s.displacements[0].change.as_slice()).collect();
    let sizes = sizes(&changes, count);
    let found = spanned(&changes, &sizes, open);
    (sizes, found)
}

/// Whether the loops positively span all of these coordinates.
fn is_spanned(strokes: &[Stroke], open: &[usize]) -> bool {
    let count = strokes.first().map_or(0, |s| s.displacements[0].change.len());
    count > 0 && span_of(strokes, count, open).1.moving.len() == open.len()
}

/// All bounds that hold.
fn bounds(model: &RestModel) -> Vec<Bound> {
    let mut list = Vec::new();
    for channel in &model.channels {
        for (order, span) in channel.spans.iter().enumerate().filter(|(_, s)| s.is_finite()) {
            list.push(Bound::new(&derivative_name(&channel.name, order), span.ends[0], span.ends[1]));
        }
    }
    for (name, region) in model.coordinate_names().iter().zip(&model.region) {
        if let Some(span) = region {
            list.push(Bound::new(name, span.ends[0], span.ends[1]));
        }
    }
    list
}

impl FromRest {
    /// Displacements of full loops alone are no evidence: they need a margin that stays for shorter loops, or a return.
    fn withdraw_evidence(&mut self, stopped: bool) {
        let carries = self.grid.as_ref().is_some_and(|grid| grid.points.iter().all(|p| p.reach > 0.0));
        if carries || self.back.is_some() {
            return;
        }
        for answer in self.coordinates.iter_mut().map(|c| &mut c.answer).chain([&mut self.answer]) {
            if *answer == EVIDENCE {
                *answer = Answer::Unknown;
                self.reason = Some(if stopped { FromRestReason::Stopped } else { FromRestReason::NoReturn });
            }
        }
    }

    fn without_answer(model: &str, reason: FromRestReason) -> Self {
        FromRest {
            model: model.to_owned(),
            answer: Answer::Unknown,
            reason: Some(reason),
            coordinates: Vec::new(),
            bounds: Vec::new(),
            cones: Vec::new(),
            strokes: Vec::new(),
            moving: Vec::new(),
            sizes: Vec::new(),
            directions: Vec::new(),
            margin: 0.0,
            grid: None,
            back: None,
        }
    }
}
