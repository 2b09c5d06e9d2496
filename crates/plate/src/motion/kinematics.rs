//! Displacement and tilt of the plate with their derivatives.

/// Displacement and tilt of the plate with their first two time derivatives.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PlateKinematics {
    /// `X` in m, along the plate's x axis.
    pub displacement: f64,
    /// `X'` in m/s.
    pub velocity: f64,
    /// `X''` in m/s².
    pub acceleration: f64,
    /// `θ` in rad about the x axis, positive if it raises +y.
    pub tilt: f64,
    /// `θ'` in rad/s.
    pub tilt_rate: f64,
    /// `θ''` in rad/s².
    pub tilt_acceleration: f64,
}

impl PlateKinematics {
    /// The motion `dt` seconds later if the accelerations stay as they are; exact for held commands.
    #[must_use]
    pub fn after(&self, dt: f64) -> Self {
        let half = 0.5 * dt * dt;
        Self {
            displacement: self.displacement + dt * self.velocity + half * self.acceleration,
            velocity: self.velocity + dt * self.acceleration,
            tilt: self.tilt + dt * self.tilt_rate + half * self.tilt_acceleration,
            tilt_rate: self.tilt_rate + dt * self.tilt_acceleration,
            ..*self
        }
    }
}

/// A plate motion in time. Closures `FnMut(f64) -> PlateKinematics` are motions.
pub trait PlateMotion {
    /// The motion at time `t` in seconds.
    fn at(&mut self, t: f64) -> PlateKinematics;
}

impl<F: FnMut(f64) -> PlateKinematics> PlateMotion for F {
    fn at(&mut self, t: f64) -> PlateKinematics {
        self(t)
    }
}
