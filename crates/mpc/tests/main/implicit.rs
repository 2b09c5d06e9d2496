//! Control of models with mass matrices and algebraic variables: they are the same problems as those of the explicit models.

use approx::assert_relative_eq;
use bracketry_mpc::{ControlError, ControlProblem, Controlled, Dynamics, MpcError, SymbolicDynamics, control};
use bracketry_system::{Accepted, System};
use nalgebra::DMatrix;

use crate::common::dense;
use proptest::prelude::*;

const ACCEPTED: Accepted = Accepted { discrete: false, algebraic: true };

/// A problem on models by name.
fn problem(models: &[(&str, &str)], text: &str) -> Result<ControlProblem, String> {
    let read = |name: &str| {
        let model = models.iter().find(|m| m.0 == name).unwrap().1;
        System::parse_accepting(name, model, ACCEPTED).map_err(Box::new)
    };
    ControlProblem::parse("problem.toml", text, read).map_err(|e| e.to_string())
}

fn run(model: &str, text: &str) -> Controlled {
    control(&problem(&[("m", model)], text).unwrap()).unwrap()
}

/// A reactor whose equilibrium obeys exp(z) = 1 + x² + u², and the same solved by hand.
const IMPLICIT: &str = "states = ['x', 'y']\ninputs = ['u']\nparameters = { k = 0.5 }\n\
                        dynamics = { x = 'y - k*z', y = 'u - x*z + c' }\n\
                        [algebraic]\nz = { equation = 'exp(z) - 1 - x^2 - u^2', guess = 0.5 }\nc = 'c - 0.1*z*y'";
const EXPLICIT: &str = "states = ['x', 'y']\ninputs = ['u']\nparameters = { k = 0.5 }\n\
                        definitions = { z = 'log(1 + x^2 + u^2)' }\n\
                        dynamics = { x = 'y - k*z', y = 'u - x*z + 0.1*z*y' }";

proptest! {
    #![proptest_config(ProptestConfig { cases: 32, ..ProptestConfig::default() })]

    #[test]
    fn derivatives_follow_from_the_implicit_function_theorem(at in prop::collection::vec(-2.0f64..2.0, 3), w in prop::collection::vec(-1.0f64..1.0, 2)) {
        let system = System::parse_accepting("m", IMPLICIT, ACCEPTED).unwrap();
        let mut implicit = SymbolicDynamics::new(&system).unwrap();
        let mut explicit = SymbolicDynamics::new(&System::parse("m", EXPLICIT).unwrap()).unwrap();
        let evaluate = |d: &mut SymbolicDynamics| {
            let pattern = d.jacobian_pattern().to_vec();
            let (mut f, mut entries) = (vec![0.0; 2], vec![0.0; pattern.len()]);
            d.field_and_jacobian(0.0, &at[..2], &at[2..], &mut f, &mut entries);
            let mut jacobian = DMatrix::zeros(2, 3);
            pattern.iter().zip(&entries).for_each(|(&place, v)| jacobian[place] = *v);
            let places = d.second_derivatives().unwrap();
            let mut values = vec![0.0; places.len()];
            d.weighted_hessian(0.0, &at[..2], &at[2..], &w, &mut values);
            let mut hessian = DMatrix::zeros(3, 3);
            places.iter().zip(&values).for_each(|(&place, v)| hessian[place] = *v);
            let mut again = vec![0.0; 2];
            d.field(0.0, &at[..2], &at[2..], &mut again);
            f.iter().zip(&again).for_each(|(f, again)| assert_relative_eq!(f, again, epsilon = 1e-13));
            (DMatrix::from_vec(2, 1, f), jacobian, hessian)
        };
        let (a, b) = (evaluate(&mut implicit), evaluate(&mut explicit));
        for (a, b) in [(a.0, b.0), (a.1, b.1), (a.2, b.2)] {
            prop_assert!((&a - &b).amax() < 1e-10, "{a} {b}");
        }
    }
}

/// Two loops are the same.
fn same(a: &Controlled, b: &Controlled, tolerance: f64) {
    assert_relative_eq!(a.run.report.closed_loop_cost, b.run.report.closed_loop_cost, max_relative = tolerance);
    assert_relative_eq!(a.run.report.open_loop_cost, b.run.report.open_loop_cost, max_relative = tolerance);
    for (a, b) in a.run.closed_loop.x.iter().zip(&b.run.closed_loop.x) {
        a.iter().zip(b).for_each(|(a, b)| assert_relative_eq!(a, b, epsilon = 10.0 * tolerance));
    }
    assert_eq!(a.run.report.succeeded, b.run.report.succeeded);
}

#[test]
fn a_loop_with_a_nonlinear_equilibrium_is_that_of_the_solved_model() {
    for (integrator, method) in
        [("rk4", "'rti'"), ("rk4", "'sqp', hessian = 'exact'"), ("radau", "'plan'"), ("radau", "'sqp'")]
    {
        let text = format!(
            "model = 'm'\nhorizon = {{ steps = 15, dt = 0.1, integrator = '{integrator}' }}\nsolve = {{ method = {method} }}\n\
             cost = {{ stage = '(x - 0.5)^2 + y^2 + 0.1*u^2' }}\nconstraints = {{ u = {{ min = -1.5, max = 1.5 }} }}\n\
             run = {{ x0 = {{ x = 1.5, y = -1 }}, steps = 20 }}"
        );
        let (implicit, explicit) = (run(IMPLICIT, &text), run(EXPLICIT, &text));
        same(&implicit, &explicit, 1e-6);
        let ends = [&implicit, &explicit].map(|run| run.recording.trajectory.final_state().to_vec());
        ends[0].iter().zip(&ends[1]).for_each(|(a, b)| assert_relative_eq!(a, b, epsilon = 1e-5));
        assert!(implicit.run.report.notes.iter().any(|note| note.to_string().contains("`c` is eliminated")));
    }
}

#[test]
fn a_cart_by_its_mass_matrix_is_controlled_as_by_its_explicit_equations() {
    let mass = "states = ['x', 'th', 'v', 'w']\ninputs = ['F']\n\
                mass = { states = ['v', 'w'], matrix = [['1.3 + 0.4', '0.28*cos(th)'], ['0.28*cos(th)', '0.196']] }\n\
                dynamics = { x = 'v', th = 'w', v = 'F + 0.28*w^2*sin(th)', w = '0.28*9.81*sin(th)' }";
    let explicit = "states = ['x', 'th', 'v', 'w']\ninputs = ['F']\n\
                    definitions = { a = '(F + 0.28*w^2*sin(th) - 0.4*9.81*sin(th)*cos(th))/(1.3 + 0.4*sin(th)^2)' }\n\
                    dynamics = { x = 'v', th = 'w', v = 'a', w = '(9.81*sin(th) - cos(th)*a)/0.7' }";
    let text = "model = 'm'\nhorizon = { steps = 20, dt = 0.05 }\ncost = { stage = 'x^2 + 5*th^2 + 0.1*v^2 + 0.1*w^2 + 0.01*F^2' }\n\
                constraints = { F = { min = -10, max = 10 } }\nsolve = { method = 'sqp' }\nrun = { x0 = { x = 0.5, th = 0.2 }, steps = 20 }";
    same(&run(mass, text), &run(explicit, text), 1e-6);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 6, ..ProptestConfig::default() })]

    /// M x' = A x + B z + u, 0 = C x + D z + u: x' = M⁻¹((A − B D⁻¹ C) x + (1 − B D⁻¹) u).
    #[test]
    fn a_linear_system_with_mass_matrix_and_algebraic_variables_costs_as_its_ordinary_one(
        e in prop::collection::vec(-1.0f64..1.0, 20),
        x0 in prop::collection::vec(-1.0f64..1.0, 2),
    ) {
        let identity = DMatrix::<f64>::identity(2, 2);
        let m = dense([[e[0], e[1]], [e[2], e[3]]]) + &identity * 3.0;
        let a = dense([[e[4], e[5]], [e[6], e[7]]]);
        let b = dense([[e[8], e[9]], [e[10], e[11]]]);
        let c = dense([[e[12], e[13]], [e[14], e[15]]]);
        let d = dense([[e[16], e[17]], [e[18], e[19]]]) + &identity * 3.0;
        let sum = |row: usize, parts: &[(&DMatrix<f64>, [&str; 2])]| {
            let terms = parts.iter().flat_map(|(matrix, names)| (0..2).map(move |j| format!("({:?})*{}", matrix[(row, j)], names[j])));
            terms.collect::<Vec<_>>().join(" + ")
        };
        let f = |i| sum(i, &[(&a, ["x", "y"]), (&b, ["z", "w"])]);
        let g = |i| sum(i, &[(&c, ["x", "y"]), (&d, ["z", "w"])]);
        let implicit = format!(
            "states = ['x', 'y']\ninputs = ['u']\nmass = [[{:?}, {:?}], [{:?}, {:?}]]\ndynamics = {{ x = '{} + u', y = '{} + u' }}\n\
             algebraic = {{ z = '{} + u', w = '{} + u' }}",
            m[(0, 0)], m[(0, 1)], m[(1, 0)], m[(1, 1)], f(0), f(1), g(0), g(1)
        );
        let (inverse, solved) = (m.try_inverse().unwrap(), &b * d.try_inverse().unwrap());
        let drift = &inverse * (&a - &solved * &c);
        let ones = DMatrix::from_element(2, 1, 1.0);
        let input = &inverse * (&ones - &solved * &ones);
        let row = |i| format!("{} + ({:?})*u", sum(i, &[(&drift, ["x", "y"])]), input[(i, 0)]);
        let ordinary = format!("states = ['x', 'y']\ninputs = ['u']\ndynamics = {{ x = '{}', y = '{}' }}", row(0), row(1));
        let text = format!(
            "model = 'm'\nhorizon = {{ steps = 10, dt = 0.2 }}\ncost = {{ stage = 'x^2 + y^2 + 0.1*u^2' }}\nsolve = {{ method = 'sqp' }}\n\
             constraints = {{ u = {{ min = -0.5, max = 0.5 }} }}\nrun = {{ x0 = {{ x = {:?}, y = {:?} }}, steps = 10 }}",
            x0[0], x0[1]
        );
        let (one, other) = (run(&implicit, &text), run(&ordinary, &text));
        prop_assert!((one.run.report.closed_loop_cost - other.run.report.closed_loop_cost).abs() < 1e-6);
        for (one, other) in one.run.closed_loop.x.iter().zip(&other.run.closed_loop.x) {
            prop_assert!(one.iter().zip(other).all(|(a, b)| (a - b).abs() < 1e-5));
        }
    }
}

#[test]
fn what_cannot_treat_algebraic_variables_says_so() {
    let with = |stage: &str, rest: &str| {
        format!("model = 'm'\nhorizon = {{ steps = 5, dt = 0.1 }}\ncost = {{ stage = '{stage}' }}\n{rest}\nrun = {{}}")
    };
    for (text, said) in [
        (with("x^2 + z^2", ""), "unknown name `z`"),
        (with("x^2", "estimation = { kind = 'ekf', outputs = { x = 0.1 } }"), "estimators"),
        (with("x^2", "solve = { method = 'stick-slip' }"), "stick-slip"),
    ] {
        let error = problem(&[("m", IMPLICIT)], &text).err().unwrap();
        assert!(error.contains(said) && error.contains("problem.toml:"), "{error}");
    }
    // What is eliminated may stand in costs.
    let eliminated = "states = ['x']\ninputs = ['u']\ndynamics = { x = 'z' }\nalgebraic = { z = '2*z + x - u' }";
    assert!(problem(&[("m", eliminated)], &with("x^2 + z^2", "")).is_ok());
}

#[test]
fn a_plant_without_a_solution_stops_with_the_equation_and_the_time() {
    let models = [
        ("m", "states = ['x']\ninputs = ['u']\ndynamics = { x = 'u' }"),
        (
            "p",
            "states = ['x']\ninputs = ['u']\ndynamics = { x = 'u - 1 - z' }\nalgebraic = { z = { equation = 'z^2 - x', guess = 1 } }",
        ),
    ];
    let text = "model = 'm'\nplant = 'p'\nhorizon = { steps = 5, dt = 0.1 }\ncost = { stage = 'u^2 + 1e-6*x^2' }\n\
                solve = { method = 'rti' }\nrun = { x0 = { x = 1 }, steps = 30 }";
    let error = control(&problem(&models, text).unwrap()).unwrap_err();
    let ControlError::Mpc(MpcError::Plant { time, source }) = &error else { panic!("{error}") };
    // 2 (1 − ln 2) = 0.614 s, see the simulation of the same fold.
    assert!((0.5..0.7).contains(time), "{error}");
    assert!(source.to_string().contains("equation 1"), "{error}");
}
