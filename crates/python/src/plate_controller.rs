//! The pose controller of the vibrating plate, stepped from Python.

use std::collections::{BTreeMap, VecDeque};
use std::sync::Mutex;

use bracketry::plate::control::{
    Command, Learned, Measurement, PlateController as _, PoseController, PoseSettings, PoseStatus,
};
use bracketry::plate::{Object, PlateError, PlateKinematics, Shape};
use pyo3::prelude::*;

use crate::error::Failure;
use crate::plate::{Given, setup_of};

/// A controller with what it knows of the plate: the commands that it has given.
struct Stepped {
    controller: PoseController,
    /// Commands that have been given and do not act yet.
    queue: VecDeque<Command>,
    /// The plate at the next sample, where it does what it is told.
    plate: PlateKinematics,
}

/// The pose controller.
#[pyclass(frozen, module = "bracketry._native")]
pub(crate) struct PlateController(Mutex<Stepped>);

/// What a step gives.
#[pyclass(frozen, get_all, module = "bracketry._native")]
pub(crate) struct PlateStep {
    /// X'' in m/s², to be held over the next period.
    displacement_acceleration: f64,
    /// θ'' in rad/s².
    tilt_acceleration: f64,
    /// Whether the controller only brings the plate to rest, or keeps it there.
    finished: bool,
    /// `working`, `arrived`, `unreachable`, or `moves_used_up`.
    status: &'static str,
    /// Estimated state of the object: x, y (m), yaw (rad) and their rates.
    estimate: Option<[f64; 6]>,
    /// Assumed friction coefficient.
    mu: f64,
    /// What has been learned, by name: value and standard deviation.
    learned: BTreeMap<&'static str, (f64, f64)>,
}

#[pymethods]
impl PlateController {
    #[new]
    #[pyo3(signature = (target, numbers, texts, *, polygon, period, delay, mu_deviation, noise, tolerance))]
    #[expect(clippy::too_many_arguments, reason = "keyword arguments of one call")]
    fn new(
        py: Python<'_>,
        target: [f64; 3],
        numbers: Given<f64>,
        texts: Given<String>,
        polygon: Option<Vec<[f64; 2]>>,
        period: f64,
        delay: usize,
        mu_deviation: f64,
        noise: [f64; 2],
        tolerance: [f64; 2],
    ) -> Result<Self, Failure> {
        py.detach(|| {
            let mu = numbers.get("mu").copied().flatten();
            let mut object: Object = setup_of(numbers, texts)?.object;
            if let Some(vertices) = polygon {
                object.shape = Shape::polygon(&vertices).map_err(|e| Failure::from(e).about("shape"))?;
            }
            let default = PoseSettings::default();
            let settings =
                PoseSettings { period, delay, mu: mu.unwrap_or(default.mu), mu_deviation, noise, tolerance, ..default };
            let controller = PoseController::new(&object, target, &settings)?;
            let queue = std::iter::repeat_n(Command::default(), delay).collect();
            Ok(Self(Mutex::new(Stepped { controller, queue, plate: PlateKinematics::default() })))
        })
    }

    /// The command for the measured pose of the object, and of the plate where it is measured: X, X', θ, θ'.
    fn step(&self, py: Python<'_>, object: [f64; 3], plate: Option<[f64; 4]>) -> Result<PlateStep, Failure> {
        py.detach(|| {
            let mut stepped = self.0.lock().map_err(|_| Failure::new("the controller has failed; create a new one"))?;
            Ok(stepped.step(object, plate)?)
        })
    }
}

/// What has been learned by name.
fn learned(learned: &Learned) -> BTreeMap<&'static str, (f64, f64)> {
    let [x, y] = learned.center_of_mass;
    let all = [
        ("mu", learned.mu),
        ("scale", learned.scale),
        ("center_of_mass_x", x),
        ("center_of_mass_y", y),
        ("latency", learned.latency),
        ("servo_lag", learned.servo_lag),
    ];
    all.into_iter().map(|(name, estimate)| (name, (estimate.value, estimate.deviation))).collect()
}

impl Stepped {
    fn step(&mut self, object: [f64; 3], plate: Option<[f64; 4]>) -> Result<PlateStep, PlateError> {
        if let Some([displacement, velocity, tilt, tilt_rate]) = plate {
            self.plate = PlateKinematics { displacement, velocity, tilt, tilt_rate, ..self.plate };
        }
        // The measurement tells the accelerations that act from now on if no new command arrives: with a delay, those of the queue.
        let acting = self.queue.front().copied();
        let measured = acting.map_or(self.plate, |command| command.applied_to(&self.plate));
        let command = self.controller.command(&Measurement { object, plate: measured })?;
        self.queue.push_back(command);
        let acts = self.queue.pop_front().unwrap_or(command);
        self.plate = acts.applied_to(&self.plate).after(self.controller.period());
        Ok(PlateStep {
            displacement_acceleration: command.displacement_acceleration,
            tilt_acceleration: command.tilt_acceleration,
            finished: self.controller.finished(),
            status: match self.controller.report().status {
                PoseStatus::Working => "working",
                PoseStatus::Arrived => "arrived",
                PoseStatus::Unreachable { .. } => "unreachable",
                PoseStatus::MovesUsedUp { .. } => "moves_used_up",
            },
            estimate: self.controller.estimate(),
            mu: self.controller.report().mu,
            learned: learned(&self.controller.report().learned),
        })
    }
}
