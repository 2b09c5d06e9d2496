//! Where a system is affine in its signs, those that stick are solved for in one evaluation; the motion is the same as by
//! iteration.

use bracketry_sim::{Inputs, Model, Simulation, SimulationSettings, Switched, simulate};
use bracketry_system::System;

/// A model that does not tell that it is affine.
struct Iterated(Model);

impl Switched for Iterated {
    fn dim(&self) -> usize {
        self.0.dim()
    }

    fn switches(&self) -> usize {
        self.0.switches()
    }

    fn components(&self, switch: usize) -> usize {
        self.0.components(switch)
    }

    fn sticks(&self, switch: usize) -> bool {
        self.0.sticks(switch)
    }

    fn rhs(&mut self, t: f64, x: &[f64], s: &[f64], dx: &mut [f64]) {
        self.0.rhs(t, x, s, dx);
    }

    fn switching(&mut self, t: f64, x: &[f64], sigma: &mut [f64]) {
        self.0.switching(t, x, sigma);
    }

    fn switching_gradient(&mut self, t: f64, x: &[f64], gradient: &mut [f64], partial_t: &mut [f64]) {
        self.0.switching_gradient(t, x, gradient, partial_t);
    }

    fn enter_segment(&mut self, t: f64) -> f64 {
        self.0.enter_segment(t)
    }
}

fn both_ways(text: &str, inputs: &Inputs, x0: &[f64], t_end: f64) -> [Simulation; 2] {
    let system = System::parse("model.toml", text).unwrap();
    let model = Model::new(&system, inputs).unwrap();
    let settings = SimulationSettings::default();
    [
        simulate(model.clone(), 0.0, x0, t_end, &settings).unwrap(),
        simulate(Iterated(model), 0.0, x0, t_end, &settings).unwrap(),
    ]
}

fn assert_same_motion([at_once, iterated]: &[Simulation; 2]) {
    assert!(at_once.outcome.is_finished() && iterated.outcome.is_finished());
    let (a, b) = (at_once.trajectory.mode_changes(), iterated.trajectory.mode_changes());
    assert!(!a.is_empty());
    assert_eq!(a.len(), b.len());
    for (a, b) in a.iter().zip(b) {
        assert_eq!((a.switch, a.from, a.to), (b.switch, b.from, b.to));
        assert!((a.t - b.t).abs() < 1e-9, "{} and {}", a.t, b.t);
    }
    for (p, q) in at_once.trajectory.final_state().iter().zip(iterated.trajectory.final_state()) {
        assert!((p - q).abs() < 1e-9, "{p} and {q}");
    }
}

#[test]
fn two_blocks_that_stick_to_each_other_and_to_the_ground() {
    let text = r#"
        states = ["x", "v", "u"]
        inputs = ["f"]
        [dynamics]
        x = "v"
        v = "-3*sign(v) - 2*sign(v - u)"
        u = "f + 2*sign(v - u)"
    "#;
    let runs = both_ways(text, &Inputs::new().expression("f", "6*sin(3*t)"), &[0.0, 0.5, -0.2], 10.0);
    assert_same_motion(&runs);
    assert!(runs[0].statistics.rhs < runs[1].statistics.rhs, "fewer evaluations");
}

#[test]
fn friction_on_a_plane() {
    let text = r#"
        states = ["vx", "vy"]
        inputs = ["f", "g"]
        [dynamics]
        vx = "f - 2*vx/sqrt(vx^2 + vy^2)"
        vy = "g - 2*vy/sqrt(vx^2 + vy^2)"
    "#;
    let inputs = Inputs::new().expression("f", "3*sin(2*t)").expression("g", "cos(3*t)");
    assert_same_motion(&both_ways(text, &inputs, &[0.0, 0.0], 10.0));
}

#[test]
fn redundant_signs_share_their_force() {
    // Both signs stand for the same velocity: only their sum is determined.
    let text = r#"
        states = ["v"]
        inputs = ["f"]
        dynamics = { v = "f - sign(v) - sign(2*v)" }
    "#;
    let runs = both_ways(text, &Inputs::new().expression("f", "3*sin(2*t)"), &[0.0], 6.0);
    assert_same_motion(&runs);
}

#[test]
fn friction_that_is_not_affine_in_its_sign() {
    let text = r#"
        states = ["v"]
        inputs = ["f"]
        dynamics = { v = "f - 2*sign(v) - sign(v)^3/2" }
    "#;
    let runs = both_ways(text, &Inputs::new().expression("f", "3*sin(2*t)"), &[0.0], 6.0);
    assert_same_motion(&runs);
    assert_eq!(runs[0].statistics.rhs, runs[1].statistics.rhs, "both are iterated");
}
