//! Area contact, and beyond: what tips or lifts off goes on as a free rigid body until it lies flat again.

use std::ops::ControlFlow;

use bracketry_sim::Slip;
use nalgebra::{UnitQuaternion, Vector3};

use super::error::PlateRunError;
use super::imposed_motion::ImposedMotion;
use super::object_model::{ObjectModel, Touch};
use super::result::PlateStop;
use super::setup::{PlateModel, PlateSetup};
use crate::area::{AreaContact, AreaOutcome, AreaSample, AreaSettings};
use crate::body::{BodyEvent, BodyEventKind, BodyOnPlate, BodySettings, BodyStop, RigidState};

/// Slip below which a point of the contact sticks, in m/s.
const STICKS: f64 = 1e-9;
/// Changes between lying flat and tipping within one row of the result before the run ends.
const MOST_CHANGES: usize = 1000;

/// An object with friction over its whole footprint.
#[derive(Clone)]
pub(super) struct FootprintModel {
    contact: AreaContact,
    motion: ImposedMotion,
    last: Option<AreaSample>,
    held: bool,
    events: usize,
    /// Work that no energy explains and turnover of the balances before the present one, in J.
    missing: f64,
    turnover: f64,
    /// The body it becomes when it tips or lifts off, if the model has one.
    body: Option<Body>,
}

#[derive(Clone)]
struct Body {
    on_plate: BodyOnPlate,
    height: f64,
    /// Whether it is the body that moves now.
    free: bool,
    events: Vec<BodyEvent>,
}

impl FootprintModel {
    pub(super) fn new(setup: &PlateSetup, motion: ImposedMotion) -> Result<Self, PlateRunError> {
        let settings = AreaSettings::default().with_step(setup.dt).with_points(setup.points);
        let mut contact = AreaContact::new(&setup.object, &setup.friction, &settings)?;
        let [x, y, phi] = setup.start;
        contact.set_state([x, y, phi, 0.0, 0.0, 0.0])?;
        contact.set_time(setup.from)?;
        let body = match setup.model {
            PlateModel::Body => {
                let settings =
                    BodySettings { contact_step: setup.dt, restitution: setup.restitution, ..BodySettings::default() };
                let on_plate = BodyOnPlate::new(&setup.object, &setup.friction, &settings)?;
                Some(Body { on_plate, height: setup.object.height, free: false, events: Vec::new() })
            }
            _ => None,
        };
        Ok(Self { contact, motion, last: None, held: true, events: 0, missing: 0.0, turnover: 0.0, body })
    }

    fn free(&self) -> Option<&Body> {
        self.body.as_ref().filter(|b| b.free)
    }

    /// Puts the flat object into another state; the energy balance goes on.
    fn set_flat(&mut self, t: f64, state: [f64; 6]) -> Result<(), PlateRunError> {
        let energy = self.contact.energy();
        self.missing += energy.relative_error() * (energy.turnover + energy.begin);
        self.turnover += energy.turnover;
        self.contact.set_state(state)?;
        self.contact.set_time(t)?;
        Ok(())
    }

    fn advance_flat(&mut self, t: f64) -> Result<AreaOutcome, PlateRunError> {
        let (last, held, events) = (&mut self.last, &mut self.held, &mut self.events);
        Ok(self.contact.advance_with(&mut self.motion, t, |sample| {
            let now = sample.slip == Slip::Held;
            *events += usize::from(now != *held);
            *held = now;
            *last = Some(*sample);
        })?)
    }

    /// The free body to `t` or until it lies flat; what ends the call.
    fn advance_free(&mut self, t: f64) -> Result<ControlFlow<Option<PlateStop>>, PlateRunError> {
        let yaw = self.contact.state()[2];
        let Some(body) = &mut self.body else { return Ok(ControlFlow::Continue(())) };
        let stop = body.on_plate.advance(&mut self.motion, t, &mut body.events)?;
        // The yaw is followed turn by turn.
        let (at, state) = (body.on_plate.time(), flat_state(body.on_plate.state(), yaw));
        let stopped = match stop {
            BodyStop::EndTime => None,
            BodyStop::Flat { overturned: false } => {
                body.free = false;
                body.events.push(BodyEvent { time: at, kind: BodyEventKind::Settled { overturned: false } });
                self.set_flat(at, state)?;
                return Ok(ControlFlow::Continue(()));
            }
            BodyStop::Flat { overturned: true } => Some(PlateStop::Overturned { t: at }),
            BodyStop::StepLimit => Some(PlateStop::StepLimit { t: at }),
            BodyStop::NotFinite => Some(PlateStop::NotFinite { t: at }),
        };
        if stopped.is_none() {
            self.set_flat(at, state)?;
        }
        Ok(ControlFlow::Break(stopped))
    }

    /// The flat object to `t` or until it tips or lifts off, where the body takes over; what ends the call.
    fn advance_until_departure(&mut self, t: f64) -> Result<ControlFlow<Option<PlateStop>>, PlateRunError> {
        let outcome = self.advance_flat(t)?;
        match outcome {
            AreaOutcome::Finished => return Ok(ControlFlow::Break(None)),
            AreaOutcome::NotFinite { t } => return Ok(ControlFlow::Break(Some(PlateStop::NotFinite { t }))),
            AreaOutcome::LiftOff { .. } | AreaOutcome::Tipping { .. } => {}
        }
        let (at, [x, y, phi, vx, vy, w]) = (self.contact.time(), self.contact.state());
        let Some(body) = &mut self.body else {
            return Ok(ControlFlow::Break(Some(PlateStop::Departed(outcome))));
        };
        body.free = true;
        if matches!(outcome, AreaOutcome::Tipping { .. }) {
            body.events.push(BodyEvent { time: at, kind: BodyEventKind::Tipping });
        }
        let state = RigidState {
            position: Vector3::new(x, y, body.height),
            orientation: UnitQuaternion::from_axis_angle(&Vector3::z_axis(), phi),
            velocity: Vector3::new(vx, vy, 0.0),
            angular_velocity: Vector3::new(0.0, 0.0, w),
        };
        body.on_plate.set_state(at, &state)?;
        Ok(ControlFlow::Continue(()))
    }
}

impl ObjectModel for FootprintModel {
    fn time(&self) -> f64 {
        self.free().map_or(self.contact.time(), |b| b.on_plate.time())
    }

    fn state(&self) -> [f64; 6] {
        match self.free() {
            Some(body) => flat_state(body.on_plate.state(), self.contact.state()[2]),
            None => self.contact.state(),
        }
    }

    fn motion(&mut self) -> &mut ImposedMotion {
        &mut self.motion
    }

    fn advance(&mut self, t: f64) -> Result<Option<PlateStop>, PlateRunError> {
        for _ in 0..MOST_CHANGES {
            if self.time() >= t {
                return Ok(None);
            }
            let step = if self.free().is_some() { self.advance_free(t)? } else { self.advance_until_departure(t)? };
            if let ControlFlow::Break(stopped) = step {
                return Ok(stopped);
            }
        }
        Ok(Some(PlateStop::Rocking { t: self.time() }))
    }

    fn set_amplitude(&mut self, amplitude: f64) {
        self.motion.set_amplitude(amplitude);
    }

    fn start_piece(&mut self, t: f64) -> Result<(), PlateRunError> {
        self.motion.start_piece(t);
        Ok(())
    }

    fn shift(&mut self, x: f64, vx: f64) -> Result<(), PlateRunError> {
        if let Some(body) = self.body.as_mut().filter(|b| b.free) {
            let mut state = *body.on_plate.state();
            state.position.x += x;
            state.velocity.x += vx;
            return Ok(body.on_plate.set_state(body.on_plate.time(), &state)?);
        }
        let mut state = self.contact.state();
        state[0] += x;
        state[3] += vx;
        self.set_flat(self.contact.time(), state)
    }

    fn fork(&self) -> Box<dyn ObjectModel> {
        Box::new(self.clone())
    }

    fn flat(&self) -> bool {
        self.free().is_none()
    }

    fn touch(&mut self) -> Touch {
        if let Some(body) = self.free() {
            let normal = body.on_plate.state().orientation * Vector3::z();
            let lean = (-normal.y).atan2(normal.z);
            let gap = body.on_plate.gap().max(0.0);
            return Touch { load: Some(f64::NAN), stick_fraction: f64::NAN, gap, lean };
        }
        let [_, _, phi, vx, vy, w] = self.contact.state();
        let (s, c) = phi.sin_cos();
        let sticks = |p: &&[f64; 2]| {
            let (u, v) = (c * p[0] - s * p[1], s * p[0] + c * p[1]);
            (vx - w * v).hypot(vy + w * u) <= STICKS
        };
        let points = self.contact.footprint().points();
        let sticking = points.iter().filter(sticks).count();
        Touch { stick_fraction: sticking as f64 / points.len().max(1) as f64, ..Touch::default() }
    }

    fn events(&self) -> Option<usize> {
        Some(self.events + self.body.as_ref().map_or(0, |b| b.events.len()))
    }

    fn energy_closure(&self) -> Option<f64> {
        // The free body keeps no balance.
        if self.body.as_ref().is_some_and(|b| !b.events.is_empty()) {
            return None;
        }
        let energy = self.contact.energy();
        let missing = self.missing + energy.relative_error() * (energy.turnover + energy.begin);
        let turnover = self.turnover + energy.turnover + energy.begin;
        Some(if turnover > 0.0 { missing / turnover } else { 0.0 })
    }
}

/// `x, y, phi` and their rates of a body, the yaw in the turn nearest to `near`.
fn flat_state(state: &RigidState, near: f64) -> [f64; 6] {
    use std::f64::consts::TAU;
    let heading = state.orientation * Vector3::x();
    let phi = heading.y.atan2(heading.x);
    let phi = phi + ((near - phi) / TAU).round() * TAU;
    let (p, v) = (&state.position, &state.velocity);
    [p.x, p.y, phi, v.x, v.y, state.angular_velocity.z]
}
