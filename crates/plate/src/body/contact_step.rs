//! Impacts and steps of a body whose points touch the plate.

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

use super::body_on_plate::{BodyOnPlate, LARGEST_TURN, TOUCHING};
use super::contact::{Contact, Impulses, normal_row};
use super::events::BodyEventKind;
use super::frame::{PlateFrame, RigidState};
use super::locate::locate;
use crate::{PlateError, PlateMotion};

/// Share of a point of the rim in the load of a face that lies flat, all of the footprint having the share 1.
const RIM_WEIGHT: f64 = 1e-4;

/// The end of a step in contact.
struct Stepped {
    state: RigidState,
    impulse: f64,
}

impl BodyOnPlate {
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
        let contact = |arm: Vector3<f64>, weight: f64| {
            let slip = before.velocity + before.angular_velocity.cross(&arm);
            let target = restitution * (-slip.z).max(0.0);
            Contact { arm: arm / length, target, coefficient: self.coefficient(&slip), weight }
        };
        let face = self.closed_face();
        let weight = if face.is_some() { RIM_WEIGHT } else { 1.0 };
        let mut contacts: Vec<Contact> = self.closed.iter().map(|&k| contact(self.points[k], weight)).collect();
        if let Some(upper) = face {
            // The footprint bears the load as its area does; the rim only what the footprint cannot.
            contacts.extend(self.solid.face_points(&at.orientation, upper).map(|(arm, share)| contact(arm, share)));
        }
        self.contacts = contacts;
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

    /// The face of which the whole rim touches: true for the upper one.
    pub(super) fn closed_face(&self) -> Option<bool> {
        // The points that touch are in order, those of the lower face first.
        let face = self.solid.points_per_face();
        let lower = self.closed.partition_point(|&k| k < face);
        if lower == face {
            Some(false)
        } else if self.closed.len() - lower == face {
            Some(true)
        } else {
            None
        }
    }

    /// The impact of the points that touch.
    pub(super) fn impact(&mut self, speed: f64) -> Result<BodyEventKind, PlateError> {
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
    pub(super) fn slide(
        &mut self,
        motion: &mut impl PlateMotion,
        t_end: f64,
        at_once: bool,
    ) -> Result<bool, PlateError> {
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
            let start = self.open_gap(&self.state.clone()).max(0.0);
            let mut failed = None;
            dt = locate(0.0, start, below, |s| match self.step(motion, &world, s) {
                Ok(end) => self.open_gap(&end.state),
                Err(error) => {
                    failed = Some(error);
                    0.0
                }
            });
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
        let rotation = (after.angular_velocity - free.angular_velocity) * half;
        let moved = after.displaced(&shift, &rotation);
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
            let rotation = move_by.fixed_rows::<3>(3) / length;
            state = state.displaced(&shift, &rotation);
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
