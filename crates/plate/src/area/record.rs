//! What a simulation with area contact records.

use super::pressure::Support;
use crate::driven::Course;
use bracketry_sim::Slip;

/// One step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AreaSample {
    /// Time in s.
    pub t: f64,
    /// State `x, y, phi, vx, vy, w`.
    pub state: [f64; 6],
    /// Second derivatives of `x, y, phi`.
    pub acceleration: [f64; 3],
    /// Normal force in N.
    pub normal: f64,
    /// Center of pressure from the center of mass, plate axes, in m.
    pub center: [f64; 2],
    /// Friction on the object: force along x and y in N, torque in N m.
    pub friction: [f64; 3],
    /// How the plate carries the object; the least pressure is told here.
    pub support: Support,
    /// Whether it slips.
    pub slip: Slip,
}

/// What changed in a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AreaEvent {
    /// The object comes to rest on the plate.
    Sticks {
        /// When, in s.
        t: f64,
    },
    /// The object breaks loose in the step that ends at `t`.
    Slips {
        /// When, in s.
        t: f64,
    },
    /// Part of the footprint loses its pressure in the step that ends at `t`.
    PartialContact {
        /// When, in s.
        t: f64,
    },
    /// All of the footprint carries again from the step on that ends at `t`.
    FullContact {
        /// When, in s.
        t: f64,
    },
}

/// Work and energy relative to the plate, in J.
///
/// Every step changes the momentum by `dt` times mean forces, so its kinetic energy changes by `dt` times these forces times
/// the mean of old and new velocity, exactly. These products are taken as the works: the balance closes to rounding for both
/// schemes, and the works converge with the order of the scheme. The normal force does no work in the frame of the plate.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct EnergyBalance {
    /// Initial kinetic energy.
    pub begin: f64,
    /// Kinetic energy now.
    pub kinetic: f64,
    /// Work of friction.
    pub friction: f64,
    /// Work of gravity and of the forces of inertia that the plate's motion causes.
    pub drive: f64,
    /// Sum of the absolute works, the scale of the error.
    pub turnover: f64,
}

impl EnergyBalance {
    pub(super) fn start(kinetic: f64) -> Self {
        Self { begin: kinetic, kinetic, ..Self::default() }
    }

    pub(super) fn add(&mut self, friction: f64, drive: f64, kinetic: f64) {
        self.friction += friction;
        self.drive += drive;
        self.turnover += friction.abs() + drive.abs();
        self.kinetic = kinetic;
    }

    /// Kinetic energy that no work explains, relative to the turnover (0 if nothing moved).
    pub fn relative_error(&self) -> f64 {
        let missing = (self.kinetic - self.begin - self.friction - self.drive).abs();
        if missing == 0.0 { 0.0 } else { missing / (self.turnover + self.begin) }
    }
}

/// A recorded simulation.
#[derive(Debug, Clone, PartialEq)]
pub struct AreaRecord {
    /// Start in s.
    start: f64,
    state: [f64; 6],
    /// Every step.
    pub samples: Vec<AreaSample>,
    /// What changed and when.
    pub events: Vec<AreaEvent>,
    /// Work and energy since the state was set.
    pub energy: EnergyBalance,
}

impl AreaRecord {
    pub(super) fn new(start: f64, state: [f64; 6]) -> Self {
        Self { start, state, samples: Vec::new(), events: Vec::new(), energy: EnergyBalance::default() }
    }

    pub(super) fn push(&mut self, sample: &AreaSample) {
        let before = self.samples.last();
        let t = sample.t;
        let held = before.map_or(self.state[3..] == [0.0; 3], |s| s.slip == Slip::Held);
        match (held, sample.slip == Slip::Held) {
            (false, true) => self.events.push(AreaEvent::Sticks { t }),
            (true, false) => self.events.push(AreaEvent::Slips { t }),
            _ => {}
        }
        let full = |support: &Support| matches!(support, Support::Full { .. });
        match (before.is_none_or(|s| full(&s.support)), full(&sample.support)) {
            (true, false) => self.events.push(AreaEvent::PartialContact { t }),
            (false, true) => self.events.push(AreaEvent::FullContact { t }),
            _ => {}
        }
        self.samples.push(*sample);
    }
}

impl Course for AreaRecord {
    fn start(&self) -> f64 {
        self.start
    }

    fn end(&self) -> f64 {
        self.samples.last().map_or(self.start, |s| s.t)
    }

    /// Cubic Hermite interpolation of positions between steps, linear of velocities.
    fn state_at(&self, t: f64) -> [f64; 6] {
        let after = self.samples.partition_point(|s| s.t < t);
        let (t0, a) = if after == 0 {
            (self.start, self.state)
        } else {
            (self.samples[after - 1].t, self.samples[after - 1].state)
        };
        let Some(next) = self.samples.get(after) else {
            return a;
        };
        let (h, b) = (next.t - t0, next.state);
        let s = ((t - t0) / h).clamp(0.0, 1.0);
        std::array::from_fn(|i| {
            if i >= 3 {
                return a[i] + s * (b[i] - a[i]);
            }
            let (left, right) = (h * a[i + 3], h * b[i + 3]);
            let rise = b[i] - a[i];
            a[i] + s * (left + s * ((3.0 * rise - 2.0 * left - right) + s * (left + right - 2.0 * rise)))
        })
    }

    fn join(&mut self, later: &Self) {
        self.samples.extend_from_slice(&later.samples);
        self.events.extend_from_slice(&later.events);
        self.energy = later.energy;
    }
}
