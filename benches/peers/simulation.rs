//! The plate's experiments, timed; see `simulation.py` for the others.

use bracketry::plate::area::{AreaContact, AreaSettings};
use bracketry::plate::experiment::Experiment;
use bracketry::plate::model::Terms;
use bracketry::plate::{Friction, Object, Shape, published, reduced};
use bracketry::sim::{Inputs, Model, SimulationSettings, Stepper};
use bracketry::system::System;
use serde_json::{Value, json};

use crate::median;

/// Seconds of experiment 1.
const DURATION: f64 = 15.0;
/// The tolerances whose work and error are told: 10 to the minus half of these.
const HALF_DIGITS: std::ops::RangeInclusive<i32> = 6..=24;
/// `x, y, phi, vx, vy, w` at the start.
const START: [f64; 6] = [0.3, 0.0, 0.0, 0.0, 0.0, 0.0];
const RUNS: usize = 21;

/// The disk of MuJoCo's scene.
fn disk() -> Object {
    Object { shape: Shape::REFERENCE_DISK, height: 0.0025, mass: 0.2, ..Object::REFERENCE }
}

/// Experiment 1 on a model: work and states every half second at each tolerance.
fn by_events(system: &System) -> Value {
    let inputs = Experiment::orientation().inputs(0.0);
    let (compile, model) = median(RUNS, || Model::new(system, &inputs).expect("inputs that fit"));
    let runs: Vec<Value> = HALF_DIGITS
        .map(|half_digits| {
            let rtol = 10f64.powf(-0.5 * f64::from(half_digits));
            let settings = SimulationSettings::default().with_tolerance(rtol, 1e-2 * rtol);
            let (seconds, (states, statistics)) = median(RUNS, || {
                let mut stepper = Stepper::new(model.clone(), 0.0, &START, &settings).expect("a start");
                let (trajectory, outcome) = stepper.record(DURATION).expect("a time span");
                assert!(outcome.is_finished(), "{outcome:?}");
                let states: Vec<_> = (0..=30).map(|i| trajectory.sample(0.5 * f64::from(i))[..3].to_vec()).collect();
                (states, stepper.statistics())
            });
            json!({"rtol": rtol, "seconds": seconds, "states": states, "steps": statistics.steps,
                   "events": statistics.events, "rhs": statistics.rhs})
        })
        .collect();
    json!({"compile": compile, "runs": runs})
}

/// Experiment 1 with contact over the whole footprint.
fn area_contact() -> Value {
    let settings = AreaSettings::default();
    let start = AreaContact::new(&disk(), &Friction::Coulomb { mu: 0.3 }, &settings).expect("an object");
    let motion = Experiment::orientation().motion(0.0).expect("a motion");
    let (seconds, yaw) = median(RUNS, || {
        let (mut area, mut motion) = (start.clone(), motion.clone());
        area.set_state(START).expect("a state");
        assert!(area.advance(&mut motion, DURATION).expect("a time span").is_finished());
        area.state()[2]
    });
    json!({"seconds": seconds, "points": settings.points, "step": settings.step, "yaw": yaw.to_degrees()})
}

/// How far an object at rest on a plate tilted by 10° moves in 60 s, in meters.
fn creep() -> f64 {
    let system = published(&Shape::REFERENCE_DISK, 0.3).expect("a model");
    let inputs = Inputs::new().expression("X", "0").expression("theta", "10*pi/180");
    let model = Model::new(&system, &inputs).expect("inputs that fit");
    let mut stepper = Stepper::new(model, 0.0, &[0.0; 6], &SimulationSettings::default()).expect("a start");
    assert!(stepper.advance(60.0).is_finished());
    stepper.state()[0].hypot(stepper.state()[1])
}

/// Everything that is measured of the simulator.
pub(crate) fn report() -> Value {
    let published = published(&Shape::REFERENCE_ELLIPSE, 0.3).expect("a model");
    let reduced = reduced(&disk(), 0.3, Terms::default()).expect("a model");
    json!({"published": by_events(&published), "reduced": by_events(&reduced), "area": area_contact(), "creep": creep()})
}
