//! Initial states that the plan decides on, and states that end where they start.

use crate::common::reports::{close, read_with_model as read, run_with_found as run};
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng, rngs::StdRng};

/// x' = A x + B u with two states, the second one's start free; cost Σ dt (x₁² + x₂² + c·x₂ + r u²): the minimum of a quadratic function.
#[test]
fn of_a_linear_system_start_and_inputs_are_those_of_least_squares() {
    let mut random = StdRng::seed_from_u64(11);
    for case in 0..20 {
        let mut number = || (random.random_range(-1.0..1.0_f64) * 1e3).round() / 1e3;
        let (a, b) = (DMatrix::from_fn(2, 2, |_, _| number()), DVector::from_fn(2, |_, _| number()));
        let (c, r, first) = (number(), 0.1 + number().abs(), number());
        let (steps, dt) = (12, 0.1);
        let model = format!(
            "states = ['x1', 'x2']\ninputs = ['u']\n[dynamics]\nx1 = '{}*x1 + ({})*x2 + ({})*u'\nx2 = '{}*x1 + ({})*x2 + ({})*u'",
            a[(0, 0)],
            a[(0, 1)],
            b[0],
            a[(1, 0)],
            a[(1, 1)],
            b[1]
        );
        let text = format!(
            "horizon = {{ steps = {steps}, dt = {dt} }}\n\
             cost = {{ stage = 'x1^2 + x2^2 + ({c})*x2 + {r}*u^2' }}\n\
             run = {{ x0 = {{ x1 = {first}, x2 = {{ free = true, guess = 0 }} }} }}"
        );
        let (found, run) = run(&model, &text);

        // One step of the method of Runge and Kutta: the exponential series to fourth order.
        let z = &a * dt;
        let one = DMatrix::identity(2, 2);
        let integral = &one + &z / 2.0 + &z * &z / 6.0 + &z * &z * &z / 24.0;
        let (step, push) = (&one + &z * &integral, &integral * &b * dt);
        // States as functions of w = (start of x2, u_0, …).
        let mut map = DMatrix::zeros(2, 1 + steps);
        map[(1, 0)] = 1.0;
        let mut constant = DVector::from_row_slice(&[first, 0.0]);
        let (mut hessian, mut slope) = (DMatrix::zeros(1 + steps, 1 + steps), DVector::zeros(1 + steps));
        for k in 0..steps {
            hessian += map.tr_mul(&map) * (2.0 * dt);
            slope += map.tr_mul(&(&constant * 2.0 + DVector::from_row_slice(&[0.0, c]))) * dt;
            hessian[(1 + k, 1 + k)] += 2.0 * dt * r;
            map = &step * map;
            map.column_mut(1 + k).axpy(1.0, &push, 1.0);
            constant = &step * constant;
        }
        let w = -hessian.cholesky().unwrap().solve(&slope);
        close(found.initial_states.get("x2").copied().unwrap(), w[0], 1e-6);
        assert_eq!(found.initial_states.get("x1"), None, "{case}");
        close(run.closed_loop.u[0][0], w[1], 1e-5);
        close(run.closed_loop.x[0][1], w[0], 1e-6);
    }
}

/// x' = u − x follows cos(ωt) at the cost ρu² over one period: the best periodic answer is cos(ωt)/(1 + ρ(1 + ω²)).
#[test]
fn a_periodic_answer_is_the_harmonic_one() {
    for (omega, rho) in [(1.0, 0.1), (2.0, 0.3), (5.0, 0.02)] {
        let text = format!(
            "horizon = {{ steps = 120, dt = '2*pi/{omega}/120' }}\n\
             references = {{ r = 'cos({omega}*t)' }}\ncost = {{ stage = '(x - r)^2 + {rho}*u^2' }}\n\
             periodic = ['x']\nrun = {{ x0 = {{ x = {{ free = true, guess = 0 }} }} }}"
        );
        let (found, run) = run("states = ['x']\ninputs = ['u']\n[dynamics]\nx = 'u - x'", &text);
        let amplitude = 1.0 / (1.0 + rho * (1.0 + omega * omega));
        // Inputs are held for 1/120 of the period.
        close(found.initial_states.get("x").copied().unwrap(), amplitude, 2e-3);
        let x = &run.closed_loop.x;
        close(x[120][0], x[0][0], 1e-9);
        close(x[60][0], -amplitude, 2e-3);
        assert!(run.report.succeeded, "{:?}", run.report.notes);
    }
}

/// The limit cycle of van der Pol's oscillator: period and amplitude from the literature (μ = 1: 6.6632868593, 2.0086198609).
#[test]
fn a_limit_cycle_is_found_with_its_period() {
    let (found, run) = run(
        "states = ['x', 'v']\ninputs = ['u']\n[dynamics]\nx = 'v'\nv = '(1 - x^2)*v - x + u'",
        "horizon = { steps = 60, end_time = { free = true, guess = 6, min = 4, max = 9 } }\ncost = { stage = 'u^2' }\n\
         constraints = { u = { min = -1, max = 1 } }\nperiodic = ['x', 'v']\n\
         run = { x0 = { x = { free = true, min = 1, max = 3, guess = 1.7 }, v = 0 } }",
    );
    close(found.end_time.unwrap(), 6.663_286_859_3, 1e-4);
    close(found.initial_states.get("x").copied().unwrap(), 2.008_619_860_9, 1e-4);
    assert!(found.cost < 1e-12 && run.report.succeeded, "{found:?}");
}

/// Beside the start that is found, the same problem with that number costs more, whether the equations are smooth or switch.
#[test]
fn no_start_nearby_costs_less() {
    for (equation, tolerance) in [("u - x^3 + 0.5*sin(3*x)", 1e-6), ("u - 0.4*sign(v) - x", 1e-3)] {
        let model = format!("states = ['x', 'v']\ninputs = ['u']\n[dynamics]\nx = 'v'\nv = '{equation}'");
        let text = |start: &str| {
            format!(
                "horizon = {{ steps = 25, dt = 0.08 }}\ncost = {{ stage = '(x - 0.6)^2 + 0.1*v^2 + 0.05*u^2', terminal = '2*x^2' }}\n\
                 constraints = {{ u = {{ min = -3, max = 3 }} }}\nsolve = {{ method = 'plan', margin = 0, tolerance = 1e-8 }}\n\
                 run = {{ x0 = {{ x = 0.2, v = {start} }} }}"
            )
        };
        let (found, _) = run(&model, &text("{ free = true, min = -4, max = 4, guess = 0 }"));
        let best = found.initial_states.get("v").copied().unwrap();
        let cost = |v: f64| read(&model, &text(&v.to_string())).unwrap().plan().unwrap().cost;
        let at = cost(best);
        for by in [-0.2, 0.2] {
            assert!(cost(best + by) > at - tolerance, "{equation}: {best} {at} {}", cost(best + by));
        }
        assert!(cost(best - 0.2).max(cost(best + 0.2)) > at + 1e-4, "{equation}: the start matters");
    }
}

#[test]
fn a_start_keeps_its_range_and_the_bounds_of_its_state() {
    let model = "states = ['x', 'v']\ninputs = ['u']\n[dynamics]\nx = 'v'\nv = 'u'";
    for (range, bounds, expected) in [
        ("min = -0.2, max = 0.5,", "", 0.5),
        ("", "v = { max = 0.3, hard = true }", 0.3),
        ("max = 0.4,", "v = { max = 0.7 }", 0.4),
    ] {
        let text = format!(
            "horizon = {{ steps = 20, dt = 0.05 }}\ncost = {{ stage = 'u^2' }}\nconstraints = {{ {bounds} }}\n\
             target = {{ x = 1 }}\nrun = {{ x0 = {{ v = {{ free = true, {range} guess = 0 }} }} }}"
        );
        let (found, _) = run(model, &text);
        close(found.initial_states.get("v").copied().unwrap(), expected, 1e-6);
    }
}

#[test]
fn what_cannot_be_meant_is_refused() {
    let model = "states = ['x', 'v']\ninputs = ['u']\n[dynamics]\nx = 'v'\nv = 'u'";
    let head = "horizon = { steps = 20, dt = 0.05 }\ncost = { stage = 'u^2' }\n";
    for (rest, part) in [
        ("run = { x0 = { v = { free = true } } }", "`v` has no `guess`"),
        ("run = { x0 = { w = { free = true, guess = 0 } } }", "`w` is not a state of the model"),
        ("run = { x0 = { v = { guess = 0 } } }", "`v` is not free, but has a range"),
        ("run = { x0 = { v = { free = true, min = 1, max = 2, guess = 0 } } }", "does not lie between 1 and 2"),
        (
            "constraints = { v = { max = 1 } }\nrun = { x0 = { v = { free = true, min = 2, guess = 3 } } }",
            "leaves nothing of its bounds",
        ),
        (
            "solve = { method = 'rti' }\nrun = { x0 = { v = { free = true, guess = 0 } } }",
            "this method has a moving horizon",
        ),
        ("periodic = 'x'\nrun = {}", "`periodic` must be a list of states"),
        ("periodic = ['x', 'x']\nrun = {}", "`x` is listed twice"),
        ("periodic = ['y']\nrun = {}", "`y` is not a state of the model"),
        ("periodic = [1]\nrun = {}", "a name must be in quotes"),
        ("periodic = ['x']\ntarget = { x = 1 }\nrun = {}", "both say where it ends"),
    ] {
        let message = read(model, &format!("{head}{rest}")).err().map(|e| e.to_string()).unwrap_or_default();
        assert!(message.contains(part), "{rest}: {message}");
    }
}
