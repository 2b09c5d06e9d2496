//! A robot measured with noise.

use super::kr125::{STIFFNESS, kr125, pose};
use bracketry_stiffness::{
    Comparison, Deformation, IdentificationError, Kinematics, Measurement, MeasurementNoise, MeasurementSet, Outliers,
    SpringFitSettings, Springs, Wrench, compare, loaded_compliance,
};
use nalgebra::{Matrix6, Vector6};
use rand::RngExt;
use rand::rngs::StdRng;
use rand_distr::{Distribution, StandardNormal};

/// 20 µm, 50 µrad, 2 N, 0.5 N·m.
pub(crate) const NOISE: [f64; 4] = [20e-6, 50e-6, 2.0, 0.5];

pub(crate) fn noise() -> MeasurementNoise {
    MeasurementNoise::from_std(NOISE[0], NOISE[1], NOISE[2], NOISE[3])
}

/// Within ± 1000 N and ± 60 N·m.
pub(crate) fn load(rng: &mut StdRng) -> Wrench {
    Wrench::from_fn(|i, _| [1000.0, 60.0][i / 3] * rng.random_range(-1.0..1.0))
}

/// Within ± 40° of the reference.
pub(crate) fn random_pose(rng: &mut StdRng) -> Vec<f64> {
    pose().iter().map(|q| q + rng.random_range(-0.7..0.7)).collect()
}

pub(crate) fn noisy(rng: &mut StdRng, value: &Vector6<f64>, first: f64, last: f64) -> Vector6<f64> {
    let mut draw = || -> f64 { StandardNormal.sample(rng) };
    Vector6::from_fn(|i, _| value[i] + draw() * if i < 3 { first } else { last })
}

/// The compliance at the pose of the reference.
pub(crate) fn compliance() -> Matrix6<f64> {
    let robot = kr125();
    let kinematics = Kinematics::new(&robot, &pose()).unwrap();
    loaded_compliance(&robot, &Springs::linear(&STIFFNESS), &kinematics, &Wrench::zeros()).unwrap()
}

/// Noisy measurements of a compliance; the displacement of each is exactly `C W`.
pub(crate) fn linear_measurements(rng: &mut StdRng, compliance: &Matrix6<f64>, count: usize) -> Vec<Measurement> {
    (0..count)
        .map(|_| {
            let wrench = load(rng);
            let displacement = noisy(rng, &(compliance * wrench), NOISE[0], NOISE[1]);
            Measurement { q: pose(), wrench: noisy(rng, &wrench, NOISE[2], NOISE[3]), displacement }
        })
        .collect()
}

/// Noisy measurements of a robot in equilibrium at the given poses in turn; `strength` times the usual loads.
pub(crate) fn robot_measurements(
    rng: &mut StdRng,
    springs: &Springs,
    poses: &[Vec<f64>],
    count: usize,
    strength: f64,
) -> Vec<Measurement> {
    let robot = kr125();
    (0..count)
        .map(|n| {
            let q = &poses[n % poses.len()];
            let wrench = strength * load(rng);
            let tool = Deformation::equilibrium(&robot, springs, q, &wrench).unwrap().tool;
            let displacement = noisy(rng, &tool, NOISE[0], NOISE[1]);
            Measurement { q: q.clone(), wrench: noisy(rng, &wrench, NOISE[2], NOISE[3]), displacement }
        })
        .collect()
}

/// Makes every twentieth measurement wrong, in turn in displacement and load.
pub(crate) fn spoil(rng: &mut StdRng, measurements: &mut [Measurement]) -> Vec<usize> {
    let wrong: Vec<usize> = (0..measurements.len()).filter(|n| n % 20 == 7).collect();
    for n in &wrong {
        if n % 40 == 7 {
            measurements[*n].displacement = Vector6::from_fn(|_, _| 5e-3 * rng.random_range(-1.0..1.0));
        } else {
            measurements[*n].wrench = 10.0 * load(rng);
        }
    }
    wrong
}

pub(crate) fn set(measurements: Vec<Measurement>) -> MeasurementSet {
    MeasurementSet::new(measurements, noise()).unwrap()
}

pub(crate) fn relative(found: &Matrix6<f64>, truth: &Matrix6<f64>) -> f64 {
    (found - truth).norm() / truth.norm()
}

/// All methods on measurements of the robot, joint springs from stiffnesses of `start`.
pub(crate) fn compared(
    set: &MeasurementSet,
    start: &Springs,
    outliers: Outliers,
) -> Result<Comparison, IdentificationError> {
    compare(set, Some((&kr125(), start, &SpringFitSettings::default())), outliers)
}
