//! A rigid body in all six degrees of freedom on the moving plate.

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

use super::contact::{Contact, ContactSolver, Impulses, normal_row};
use super::events::{BodyEvent, BodyEventKind};
use super::flight::fly;
use super::solid::Solid;
use super::{BodySettings, PlateFrame, RigidState};
use crate::{Friction, Object, PlateError, PlateMotion};

/// Gap in lengths of the body below which a point touches.
const TOUCHING: f64 = 1e-8;
/// Largest rotation in one step in contact, in rad.
const LARGEST_TURN: f64 = 0.05;
/// Resolution of event times in s.
const TIME_RESOLUTION: f64 = 1e-12;
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
    solid: Solid,
    friction: Friction,
    settings: BodySettings,
    state: RigidState,
    time: f64,
    solver: ContactSolver,
    points: Vec<Vector3<f64>>,
    /// Numbers of the points that touch.
    closed: Vec<usize>,
    contacts: Vec<Contact>,
    airborne: bool,
    unresolved: usize,
}

/// The end of a step in contact.
struct Stepped {
    state: RigidState,
    impulse: f64,
}

impl BodyOnPlate {
    /// The object at rest at the origin of the plate at time 0.
    ///
    /// # Errors
    /// [`PlateError`] for an object, a friction law or settings without meaning.
    pub fn new(object: &Object, friction: &Friction, settings: &BodySettings) -> Result<Self, PlateError> {
        friction.validate()?;
        settings.validate()?;
        let solid = Solid::of(object)?;
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
            unresolved: 0,
        })
    }

    /// Starts from `state`, relative to the plate, at `time`.
    ///
    /// # Errors
    /// [`PlateError::StateNotFinite`], or [`PlateError::Penetration`] if a point lies below the plate.
    pub fn set_state(&mut self, time: f64, state: &RigidState) -> Result<(), PlateError> {
        if !(state.is_finite() && time.is_finite()) {
            return Err(PlateError::StateNotFinite);
        }
        let gap = self.solid.gap(state).0;
        if gap < -TOUCHING * self.solid.radius {
            return Err(PlateError::Penetration { depth: -gap });
        }
        self.time = time;
        self.state = *state;
        self.airborne = gap > TOUCHING * self.solid.radius;
        self.solver.forget();
        Ok(())
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
            if !self.state.is_finite() {
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
                    events.push(BodyEvent { time: self.time, kind: BodyEventKind::LiftOff });
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
                events.push(BodyEvent { time: self.time, kind });
                continue;
            }
            impacts_at_once = 0;
            let pressed = self.slide(motion, t_end, false)?;
            if pressed && let Some(overturned) = self.lies_flat() {
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

    /// Whether all points of one face touch, and which one.
    fn lies_flat(&mut self) -> Option<bool> {
        let (approach, parting) = self.find_contacts();
        let still = approach.max(0.0) < self.settings.rest_speed && parting > -self.settings.rest_speed;
        let face = self.solid.points_per_face();
        let spread = self.closed.iter().map(|&k| {
            let speed = self.state.velocity.z + self.state.angular_velocity.cross(&self.points[k]).z;
            speed.abs()
        });
        let moving = spread.fold(0.0, f64::max) > self.settings.rest_speed;
        let all = |from: usize| (from..from + face).all(|k| self.closed.contains(&k));
        if !still || moving {
            None
        } else if all(0) {
            Some(false)
        } else if self.points.len() > face && all(face) {
            Some(true)
        } else {
            None
        }
    }

    /// The state relative to the plate after a free flight of `dt`.
    fn free(&self, motion: &mut impl PlateMotion, world: &RigidState, dt: f64) -> RigidState {
        let end = fly(world, dt, self.settings.gravity, &self.solid.inertia, &self.solid.inverse_inertia);
        PlateFrame::new(&motion.at(self.time + dt)).from_world(&end)
    }

    /// The longest step that keeps rotation small.
    fn limited(&self, dt: f64, turn: f64) -> f64 {
        let spin = self.state.angular_velocity.norm();
        if spin * dt > turn { turn / spin } else { dt }
    }

    /// One step of flight, ended where the body meets the plate; `slowest` is the least speed of parting of the points that
    /// touch. False, and nothing done, if they do not come clear of the plate.
    fn flight(&mut self, motion: &mut impl PlateMotion, t_end: f64, slowest: f64) -> bool {
        let world = PlateFrame::new(&motion.at(self.time)).to_world(&self.state);
        let gap = self.solid.gap(&self.state).0;
        let left = t_end - self.time;
        let mut dt = self.limited(self.settings.flight_step, LARGEST_TURN).min(left);
        let (mut low, mut at_low) = (0.0, gap.max(0.0));
        // After a rebound gaps begin at zero: look for the next zero from the top of the shortest bounce on.
        if !self.closed.is_empty() {
            let top = self.shortest_rise(motion, &world, slowest);
            if top < dt {
                (low, at_low) = (top, self.solid.gap(&self.free(motion, &world, top)).0);
                if at_low <= 0.0 {
                    return false;
                }
                dt = dt.min(2.5 * top);
            }
        }
        let mut end = self.free(motion, &world, dt);
        let below = if self.solid.gap(&end).0 < 0.0 {
            Some(dt)
        } else {
            self.dip(&end, dt, &[]).filter(|&s| s > low && self.solid.gap(&self.free(motion, &world, s)).0 < 0.0)
        };
        if let Some(below) = below {
            dt = locate(low, at_low, below, |s| self.solid.gap(&self.free(motion, &world, s)).0);
            end = self.free(motion, &world, dt);
        }
        self.state = end;
        self.time = if dt >= left { t_end } else { self.time + dt };
        true
    }

    /// The time until the first of the points that touch and part, the slowest with the speed `slowest`, stops rising.
    fn shortest_rise(&self, motion: &mut impl PlateMotion, world: &RigidState, slowest: f64) -> f64 {
        let probe = (slowest / self.settings.gravity * 1e-3).min(1e-3 * self.settings.flight_step);
        let later = self.free(motion, world, probe);
        let mut points = Vec::new();
        self.solid.points(&later.orientation, &mut points);
        let rise = |&k: &usize| {
            let rate = self.state.velocity.z + self.state.angular_velocity.cross(&self.points[k]).z;
            let then = later.velocity.z + later.angular_velocity.cross(&points[k]).z;
            if then < rate { rate * probe / (rate - then) } else { f64::INFINITY }
        };
        self.closed.iter().map(rise).fold(f64::INFINITY, f64::min)
    }

    /// The time in a step of length `dt` to `end` at which a point, none of `touching`, comes lowest in between, if that may
    /// be below the plate: the least of the cubics through the gaps and their rates.
    fn dip(&self, end: &RigidState, dt: f64, touching: &[usize]) -> Option<f64> {
        let mut lowest = (0.0, None);
        let starts = self.solid.lowest_points(&self.state);
        for ((k, gap, rate), (_, gap_end, rate_end)) in starts.into_iter().zip(self.solid.lowest_points(end)) {
            if rate >= 0.0 || rate_end <= 0.0 || touching.contains(&k) {
                continue;
            }
            // g(s) = gap + rate s + c s² + d s³ in units of the step, g'(s) = 0.
            let (p, q) = (rate * dt, rate_end * dt);
            let (c, d) = (3.0 * (gap_end - gap) - 2.0 * p - q, p + q - 2.0 * (gap_end - gap));
            let root = (c * c - 3.0 * d * p).max(0.0).sqrt();
            let s = (-p / (c + root)).clamp(0.0, 1.0);
            let least = gap + s * (p + s * (c + s * d));
            if least < lowest.0 {
                lowest = (least, Some(s * dt));
            }
        }
        lowest.1
    }

    /// Coefficient of friction of the law at that slip.
    fn coefficient(&self, slip: &Vector3<f64>) -> f64 {
        let [dx, dy] = self.friction.weights();
        let speed = (dx * slip.x).hypot(dy * slip.y);
        if speed < self.settings.rest_speed {
            self.friction.static_coefficient()
        } else {
            self.friction.coefficient(speed)
        }
    }

    /// Solves for the impulses on the points `closed` of a body that has the velocities of `before` and the place of `at`
    /// where they act; without them it would have the velocities of `at`.
    fn impulses(
        &mut self,
        before: &RigidState,
        at: &RigidState,
        restitution: f64,
    ) -> Result<(RigidState, Impulses), PlateError> {
        let length = self.solid.radius;
        self.solid.points(&at.orientation, &mut self.points);
        self.contacts.clear();
        for &k in &self.closed {
            let arm = self.points[k];
            let slip = before.velocity + before.angular_velocity.cross(&arm);
            let target = restitution * (-slip.z).max(0.0);
            let coefficient = self.coefficient(&slip);
            self.contacts.push(Contact { arm: arm / length, target, coefficient });
        }
        let inertia = self.solid.inertia_at(&at.orientation) / (self.solid.mass * length * length);
        let mass = blocks(&inertia);
        let inverse = blocks(&inertia.try_inverse().unwrap_or_else(Matrix3::identity));
        let mut free = Vector6::zeros();
        free.fixed_rows_mut::<3>(0).copy_from(&at.velocity);
        free.fixed_rows_mut::<3>(3).copy_from(&(at.angular_velocity * length));
        let weights = self.friction.weights();
        let mut done = self.solver.solve(&mass, &inverse, &free, &self.contacts, weights)?;
        let energy = |v: &Vector6<f64>| v.dot(&(mass * v));
        let allowed = energy(&free) * (1.0 + 1e-12);
        if energy(&done.velocity) > allowed && restitution > 0.0 {
            // Newton's restitution with friction can make energy (Kane 1984): the greatest restitution that does not.
            let targets: Vec<f64> = self.contacts.iter().map(|c| c.target).collect();
            let (mut low, mut high) = (0.0, 1.0);
            for _ in 0..30 {
                let middle = 0.5 * (low + high);
                for (contact, target) in self.contacts.iter_mut().zip(&targets) {
                    contact.target = middle * target;
                }
                done = self.solver.solve(&mass, &inverse, &free, &self.contacts, weights)?;
                if energy(&done.velocity) > allowed { high = middle } else { low = middle }
            }
            for (contact, target) in self.contacts.iter_mut().zip(&targets) {
                contact.target = low * target;
            }
            done = self.solver.solve(&mass, &inverse, &free, &self.contacts, weights)?;
        }
        if energy(&done.velocity) > allowed {
            // Only where friction was not resolved: without it the impulses cannot make energy.
            for contact in &mut self.contacts {
                (contact.coefficient, contact.target) = (0.0, 0.0);
            }
            self.solver.forget();
            done = self.solver.solve(&mass, &inverse, &free, &self.contacts, weights)?;
        }
        if !done.converged {
            self.unresolved += 1;
            self.solver.forget();
        }
        let velocity = done.velocity.fixed_rows::<3>(0).into_owned();
        let angular_velocity = done.velocity.fixed_rows::<3>(3) / length;
        Ok((RigidState { velocity, angular_velocity, ..*at }, done))
    }

    /// The impact of the points that touch.
    fn impact(&mut self, speed: f64) -> Result<BodyEventKind, PlateError> {
        let before = self.state;
        let energy = self.relative_energy();
        self.solver.forget();
        let (after, done) = self.impulses(&before, &before, self.settings.restitution)?;
        self.solver.forget();
        self.state = after;
        let loss = energy - self.relative_energy();
        Ok(BodyEventKind::Impact { speed, impulse: done.normal * self.solid.mass, loss })
    }

    /// One step in contact, ended where another point meets the plate, or with all points that would meet it `at_once`.
    /// Returns whether the points press.
    fn slide(&mut self, motion: &mut impl PlateMotion, t_end: f64, at_once: bool) -> Result<bool, PlateError> {
        let left = t_end - self.time;
        let world = PlateFrame::new(&motion.at(self.time)).to_world(&self.state);
        let mut dt = self.limited(self.settings.contact_step, LARGEST_TURN).min(left);
        if at_once {
            let end = self.free(motion, &world, dt);
            self.solid.points(&end.orientation, &mut self.points);
            let below = |(_, arm): &(usize, &Vector3<f64>)| end.position.z + arm.z < 0.0;
            let all = self.points.iter().enumerate().filter(below).map(|(k, _)| k);
            self.closed = all.chain(self.closed.iter().copied()).collect();
            self.closed.sort_unstable();
            self.closed.dedup();
        }
        let mut end = self.step(motion, &world, dt)?;
        let tolerance = TOUCHING * self.solid.radius;
        let mut below = (self.open_gap(&end.state) < -tolerance).then_some(dt);
        if below.is_none()
            && let Some(s) = self.dip(&end.state, dt, &self.closed)
        {
            let middle = self.step(motion, &world, s)?;
            below = (self.open_gap(&middle.state) < -tolerance).then_some(s);
        }
        if let (Some(below), false) = (below, at_once) {
            let mut failed = None;
            let gap_of = |body: &mut Self, motion: &mut _, s: f64| match body.step(motion, &world, s) {
                Ok(end) => body.open_gap(&end.state),
                Err(error) => {
                    failed = Some(error);
                    0.0
                }
            };
            let start = self.open_gap(&self.state.clone()).max(0.0);
            let mut gap_of = gap_of;
            dt = locate(0.0, start, below, |s| gap_of(self, motion, s));
            if let Some(error) = failed {
                return Err(error);
            }
            end = self.step(motion, &world, dt)?;
        }
        self.state = end.state;
        self.time = if dt >= left { t_end } else { self.time + dt };
        Ok(end.impulse > 0.0)
    }

    /// The least gap of the points that were open when the step began.
    fn open_gap(&mut self, state: &RigidState) -> f64 {
        self.solid.points(&state.orientation, &mut self.points);
        let mut least = f64::INFINITY;
        for (k, arm) in self.points.iter().enumerate() {
            if !self.closed.contains(&k) {
                least = least.min(state.position.z + arm.z);
            }
        }
        least
    }

    /// The state after `dt` with the points `closed` in contact.
    ///
    /// The impulse is spread over the step, so half of its displacement is added to the free motion; the gaps of the points
    /// that press are then closed to rounding.
    fn step(&mut self, motion: &mut impl PlateMotion, world: &RigidState, dt: f64) -> Result<Stepped, PlateError> {
        let before = self.state;
        let free = self.free(motion, world, dt);
        let (after, done) = self.impulses(&before, &free, 0.0)?;
        let half = 0.5 * dt;
        let shift = (after.velocity - free.velocity) * half;
        let turn = (after.angular_velocity - free.angular_velocity) * half;
        let moved = after.displaced(&shift, &turn);
        Ok(Stepped { state: self.closed_up(moved), impulse: done.normal })
    }

    /// Moves the body so that the points with an impulse touch, the least in the metric of the mass.
    fn closed_up(&mut self, mut state: RigidState) -> RigidState {
        let length = self.solid.radius;
        let inertia = self.solid.inertia_at(&state.orientation) / (self.solid.mass * length * length);
        for _ in 0..2 {
            self.solid.points(&state.orientation, &mut self.points);
            let mut matrix = blocks(&inertia) * 1e-10;
            let mut right = Vector6::zeros();
            for (&k, impulse) in self.closed.iter().zip(&self.solver.impulses) {
                let arm = self.points[k] / length;
                let gap = state.position.z / length + arm.z;
                if *impulse > 0.0 || gap < 0.0 {
                    let row = normal_row(&arm);
                    matrix.ger(1.0, &row, &row, 1.0);
                    right -= row * gap;
                }
            }
            let Some(factor) = matrix.cholesky() else { return state };
            let move_by = factor.solve(&right) * length;
            let shift = move_by.fixed_rows::<3>(0).into_owned();
            let turn = move_by.fixed_rows::<3>(3) / length;
            state = state.displaced(&shift, &turn);
        }
        state
    }
}

/// Mass matrix of unit mass and that inertia.
fn blocks(inertia: &Matrix3<f64>) -> Matrix6<f64> {
    let mut mass = Matrix6::identity();
    mass.fixed_view_mut::<3, 3>(3, 3).copy_from(inertia);
    mass
}

/// The end, on the negative side, of an interval of [`TIME_RESOLUTION`] in which `f` changes sign, given `f(low) = at_low ≥ 0`
/// and `f(high) < 0`: false position with the Illinois rule, bisection where that is slow.
fn locate(mut low: f64, mut at_low: f64, mut high: f64, mut f: impl FnMut(f64) -> f64) -> f64 {
    let mut at_high = f(high);
    let mut side = 0;
    for round in 0..200 {
        let width = high - low;
        if width <= TIME_RESOLUTION {
            break;
        }
        let secant = high - at_high * width / (at_high - at_low);
        let middle = if round % 3 == 2 || !(secant > low && secant < high) {
            0.5 * (low + high)
        } else {
            // A step to the other side of the root shrinks the interval from both ends.
            secant.clamp(low + 0.1 * TIME_RESOLUTION, high - 0.1 * TIME_RESOLUTION)
        };
        if middle <= low || middle >= high {
            break;
        }
        let value = f(middle);
        if value < 0.0 {
            (high, at_high) = (middle, value);
            if side == -1 {
                at_low *= 0.5;
            }
            side = -1;
        } else {
            (low, at_low) = (middle, value);
            if side == 1 {
                at_high *= 0.5;
            }
            side = 1;
        }
    }
    high
}
