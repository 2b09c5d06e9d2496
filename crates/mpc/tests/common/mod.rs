//! Systems that several tests use.
#![allow(clippy::unwrap_used, dead_code, unreachable_pub)]

use bracketry_mpc::{Plant, PlantError};
use bracketry_system::System;

/// Cart with an inverted pendulum, th = 0 up.
pub fn cart_pole() -> System {
    let text = r#"
        states = ["p", "th", "v", "w"]
        inputs = ["u"]
        [parameters]
        M = 1
        m = 0.1
        l = 0.8
        g = 9.81
        [definitions]
        d = "M + m - m*cos(th)^2"
        [dynamics]
        p = "v"
        th = "w"
        v = "(-m*l*sin(th)*w^2 + m*g*cos(th)*sin(th) + u)/d"
        w = "(-m*l*cos(th)*sin(th)*w^2 + u*cos(th) + (M + m)*g*sin(th))/(l*d)"
    "#;
    System::parse("cart_pole.toml", text).unwrap()
}

/// The published plate model, made affine by two integrators per input; uniform ellipse 0.15 × 0.10 m.
pub fn plate(mu: f64) -> System {
    let text = format!(
        r#"
        states = ["x", "y", "phi", "vx", "vy", "w", "X", "Xd", "theta", "thetad"]
        inputs = ["ax", "ath"]
        [parameters]
        mu = {mu}
        g = 9.81
        Sa = 0.005625
        Sb = 0.0025
        [dynamics]
        x = "vx"
        y = "vy"
        phi = "w"
        vx = "-ax - sign(vx)*mu*g"
        vy = "-g*sin(theta) - sign(vy)*mu*(g*cos(theta) + y*ath)"
        w = "-sign(vx)*mu*(sin(phi)^2*Sa + cos(phi)^2*Sb)*ath/(Sa + Sb)"
        X = "Xd"
        Xd = "ax"
        theta = "thetad"
        thetad = "ath"
        "#
    );
    System::parse("plate.toml", &text).unwrap()
}

/// A system with set-valued friction.
pub struct ExactPlant(pub bracketry_sim::Plant);

impl ExactPlant {
    pub fn new(system: &System, x0: &[f64]) -> Self {
        Self(bracketry_sim::Plant::new(system, x0, &bracketry_sim::Settings::default()).unwrap())
    }
}

impl Plant for ExactPlant {
    fn step(&mut self, _t: f64, x: &mut [f64], u: &[f64], dt: f64) -> Result<(), PlantError> {
        if self.0.state() != x {
            self.0.set_state(x)?;
        }
        let outcome = self.0.step(u, dt)?;
        assert!(outcome.is_finished(), "{outcome:?}");
        x.copy_from_slice(self.0.state());
        Ok(())
    }
}
