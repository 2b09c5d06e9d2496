//! Where the object is and how fast, and what it is like, from measured poses.
//!
//! Since the object starts from rest, its motion is known up to the parameters of [`super::learned`] and a small offset. A filter
//! (Kalman 1960, *A new approach to linear filtering and prediction problems*; here on exact simulations instead of linear models)
//! estimates them sample by sample. When the parameters leave the neighborhood of the simulations, these are made anew about the
//! estimate and the record since the last rest is filtered again; at rest this is repeated over the records of all moves until
//! nothing changes, which is Gauss and Newton's method for the most likely parameters, with the offset as a random walk.

use super::interface::Command;
use super::learned::{
    Estimate, LATENCY, Learned, OF_OBJECT, PARAMETERS, Parameters, first_belief, object_of, validate,
};
use super::model_family::ModelFamily;
use super::pose_filter::{DRIFT, Filter, LEAST_NOISE, Vector};
use super::settings::PoseSettings;
use crate::{Object, PlateError, PlateKinematics};

/// Least and greatest distance of the simulations on either side.
const STEPS: [[f64; 2]; OF_OBJECT] = [[0.03, 0.12], [0.06, 0.2], [5e-4, 3e-3], [5e-4, 3e-3]];
/// Distance in steps at which simulations are made anew on the way, and how far they go at once.
const DISTANT: f64 = 1.5;
const STRIDE: f64 = 3.0;
/// Samples of the record that new simulations catch up with while one is measured.
const CATCH_UP: usize = 4;
/// Rounds over the records at rest, and the change in steps that ends them.
const ROUNDS: usize = 4;
const SETTLED: f64 = 0.3;
/// What a run may leave unexplained, in m and rad; beyond, something has pushed the object.
const PUSHED: [f64; 2] = [0.015, 0.25];
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
    /// Whether something else than the plate has moved the object: then the record tells of nothing but its place.
    disturbed: bool,
    resting: usize,
}

impl Run {
    /// The object at rest at a pose.
    fn at(start: [f64; 3], variance: [f64; 3]) -> Self {
        Self { start, variance, samples: Vec::new(), moved: false, disturbed: false, resting: 0 }
    }
}

/// The estimator.
#[derive(Debug, Clone)]
pub(super) struct MotionEstimator {
    /// The object assumed at first.
    object: Object,
    period: f64,
    noise: [f64; 3],
    /// What is assumed before anything is measured, without the offset.
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
        let mut first = Filter::new();
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
        let run = Run::at(pose, variance);
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
        } else if self.family.distance(&self.filter.parameters()) > DISTANT {
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

    /// Learns from the records. A run whose end even the most likely parameters do not explain was disturbed: it is left out then.
    fn learn(&mut self) -> Result<(), PlateError> {
        self.next = None;
        self.filter_all()?;
        if (0..3).any(|i| self.filter.estimate[i].abs() > PUSHED[i / 2]) && self.run.moved && !self.run.disturbed {
            self.run.disturbed = true;
            self.filter = self.prior.clone();
            self.family = ModelFamily::new(&self.object, self.prior.parameters(), steps(&self.prior))?;
            self.filter_all()?;
        }
        self.unlearned = false;
        Ok(())
    }

    /// Filters all records with what was believed at first until the parameters stay.
    fn filter_all(&mut self) -> Result<(), PlateError> {
        for _ in 0..ROUNDS {
            self.family = self.centered()?;
            self.filter = self.first.clone();
            for run in self.runs.iter().chain([&self.run]) {
                self.family.place(run.start)?;
                let before = self.filter.covariance;
                if run.disturbed {
                    self.filter.covariance.fill(0.0);
                }
                self.filter.begin(run.variance);
                for sample in &run.samples {
                    filtered(&mut self.family, &mut self.filter, sample, &self.noise, self.period)?;
                }
                if run.disturbed {
                    let known = before.fixed_view::<PARAMETERS, PARAMETERS>(3, 3);
                    self.filter.covariance.fixed_view_mut::<PARAMETERS, PARAMETERS>(3, 3).copy_from(&known);
                }
            }
            if self.family.distance(&self.filter.parameters()) < SETTLED {
                break;
            }
        }
        Ok(())
    }

    /// Forgets what was learned, but for the place of the object; false if nothing was.
    pub(super) fn forget_learned(&mut self) -> Result<bool, PlateError> {
        let known = !self.runs.is_empty();
        self.runs.clear();
        let state = self.state();
        self.filter = self.first.clone();
        self.filter.begin(self.run.variance);
        self.prior = self.filter.clone();
        self.run.start = [state[0], state[1], state[2]];
        self.family = ModelFamily::new(&self.object, self.first.parameters(), steps(&self.first))?;
        self.family.place(self.run.start)?;
        Ok(known)
    }

    /// Learns from the records and begins a new run from the estimated pose, at rest. What the last run did not explain: the
    /// displacement of its end, x, y (m), yaw (rad), in which the motion differs from that of the learned object.
    pub(super) fn restart(&mut self) -> Result<[f64; 3], PlateError> {
        if self.unlearned {
            self.learn()?;
        }
        let unexplained =
            if self.run.moved && !self.run.disturbed { [0, 1, 2].map(|i| self.filter.estimate[i]) } else { [0.0; 3] };
        let variance = [0, 1, 2].map(|i| self.filter.covariance[(i, i)]);
        self.begin(variance)?;
        Ok(unexplained)
    }

    /// Files the record of the run and begins another where the object is estimated to be.
    fn begin(&mut self, variance: [f64; 3]) -> Result<(), PlateError> {
        let [x, y, phi, ..] = self.state();
        let next = Run::at([x, y, phi], variance);
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
            // The object hardly turns, which would show where its center of mass is; what is assumed of it stays uncertain.
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
