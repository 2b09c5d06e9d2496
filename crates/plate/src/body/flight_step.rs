//! Steps of a body in flight.

use super::body_on_plate::{BodyOnPlate, LARGEST_TURN};
use super::flight::fly;
use super::frame::{PlateFrame, RigidState};
use super::locate::locate;
use crate::PlateMotion;

impl BodyOnPlate {
    /// The state relative to the plate after a free flight of `dt`.
    pub(super) fn free(&self, motion: &mut impl PlateMotion, world: &RigidState, dt: f64) -> RigidState {
        let end = fly(world, dt, self.settings.gravity, &self.solid.inertia, &self.solid.inverse_inertia);
        PlateFrame::new(&motion.at(self.time + dt)).from_world(&end)
    }

    /// The longest step that keeps rotation small.
    pub(super) fn limited(&self, dt: f64, turn: f64) -> f64 {
        let spin = self.state.angular_velocity.norm();
        if spin * dt > turn { turn / spin } else { dt }
    }

    /// One step of flight, ended where the body meets the plate; `slowest` is the least speed of parting of the points that
    /// touch. False, and nothing done, if they do not come clear of the plate.
    pub(super) fn flight(&mut self, motion: &mut impl PlateMotion, t_end: f64, slowest: f64) -> bool {
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
    pub(super) fn dip(&self, end: &RigidState, dt: f64, touching: &[usize]) -> Option<f64> {
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
}
