//! Experiment 1 of the plate by events, and steps of area contact, against the same equations written by hand.
//!
//! The items of the first two groups are accepted steps, those of the last are contact steps.

mod by_hand;

use bracketry_sim::{FrictionPoints, FrictionSolver, Inputs, Model, SimulationSettings, Stepper};
use bracketry_system::System;
use divan::counter::ItemsCount;
use divan::{Bencher, black_box};

/// Seconds of experiment 1.
const DURATION: f64 = 15.0;
const START: [f64; 6] = [0.3, 0.0, 0.0, 0.0, 0.0, 0.0];

/// Friction that is coupled over both directions, at the center of mass.
const COUPLED: &str = r#"
    states = ["x", "y", "vx", "vy"]
    inputs = ["X", "theta"]
    parameters = { mu = 0.3, g = 9.81 }
    [definitions]
    N = "g*cos(theta) + y*der(theta,2) + 2*vy*der(theta,1)"
    [dynamics]
    x = "vx"
    y = "vy"
    vx = "-der(X,2) - mu*N*vx/sqrt(vx^2 + vy^2)"
    vy = "-g*sin(theta) + y*der(theta,1)^2 - mu*N*vy/sqrt(vx^2 + vy^2)"
"#;

fn main() {
    divan::main();
}

fn experiment_1(text: &str) -> Model {
    let system = System::parse("plate.toml", text).expect("a model");
    let inputs = Inputs::new()
        .expression("X", "0.025*sin(4*pi*t)*(1 - exp(-t))")
        .expression("theta", "-15*pi/180*sin(4*pi*t)*(1 - exp(-t))");
    Model::new(&system, &inputs).expect("inputs that fit")
}

fn run(bencher: Bencher, model: &Model, start: &[f64], digits: i32) {
    let rtol = 10f64.powi(-digits);
    let settings = SimulationSettings::default().with_tolerance(rtol, 1e-2 * rtol);
    let whole = || {
        let mut stepper = Stepper::new(model.clone(), 0.0, start, &settings).expect("a start");
        assert!(stepper.advance(DURATION).is_finished());
        stepper
    };
    let steps = whole().statistics().steps;
    bencher.counter(ItemsCount::new(steps)).bench_local(|| black_box(whole().state()[0]));
}

/// Friction of each axis by itself: sticks, breaks loose and slides in x and y.
#[divan::bench(args = [6, 9])]
fn scalar_friction(bencher: Bencher, digits: i32) {
    run(bencher, &experiment_1(include_str!("../../../models/plate_published.toml")), &START, digits);
}

/// Friction as one unit vector.
#[divan::bench(args = [6, 9])]
fn coupled_friction(bencher: Bencher, digits: i32) {
    run(bencher, &experiment_1(COUPLED), &[0.3, 0.0, 0.0, 0.0], digits);
}

/// The published equations in the same method with steps of one length and no events: what the stages alone cost.
#[divan::bench(args = [435, 1621])]
fn scalar_friction_by_hand_without_events(bencher: Bencher, steps: usize) {
    bencher.counter(ItemsCount::new(steps)).bench_local(|| by_hand::published(black_box(START), DURATION, steps));
}

/// Centers of 48 cells of equal area of a disk, with their weight, in a step of 1 ms: `μ g dt / 48`.
fn footprint() -> FrictionPoints<3> {
    let mut points = FrictionPoints::new();
    for [x, y] in by_hand::cells() {
        points.push([[1.0, 0.0, -y], [0.0, 1.0, x]], by_hand::BOUND);
    }
    points
}

/// A disk that slides and turns, turns on the spot, or rests: one step of 48 points.
#[divan::bench(args = ["slides", "turns", "rests"])]
fn contact(bencher: Bencher, way: &str) {
    let (mut solver, points) = (FrictionSolver::new(), footprint());
    let free = by_hand::free_velocity(way);
    let mass = by_hand::mass();
    let guess = solver.step(&mass, &free, &points, &free).expect("a step").velocity;
    bencher.counter(ItemsCount::new(1usize)).bench_local(|| {
        solver.step(black_box(&mass), black_box(&free), &points, black_box(&guess)).expect("a step").velocity
    });
}

/// The same by four Newton steps of the smoothed problem, from the solution: no test of convergence, no rest.
#[divan::bench(args = ["slides", "turns", "rests"])]
fn contact_by_hand_smoothed(bencher: Bencher, way: &str) {
    let cells = by_hand::cells();
    let free = by_hand::free_velocity(way);
    let guess = by_hand::contact(&cells, free, free, 40);
    bencher
        .counter(ItemsCount::new(1usize))
        .bench_local(|| by_hand::contact(black_box(&cells), black_box(free), black_box(guess), 4));
}
