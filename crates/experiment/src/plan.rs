//! The optimization of an experiment: from several starts, the best is kept.

use crate::composed::Composed;
use crate::options::{ExperimentError, ExperimentOptions};
use crate::setup::Setup;
use crate::signals::Signals;
use bracketry_mpc::ocp::{Bounds, Softness, Substeps};
use bracketry_mpc::{CostFunction, Integrator, Ocp, PlannedTrajectory, Sqp, SqpSettings, SymbolicDynamics};
use bracketry_sim::Hold;
use std::time::Instant;

/// Most programs of a start: what the interior-point method does not solve, they rarely do.
const PROGRAMS: usize = 5;
/// Change of a state, as a share of its size, up to which more integration steps do not matter to a plan.
const ACCURATE: f64 = 1e-3;
/// Most integration steps per piece by the explicit method.
const MOST_SUBSTEPS: usize = 32;

/// Values of what is chosen, one row per piece of the inputs: the inputs, or their rates where these are limited.
pub(crate) type Pieces = Vec<Vec<f64>>;

/// The optimization of one criterion.
pub(crate) struct Plan {
    sqp: Sqp,
    terminal: CostFunction,
    x0: Vec<f64>,
}

impl Plan {
    /// The problem of a composed system with this cost of the end. The limits of states are narrowed by `margins`, shares of their widths.
    /// `starts` are inputs that show how large the states become.
    pub(crate) fn new(
        composed: &Composed,
        terminal: CostFunction,
        setup: &Setup,
        margins: &[f64],
        starts: &[Pieces],
        options: &ExperimentOptions,
    ) -> Result<Self, ExperimentError> {
        let (n, m, steps) = (composed.x0.len(), setup.inputs.len(), setup.pieces.len() - 1);
        let mut ocp = Ocp::new(n, m, steps, setup.length(0));
        ocp.lengths = (0..steps).map(|k| setup.length(k)).collect();
        ocp.terminal = Some(terminal.clone());
        for (j, input) in setup.inputs.iter().enumerate() {
            let chosen = if setup.is_linear() { setup.rate(j) } else { input.range };
            ocp.input_bounds[j] = (chosen[0], chosen[1]);
            ocp.input_trust[j] = (chosen[1] - chosen[0]) / 2.0;
            if setup.is_linear() {
                let [min, max] = input.range;
                ocp.state_bounds[j] = Bounds { min, max, softness: Softness::Hard };
            }
        }
        for &(at, limit) in &composed.limited {
            let (l, margin) = (&setup.states[limit], margins[limit]);
            let room = margin.min(0.45) * (l.high - l.low);
            let start = composed.x0[at];
            // The start stays inside.
            let (min, max) = ((l.low + room).min(start), (l.high - room).max(start));
            ocp.state_bounds[at] = Bounds { min, max, softness: Softness::Hard };
        }
        let dynamics = SymbolicDynamics::new(&composed.system)?;
        let settings = SqpSettings {
            max_iterations: PROGRAMS,
            filter_iterations: PROGRAMS,
            stop: options.stop.clone(),
            ..SqpSettings::default()
        };
        let mut rolled = |ocp: &Ocp| -> Result<Vec<f64>, ExperimentError> {
            let mut sqp = Sqp::new(Box::new(dynamics.clone()), ocp.clone(), settings.clone())?;
            let mut sizes = vec![0.0; n];
            for inputs in starts {
                let guess = sqp.guess(&composed.x0, inputs)?;
                sizes.iter_mut().zip(largest(&guess)).for_each(|(s, v): (&mut f64, f64)| *s = s.max(v));
            }
            Ok(sizes)
        };
        choose_integration(&mut ocp, &mut rolled)?;
        let sizes = rolled(&ocp)?;
        ocp.state_scale = sizes.into_iter().map(|s| if s > 0.0 && s.is_finite() { s } else { 1.0 }).collect();
        Ok(Self { sqp: Sqp::new(Box::new(dynamics), ocp, settings)?, terminal, x0: composed.x0.clone() })
    }

    /// The criterion under inputs; infinite where it is no number.
    pub(crate) fn value(&mut self, inputs: &Pieces) -> Result<f64, ExperimentError> {
        let rolled = self.sqp.guess(&self.x0, inputs)?;
        let value = self.terminal.value(rolled.x(rolled.steps()), &[], 0.0, &[]);
        Ok(if value.is_finite() { value } else { f64::INFINITY })
    }

    /// What the solver makes of a start, with the criterion of its inputs; none where that is no number.
    pub(crate) fn improve(&mut self, start: &Pieces) -> Result<Option<(f64, Pieces)>, ExperimentError> {
        let guess = self.sqp.guess(&self.x0, start)?;
        if !guess.is_finite() {
            return Ok(None);
        }
        let found = self.sqp.solve(&self.x0, &guess)?.trajectory;
        let inputs: Pieces = (0..found.steps()).map(|k| found.u(k).to_vec()).collect();
        if !inputs.iter().flatten().all(|v| v.is_finite()) {
            return Ok(None);
        }
        let value = self.value(&inputs)?;
        Ok(value.is_finite().then_some((value, inputs)))
    }
}

fn largest(trajectory: &PlannedTrajectory) -> Vec<f64> {
    let rows = (0..=trajectory.steps()).map(|k| trajectory.x(k));
    rows.fold(vec![0.0; trajectory.states()], |mut sizes: Vec<f64>, x| {
        sizes.iter_mut().zip(x).for_each(|(s, v)| *s = if v.is_nan() { f64::INFINITY } else { s.max(v.abs()) });
        sizes
    })
}

/// As many integration steps as are needed for the states under the starts to be accurate; where that takes too many, an implicit method.
fn choose_integration(
    ocp: &mut Ocp,
    rolled: &mut impl FnMut(&Ocp) -> Result<Vec<f64>, ExperimentError>,
) -> Result<(), ExperimentError> {
    let mut last: Option<Vec<f64>> = None;
    let mut substeps = 1;
    while substeps <= MOST_SUBSTEPS {
        ocp.substeps = Substeps::Fixed(substeps);
        let sizes = rolled(ocp)?;
        let settled = |before: &Vec<f64>| {
            let finite = sizes.iter().all(|s| s.is_finite());
            finite && sizes.iter().zip(before).all(|(a, b)| (a - b).abs() <= ACCURATE * a.max(f64::MIN_POSITIVE))
        };
        if last.as_ref().is_some_and(settled) {
            ocp.substeps = Substeps::Fixed(substeps / 2);
            return Ok(());
        }
        last = Some(sizes);
        substeps *= 2;
    }
    ocp.integrator = Integrator::RadauIIA { stages: 2 };
    ocp.substeps = Substeps::Fixed(4);
    Ok(())
}

impl Setup {
    /// Length of a piece, s.
    pub(crate) fn length(&self, piece: usize) -> f64 {
        (self.pieces[piece + 1] - self.pieces[piece]) as f64 * self.sample
    }

    /// What is chosen so that the inputs follow these values, as far as their rates allow.
    pub(crate) fn chosen(&self, wanted: &[Vec<f64>]) -> Pieces {
        if !self.is_linear() {
            return wanted.to_vec();
        }
        let mut now = self.rest();
        let piece = |(k, row): (usize, &Vec<f64>)| {
            let length = self.length(k);
            let rates = row.iter().zip(&mut now).enumerate().map(|(j, (to, now))| {
                let [low, high] = self.rate(j);
                let rate = ((to - *now) / length).clamp(low, high);
                *now += rate * length;
                rate
            });
            rates.collect()
        };
        wanted.iter().enumerate().map(piece).collect()
    }

    /// The inputs at the samples.
    pub(crate) fn signals(&self, pieces: &Pieces) -> Signals {
        let mut values = Vec::with_capacity(self.times.len());
        let mut now = self.rest();
        for (k, row) in pieces.iter().enumerate() {
            for _ in self.pieces[k]..self.pieces[k + 1] {
                if self.is_linear() {
                    values.push(self.clamped(now.clone()));
                    now.iter_mut().zip(row).for_each(|(u, rate)| *u += rate * self.sample);
                } else {
                    values.push(self.clamped(row.clone()));
                }
            }
        }
        if let (true, Some(first)) = (self.is_late, values.first_mut()) {
            *first = self.rest();
        }
        let last = if self.is_linear() { self.clamped(now) } else { values.last().cloned().unwrap_or_default() };
        values.push(last);
        let hold = if self.is_linear() { Hold::Linear } else { Hold::Previous };
        let names = self.inputs.iter().map(|u| u.name.clone()).collect();
        Signals { times: self.times.clone(), names, values, hold }
    }

    fn clamped(&self, mut row: Vec<f64>) -> Vec<f64> {
        row.iter_mut().zip(&self.inputs).for_each(|(v, u)| *v = v.clamp(u.range[0], u.range[1]));
        row
    }
}

/// Share of the time limit after which no further optimization starts: the rest is for the one that runs, and for exact simulations.
const SHARE: f64 = 0.6;

/// The time at which no further start is tried.
pub(crate) fn deadline(options: &ExperimentOptions) -> Option<Instant> {
    options.time_limit.and_then(|limit| Instant::now().checked_add(limit.mul_f64(SHARE)))
}
