//! Friction between that of the axes and that of the plane, `(1 − c) sign(v) + c v/|v|`: switches that depend on each other.

use crate::time_stepping::{Term, rest_of_step};
use bracketry_sim::{
    Balance, Closures, Coupled, FrictionMode, Inputs, Model, Path, Simulation, SimulationSettings, Stepper, Tangent,
    simulate,
};
use bracketry_system::System;
use proptest::prelude::*;

/// The published disk, with part `c` of its friction coupled over the plane, and `spin` in its last equation.
fn disk(c: f64, spin: &str) -> System {
    let mixture = |axis: &str, other: &str| format!("((1 - {c})*sign({axis}) + {c}*unit({axis}, {other}))");
    let text = include_str!("../../../../models/plate_published_disk.toml")
        .replace("der(theta,2)/I\"", &format!("der(theta,2)/I{spin}\""))
        .replace("sign(vx)", &mixture("vx", "vy"))
        .replace("sign(vy)", &mixture("vy", "vx"));
    System::parse("disk.toml", &text).unwrap()
}

/// A mass in the plane under the acceleration `(a, b)`, with part `c` of its friction `f` coupled.
fn plane(f: f64, c: f64) -> System {
    let text = r#"
        states = ["vx", "vy"]
        inputs = ["a", "b"]
        parameters = { f = F, c = C }
        [dynamics]
        vx = "a - f*((1 - c)*sign(vx) + c*unit(vx, vy))"
        vy = "b - f*((1 - c)*sign(vy) + c*unit(vy, vx))"
    "#;
    let number = |value: f64| format!("{value:.17e}");
    System::parse(
        "plane.toml",
        &text.replace("f = F", &format!("f = {}", number(f))).replace("c = C", &format!("c = {}", number(c))),
    )
    .unwrap()
}

/// An acceleration in the plane, and its mean over a step.
#[derive(Debug, Clone, Copy)]
struct Drive {
    /// By axis: amplitude and angular frequency of two sines, and a constant.
    axes: [[f64; 5]; 2],
}

impl Drive {
    fn inputs(&self) -> Inputs {
        let text = |[p, m, q, n, r]: [f64; 5]| format!("{p:.17}*sin({m:.17}*t) + {q:.17}*cos({n:.17}*t) + {r:.17}");
        Inputs::new().expression("a", &text(self.axes[0])).expression("b", &text(self.axes[1]))
    }

    fn mean(&self, t: f64, h: f64) -> [f64; 2] {
        self.axes.map(|[p, m, q, n, r]| {
            let middle = t + 0.5 * h;
            // sin(x)/x of the half step is 1 to rounding errors of the method.
            p * (m * middle).sin() + q * (n * middle).cos() + r
        })
    }
}

fn drives() -> impl Strategy<Value = Drive> {
    let axis = (0.0..4.0f64, 1.0..12.0f64, 0.0..3.0f64, 1.0..12.0f64, -1.0..1.0f64);
    let axis = axis.prop_map(|(p, m, q, n, r)| [p, m, q, n, r]);
    (axis.clone(), axis).prop_map(|(a, b)| Drive { axes: [a, b] })
}

fn parts() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), Just(1.0), 0.0..=1.0f64, 0.0..0.01f64, 0.99..1.0f64]
}

fn velocities() -> impl Strategy<Value = [f64; 2]> {
    let entry = prop_oneof![Just(0.0), -1.0..1.0f64];
    [entry.clone(), entry]
}

fn run(system: &System, inputs: &Inputs, x0: &[f64], t_end: f64) -> Simulation {
    let model = Model::new(system, inputs).unwrap();
    simulate(model, 0.0, x0, t_end, &SimulationSettings::default()).unwrap()
}

/// The proximal map of `|vx| + |vy|` times `axes` plus `|v|` times `plane`: that of the second after that of the first
/// (Yu 2013).
fn prox(v: [f64; 2], axes: f64, plane: f64) -> [f64; 2] {
    let soft = v.map(|v: f64| v.signum() * (v.abs() - axes).max(0.0));
    let size = soft[0].hypot(soft[1]);
    let left = if size > plane { 1.0 - plane / size } else { 0.0 };
    soft.map(|v| left * v)
}

/// A point on the boundary of what the friction 1 can hold, with the normal at `angle`; where the normal is that of an edge, the point
/// at `along` of it.
fn limit(c: f64, angle: f64, edge: Option<usize>, along: f64) -> [f64; 2] {
    if let Some(edge) = edge {
        let mut point = [along * (1.0 - c); 2];
        point[edge % 2] = if edge < 2 { 1.0 } else { -1.0 };
        return point;
    }
    let (s, k) = angle.sin_cos();
    [k, s].map(|n| (1.0 - c) * n.signum() + c * n)
}

#[test]
fn a_disk_on_a_shaken_plate_runs_to_the_end() {
    let sine = Inputs::new()
        .expression("X", "0.025*sin(4*pi*t)*(1 - exp(-t))")
        .expression("theta", "-pi/12*sin(4*pi*t)*(1 - exp(-t))");
    let multisine = Inputs::new()
        .expression("X", "0.02*sin(11*t) + 0.01*sin(23*t + 1)")
        .expression("theta", "0.15*sin(9*t) - 0.06*sin(19*t + 2)");
    for inputs in [&sine, &multisine] {
        for c in [0.1, 0.5, 0.9] {
            for spin in ["", " - 20*w/sqrt(vx^2 + vy^2 + 0.0036*w^2)"] {
                let run = run(&disk(c, spin), inputs, &[0.3, 0.0, 0.0, 0.0, 0.0, 0.0], 10.0);
                assert!(run.outcome.is_finished(), "{c} {spin}: {:?}", run.outcome);
            }
        }
    }
}

#[test]
fn where_all_friction_is_of_one_kind_it_is_that_law() {
    let drive = Drive { axes: [[4.0, 3.0, 2.0, 7.0, 0.3], [3.0, 5.0, 2.5, 2.0, -0.2]] };
    let pure = |x: &str, y: &str| {
        let text = "states = [\"vx\", \"vy\"]\ninputs = [\"a\", \"b\"]\n[dynamics]\n";
        System::parse("pure.toml", &format!("{text}vx = \"a - 2*{x}\"\nvy = \"b - 2*{y}\"")).unwrap()
    };
    for (c, law) in [(0.0f64, pure("sign(vx)", "sign(vy)")), (1.0, pure("unit(vx, vy)", "unit(vy, vx)"))] {
        let exact = run(&law, &drive.inputs(), &[0.4, -0.3], 5.0);
        for near in [0.0, 1e-6, 1e-3] {
            let mixed = run(&plane(2.0, (c - near).abs()), &drive.inputs(), &[0.4, -0.3], 5.0);
            assert!(mixed.outcome.is_finished(), "{:?}", mixed.outcome);
            for i in 0..=50 {
                let t = 0.1 * f64::from(i);
                let (a, b) = (exact.trajectory.sample(t), mixed.trajectory.sample(t));
                // The forces differ by at most 2·2·near, and motions approach each other. Between the steps, whose lengths the signs
                // change, the states are interpolated.
                let most = 4.0 * near * t + 1e-7;
                assert!((a[0] - b[0]).hypot(a[1] - b[1]) <= most, "{c} {near} {t} {a:?} {b:?}");
            }
        }
    }
}

#[test]
fn a_sum_of_axes_and_plane_breaks_loose_at_its_own_boundary() {
    // Pushes that grow along a ray reach the boundary of the sum at t = 1, at which no single term alone would hold.
    for c in [0.1, 0.5, 0.9] {
        for step in 0..24 {
            let point = limit(c, f64::from(step) * 0.2 + 0.05, None, 0.0);
            let inputs = Inputs::new()
                .expression("a", &format!("{:.17}*t", point[0]))
                .expression("b", &format!("{:.17}*t", point[1]));
            let run = run(&plane(1.0, c), &inputs, &[0.0, 0.0], 1.5);
            assert!(run.outcome.is_finished(), "{c} {point:?} {:?}", run.outcome);
            let events = run.trajectory.mode_changes();
            assert!(events.len() == 3 && events.iter().all(|e| (e.t - 1.0).abs() < 1e-9), "{c} {point:?} {events:?}");
        }
    }
}

/// The mass on springs: `(1 − c) sign + c unit` of friction 1, and springs that remember where it stuck.
const ON_SPRINGS: &str = r#"
    states = ["x", "y", "vx", "vy"]
    inputs = ["a", "b"]
    [dynamics]
    x = "vx"
    y = "vy"
    vx = "a - x - 0.6*sign(vx) - 0.4*unit(vx, vy)"
    vy = "b - y - 0.6*sign(vy) - 0.4*unit(vy, vx)"
"#;

#[test]
fn sensitivities_pass_through_rest() {
    let system = System::parse("springs.toml", ON_SPRINGS).unwrap();
    let inputs = Inputs::new().expression("a", "1.6*sin(t)").expression("b", "0.8*cos(2*t)");
    let x0 = [0.1, -0.2, 0.5, 0.3];
    let model = Model::differentiable(&system, &inputs, &[]).unwrap();
    // Steps short enough for the midpoint rule of the linear maps.
    let settings = SimulationSettings::default().with_max_step(1e-3);
    let mut stepper = Stepper::new(model, 0.0, &x0, &settings).unwrap();
    stepper.follow(Path::default());
    let mut rested = false;
    for i in 1..=120 {
        assert!(stepper.advance(0.05 * f64::from(i)).is_finished());
        rested |= stepper.modes().iter().all(|&mode| mode == FrictionMode::Sticking);
    }
    assert!(rested);
    let (path, mut tangent) = (stepper.take_path(), Tangent::default());
    assert!(stepper.system_mut().tangent(&path, &mut tangent));
    let mut change: Vec<f64> = (0..16).map(|i| f64::from(u8::from(i % 5 == 0))).collect();
    for piece in 0..tangent.len() {
        tangent.propagate(piece, &mut change, &[], &mut Vec::new());
    }
    let end = |j: usize, step: f64| {
        let mut x = x0;
        x[j] += step;
        run(&system, &inputs, &x, 6.0).trajectory.final_state().to_vec()
    };
    for j in 0..4 {
        let (above, below) = (end(j, 1e-5), end(j, -1e-5));
        for i in 0..4 {
            let difference = (above[i] - below[i]) / 2e-5;
            assert!((change[4 * j + i] - difference).abs() < 1e-3, "{i} {j} {} {difference}", change[4 * j + i]);
        }
    }
}

#[test]
fn forces_found_by_iteration_are_shared_alike() {
    let drive = Drive { axes: [[2.0, 3.0, 1.0, 7.0, 0.3], [1.5, 5.0, 1.5, 2.0, -0.2]] };
    let at_once = run(&plane(1.6, 0.4), &drive.inputs(), &[0.4, -0.3], 4.0);
    // Closures do not tell that their field is affine in the signs.
    let block = Closures {
        dim: 2,
        switches: 4,
        rhs: move |t: f64, _x: &[f64], s: &[f64], dx: &mut [f64]| {
            let a = drive.mean(t, 0.0);
            (0..2).for_each(|i| dx[i] = a[i] - 1.6 * (0.4 * s[i] + 0.6 * s[2 + i]));
        },
        switching: |_t, x: &[f64], sigma: &mut [f64]| sigma.copy_from_slice(&[x[0], x[1], x[0], x[1]]),
        gradient: |_t, _x: &[f64], g: &mut [f64], _dt: &mut [f64]| {
            g.copy_from_slice(&[1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0]);
        },
    };
    // The plane first, then the axes.
    let block = Coupled::new(block, vec![2, 1, 1]);
    let iterated = simulate(block, 0.0, &[0.4, -0.3], 4.0, &SimulationSettings::default()).unwrap();
    assert!(at_once.outcome.is_finished() && iterated.outcome.is_finished(), "{:?}", iterated.outcome);
    let (a, b) = (at_once.trajectory.mode_changes(), iterated.trajectory.mode_changes());
    assert!(a.len() > 10 && a.len() == b.len(), "{} {}", a.len(), b.len());
    for (a, b) in a.iter().zip(b) {
        assert!((a.t - b.t).abs() < 1e-8, "{a:?} {b:?}");
    }
    for (a, b) in at_once.trajectory.final_state().iter().zip(iterated.trajectory.final_state()) {
        assert!((a - b).abs() < 1e-8, "{a} {b}");
    }
}

proptest! {
    #![proptest_config(crate::common::random_cases(60))]

    #[test]
    fn the_motion_is_that_of_implicit_time_steps(
        c in parts(), f in 0.2..3.0f64, drive in drives(), v0 in velocities(),
    ) {
        let run = run(&plane(f, c), &drive.inputs(), &v0, 2.0);
        prop_assert!(run.outcome.is_finished(), "{:?}", run.outcome);
        let (mut v, steps) = (v0, 40_000);
        let h = 2.0 / f64::from(steps);
        let mut worst = 0.0f64;
        for i in 0..steps {
            let t = h * f64::from(i);
            let a = drive.mean(t, h);
            v = prox([v[0] + h * a[0], v[1] + h * a[1]], h * f * (1.0 - c), h * f * c);
            if i % 100 == 99 {
                let x = run.trajectory.sample(t + h);
                worst = worst.max((x[0] - v[0]).hypot(x[1] - v[1]));
            }
        }
        prop_assert!(worst < 40.0 * h, "{worst:e}");
    }

    #[test]
    fn what_sticks_on_both_axes_sticks_in_the_plane_and_the_reverse(
        c in 0.001..0.999f64, f in 0.2..3.0f64, drive in drives(), v0 in velocities(),
    ) {
        let run = run(&plane(f, c), &drive.inputs(), &v0, 3.0);
        prop_assert!(run.outcome.is_finished(), "{:?}", run.outcome);
        for i in 0..=600 {
            let t = 0.005 * f64::from(i);
            let mode = |switch| run.trajectory.mode(switch, t).unwrap();
            let sticks = |switch| mode(switch) == FrictionMode::Sticking;
            prop_assert_eq!(sticks(0) && sticks(1), sticks(2), "{} {:?} {:?} {:?}", t, mode(0), mode(1), mode(2));
        }
    }

    #[test]
    fn friction_takes_what_it_can_and_never_feeds(
        c in parts(), f in 0.2..3.0f64, drive in drives(), v0 in velocities(),
    ) {
        let system = plane(f, c);
        let run = run(&system, &drive.inputs(), &v0, 3.0);
        prop_assert!(run.outcome.is_finished(), "{:?}", run.outcome);
        // The greatest dissipation of all friction forces in the sum.
        let power = "a*vx + b*vy - f*((1 - c)*(abs(vx) + abs(vy)) + c*sqrt(vx^2 + vy^2))";
        let mut balance = Balance::new(&system, &drive.inputs(), "(vx^2 + vy^2)/2", power, &[]).unwrap();
        let account = balance.of(&run.trajectory);
        prop_assert!(account.error() < 1e-7 * (1.0 + account.turnover), "{:e} {:e}", account.error(), account.turnover);
        let mut forces = Balance::new(
            &system,
            &drive.inputs(),
            "0*vx",
            "-f*(vx*((1 - c)*sign(vx) + c*unit(vx, vy)) + vy*((1 - c)*sign(vy) + c*unit(vy, vx)))",
            &[],
        ).unwrap();
        let friction = forces.of(&run.trajectory);
        prop_assert!(friction.work.windows(2).all(|w| w[1] <= w[0] + 1e-12), "{:?}", friction.work);
    }

    #[test]
    fn rest_holds_exactly_while_the_drive_is_inside(
        c in parts(), angle in 0.0..6.3f64, edge in prop::option::of(0usize..4), along in -0.99..0.99f64,
        f in 0.01..100.0f64,
        size in prop_oneof![0.0..0.9f64, 0.9..1.0f64, Just(1.0 - 1e-9), Just(1.0 + 1e-9), 1.0..1.1f64, 1.1..5.0f64],
    ) {
        let point = limit(c, angle, edge, along).map(|p| f * size * p);
        let inputs = Inputs::new()
            .expression("a", &format!("{:.17e}", point[0]))
            .expression("b", &format!("{:.17e}", point[1]));
        let run = run(&plane(f, c), &inputs, &[0.0, 0.0], 1.0);
        prop_assert!(run.outcome.is_finished(), "{:?}", run.outcome);
        let end = run.trajectory.final_state();
        if size < 1.0 {
            prop_assert_eq!(end, &[0.0, 0.0]);
            prop_assert!(run.trajectory.mode_changes().is_empty());
        } else if size > 1.0 + 1e-12 {
            prop_assert!(end[0].hypot(end[1]) > 0.0);
        }
    }

    #[test]
    fn any_sum_of_dependent_terms_moves_as_by_implicit_time_steps(
        which in 0usize..6, p in prop::array::uniform3(0.1..1.5f64), drive in drives(), v0 in velocities(), w0 in -1.0..1.0f64,
        r in 0.3..2.0f64, still in any::<bool>(),
    ) {
        let [k, l, m] = p;
        // Terms of the dissipation: a weight, and the rows of what it is the norm of.
        let (x, y) = (vec![1.0, 0.0, 0.0], vec![0.0, 1.0, 0.0]);
        let along = |text: &str| format!("states = [\"vx\", \"vy\", \"w\"]\ninputs = [\"a\", \"b\"]\n[dynamics]\n{text}");
        let unit3 = format!("sqrt(vx^2 + vy^2 + {:.17}*w^2)", r * r);
        let (text, terms) = match which {
            0 => (
                along(&format!("vx = \"a - {k}*sign(vx) - {l}*sign(2*vx) - {m}*sign(-3*vx)*(-1)\"\nvy = \"b\"\nw = \"0\"")),
                vec![Term::new(k, [x.clone()]), Term::new(l, [x.clone()]), Term::new(m, [x])],
            ),
            1 => (
                along(&format!(
                    "vx = \"a - {k}*unit(vx, vy) - {l}*vx/{unit3}\"\nvy = \"b - {k}*unit(vy, vx) - {l}*vy/{unit3}\"\n\
                     w = \"0.5*a - {l}*{:.17}*w/{unit3}\"", r * r
                )),
                vec![Term::new(k, [x.clone(), y.clone()]), Term::new(l, [x, y, vec![0.0, 0.0, r]])],
            ),
            2 => (
                along(&format!(
                    "vx = \"a - {k}*sign(vx) - {m}*sign(vx + vy)\"\nvy = \"b - {l}*sign(vy) - {m}*sign(vx + vy)\"\nw = \"0\""
                )),
                vec![Term::new(k, [x]), Term::new(l, [y]), Term::new(m, [vec![1.0, 1.0, 0.0]])],
            ),
            3 => (
                along(&format!(
                    "vx = \"a - {k}*sign(vx) - {m}*unit(vx, vy)\"\nvy = \"b - {l}*sign(vy) - {m}*unit(vy, vx)\"\nw = \"0\""
                )),
                vec![Term::new(k, [x.clone()]), Term::new(l, [y.clone()]), Term::new(m, [x, y])],
            ),
            4 => (
                along(&format!(
                    "vx = \"a - {k}*sign(vx) - {m}*unit(vx, vy)\"\nvy = \"b - {m}*unit(vy, vx)\"\nw = \"0.3*b - {l}*sign(w)\""
                )),
                vec![
                    Term::new(k, [x.clone()]), Term::new(m, [x, y]), Term::new(l, [vec![0.0, 0.0, 1.0]]),
                ],
            ),
            _ => (
                along(&format!(
                    "vx = \"a - {k}*unit(vx, vy) - {l}*4*vx/sqrt(4*vx^2 + vy^2) - {m}*sign(vx - vy)\"\n\
                     vy = \"b - {k}*unit(vy, vx) - {l}*vy/sqrt(4*vx^2 + vy^2) + {m}*sign(vx - vy)\"\nw = \"0\""
                )),
                vec![
                    Term::new(k, [x.clone(), y.clone()]),
                    Term::new(l, [vec![2.0, 0.0, 0.0], y]),
                    Term::new(m, [vec![1.0, -1.0, 0.0]]),
                ],
            ),
        };
        let push = match which { 1 => 0.5, 4 => 0.3, _ => 0.0 };
        let system = System::parse("sum.toml", &text).unwrap();
        let mut v = vec![v0[0], v0[1], if still { 0.0 } else { w0 }];
        let run = run(&system, &drive.inputs(), &v, 2.0);
        prop_assert!(run.outcome.is_finished(), "{which} {:?}", run.outcome);
        let (mut terms, steps) = (terms, 8000);
        let h = 2.0 / f64::from(steps);
        let mut worst = 0.0f64;
        for i in 0..steps {
            let t = h * f64::from(i);
            let [a, b] = drive.mean(t, h);
            let c = if which == 1 { push * a } else { push * b };
            v.iter_mut().zip([a, b, c]).for_each(|(v, a)| *v += h * a);
            rest_of_step(&mut v, h, &mut terms);
            if i % 40 == 39 {
                let x = run.trajectory.sample(t + h);
                worst = worst.max(x.iter().zip(&v).map(|(x, v)| (x - v).abs()).fold(0.0, f64::max));
            }
        }
        prop_assert!(worst < 60.0 * h, "{which} {worst:e}");
    }
}
