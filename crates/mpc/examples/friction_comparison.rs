//! Ways to control through dry friction, each judged on the exact stick–slip plant.
//!
//! `cargo run --release -p bracketry-mpc --example friction_comparison --features measure`
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use bracketry_mpc::closed_loop::{ClosedLoop, LoopSettings};
use bracketry_mpc::exact_friction::StickSlipSettings;
use bracketry_mpc::sqp::SqpController;
use bracketry_mpc::{
    Controller, CostFunction, CostKind, Ocp, PlannedTrajectory, Rti, RtiSettings, Sqp, SqpSettings,
    StickSlipController, SymbolicDynamics, run_closed_loop,
};
use bracketry_sim::{ExactPlant, SimulationSettings};
use bracketry_symbolic::Rational;
use bracketry_system::System;

/// A problem: its friction level is the parameter `mu`.
struct Case {
    name: &'static str,
    model: String,
    stage: String,
    terminal: Option<String>,
    bounds: Vec<(f64, f64)>,
    steps: usize,
    dt: f64,
    x0: Vec<f64>,
    samples: usize,
    /// State that counts and its target.
    target: (usize, f64),
}

impl Case {
    fn system(&self) -> System {
        System::parse(self.name, &self.model).unwrap()
    }

    fn ocp(&self) -> Ocp {
        let system = self.system();
        let mut ocp = Ocp::new(self.x0.len(), self.bounds.len(), self.steps, self.dt);
        ocp.stage = Some(CostFunction::parse(&system, CostKind::Stage, &[], &self.stage).unwrap());
        ocp.terminal =
            self.terminal.as_ref().map(|t| CostFunction::parse(&system, CostKind::Terminal, &[], t).unwrap());
        ocp.input_bounds.clone_from(&self.bounds);
        ocp
    }
}

/// A mass on a spring, with the input that holds it at its goal while it slides as the wanted one.
fn spring(name: &'static str, k: f64, c: f64, mu: f64, goal: f64) -> Case {
    Case {
        name,
        model: format!(
            "states = [\"x\", \"v\"]\ninputs = [\"u\"]\nparameters = {{ mu = {mu} }}\n\
             dynamics = {{ x = \"v\", v = \"-{k}*x - {c}*v + u - mu*sign(v)\" }}"
        ),
        stage: format!("(x - {goal})^2 + v^2 + 0.1*(u - {})^2", k * goal + mu),
        terminal: None,
        bounds: vec![(-2.0, 2.0)],
        steps: 20,
        dt: 0.15,
        x0: vec![0.0, 0.0],
        samples: 40,
        target: (0, goal),
    }
}

/// Springs with random stiffness, damping, friction, goal and start.
fn random_springs(count: usize) -> Vec<Case> {
    let mut seed = 5u64;
    let mut uniform = move |low: f64, high: f64| {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        low + (high - low) * (seed >> 11) as f64 / (1u64 << 53) as f64
    };
    (0..count)
        .map(|_| {
            let (k, mu) = (uniform(0.1, 2.0), uniform(0.05, 0.6));
            let goal = uniform(0.3, 0.9) * (2.0 - mu) / k;
            let mut case = spring("random springs", k, uniform(0.05, 1.0), mu, goal);
            case.x0 = vec![uniform(-0.5, 1.5) * goal, uniform(-0.5, 0.5)];
            case
        })
        .collect()
}

fn cases() -> Vec<Case> {
    let block = |name, x0: f64, end: Option<&str>| Case {
        name,
        model: "states = [\"x\", \"v\"]\ninputs = [\"u\"]\nparameters = { mu = 1 }\n\
                dynamics = { x = \"v\", v = \"u - mu*sign(v)\" }"
            .into(),
        stage: "x^2 + 0.1*v^2 + 0.001*u^2".into(),
        terminal: end.map(str::to_owned),
        bounds: vec![(-5.0, 5.0)],
        steps: 20,
        dt: 0.05,
        x0: vec![x0, 0.0],
        samples: 60,
        target: (0, 0.0),
    };
    vec![
        spring("spring-mass", 0.8, 0.5, 0.2, 2.0),
        spring("spring-mass, stiffer, more friction", 1.5, 0.3, 0.4, 0.9),
        spring("spring-mass, weak, light friction", 0.2, 0.1, 0.1, 1.0),
        block("block, from afar", -1.0, None),
        block("block, at rest 20 mm away", -0.02, None),
        block("block, at rest 20 mm away, the end weighs", -0.02, Some("50*x^2")),
        Case {
            name: "block on an incline",
            model: "states = [\"x\", \"v\"]\ninputs = [\"u\"]\nparameters = { mu = 0.3, g = 9.81 }\n\
                    dynamics = { x = \"v\", v = \"u - g*sin(0.2) - mu*g*cos(0.2)*sign(v)\" }"
                .into(),
            stage: "100*(x - 0.3)^2 + v^2 + 0.001*u^2".into(),
            terminal: None,
            bounds: vec![(-10.0, 10.0)],
            steps: 30,
            dt: 0.02,
            x0: vec![0.0, 0.0],
            samples: 100,
            target: (0, 0.3),
        },
        Case {
            name: "two blocks",
            model: "states = [\"p\", \"v\", \"q\", \"w\"]\ninputs = [\"u\"]\nparameters = { mu = 0.5 }\n\
                    dynamics = { p = \"v\", v = \"u + 20*(q - p) + (w - v) - mu*sign(v)\", \
                    q = \"w\", w = \"20*(p - q) + (v - w) - mu*sign(w)\" }"
                .into(),
            stage: "10*(q - 0.5)^2 + w^2 + 0.1*v^2 + 0.01*u^2".into(),
            terminal: None,
            bounds: vec![(-5.0, 5.0)],
            steps: 30,
            dt: 0.05,
            x0: vec![0.0; 4],
            samples: 100,
            target: (2, 0.5),
        },
        Case {
            name: "cart-pole, balance",
            model: cart_pole(),
            stage: "10*p^2 + 10*th^2 + 0.1*v^2 + 0.1*w^2 + 0.01*u^2".into(),
            terminal: Some("20*p^2 + 50*th^2 + 5*v^2 + 5*w^2".into()),
            bounds: vec![(-20.0, 20.0)],
            steps: 40,
            dt: 0.03,
            x0: vec![0.5, 0.1, 0.0, 0.0],
            samples: 150,
            target: (0, 0.0),
        },
        Case {
            name: "cart-pole, swing-up",
            model: cart_pole(),
            stage: "1e3*p^2 + 1e3*th^2 + 1e-2*v^2 + 1e-2*w^2 + 1e-2*u^2".into(),
            terminal: Some("1e3*p^2 + 1e3*th^2 + 1e-2*v^2 + 1e-2*w^2".into()),
            bounds: vec![(-80.0, 80.0)],
            steps: 40,
            dt: 0.02,
            x0: vec![0.0, std::f64::consts::PI, 0.0, 0.0],
            samples: 150,
            target: (1, 0.0),
        },
    ]
}

fn cart_pole() -> String {
    "states = [\"p\", \"th\", \"v\", \"w\"]\ninputs = [\"u\"]\nparameters = { mu = 2 }\n\
     definitions = { d = \"1.1 - 0.1*cos(th)^2\", f = \"u - mu*sign(v)\" }\n\
     dynamics = { p = \"v\", th = \"w\", v = \"(-0.08*sin(th)*w^2 + 0.981*cos(th)*sin(th) + f)/d\", \
     w = \"(-0.08*cos(th)*sin(th)*w^2 + f*cos(th) + 1.1*9.81*sin(th))/(0.8*d)\" }"
        .into()
}

/// A controller for a case whose model's friction is `factor` of the plant's.
type Maker = Box<dyn Fn(&Case, &System) -> Box<dyn Controller>>;

fn contenders() -> Vec<(String, Maker)> {
    let guess = |case: &Case| PlannedTrajectory::constant(case.steps, &case.x0, &vec![0.0; case.bounds.len()]);
    let mut list: Vec<(String, Maker)> = Vec::new();
    for width in [0.1, 0.01, 0.001] {
        list.push((
            format!("smoothed {width}, one program"),
            Box::new(move |case, system| {
                let dynamics = Box::new(SymbolicDynamics::new(system).unwrap());
                let settings = RtiSettings { smoothing: Some(width), ..RtiSettings::default() };
                let mut rti = Rti::new(dynamics, case.ocp(), guess(case), settings).unwrap();
                for _ in 0..30 {
                    rti.feedback(&case.x0).unwrap();
                }
                Box::new(rti)
            }),
        ));
    }
    for (name, widths) in
        [("0.1 to 0.01", vec![0.1, 0.03, 0.01]), ("0.1 to 0.001", vec![0.1, 0.03, 0.01, 0.003, 0.001])]
    {
        list.push((
            format!("smoothed {name}, converged"),
            Box::new(move |case, system| {
                let dynamics = Box::new(SymbolicDynamics::new(system).unwrap());
                let settings = SqpSettings { smoothing: widths.clone(), ..SqpSettings::default() };
                let sqp = Sqp::new(dynamics, case.ocp(), settings).unwrap();
                Box::new(SqpController::new(sqp, guess(case)))
            }),
        ));
    }
    for (name, iterations) in [("one program", 1), ("converged", 20)] {
        list.push((
            format!("exact flow, {name}"),
            Box::new(move |case, system| {
                let settings = StickSlipSettings { iterations, ..StickSlipSettings::default() };
                Box::new(StickSlipController::new(system, case.ocp(), guess(case), settings).unwrap())
            }),
        ));
    }
    list
}

fn run(case: &Case, make: &Maker, percent: i64) -> ClosedLoop {
    let plant = case.system();
    let mut model = case.system();
    let mu = model.parameters.iter().find(|p| model.symbol_name(p.symbol) == "mu").unwrap().value.clone();
    assert!(model.set_parameter("mu", mu * Rational::from_parts(percent.into(), 100u8.into())));
    let mut controller = make(case, &model);
    let mut plant = ExactPlant::new(&plant, &case.x0, &SimulationSettings::default()).unwrap();
    run_closed_loop(controller.as_mut(), &mut plant, &case.x0, case.samples, LoopSettings::default()).unwrap()
}

/// Costs of random problems relative to the lowest that any way reaches.
fn compare_on_random_springs() {
    let cases = random_springs(20);
    let runs: Vec<(String, Vec<ClosedLoop>)> = contenders()
        .into_iter()
        .map(|(name, make)| (name, cases.iter().map(|c| run(c, &make, 100)).collect()))
        .collect();
    let lowest: Vec<f64> =
        (0..cases.len()).map(|i| runs.iter().map(|(_, r)| r[i].cost).fold(f64::INFINITY, f64::min)).collect();
    println!("\n### {} random springs\n", cases.len());
    println!("| way | excess cost, mean | largest | end error, mean | ms median |");
    println!("|---|---|---|---|---|");
    for (name, runs) in &runs {
        let excess: Vec<f64> = runs.iter().zip(&lowest).map(|(r, l)| 100.0 * (r.cost / l - 1.0)).collect();
        let count = runs.len() as f64;
        let error =
            runs.iter().zip(&cases).map(|(r, c)| (r.x.last().unwrap()[0] - c.target.1).abs()).sum::<f64>() / count;
        println!(
            "| {name} | {:.4} % | {:.4} % | {error:.5} | {:.2} |",
            excess.iter().sum::<f64>() / count,
            excess.iter().copied().fold(0.0, f64::max),
            runs.iter().map(|r| r.times.median).sum::<f64>() / count,
        );
    }
}

fn main() {
    let only: Option<String> = std::env::args().nth(1);
    for case in cases().iter().filter(|c| only.as_ref().is_none_or(|o| c.name.contains(o.as_str()))) {
        println!("\n### {}\n", case.name);
        println!(
            "| way | cost | end error | swing at the end | ms median | ms longest | error, μ 20 % too low | 20 % too high |"
        );
        println!("|---|---|---|---|---|---|---|---|");
        for (name, make) in contenders() {
            let r = run(case, &make, 100);
            let (i, goal) = case.target;
            let error = |r: &ClosedLoop| (r.x.last().unwrap()[i] - goal).abs();
            let tail = &r.x[r.x.len() - r.x.len() / 5..];
            let (low, high) =
                tail.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |a, x| (a.0.min(x[i]), a.1.max(x[i])));
            println!(
                "| {name} | {:.5} | {:.5} | {:.5} | {:.2} | {:.2} | {:.5} | {:.5} |",
                r.cost,
                error(&r),
                high - low,
                r.times.median,
                r.times.max,
                error(&run(case, &make, 80)),
                error(&run(case, &make, 120)),
            );
        }
    }
    if only.is_none_or(|o| "random springs".contains(o.as_str())) {
        compare_on_random_springs();
    }
}
