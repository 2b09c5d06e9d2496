//! Area contact: friction laws, pressure, tipping and lift-off, symmetries, balances, orders of convergence, bad input.

use bracketry_plate::area::{
    AreaContact, AreaEvent, AreaOutcome, AreaRecord, AreaSettings, Footprint, Load, Scheme, Support,
};
use bracketry_plate::{Friction, Object, PlateError, PlateKinematics, Shape};

const G: f64 = 9.81;

fn still(_: f64) -> PlateKinematics {
    PlateKinematics::default()
}

/// Plate that shakes with the amplitude `a` (m, 2 Hz) and rocks with `b` (rad, 3 Hz).
fn shaken(a: f64, b: f64) -> impl FnMut(f64) -> PlateKinematics + Copy {
    move |t| {
        let (p, q) = (4.0 * std::f64::consts::PI, 6.0 * std::f64::consts::PI);
        PlateKinematics {
            displacement: a * (p * t).sin(),
            velocity: a * p * (p * t).cos(),
            acceleration: -a * p * p * (p * t).sin(),
            tilt: b * (q * t).sin(),
            tilt_rate: b * q * (q * t).cos(),
            tilt_acceleration: -b * q * q * (q * t).sin(),
        }
    }
}

fn contact(object: &Object, friction: Friction, settings: &AreaSettings, state: [f64; 6]) -> AreaContact {
    let mut contact = AreaContact::new(object, &friction, settings).unwrap();
    contact.set_state(state).unwrap();
    contact
}

fn flat(shape: Shape) -> Object {
    Object { shape, height: 0.0, mass: 0.2, ..Object::REFERENCE }
}

fn finish(contact: &mut AreaContact, mut motion: impl FnMut(f64) -> PlateKinematics, t_end: f64) -> AreaRecord {
    let (record, outcome) = contact.record(&mut motion, t_end).unwrap();
    assert_eq!(outcome, AreaOutcome::Finished);
    record
}

#[test]
fn a_static_level_holds_more_than_sliding_friction() {
    let law = Friction::StaticLevel { mu: 0.2, mu_static: 0.4 };
    let start = [0.0; 6];
    let tilted = |angle: f64| move |_| PlateKinematics { tilt: angle, ..PlateKinematics::default() };
    let object = flat(Shape::REFERENCE_ELLIPSE);
    let angle = 0.4f64.atan();
    let mut held = contact(&object, law, &AreaSettings::default(), start);
    finish(&mut held, tilted(angle - 1e-9), 1.0);
    assert_eq!(held.state(), start);
    // Once loose, the lower level acts, also below the angle at which it broke loose.
    let mut loose = contact(&object, law, &AreaSettings::default(), start);
    finish(&mut loose, tilted(angle + 1e-9), 0.5);
    let acceleration = G * (angle.sin() - 0.2 * angle.cos());
    assert!((loose.state()[4] + 0.5 * acceleration).abs() < 1e-6);
    loose.set_state([0.0, 0.0, 0.0, 0.0, -1e-3, 0.0]).unwrap();
    let from = loose.time();
    finish(&mut loose, tilted(0.3f64.atan()), from + 0.5);
    assert!(loose.state()[4] < -0.4);
}

#[test]
fn viscous_friction_decays_exponentially_to_the_dry_part() {
    // v' = −g (μ + k v)
    let (mu, k) = (0.1, 0.5);
    for (scheme, tolerance) in [(Scheme::Euler, 3e-3), (Scheme::SecondOrder, 2e-6)] {
        let settings = AreaSettings::default().with_scheme(scheme);
        let law = Friction::Viscous { mu, coefficient: k };
        let mut block = contact(&flat(Shape::REFERENCE_DISK), law, &settings, [0.0, 0.0, 0.0, 0.6, 0.8, 0.0]);
        finish(&mut block, still, 0.2);
        let v = (1.0 + mu / k) * (-G * k * 0.2).exp() - mu / k;
        let [vx, vy] = [block.state()[3], block.state()[4]];
        assert!((vx - 0.6 * v).abs() < tolerance && (vy - 0.8 * v).abs() < tolerance, "{vx} {vy} {v}");
    }
}

#[test]
fn stribeck_friction_follows_its_curve() {
    let law = Friction::Stribeck { mu: 0.2, mu_static: 0.3, velocity: 0.1 };
    let settings = AreaSettings::default().with_step(2.5e-4);
    let mut block = contact(&flat(Shape::REFERENCE_DISK), law, &settings, [0.0, 0.0, 0.0, 0.5, 0.0, 0.0]);
    finish(&mut block, still, 0.18);
    // The same by the midpoint rule in fine steps.
    let (mut v, steps) = (0.5f64, 20_000);
    let dt = 0.18 / f64::from(steps);
    for _ in 0..steps {
        let middle = v - 0.5 * dt * G * law.coefficient(v);
        v -= dt * G * law.coefficient(middle);
    }
    assert!((block.state()[3] - v).abs() < 1e-6, "{} {v}", block.state()[3]);
}

#[test]
fn anisotropic_friction_slows_each_direction_by_its_own_coefficient() {
    let law = Friction::Anisotropic { mu_along: 0.2, mu_across: 0.4 };
    // The axes are those of the plate: the yaw of the object does not matter.
    for (direction, mu) in [([0.5, 0.0], 0.2), ([0.0, 0.5], 0.4)] {
        let start = [0.0, 0.0, 0.7, direction[0], direction[1], 0.0];
        let object = flat(Shape::Rectangle { a: 0.1, b: 0.05 });
        let mut block = contact(&object, law, &AreaSettings::default(), start);
        finish(&mut block, still, 0.1);
        let left = 0.5 - 0.1 * mu * G;
        assert!((block.state()[3].hypot(block.state()[4]) - left).abs() < 1e-9);
        assert!(block.state()[5].abs() < 1e-9);
    }
    // A slip between the axes turns toward the easy one.
    let mut block =
        contact(&flat(Shape::REFERENCE_DISK), law, &AreaSettings::default(), [0.0, 0.0, 0.0, 0.4, 0.4, 0.0]);
    finish(&mut block, still, 0.1);
    assert!(block.state()[3] > 1.5 * block.state()[4]);
}

#[test]
fn pressure_carries_force_and_moments_and_never_pulls() {
    let shapes = [
        Shape::REFERENCE_ELLIPSE,
        Shape::Rectangle { a: 0.1, b: 0.04 },
        Shape::polygon(&[[0.0, 0.0], [0.3, 0.0], [0.3, 0.1], [0.1, 0.1], [0.1, 0.2], [0.0, 0.2]]).unwrap(),
    ];
    for shape in shapes {
        let mut footprint = Footprint::new(&flat(shape.clone()), 192).unwrap();
        let rim = shape.support([0.6, 0.8]);
        let mut kinds = [false; 2];
        for share in [0.0, 0.1, 0.2, 0.4, 0.6, 0.8] {
            let load = Load { normal: 7.0, moments: rim.map(|r| 7.0 * share * r) };
            let support = footprint.carry(&load).unwrap();
            match support {
                Support::Full { least } => {
                    assert!(least >= 0.0);
                    kinds[0] = true;
                }
                Support::Partial { share } => {
                    assert!(share < 1.0);
                    kinds[1] = true;
                }
                _ => panic!("{shape:?} at {share}: {support:?}"),
            }
            assert!(footprint.loads().iter().all(|p| *p >= 0.0));
            let sum = |f: &dyn Fn(&[f64; 2]) -> f64| -> f64 {
                footprint.points().iter().zip(footprint.loads()).map(|(r, p)| p * f(r)).sum()
            };
            assert!((sum(&|_| 1.0) - 7.0).abs() < 1e-11);
            assert!((sum(&|r| r[0]) - load.moments[0]).abs() < 1e-11);
            assert!((sum(&|r| r[1]) - load.moments[1]).abs() < 1e-11);
        }
        assert_eq!(kinds, [true, true]);
        // Beyond the outermost points an edge carries; beyond the rim nothing can.
        let at = |share: f64| Load { normal: 1.0, moments: rim.map(|r| share * r) };
        assert!(matches!(footprint.carry(&at(0.9999)).unwrap(), Support::Edge { .. } | Support::Partial { .. }));
        assert!(
            matches!(footprint.carry(&at(1.0001)).unwrap(), Support::Tipping { rim_share, .. } if rim_share >= 1.0)
        );
        assert_eq!(footprint.carry(&Load { normal: -1.0, moments: [0.0; 2] }).unwrap(), Support::LiftOff);
    }
}

#[test]
fn a_tall_object_tips_where_the_weight_leaves_its_base() {
    // tan θ = b/h on a plate that rises slowly; friction is enough.
    let object = Object { shape: Shape::Rectangle { a: 0.1, b: 0.01 }, height: 0.05, mass: 2.0, ..Object::REFERENCE };
    let mut tall = contact(&object, Friction::Coulomb { mu: 1.0 }, &AreaSettings::default(), [0.0; 6]);
    let rate = 0.01;
    let mut rising = |t: f64| PlateKinematics { tilt: rate * t, tilt_rate: rate, ..PlateKinematics::default() };
    let (record, outcome) = tall.record(&mut rising, 30.0).unwrap();
    let AreaOutcome::Tipping { t, at, normal } = outcome else { panic!("{outcome:?}") };
    assert!((rate * t - 0.2f64.atan()).abs() < 1e-6, "{}", rate * t);
    assert!(at[0].abs() < 1e-9 && (at[1] + 0.01).abs() < 1e-9);
    assert!((normal - 2.0 * G * (rate * t).cos()).abs() < 1e-3);
    // Before, part of the base lost its pressure: at tan θ = b/(3 h).
    let lost = record.events.iter().find_map(|e| if let AreaEvent::PartialContact { t } = e { Some(*t) } else { None });
    assert!((rate * lost.unwrap() - (0.2f64 / 3.0).atan()).abs() < 1e-4);
    assert_eq!(tall.state(), [0.0; 6]);
}

#[test]
fn an_object_that_the_plate_would_have_to_pull_lifts_off() {
    // g cos θ < h θ'²
    let object = Object { shape: Shape::REFERENCE_DISK, height: 0.1, mass: 1.0, ..Object::REFERENCE };
    let mut disk = contact(&object, Friction::Coulomb { mu: 0.0 }, &AreaSettings::default(), [0.0; 6]);
    let mut turning = |t: f64| PlateKinematics { tilt: 12.0 * t, tilt_rate: 12.0, ..PlateKinematics::default() };
    assert_eq!(disk.advance(&mut turning, 1.0).unwrap(), AreaOutcome::LiftOff { t: 0.0 });
}

#[test]
fn the_frame_does_not_matter() {
    let object = Object { shape: Shape::Rectangle { a: 0.12, b: 0.07 }, height: 0.004, mass: 0.3, ..Object::REFERENCE };
    let start = [0.1, -0.05, 0.4, 0.2, -0.1, 1.0];
    let end = |start: [f64; 6], sign_x: f64, sign_tilt: f64| {
        let mut contact = contact(&object, Friction::Coulomb { mu: 0.25 }, &AreaSettings::default(), start);
        finish(&mut contact, shaken(0.02 * sign_x, 0.12 * sign_tilt), 1.0);
        contact.state()
    };
    let same = |a: [f64; 6], b: [f64; 6], signs: [f64; 6]| {
        for i in 0..6 {
            assert!((a[i] - signs[i] * b[i]).abs() < 1e-9, "{a:?} {b:?}");
        }
    };
    let reference = end(start, 1.0, 1.0);
    // Shifted along x.
    let mut shifted = end([start[0] + 5.0, start[1], start[2], start[3], start[4], start[5]], 1.0, 1.0);
    shifted[0] -= 5.0;
    same(reference, shifted, [1.0; 6]);
    // Mirrored in the x axis and in the y axis.
    let mirror = |signs: [f64; 6]| std::array::from_fn(|i| signs[i] * start[i]);
    let across = [1.0, -1.0, -1.0, 1.0, -1.0, -1.0];
    same(reference, end(mirror(across), 1.0, -1.0), across);
    let along = [-1.0, 1.0, -1.0, -1.0, 1.0, -1.0];
    same(reference, end(mirror(along), -1.0, 1.0), along);
    // Turned by half a turn, the rectangle is the same.
    let mut turned = end([start[0], start[1], start[2] + std::f64::consts::PI, start[3], start[4], start[5]], 1.0, 1.0);
    turned[2] -= std::f64::consts::PI;
    same(reference, turned, [1.0; 6]);
    // Turned by a quarter turn it is the rectangle with its sides exchanged.
    let swapped = Object { shape: Shape::Rectangle { a: 0.07, b: 0.12 }, ..object.clone() };
    let quarter = std::f64::consts::FRAC_PI_2;
    let start = [start[0], start[1], start[2] + quarter, start[3], start[4], start[5]];
    let mut other = contact(&swapped, Friction::Coulomb { mu: 0.25 }, &AreaSettings::default(), start);
    finish(&mut other, shaken(0.02, 0.12), 1.0);
    let mut other = other.state();
    other[2] -= quarter;
    same(reference, other, [1.0; 6]);
}

#[test]
fn kinetic_energy_relative_to_the_plate_is_the_work_of_friction_and_inertia() {
    for scheme in [Scheme::Euler, Scheme::SecondOrder] {
        let settings = AreaSettings::default().with_scheme(scheme);
        let start = [0.1, -0.05, 0.4, 0.2, -0.1, 1.0];
        let mut object = contact(&Object::REFERENCE, Friction::Coulomb { mu: 0.25 }, &settings, start);
        finish(&mut object, shaken(0.03, 0.12), 3.0);
        let energy = object.energy();
        assert!(energy.friction < -0.01 && energy.drive > 0.01);
        assert!(energy.relative_error() < 1e-12, "{energy:?}");
    }
}

/// Energy of the object in the world, in J.
fn energy_in_the_world(object: &Object, plate: &PlateKinematics, state: &[f64; 6]) -> f64 {
    let [_, y, phi, vx, vy, w] = *state;
    let (h, rate) = (object.height, plate.tilt_rate);
    let (_, syy, _) = object.shape.second_moments_at(phi);
    let velocity = [plate.velocity + vx, vy - h * rate, y * rate];
    let translation: f64 = velocity.iter().map(|v| v * v).sum();
    let rotation = (syy + h * h / 3.0) * rate * rate + object.shape.yaw_inertia() * w * w;
    object.mass * (0.5 * (translation + rotation) + G * (y * plate.tilt.sin() + h * plate.tilt.cos()))
}

#[test]
fn energy_in_the_world_is_the_work_of_the_plate() {
    // Kinetic and potential energy from an inertial frame, the power of pressure and friction at the moving plate: this
    // tests every term of the equations. The powers are integrated over the steps by the trapezoidal rule.
    let object = Object { shape: Shape::REFERENCE_ELLIPSE, height: 0.01, mass: 0.5, ..Object::REFERENCE };
    let start = [0.1, -0.02, 0.4, 0.6, 0.3, 2.0];
    let error = |step: f64| {
        let settings = AreaSettings::default().with_step(step);
        let mut moving = contact(&object, Friction::Coulomb { mu: 0.1 }, &settings, start);
        let mut plate = shaken(0.03, 0.1);
        finish(&mut moving, plate, 0.1);
        let begin = energy_in_the_world(&object, &plate(0.1), &moving.state());
        let record = finish(&mut moving, plate, 0.4);
        assert!(record.events.is_empty(), "{:?}", record.events);
        let (mut work, mut turnover, mut before) = (0.0, 0.0, None);
        for sample in &record.samples {
            let now = plate(sample.t);
            let [_, y, _, vx, vy, w] = sample.state;
            let [fx, fy, torque] = sample.friction;
            let power = fx * (now.velocity + vx)
                + fy * vy
                + torque * w
                + now.tilt_rate * sample.normal * (y + sample.center[1]);
            // The first step begins where no sample is; its end stands for it.
            let (t, last) = before.unwrap_or((0.1, power));
            work += 0.5 * (sample.t - t) * (power + last);
            turnover += (sample.t - t) * power.abs();
            before = Some((sample.t, power));
        }
        (energy_in_the_world(&object, &plate(0.4), &moving.state()) - begin - work).abs() / turnover
    };
    let (coarse, fine) = (error(1e-3), error(1e-4));
    assert!(fine < 1e-6 && fine < 0.15 * coarse, "{coarse} {fine}");
}

#[test]
fn the_schemes_have_their_orders() {
    // Sliding and spinning without stop: smooth in time.
    let end = |scheme, step| {
        let settings = AreaSettings::default().with_scheme(scheme).with_step(step);
        let start = [0.1, -0.02, 0.4, 0.8, 0.5, 2.0];
        let mut moving = contact(&Object::REFERENCE, Friction::Coulomb { mu: 0.2 }, &settings, start);
        finish(&mut moving, shaken(0.01, 0.05), 0.2);
        moving.state()
    };
    let reference = end(Scheme::SecondOrder, 1e-4);
    let distance = |a: [f64; 6]| a.iter().zip(reference).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
    for (scheme, order) in [(Scheme::Euler, 1.0), (Scheme::SecondOrder, 2.0)] {
        let errors = [4e-3, 2e-3].map(|step| distance(end(scheme, step)));
        let measured = (errors[0] / errors[1]).log2();
        assert!((measured - order).abs() < 0.3, "{scheme:?}: {measured}, {errors:?}");
    }
}

#[test]
fn random_objects_on_random_plates_end_in_a_known_way() {
    let mut seed = 9u64;
    let mut random = move || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut counts = [0; 3];
    for case in 0..200 {
        let (a, b) = (0.01 + 0.2 * random(), 0.01 + 0.2 * random());
        let triangle = [[0.0, 0.0], [a, 0.01 * random()], [b * random(), b]];
        let shape = match case % 4 {
            0 => Shape::Disk { radius: a },
            1 => Shape::Ellipse { a, b },
            2 => Shape::Rectangle { a, b },
            _ => Shape::polygon(&triangle).unwrap(),
        };
        let object =
            Object { shape, height: 0.05 * random() * random(), mass: 10.0 * random() + 1e-3, ..Object::REFERENCE };
        let mu = random();
        let law = match case % 5 {
            0 => Friction::Coulomb { mu },
            1 => Friction::StaticLevel { mu, mu_static: 1.5 * mu },
            2 => Friction::Stribeck { mu, mu_static: 2.0 * mu, velocity: 0.001 + 0.1 * random() },
            3 => Friction::Anisotropic { mu_along: mu, mu_across: random() },
            _ => Friction::Viscous { mu, coefficient: random() },
        };
        let settings = AreaSettings::default().with_points(4 + case % 30).with_step(4e-3);
        let start = std::array::from_fn(|i| (random() - 0.5) * if i == 5 { 20.0 } else { 1.0 });
        let mut moving = contact(&object, law, &settings, start);
        let (record, outcome) = moving.record(&mut shaken(0.05 * random(), 0.4 * random()), 0.4).unwrap();
        match outcome {
            AreaOutcome::Finished => counts[0] += 1,
            AreaOutcome::Tipping { t, normal, .. } => {
                counts[1] += 1;
                assert!(t <= 0.4 && normal > 0.0);
            }
            AreaOutcome::LiftOff { t } => {
                counts[2] += 1;
                assert!(t <= 0.4);
            }
            AreaOutcome::NotFinite { t } => panic!("case {case}: not finite after {t}"),
        }
        assert!(moving.state().iter().all(|x| x.is_finite()));
        assert!(record.energy.relative_error() < 1e-9);
        assert!(record.samples.iter().all(|s| s.normal > 0.0));
    }
    assert!(counts[0] > 50 && counts[1] > 10, "{counts:?}");
}

#[test]
fn what_has_no_meaning_is_refused() {
    let settings = AreaSettings::default();
    let law = Friction::Coulomb { mu: 0.3 };
    let refused =
        |object: &Object, law: &Friction, settings: &AreaSettings| AreaContact::new(object, law, settings).unwrap_err();
    let bad = Object { mass: -1.0, ..Object::REFERENCE };
    assert_eq!(refused(&bad, &law, &settings), PlateError::BadNumber { name: "mass", value: -1.0 });
    let bad = Object { height: f64::INFINITY, ..Object::REFERENCE };
    assert!(matches!(refused(&bad, &law, &settings), PlateError::NegativeNumber { name: "height", .. }));
    let negative = refused(&Object::REFERENCE, &Friction::Coulomb { mu: -0.3 }, &settings);
    assert_eq!(negative, PlateError::NegativeNumber { name: "mu", value: -0.3 });
    let step = refused(&Object::REFERENCE, &law, &settings.clone().with_step(0.0));
    assert_eq!(step, PlateError::BadNumber { name: "step", value: 0.0 });
    let points = refused(&Object::REFERENCE, &law, &settings.clone().with_points(2));
    assert_eq!(points, PlateError::TooFewPoints { count: 2, least: 4 });
    let mut disk = contact(&Object::REFERENCE, law, &settings, [0.0; 6]);
    assert!(matches!(disk.set_state([0.0, f64::NAN, 0.0, 0.0, 0.0, 0.0]), Err(PlateError::BadState { .. })));
    disk.advance(&mut still, 1.0).unwrap();
    assert_eq!(disk.advance(&mut still, 0.5).unwrap_err(), PlateError::BadState { value: 0.5 });
    assert!(disk.advance(&mut still, f64::NAN).is_err());
    // A plate motion that is not finite ends the simulation.
    let mut broken = |t: f64| PlateKinematics { acceleration: 1.0 / (1.5 - t).max(0.0), ..PlateKinematics::default() };
    assert!(matches!(disk.advance(&mut broken, 2.0).unwrap(), AreaOutcome::NotFinite { .. }));
    let mut broken = |t: f64| PlateKinematics { tilt: (4.0 - t).sqrt() * 0.0, ..PlateKinematics::default() };
    disk.set_time(3.9).unwrap();
    disk.set_state([0.0; 6]).unwrap();
    let outcome = disk.advance(&mut broken, 5.0).unwrap();
    assert!(matches!(outcome, AreaOutcome::NotFinite { t } if (t - 4.0).abs() < 1e-6), "{outcome:?}");
}
