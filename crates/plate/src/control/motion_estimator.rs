//! Where the object is and how fast, and what it is like, from measured poses.
//!
//! Since the object starts from rest, its motion is known up to the parameters of [`super::learned`] and a small offset. A filter
//! (Kalman 1960, on exact simulations instead of linear models) estimates them sample by sample. When the parameters leave the
//! neighborhood of the simulations, these are made anew about the estimate and the record since the last rest is filtered again;
//! at rest this is repeated over the records of all moves until nothing changes, which is Gauss and Newton's method for the most
//! likely parameters, with the offset as a random walk.

use super::interface::Command;
use super::learned::{
    Estimate, LATENCY, Learned, OF_OBJECT, PARAMETERS, Parameters, bounded, first_belief, object_of, validate,
};
use super::model_family::ModelFamily;
use super::settings::PoseSettings;
use crate::{Object, PlateError, PlateKinematics};
use nalgebra::{SMatrix, SVector};

/// Offset and parameters.
const STATES: usize = 3 + PARAMETERS;
type Vector = SVector<f64, STATES>;
type Matrix = SMatrix<f64, STATES, STATES>;

/// Growth of the offset's standard deviation in the first second of motion (a random walk): m and rad.
const DRIFT: [f64; 2] = [2e-3, 2e-2];
/// The same of the coefficient's logarithm.
const WANDER: f64 = 0.01;
/// Innovations beyond this many standard deviations are taken for a push or an outlier.
const GATE: f64 = 6.0;
/// Those beyond this many count as if their noise were as much larger (Huber 1964).
const ROBUST: f64 = 2.5;
/// Least standard deviation of a measurement: m and rad.
const LEAST_NOISE: [f64; 2] = [1e-6, 1e-5];
/// Least and greatest distance of the simulations on either side.
const STEPS: [[f64; 2]; OF_OBJECT] = [[0.03, 0.12], [0.06, 0.2], [5e-4, 3e-3], [5e-4, 3e-3]];
/// Distance in steps at which simulations are made anew on the way, and how far they go at once.
const STRAYED: f64 = 1.5;
const STRIDE: f64 = 3.0;
/// Samples of the record that new simulations catch up with while one is measured.
const CATCH_UP: usize = 4;
/// Rounds over the records at rest, and the change in steps that ends them.
const ROUNDS: usize = 4;
const SETTLED: f64 = 0.3;
/// Moves whose records are kept, and samples at rest that are.
const RUNS: usize = 4;
const RESTING: usize = 40;
/// Standard deviations by which what has been learned may be off in the next move.
const CHANGE: Parameters = [0.015, 0.03, 3e-4, 3e-4, 3e-4];

/// A sample: the plate's motion up to it, and what was measured then.
#[derive(Debug, Clone)]
struct Sample {
    plate: PlateKinematics,
    acted: Command,
    pose: [f64; 3],
}

/// What was recorded from one rest to the next.
#[derive(Debug, Clone)]
struct Run {
    start: [f64; 3],
    /// Variances of the start.
    variance: [f64; 3],
    samples: Vec<Sample>,
    moved: bool,
    resting: usize,
}

/// Offset and parameters with their covariance.
#[derive(Debug, Clone)]
struct Filter {
    estimate: Vector,
    covariance: Matrix,
    surprises: usize,
}

impl Filter {
    fn parameters(&self) -> Parameters {
        std::array::from_fn(|i| self.estimate[3 + i])
    }

    /// Begins a run: the offset is that of its start.
    fn begin(&mut self, variance: [f64; 3]) {
        self.surprises = 0;
        for (i, variance) in variance.into_iter().enumerate() {
            self.estimate[i] = 0.0;
            self.covariance.row_mut(i).fill(0.0);
            self.covariance.column_mut(i).fill(0.0);
            self.covariance[(i, i)] = variance;
        }
    }

    /// What a period of motion adds to the uncertainty.
    fn drift(&mut self, period: f64) {
        for i in 0..3 {
            self.covariance[(i, i)] += DRIFT[i / 2].powi(2) * period;
        }
        if self.covariance[(3, 3)] > 0.0 {
            self.covariance[(3, 3)] += WANDER.powi(2) * period;
        }
    }

    /// Takes in a measured pose, but for one that does not fit at all.
    fn take(&mut self, family: &ModelFamily, pose: &[f64; 3], noise: &[f64; 3], period: f64) {
        if pose.iter().any(|v| !v.is_finite()) {
            return;
        }
        let before = self.estimate;
        let seen = family.seen(&self.parameters(), period);
        let rows: [Vector; 3] = std::array::from_fn(|i| {
            let mut row = Vector::zeros();
            row[i] = 1.0;
            row.fixed_rows_mut::<PARAMETERS>(3).copy_from_slice(&seen.slopes[i]);
            row
        });
        let predicted: [f64; 3] = std::array::from_fn(|i| seen.pose[i] + before[i]);
        let variance = |filter: &Self, i: usize| rows[i].dot(&(filter.covariance * rows[i])) + noise[i].powi(2);
        let surprising = (0..3)
            .any(|i| (pose[i] - predicted[i]).abs() > GATE * variance(self, i).sqrt() + 20.0 * LEAST_NOISE[i / 2]);
        self.surprises = if surprising { self.surprises + 1 } else { 0 };
        if surprising {
            if self.surprises < 3 {
                return;
            }
            // Not an outlier: something has pushed the object, or the model is wrong.
            for i in 0..3 {
                self.covariance[(i, i)] += (10.0 * DRIFT[i / 2]).powi(2);
            }
        }
        for i in 0..3 {
            let row = rows[i];
            let innovation = pose[i] - predicted[i] - row.dot(&(self.estimate - before));
            let expected = variance(self, i);
            let excess = (innovation.abs() / (ROBUST * expected.sqrt())).max(1.0);
            let gain_of = self.covariance * row;
            let gain = gain_of / (expected * excess);
            self.estimate += gain * innovation;
            self.covariance -= gain * gain_of.transpose();
            self.covariance = 0.5 * (self.covariance + self.covariance.transpose());
        }
        let mut parameters = self.parameters();
        bounded(&mut parameters);
        self.estimate.fixed_rows_mut::<PARAMETERS>(3).copy_from_slice(&parameters);
    }
}

/// The estimator.
#[derive(Debug, Clone)]
pub(super) struct MotionEstimator {
    /// The object that is believed in at first.
    object: Object,
    period: f64,
    noise: [f64; 3],
    /// What is believed before anything is measured, without the offset.
    first: Filter,
    /// The same at the beginning of the run.
    prior: Filter,
    filter: Filter,
    family: ModelFamily,
    /// Other simulations that are to take the place of these, and how many samples of the run they have seen.
    next: Option<(ModelFamily, Filter, usize)>,
    run: Run,
    runs: Vec<Run>,
    /// Whether there are records that nothing has been learned from.
    unlearned: bool,
}

impl MotionEstimator {
    /// The object at rest at a measured pose.
    pub(super) fn new(object: &Object, settings: &PoseSettings, pose: [f64; 3]) -> Result<Self, PlateError> {
        let uncertainty = settings.uncertainty;
        validate(&uncertainty, settings.mu_deviation)?;
        let [position, yaw] = [0, 1].map(|i| settings.noise[i].max(LEAST_NOISE[i]));
        let noise = [position, position, yaw];
        let mut first = Filter { estimate: Vector::zeros(), covariance: Matrix::zeros(), surprises: 0 };
        first.estimate.fixed_rows_mut::<PARAMETERS>(3).copy_from_slice(&first_belief(object, settings.mu));
        let (scale, center) = (uncertainty.scale, uncertainty.center_of_mass);
        let deviations = [settings.mu_deviation, scale, center, center, uncertainty.latency];
        for (i, deviation) in deviations.into_iter().enumerate() {
            first.covariance[(3 + i, 3 + i)] = deviation * deviation;
        }
        let variance = noise.map(|n| n * n);
        let mut filter = first.clone();
        filter.begin(variance);
        let mut family = ModelFamily::new(object, first.parameters(), steps(&first))?;
        family.place(pose)?;
        let run = Run { start: pose, variance, samples: Vec::new(), moved: false, resting: 0 };
        Ok(Self {
            object: object.clone(),
            period: settings.period,
            noise,
            prior: first.clone(),
            first,
            filter,
            family,
            next: None,
            run,
            runs: Vec::new(),
            unlearned: false,
        })
    }

    /// The object as it is known, and its friction coefficient.
    pub(super) fn object(&self) -> (Object, f64) {
        object_of(&self.object, &self.filter.parameters())
    }

    /// What has been learned; the lag of the servo is not known here.
    pub(super) fn learned(&self) -> Learned {
        let at = |i: usize| Estimate {
            value: self.filter.estimate[3 + i],
            deviation: self.filter.covariance[(3 + i, 3 + i)].max(0.0).sqrt(),
        };
        let share = |i: usize| {
            let Estimate { value, deviation } = at(i);
            Estimate { value: value.exp(), deviation: value.exp() * deviation }
        };
        Learned {
            mu: share(0),
            scale: share(1),
            center_of_mass: [at(2), at(3)],
            latency: at(LATENCY),
            servo_lag: Estimate::default(),
        }
    }

    /// The state `x, y, phi, vx, vy, w`.
    pub(super) fn state(&self) -> [f64; 6] {
        let state = self.family.state(&self.filter.parameters());
        std::array::from_fn(|i| if i < 3 { state[i] + self.filter.estimate[i] } else { state[i] })
    }

    /// Standard deviations of x, y and yaw.
    pub(super) fn deviation(&self) -> [f64; 3] {
        let mut now = self.filter.parameters();
        now[LATENCY] = 0.0;
        let seen = self.family.seen(&now, self.period);
        std::array::from_fn(|i| {
            let mut row = Vector::zeros();
            row[i] = 1.0;
            row.fixed_rows_mut::<OF_OBJECT>(3).copy_from_slice(&seen.slopes[i][..OF_OBJECT]);
            row.dot(&(self.filter.covariance * row)).max(0.0).sqrt()
        })
    }

    /// Whether the object rests whatever it is like.
    pub(super) fn at_rest(&self) -> bool {
        self.family.at_rest()
    }

    /// Moves on by a period of the plate's motion and takes in the pose that is measured then.
    pub(super) fn step(&mut self, plate: &PlateKinematics, acted: Command, pose: &[f64; 3]) -> Result<(), PlateError> {
        let sample = Sample { plate: *plate, acted, pose: *pose };
        filtered(&mut self.family, &mut self.filter, &sample, &self.noise, self.period)?;
        if self.at_rest() {
            self.run.resting += 1;
        } else {
            (self.run.moved, self.run.resting, self.unlearned) = (true, 0, true);
        }
        if self.run.resting <= RESTING {
            self.run.samples.push(sample);
        }
        if self.next.is_some() {
            self.catch_up()
        } else if self.family.distance(&self.filter.parameters()) > STRAYED {
            let mut family = self.centered()?;
            family.place(self.run.start)?;
            self.next = Some((family, self.prior.clone(), 0));
            Ok(())
        } else {
            Ok(())
        }
    }

    /// Filters a part of the record with the next simulations; once they have seen all of it, they take over.
    fn catch_up(&mut self) -> Result<(), PlateError> {
        let Some((mut family, mut filter, seen)) = self.next.take() else { return Ok(()) };
        let all = self.run.samples.len();
        let end = if self.at_rest() { all } else { all.min(seen + CATCH_UP) };
        for sample in &self.run.samples[seen.min(end)..end] {
            filtered(&mut family, &mut filter, sample, &self.noise, self.period)?;
        }
        if end == all {
            (self.family, self.filter) = (family, filter);
        } else {
            self.next = Some((family, filter, end));
        }
        Ok(())
    }

    /// Simulations about the estimate, or as far toward it as they may go at once.
    fn centered(&self) -> Result<ModelFamily, PlateError> {
        let (mut parameters, distance) = (self.filter.parameters(), self.family.distance(&self.filter.parameters()));
        if distance > STRIDE {
            for (value, middle) in parameters.iter_mut().zip(*self.family.middle()) {
                *value = middle + (*value - middle) * STRIDE / distance;
            }
        }
        ModelFamily::new(&self.object, parameters, steps(&self.filter))
    }

    /// Filters all records with what was believed at first until the parameters stay.
    fn learn(&mut self) -> Result<(), PlateError> {
        self.next = None;
        for _ in 0..ROUNDS {
            self.family = self.centered()?;
            self.filter = self.first.clone();
            for run in self.runs.iter().chain([&self.run]) {
                self.family.place(run.start)?;
                self.filter.begin(run.variance);
                for sample in &run.samples {
                    filtered(&mut self.family, &mut self.filter, sample, &self.noise, self.period)?;
                }
            }
            if self.family.distance(&self.filter.parameters()) < SETTLED {
                break;
            }
        }
        self.unlearned = false;
        Ok(())
    }

    /// Learns from the records and begins a new run from the estimated pose, at rest. What the last run did not explain: the
    /// displacement of its end, x, y (m), yaw (rad), in which the motion differs from that of the learned object.
    pub(super) fn restart(&mut self) -> Result<[f64; 3], PlateError> {
        if self.unlearned {
            self.learn()?;
        }
        let unexplained = if self.run.moved { [0, 1, 2].map(|i| self.filter.estimate[i]) } else { [0.0; 3] };
        let variance = [0, 1, 2].map(|i| self.filter.covariance[(i, i)]);
        self.begin(variance)?;
        Ok(unexplained)
    }

    /// Files the record of the run and begins another where the object is estimated to be.
    fn begin(&mut self, variance: [f64; 3]) -> Result<(), PlateError> {
        let [x, y, phi, ..] = self.state();
        let next = Run { start: [x, y, phi], variance, samples: Vec::new(), moved: false, resting: 0 };
        let run = std::mem::replace(&mut self.run, next);
        if run.moved {
            self.runs.push(run);
            let surplus = self.runs.len().saturating_sub(RUNS);
            self.runs.drain(..surplus);
        }
        self.next = None;
        self.family = self.centered()?;
        self.family.place([x, y, phi])?;
        self.filter.begin(variance);
        for (i, change) in CHANGE.into_iter().enumerate() {
            let at = (3 + i, 3 + i);
            // What is known exactly does not change.
            if self.first.covariance[at] > 0.0 {
                self.filter.covariance[at] += change * change;
            }
        }
        self.prior = self.filter.clone();
        Ok(())
    }

    /// Believes the next measurements of the pose, whatever was estimated before.
    pub(super) fn forget_pose(&mut self) -> Result<(), PlateError> {
        self.begin([0, 1, 2].map(|i| (100.0 * DRIFT[i / 2]).powi(2)))
    }
}

/// Moves simulations and filter on by a sample.
fn filtered(
    family: &mut ModelFamily,
    filter: &mut Filter,
    sample: &Sample,
    noise: &[f64; 3],
    period: f64,
) -> Result<(), PlateError> {
    family.advance(&sample.plate, sample.acted, period)?;
    if !family.at_rest() {
        filter.drift(period);
    }
    filter.take(family, &sample.pose, noise, period);
    Ok(())
}

/// Distances of simulations: a standard deviation, within limits.
fn steps(filter: &Filter) -> [f64; OF_OBJECT] {
    std::array::from_fn(|i| {
        let deviation = filter.covariance[(3 + i, 3 + i)].max(0.0).sqrt();
        if deviation > 0.0 { deviation.clamp(STEPS[i][0], STEPS[i][1]) } else { 0.0 }
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::oscillation::Oscillation;
    use super::super::replay::Replay;
    use super::*;
    use crate::Shape;

    const PERIOD: f64 = 0.02;

    /// An estimator that has watched an object with the given parameters for 1.2 s on an oscillating plate.
    fn watched(truth: Parameters) -> MotionEstimator {
        let first = Object { shape: Shape::REFERENCE_ELLIPSE, ..Object::REFERENCE };
        let (object, mu) = object_of(&first, &truth);
        let mut plant = Replay::new(&object, mu).unwrap();
        let start = [0.02, -0.05, 0.4];
        plant.set_state([start[0], start[1], start[2], 0.0, 0.0, 0.0]).unwrap();
        let mut estimator = MotionEstimator::new(&first, &PoseSettings::default(), start).unwrap();
        let swing = Oscillation { frequency: 2.5, displacement: 0.03, tilt: 0.15, phase: 0.3 };
        let mut plate = PlateKinematics::default();
        for input in swing.inputs(60, PERIOD).into_iter().chain(std::iter::repeat_n(vec![0.0; 2], 20)) {
            let command = Command { displacement_acceleration: input[0], tilt_acceleration: input[1] };
            plant.advance(&plate, command, PERIOD).unwrap();
            let [x, y, phi, ..] = plant.state();
            estimator.step(&plate, command, &[x, y, phi]).unwrap();
            plate = command.applied_to(&plate).after(PERIOD);
            if input == [0.0; 2] {
                plate = PlateKinematics { displacement: plate.displacement, ..PlateKinematics::default() };
            }
        }
        estimator
    }

    #[test]
    fn parameters_that_explain_the_motion_are_found() {
        for truth in [[-1.6, 0.0, 0.0, 0.0, 0.0], [-1.0, -0.5, 0.0, 0.0, 0.0], [-1.2, 0.0, 4e-3, -5e-3, 0.0]] {
            let mut estimator = watched(truth);
            estimator.restart().unwrap();
            let learned = estimator.learned();
            assert!((learned.mu.value.ln() - truth[0]).abs() < 0.01, "{truth:?} {learned:?}");
            assert!((learned.scale.value.ln() - truth[1]).abs() < 0.04, "{truth:?} {learned:?}");
            assert!(learned.latency.value < 5e-4, "{truth:?} {learned:?}");
            // The object hardly turns, which would show where its center of mass is; what is believed of it stays uncertain.
            for (estimate, truth) in learned.center_of_mass.iter().zip(&truth[2..]) {
                assert!((estimate.value - truth).abs() < 2.0 * estimate.deviation, "{truth:?} {learned:?}");
            }
        }
    }

    #[test]
    fn a_plate_at_rest_teaches_nothing() {
        let first = Object { shape: Shape::REFERENCE_ELLIPSE, ..Object::REFERENCE };
        let settings = PoseSettings::default();
        let mut estimator = MotionEstimator::new(&first, &settings, [0.0; 3]).unwrap();
        let before = estimator.learned();
        for _ in 0..30 {
            estimator.step(&PlateKinematics::default(), Command::default(), &[1e-4, -1e-4, 1e-3]).unwrap();
        }
        assert_eq!(estimator.learned(), before);
        assert!((before.scale.deviation - settings.uncertainty.scale).abs() < 1e-12);
        assert!(estimator.deviation()[0] < 0.2 * settings.noise[0]);
    }
}
