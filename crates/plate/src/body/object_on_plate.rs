//! An object on the plate however it moves: flat, tipping, in flight, landing.

use std::f64::consts::{PI, TAU};

use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use super::body_on_plate::{BodyOnPlate, BodyStop};
use super::events::{BodyEvent, BodyEventKind};
use super::frame::{PlateFrame, RigidState};
use super::settings::BodySettings;
use crate::area::{AreaContact, AreaOutcome, AreaSettings};
use crate::{Friction, Object, PlateError, PlateMotion, Shape};

/// Steps in contact for which a body that lies flat without being able to stay so is simulated on.
const UNSTEADY_STEPS: f64 = 20.0;

/// How an object moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ObjectMode {
    /// A face lies on the plate: area contact in three degrees of freedom.
    Flat {
        /// Whether it is the face that is the upper one at orientation zero.
        overturned: bool,
    },
    /// It tips, rolls or flies: a rigid body in six degrees of freedom.
    Free,
}

/// Why a call of [`ObjectOnPlate::advance`] ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ObjectStop {
    /// The end time is reached.
    EndTime,
    /// The number of steps is used up: what happens is too fast for the steps that were allowed.
    StepLimit,
    /// State or plate motion left the range of floating-point numbers.
    NotFinite,
}

/// An object on the moving plate: [`AreaContact`] while it lies flat, [`BodyOnPlate`] from the instant at which it tips or
/// lifts off until it lies flat again.
///
/// ```
/// use bracketry_plate::{Friction, Object, PlateKinematics};
/// use bracketry_plate::area::AreaSettings;
/// use bracketry_plate::body::{BodySettings, ObjectMode, ObjectOnPlate, RigidState};
/// let settings = BodySettings { restitution: 0.5, ..BodySettings::default() };
/// let friction = Friction::Coulomb { mu: 0.3 };
/// let mut object = ObjectOnPlate::new(&Object::REFERENCE, &friction, &AreaSettings::default(), &settings).unwrap();
/// object.set_state(0.0, &RigidState::at_rest(0.0025 + 0.1)).unwrap();
/// object.advance(&mut |_| PlateKinematics::default(), 1.0).unwrap();
/// assert_eq!(object.mode(), ObjectMode::Flat { overturned: false });
/// // The first impact is at sqrt(2 · 0.1 m / g).
/// assert!((object.events()[0].time - (0.2_f64 / 9.81).sqrt()).abs() < 1e-10);
/// ```
#[derive(Debug, Clone)]
pub struct ObjectOnPlate {
    object: Object,
    /// Contact on the lower and on the upper face.
    faces: [AreaContact; 2],
    body: BodyOnPlate,
    mode: ObjectMode,
    /// Yaw when the object last lay flat, whole turns included.
    yaw: f64,
    area_step: f64,
    contact_step: f64,
    events: Vec<BodyEvent>,
}

impl ObjectOnPlate {
    /// The object at rest in the origin at time 0, flat.
    ///
    /// # Errors
    /// [`PlateError`] if object, friction law or settings have no meaning, [`PlateError::GravityDiffers`] if the two
    /// settings do not agree on gravity.
    pub fn new(
        object: &Object,
        friction: &Friction,
        area: &AreaSettings,
        body: &BodySettings,
    ) -> Result<Self, PlateError> {
        if area.gravity != body.gravity {
            return Err(PlateError::GravityDiffers { area: area.gravity, body: body.gravity });
        }
        let lower = AreaContact::new(object, friction, area)?;
        let upper = AreaContact::new(&flipped(object)?, friction, area)?;
        Ok(Self {
            object: object.clone(),
            faces: [lower, upper],
            body: BodyOnPlate::new(object, friction, body)?,
            mode: ObjectMode::Flat { overturned: false },
            yaw: 0.0,
            area_step: area.step,
            contact_step: body.contact_step,
            events: Vec::new(),
        })
    }

    /// Starts from any state relative to the plate at `time`; the log of events restarts.
    ///
    /// # Errors
    /// [`PlateError::BadState`] for a number that is not finite, [`PlateError::Penetration`] for a body that reaches below
    /// the plate.
    pub fn set_state(&mut self, time: f64, state: &RigidState) -> Result<(), PlateError> {
        self.body.set_state(time, state)?;
        self.events.clear();
        self.mode = ObjectMode::Free;
        self.yaw = yaw(state);
        if let Some(overturned) = self.body.lies_flat() {
            self.lay(overturned)?;
        }
        Ok(())
    }

    /// Starts flat, on its lower face, from `x, y, phi, vx, vy, w`.
    ///
    /// # Errors
    /// [`PlateError::BadState`] for a number that is not finite.
    pub fn set_flat_state(&mut self, time: f64, state: [f64; 6]) -> Result<(), PlateError> {
        self.faces[0].set_time(time)?;
        self.faces[0].set_state(state)?;
        self.events.clear();
        self.yaw = state[2];
        self.mode = ObjectMode::Flat { overturned: false };
        Ok(())
    }

    /// How the object moves now.
    pub fn mode(&self) -> ObjectMode {
        self.mode
    }

    /// The time in s.
    pub fn time(&self) -> f64 {
        match self.mode {
            ObjectMode::Flat { overturned } => self.faces[usize::from(overturned)].time(),
            ObjectMode::Free => self.body.time(),
        }
    }

    /// The state relative to the plate.
    pub fn state(&self) -> RigidState {
        match self.mode {
            ObjectMode::Flat { overturned } => self.flat(overturned),
            ObjectMode::Free => *self.body.state(),
        }
    }

    /// `x, y, phi, vx, vy, w`: the state along the plate. Of a body that does not lie flat, `phi` is the direction of its own
    /// x axis seen along the normal, and `w` the angular velocity about the normal.
    pub fn planar_state(&self) -> [f64; 6] {
        match self.mode {
            ObjectMode::Flat { overturned } => self.faces[usize::from(overturned)].state(),
            ObjectMode::Free => {
                let s = self.body.state();
                [s.position.x, s.position.y, self.near(yaw(s)), s.velocity.x, s.velocity.y, s.angular_velocity.z]
            }
        }
    }

    /// The pose in the plate frame.
    pub fn pose(&self) -> Isometry3<f64> {
        self.state().pose()
    }

    /// The pose in the world, the plate moving as given.
    pub fn world_pose(&self, motion: &mut impl PlateMotion) -> Isometry3<f64> {
        PlateFrame::new(&motion.at(self.time())).pose() * self.pose()
    }

    /// What happened since the last state that was set.
    pub fn events(&self) -> &[BodyEvent] {
        &self.events
    }

    /// Steps with approximate friction; see [`BodyOnPlate::unresolved_steps`].
    pub fn unresolved_steps(&self) -> usize {
        self.body.unresolved_steps()
    }

    /// Simulates to `t_end`.
    ///
    /// # Errors
    /// [`PlateError::BadState`] if `t_end` is not finite or lies in the past; [`PlateError::Contact`] if numbers leave the
    /// range in which friction can be solved for.
    pub fn advance(&mut self, motion: &mut impl PlateMotion, t_end: f64) -> Result<ObjectStop, PlateError> {
        if !t_end.is_finite() || t_end < self.time() {
            return Err(PlateError::BadState { value: t_end });
        }
        loop {
            match self.mode {
                ObjectMode::Flat { overturned } => {
                    let kind = match self.faces[usize::from(overturned)].advance(motion, t_end)? {
                        AreaOutcome::Finished => return Ok(ObjectStop::EndTime),
                        AreaOutcome::NotFinite { .. } => return Ok(ObjectStop::NotFinite),
                        AreaOutcome::Tipping { .. } => Some(BodyEventKind::Tipping),
                        AreaOutcome::LiftOff { .. } => None,
                    };
                    let time = self.time();
                    self.events.extend(kind.map(|kind| BodyEvent { time, kind }));
                    let state = self.flat(overturned);
                    self.yaw = self.planar_state()[2];
                    self.body.set_state(time, &state)?;
                    self.body.keep_until(time + UNSTEADY_STEPS * self.contact_step);
                    self.mode = ObjectMode::Free;
                }
                ObjectMode::Free => match self.body.advance(motion, t_end, &mut self.events)? {
                    BodyStop::EndTime => return Ok(ObjectStop::EndTime),
                    BodyStop::StepLimit => return Ok(ObjectStop::StepLimit),
                    BodyStop::NotFinite => return Ok(ObjectStop::NotFinite),
                    BodyStop::Flat { overturned } => self.settle(motion, overturned, t_end)?,
                },
            }
        }
    }

    /// Goes over to area contact if it holds for a step.
    fn settle(&mut self, motion: &mut impl PlateMotion, overturned: bool, t_end: f64) -> Result<(), PlateError> {
        let time = self.body.time();
        self.lay(overturned)?;
        let ahead = (time + self.area_step).min(t_end);
        if self.faces[usize::from(overturned)].advance(motion, ahead)?.is_finished() {
            self.events.push(BodyEvent { time, kind: BodyEventKind::Settled { overturned } });
        } else {
            self.mode = ObjectMode::Free;
            self.body.keep_until(time + UNSTEADY_STEPS * self.contact_step);
        }
        Ok(())
    }

    /// Area contact from the state of the body, the rounding of its rest removed.
    fn lay(&mut self, overturned: bool) -> Result<(), PlateError> {
        let time = self.body.time();
        let state = self.planar_state();
        self.yaw = state[2];
        let contact = &mut self.faces[usize::from(overturned)];
        contact.set_time(time)?;
        contact.set_state(state)?;
        self.mode = ObjectMode::Flat { overturned };
        Ok(())
    }

    /// The state of the object on a face.
    fn flat(&self, overturned: bool) -> RigidState {
        let [x, y, phi, vx, vy, w] = self.faces[usize::from(overturned)].state();
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), phi);
        let over = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), if overturned { PI } else { 0.0 });
        RigidState {
            position: Vector3::new(x, y, self.object.height),
            orientation: turn * over,
            velocity: Vector3::new(vx, vy, 0.0),
            angular_velocity: Vector3::new(0.0, 0.0, w),
        }
    }

    /// The angle `yaw` with the whole turns that bring it nearest to the last known yaw.
    fn near(&self, yaw: f64) -> f64 {
        yaw + TAU * ((self.yaw - yaw) / TAU).round()
    }
}

/// Direction of the body's x axis along the plate.
fn yaw(state: &RigidState) -> f64 {
    let axis = state.orientation * Vector3::x();
    axis.y.atan2(axis.x)
}

/// The object rotated by half a turn about its own x axis.
fn flipped(object: &Object) -> Result<Object, PlateError> {
    let shape = match &object.shape {
        Shape::Polygon { vertices } => {
            let mirrored: Vec<[f64; 2]> = vertices.iter().map(|v| [v[0], -v[1]]).collect();
            Shape::polygon(&mirrored)?
        }
        other => other.clone(),
    };
    Ok(Object { shape, ..object.clone() })
}
