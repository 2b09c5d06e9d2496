//! Systems that several tests use.
#![allow(clippy::unwrap_used, dead_code, unreachable_pub)]

use bracketry_mpc::{CostFunction, Plant, PlantError, SymbolicDynamics};
use bracketry_symbolic::{Expr, Pool, Symbol};

/// A model written out as text.
pub struct Model {
    pub pool: Pool,
    pub time: Symbol,
    pub states: Vec<Symbol>,
    pub inputs: Vec<Symbol>,
    pub parameters: Vec<(Symbol, f64)>,
    pub field: Vec<Expr>,
}

impl Model {
    pub fn new(states: &[(&str, &str)], inputs: &[&str], parameters: &[(&str, f64)]) -> Self {
        let mut pool = Pool::new();
        let time = pool.symbol("t");
        let symbols = states.iter().map(|s| pool.symbol(s.0)).collect();
        let inputs = inputs.iter().map(|s| pool.symbol(s)).collect();
        let parameters = parameters.iter().map(|(s, v)| (pool.symbol(s), *v)).collect();
        let field = states.iter().map(|s| pool.parse(s.1).unwrap()).collect();
        Self { pool, time, states: symbols, inputs, parameters, field }
    }

    pub fn dynamics(&mut self) -> SymbolicDynamics {
        SymbolicDynamics::compile(
            &mut self.pool,
            self.time,
            &self.states,
            &self.inputs,
            &self.parameters,
            &self.field,
        )
        .unwrap()
    }

    pub fn stage(&mut self, cost: &str) -> CostFunction {
        let e = self.pool.parse(cost).unwrap();
        CostFunction::compile(&mut self.pool, self.time, &self.states, &self.inputs, &[], e).unwrap()
    }

    pub fn terminal(&mut self, cost: &str) -> CostFunction {
        let e = self.pool.parse(cost).unwrap();
        CostFunction::compile(&mut self.pool, self.time, &self.states, &[], &[], e).unwrap()
    }
}

/// Cart with an inverted pendulum, th = 0 up.
pub fn cart_pole() -> Model {
    let d = "(M + m - m*cos(th)^2)";
    let dv = format!("(-m*l*sin(th)*w^2 + m*g*cos(th)*sin(th) + u)/{d}");
    let dw = format!("(-m*l*cos(th)*sin(th)*w^2 + u*cos(th) + (M + m)*g*sin(th))/(l*{d})");
    Model::new(
        &[("p", "v"), ("th", "w"), ("v", &dv), ("w", &dw)],
        &["u"],
        &[("M", 1.0), ("m", 0.1), ("l", 0.8), ("g", 9.81)],
    )
}

/// The published plate model, made affine by two integrators per input; uniform ellipse 0.15 × 0.10 m.
pub fn plate(mu: f64) -> Model {
    let ix = "(sin(phi)^2*Sa + cos(phi)^2*Sb)";
    let dw = format!("-sign(vx)*mu*{ix}*ath/(Sa + Sb)");
    Model::new(
        &[
            ("x", "vx"),
            ("y", "vy"),
            ("phi", "w"),
            ("vx", "-ax - sign(vx)*mu*g"),
            ("vy", "-g*sin(theta) - sign(vy)*mu*(g*cos(theta) + y*ath)"),
            ("w", &dw),
            ("X", "Xd"),
            ("Xd", "ax"),
            ("theta", "thetad"),
            ("thetad", "ath"),
        ],
        &["ax", "ath"],
        &[("mu", mu), ("g", 9.81), ("Sa", 0.15 * 0.15 / 4.0), ("Sb", 0.01 / 4.0)],
    )
}

/// The plate with set-valued friction: sliding with a definite sign, sticking with the equivalent one, small steps that end
/// on every change between them.
pub struct ExactPlate {
    pub mu: f64,
    pub max_step: f64,
}

const G: f64 = 9.81;
const SA: f64 = 0.15 * 0.15 / 4.0;
const SB: f64 = 0.01 / 4.0;

impl ExactPlate {
    fn signs(&self, z: &[f64], u: &[f64]) -> [f64; 2] {
        let select = |v: f64, drive: f64, load: f64| {
            if v != 0.0 {
                v.signum()
            } else if load > 0.0 {
                (-drive / load).clamp(-1.0, 1.0)
            } else {
                0.0
            }
        };
        let load = self.mu * (G * z[8].cos() + z[1] * u[1]);
        [select(z[3], u[0], self.mu * G), select(z[4], G * z[8].sin(), load)]
    }

    fn field(&self, z: &[f64], u: &[f64], s: [f64; 2]) -> [f64; 10] {
        let ix = z[2].sin().powi(2) * SA + z[2].cos().powi(2) * SB;
        let mut dvx = -u[0] - s[0] * self.mu * G;
        let mut dvy = -G * z[8].sin() - s[1] * self.mu * (G * z[8].cos() + z[1] * u[1]);
        if z[3] == 0.0 && s[0].abs() < 1.0 {
            dvx = 0.0;
        }
        if z[4] == 0.0 && s[1].abs() < 1.0 {
            dvy = 0.0;
        }
        [z[3], z[4], z[5], dvx, dvy, -s[0] * self.mu * ix * u[1] / (SA + SB), z[7], u[0], z[9], u[1]]
    }
}

impl Plant for ExactPlate {
    fn step(&mut self, _t: f64, z: &mut [f64], u: &[f64], dt: f64) -> Result<(), PlantError> {
        let mut t = 0.0;
        while t < dt - 1e-12 {
            let mut h = self.max_step.min(dt - t);
            let s = self.signs(z, u);
            let k1 = self.field(z, u, s);
            let move_by = |h: f64| {
                let middle: Vec<f64> = z.iter().zip(&k1).map(|(z, k)| z + 0.5 * h * k).collect();
                let mut held = s;
                for (i, v) in [(0, 3), (1, 4)] {
                    if z[v] == 0.0 && k1[v] == 0.0 {
                        held[i] = self.signs(&middle, u)[i];
                    }
                }
                let k2 = self.field(&middle, u, held);
                z.iter().zip(&k2).map(|(z, k)| z + h * k).collect::<Vec<f64>>()
            };
            let mut end = move_by(h);
            for v in [3, 4] {
                if z[v] * end[v] < 0.0 {
                    h = h.min(h * z[v] / (z[v] - end[v]));
                }
            }
            end = move_by(h);
            for v in [3, 4] {
                if z[v] != 0.0 && (end[v].abs() < 1e-7 && z[v].abs() > end[v].abs() || z[v] * end[v] < 0.0) {
                    end[v] = 0.0;
                }
            }
            z.copy_from_slice(&end);
            t += h.max(1e-12);
        }
        Ok(())
    }
}
