//! Controller and plant together, with all that stands between them: what is measured, how well, how late, and what fails.

use super::counts::{Counts, PhaseTimes, SolveTimes};
use super::faults::{Fault, disturb, lose};
use super::plant::Plant;
use crate::controller::{Controller, Step, StepLimits, StepStatus, Timings};
use crate::error::{MpcError, check_flag, check_length};
use crate::ocp::Ocp;
use crate::trajectory::PlannedTrajectory;
use bracketry_symbolic::StopFlag;
use std::collections::VecDeque;

/// Measured outputs as a function of time (s) and state.
pub type MeasurementFunction<'a> = Box<dyn FnMut(f64, &[f64]) -> Vec<f64> + 'a>;
/// Changes the measured outputs of sample k.
pub type NoiseFunction<'a> = Box<dyn FnMut(usize, &mut [f64]) + 'a>;
/// What goes wrong at sample k.
pub type FaultFunction<'a> = Box<dyn FnMut(usize) -> Vec<Fault> + 'a>;

/// What stands between controller and plant. The default: the state is measured exactly and at once, and nothing fails.
#[derive(Default)]
pub struct LoopSettings<'a> {
    /// The measured outputs; the states themselves when there is none.
    pub measurement: Option<MeasurementFunction<'a>>,
    /// Noise on the measured outputs.
    pub noise: Option<NoiseFunction<'a>>,
    /// Samples between the measurement that an input answers and its application. A controller that knows of them is a
    /// [`DelayCompensated`](crate::closed_loop::DelayCompensated) one.
    pub delay: usize,
    /// Input before the first decision acts: that of the first `delay` samples, and what rates of inputs start from; zero when
    /// empty.
    pub initial_input: Vec<f64>,
    /// What goes wrong.
    pub faults: Option<FaultFunction<'a>>,
    /// Whether the plan of every sample is kept.
    pub keep_predictions: bool,
    /// Once it is raised, the loop ends with [`MpcError::Stopped`] at its next sample.
    pub stop: StopFlag,
}

/// One sample of a closed loop.
#[derive(Clone, Debug, PartialEq)]
pub struct Sample {
    /// Time, s.
    pub t: f64,
    /// State of the plant at that time.
    pub x: Vec<f64>,
    /// Measured outputs.
    pub y: Vec<f64>,
    /// State handed to the controller: estimated, or the measured outputs.
    pub estimate: Vec<f64>,
    /// Standard deviations of the estimated state as the estimator states them; empty without an estimator.
    pub deviation: Vec<f64>,
    /// Input applied from that time on.
    pub u: Vec<f64>,
    /// What the controller answered; with a delay its input is applied later.
    pub step: Step,
    /// The plan behind the answer, where predictions are kept.
    pub prediction: Option<PlannedTrajectory>,
}

/// A closed loop that is run sample by sample and keeps nothing of the past but counts and cost.
pub struct SampledLoop<'a> {
    controller: &'a mut dyn Controller,
    plant: &'a mut dyn Plant,
    settings: LoopSettings<'a>,
    ocp: Ocp,
    k: usize,
    x: Vec<f64>,
    pending: VecDeque<Vec<f64>>,
    /// Input applied over the interval before.
    before: Vec<f64>,
    cost: f64,
    counts: Counts,
}

impl<'a> SampledLoop<'a> {
    /// A loop at time 0 in the state `x0`.
    ///
    /// # Errors
    /// If a length is wrong.
    pub fn new(
        controller: &'a mut dyn Controller,
        plant: &'a mut dyn Plant,
        x0: &[f64],
        settings: LoopSettings<'a>,
    ) -> Result<Self, MpcError> {
        let mut ocp = controller.ocp().clone();
        // What is done costs what the norms are.
        ocp.round_norms(0.0);
        check_length("the initial state", x0.len(), ocp.model_states())?;
        let first =
            if settings.initial_input.is_empty() { vec![0.0; ocp.inputs()] } else { settings.initial_input.clone() };
        check_length("the initial input", first.len(), ocp.inputs())?;
        let (pending, before) = (vec![first.clone(); settings.delay].into(), first);
        let (x, cost, counts) = (x0.to_vec(), 0.0, Counts::default());
        Ok(Self { controller, plant, settings, ocp, k: 0, x, pending, before, cost, counts })
    }

    /// Time, s.
    pub fn time(&self) -> f64 {
        self.k as f64 * self.ocp.dt
    }

    /// State of the plant.
    pub fn state(&self) -> &[f64] {
        &self.x
    }

    /// Σ dt·stage cost at the samples so far.
    pub fn cost(&self) -> f64 {
        self.cost
    }

    /// Outcomes of the samples so far.
    pub fn counts(&self) -> &Counts {
        &self.counts
    }

    /// Runs one sample: disturb, measure, estimate, decide, apply.
    ///
    /// # Errors
    /// If a length is wrong or the plant stops ([`MpcError::Plant`]).
    pub fn sample(&mut self) -> Result<Sample, MpcError> {
        check_flag(&self.settings.stop)?;
        let (k, t, dt) = (self.k, self.time(), self.ocp.dt);
        let faults = self.settings.faults.as_mut().map_or_else(Vec::new, |f| f(k));
        disturb(&faults, &mut self.x);
        let x = self.x.clone();
        let mut y = match &mut self.settings.measurement {
            Some(measure) => measure(t, &x),
            None => x.clone(),
        };
        if let Some(noise) = &mut self.settings.noise {
            noise(k, &mut y);
        }
        lose(&faults, &mut y);
        let limits = StepLimits::of(&faults);
        if limits != StepLimits::default() {
            self.controller.limit_next_step(limits);
        }
        let step = self.controller.feedback(&y)?.clone();
        let prediction = self.settings.keep_predictions.then(|| self.controller.plan().clone());
        self.controller.shift();
        let estimate = self.controller.estimate().map_or_else(|| y.clone(), |e| e.x.clone());
        let deviation =
            self.controller.estimate().map_or_else(Vec::new, |e| e.std.iter().take(e.x.len()).copied().collect());
        self.pending.push_back(step.u.clone());
        let u = self.pending.pop_front().unwrap_or_else(|| step.u.clone());
        self.counts.add(&step);
        let mut at = x.clone();
        self.ocp.append_previous(&mut at, &self.before);
        self.before.copy_from_slice(&u);
        self.cost += dt * self.ocp.stage_cost(k, t, &at, &u);
        self.plant.step(t, &mut self.x, &u, dt).map_err(|source| MpcError::Plant { time: t, source })?;
        self.k += 1;
        Ok(Sample { t, x, y, estimate, deviation, u, step, prediction })
    }
}

/// A closed-loop run.
#[derive(Clone, Debug)]
pub struct ClosedLoop {
    /// Sampled times, s; one more than inputs.
    pub t: Vec<f64>,
    /// States at these times.
    pub x: Vec<Vec<f64>>,
    /// Measured outputs of each sample.
    pub y: Vec<Vec<f64>>,
    /// States handed to the controller: estimated, or the measured outputs.
    pub estimates: Vec<Vec<f64>>,
    /// Standard deviations of the estimates, as the estimator states them; empty without an estimator.
    pub deviations: Vec<Vec<f64>>,
    /// Inputs applied from each time on.
    pub u: Vec<Vec<f64>>,
    /// Outcome of each sample.
    pub steps: Vec<Step>,
    /// The plan behind each input, where predictions are kept. With delay compensation it starts where the input begins to act.
    pub predictions: Vec<PlannedTrajectory>,
    /// Σ dt·stage cost at the sampled states with the applied inputs.
    pub cost: f64,
    /// Counted outcomes.
    pub counts: Counts,
    /// Times per sample.
    pub times: SolveTimes,
    /// The same by phase.
    pub phases: PhaseTimes,
}

/// Runs `controller` on `plant` from `x0` for a number of samples.
///
/// # Errors
/// If a length is wrong or the plant stops ([`MpcError::Plant`]).
pub fn run_closed_loop(
    controller: &mut dyn Controller,
    plant: &mut dyn Plant,
    x0: &[f64],
    samples: usize,
    settings: LoopSettings<'_>,
) -> Result<ClosedLoop, MpcError> {
    let mut sampled = SampledLoop::new(controller, plant, x0, settings)?;
    let mut run = ClosedLoop {
        t: Vec::with_capacity(samples + 1),
        x: Vec::with_capacity(samples + 1),
        y: Vec::with_capacity(samples),
        estimates: Vec::with_capacity(samples),
        deviations: Vec::with_capacity(samples),
        u: Vec::with_capacity(samples),
        steps: Vec::with_capacity(samples),
        predictions: Vec::new(),
        cost: 0.0,
        counts: Counts::default(),
        times: SolveTimes::default(),
        phases: PhaseTimes::default(),
    };
    for _ in 0..samples {
        let sample = sampled.sample()?;
        run.t.push(sample.t);
        run.x.push(sample.x);
        run.y.push(sample.y);
        run.estimates.push(sample.estimate);
        run.deviations.push(sample.deviation);
        run.u.push(sample.u);
        run.steps.push(sample.step);
        run.predictions.extend(sample.prediction);
    }
    run.t.push(sampled.time());
    run.x.push(sampled.state().to_vec());
    run.cost = sampled.cost();
    run.counts = *sampled.counts();
    let timings: Vec<Timings> =
        run.steps.iter().filter(|s| s.status != StepStatus::PlayedOut).map(|s| s.timings).collect();
    run.times = SolveTimes::of(&timings.iter().map(Timings::total).collect::<Vec<f64>>());
    run.phases = PhaseTimes::of(&timings);
    Ok(run)
}
