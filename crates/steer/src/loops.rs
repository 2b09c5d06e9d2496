//! Steering from rest to rest: full loops until the end is near, then shorter ones that meet it.

use bracketry_numerics::least_squares::{Damping, Settings, minimize};
use bracketry_sim::Hold;
use bracketry_symbolic::Rational;
use bracketry_system::Point;
use nalgebra::DVector;

use crate::from_rest::decide;
use crate::from_rest::displacement::{Displaced, Plant, at_rest};
use crate::from_rest::model::RestModel;
use crate::from_rest::span::{LEAST_MARGIN, Spanned, fewest, sizes, spanned};
use crate::from_rest::strokes::{self, Loop, rest_values};
use crate::from_rest::{FromRestReason, Motion};
use crate::problem::{Outcome, Planned, Problem};
use crate::signals::Signals;
use crate::steering::{Plan, SteerReason};

/// Most full loops.
const MAX_LOOPS: usize = 1000;
/// The last loops are this part of the full ones, or more: shorter ones of some families move nothing.
const SHORTEST: f64 = 0.2;
const SHORTEST_SCALE: f64 = 0.01;
/// Durations of the full loops, relative to the first ones: shorter where a loop cannot be closed, or cannot be simulated.
const LONGEST: [f64; 8] = [1.0, 0.99, 0.95, 0.9, 0.7, 0.5, 0.35, 0.25];
/// Bisections of the duration of a loop with a given displacement.
const BISECTIONS: usize = 30;
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
            if let Some(change) = moved.filter(|change| decide::is_displaced(change, &start)) {
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

    /// The longest loops that end at rest from a place, with their scales.
    fn longest(&mut self, from: &[f64]) -> Option<Vec<(f64, Displaced)>> {
        let mut list = Vec::new();
        for stroke in &self.loops {
            let runs = LONGEST.iter().find_map(|&s| {
                let run = self.plant.displaced(&self.model, from, stroke, s)?;
                decide::is_displaced(&run.change, from).then_some((s, run))
            });
            list.push(runs?);
        }
        Some(list)
    }

    /// A difference in units of the sizes.
    fn scaled(&self, difference: &[f64]) -> Vec<f64> {
        scaled(difference, &self.sizes)
    }

    /// Full loops toward the end until it is met by shorter ones.
    fn approach(&mut self) -> Outcome {
        let end = self.coordinates(&self.problem.options.to);
        let mut here = self.coordinates(&self.problem.options.from);
        for _ in 0..MAX_LOOPS {
            if self.problem.is_over() {
                return Err(SteerReason::Stopped);
            }
            let none = SteerReason::EndError { error: f64::INFINITY };
            let runs = self.longest(&here).ok_or(none.clone())?;
            let (scales, full): (Vec<f64>, Vec<Vec<f64>>) =
                runs.iter().map(|(scale, run)| (*scale, run.change.clone())).unzip();
            let gap: Vec<f64> = end.iter().zip(&here).map(|(b, a)| b - a).collect();
            if let Some(parts) = self.combined(&full, &gap, [SHORTEST, 1.0], 0.5 * (1.0 + SHORTEST)) {
                return self.meet(&here, &end, &full, &scales, &parts);
            }
            // How often each loop is run if displacements stay as they are; the one that is needed most is next.
            let often = self.combined(&full, &gap, [0.0, MAX_LOOPS as f64], 0.0).ok_or(none.clone())?;
            let next = (0..often.len()).max_by(|&a, &b| often[a].total_cmp(&often[b])).ok_or(none)?;
            here.iter_mut().zip(&full[next]).for_each(|(q, d)| *q += d);
            self.pieces.extend(runs.into_iter().nth(next).map(|(_, run)| run.signals));
        }
        Err(SteerReason::EndError { error: f64::INFINITY })
    }

    /// Multiples of the full displacements, within limits, that add up to a gap; `None` if there are none.
    fn combined(&self, full: &[Vec<f64>], gap: &[f64], limits: [f64; 2], start: f64) -> Option<Vec<f64>> {
        let (columns, wanted): (Vec<Vec<f64>>, _) = (full.iter().map(|d| self.scaled(d)).collect(), self.scaled(gap));
        let mut parts = Parts { columns, wanted, limits: vec![limits; full.len()] };
        let start = DVector::from_element(full.len(), start);
        let settings = Settings { iterations: 200, enough: 1e-9, ..Settings::default() };
        let found = minimize(&mut parts, &start, &settings)?;
        (found.residual.amax() <= 1e-6).then(|| found.at.iter().copied().collect())
    }

    /// The last loops: durations whose displacements add up to the gap, first one by one, then together on the plant.
    fn meet(&mut self, here: &[f64], end: &[f64], full: &[Vec<f64>], longest: &[f64], parts: &[f64]) -> Outcome {
        let mut start = DVector::zeros(parts.len());
        for k in 0..parts.len() {
            let toward = self.scaled(&full[k]);
            let sizes = self.sizes.clone();
            let length = |d: &[f64]| -> f64 { scaled(d, &sizes).iter().zip(&toward).map(|(a, b)| a * b).sum() };
            let whole = length(&full[k]);
            let (mut low, mut high) = (0.0, longest[k]);
            for _ in 0..BISECTIONS {
                let middle = 0.5 * (low + high);
                let stroke = self.loops[k].clone();
                let reaches = self.plant.displaced(&self.model, here, &stroke, middle);
                let part = reaches.map_or(0.0, |d| length(&d.change) / whole);
                if part < parts[k] { low = middle } else { high = middle }
            }
            start[k] = high;
        }
        let limits = longest.iter().map(|&s| [SHORTEST_SCALE * s, s]).collect();
        let mut last = Last { planner: self, here, end, limits };
        let settings = Settings {
            damping: Damping { least: 1e-15, trials: 8, ..Damping::default() },
            iterations: 30,
            enough: 1e-11,
            ..Settings::default()
        };
        let found = minimize(&mut last, &start, &settings).ok_or(SteerReason::EndError { error: f64::INFINITY })?;
        let (_, run) = last.run(&found.at).ok_or(SteerReason::EndError { error: f64::INFINITY })?;
        self.pieces.extend(run);
        let loops = self.pieces.len();
        let signals = self.joined()?;
        Ok(vec![Planned { signals, plan: Plan::Loops { loops, shapes: self.loops.len() } }])
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

fn scaled(difference: &[f64], sizes: &[f64]) -> Vec<f64> {
    difference.iter().zip(sizes).map(|(d, s)| if *s > 0.0 { d / s } else { 0.0 }).collect()
}

/// The linear problem of the parts.
struct Parts {
    columns: Vec<Vec<f64>>,
    wanted: Vec<f64>,
    limits: Vec<[f64; 2]>,
}

impl bracketry_numerics::least_squares::Problem for Parts {
    fn residual(&mut self, at: &DVector<f64>) -> Option<DVector<f64>> {
        let sum = |i: usize| self.columns.iter().zip(at.iter()).map(|(c, h)| c[i] * h).sum::<f64>();
        Some(DVector::from_fn(self.wanted.len(), |i, _| sum(i) - self.wanted[i]))
    }

    fn limits(&self) -> &[[f64; 2]] {
        &self.limits
    }
}

/// What is left to the end as a function of the durations of the last loops.
struct Last<'a, 'p> {
    planner: &'a mut Planner<'p>,
    here: &'a [f64],
    end: &'a [f64],
    limits: Vec<[f64; 2]>,
}

impl Last<'_, '_> {
    /// The end of the loops, and their signals.
    fn run(&mut self, scales: &DVector<f64>) -> Option<(Vec<f64>, Vec<Signals>)> {
        let mut place = self.here.to_vec();
        let mut list = Vec::new();
        for (k, &scale) in scales.iter().enumerate() {
            if self.planner.problem.is_over() {
                return None;
            }
            let planner = &mut *self.planner;
            let run = planner.plant.displaced(&planner.model, &place, &planner.loops[k], scale)?;
            place.iter_mut().zip(&run.change).for_each(|(q, d)| *q += d);
            list.push(run.signals);
        }
        Some((place, list))
    }
}

impl bracketry_numerics::least_squares::Problem for Last<'_, '_> {
    fn residual(&mut self, at: &DVector<f64>) -> Option<DVector<f64>> {
        let (place, _) = self.run(at)?;
        Some(DVector::from_fn(place.len(), |i, _| place[i] - self.end[i]))
    }

    fn limits(&self) -> &[[f64; 2]] {
        &self.limits
    }
}
