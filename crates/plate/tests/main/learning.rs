//! What the pose controller learns of an object, a camera, and a servo that are not as it believes.

use bracketry_plate::area::{AreaContact, AreaSettings};
use bracketry_plate::control::{
    Command, Estimate, Learned, Measurement, PlateController, PoseController, PoseSettings, PoseStatus,
};
use bracketry_plate::object::Bearing;
use bracketry_plate::{Friction, Object, PlateKinematics, Shape};

const BELIEVED: Object = Object { shape: Shape::REFERENCE_ELLIPSE, ..Object::REFERENCE };
const TARGET: [f64; 3] = [0.05, -0.02, 0.9];
const PERIOD: f64 = 0.02;
const PIECE: f64 = 2e-3;

/// A plant that differs from the assumed one.
struct Plant {
    object: Object,
    mu: f64,
    /// Age of the measured poses in s.
    latency: f64,
    /// Time constant of the plate's servo in s.
    lag: f64,
}

const AS_BELIEVED: Plant = Plant { object: BELIEVED, mu: 0.3, latency: 0.0, lag: 0.0 };

/// The plant under the controller, for three seconds at most: what is learned, and the pose at the end.
fn moved(plant: &Plant) -> (Learned, [f64; 3]) {
    let settings = PoseSettings { delay: 0, ..PoseSettings::default() };
    let mut controller = PoseController::new(&BELIEVED, TARGET, &settings).unwrap();
    let law = Friction::Coulomb { mu: plant.mu };
    let area = AreaSettings::default().with_step(PIECE).with_points(24);
    let mut contact = AreaContact::new(&plant.object, &law, &area).unwrap();
    let (mut plate, mut acceleration, mut past) = (PlateKinematics::default(), [0.0; 2], vec![[0.0; 3]]);
    for sample in 0..400 {
        let late = past.len() - 1 - ((plant.latency / PIECE).round() as usize).min(past.len() - 1);
        // Errors of the size of the noise.
        let wave = |shift: f64| (2.4 * f64::from(sample) + shift).sin() * 2f64.sqrt();
        let [position, yaw] = settings.noise;
        let noise = [position * wave(0.0), position * wave(1.0), yaw * wave(2.0)];
        let object = std::array::from_fn(|i| past[late][i] + noise[i]);
        let command = controller.command(&Measurement { object, plate }).unwrap();
        if controller.finished() {
            break;
        }
        let goal = [command.displacement_acceleration, command.tilt_acceleration];
        for _ in 0..(PERIOD / PIECE).round() as usize {
            // The mean over a piece of what a servo of first order makes of the command.
            let left = if plant.lag > 0.0 { (-PIECE / plant.lag).exp() } else { 0.0 };
            let mean = [0, 1].map(|i| goal[i] + (acceleration[i] - goal[i]) * (1.0 - left) * plant.lag / PIECE);
            acceleration = [0, 1].map(|i| goal[i] + (acceleration[i] - goal[i]) * left);
            let acting = Command { displacement_acceleration: mean[0], tilt_acceleration: mean[1] };
            let (from, before) = (contact.time(), acting.applied_to(&plate));
            assert!(contact.advance(&mut |t| before.after(t - from), from + PIECE).unwrap().is_finished());
            plate = before.after(PIECE);
            let [x, y, phi, ..] = contact.state();
            past.push([x, y, phi]);
        }
    }
    assert_eq!(controller.report().status, PoseStatus::Arrived);
    let [x, y, phi, ..] = contact.state();
    (controller.report().learned, [x, y, phi])
}

fn assert_learned(what: &str, learned: Estimate, truth: f64, within: f64) {
    let Estimate { value, deviation } = learned;
    assert!((value - truth).abs() < within, "{what}: {value} ± {deviation} instead of {truth}");
    assert!(deviation > 0.0 && (value - truth).abs() < 5.0 * deviation + 0.2 * within, "{what}: {value} ± {deviation}");
}

fn assert_arrived(pose: [f64; 3]) {
    assert!((pose[0] - TARGET[0]).abs() < 2e-3 && (pose[1] - TARGET[1]).abs() < 2e-3, "{pose:?}");
    assert!((pose[2] - TARGET[2]).abs() < 2f64.to_radians(), "{pose:?}");
}

#[test]
fn one_move_shows_friction_and_how_far_out_the_pressure_stands() {
    let object = Object { bearing: Bearing::Scaled(0.5), ..BELIEVED };
    let (learned, end) = moved(&Plant { object, mu: 0.2, ..AS_BELIEVED });
    assert_arrived(end);
    assert_learned("friction", learned.mu, 0.2, 0.015);
    assert_learned("scale", learned.scale, 0.5, 0.12);
}

#[test]
fn one_move_shows_the_latency_of_the_camera_and_the_lag_of_the_servo() {
    let (learned, end) = moved(&Plant { latency: 0.02, lag: 0.006, ..AS_BELIEVED });
    assert_arrived(end);
    assert_learned("latency", learned.latency, 0.02, 4e-3);
    assert!((learned.servo_lag.value - 0.006).abs() < 1.5e-3, "{:?}", learned.servo_lag);
}

#[test]
fn one_move_shows_on_which_side_the_mass_is() {
    let object = Object { center_of_mass: [0.0, 8e-3], ..BELIEVED };
    let (learned, end) = moved(&Plant { object, ..AS_BELIEVED });
    assert_arrived(end);
    assert_learned("center of mass along y", learned.center_of_mass[1], 8e-3, 5e-3);
    assert_learned("scale", learned.scale, 1.0, 0.2);
}
