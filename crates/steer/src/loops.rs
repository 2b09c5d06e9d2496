//! Steering from rest to rest: full loops until the end is near, then shorter ones that meet it.

use bracketry_sim::Hold;
use bracketry_symbolic::Rational;
use bracketry_system::Point;

use crate::from_rest::decide;
use crate::from_rest::displacement::{Plant, at_rest};
use crate::from_rest::meeting::Meeting;
use crate::from_rest::model::RestModel;
use crate::from_rest::span::{LEAST_MARGIN, Spanned, fewest, is_displaced, sizes, spanned};
use crate::from_rest::strokes::{self, Loop, rest_values};
use crate::from_rest::{FromRestReason, Motion};
use crate::problem::{Outcome, Planned, Problem};
use crate::signals::Signals;
use crate::steering::{Plan, SteerReason};

/// Most full loops.
const MAX_LOOPS: usize = 1000;
/// A difference of a state from rest, and of the end from what was asked for, that is none.
const ROUNDING: f64 = 1e-12;

struct Planner<'a> {
    problem: &'a Problem,
    model: RestModel,
    plant: Plant,
    loops: Vec<Loop>,
    /// Sizes of displacements by coordinate.
    sizes: Vec<f64>,
    /// Loops that were run, each with its pause.
    pieces: Vec<Signals>,
}

/// Loops of the inputs from the state at the start to that at the end, both at rest.
pub(crate) fn plan(problem: &Problem) -> Outcome {
    let (from, to) = (&problem.options.from, &problem.options.to);
    let mut given = problem.given.clone();
    let mut number = |x: &f64| {
        let exact = Rational::try_from(*x).unwrap_or_default();
        given.pool.rational(exact)
    };
    let states = from[..problem.given.states.len()].iter().map(&mut number).collect();
    let homes = problem.given.inputs.iter().enumerate().map(|(j, &u)| {
        let place = problem.system.states.iter().position(|&s| s == u);
        let value = place.map(|k| from[k]).or(problem.options.from_inputs.as_ref().map(|u| u[j]));
        value.unwrap_or(0.0)
    });
    let inputs = homes.collect::<Vec<f64>>().iter().map(&mut number).collect();
    given.point = Some(Point { states, inputs });
    let model = match RestModel::new(&given, &problem.options.bounds) {
        Ok(Ok(model)) => model,
        Ok(Err(why)) => return Err(SteerReason::FromRest(why)),
        Err(error) => return Err(SteerReason::Bounds(error)),
    };
    let plant = Plant::new(&model, problem.stop()).map_err(|_| SteerReason::FromRest(FromRestReason::Inputs))?;
    let mut planner = Planner { problem, model, plant, loops: Vec::new(), sizes: Vec::new(), pieces: Vec::new() };
    planner.check_ends(from, to)?;
    planner.choose_loops()?;
    planner.approach()
}

impl Planner<'_> {
    fn coordinates(&self, state: &[f64]) -> Vec<f64> {
        self.model.coordinates.iter().map(|&k| state[k]).collect()
    }

    fn check_ends(&self, from: &[f64], to: &[f64]) -> Result<(), SteerReason> {
        for end in [from, to] {
            let rest = at_rest(&self.model, &self.coordinates(end));
            if end.iter().zip(&rest).any(|(x, r)| (x - r).abs() > ROUNDING) {
                return Err(SteerReason::NotAtRest);
            }
        }
        Ok(())
    }

    /// The loops that positively span the coordinates, without those that add little to the margin.
    fn choose_loops(&mut self) -> Result<(), SteerReason> {
        let (from, to) = (&self.problem.options.from, &self.problem.options.to);
        let start = self.coordinates(from);
        let gap: Vec<f64> = self.coordinates(to).iter().zip(&start).map(|(b, a)| b - a).collect();
        let motions = decide::global(&mut self.model).motions;
        if let Some(c) = (0..gap.len()).find(|&c| gap[c].abs() > ROUNDING && motions[c] == Motion::Never) {
            return Err(SteerReason::Held { coordinate: self.model.coordinate_names()[c].clone() });
        }
        let open: Vec<usize> = (0..gap.len()).filter(|&c| motions[c] != Motion::Never).collect();
        let slow = strokes::slow_accelerations(&mut self.model);
        let all = [strokes::single(&self.model, &slow), strokes::pairs(&self.model, &slow)].concat();
        let tried = all.len();
        let mut found: Vec<(Loop, Vec<f64>)> = Vec::new();
        for stroke in all {
            if self.problem.is_over() {
                return Err(SteerReason::Stopped);
            }
            let moved = self.plant.displaced(&self.model, &start, &stroke, 1.0).map(|d| d.change);
            if let Some(change) = moved.filter(|change| is_displaced(change, &start)) {
                found.push((stroke, change));
            }
        }
        // Loops of several inputs are left out first, then long ones.
        found.sort_by(|(a, _), (b, _)| a.moved.len().cmp(&b.moved.len()).then(a.duration().total_cmp(&b.duration())));
        let changes: Vec<&[f64]> = found.iter().map(|(_, d)| d.as_slice()).collect();
        let units = sizes(&changes, gap.len());
        let Spanned { moving, directions, margin } = spanned(&changes, &units, &open);
        let missing = (0..gap.len()).any(|c| gap[c].abs() > ROUNDING && !moving.contains(&c));
        if missing || margin < LEAST_MARGIN {
            return Err(SteerReason::FromRest(FromRestReason::Loops { tried }));
        }
        let alone: Vec<usize> = (0..found.len()).filter(|&k| directions[k].iter().any(|x| *x != 0.0)).collect();
        let list: Vec<&[f64]> = alone.iter().map(|&k| changes[k]).collect();
        let used: Vec<usize> = fewest(&list, &units, &moving).into_iter().map(|k| alone[k]).collect();
        let list: Vec<&[f64]> = used.iter().map(|&k| changes[k]).collect();
        self.sizes = sizes(&list, gap.len());
        self.loops = used.iter().map(|&k| found[k].0.clone()).collect();
        Ok(())
    }

    /// Full loops toward the end until it is met by shorter ones.
    fn approach(&mut self) -> Outcome {
        let end = self.coordinates(&self.problem.options.to);
        let mut here = self.coordinates(&self.problem.options.from);
        let problem = self.problem;
        let is_over = || problem.is_over();
        let mut meeting = Meeting {
            model: &self.model,
            plant: &mut self.plant,
            loops: &self.loops,
            sizes: &self.sizes,
            is_over: &is_over,
        };
        let none = SteerReason::EndError { error: f64::INFINITY };
        for _ in 0..MAX_LOOPS {
            if is_over() {
                return Err(SteerReason::Stopped);
            }
            let longest = meeting.longest(&here).ok_or(none.clone())?;
            let gap: Vec<f64> = end.iter().zip(&here).map(|(b, a)| b - a).collect();
            if let Some(parts) = meeting.parts(&longest, &gap) {
                let met = meeting.meet(&here, &end, &longest, &parts).ok_or(none)?;
                self.pieces.extend(met.signals);
                let plan = Plan::Loops { loops: self.pieces.len(), shapes: self.loops.len() };
                return Ok(vec![Planned { signals: self.joined()?, plan }]);
            }
            // How often each loop is run if displacements stay as they are; the one that is needed most is next.
            let often = meeting.combined(&longest, &gap, [0.0, MAX_LOOPS as f64], 0.0).ok_or(none.clone())?;
            let next = (0..often.len()).max_by(|&a, &b| often[a].total_cmp(&often[b])).unwrap_or(0);
            for run in longest.runs.into_iter().skip(next).take(1) {
                here.iter_mut().zip(&run.change).for_each(|(q, d)| *q += d);
                self.pieces.push(run.signals);
            }
        }
        Err(none)
    }

    /// All loops, one after the other; the last value holds to the end of the duration that was asked for.
    fn joined(&self) -> Result<Signals, SteerReason> {
        let (mut times, mut values, mut t) = (Vec::new(), Vec::new(), 0.0);
        for piece in &self.pieces {
            let rows = piece.times.len() - 1;
            times.extend(piece.times[..rows].iter().map(|s| t + s));
            values.extend_from_slice(&piece.values[..rows]);
            t += piece.duration();
        }
        if let Some(asked) = self.problem.options.duration {
            if t > asked {
                return Err(SteerReason::TooLong { needed: t });
            }
            t = asked;
        }
        times.push(t);
        values.push(rest_values(&self.model));
        Ok(Signals { times, values, hold: Hold::Previous })
    }
}
