//! A rigid body in all six degrees of freedom on the moving plate.

use nalgebra::Vector3;

use super::contact::{Contact, ContactSolver};
use super::events::{BodyEvent, BodyEventKind};
use super::frame::RigidState;
use super::settings::BodySettings;
use super::solid::Solid;
use crate::{Friction, Object, PlateError, PlateMotion};

/// Gap in lengths of the body below which a point touches.
pub(super) const TOUCHING: f64 = 1e-8;
/// Largest rotation in one step in contact, in rad.
pub(super) const LARGEST_TURN: f64 = 0.05;
/// Impacts at one instant before the rest is taken as contact.
const IMPACTS_AT_ONCE: usize = 20;
/// Events within a step in contact before they are taken together.
const PILE_UP: usize = 2000;

/// Why a call of [`BodyOnPlate::advance`] ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BodyStop {
    /// The end time is reached.
    EndTime,
    /// A face lies flat on the plate and does not move against it along the normal.
    Flat {
        /// Whether it is the face that is the upper one at orientation zero.
        overturned: bool,
    },
    /// The number of steps is used up: what happens is too fast for the steps that were allowed.
    StepLimit,
    /// The state left the range of floating-point numbers.
    NotFinite,
}

/// A rigid prism on the plate, free in six degrees of freedom.
///
/// In flight it is on its exact path in the world, and the instants at which its lowest point meets the plate are located to
/// 1e-12 s. At an impact Newton's law with friction holds for all points that touch. While points touch, time stepping
/// (Moreau 1988) adds the impulses of contact to the exact free motion: `M (v⁺ − v*) = Σ J_kᵀ λ_k`, Signorini's condition on
/// the normal velocities and Coulomb's law on the slip of every point.
#[derive(Debug, Clone)]
pub struct BodyOnPlate {
    pub(super) solid: Solid,
    pub(super) friction: Friction,
    pub(super) settings: BodySettings,
    pub(super) state: RigidState,
    pub(super) time: f64,
    pub(super) solver: ContactSolver,
    pub(super) points: Vec<Vector3<f64>>,
    /// Numbers of the points that touch.
    pub(super) closed: Vec<usize>,
    pub(super) contacts: Vec<Contact>,
    airborne: bool,
    /// Since when no point presses, if the body has not been seen to come clear of the plate.
    unloaded: Option<f64>,
    /// Before this time a body that lies flat is simulated on.
    flat_from: f64,
    pub(super) unresolved: usize,
}

impl BodyOnPlate {
    /// The object at rest at the origin of the plate at time 0.
    ///
    /// # Errors
    /// [`PlateError`] for an object, a friction law or settings without meaning.
    pub fn new(object: &Object, friction: &Friction, settings: &BodySettings) -> Result<Self, PlateError> {
        friction.validate()?;
        settings.validate()?;
        let solid = Solid::of(object, settings.points)?;
        let state = RigidState::at_rest(object.height);
        Ok(Self {
            solid,
            friction: *friction,
            settings: *settings,
            state,
            time: 0.0,
            solver: ContactSolver::default(),
            points: Vec::new(),
            closed: Vec::new(),
            contacts: Vec::new(),
            airborne: false,
            unloaded: None,
            flat_from: f64::NEG_INFINITY,
            unresolved: 0,
        })
    }

    /// Starts from `state`, relative to the plate, at `time`.
    ///
    /// # Errors
    /// [`PlateError::BadState`] for a number that is not finite, or [`PlateError::Penetration`] if a point lies below the plate.
    pub fn set_state(&mut self, time: f64, state: &RigidState) -> Result<(), PlateError> {
        if !time.is_finite() {
            return Err(PlateError::BadState { value: time });
        }
        if let Some(value) = state.components().find(|c| !c.is_finite()) {
            return Err(PlateError::BadState { value });
        }
        let gap = self.solid.gap(state).0;
        if gap < -TOUCHING * self.solid.radius {
            return Err(PlateError::Penetration { depth: -gap });
        }
        self.time = time;
        self.state = *state;
        self.airborne = gap > TOUCHING * self.solid.radius;
        self.unloaded = None;
        self.flat_from = f64::NEG_INFINITY;
        self.solver.forget();
        Ok(())
    }

    /// Simulates a body that lies flat on until `time`, in place of ending the call.
    pub(super) fn keep_until(&mut self, time: f64) {
        self.flat_from = time;
    }

    /// The state relative to the plate.
    pub fn state(&self) -> &RigidState {
        &self.state
    }

    /// The time in s.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// The gap between the lowest point of the body and the plate, in m.
    pub fn gap(&self) -> f64 {
        self.solid.gap(&self.state).0
    }

    /// Kinetic energy relative to the plate in J.
    pub fn relative_energy(&self) -> f64 {
        let inertia = self.solid.inertia_at(&self.state.orientation);
        let spin = &self.state.angular_velocity;
        0.5 * (self.solid.mass * self.state.velocity.norm_squared() + spin.dot(&(inertia * spin)))
    }

    /// Steps in which normal impulses and friction did not agree to the tolerance within the allowed iterations. The points
    /// do not penetrate and no energy was made there, but the friction force is approximate.
    pub fn unresolved_steps(&self) -> usize {
        self.unresolved
    }

    /// Simulates until `t_end` or until a face lies flat, adding to `events`.
    ///
    /// # Errors
    /// [`PlateError::Contact`] if the friction problem cannot be solved (numbers out of range).
    pub fn advance(
        &mut self,
        motion: &mut impl PlateMotion,
        t_end: f64,
        events: &mut Vec<BodyEvent>,
    ) -> Result<BodyStop, PlateError> {
        let mut impacts_at_once = 0;
        let mut window = (self.time, 0);
        for _ in 0..self.settings.max_steps {
            if !self.state.components().all(f64::is_finite) {
                return Ok(BodyStop::NotFinite);
            }
            if self.time >= t_end {
                return Ok(BodyStop::EndTime);
            }
            if self.time - window.0 > self.settings.contact_step {
                window = (self.time, 0);
            }
            window.1 += 1;
            let (fastest, slowest) = self.find_contacts();
            if window.1 > PILE_UP {
                // Events pile up: one step over all of them, without rebound.
                self.slide(motion, t_end, true)?;
                continue;
            }
            if self.closed.is_empty() || slowest > self.settings.rest_speed {
                if !self.airborne && self.gap() > TOUCHING * self.solid.radius {
                    self.airborne = true;
                    let time = self.unloaded.unwrap_or(self.time);
                    events.push(BodyEvent { time, kind: BodyEventKind::LiftOff });
                }
                impacts_at_once = 0;
                if self.flight(motion, t_end, slowest) {
                    continue;
                }
            }
            if self.airborne {
                self.airborne = false;
                events.push(BodyEvent { time: self.time, kind: BodyEventKind::Landing });
            }
            if fastest > self.settings.rest_speed && impacts_at_once < IMPACTS_AT_ONCE {
                impacts_at_once += 1;
                let kind = self.impact(fastest)?;
                self.unloaded = Some(self.time);
                events.push(BodyEvent { time: self.time, kind });
                continue;
            }
            impacts_at_once = 0;
            let start = self.time;
            let pressed = self.slide(motion, t_end, false)?;
            self.unloaded = if pressed { None } else { self.unloaded.or(Some(start)) };
            if pressed
                && self.time >= self.flat_from
                && let Some(overturned) = self.lies_flat()
            {
                return Ok(BodyStop::Flat { overturned });
            }
        }
        Ok(BodyStop::StepLimit)
    }

    /// Finds the points that touch. Returns their greatest speed of approach and their least speed of parting.
    fn find_contacts(&mut self) -> (f64, f64) {
        self.solid.points(&self.state.orientation, &mut self.points);
        self.closed.clear();
        let (mut approach, mut parting) = (f64::NEG_INFINITY, f64::INFINITY);
        for (k, arm) in self.points.iter().enumerate() {
            if self.state.position.z + arm.z <= TOUCHING * self.solid.radius {
                let speed = self.state.velocity.z + self.state.angular_velocity.cross(arm).z;
                approach = approach.max(-speed);
                parting = parting.min(speed);
                self.closed.push(k);
            }
        }
        (approach, parting)
    }

    /// The face that lies on the plate and does not move along the normal: true for the upper one.
    pub(super) fn lies_flat(&mut self) -> Option<bool> {
        self.find_contacts();
        let rate = |k: &usize| self.state.velocity.z + self.state.angular_velocity.cross(&self.points[*k]).z;
        let still = self.closed.iter().all(|k| rate(k).abs() < self.settings.rest_speed);
        if still { self.closed_face() } else { None }
    }
}
