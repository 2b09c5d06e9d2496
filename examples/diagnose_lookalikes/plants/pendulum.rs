//! Pendulums whose friction has two terms.

use std::f64::consts::TAU;

use bracketry::diagnose::Cause;
use bracketry::sim::{ExactPlant, SimulationSettings};
use bracketry::system::System;
use rand::RngExt;
use rand::rngs::StdRng;

use super::Drawn;
use super::measure::{Colored, Encoder, Table, between};

/// Two terms of friction of comparable size at a speed: of the deceleration and its names.
fn friction(size: f64, speed: f64, random: &mut StdRng) -> (String, Vec<Vec<Cause>>) {
    let viscous = size / speed * between(random, 0.6, 1.4);
    let dry = size * between(random, 0.4, 1.0);
    let drag = size / (speed * speed) * between(random, 0.6, 1.4);
    let terms = [
        (format!("{viscous}*w"), Cause::ViscousFriction),
        (format!("{dry}*sign(w)"), Cause::CoulombFriction),
        (format!("{drag}*w*abs(w)"), Cause::QuadraticDrag),
    ];
    // Viscous and dry most often: the textbook's pair.
    let (a, b) = [(0, 1), (0, 1), (1, 2)][random.random_range(0..3)];
    (format!("{} + {}", terms[a].0, terms[b].0), vec![vec![terms[a].1], vec![terms[b].1]])
}

/// Let go from two heights; an encoder of 4096 steps, 200 Hz.
pub(super) fn free(random: &mut StdRng) -> Drawn {
    let length = 0.5 * between(random, 0.95, 1.05);
    let (friction, truth) = friction(9.81 / length * between(random, 0.01, 0.03), 5.0, random);
    let true_model = format!(
        "states = ['th', 'w']\ninputs = ['draught']\n[dynamics]\nth = 'w'\nw = '-9.81/{length}*sin(th) - ({friction}) + draught'\n"
    );
    let plant = System::parse("pendulum.toml", &true_model).unwrap();
    let mut run = |duration: f64| {
        let dt = 5e-3;
        let x0 = [between(random, 1.0, 2.2), 0.0];
        let mut plant = ExactPlant::new(&plant, &x0, &SimulationSettings::default()).unwrap();
        let (mut encoder, mut draught) = (Encoder::new(TAU / 4096.0, dt), Colored::new(0.01, 5.0, dt));
        let mut table = Table::new("t,th");
        for k in 0..(duration / dt) as usize {
            table.row(&[k as f64 * dt, encoder.read(plant.state()[0], random)]);
            assert!(plant.hold(&[draught.next(random)], dt).unwrap().is_finished());
        }
        table.text()
    };
    Drawn { data: run(20.0), validate: run(12.0), truth, true_model }
}

/// Driven by a sum of sines through several turns of the encoder of 8192 steps, 500 Hz.
pub(super) fn driven(random: &mut StdRng) -> Drawn {
    let inertia = 0.06 * between(random, 0.9, 1.1);
    let weight = 1.5 * between(random, 0.9, 1.1);
    let (friction, truth) = friction(between(random, 0.05, 0.15), 3.0, random);
    let true_model = format!(
        "states = ['th', 'w']\ninputs = ['tau']\n[dynamics]\nth = 'w'\nw = '(tau - {weight}*sin(th) - ({friction}))/{inertia}'\n"
    );
    let plant = System::parse("pendulum.toml", &true_model).unwrap();
    let mut run = |duration: f64| {
        let dt = 2e-3;
        let sines: Vec<[f64; 3]> = (0..6)
            .map(|_| [between(random, 0.15, 0.45), between(random, 0.15, 1.6), between(random, 0.0, TAU)])
            .collect();
        let mut plant = ExactPlant::new(&plant, &[0.0, 0.0], &SimulationSettings::default()).unwrap();
        let (mut encoder, mut unlogged) = (Encoder::new(TAU / 8192.0, dt), Colored::new(0.005, 50.0, dt));
        let mut table = Table::new("t,th,tau");
        for k in 0..(duration / dt) as usize {
            let t = k as f64 * dt;
            let tau: f64 = sines.iter().map(|[a, f, phase]| a * (TAU * f * t + phase).sin()).sum();
            table.row(&[t, encoder.read(plant.state()[0], random), tau]);
            assert!(plant.hold(&[tau + unlogged.next(random)], dt).unwrap().is_finished());
        }
        table.text()
    };
    Drawn { data: run(16.0), validate: run(8.0), truth, true_model }
}
