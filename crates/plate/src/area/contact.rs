//! A flat object on the moving plate with friction over its whole footprint.

use super::outcome::AreaOutcome;
use super::pressure::{Footprint, Support};
use super::record::{AreaRecord, AreaSample, EnergyBalance};
use super::settings::{AreaSettings, Scheme};
use super::stage::{Base, Equations, Stage};
use crate::{Friction, Object, PlateError, PlateMotion};
use bracketry_sim::Slip;

/// `γ = 1 − 1/√2`.
const GAMMA: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;
/// Halvings of a step to find when the object stops, tips or lifts off.
const HALVINGS: usize = 30;

/// A flat object on the moving plate with dry friction over its footprint, stepped in time implicitly.
///
/// States `x, y, phi, vx, vy, w` in the plate frame, those of the center of the shape. The pressure follows from the balance of normal force and moments
/// ([`Footprint`]), the friction at every point from the pressure and maximum dissipation
/// ([`bracketry_sim::FrictionSolver`]); what friction holds rests exactly.
///
/// ```
/// use bracketry_plate::{Friction, Object, PlateKinematics, Shape};
/// use bracketry_plate::area::{AreaContact, AreaSettings};
/// // A spinning disk on a level plate stops after 3 R w/(4 μ g).
/// let object = Object { shape: Shape::Disk { radius: 0.12 }, height: 0.0, ..Object::REFERENCE };
/// let mut disk = AreaContact::new(&object, &Friction::Coulomb { mu: 0.3 }, &AreaSettings::default()).unwrap();
/// disk.set_state([0.0, 0.0, 0.0, 0.0, 0.0, 10.0]).unwrap();
/// let mut still = |_| PlateKinematics::default();
/// disk.advance(&mut still, 0.305).unwrap();
/// assert!(disk.state()[5] > 0.0);
/// disk.advance(&mut still, 0.307).unwrap();
/// assert_eq!(disk.state()[5], 0.0);
/// ```
#[derive(Debug, Clone)]
pub struct AreaContact {
    equations: Equations,
    settings: AreaSettings,
    mass: f64,
    t: f64,
    /// Position of the center of mass and yaw, and their rates.
    position: [f64; 3],
    velocity: [f64; 3],
    /// The last stage: guess of friction for the next, and what a sample tells.
    last: Option<Stage>,
    energy: EnergyBalance,
}

/// What a trial step gave.
enum Trial {
    Step { position: [f64; 3], velocity: [f64; 3], friction: [f64; 3], drive: [f64; 3], stage: Stage },
    Captured,
    Failed(Stage),
}

impl AreaContact {
    /// The object at rest in the origin at time 0.
    ///
    /// # Errors
    /// [`PlateError`] if object, friction law or settings have no meaning.
    pub fn new(object: &Object, friction: &Friction, settings: &AreaSettings) -> Result<Self, PlateError> {
        Ok(Self {
            equations: Equations::new(object, friction, settings)?,
            settings: settings.clone(),
            mass: object.mass,
            t: 0.0,
            position: [object.center_of_mass[0], object.center_of_mass[1], 0.0],
            velocity: [0.0; 3],
            last: None,
            energy: EnergyBalance::default(),
        })
    }

    /// Puts the object into another state `x, y, phi, vx, vy, w` (plate frame, SI units) and starts a new energy balance.
    ///
    /// # Errors
    /// [`PlateError::BadState`] if a number is not finite.
    pub fn set_state(&mut self, state: [f64; 6]) -> Result<(), PlateError> {
        if let Some(value) = state.iter().find(|x| !x.is_finite()) {
            return Err(PlateError::BadState { value: *value });
        }
        let [mut x, mut y, phi, mut vx, mut vy, w] = state;
        if self.is_off_center() {
            let [rx, ry] = self.equations.object().center_of_mass_at(phi);
            (x, y, vx, vy) = (x + rx, y + ry, vx - w * ry, vy + w * rx);
        }
        (self.position, self.velocity, self.last) = ([x, y, phi], [vx, vy, w], None);
        self.energy = EnergyBalance::start(self.kinetic_energy());
        Ok(())
    }

    /// Sets the time in s.
    ///
    /// # Errors
    /// [`PlateError::BadState`] if it is not finite.
    pub fn set_time(&mut self, t: f64) -> Result<(), PlateError> {
        if !t.is_finite() {
            return Err(PlateError::BadState { value: t });
        }
        self.t = t;
        Ok(())
    }

    /// The state `x, y, phi, vx, vy, w`.
    pub fn state(&self) -> [f64; 6] {
        let ([x, y, phi], [vx, vy, w]) = (self.position, self.velocity);
        if self.is_off_center() {
            let [rx, ry] = self.equations.object().center_of_mass_at(phi);
            return [x - rx, y - ry, phi, vx + w * ry, vy - w * rx, w];
        }
        [x, y, phi, vx, vy, w]
    }

    /// Whether the center of mass is not that of the shape.
    fn is_off_center(&self) -> bool {
        self.equations.object().center_of_mass != [0.0; 2]
    }

    /// The time in s.
    pub fn time(&self) -> f64 {
        self.t
    }

    /// Work and energy since the last [`AreaContact::set_state`].
    pub fn energy(&self) -> &EnergyBalance {
        &self.energy
    }

    /// The points of the footprint and the loads of the last step.
    pub fn footprint(&self) -> &Footprint {
        self.equations.footprint()
    }

    /// Simulates to `t_end`.
    ///
    /// # Errors
    /// [`PlateError::BadState`] if `t_end` is not finite or lies in the past, [`PlateError::NotConverged`] if the equations of
    /// the shortest step were not solved. What ends the contact is an outcome.
    pub fn advance<M: PlateMotion + ?Sized>(&mut self, motion: &mut M, t_end: f64) -> Result<AreaOutcome, PlateError> {
        self.advance_with(motion, t_end, |_| ())
    }

    /// Simulates to `t_end` and records every step.
    ///
    /// # Errors
    /// As [`AreaContact::advance`].
    pub fn record<M: PlateMotion + ?Sized>(
        &mut self,
        motion: &mut M,
        t_end: f64,
    ) -> Result<(AreaRecord, AreaOutcome), PlateError> {
        let mut record = AreaRecord::new(self.t, self.state());
        let outcome = self.advance_with(motion, t_end, |sample| record.push(sample))?;
        record.energy = self.energy;
        Ok((record, outcome))
    }

    /// Simulates to `t_end` and tells every step.
    ///
    /// # Errors
    /// As [`AreaContact::advance`].
    pub fn advance_with<M: PlateMotion + ?Sized>(
        &mut self,
        motion: &mut M,
        t_end: f64,
        mut tell: impl FnMut(&AreaSample),
    ) -> Result<AreaOutcome, PlateError> {
        if !t_end.is_finite() || t_end < self.t {
            return Err(PlateError::BadState { value: t_end });
        }
        while self.t < t_end {
            // Equal steps that end at t_end.
            let steps = ((t_end - self.t) / self.settings.step - 1e-6).ceil().max(1.0);
            let to = if steps == 1.0 { t_end } else { self.t + (t_end - self.t) / steps };
            if let Some(end) = self.step(motion, to)? {
                return Ok(end);
            }
            tell(&self.sample());
        }
        Ok(AreaOutcome::Finished)
    }

    /// One step to the time `to`, or a shorter one where friction that falls with speed lets so long a step end in several ways.
    fn step<M: PlateMotion + ?Sized>(
        &mut self,
        motion: &mut M,
        mut to: f64,
    ) -> Result<Option<AreaOutcome>, PlateError> {
        for _ in 0..HALVINGS {
            match self.attempt(motion, to) {
                Err(PlateError::NotConverged { .. }) => to = self.t + 0.5 * (to - self.t),
                done => return done,
            }
        }
        self.attempt(motion, to)
    }

    /// One step to the time `to`, or to where the object stops before; the outcome if contact ends.
    fn attempt<M: PlateMotion + ?Sized>(&mut self, motion: &mut M, to: f64) -> Result<Option<AreaOutcome>, PlateError> {
        let scheme = self.settings.scheme;
        let mut trial = match scheme {
            Scheme::Euler => self.euler(motion, to)?,
            Scheme::SecondOrder => self.second_order(motion, to)?,
        };
        if matches!(trial, Trial::Captured) {
            trial = self.euler(motion, to)?;
        }
        let stops = |trial: &Trial| matches!(trial, Trial::Step { stage, .. } if stage.slip == Slip::Held);
        let moving = self.velocity != [0.0; 3];
        let failed = |trial: &Trial| matches!(trial, Trial::Failed(_));
        let ends = |trial: &Trial| failed(trial) || (moving && stops(trial));
        if ends(&trial) {
            // The shortest implicit step at whose end it has happened.
            let (mut before, mut after) = (self.t, to);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (before + after);
                if middle <= before || middle >= after {
                    break;
                }
                let shorter = self.euler(motion, middle)?;
                if ends(&shorter) {
                    (after, trial) = (middle, shorter);
                } else {
                    before = middle;
                }
            }
            if let Trial::Failed(stage) = trial {
                if before > self.t
                    && let step @ Trial::Step { .. } = self.euler(motion, before)?
                {
                    self.accept(before, &step);
                }
                return Ok(Some(self.ended(&stage)));
            }
            self.accept(after, &trial);
            return Ok(None);
        }
        self.accept(to, &trial);
        Ok(None)
    }

    fn ended(&self, stage: &Stage) -> AreaOutcome {
        let t = self.t;
        match stage.support {
            Support::LiftOff if stage.normal <= 0.0 => AreaOutcome::LiftOff { t },
            Support::Tipping { rim_share, .. } => {
                let (object, [x, y]) = (self.equations.object(), self.equations.footprint().center());
                let (s, c) = stage.position[2].sin_cos();
                let (middle, offset) = ([c * x - s * y, s * x + c * y], object.center_of_mass_at(stage.position[2]));
                let at = [0, 1].map(|i| offset[i] + middle[i] + (stage.center[i] - middle[i]) / rim_share);
                AreaOutcome::Tipping { t, at, normal: self.mass * stage.normal }
            }
            _ => AreaOutcome::NotFinite { t },
        }
    }

    /// One stage of implicit Euler.
    fn euler<M: PlateMotion + ?Sized>(&mut self, motion: &mut M, to: f64) -> Result<Trial, PlateError> {
        let base = Base {
            position: self.position,
            velocity: self.velocity,
            length: to - self.t,
            at_rest: self.velocity == [0.0; 3],
        };
        let stage = self.stage(motion, to, &base)?;
        if stage.failed() {
            return Ok(Trial::Failed(stage));
        }
        Ok(Trial::Step {
            position: stage.position,
            velocity: stage.velocity,
            friction: stage.friction,
            drive: stage.drive,
            stage,
        })
    }

    fn second_order<M: PlateMotion + ?Sized>(&mut self, motion: &mut M, to: f64) -> Result<Trial, PlateError> {
        let dt = to - self.t;
        let length = GAMMA * dt;
        let at_rest = self.velocity == [0.0; 3];
        let base = Base { position: self.position, velocity: self.velocity, length, at_rest };
        let first = self.stage(motion, self.t + length, &base)?;
        if first.failed() {
            return Ok(Trial::Failed(first));
        }
        // What stops or breaks loose does so within one stage.
        if at_rest != (first.slip == Slip::Held) {
            return Ok(Trial::Captured);
        }
        let rest = (1.0 - GAMMA) * dt;
        let mut velocity = self.velocity;
        let mut position = self.position;
        for i in 0..3 {
            velocity[i] += rest * (first.velocity[i] - self.velocity[i]) / length;
            position[i] += rest * first.velocity[i];
        }
        let base = Base { position, velocity, length, at_rest };
        let second = self.equations.stage(&motion.at(to), &base, &first)?;
        if second.failed() {
            return Ok(Trial::Failed(second));
        }
        if at_rest != (second.slip == Slip::Held) {
            return Ok(Trial::Captured);
        }
        let mean = |a: &[f64; 3], b: &[f64; 3]| std::array::from_fn(|i| (1.0 - GAMMA) * a[i] + GAMMA * b[i]);
        Ok(Trial::Step {
            position: second.position,
            velocity: second.velocity,
            friction: mean(&first.friction, &second.friction),
            drive: mean(&first.drive, &second.drive),
            stage: second,
        })
    }

    /// A stage from the state of the object.
    fn stage<M: PlateMotion + ?Sized>(&mut self, motion: &mut M, to: f64, base: &Base) -> Result<Stage, PlateError> {
        let before = self.last.unwrap_or_else(|| Stage::at(self.position, self.velocity));
        self.equations.stage(&motion.at(to), base, &before)
    }

    fn accept(&mut self, to: f64, trial: &Trial) {
        let Trial::Step { position, velocity, friction, drive, stage } = *trial else {
            return;
        };
        let dt = to - self.t;
        let mean: [f64; 3] = std::array::from_fn(|i| 0.5 * (self.velocity[i] + velocity[i]));
        let work = |force: &[f64; 3]| self.mass * dt * mean.iter().zip(force).map(|(v, f)| v * f).sum::<f64>();
        let (friction, drive) = (work(&friction), work(&drive));
        (self.t, self.position, self.velocity, self.last) = (to, position, velocity, Some(stage));
        let kinetic = self.kinetic_energy();
        self.energy.add(friction, drive, kinetic);
    }

    /// Kinetic energy relative to the plate, in J.
    fn kinetic_energy(&self) -> f64 {
        let [vx, vy, w] = self.velocity;
        0.5 * self.mass * (vx * vx + vy * vy + self.equations.inertia() * w * w)
    }

    fn sample(&self) -> AreaSample {
        let mut sample = AreaSample {
            t: self.t,
            state: self.state(),
            acceleration: [0.0; 3],
            normal: 0.0,
            center: [0.0; 2],
            friction: [0.0; 3],
            support: Support::Full { least: 1.0 },
            slip: Slip::Held,
        };
        if let Some(stage) = &self.last {
            sample.normal = self.mass * stage.normal;
            sample.center = stage.center;
            sample.friction = stage.friction.map(|f| self.mass * f);
            sample.support = stage.support;
            sample.slip = stage.slip;
            sample.acceleration = stage.acceleration(self.equations.inertia());
            if self.is_off_center() {
                let ([ax, ay, spin], w) = (sample.acceleration, stage.velocity[2]);
                let [rx, ry] = self.equations.object().center_of_mass_at(stage.position[2]);
                sample.acceleration = [ax + spin * ry + w * w * rx, ay - spin * rx + w * w * ry, spin];
            }
        }
        sample
    }
}
