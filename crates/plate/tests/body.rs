//! The rigid body on the plate against closed-form answers of mechanics.
#![allow(clippy::unwrap_used)]

use bracketry_plate::{
    BodyEvent, BodyEventKind, BodyOnPlate, BodySettings, BodyStop, Friction, Object, PlateFrame, PlateKinematics,
    RigidState, Shape,
};
use nalgebra::{UnitQuaternion, Vector3};

const G: f64 = 9.81;

fn resting(_: f64) -> PlateKinematics {
    PlateKinematics::default()
}

fn tilted(angle: f64) -> impl FnMut(f64) -> PlateKinematics + Clone {
    move |_| PlateKinematics { tilt: angle, ..PlateKinematics::default() }
}

fn block(a: f64, b: f64, height: f64) -> Object {
    Object { shape: Shape::Rectangle { a, b }, height, mass: 0.3 }
}

fn coin() -> Object {
    Object { shape: Shape::Disk { radius: 0.1 }, height: 0.01, mass: 0.2 }
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
    // Lowest edge at y = +b: turned about -x by the angle `turn`, the centre of mass beyond the edge.
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
