//! A carriage on a rack: a force that repeats with each turn of the pinion, and one effect more.

use bracketry::diagnose::Cause;
use bracketry::system::System;
use rand::RngExt;
use rand::rngs::StdRng;

use super::Drawn;
use super::measure::{between, sign};
use super::servo::{Axis, Servo};

pub(super) fn rack(random: &mut StdRng) -> Drawn {
    let mut about = |value: f64, spread: f64| value * between(random, 1.0 - spread, 1.0 + spread);
    let (mass, viscous, dry) = (about(12.0, 0.15), about(40.0, 0.2), about(15.0, 0.15));
    let (amplitude, turn) = (about(5.0, 0.4), about(0.08, 0.4));
    let phase = between(random, 0.0, 6.0);
    let second = random.random_range(0..3);
    let (mut extra, mut delay) = (String::new(), 0.0);
    let mut truth = vec![vec![Cause::PeriodicDisturbance]];
    match second {
        0 => {
            let (a, b) = (sign(random) * between(random, 1.5, 4.0), sign(random) * between(random, 6.0, 14.0));
            // Dry friction of dry ± a: the set-valued sign makes a constant of it, at rest too.
            extra = format!(" - ({a}) - ({b})*abs(v)");
            truth.push(vec![Cause::FrictionAsymmetry]);
        }
        1 => {
            delay = between(random, 0.002, 0.006);
            truth.push(vec![Cause::InputDelay]);
        }
        _ => {
            let (rise, width) = (between(random, 6.0, 12.0), between(random, 0.02, 0.06));
            extra = format!(" - {rise}*exp(-(v/{width})^2)*sign(v)");
            truth.push(vec![Cause::StribeckFriction]);
        }
    }
    let true_model = format!(
        "states = ['x', 'v']\ninputs = ['force']\n[dynamics]\nx = 'v'\n\
         v = '(force - {viscous}*v - {dry}*sign(v) - {amplitude}*sin(2*pi*x/{turn} + {phase}){extra})/{mass}'\n"
    );
    let plant = System::parse("rack_true.toml", &true_model).unwrap();
    let axes = [Axis { inertia: mass, bandwidth: 5.0, travel: 0.3, durations: [0.5, 1.4], step: 5e-6, unlogged: 0.4 }];
    let header = "t,x,force";
    let mut run = |duration| Servo { plant: &plant, axes: &axes, header, dt: 1e-3, duration, delay }.run(random);
    Drawn { data: run(12.0), validate: run(6.0), truth, true_model }
}
