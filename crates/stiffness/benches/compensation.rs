//! What one step of the compensation costs: `cargo bench -p bracketry-stiffness --bench compensation`.

#[path = "../tests/main/common/kr125.rs"]
mod table;

use bracketry_stiffness::{CompensationSettings, Compensator, ForceSensor, JointSpring, Payload, Springs, Wrench};
use divan::{Bencher, black_box};
use nalgebra::{Isometry3, Matrix6, Vector3};
use table::kr125;

const Q: [f64; 6] = [0.35, -0.44, 0.7, 0.52, 0.79, 0.17];

fn main() {
    divan::main();
}

fn compensator(springs: Springs) -> Compensator {
    let robot = kr125().with_tool(Isometry3::translation(0.0, 0.0, 0.3));
    let sensor =
        ForceSensor { pose: Isometry3::translation(0.0, 0.0, -0.25), force_range: 2000.0, moment_range: 500.0 };
    let payload = Payload {
        mass: 12.0,
        center: Vector3::new(0.01, -0.02, 0.1),
        bias: Wrench::new(5.0, -8.0, 12.0, 0.5, 0.2, 0.1),
    };
    Compensator::new(robot, springs, sensor, payload, CompensationSettings::default()).expect("a compensator")
}

fn run(bencher: Bencher, springs: Springs) {
    let mut compensator = compensator(springs);
    let reading = Wrench::new(200.0, -100.0, 300.0, 10.0, 20.0, -5.0);
    bencher.bench_local(move || {
        black_box(compensator.step(black_box(&Q), black_box(&reading), black_box(&Q)).reference[0])
    });
}

const STIFFNESS: [f64; 6] = [1_409_800.0, 400_760.0, 935_280.0, 360_000.0, 370_000.0, 380_000.0];

#[divan::bench]
fn linear_joints(bencher: Bencher) {
    run(bencher, Springs::linear(&STIFFNESS));
}

#[divan::bench]
fn nonlinear_joints(bencher: Bencher) {
    let stiffening = STIFFNESS.map(|stiffness| JointSpring::Stiffening { stiffness, cubic: 1e10 });
    run(bencher, Springs::of_joints(stiffening.to_vec()));
}

#[divan::bench]
fn linear_joints_and_links(bencher: Bencher) {
    run(bencher, Springs::linear(&STIFFNESS).with_links(vec![Matrix6::identity() * 1e-7; 6]));
}
