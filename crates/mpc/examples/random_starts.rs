//! Counts programs and successes of the solution method over random starts of several problems.
//!
//! `cargo run --release -p bracketry-mpc --example random_starts --features measure [STARTS] [PROBLEM] [--exact]`
#![allow(clippy::print_stdout, clippy::format_push_string)]

use bracketry_mpc::ocp::{Bounds, Softness, Substeps};
use bracketry_mpc::problem::Method;
use bracketry_mpc::sqp::Hessian;
use bracketry_mpc::{
    ControlProblem, CostFunction, CostKind, Integrator, MpcError, Ocp, PlannedTrajectory, SolveStatus, Sqp,
    SqpSettings, SymbolicDynamics,
};
use bracketry_system::System;
use std::f64::consts::PI;

/// A problem with the box that its starts are drawn from.
struct Case {
    name: &'static str,
    system: System,
    ocp: Ocp,
    low: Vec<f64>,
    high: Vec<f64>,
    input: Vec<f64>,
    smoothing: Vec<f64>,
}

type Failure = Box<dyn std::error::Error>;

/// Uniform numbers in [0, 1): a linear congruential generator (Knuth's MMIX).
struct Uniform(u64);

impl Uniform {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

#[allow(clippy::too_many_arguments)]
fn case(
    name: &'static str,
    model: &str,
    (steps, dt): (usize, f64),
    (stage, terminal): (&str, &str),
    inputs: &[(f64, f64)],
    low: &[f64],
    high: &[f64],
    input: &[f64],
) -> Result<Case, Failure> {
    let system = System::parse(name, model)?;
    let mut ocp = Ocp::new(system.states.len(), system.inputs.len(), steps, dt);
    ocp.stage = Some(CostFunction::parse(&system, CostKind::Stage, &[], stage)?);
    ocp.terminal = Some(CostFunction::parse(&system, CostKind::Terminal, &[], terminal)?);
    ocp.input_bounds = inputs.to_vec();
    ocp.input_trust = inputs.iter().map(|b| (b.1 - b.0) / 2.0).collect();
    Ok(Case { name, system, ocp, low: low.to_vec(), high: high.to_vec(), input: input.to_vec(), smoothing: vec![] })
}

const CART_POLE: &str = r#"
    states = ["p", "th", "v", "w"]
    inputs = ["u"]
    parameters = { M = 1, m = 0.1, l = 0.8, g = 9.81, c = FRICTION }
    dynamics = { p = "v", th = "w", v = "(-m*l*sin(th)*w^2 + m*g*cos(th)*sin(th) + u - c*sign(v))/(M + m - m*cos(th)^2)", w = "(-m*l*cos(th)*sin(th)*w^2 + (u - c*sign(v))*cos(th) + (M + m)*g*sin(th))/(l*(M + m - m*cos(th)^2))" }
"#;

fn cart_pole(name: &'static str, friction: &str) -> Result<Case, Failure> {
    let mut c = case(
        name,
        &CART_POLE.replace("FRICTION", friction),
        (40, 0.02),
        ("1e3*p^2 + 1e3*th^2 + 1e-2*v^2 + 1e-2*w^2 + 1e-2*u^2", "1e3*p^2 + 1e3*th^2 + 1e-2*v^2 + 1e-2*w^2"),
        &[(-80.0, 80.0)],
        &[-1.0, -PI, -1.0, -1.0],
        &[1.0, PI, 1.0, 1.0],
        &[0.0],
    )?;
    c.ocp.substeps = Substeps::AtLeast(1);
    Ok(c)
}

fn chain(masses: usize) -> Result<Case, Failure> {
    // Point masses in a vertical plane between a fixed point and a driven end: springs of rest length 0.033, gravity.
    let (stiffness, mass, rest) = (1.0, 0.03, 0.033);
    let mut states = Vec::new();
    for i in 1..=masses {
        states.extend([format!("x{i}"), format!("y{i}")]);
    }
    states.extend(["ex".into(), "ey".into()]);
    for i in 1..=masses {
        states.extend([format!("vx{i}"), format!("vy{i}")]);
    }
    let end = masses + 1;
    let place = |i: usize, axis: &str| match i {
        0 => "0".to_owned(),
        i if i == end => format!("e{axis}"),
        i => format!("{axis}{i}"),
    };
    let force = |i: usize, axis: &str| {
        let (dx, dy) = (
            format!("({} - {})", place(i + 1, "x"), place(i, "x")),
            format!("({} - {})", place(i + 1, "y"), place(i, "y")),
        );
        let d = if axis == "x" { &dx } else { &dy };
        format!("{stiffness}*(1 - {rest}/sqrt({dx}^2 + {dy}^2))*{d}")
    };
    let mut rows = vec!["ex = \"ux\"".to_owned(), "ey = \"uy\"".to_owned()];
    for i in 1..=masses {
        for (axis, weight) in [("x", ""), ("y", " - 9.81")] {
            rows.push(format!("{axis}{i} = \"v{axis}{i}\""));
            rows.push(format!("v{axis}{i} = \"({} - {})/{mass}{weight}\"", force(i, axis), force(i - 1, axis)));
        }
    }
    let model = format!("states = {states:?}\ninputs = [\"ux\", \"uy\"]\ndynamics = {{ {} }}", rows.join(", "));
    let mut stage = "25*((ex - 1)^2 + ey^2) + 0.1*(ux^2 + uy^2)".to_owned();
    let mut terminal = "25*((ex - 1)^2 + ey^2)".to_owned();
    for i in 1..=masses {
        stage += &format!(" + vx{i}^2 + vy{i}^2");
        terminal += &format!(" + vx{i}^2 + vy{i}^2");
    }
    let (mut low, mut high) = (Vec::new(), Vec::new());
    for i in 1..=masses {
        let x = i as f64 / end as f64;
        low.extend([x - 0.15, -0.5]);
        high.extend([x + 0.15, 0.2]);
    }
    low.extend([0.6, -0.4]);
    high.extend([1.2, 0.4]);
    low.extend(vec![-1.0; 2 * masses]);
    high.extend(vec![1.0; 2 * masses]);
    let mut c =
        case("chain of masses", &model, (20, 0.1), (&stage, &terminal), &[(-1.0, 1.0); 2], &low, &high, &[0.0, 0.0])?;
    c.ocp.substeps = Substeps::Fixed(2);
    Ok(c)
}

fn cases() -> Result<Vec<Case>, Failure> {
    let mut list = vec![cart_pole("cart-pole", "0")?];
    let mut c = case(
        "Van der Pol",
        r#"
        states = ["x", "v"]
        inputs = ["u"]
        dynamics = { x = "(1 - v^2)*x - v + u", v = "x" }
        "#,
        (40, 0.25),
        ("x^2 + v^2 + u^2", "10*(x^2 + v^2)"),
        &[(-1.0, 1.0)],
        &[-1.0, -2.0],
        &[2.0, 2.0],
        &[0.0],
    )?;
    c.ocp.state_bounds[0] = Bounds { min: -0.4, max: f64::INFINITY, softness: Softness::Hard };
    list.push(c);
    let mut c = case(
        "stirred-tank reactor",
        r#"
        states = ["c", "T"]
        inputs = ["Tc"]
        dynamics = { c = "1 - c - 7.2e10*exp(-8750/T)*c", T = "350 - T + 209.2050209*7.2e10*exp(-8750/T)*c + 2.092050209*(Tc - T)" }
        "#,
        (40, 0.05),
        ("100*(c - 0.5)^2 + 0.01*(T - 350)^2 + 1e-3*(Tc - 300)^2", "100*(c - 0.5)^2 + 0.01*(T - 350)^2"),
        &[(280.0, 370.0)],
        &[0.1, 310.0],
        &[1.0, 400.0],
        &[300.0],
    )?;
    c.ocp.integrator = Integrator::RadauIIA { stages: 2 };
    list.push(c);
    list.push(case(
        "quadrotor",
        r#"
        states = ["x", "y", "a", "vx", "vy", "w"]
        inputs = ["f1", "f2"]
        dynamics = { x = "vx", y = "vy", a = "w", vx = "-(f1 + f2)*sin(a)", vy = "(f1 + f2)*cos(a) - 9.81", w = "20*(f1 - f2)" }
        "#,
        (40, 0.05),
        ("10*(x^2 + y^2) + a^2 + 0.1*(vx^2 + vy^2 + w^2) + 0.01*((f1 - 4.905)^2 + (f2 - 4.905)^2)", "50*(x^2 + y^2) + 10*a^2 + 5*(vx^2 + vy^2) + w^2"),
        &[(0.0, 12.0), (0.0, 12.0)],
        &[-3.0, -3.0, -PI, -2.0, -2.0, -3.0],
        &[3.0, 3.0, PI, 2.0, 2.0, 3.0],
        &[4.905, 4.905],
    )?);
    list.push(chain(4)?);
    let mut c = case(
        "spring-mass, dry friction",
        r#"
        states = ["x", "v"]
        inputs = ["u"]
        dynamics = { x = "v", v = "-0.8*x - 0.5*v + u - 0.2*sign(v)" }
        "#,
        (20, 0.15),
        ("(x - 2)^2 + v^2 + 0.1*(u - 1.8)^2", "(x - 2)^2 + v^2"),
        &[(-2.0, 2.0)],
        &[-2.0, -2.0],
        &[3.0, 2.0],
        &[0.0],
    )?;
    c.smoothing = vec![0.1, 0.03, 0.01];
    c.ocp.state_trust[1] = 0.1;
    list.push(c);
    let mut c = cart_pole("cart-pole, dry friction", "2")?;
    c.smoothing = vec![0.3, 0.1, 0.03];
    c.ocp.state_trust[2] = 0.5;
    list.push(c);
    Ok(list)
}

/// Programs and cost of one start; `None` where it failed.
struct Outcome {
    converged: bool,
    programs: usize,
    cost: f64,
    status: SolveStatus,
}

fn report(name: &str, outcomes: &[Outcome], verbose: bool) {
    let mut programs: Vec<usize> = outcomes.iter().map(|o| o.programs).collect();
    programs.sort_unstable();
    let converged = outcomes.iter().filter(|o| o.converged).count();
    let mut costs: Vec<f64> = outcomes.iter().filter(|o| o.converged).map(|o| o.cost).collect();
    costs.sort_by(f64::total_cmp);
    let mean = costs.iter().sum::<f64>() / costs.len().max(1) as f64;
    println!(
        "{name:26} {converged:3}/{:3} converged, programs: median {:3}, mean {:5.1}, most {:3}; mean cost {mean:.5}",
        outcomes.len(),
        programs[programs.len() / 2],
        programs.iter().sum::<usize>() as f64 / programs.len() as f64,
        programs[programs.len() - 1],
    );
    let mut failures = std::collections::BTreeMap::new();
    for o in outcomes.iter().filter(|o| !o.converged) {
        *failures.entry(o.status.to_string()).or_insert(0) += 1;
    }
    for (status, count) in failures {
        println!("    {count:3} {status}");
    }
    if verbose {
        for o in outcomes {
            println!("    {:4} {:?} {:.6}", o.programs, o.status, o.cost);
        }
    }
}

fn solve(sqp: &mut Sqp, x0: &[f64], guess: &PlannedTrajectory) -> Result<Outcome, MpcError> {
    let s = sqp.solve(x0, guess)?;
    let converged = matches!(s.status, SolveStatus::Converged | SolveStatus::Infeasible { .. });
    Ok(Outcome { converged, programs: s.iterations.len(), cost: s.cost, status: s.status })
}

/// Moves of the plate between random places.
fn plate(starts: usize, hessian: Hessian, random: &mut Uniform) -> Result<Vec<Outcome>, Failure> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../models/plate_move.toml");
    let mut outcomes = Vec::new();
    for _ in 0..starts {
        let mut p = ControlProblem::read(path)?;
        if let Method::Plan { convergence, .. } = &mut p.method {
            convergence.hessian = hessian;
        }
        for i in 0..3 {
            let reach = [0.1, 0.1, PI][i];
            p.x0[i] = reach * (2.0 * random.next() - 1.0);
            p.ocp.targets[i].value = reach * (2.0 * random.next() - 1.0);
        }
        let s = p.plan()?;
        let cost = s.cost
            + s.miss.iter().zip(&p.ocp.targets).map(|(e, t)| t.linear * e.abs() + t.quadratic * e * e).sum::<f64>();
        let converged = s.status == SolveStatus::Converged;
        outcomes.push(Outcome { converged, programs: s.iterations.len(), cost, status: s.status });
    }
    Ok(outcomes)
}

fn main() -> Result<(), Failure> {
    let exact = std::env::args().any(|a| a == "--exact");
    let hessian = if exact { Hessian::Exact } else { Hessian::Automatic };
    let mut arguments = std::env::args().skip(1).filter(|a| a != "--exact");
    let starts: usize = arguments.next().map_or(Ok(30), |a| a.parse())?;
    let only = arguments.next();
    let chosen = |name: &str| only.as_ref().is_none_or(|o| o == name);
    for c in cases()?.into_iter().filter(|c| chosen(c.name)) {
        let settings = SqpSettings { smoothing: c.smoothing.clone(), hessian, ..SqpSettings::default() };
        let mut sqp = Sqp::new(Box::new(SymbolicDynamics::new(&c.system)?), c.ocp.clone(), settings)?;
        let mut random = Uniform(1);
        let mut outcomes = Vec::new();
        for _ in 0..starts {
            let x0: Vec<f64> = c.low.iter().zip(&c.high).map(|(a, b)| a + (b - a) * random.next()).collect();
            let guess = PlannedTrajectory::constant(c.ocp.steps, &x0, &c.input);
            outcomes.push(solve(&mut sqp, &x0, &guess)?);
        }
        report(c.name, &outcomes, only.is_some());
    }
    if chosen("plate") {
        report("plate", &plate(starts.div_ceil(5), hessian, &mut Uniform(1))?, only.is_some());
    }
    Ok(())
}
