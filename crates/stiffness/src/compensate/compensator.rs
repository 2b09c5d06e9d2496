//! The compensation, one step per control period.

use super::error::{CompensationError, positive};
use super::filter::{Prediction, WrenchFilter};
use super::settings::CompensationSettings;
use crate::compliance::{Deflections, DeformedFrames, Springs};
use crate::error::check_finite;
use crate::robot::{
    Kinematics, Robot, Twist, Wrench, displacement_between, halves, solve_damped, twist_adjoint, wrench_adjoint,
};
use crate::sensor::{ForceSensor, Payload};
use nalgebra::Isometry3;

/// Damping of Newton's steps (m, rad).
const DAMPING: f64 = 1e-4;

/// What kept a step from using its input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// Not as many measured or reference coordinates as joints.
    Count,
    /// An entry of the sensor's reading, from 0, is not finite.
    Reading(usize),
    /// The reading lies beyond the sensor's range: overload, or other units.
    Range,
    /// A measured coordinate, from 0, is not finite.
    Measured(usize),
    /// A reference coordinate, from 0, is not finite; the last command is repeated.
    Reference(usize),
    /// Coordinates so large that no pose comes out.
    Unbounded,
}

/// What a step did besides compensating.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Status {
    /// Input that was bad: the last good correction is held.
    pub fault: Option<Fault>,
    /// Steps for which a correction has been held, this one included.
    pub held: usize,
    /// The correction was shortened to its limit.
    pub saturated: bool,
    /// The change of the correction was shortened to its limit.
    pub rate_limited: bool,
}

impl Status {
    /// Whether the correction is the one asked for, of this step's input.
    pub fn is_good(&self) -> bool {
        self.fault.is_none() && !self.saturated && !self.rate_limited
    }
}

/// What a step gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Correction<'a> {
    /// Corrected reference of the joints (rad, m): what to send to the robot. Always finite.
    pub reference: &'a [f64],
    /// The correction that is in force (rad, m); held while input is bad.
    pub correction: &'a [f64],
    /// Filtered process wrench on the robot at the tool point, in base axes; predicted ahead where the settings name a lag.
    pub wrench: Wrench,
    /// Displacement of the tool point at the reference if it were not corrected, first order, in base axes.
    pub displacement: Twist,
    /// Faults and limits.
    pub status: Status,
}

/// Moves a robot's reference so that the tool point under load stands where it was to stand.
///
/// At every step: the sensor's reading less bias and weight, carried to the tool point in base axes and filtered; the springs' yielding at
/// the reference pose; and the reference `q_c` whose loaded tool point has the reference pose,
/// `f(q_c + δ(J(q_r)ᵀ W)) = f(q_r)`. With rigid links `q_c = q_r − δ(J(q_r)ᵀ W)` solves this exactly, in any pose, as the loaded joints
/// stand at `q_r`; where links bend Newton's steps follow.
///
/// The weight of robot and payload counts as calibrated: only the process wrench is compensated.
///
/// ```
/// use bracketry_stiffness::{CompensationSettings, Compensator, DhParameters, ForceSensor, Payload, Robot, Springs, Wrench};
/// use nalgebra::Isometry3;
/// // An arm of 1 m on one joint, 1000 N·m/rad, 5 N across its end: it yields by 5 mrad.
/// let robot = Robot::from_modified_dh("arm", &[DhParameters::default()]).with_tool(Isometry3::translation(1.0, 0.0, 0.0));
/// let sensor = ForceSensor { pose: Isometry3::identity(), force_range: 100.0, moment_range: 10.0 };
/// let settings = CompensationSettings::default();
/// let mut compensator = Compensator::new(robot, Springs::linear(&[1000.0]), sensor, Payload::none(), settings).unwrap();
/// let mut command = 0.0;
/// for _ in 0..500 {
///     let step = compensator.step(&[command], &Wrench::new(0.0, 5.0, 0.0, 0.0, 0.0, 0.0), &[0.0]);
///     command = step.reference[0];
/// }
/// assert!((command + 0.005).abs() < 1e-6);
/// ```
#[derive(Clone, Debug)]
pub struct Compensator {
    robot: Robot,
    springs: Springs,
    sensor: ForceSensor,
    payload: Payload,
    settings: CompensationSettings,
    filter: WrenchFilter,
    prediction: Option<Prediction>,
    kinematics: Kinematics,
    deformed: DeformedFrames,
    deflected: Deflections,
    /// Where the joints stand, loaded.
    loaded: Vec<f64>,
    wanted: Vec<f64>,
    correction: Vec<f64>,
    command: Vec<f64>,
    wrench: Wrench,
    displacement: Twist,
    held: usize,
}

impl Compensator {
    /// A compensation at rest: no wrench, no correction, the command at the robot's coordinates 0 until the first good reference.
    ///
    /// # Errors
    /// [`CompensationError`] for springs, payload, sensor or settings that do not fit.
    pub fn new(
        robot: Robot,
        springs: Springs,
        sensor: ForceSensor,
        payload: Payload,
        settings: CompensationSettings,
    ) -> Result<Self, CompensationError> {
        let joints = robot.joints.len();
        springs.check(joints)?;
        payload.check()?;
        positive("the range of force", sensor.force_range)?;
        positive("the range of moment", sensor.moment_range)?;
        positive("the limit of the correction", settings.correction_limit)?;
        positive("the limit of the rate", settings.rate_limit)?;
        check_finite("gravity", &settings.gravity)?;
        let share = settings.stiffness_error;
        if !(0.0..1.0).contains(&share) {
            return Err(CompensationError::StiffnessError { share });
        }
        let (order, cutoff, period) = (settings.order, settings.cutoff, settings.period);
        let filter = WrenchFilter::new(order, cutoff, period)?;
        let prediction = settings.lag.map(|lag| Prediction::new(order, cutoff, period, lag)).transpose()?;
        let rest = vec![0.0; joints];
        let deflected = Deflections::none(joints);
        Ok(Self {
            kinematics: Kinematics::new(&robot, &rest)?,
            deformed: DeformedFrames::new(&robot, &rest, &deflected),
            deflected,
            loaded: rest.clone(),
            wanted: rest.clone(),
            correction: rest.clone(),
            command: rest,
            wrench: Wrench::zeros(),
            displacement: Twist::zeros(),
            held: 0,
            robot,
            springs,
            sensor,
            payload,
            settings,
            filter,
            prediction,
        })
    }

    /// One control period: measured coordinates (encoders, rad), the sensor's reading (N, N·m, its axes), and the
    /// reference (rad) of this period. Nothing is allocated. Bad input changes neither filter nor correction.
    pub fn step(&mut self, measured: &[f64], reading: &Wrench, reference: &[f64]) -> Correction<'_> {
        let mut status = Status::default();
        match self.compensate(measured, reading, reference, &mut status) {
            Ok(()) => self.held = 0,
            Err(fault) => {
                self.held += 1;
                status = Status { fault: Some(fault), held: self.held, ..Status::default() };
            }
        }
        if !matches!(status.fault, Some(Fault::Reference(_) | Fault::Count)) {
            for (i, command) in self.command.iter_mut().enumerate() {
                *command = reference[i] + self.correction[i];
            }
        }
        Correction {
            reference: &self.command,
            correction: &self.correction,
            wrench: self.wrench,
            displacement: self.displacement,
            status,
        }
    }

    fn compensate(
        &mut self,
        measured: &[f64],
        reading: &Wrench,
        reference: &[f64],
        status: &mut Status,
    ) -> Result<(), Fault> {
        self.check(measured, reading, reference)?;
        let process = self.process_wrench(measured, reading)?;
        self.kinematics.update(&self.robot, reference).map_err(|_| Fault::Unbounded)?;
        if self.kinematics.jacobian().iter().any(|v| !v.is_finite()) {
            return Err(Fault::Unbounded);
        }
        let filtered = self.filter.step(&process);
        self.wrench = self.prediction.as_mut().map_or(filtered, |prediction| prediction.step(&filtered));
        self.correct(reference);
        self.limit(status);
        Ok(())
    }

    fn check(&self, measured: &[f64], reading: &Wrench, reference: &[f64]) -> Result<(), Fault> {
        let joints = self.robot.joints.len();
        let bad = |values: &[f64]| values.iter().position(|v| !v.is_finite());
        if measured.len() != joints || reference.len() != joints {
            return Err(Fault::Count);
        }
        if let Some(i) = bad(reference) {
            return Err(Fault::Reference(i));
        }
        if let Some(i) = bad(measured) {
            return Err(Fault::Measured(i));
        }
        if let Some(i) = bad(reading.as_slice()) {
            return Err(Fault::Reading(i));
        }
        let (force, moment) = halves(reading);
        if force.amax() > self.sensor.force_range || moment.amax() > self.sensor.moment_range {
            return Err(Fault::Range);
        }
        Ok(())
    }

    /// The process wrench at the tool point, in base axes: the reading less bias and weight.
    fn process_wrench(&mut self, measured: &[f64], reading: &Wrench) -> Result<Wrench, Fault> {
        for (i, loaded) in self.loaded.iter_mut().enumerate() {
            *loaded = measured[i] + self.deflected.deflections[i];
        }
        let tool = self.robot.tool_pose(&self.loaded).map_err(|_| Fault::Unbounded)?;
        let sensor = tool * self.sensor.pose;
        let process = reading - self.payload.reading(&sensor.rotation, &self.settings.gravity);
        let arm = sensor.translation.vector - tool.translation.vector;
        let wrench = wrench_adjoint(&Isometry3::from_parts(arm.into(), sensor.rotation)) * process;
        if wrench.iter().all(|v| v.is_finite()) { Ok(wrench) } else { Err(Fault::Unbounded) }
    }

    /// The correction that is wanted at a reference.
    fn correct(&mut self, reference: &[f64]) {
        self.displacement = Twist::zeros();
        for (i, spring) in self.springs.joints.iter().enumerate() {
            let deflection = spring.deflection(self.kinematics.torque(i, &self.wrench));
            self.displacement += self.kinematics.jacobian().column(i) * deflection;
            self.deflected.deflections[i] = deflection;
            self.wanted[i] = -deflection;
        }
        if !self.springs.links.is_empty() {
            self.follow_links(reference);
        }
        let believed = 1.0 - self.settings.stiffness_error.powi(2);
        self.wanted.iter_mut().for_each(|wanted| *wanted *= believed);
    }

    /// Newton's steps to the reference pose, while the links yield under the wrench.
    fn follow_links(&mut self, reference: &[f64]) {
        for (i, link) in self.springs.links.iter().enumerate() {
            let local = link * self.kinematics.wrench_at(i, &self.wrench);
            self.displacement += twist_adjoint(&self.kinematics.to_tool(i)) * local;
        }
        let target = *self.kinematics.tool();
        for _ in 0..self.settings.newton_steps {
            self.deform(reference);
            self.deformed.deflect(&self.robot, &self.springs, &self.wrench, &mut self.deflected);
            self.deform(reference);
            let missing = displacement_between(&self.deformed.tool, &target);
            let weights = solve_damped(self.kinematics.jacobian(), &missing, DAMPING);
            for (i, wanted) in self.wanted.iter_mut().enumerate() {
                *wanted += self.kinematics.jacobian().column(i).dot(&weights);
            }
        }
    }

    /// Frames at the wanted command, with its deflections.
    fn deform(&mut self, reference: &[f64]) {
        for (i, loaded) in self.loaded.iter_mut().enumerate() {
            *loaded = reference[i] + self.wanted[i];
        }
        self.deformed.update(&self.robot, &self.loaded, &self.deflected);
    }

    /// Brings the correction toward what is wanted, as far as the limits allow. All joints are shortened alike, so that the tool
    /// keeps its direction.
    fn limit(&mut self, status: &mut Status) {
        let largest = self.wanted.iter().fold(0.0f64, |m, w| m.max(w.abs()));
        let within = (self.settings.correction_limit / largest).min(1.0);
        status.saturated = within < 1.0;
        let steps = self.wanted.iter().zip(&self.correction).map(|(w, c)| (within * w - c).abs());
        let longest = steps.fold(0.0, f64::max);
        let share = (self.settings.rate_limit * self.settings.period / longest).min(1.0);
        status.rate_limited = share < 1.0;
        for (correction, wanted) in self.correction.iter_mut().zip(&self.wanted) {
            *correction += share * (within * wanted - *correction);
        }
    }
}
