//! Objects on plates with random numbers, sensible ones, absurd ones and impossible ones.

use bracketry_plate::area::AreaSettings;
use bracketry_plate::body::{BodySettings, ObjectMode, ObjectOnPlate, ObjectStop, RigidState};
use bracketry_plate::{Friction, Object, PlateError, PlateKinematics, Shape};
use nalgebra::{UnitQuaternion, Vector3};
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};

/// What became of a random object.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Outcome {
    /// The kind of outcome, to be counted.
    pub kind: String,
    /// Whether the object was impossible by construction.
    pub impossible: bool,
    /// Whether it was refused.
    pub refused: bool,
    /// What must not be, if it was.
    pub fault: Option<String>,
    /// Events in its log.
    pub events: usize,
    /// Steps with approximate friction.
    pub unresolved: usize,
}

/// A number between the powers of ten `low` and `high`.
fn magnitude(rng: &mut StdRng, low: f64, high: f64) -> f64 {
    10f64.powf(rng.random_range(low..high))
}

fn vector(rng: &mut StdRng, size: f64) -> Vector3<f64> {
    let mut component = || rng.random_range(-1.0..1.0);
    size * Vector3::new(component(), component(), component())
}

fn shape(rng: &mut StdRng) -> Result<Shape, PlateError> {
    let (a, b) = (magnitude(rng, -2.5, 0.0), magnitude(rng, -2.5, 0.0));
    Ok(match rng.random_range(0..4) {
        0 => Shape::Disk { radius: a },
        1 => Shape::Ellipse { a, b },
        2 => Shape::Rectangle { a, b },
        _ => {
            let corners = rng.random_range(3..9);
            let turn = std::f64::consts::TAU / f64::from(corners);
            let mut corner = |k: i32| {
                let (angle, radius) =
                    (turn * (f64::from(k) + rng.random_range(0.0..0.8)), a * rng.random_range(0.4..1.0));
                [radius * angle.cos(), radius * angle.sin()]
            };
            Shape::polygon(&(0..corners).map(&mut corner).collect::<Vec<_>>())?
        }
    })
}

fn friction(rng: &mut StdRng) -> Friction {
    let mu = if rng.random_bool(0.1) { 0.0 } else { magnitude(rng, -2.0, 0.6) };
    let more = mu * rng.random_range(1.0..2.0);
    match rng.random_range(0..5) {
        0 => Friction::Coulomb { mu },
        1 => Friction::StaticLevel { mu, mu_static: more },
        2 => Friction::Stribeck { mu, mu_static: more, velocity: magnitude(rng, -3.0, 0.0) },
        3 => Friction::Anisotropic { mu_along: mu, mu_across: more },
        _ => Friction::Viscous { mu, coefficient: magnitude(rng, -2.0, 2.0) },
    }
}

/// A plate that shakes along x and tilts, at two frequencies.
fn motion(rng: &mut StdRng) -> impl FnMut(f64) -> PlateKinematics + use<> {
    let [wx, wt] = [(); 2].map(|()| magnitude(rng, -1.0, 1.7) * std::f64::consts::TAU);
    let amplitude = rng.random_range(0.0..40.0) / (wx * wx);
    let swing = rng.random_range(0.0..0.6_f64).min(rng.random_range(0.0..200.0) / (wt * wt));
    let [px, pt] = [(); 2].map(|()| rng.random_range(0.0..std::f64::consts::TAU));
    let lean = rng.random_range(-0.3..0.3);
    move |t| {
        let ((s, c), (st, ct)) = ((wx * t + px).sin_cos(), (wt * t + pt).sin_cos());
        PlateKinematics {
            displacement: amplitude * s,
            velocity: amplitude * wx * c,
            acceleration: -amplitude * wx * wx * s,
            tilt: lean + swing * st,
            tilt_rate: swing * wt * ct,
            tilt_acceleration: -swing * wt * wt * st,
        }
    }
}

/// Simulates the object number `seed` for `duration` seconds.
pub(crate) fn run(seed: u64, duration: f64) -> Outcome {
    let mut rng = StdRng::seed_from_u64(seed);
    let impossible = rng.random_bool(0.15);
    let mut events = 0;
    let mut unresolved = 0;
    let (kind, refused, fault) = match simulate(&mut rng, impossible, duration) {
        Err(error) => {
            let text = error.to_string();
            let fault = (!impossible).then(|| format!("refused without cause: {text}"));
            (format!("refused: {}", words(&text)), true, fault)
        }
        Ok((object, stop)) => {
            events = object.events().len();
            unresolved = object.unresolved_steps();
            let state = object.state();
            let finite = state.position.iter().chain(state.velocity.iter()).all(|c| c.is_finite());
            let mode = match object.mode() {
                ObjectMode::Flat { overturned: false } => "flat",
                ObjectMode::Flat { overturned: true } => "flat, overturned",
                ObjectMode::Free => "free",
            };
            let fault = if impossible {
                Some("not refused".to_owned())
            } else if stop == ObjectStop::EndTime && !finite {
                Some("not finite at the end".to_owned())
            } else {
                None
            };
            (format!("{stop:?}, {mode}"), false, fault)
        }
    };
    Outcome { kind, impossible, refused, fault, events, unresolved }
}

/// The words of a message without its numbers.
fn words(text: &str) -> String {
    let number =
        |word: &&str| !word.chars().any(|c| c.is_ascii_digit()) && !word.contains("NaN") && !word.contains("inf");
    text.split_whitespace().filter(number).take(9).collect::<Vec<_>>().join(" ")
}

fn simulate(rng: &mut StdRng, impossible: bool, duration: f64) -> Result<(ObjectOnPlate, ObjectStop), PlateError> {
    let shape = shape(rng)?;
    let size = shape.second_moments().0.max(shape.second_moments().1).sqrt();
    let height = if rng.random_bool(0.1) { 0.0 } else { size * magnitude(rng, -2.0, 0.7) };
    let mut object = Object { shape, height, mass: magnitude(rng, -3.0, 2.0), ..Object::REFERENCE };
    let mut friction = friction(rng);
    let mut settings = BodySettings {
        restitution: if rng.random_bool(0.2) { 0.0 } else { rng.random_range(0.0..1.0) },
        max_steps: 50_000,
        ..BodySettings::default()
    };
    // One in ten is thrown at absurd speeds.
    let absurd = rng.random_bool(0.1);
    let (speed, spin) =
        if absurd { (magnitude(rng, 1.0, 5.0), magnitude(rng, 2.0, 5.0)) } else { (1.0, magnitude(rng, -1.0, 1.5)) };
    let mut state = RigidState::at_rest(height);
    let mut flat = true;
    match rng.random_range(0..3) {
        0 => {}
        1 => {
            state.velocity = vector(rng, speed);
            state.velocity.z = 0.0;
            state.angular_velocity.z = rng.random_range(-spin..spin);
        }
        _ => {
            flat = false;
            state.position.z += 3.0 * (size + height) + rng.random_range(0.0..0.3);
            state.orientation = UnitQuaternion::from_scaled_axis(vector(rng, 3.0));
            state.velocity = vector(rng, speed);
            state.angular_velocity = vector(rng, spin);
        }
    }
    state.position += Vector3::new(rng.random_range(-0.5..0.5), rng.random_range(-0.5..0.5), 0.0);
    let mut motion = motion(rng);
    if impossible {
        match rng.random_range(0..9) {
            0 => object.mass = -object.mass,
            1 => object.mass = f64::NAN,
            2 => object.shape = Shape::Rectangle { a: 0.0, b: 0.1 },
            3 => object.shape = Shape::polygon(&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 3.0]])?,
            4 => friction = Friction::StaticLevel { mu: 0.4, mu_static: 0.3 },
            5 => settings.restitution = rng.random_range(1.001..9.0),
            6 => state.position.z -= 0.5 * (height + size) + 20.0 * size + 1.0,
            7 => state.velocity.x = f64::INFINITY,
            _ => friction = Friction::Coulomb { mu: -0.2 },
        }
        flat = false;
    }
    let mut simulated = ObjectOnPlate::new(&object, &friction, &AreaSettings::default(), &settings)?;
    if flat {
        let [x, y] = [state.position.x, state.position.y];
        simulated.set_flat_state(0.0, [x, y, 0.0, state.velocity.x, state.velocity.y, state.angular_velocity.z])?;
    } else {
        simulated.set_state(0.0, &state)?;
    }
    let stop = simulated.advance(&mut motion, duration)?;
    Ok((simulated, stop))
}
