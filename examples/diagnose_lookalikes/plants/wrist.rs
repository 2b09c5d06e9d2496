//! Joints 5 and 6 of a robot's wrist: the motor of joint 6 sits before joint 5 and turns with `q5 + q6`, so that its
//! inertia and its friction act on both (as on the robots of Gautier and Janot).

use bracketry::diagnose::Cause;
use bracketry::system::System;
use rand::rngs::StdRng;

use super::Drawn;
use super::measure::between;
use super::servo::{Axis, Servo};

pub(super) fn wrist(random: &mut StdRng) -> Drawn {
    let mut about = |value: f64, spread: f64| value * between(random, 1.0 - spread, 1.0 + spread);
    let (j5, j6, motor) = (about(0.04, 0.2), about(0.005, 0.2), about(0.0095, 0.3));
    let (fv5, fv6, fvm) = (about(1.4, 0.2), about(0.5, 0.2), about(0.6, 0.3));
    let (fc5, fc6, fcm) = (about(2.0, 0.2), about(0.4, 0.2), about(1.2, 0.4));
    // [j5 + motor, motor; motor, j6 + motor] times the accelerations is the moment of each joint.
    let determinant = (j5 + motor) * (j6 + motor) - motor * motor;
    let true_model = format!(
        "states = ['q5', 'q6', 'v5', 'v6']\ninputs = ['tau5', 'tau6']\n[definitions]\n\
         m = '{fvm}*(v5 + v6) + {fcm}*sign(v5 + v6)'\n\
         r5 = 'tau5 - {fv5}*v5 - {fc5}*sign(v5) - m'\nr6 = 'tau6 - {fv6}*v6 - {fc6}*sign(v6) - m'\n[dynamics]\n\
         q5 = 'v5'\nq6 = 'v6'\n\
         v5 = '({b}*r5 - {motor}*r6)/{determinant}'\nv6 = '({a}*r6 - {motor}*r5)/{determinant}'\n",
        a = j5 + motor,
        b = j6 + motor,
    );
    let plant = System::parse("wrist_true.toml", &true_model).unwrap();
    let axis = |inertia: f64, step: f64, unlogged: f64| Axis {
        inertia,
        bandwidth: 12.0,
        travel: 1.2,
        durations: [0.35, 0.9],
        step,
        unlogged,
    };
    let axes = [axis(j5 + motor, 2e-5, 0.03), axis(j6 + motor, 3e-5, 0.02)];
    let header = "t,q5,q6,tau5,tau6";
    let mut run = |duration| Servo { plant: &plant, axes: &axes, header, dt: 1e-3, duration, delay: 0.0 }.run(random);
    let (data, validate) = (run(10.0), run(6.0));
    let coupling = vec![Cause::JointCoupling, Cause::InertialCoupling];
    let friction = vec![Cause::FrictionCoupling, Cause::JointCoupling];
    Drawn { data, validate, truth: vec![coupling, friction], true_model }
}
