//! The search for the shortest plan.

use super::displacement::ways_round;
use super::oscillation::Oscillation;
use super::planner::{Plan, Planner, cost};
use crate::PlateError;
use std::f64::consts::{FRAC_PI_2, PI};
use std::time::Instant;

/// Shortest and longest duration of a move in s.
const SHORTEST: f64 = 0.24;
const LONGEST: f64 = 4.0;
/// Turn in rad and displacement in m that take about a second: times grow with their square root.
const TURN: f64 = 0.9;
const DISPLACEMENT: f64 = 0.44;
/// Share of that time at which the search begins: shorter moves are tried first, since a program of few intervals is solved
/// fast.
const HOPE: f64 = 0.85;
/// Cost of a miss above which other guesses do not help: the move is too short.
const TOO_SHORT: f64 = 60.0;
/// Cost of a miss that asks for twice the duration, and most growth at a time.
const DOUBLE: f64 = 600.0;
const GROWTH: f64 = 1.3;
/// Cost of a miss that is good enough out of budget, and the growth of durations then.
const NEARLY: f64 = 4.0;
const HASTE: f64 = 1.15;
/// Share of a duration to which the shortest is found.
const RESOLUTION: f64 = 0.05;
/// Frequency in Hz at which guesses have an amplitude of 30 mm and 0.1 rad.
const REFERENCE: f64 = 2.5;
/// Oscillations per second of guesses.
const FREQUENCY: f64 = 2.1;
/// Phases of the displacement before the tilt, and differences in the number of oscillations, in the order of trial.
const GUESSES: [(f64, i32); 6] = [(-FRAC_PI_2, 0), (0.0, 0), (FRAC_PI_2, 0), (PI, 0), (-FRAC_PI_2, 1), (0.0, 1)];

/// What a search for the shortest plan may take.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlanningBudget {
    /// Quadratic programs. A first plan is searched beyond them, with one guess for each duration.
    pub programs: usize,
    /// Wall time in s that takes the place of the number of programs where it ends first. Infinite, plans do not depend on
    /// the machine.
    pub seconds: f64,
}

/// A search for the shortest plan from a state at rest.
pub(super) struct Search<'a> {
    pub(super) planner: &'a Planner,
    pub(super) start: [f64; 10],
    pub(super) target: [f64; 3],
    pub(super) mu: f64,
    pub(super) budget: PlanningBudget,
}

/// The best plan so far, and what has been spent.
struct Progress {
    best: Option<Plan>,
    programs: usize,
    clock: Instant,
}

impl Progress {
    fn is_within(&self, budget: &PlanningBudget) -> bool {
        self.programs < budget.programs && self.clock.elapsed().as_secs_f64() < budget.seconds
    }

    /// Takes a plan into account; returns the cost of its miss.
    fn take(&mut self, plan: Plan) -> f64 {
        let found = cost(&plan.miss);
        self.programs += plan.programs;
        if self.best.as_ref().is_none_or(|best| found < cost(&best.miss) || (found < 1.0 && plan.is_shorter(best))) {
            self.best = Some(plan);
        }
        found
    }
}

impl Search<'_> {
    /// The shortest plan found; where none arrives, the one that misses least; absent if no program could be solved at all.
    /// Short durations are tried first.
    pub(super) fn run(&self) -> Result<Option<Plan>, PlateError> {
        let ways = ways_round(self.start[2], self.target);
        let interval = self.planner.problem().interval();
        let intervals = |seconds: f64| (seconds / interval).ceil() as usize;
        let longest = intervals(LONGEST);
        let mut progress = Progress { best: None, programs: 0, clock: Instant::now() };
        let mut steps = intervals(self.hope(ways[0]).clamp(SHORTEST, LONGEST));
        let mut too_short = 0;
        loop {
            let least = self.attempts(steps, &ways, &mut progress)?;
            let enough = if progress.is_within(&self.budget) { 1.0 } else { NEARLY };
            if least < enough || steps >= longest {
                break;
            }
            too_short = steps;
            let growth = if progress.is_within(&self.budget) { 1.0 + least / DOUBLE } else { HASTE };
            steps = ((steps as f64 * growth.min(GROWTH)) as usize).clamp(steps + 1, longest);
        }
        // What was passed over by great strides.
        while progress.is_within(&self.budget) && (steps - too_short) as f64 > (RESOLUTION * steps as f64).max(1.0) {
            let middle = usize::midpoint(steps, too_short);
            if self.attempts(middle, &ways, &mut progress)? < 1.0 {
                steps = middle;
            } else {
                too_short = middle;
            }
        }
        let programs = progress.programs;
        Ok(progress.best.map(|best| Plan { programs, ..best }))
    }

    /// Duration in s at which the search begins.
    fn hope(&self, target: [f64; 3]) -> f64 {
        let [x, y, yaw]: [f64; 3] = std::array::from_fn(|i| (target[i] - self.start[i]).abs());
        HOPE * (yaw / TURN).max(x.max(y) / DISPLACEMENT).sqrt()
    }

    /// Plans of so many intervals from one guess after the other until one arrives: the least cost of a miss. Out of budget, one
    /// guess is all.
    fn attempts(&self, steps: usize, ways: &[[f64; 3]], progress: &mut Progress) -> Result<f64, PlateError> {
        // Where another duration nearly arrives or arrives, its motion is nearly the right one.
        if let Some(near) = progress.best.as_ref().filter(|best| cost(&best.miss) < TOO_SHORT) {
            let found = progress.take(self.planner.replan(&self.start, self.mu, steps, near)?);
            if found < 1.0 {
                return Ok(found);
            }
        }
        let mut ways: Vec<_> = ways.iter().map(|way| (*way, f64::INFINITY)).collect();
        for guess in GUESSES {
            for (target, least) in &mut ways {
                let swing = self.swing(steps, *target, guess);
                let plan = self.planner.plan(&self.start, *target, self.mu, steps, &swing)?;
                let found = progress.take(plan);
                *least = least.min(found);
                if found < 1.0 {
                    return Ok(found);
                }
            }
            let least = ways.iter().fold(f64::INFINITY, |least, way| least.min(way.1));
            ways.retain(|way| way.1 < TOO_SHORT);
            if ways.is_empty() || !progress.is_within(&self.budget) {
                return Ok(least);
            }
        }
        Ok(ways.iter().fold(f64::INFINITY, |least, way| least.min(way.1)))
    }

    /// An oscillation to start from.
    fn swing(&self, steps: usize, target: [f64; 3], (phase, more): (f64, i32)) -> Oscillation {
        let duration = steps as f64 * self.planner.problem().interval();
        let cycles = ((FREQUENCY * duration).round() + f64::from(more)).max(1.0);
        let frequency = cycles / duration;
        // Accelerations of this size stay within the bounds.
        let slower = (REFERENCE / frequency).powi(2);
        Oscillation {
            frequency,
            displacement: (0.03 * slower).min(0.05),
            tilt: (0.1 * slower).min(0.2).copysign(target[2] - self.start[2]),
            phase,
        }
    }
}
