//! Motion from rest to rest under dry friction: exact thresholds, displacements in closed form, margins.

use crate::common::{Numbers, model, reached, system};
use bracketry_steer::from_rest::{
    Answer, Bound, FromRest, FromRestError, FromRestOptions, FromRestReason, Holds, Motion, Proof, Shape, from_rest,
    from_rest_map, margin,
};
use bracketry_steer::{SteerMethod, SteerOptions, Steering, own_inputs};
use bracketry_symbolic::Rational;
use bracketry_system::{System, point};

const PROVEN: Answer = Answer::Yes { proof: Proof::Proven };
const EVIDENCE: Answer = Answer::Yes { proof: Proof::Evidence };

fn under(system: &System, bounds: Vec<Bound>) -> FromRest {
    from_rest(system, &FromRestOptions { bounds, ..FromRestOptions::default() }).unwrap()
}

fn within(system: &System, bounds: &str) -> FromRest {
    under(system, Bound::list(bounds).unwrap())
}

fn at(mut system: System, text: &str) -> System {
    system.point = Some(point(&mut system, text).unwrap());
    system
}

fn motions(found: &FromRest) -> Vec<Motion> {
    found.coordinates.iter().map(|c| c.motion).collect()
}

fn answers(found: &FromRest) -> Vec<Answer> {
    found.coordinates.iter().map(|c| c.answer).collect()
}

fn thousandths(x: f64) -> Rational {
    Rational::from_parts(((1000.0 * x) as i64).into(), 1000u16.into())
}

/// A mass on a table with accelerations from −B to A moves down if and only if A > μ g, and up if and only if B > μ g: also where
/// the bounds equal μ g.
#[test]
fn the_table_moves_the_mass_where_its_acceleration_exceeds_friction() {
    let mut numbers = Numbers(11);
    for _ in 0..40 {
        let mut table = model("shaken_table");
        let (mu, g) = (thousandths(0.5 + 0.4 * numbers.next()), thousandths(10.0 + 5.0 * numbers.next()));
        assert!(table.set_parameter("mu", mu.clone()) && table.set_parameter("g", g.clone()));
        let friction = mu * g;
        let mut bound = || match (3.0 * numbers.next()) as i32 {
            0 => friction.clone(),
            sign => friction.clone() + Rational::from(sign) * thousandths(0.001 + 0.4 * numbers.next().abs()),
        };
        let (low, high) = (bound(), bound());
        let found = under(&table, vec![Bound::exact("der(X,2)", -low.clone(), high.clone())]);
        let expected = match (high > friction, low > friction) {
            (false, false) => (Motion::Never, Answer::No),
            (true, false) => (Motion::OnlyDown, Answer::No),
            (false, true) => (Motion::OnlyUp, Answer::No),
            (true, true) => (Motion::Open, PROVEN),
        };
        assert_eq!((found.coordinates[0].motion, found.answer), expected, "{low} {high} {friction}");
    }
}

/// Pushed with A for t, then back with D < m = μ g: the mass slides by (A − m) t²/2 while it is pushed, and by
/// ((A − m) t)²/(2 (D + m)) until it stops.
#[test]
fn displacements_on_the_table_have_their_closed_form() {
    let found = within(&model("shaken_table"), "der(X,2)=-5..4.5");
    assert_eq!(found.strokes.len(), 2);
    for stroke in &found.strokes {
        let Shape::FastSlow { fast, slow } = stroke.shape else { panic!("{:?}", stroke.shape) };
        let (a, m, t) = (fast.abs(), 0.3 * 9.81, stroke.signals.times[1]);
        assert!(slow < m);
        let slid = 0.5 * (a - m) * t * t + ((a - m) * t).powi(2) / (2.0 * (slow + m));
        for d in &stroke.displacements {
            let expected = -fast.signum() * slid * d.scale.powi(2);
            assert!((d.change[0] - expected).abs() < 1e-9, "{} {expected}", d.change[0]);
        }
    }
    assert!((found.margin - 1.0).abs() < 1e-12);
}

/// In a bowl, at a distance q from the bottom, friction holds up to μ g − k g q. Small loops move the mass both ways beyond
/// μ g + k g q, and only inward in between.
#[test]
fn in_a_bowl_the_slope_helps_one_way_and_resists_the_other() {
    let (mu, k, g) = (0.3, 0.5, 9.81);
    for q in [-0.4, -0.1, 0.0, 0.2, 0.5] {
        let bowl = at(model("vibrating_bowl"), &format!("x={q}"));
        let (inward, outward) = (g * (mu - k * f64::abs(q)), g * (mu + k * f64::abs(q)));
        let with = |a: f64| within(&bowl, &format!("der(X,2)=-{a}..{a},der(Y,2)=0..0"));
        assert_eq!(motions(&with(inward - 1e-6)), [Motion::Never; 2]);
        if q != 0.0 {
            let middle = with(0.5 * (inward + outward));
            assert_eq!(answers(&middle), [Answer::Unknown, Answer::No]);
            assert!(matches!(middle.reason, Some(FromRestReason::Loops { .. })));
            assert!(middle.strokes.iter().all(|s| s.displacements[0].change[0] * q < 0.0));
        }
        assert_eq!(answers(&with(outward + 0.2)), [PROVEN, Answer::No]);
    }
    let both = within(&at(model("vibrating_bowl"), "x=0.1,y=-0.05"), "der(X,2)=-6..6,der(Y,2)=-6..6");
    assert!(matches!(both.answer, Answer::Yes { .. }), "{both:?}");
    assert!(both.margin > 0.5);
}

/// A cart on a beam that tilts up to Θ with |θ''| ≤ α stays if g sin θ + s θ'² ≤ μ (g cos θ − s α) with θ'² ≤ 2 α (Θ − |θ|), for g > 2 s α
/// if this holds for θ = Θ. Otherwise a shaken tilt moves it, but for the room that loops leave.
#[test]
fn the_cart_stays_within_the_cone_of_the_tilt() {
    let mut numbers = Numbers(7);
    let (mut never, mut open) = (0, 0);
    for _ in 0..30 {
        let (tilt, alpha, s) = (0.2 + 0.1 * numbers.next(), 3.0 + 2.5 * numbers.next(), 0.2 + 0.1 * numbers.next());
        let cart = at(model("cart_on_tilting_beam"), &format!("s={s}"));
        let found = within(&cart, &format!("theta=-{tilt}..{tilt},der(theta,2)=-{alpha}..{alpha}"));
        let g = 9.81;
        let excess = g * tilt.sin() - 0.2 * (g * tilt.cos() - s * alpha);
        if excess < -1e-9 {
            never += 1;
            assert_eq!((motions(&found), found.answer), (vec![Motion::Never], Answer::No));
        } else {
            open += 1;
            assert_ne!(motions(&found), [Motion::Never]);
        }
    }
    assert!(never > 5 && open > 5, "{never} {open}");
    let wide = within(&model("cart_on_tilting_beam"), "der(theta,2)=-20..20");
    assert_eq!(wide.answer, PROVEN);
}

/// A force u pulls a mass on a spring: at x, friction holds if |u − k x| ≤ F for all u; with bounds of x, if this is so everywhere
/// within them.
#[test]
fn a_force_moves_the_mass_on_a_spring() {
    let mass = model("spring_mass_friction");
    assert_eq!(within(&mass, "u=-0.2..0.2").answer, Answer::No);
    assert_eq!(within(&mass, "u=-0.3..0.3").answer, PROVEN);
    // k x = 0.08 at x = 0.1.
    assert_eq!(motions(&within(&mass, "u=-0.12..0.12,x=-0.1..0.1")), [Motion::Never]);
    assert_ne!(motions(&within(&mass, "u=-0.121..0.12,x=-0.1..0.1")), [Motion::Never]);
    // At x = 0.3, the spring alone pulls with 0.24: no rest state.
    assert_eq!(within(&at(mass, "x=0.3"), "u=-1..1").reason, Some(FromRestReason::NotAtRest));
}

/// On the published plate, yaw has no friction: it turns within the friction cone, where x and y never change.
#[test]
fn the_published_plate_turns_what_it_cannot_shift() {
    let plate = model("plate_published");
    let small = within(&plate, "der(X,2)=-2..2,theta=-0.2..0.2,der(theta,2)=-20..20");
    assert_eq!(motions(&small), [Motion::Never, Motion::Never, Motion::Open]);
    assert_eq!(answers(&small)[2], PROVEN);
    let large = within(&plate, "der(X,2)=-5..5,theta=-0.4..0.4,der(theta,2)=-20..20");
    assert_eq!(large.answer, PROVEN);
    assert!((large.margin - 1.0 / 3f64.sqrt()).abs() < 1e-3, "{}", large.margin);
}

/// With the contact in one point, nothing turns an object that is aligned with the axis.
#[test]
fn with_contact_in_a_point_the_aligned_object_never_turns() {
    let found = within(&model("plate_point"), "der(X,2)=-5..5,theta=-0.4..0.4,der(theta,2)=-20..20");
    assert_eq!(answers(&found), [PROVEN, PROVEN, Answer::No]);
    assert_eq!(found.coordinates[2].motion, Motion::Never);
    let small = within(&model("plate_point"), "der(X,2)=-2..2,theta=-0.1..0.1,der(theta,2)=-5..5");
    assert_eq!(motions(&small), [Motion::Never; 3]);
    assert!(small.cones.iter().all(|c| c.holds == Holds::Always));
}

/// Friction over the footprint resists yaw, and lets it turn.
#[test]
fn with_contact_over_the_footprint_all_three_coordinates_change() {
    let found = within(&model("plate_reduced"), "der(X,2)=-5..5,theta=-0.4..0.4,der(theta,2)=-20..20");
    assert_eq!(found.answer, EVIDENCE);
    assert!(found.margin > 0.3, "{}", found.margin);
    let small = within(&model("plate_reduced"), "der(X,2)=-1..1,theta=-0.05..0.05,der(theta,2)=-1..1");
    assert_eq!(motions(&small), [Motion::Never; 3], "{:?}", small.cones);
}

/// The hull of ±e_i in any rotation holds the ball of radius 1/√d, and half of these vectors hold none.
#[test]
fn the_margin_of_a_cross_polytope_is_known() {
    let mut numbers = Numbers(3);
    for d in 1..=4 {
        let random = nalgebra::DMatrix::from_fn(d, d, |_, _| numbers.next());
        let q = random.qr().q();
        let vectors: Vec<Vec<f64>> =
            (0..2 * d).map(|k| q.column(k / 2).iter().map(|x| if k % 2 == 0 { *x } else { -x }).collect()).collect();
        assert!((margin(&vectors) - 1.0 / (d as f64).sqrt()).abs() < 1e-9);
        assert!(margin(&vectors[..2 * d - 1]) < 1e-9);
    }
    assert_eq!(margin(&[]), 0.0);
}

#[test]
fn models_without_rest_or_friction_have_no_answer() {
    let free = system(&["x", "v"], &["u"], &["v", "u"]);
    assert_eq!(within(&free, "u=-1..1").reason, Some(FromRestReason::NoFriction));
    assert_eq!(under(&model("unicycle"), Vec::new()).reason, Some(FromRestReason::NoCoordinates));
}

/// Motion is a statement of loops, so it is open where there is no time or memory for them; friction cones decide all the same.
#[test]
fn at_its_limits_the_answer_is_open() {
    let bounds = |text: &str| Bound::list(text).unwrap();
    let ends: [fn(&mut FromRestOptions); 3] = [
        |options| options.stop.raise(),
        |options| options.stop.memory_runs_out(),
        |options| options.time_limit = Some(std::time::Duration::ZERO),
    ];
    for end in ends {
        let mut options = FromRestOptions { bounds: bounds("der(X,2)=-4..4"), ..FromRestOptions::default() };
        end(&mut options);
        let found = from_rest(&model("shaken_table"), &options).unwrap();
        assert_eq!((found.answer, found.reason), (Answer::Unknown, Some(FromRestReason::Stopped)));
    }
}

#[test]
fn bounds_that_do_not_fit_are_refused() {
    let table = model("shaken_table");
    let error = |bounds: &str| {
        let options = FromRestOptions { bounds: Bound::list(bounds).unwrap(), ..FromRestOptions::default() };
        from_rest(&table, &options).unwrap_err().to_string()
    };
    assert_eq!(error("X=-1..1"), "`der(X,2)` is not bounded: give its bounds, as in der(X,2)=-4..4");
    assert!(
        error("der(Y,2)=-1..1").starts_with("`der(Y,2)` has no bounds here: give bounds of X, der(X), der(X,2), x")
    );
    assert!(error("der(X,2)=-1..1,der(X, 2)=0..1").contains("has two bounds"));
    assert!(error("der(X,2)=1..2").contains("exclude its value at rest, 0"));
    for text in ["der(X,2)", "der(X,2)=1", "der(X,2)=2..1", "der(X,2)=a..1"] {
        assert!(matches!(Bound::list(text), Err(FromRestError::Bound { .. })), "{text}");
    }
}

/// Along the acceleration, "no" ends at μ g, and "yes" starts there up to the room that loops leave to their bounds.
#[test]
fn the_threshold_of_a_map_is_the_known_one() {
    let mut numbers = Numbers(5);
    for _ in 0..5 {
        let mut table = model("shaken_table");
        let (mu, g) = (thousandths(0.5 + 0.4 * numbers.next()), thousandths(10.0 + 5.0 * numbers.next()));
        assert!(table.set_parameter("mu", mu.clone()) && table.set_parameter("g", g.clone()));
        let friction = (mu * g).to_f64().value();
        let axes = [Bound::new("der(X,2)", 0.5 * friction, 2.0 * friction), Bound::new("X", 0.01, 1.0)];
        let map = from_rest_map(&table, &axes, 4, &FromRestOptions::default()).unwrap();
        assert!(map.is_complete());
        let threshold = &map.thresholds[0];
        assert!((threshold.no_up_to - friction).abs() < 1e-6 * friction, "{threshold:?} {friction}");
        let yes = threshold.yes_from.unwrap();
        assert!(yes > friction && yes < 1.002 * friction, "{threshold:?} {friction}");
        for (j, row) in map.cells.iter().enumerate() {
            for (i, cell) in row.iter().enumerate() {
                let expected = if map.x[i] > friction { PROVEN } else { Answer::No };
                assert_eq!(cell.as_ref().unwrap()[0], expected, "{i} {j}");
            }
        }
    }
}

/// From rest to rest by loops, between coordinates by name; simulated again by itself.
fn steered(system: &System, bounds: &str, from: &[(&str, f64)], to: &[(&str, f64)]) -> Steering {
    let given = own_inputs(system).unwrap();
    let state = |named: &[(&str, f64)]| -> Vec<f64> {
        let value = |n: &String| named.iter().find(|(name, _)| name == n).map_or(0.0, |(_, v)| *v);
        given.state_names().iter().map(value).collect()
    };
    let mut options = SteerOptions::between(&state(from), &state(to));
    options.bounds = Bound::list(bounds).unwrap();
    options.method = Some(SteerMethod::Loops);
    reached(system, &options)
}

#[test]
fn loops_steer_from_rest_to_rest() {
    let table = model("shaken_table");
    for to in [0.05, -0.003, 0.0] {
        let found = steered(&table, "der(X,2)=-5..5", &[], &[("x", to)]);
        assert!(found.signals.unwrap().values.iter().all(|u| u[0].abs() <= 5.0));
    }
    steered(&model("cart_on_tilting_beam"), "der(theta,2)=-20..20", &[("s", 0.1)], &[("s", 0.03)]);
    steered(&model("vibrating_bowl"), "der(X,2)=-6..6,der(Y,2)=-6..6", &[], &[("x", 0.03), ("y", -0.02)]);
}

#[test]
fn loops_steer_the_plate() {
    let bounds = "der(X,2)=-5..5,theta=-0.4..0.4,der(theta,2)=-20..20";
    let start = [("x", 0.48), ("y", -0.03)];
    steered(&model("plate_point"), bounds, &start, &[("x", 0.54), ("y", 0.01)]);
    let all = [("x", 0.54), ("y", 0.0), ("phi", std::f64::consts::FRAC_PI_2)];
    steered(&model("plate_published"), bounds, &start, &all);
    steered(&model("plate_reduced"), bounds, &start, &[("x", 0.5), ("y", 0.0), ("phi", 0.2)]);
}

/// A puck on a table that is shaken along two directions: friction holds it if and only if the corners of the accelerations lie in
/// the disk of radius m, also where they lie on its edge.
#[test]
fn the_cone_of_a_puck_is_a_disk() {
    let puck = |m: i32| {
        system(
            &["x", "y", "vx", "vy"],
            &["X", "Y"],
            &["vx", "vy", &format!("-der(X,2) - {m}*unit(vx, vy)"), &format!("-der(Y,2) - {m}*unit(vy, vx)")],
        )
    };
    let bounds = |a: i32, b: i32, more: f64| {
        let more = thousandths(more);
        let size = |x: i32| Rational::from(x) + more.clone();
        vec![Bound::exact("der(X,2)", -size(a), size(a)), Bound::exact("der(Y,2)", -size(b), size(b))]
    };
    for (a, b, m) in [(3, 4, 5), (5, 12, 13), (8, 15, 17), (20, 21, 29)] {
        assert_eq!(motions(&under(&puck(m), bounds(a, b, 0.0))), [Motion::Never; 2]);
        assert_eq!(motions(&under(&puck(m), bounds(a, b, 0.001))), [Motion::Open; 2]);
        // Both accelerations together move it where none of them does alone.
        let together = under(&puck(m), bounds(a, b, 0.1));
        assert_eq!(together.answer, EVIDENCE, "{a} {b} {:?}", together.reason);
        let both = under(&puck(m), bounds(m, m, 1.0));
        assert_eq!(both.answer, PROVEN);
        assert!(both.back.unwrap().error < 1e-9 && both.grid.unwrap().points[0].reach > 0.0);
    }
}
