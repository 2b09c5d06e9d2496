//! The pose controller on the object with exact friction over its footprint.

use bracketry_plate::area::{AreaContact, AreaSettings};
use bracketry_plate::control::{
    Command, Measurement, PlateController, PlateLimits, PoseController, PoseSettings, PoseStatus,
};
use bracketry_plate::{Friction, Object, PlateKinematics, Shape};

const ELLIPSE: Object = Object { shape: Shape::Ellipse { a: 0.15, b: 0.10 }, ..Object::REFERENCE };

/// The plate after `time` seconds under a command.
fn moved(plate: &PlateKinematics, command: Command, time: f64) -> PlateKinematics {
    let (a, b) = (command.displacement_acceleration, command.tilt_acceleration);
    PlateKinematics {
        displacement: plate.displacement + time * (plate.velocity + 0.5 * time * a),
        velocity: plate.velocity + time * a,
        acceleration: a,
        tilt: plate.tilt + time * (plate.tilt_rate + 0.5 * time * b),
        tilt_rate: plate.tilt_rate + time * b,
        tilt_acceleration: b,
    }
}

/// What a trial showed.
struct Trial {
    commands: Vec<Command>,
    plates: Vec<PlateKinematics>,
    end: [f64; 6],
    seconds: f64,
    finished: bool,
}

/// Runs a controller on the exact plant for at most `seconds`; `see` turns the true pose into a measurement.
fn run(
    controller: &mut PoseController,
    delay: usize,
    mu: f64,
    start: [f64; 3],
    seconds: f64,
    mut see: impl FnMut(usize, [f64; 3]) -> [f64; 3],
) -> Trial {
    let mut plant = AreaContact::new(&ELLIPSE, &Friction::Coulomb { mu }, &AreaSettings::default()).unwrap();
    plant.set_state([start[0], start[1], start[2], 0.0, 0.0, 0.0]).unwrap();
    let period = controller.period();
    let mut plate = PlateKinematics::default();
    let mut queue = vec![Command::default(); delay];
    let mut trial =
        Trial { commands: Vec::new(), plates: Vec::new(), end: plant.state(), seconds: 0.0, finished: false };
    while trial.seconds < seconds && !trial.finished {
        let [x, y, phi, ..] = plant.state();
        let object = see(trial.commands.len(), [x, y, phi]);
        queue.push(controller.command(&Measurement { object, plate }).unwrap());
        let command = queue.remove(0);
        let (from, before) = (plant.time(), plate);
        let mut motion = |t: f64| moved(&before, command, t - from);
        let outcome = plant.advance(&mut motion, from + period).unwrap();
        assert!(outcome.is_finished(), "{outcome}");
        plate = moved(&before, command, period);
        trial.commands.push(command);
        trial.plates.push(plate);
        trial.seconds += period;
        trial.finished = controller.finished();
    }
    trial.end = plant.state();
    trial
}

fn exact() -> PoseSettings {
    PoseSettings {
        delay: 0,
        mu_deviation: 0.0,
        noise: [0.0; 2],
        tolerance: [1e-3, 1f64.to_radians()],
        ..PoseSettings::default()
    }
}

fn assert_within(trial: &Trial, limits: &PlateLimits) {
    for (command, plate) in trial.commands.iter().zip(&trial.plates) {
        assert!(command.displacement_acceleration.abs() <= limits.displacement_acceleration);
        assert!(command.tilt_acceleration.abs() <= limits.tilt_acceleration);
        assert!(plate.displacement.abs() <= limits.stroke && plate.tilt.abs() <= limits.tilt);
    }
}

fn assert_arrived(trial: &Trial, target: [f64; 3], tolerance: [f64; 2]) {
    assert!(trial.finished);
    let [x, y, phi, vx, vy, w] = trial.end;
    assert_eq!([vx, vy, w], [0.0; 3]);
    assert!((x - target[0]).abs() < tolerance[0] && (y - target[1]).abs() < tolerance[0], "{:?}", trial.end);
    assert!((phi - target[2]).abs() < tolerance[1], "{:?}", trial.end);
}

#[test]
fn a_move_with_the_exact_model_arrives_within_the_bounds() {
    let (start, target, settings) = ([0.02, -0.03, 0.4], [0.04, -0.02, 0.7], exact());
    let mut controller = PoseController::new(&ELLIPSE, target, &settings).unwrap();
    let trial = run(&mut controller, 0, 0.3, start, 3.0, |_, pose| pose);
    assert_eq!(controller.report().status, PoseStatus::Arrived);
    assert_arrived(&trial, target, settings.tolerance);
    assert_within(&trial, &settings.limits);
}

#[test]
fn wrong_friction_a_delay_noise_and_lost_measurements_are_recovered_from() {
    let (start, target, settings) = ([0.0, 0.05, -0.2], [-0.03, 0.04, 0.0], PoseSettings::default());
    let mut controller = PoseController::new(&ELLIPSE, target, &settings).unwrap();
    let trial = run(&mut controller, 1, 0.25, start, 6.0, |k, [x, y, phi]| {
        // A fixed pattern of errors of the size of the noise; every fifth sample is lost.
        let wave = |shift: f64| (2.4 * k as f64 + shift).sin() * 2f64.sqrt();
        let lost = if k % 5 == 3 { f64::NAN } else { 0.0 };
        let [position, yaw] = settings.noise;
        [x + position * wave(0.0) + lost, y + position * wave(1.0), phi + yaw * wave(2.0)]
    });
    assert_arrived(&trial, target, settings.tolerance);
    assert_within(&trial, &settings.limits);
    assert!((controller.report().mu - 0.25).abs() < 0.015, "{}", controller.report().mu);
    assert!(controller.report().lost > 0);
}

/// A plate whose rates follow those that the commands add up to with a first-order lag, and an object on it.
struct LaggingPlate {
    contact: AreaContact,
    time_constant: f64,
    commanded: [f64; 2],
    plate: PlateKinematics,
}

impl LaggingPlate {
    const PIECE: f64 = 1e-3;

    fn new(bandwidth: f64, mu: f64, [x, y, phi]: [f64; 3]) -> Self {
        let mut contact = AreaContact::new(&ELLIPSE, &Friction::Coulomb { mu }, &AreaSettings::default()).unwrap();
        contact.set_state([x, y, phi, 0.0, 0.0, 0.0]).unwrap();
        let time_constant = 1.0 / (std::f64::consts::TAU * bandwidth);
        Self { contact, time_constant, commanded: [0.0; 2], plate: PlateKinematics::default() }
    }

    /// Moves on by a period.
    fn advance(&mut self, command: Command, period: f64) {
        for _ in 0..(period / Self::PIECE).round() as usize {
            self.commanded[0] += command.displacement_acceleration * Self::PIECE;
            self.commanded[1] += command.tilt_acceleration * Self::PIECE;
            let acting = Command {
                displacement_acceleration: (self.commanded[0] - self.plate.velocity) / self.time_constant,
                tilt_acceleration: (self.commanded[1] - self.plate.tilt_rate) / self.time_constant,
            };
            let (from, before) = (self.contact.time(), self.plate);
            let mut motion = |t: f64| moved(&before, acting, t - from);
            assert!(self.contact.advance(&mut motion, from + Self::PIECE).unwrap().is_finished());
            self.plate = moved(&before, acting, Self::PIECE);
        }
    }
}

#[test]
fn on_a_lagging_plate_the_object_rests_and_comes_back_when_it_is_pushed() {
    let (target, tolerance) = ([0.04, -0.02, 0.6], [5e-3, 4f64.to_radians()]);
    for (bandwidth, push) in [(20.0, [0.2, -0.15, 1.0]), (50.0, [-0.1, 0.2, -2.0])] {
        let settings = PoseSettings { delay: 0, tolerance, ..PoseSettings::default() };
        let mut controller = PoseController::new(&ELLIPSE, target, &settings).unwrap();
        let mut plant = LaggingPlate::new(bandwidth, 0.3, target);
        // The number of arrivals, and the samples since the last one.
        let (mut arrivals, mut rested) = (0, 0);
        for _ in 0..500 {
            let [x, y, phi, ..] = plant.contact.state();
            let command = controller.command(&Measurement { object: [x, y, phi], plate: plant.plate }).unwrap();
            plant.advance(command, controller.period());
            arrivals += usize::from(controller.finished() && rested == 0);
            rested = if controller.finished() { rested + 1 } else { 0 };
            if rested == 25 && arrivals == 1 {
                plant.contact.set_state([x, y, phi, push[0], push[1], push[2]]).unwrap();
            }
        }
        let [x, y, phi, ..] = plant.contact.state();
        let PlateKinematics { velocity, tilt_rate, .. } = plant.plate;
        assert_eq!((arrivals, rested > 25), (2, true), "{bandwidth} Hz: {:?}", controller.report().status);
        assert!(
            (x - target[0]).abs() < tolerance[0] && (y - target[1]).abs() < tolerance[0],
            "{bandwidth} Hz: {x} {y}"
        );
        assert!((phi - target[2]).abs() < tolerance[1], "{bandwidth} Hz: {phi}");
        assert!(velocity.abs() < 1e-6 && tilt_rate.abs() < 1e-6, "{bandwidth} Hz: {velocity} {tilt_rate}");
    }
}

#[test]
fn a_mirrored_task_gets_mirrored_commands() {
    // y, φ and θ change their signs.
    let (start, target) = ([0.0, 0.02, 0.3], [0.01, 0.03, 0.5]);
    let mirror = |[x, y, phi]: [f64; 3]| [x, -y, -phi];
    let one = run(&mut PoseController::new(&ELLIPSE, target, &exact()).unwrap(), 0, 0.3, start, 0.3, |_, pose| pose);
    let mut mirrored = PoseController::new(&ELLIPSE, mirror(target), &exact()).unwrap();
    let other = run(&mut mirrored, 0, 0.3, mirror(start), 0.3, |_, pose| pose);
    for (a, b) in one.commands.iter().zip(&other.commands) {
        assert!((a.displacement_acceleration - b.displacement_acceleration).abs() < 0.15);
        assert!((a.tilt_acceleration + b.tilt_acceleration).abs() < 0.6);
    }
}

#[test]
fn a_target_out_of_reach_is_given_up_with_the_plate_at_rest() {
    let weak = PlateLimits { displacement_acceleration: 1.0, tilt_acceleration: 1.0, tilt: 0.05, ..Default::default() };
    let settings = PoseSettings { limits: weak, ..exact() };
    let mut controller = PoseController::new(&ELLIPSE, [0.05, 0.0, 0.0], &settings).unwrap();
    let trial = run(&mut controller, 0, 0.3, [0.0; 3], 1.0, |_, pose| pose);
    assert!(matches!(controller.report().status, PoseStatus::Unreachable { miss } if (miss[0] + 0.05).abs() < 1e-9));
    assert!(trial.finished && trial.commands.iter().all(|c| *c == Command::default()));
    assert!(PoseController::new(&ELLIPSE, [f64::NAN, 0.0, 0.0], &exact()).is_err());
}
