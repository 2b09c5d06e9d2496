//! The rigid body on the plate against closed-form answers of mechanics.

use crate::tier::cases;
use bracketry_plate::area::{AreaContact, AreaSettings};
use bracketry_plate::body::{
    BodyEvent, BodyEventKind, BodyOnPlate, BodySettings, BodyStop, ObjectMode, ObjectOnPlate, PlateFrame, RigidState,
};
use bracketry_plate::{Friction, Object, PlateError, PlateKinematics, Shape};
use nalgebra::{UnitQuaternion, Vector3};
use rayon::prelude::*;

const G: f64 = 9.81;

fn resting(_: f64) -> PlateKinematics {
    PlateKinematics::default()
}

fn tilted(angle: f64) -> impl FnMut(f64) -> PlateKinematics + Clone {
    move |_| PlateKinematics { tilt: angle, ..PlateKinematics::default() }
}

fn block(a: f64, b: f64, height: f64) -> Object {
    Object { shape: Shape::Rectangle { a, b }, height, mass: 0.3, ..Object::REFERENCE }
}

fn coin() -> Object {
    Object { shape: Shape::Disk { radius: 0.1 }, height: 0.01, mass: 0.2, ..Object::REFERENCE }
}

fn impacts(events: &[BodyEvent]) -> Vec<(f64, f64)> {
    let impact = |e: &BodyEvent| match e.kind {
        BodyEventKind::Impact { speed, .. } => Some((e.time, speed)),
        _ => None,
    };
    events.iter().filter_map(impact).collect()
}

fn body(object: &Object, mu: f64, settings: &BodySettings) -> BodyOnPlate {
    BodyOnPlate::new(object, &Friction::Coulomb { mu }, settings).unwrap()
}

#[test]
fn a_body_dropped_flat_bounces_to_heights_that_fall_by_the_square_of_the_restitution() {
    for (object, e) in [(block(0.1, 0.05, 0.02), 0.7), (coin(), 0.4)] {
        let settings = BodySettings { restitution: e, ..BodySettings::default() };
        let mut body = body(&object, 0.3, &settings);
        let drop = 0.2;
        let mut state = RigidState::at_rest(object.height + drop);
        state.velocity.x = 0.1;
        body.set_state(0.0, &state).unwrap();
        let mut events = Vec::new();
        let stop = body.advance(&mut resting, 10.0, &mut events).unwrap();
        assert_eq!(stop, BodyStop::Flat { overturned: false });
        let fall = (2.0 * drop / G).sqrt();
        let mut time = fall;
        for (k, (at, speed)) in impacts(&events).into_iter().enumerate().take(15) {
            let expected = G * fall * e.powi(k as i32);
            assert!((at - time).abs() < 1e-9, "impact {k} at {at}, not {time}");
            assert!((speed - expected).abs() < 1e-8, "impact {k} with {speed}, not {expected}");
            time += 2.0 * fall * e.powi(k as i32 + 1);
        }
        // The sum of all flights: the impacts accumulate there, and the body then lies flat.
        let limit = fall * (1.0 + e) / (1.0 - e);
        assert!((body.time() - limit).abs() < 1e-3, "{} {limit}", body.time());
        assert!(impacts(&events).last().unwrap().0 > limit - 1e-5 && impacts(&events).last().unwrap().0 < limit);
    }
}

#[test]
fn impacts_never_make_energy() {
    let mut seed = 7_u64;
    let mut random = move || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut seen = 0;
    for round in 0..60 {
        let object = match round % 2 {
            0 => block(0.02 + 0.1 * random(), 0.02 + 0.1 * random(), 0.001 + 0.1 * random()),
            _ => Object {
                shape: Shape::Ellipse { a: 0.02 + 0.1 * random(), b: 0.02 + 0.1 * random() },
                height: 0.001 + 0.1 * random(),
                mass: 0.1 + random(),
                ..Object::REFERENCE
            },
        };
        let settings = BodySettings { restitution: random(), ..BodySettings::default() };
        let mut body = body(&object, 1.5 * random(), &settings);
        let mut v = || Vector3::new(random() - 0.5, random() - 0.5, random() - 0.5);
        let state = RigidState {
            position: Vector3::new(0.0, 0.0, 0.3),
            orientation: UnitQuaternion::from_scaled_axis(v() * 6.0),
            velocity: v() * 4.0,
            angular_velocity: v() * 40.0,
        };
        body.set_state(0.0, &state).unwrap();
        let mut events = Vec::new();
        let _ = body.advance(&mut resting, 0.5, &mut events).unwrap();
        for event in &events {
            if let BodyEventKind::Impact { loss, impulse, .. } = event.kind {
                seen += 1;
                assert!(loss >= -1e-10 && impulse > 0.0, "round {round}: {event:?}");
            }
        }
        let potential = |s: &RigidState| object.mass * G * s.position.z;
        let before = 0.5 * object.mass * state.velocity.norm_squared() + potential(&state);
        assert!(body.relative_energy() + potential(body.state()) < before + 0.5 * 400.0 * object.mass, "round {round}");
        assert!(body.gap() > -1e-6, "round {round}: {}", body.gap());
    }
    assert!(seen > 100, "{seen}");
}

#[test]
fn a_tall_block_tips_and_a_rough_low_one_slides() {
    // Tips about its lower edge if tan θ > b/h, slides if tan θ > μ.
    let (b, h) = (0.05, 0.1);
    for (tangent, mu, slides, tips) in
        [(0.45, 0.8, false, false), (0.55, 0.8, false, true), (0.35, 0.3, true, false), (0.28, 0.3, false, false)]
    {
        let object = block(0.08, b, h);
        let mut body = body(&object, mu, &BodySettings::default());
        let mut events = Vec::new();
        let mut motion = tilted(f64::atan(tangent));
        for k in 1..=500 {
            let _ = body.advance(&mut motion, f64::from(k) * 2e-4, &mut events).unwrap();
        }
        let state = body.state();
        let turned = state.orientation.angle() > 1e-4;
        assert_eq!(turned, tips, "tan θ = {tangent}: turned by {}", state.orientation.angle());
        if slides {
            let cos = f64::atan(tangent).cos();
            let expected = -G * cos * (tangent - mu) * body.time();
            assert!((state.velocity.y - expected).abs() < 1e-6, "{} {expected}", state.velocity.y);
        } else if !tips {
            assert!(state.velocity.norm() < 1e-10 && state.position.y.abs() < 1e-10);
        }
    }
}

#[test]
fn a_block_that_tips_about_its_edge_follows_the_inverted_pendulum() {
    // Pivot at the edge: (J + m r²) β'' = m g r sin(β), β the angle of the radius r to the vertical.
    let (b, h) = (0.05, 0.1);
    let object = block(0.2, b, h);
    let settings = BodySettings { contact_step: 1e-4, ..BodySettings::default() };
    let mut body = body(&object, 5.0, &settings);
    let start = f64::atan(b / h) + 0.1;
    let radius = b.hypot(h);
    // Lowest edge at y = +b: turned about -x by the angle `turn`, the center of mass beyond the edge.
    let turn = -start;
    let mut state = RigidState::at_rest(0.0);
    state.orientation = UnitQuaternion::from_scaled_axis(Vector3::x() * turn);
    state.position = Vector3::new(0.0, 0.0, radius * 0.1_f64.cos());
    body.set_state(0.0, &state).unwrap();
    let mut events = Vec::new();
    let _ = body.advance(&mut resting, 0.15, &mut events).unwrap();
    let inertia = (b * b + h * h) / 3.0 + radius * radius;
    let (mut beta, mut rate) = (0.1_f64, 0.0_f64);
    let n = 15000;
    let dt = 0.15 / f64::from(n);
    for _ in 0..n {
        rate += 0.5 * dt * G * radius * beta.sin() / inertia;
        beta += dt * rate;
        rate += 0.5 * dt * G * radius * beta.sin() / inertia;
    }
    let turned = body.state().orientation.angle() - start;
    assert!((turned - (beta - 0.1)).abs() < 1e-3 * (beta - 0.1), "{turned} {}", beta - 0.1);
}

#[test]
fn a_plate_jerked_down_lets_go_where_the_load_vanishes_and_the_body_lands_when_it_should() {
    // The plate tilts about x with the body far out at y: its surface falls away with y θ'' < -g.
    let object = coin();
    let mut body = body(&object, 0.3, &BodySettings::default());
    let y = 1.0;
    let mut state = RigidState::at_rest(object.height);
    state.position.y = y;
    body.set_state(0.0, &state).unwrap();
    // θ'' = -30 from the start: the surface under the body outruns free fall at once.
    let mut motion = |t: f64| PlateKinematics {
        tilt: -15.0 * t * t,
        tilt_rate: -30.0 * t,
        tilt_acceleration: -30.0,
        ..PlateKinematics::default()
    };
    let mut events = Vec::new();
    let _ = body.advance(&mut motion, 0.1, &mut events).unwrap();
    assert!(impacts(&events).is_empty());
    let plate = PlateFrame::new(&motion(0.1));
    let world = plate.to_world(body.state());
    let started = PlateFrame::new(&motion(0.0)).to_world(&state);
    let expected = started.position + Vector3::z() * (-0.5 * G * 0.01);
    assert!((world.position - expected).norm() < 1e-9, "{}", world.position - expected);
}

#[test]
fn mirrored_motions_give_mirrored_results() {
    let object = block(0.06, 0.04, 0.02);
    let run = |sign: f64| {
        let settings = BodySettings { restitution: 0.4, ..BodySettings::default() };
        let mut body = body(&object, 0.5, &settings);
        let state = RigidState {
            position: Vector3::new(sign * 0.1, 0.0, 0.2),
            orientation: UnitQuaternion::from_scaled_axis(Vector3::new(0.4, sign * 0.7, sign * -0.2)),
            velocity: Vector3::new(sign * 0.8, 0.3, -0.5),
            angular_velocity: Vector3::new(2.0, sign * -3.0, sign * 1.0),
        };
        body.set_state(0.0, &state).unwrap();
        let mut events = Vec::new();
        let _ = body.advance(&mut resting, 0.25, &mut events).unwrap();
        (*body.state(), events.len())
    };
    let ((right, n), (left, m)) = (run(1.0), run(-1.0));
    assert_eq!(n, m);
    assert!((right.position.x + left.position.x).abs() < 1e-9, "{right:?} {left:?}");
    assert!((right.position.y - left.position.y).abs() < 1e-9);
    assert!((right.velocity.z - left.velocity.z).abs() < 1e-7);
}

fn object_on_plate(object: &Object, mu: f64, restitution: f64) -> ObjectOnPlate {
    let settings = BodySettings { restitution, ..BodySettings::default() };
    ObjectOnPlate::new(object, &Friction::Coulomb { mu }, &AreaSettings::default(), &settings).unwrap()
}

fn first(object: &ObjectOnPlate, wanted: fn(&BodyEventKind) -> bool) -> Option<f64> {
    object.events().iter().find(|e| wanted(&e.kind)).map(|e| e.time)
}

fn shaken(t: f64) -> PlateKinematics {
    let w = 18.0;
    let (s, c) = (w * t).sin_cos();
    PlateKinematics {
        displacement: 0.02 * s,
        velocity: 0.02 * w * c,
        acceleration: -0.02 * w * w * s,
        tilt: 0.1 * s,
        tilt_rate: 0.1 * w * c,
        tilt_acceleration: -0.1 * w * w * s,
    }
}

#[test]
fn while_it_lies_flat_the_object_is_area_contact() {
    let object = Object { shape: Shape::Ellipse { a: 0.1, b: 0.06 }, height: 0.01, mass: 0.2, ..Object::REFERENCE };
    let start = [0.1, 0.05, 0.3, 0.2, -0.1, 2.0];
    let mut whole = object_on_plate(&object, 0.3, 0.5);
    whole.set_flat_state(0.0, start).unwrap();
    let _ = whole.advance(&mut shaken, 0.5).unwrap();
    let mut area = AreaContact::new(&object, &Friction::Coulomb { mu: 0.3 }, &AreaSettings::default()).unwrap();
    area.set_state(start).unwrap();
    let _ = area.advance(&mut shaken, 0.5).unwrap();
    assert_eq!(whole.planar_state(), area.state());
    assert!(whole.events().is_empty());
}

#[test]
fn six_degrees_of_freedom_in_flat_contact_agree_with_three() {
    // The pressure and the friction of area contact are those of a rigid body whose contacts bear the load with least norm.
    let object = Object { shape: Shape::Ellipse { a: 0.1, b: 0.06 }, height: 0.01, mass: 0.2, ..Object::REFERENCE };
    let start = [0.1, 0.05, 0.3, 0.2, -0.1, 2.0];
    let mut area = AreaContact::new(&object, &Friction::Coulomb { mu: 0.3 }, &AreaSettings::default()).unwrap();
    area.set_state(start).unwrap();
    let _ = area.advance(&mut shaken, 0.15).unwrap();
    let expected = area.state();
    let settings = BodySettings { contact_step: 2.5e-4, ..BodySettings::default() };
    let mut body = body(&object, 0.3, &settings);
    let mut state = RigidState::at_rest(object.height);
    state.position += Vector3::new(start[0], start[1], 0.0);
    state.orientation = UnitQuaternion::from_scaled_axis(Vector3::z() * start[2]);
    state.velocity = Vector3::new(start[3], start[4], 0.0);
    state.angular_velocity.z = start[5];
    body.set_state(0.0, &state).unwrap();
    let mut events = Vec::new();
    while body.time() < 0.15 {
        let _ = body.advance(&mut shaken, 0.15, &mut events).unwrap();
    }
    assert!(events.is_empty());
    let got = body.state();
    let angle = got.orientation.scaled_axis().z;
    assert!((got.position.x - expected[0]).abs() < 2e-5, "{} {}", got.position.x, expected[0]);
    assert!((got.position.y - expected[1]).abs() < 2e-5, "{} {}", got.position.y, expected[1]);
    assert!((angle - expected[2]).abs() < 5e-4, "{angle} {}", expected[2]);
    assert!((got.position.z - object.height).abs() < 1e-9);
}

#[test]
fn a_plate_that_tilts_slowly_tips_a_rough_block_and_lets_a_smooth_one_slide() {
    let (b, h) = (0.03, 0.08);
    let rate = 0.2;
    let mut tilting = |t: f64| PlateKinematics { tilt: rate * t, tilt_rate: rate, ..PlateKinematics::default() };
    let mut rough = object_on_plate(&block(0.05, b, h), 0.9, 0.0);
    let _ = rough.advance(&mut tilting, 2.2).unwrap();
    let tipped = first(&rough, |k| matches!(k, BodyEventKind::Tipping)).unwrap();
    // tan θ = b/h up to the inertia of the slow rotation, h θ'²/g.
    assert!((tipped - (b / h).atan() / rate).abs() < 1e-3, "{tipped} {}", (b / h).atan() / rate);
    assert_eq!(rough.mode(), ObjectMode::Free);
    let mut smooth = object_on_plate(&block(0.05, b, h), 0.2, 0.0);
    let slides_at = 0.2_f64.atan() / rate;
    let _ = smooth.advance(&mut tilting, slides_at - 0.01).unwrap();
    assert_eq!(smooth.planar_state()[3..], [0.0; 3]);
    let _ = smooth.advance(&mut tilting, slides_at + 0.2).unwrap();
    assert!(smooth.planar_state()[4] < -1e-3 && smooth.events().is_empty());
}

#[test]
fn a_plate_that_drops_away_throws_the_object_which_lands_where_plate_and_parabola_meet() {
    // Over y the surface falls with y A w² > g from the first instant: the block hangs in the world without rotation, until
    // the plate has swung back and meets a lower corner.
    let (amplitude, w) = (0.2, 14.0);
    let mut swing = |t: f64| {
        let (s, c) = (w * t).sin_cos();
        PlateKinematics {
            tilt: -amplitude * (1.0 - c),
            tilt_rate: -amplitude * w * s,
            tilt_acceleration: -amplitude * w * w * c,
            ..PlateKinematics::default()
        }
    };
    let (b, y) = (0.02, 0.5);
    let object = block(0.03, b, 0.01);
    let mut thrown = object_on_plate(&object, 0.5, 0.3);
    thrown.set_flat_state(0.0, [0.2, y, 0.0, 0.0, 0.0, 0.0]).unwrap();
    let _ = thrown.advance(&mut swing, 0.6).unwrap();
    let lifted = first(&thrown, |k| matches!(k, BodyEventKind::LiftOff)).unwrap();
    let landed = first(&thrown, |k| matches!(k, BodyEventKind::Impact { .. })).unwrap();
    assert!(lifted < 1e-6, "{lifted}");
    // Lower corners y ± b fall by g t²/2; the surface there is at z = y tan θ.
    let gap = |t: f64| {
        let tilt = -amplitude * (1.0 - (w * t).cos());
        [y - b, y + b]
            .map(|y| (-0.5 * G * t * t) * tilt.cos() - y * tilt.sin())
            .into_iter()
            .fold(f64::INFINITY, f64::min)
    };
    let (mut low, mut high) = (0.05, 0.05);
    while gap(high) > 0.0 {
        high += 1e-3;
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if gap(middle) > 0.0 { low = middle } else { high = middle }
    }
    assert!((landed - high).abs() < 1e-8, "{landed} {high}");
}

#[test]
fn a_rocking_block_loses_at_each_impact_what_angular_momentum_about_the_new_edge_says() {
    // Housner (1963): ω⁺/ω⁻ = 1 − (3/2) sin² α, tan α = b/h, for a block that neither slips nor bounces.
    let (b, h) = (0.03, 0.12);
    let object = block(0.1, b, h);
    let mut rocking = object_on_plate(&object, 2.0, 0.0);
    let (radius, alpha, lift) = (b.hypot(h), (b / h).atan(), 0.05_f64);
    let mut state = RigidState::at_rest(radius * (alpha - lift).cos());
    state.orientation = UnitQuaternion::from_scaled_axis(Vector3::x() * lift);
    rocking.set_state(0.0, &state).unwrap();
    let _ = rocking.advance(&mut resting, 0.6).unwrap();
    let losses: Vec<f64> = rocking
        .events()
        .iter()
        .filter_map(|e| match e.kind {
            BodyEventKind::Impact { loss, .. } => Some(loss),
            _ => None,
        })
        .collect();
    let ratio = 1.0 - 1.5 * alpha.sin().powi(2);
    let fallen = object.mass * G * radius * ((alpha - lift).cos() - alpha.cos());
    assert!((losses[0] / (fallen * (1.0 - ratio * ratio)) - 1.0).abs() < 0.01, "{losses:?}");
    assert!((losses[1] / (losses[0] * ratio * ratio) - 1.0).abs() < 0.02, "{losses:?} {ratio}");
}

#[test]
fn flight_keeps_energy_and_angular_momentum_in_the_world_however_the_plate_moves() {
    let object = block(0.1, 0.05, 0.02);
    let mut flying = body(&object, 0.3, &BodySettings::default());
    let state = RigidState {
        position: Vector3::new(0.1, 0.2, 3.0),
        orientation: UnitQuaternion::from_scaled_axis(Vector3::new(0.3, 1.0, -0.4)),
        velocity: Vector3::new(0.5, -0.3, 1.0),
        angular_velocity: Vector3::new(3.0, 20.0, -7.0),
    };
    flying.set_state(0.0, &state).unwrap();
    let inertia = |s: &RigidState| {
        let moments = Vector3::new(
            0.05_f64.powi(2) + 0.02_f64.powi(2),
            0.1_f64.powi(2) + 0.02_f64.powi(2),
            0.1_f64.powi(2) + 0.05_f64.powi(2),
        );
        let body = s.orientation.inverse() * s.angular_velocity;
        let momentum = (object.mass / 3.0) * moments.component_mul(&body);
        let kinetic = 0.5 * (object.mass * s.velocity.norm_squared() + momentum.dot(&body));
        (s.orientation * momentum, kinetic + object.mass * G * s.position.z)
    };
    let (momentum, energy) = inertia(&PlateFrame::new(&shaken(0.0)).to_world(&state));
    let mut events = Vec::new();
    let _ = flying.advance(&mut shaken, 0.7, &mut events).unwrap();
    let (later, energy_later) = inertia(&PlateFrame::new(&shaken(0.7)).to_world(flying.state()));
    assert!(events.is_empty());
    assert!((later - momentum).norm() < 1e-9 * momentum.norm());
    assert!((energy_later - energy).abs() < 1e-9 * energy);
}

#[test]
fn an_object_that_landed_on_a_tilted_plate_rests_for_a_minute_without_creep() {
    let settings = BodySettings { restitution: 0.3, ..BodySettings::default() };
    let area = AreaSettings::default().with_step(1e-2);
    let mut resting = ObjectOnPlate::new(&coin(), &Friction::Coulomb { mu: 0.3 }, &area, &settings).unwrap();
    let mut tilt = tilted(10f64.to_radians());
    resting.set_state(0.0, &RigidState::at_rest(0.01 + 0.02)).unwrap();
    let _ = resting.advance(&mut tilt, 3.0).unwrap();
    assert_eq!(resting.mode(), ObjectMode::Flat { overturned: false });
    let before = resting.planar_state();
    let _ = resting.advance(&mut tilt, 63.0).unwrap();
    assert_eq!(resting.planar_state(), before);
    assert_eq!(before[3..], [0.0; 3]);
}

#[test]
fn an_object_dropped_upside_down_lies_on_its_other_face() {
    let corners = [[-0.05, -0.04], [0.07, -0.04], [0.01, 0.06]];
    let object = Object { shape: Shape::polygon(&corners).unwrap(), height: 0.01, mass: 0.1, ..Object::REFERENCE };
    let mut dropped = object_on_plate(&object, 0.4, 0.2);
    let mut state = RigidState::at_rest(0.03);
    state.orientation = UnitQuaternion::from_scaled_axis(Vector3::x() * std::f64::consts::PI);
    state.angular_velocity.z = 5.0;
    dropped.set_state(0.0, &state).unwrap();
    let _ = dropped.advance(&mut resting, 1.0).unwrap();
    assert_eq!(dropped.mode(), ObjectMode::Flat { overturned: true });
    let upward = dropped.state().orientation * Vector3::z();
    assert!((upward + Vector3::z()).norm() < 1e-12);
    assert!(dropped.planar_state()[2] > 0.01 && dropped.planar_state()[5] == 0.0);
}

#[test]
fn the_same_throw_elsewhere_and_later_gives_the_same_motion() {
    let object = block(0.06, 0.04, 0.02);
    let run = |shift: f64, delay: f64| {
        let mut thrown = object_on_plate(&object, 0.5, 0.4);
        let state = RigidState {
            position: Vector3::new(shift, shift, 0.2),
            orientation: UnitQuaternion::from_scaled_axis(Vector3::new(0.4, 0.7, -0.2)),
            velocity: Vector3::new(0.8, 0.3, -0.5),
            angular_velocity: Vector3::new(2.0, -3.0, 1.0),
        };
        thrown.set_state(delay, &state).unwrap();
        let _ = thrown.advance(&mut resting, delay + 0.22).unwrap();
        thrown.state().position - Vector3::new(shift, shift, 0.0)
    };
    assert!((run(0.0, 0.0) - run(0.75, 0.5)).norm() < 1e-9);
}

#[test]
fn states_and_settings_without_meaning_are_refused_with_the_reason() {
    let object = coin();
    let make = |settings: BodySettings| {
        ObjectOnPlate::new(&object, &Friction::Coulomb { mu: 0.3 }, &AreaSettings::default(), &settings).map(|_| ())
    };
    let settings = BodySettings { restitution: 1.2, ..BodySettings::default() };
    assert_eq!(make(settings), Err(PlateError::Restitution { value: 1.2 }));
    let settings = BodySettings { gravity: 1.6, ..BodySettings::default() };
    assert_eq!(make(settings), Err(PlateError::GravityDiffers { area: 9.81, body: 1.6 }));
    let mut placed = object_on_plate(&object, 0.3, 0.0);
    let error = placed.set_state(0.0, &RigidState::at_rest(0.004)).unwrap_err();
    assert!(matches!(error, PlateError::Penetration { depth } if (depth - 0.006).abs() < 1e-12));
    let mut state = RigidState::at_rest(0.1);
    state.velocity.z = f64::NAN;
    assert!(matches!(placed.set_state(0.0, &state), Err(PlateError::BadState { .. })));
}

#[test]
fn random_objects_run_to_an_end_or_are_refused_with_the_reason() {
    let outcomes: Vec<_> =
        (1..=cases(100, 300_u64)).into_par_iter().map(|seed| (seed, crate::random_object::run(seed, 0.1))).collect();
    for (seed, outcome) in &outcomes {
        assert_eq!(outcome.fault, None, "seed {seed}: {}", outcome.kind);
        assert_eq!(outcome.refused, outcome.impossible, "seed {seed}: {}", outcome.kind);
    }
    assert!(
        outcomes.iter().any(|(_, o)| o.refused)
            && outcomes.iter().map(|(_, o)| o.events).sum::<usize>() > outcomes.len() / 3
    );
    assert!(outcomes.iter().map(|(_, o)| o.unresolved).sum::<usize>() < 10 * outcomes.len());
}
