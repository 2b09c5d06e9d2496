//! The published equations 3.16 to 3.21 by their mathematics: the torque from friction at every point of the body, and what the
//! inputs would do if they were read as they are printed.

use bracketry_plate::experiment::{AmplitudeStep, Experiment};
use bracketry_plate::motion::ExpressionMotion;
use bracketry_plate::{GRAVITY, Object, PlateMotion, Shape, published};
use bracketry_sim::SimulationSettings;
use std::f64::consts::{FRAC_PI_2, PI};

const START: [f64; 6] = [0.48, -0.03, 0.0, 0.0, 0.0, 0.0];
const MU: f64 = 0.3;

/// Torque per mass of Coulomb friction about the center of mass of a flat body that slides along x without spin, yaw positive from
/// x to y. The pressure at each point is what its acceleration in the inertial frame needs, by differences.
fn torque(shape: &Shape, [y, phi]: [f64; 2], [tilt, rate, acceleration]: [f64; 3], slip: f64) -> f64 {
    let footprint = shape.quadrature(400).unwrap();
    let (sine, cosine) = phi.sin_cos();
    let turned = footprint.points.iter().map(|[a, b]| [cosine * a - sine * b, sine * a + cosine * b]);
    let share = |[rx, ry]: [f64; 2]| {
        let place = |t: f64| {
            let angle = tilt + rate * t + 0.5 * acceleration * t * t;
            [(y + ry) * angle.cos(), (y + ry) * angle.sin()]
        };
        let h = 1e-3;
        let [across, up] = [0, 1].map(|i| (place(h)[i] - 2.0 * place(0.0)[i] + place(-h)[i]) / (h * h));
        let pressure = (up + GRAVITY) * tilt.cos() - across * tilt.sin();
        assert!(pressure > 0.0);
        let (fx, fy) = (-MU * pressure * slip.signum(), 0.0);
        rx * fy - ry * fx
    };
    turned.zip(&footprint.weights).map(|(point, weight)| weight * share(point)).sum()
}

#[test]
fn coulomb_friction_over_a_sliding_body_turns_it_against_the_published_sign() {
    let rectangle = Shape::Rectangle { a: 0.14, b: 0.07 };
    for shape in [Shape::REFERENCE_DISK, Shape::REFERENCE_ELLIPSE, rectangle] {
        for (k, place) in [[0.0, 0.0], [-0.03, 0.4], [0.1, 2.0]].into_iter().enumerate() {
            for plate in [[0.0, 0.0, 20.0], [0.2, -3.0, -15.0], [-0.25, 2.0, 12.0]] {
                for slip in [0.3_f64, -0.1] {
                    let (_, syy, _) = shape.second_moments_at(place[1]);
                    let printed = -slip.signum() * MU * syy * plate[2];
                    let found = torque(&shape, place, plate, slip);
                    assert!((found / printed + 1.0).abs() < 1e-3, "{shape:?} {k} {plate:?} {slip}: {found} {printed}");
                }
            }
        }
    }
}

#[test]
fn the_thickness_adds_little_to_the_moment_of_inertia_about_x() {
    let object = Object::REFERENCE;
    // Layers of the disk at all heights, each with the moments of its area.
    let layers = 1000;
    let heights = (0..layers).map(|k| object.height * (2.0 * (f64::from(k) + 0.5) / f64::from(layers) - 1.0));
    let along_normal = heights.map(|z| z * z).sum::<f64>() / f64::from(layers);
    assert!((along_normal / object.normal_moment() - 1.0).abs() < 1e-5);
    let (_, syy, _) = object.shape.second_moments_at(0.0);
    assert!((along_normal / syy - 5.8e-4).abs() < 1e-5, "{}", along_normal / syy);
}

#[test]
fn with_the_frequency_of_3_18_the_inputs_of_3_20_move_nothing() {
    // cos(2ωt) with ω = 4 rad/s; the period is π/ω.
    let slow = Experiment::translation_x(4).with_frequency(4.0 / PI).with_amplitude_step(AmplitudeStep::Smooth);
    let mut motion = slow.motion(0.0).unwrap();
    motion.set("A", slow.amplitude(0.48 - 0.54));
    let strongest = (0..150_000).map(|k| motion.at(1e-4 * f64::from(k)).acceleration.abs()).fold(0.0, f64::max);
    assert!(strongest > 1.9 && strongest < 1.91, "{strongest}");
    let system = published(&Shape::REFERENCE_DISK, MU).unwrap();
    let run = slow.run(&system, &START, 15.0, &SimulationSettings::default()).unwrap();
    for (end, start) in run.trajectory.final_state().iter().zip(START) {
        assert!((end - start).abs() < 1e-9);
    }
}

#[test]
fn experiment_2_starts_with_a_jump_of_the_velocity() {
    let experiment = Experiment::translation_x(3);
    let amplitude = experiment.amplitude(0.48 - 0.54);
    assert!((amplitude + 0.033).abs() < 1e-12);
    let start = |displacement: &str| {
        let numbers = [("A", amplitude), ("t0", 0.0), ("T", experiment.period)];
        ExpressionMotion::new(displacement, "0", &numbers).unwrap().at(0.0)
    };
    // X'(0) = A (0.51 − 0.5 − 0.1)/τ.
    let printed = start(&experiment.displacement);
    assert_eq!(printed.displacement, 0.0);
    assert!((printed.velocity - 2.97e-3).abs() < 1e-9, "{}", printed.velocity);
    let balanced = start(&experiment.displacement.replace("0.51", "0.6"));
    assert!(balanced.velocity.abs() < 1e-12);
}

/// Once the inputs have swelled: their difference over a period between the amplitudes at e = ±0, the largest and that at its start.
fn jumps(experiment: &Experiment, quantity: fn(&mut ExpressionMotion, f64) -> f64) -> [f64; 2] {
    let law = experiment.law.unwrap();
    let mut motion = experiment.motion(0.0).unwrap();
    let mut jump = |t: f64| {
        let mut at = |amplitude: f64| {
            motion.set("A", amplitude);
            quantity(&mut motion, t)
        };
        (at(law.offset) - at(-law.offset)).abs()
    };
    let start = 30.0 * experiment.period;
    let largest = (0..1000).map(|k| jump(start + experiment.period * f64::from(k) / 1000.0)).fold(0.0, f64::max);
    [largest, jump(start)]
}

#[test]
fn amplitudes_that_follow_the_error_at_once_would_make_the_plate_jump() {
    let [largest, held] = jumps(&Experiment::translation_x(3), |m, t| 1e3 * m.at(t).displacement);
    assert!((largest - 27.3).abs() < 0.1 && (held - 2.7).abs() < 0.01, "{largest} {held}");
    let [largest, held] = jumps(&Experiment::translation_y(), |m, t| m.at(t).tilt.to_degrees());
    assert!((largest - 40.0).abs() < 0.1 && held < 1e-6, "{largest} {held}");
    // X = A p ξ with A = ±0.015 + 0.3 (x − x_d): X'' contains 0.3 p ξ x'', and x'' has the factor 1 + 0.3 p ξ.
    let p = |c: f64| 0.51 - 0.5 * c - 0.1 * (2.0 * c * c - 1.0);
    let least = (0..=200).map(|k| 1.0 + 0.3 * p(0.01 * f64::from(k) - 1.0)).fold(f64::INFINITY, f64::min);
    assert!((least - 0.973).abs() < 1e-9, "{least}");
}

#[test]
fn tilts_in_radians_would_turn_the_plate_over() {
    let experiment = Experiment::orientation();
    let radians = experiment.tilt.replace("*pi/180", "");
    assert_ne!(radians, experiment.tilt);
    let numbers = [("A", 1.0), ("t0", 0.0), ("T", experiment.period)];
    let mut motion = ExpressionMotion::new(&experiment.displacement, &radians, &numbers).unwrap();
    let vertical = (0..1000).map(|k| 1e-3 * f64::from(k)).find(|t| motion.at(*t).tilt.abs() > FRAC_PI_2).unwrap();
    assert!((vertical - 0.112).abs() < 2e-3, "{vertical}");
    let mut degrees = experiment.motion(0.0).unwrap();
    assert!((0..15_000).all(|k| degrees.at(1e-3 * f64::from(k)).tilt.abs() < 0.27));
}
