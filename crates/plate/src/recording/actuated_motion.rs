//! What the plate does when it is told to move.

use super::mismatch::PlateMismatch;
use crate::motion::ExpressionMotion;
use crate::{PlateKinematics, PlateMotion};

/// Time between the nodes at which a lagging motion is kept, in s.
const NODE: f64 = 5e-4;

/// The motion of the plate under a command, with what the plant does otherwise.
pub(super) struct ActuatedMotion {
    /// The command.
    command: ExpressionMotion,
    /// Time constant in s and displacement and tilt at nodes `NODE` apart.
    lag: Option<(f64, f64, Vec<[f64; 2]>)>,
    /// What else is otherwise than believed, and gravity in m/s².
    effect: PlateMismatch,
    gravity: f64,
}

impl ActuatedMotion {
    /// The motion from time 0 on, where the plate stands as it is told, under gravity in m/s².
    pub(super) fn new(mut command: ExpressionMotion, effect: &PlateMismatch, gravity: f64) -> Self {
        let start = command.at(0.0);
        let lag = match *effect {
            PlateMismatch::ActuatorLag(time) => Some((time, 0.0, vec![[start.displacement, start.tilt]])),
            _ => None,
        };
        Self { command, lag, effect: *effect, gravity }
    }

    /// What the plate is told to do.
    pub(super) fn command(&mut self, t: f64) -> PlateKinematics {
        self.command.at(t)
    }

    /// Sets the amplitude from time `t` on.
    pub(super) fn set_amplitude(&mut self, t: f64, amplitude: f64) {
        if self.lag.is_some() {
            let now = self.lagging(t);
            if let Some((_, start, nodes)) = &mut self.lag {
                (*start, *nodes) = (t, vec![[now.displacement, now.tilt]]);
            }
        }
        self.command.set("A", amplitude);
    }

    /// The command behind its lag. Between two nodes the command is taken as a parabola, for which the response is known:
    /// `y = p + (y₀ − p₀) exp(−s/τ)`, `p = u − τ u' + τ² u''`.
    fn lagging(&mut self, t: f64) -> PlateKinematics {
        let now = self.command.at(t);
        let Some((time, start, nodes)) = &mut self.lag else {
            return now;
        };
        let (time, start) = (*time, *start);
        let index = ((t - start) / NODE).floor().max(0.0) as usize;
        while nodes.len() <= index {
            let k = nodes.len() - 1;
            nodes.push(respond(&self.command.at(start + NODE * k as f64), &nodes[k], time, NODE));
        }
        let at = start + NODE * index as f64;
        let [displacement, tilt] = respond(&self.command.at(at), &nodes[index], time, t - at);
        let velocity = (now.displacement - displacement) / time;
        let tilt_rate = (now.tilt - tilt) / time;
        PlateKinematics {
            displacement,
            velocity,
            acceleration: (now.velocity - velocity) / time,
            tilt,
            tilt_rate,
            tilt_acceleration: (now.tilt_rate - tilt_rate) / time,
        }
    }
}

/// Displacement and tilt `s` seconds after they were `from`, under the command that was `u` then.
fn respond(u: &PlateKinematics, from: &[f64; 2], time: f64, s: f64) -> [f64; 2] {
    let decay = (-s / time).exp();
    let signal = |value: f64, rate: f64, acceleration: f64, from: f64| {
        let start = value - time * rate + time * time * acceleration;
        let end = start + s * (rate - time * acceleration) + 0.5 * s * s * acceleration;
        end + (from - start) * decay
    };
    [
        signal(u.displacement, u.velocity, u.acceleration, from[0]),
        signal(u.tilt, u.tilt_rate, u.tilt_acceleration, from[1]),
    ]
}

impl PlateMotion for ActuatedMotion {
    fn at(&mut self, t: f64) -> PlateKinematics {
        let plate = self.lagging(t);
        self.effect.inclined(plate, self.gravity)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_lagging_plate_follows_its_command_as_the_differential_equation_says() {
        let command = ExpressionMotion::new("0.05*sin(14*t)", "A*(1 - cos(9*t))", &[("A", 0.2)]).unwrap();
        let mut plate = ActuatedMotion::new(command.clone(), &PlateMismatch::ActuatorLag(0.02), 9.81);
        // Response of y' = (u − y)/τ to sin ωt and 1 − cos ωt from rest.
        let tau = 0.02;
        let sine = |w: f64, t: f64| {
            ((w * t).sin() - w * tau * (w * t).cos() + w * tau * (-t / tau).exp()) / (1.0 + (w * tau).powi(2))
        };
        let cosine = |w: f64, t: f64| {
            let d = 1.0 + (w * tau).powi(2);
            1.0 - (-t / tau).exp() - ((w * t).cos() + w * tau * (w * t).sin() - (-t / tau).exp()) / d
        };
        for t in [0.0, 0.0101, 0.5, 0.3333, 2.0] {
            let k = plate.at(t);
            assert!((k.displacement - 0.05 * sine(14.0, t)).abs() < 1e-8, "{t}");
            assert!((k.tilt - 0.2 * cosine(9.0, t)).abs() < 1e-8, "{t}");
        }
        let h = 1e-4;
        let (before, now, after) = (plate.at(1.0 - h), plate.at(1.0), plate.at(1.0 + h));
        assert!((now.velocity - (after.displacement - before.displacement) / (2.0 * h)).abs() < 1e-4);
        assert!((now.tilt_acceleration - (after.tilt_rate - before.tilt_rate) / (2.0 * h)).abs() < 1e-3);
    }

    #[test]
    fn a_new_amplitude_does_not_make_a_lagging_plate_jump() {
        let command = ExpressionMotion::new("0", "A*t", &[("A", 1.0)]).unwrap();
        let mut plate = ActuatedMotion::new(command, &PlateMismatch::ActuatorLag(0.02), 9.81);
        let before = plate.at(0.5).tilt;
        plate.set_amplitude(0.5, 0.0);
        assert!((plate.at(0.5).tilt - before).abs() < 1e-12);
        assert!((plate.at(0.6).tilt - before * (-5.0f64).exp()).abs() < 1e-9);
    }
}
