//! The whole way of a model, for random ones: what it reaches, its affine form, simulation, diagnosis of its own data, the
//! extended model.
//!
//! Models are chains of carriages or of rotors on springs, with dampers, dry friction and gravity here and there, pushed at the
//! first by a function of the input. `BRACKETRY_CHAIN_CASES` sets how many are drawn (default 2), `BRACKETRY_CHAIN_SEED` the
//! first seed; with `--nocapture` the counts are printed.
#![allow(clippy::print_stdout)]

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::fmt::Write as _;

use bracketry::diagnose::{Cause, DiagnosisSettings, Record, RecordSettings, Report, Verdict, diagnose};
use bracketry::lie::{AnalysisOptions, Answer};
use bracketry::sim::{Hold, Inputs, Model, Samples, SimulationSettings, Trajectory, simulate};
use bracketry::system::{Affinization, Method, System};
use rand::rngs::StdRng;
use rand::seq::IndexedRandom;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};

/// Largest share of wrong diagnoses of either kind.
const MOST_WRONG: f64 = 0.05;
/// Seconds of a run.
const DURATION: f64 = 8.0;
/// Samples per second.
const RATE: f64 = 100.0;

/// How the force of the first body depends on the input.
const DRIVES: [&str; 5] = ["u", "u^3 + u", "sin(u)", "u*abs(u)", "2*tanh(u)"];

/// A chain of bodies.
struct Chain {
    bodies: usize,
    /// The model file.
    text: String,
    /// A hidden viscous coefficient and the equation it belongs to.
    hidden: (f64, usize),
}

impl Chain {
    fn draw(random: &mut StdRng) -> Self {
        let bodies = random.random_range(1..=3);
        let rotors = random.random_bool(0.5);
        let drive = *DRIVES.choose(random).unwrap();
        let both = bodies > 1 && random.random_bool(0.3);
        let mut between = |low: f64, high: f64| low * (high / low).powf(random.random::<f64>());
        let mut parameters = String::new();
        let mut dynamics = String::new();
        let inertias: Vec<f64> = (0..bodies).map(|_| between(0.5, 2.0)).collect();
        let stiffnesses: Vec<f64> = (0..bodies).map(|_| between(5.0, 40.0)).collect();
        let mut rough: Vec<f64> = (0..bodies).map(|_| between(0.05, 0.3)).collect();
        let dampings: Vec<f64> = (0..bodies).map(|_| between(0.1, 0.5)).collect();
        let weights: Vec<f64> = (0..bodies).map(|_| between(0.5, 3.0)).collect();
        for friction in &mut rough {
            if random.random_bool(0.5) {
                *friction = 0.0;
            }
        }
        for i in 0..bodies {
            writeln!(parameters, "m{i} = {:.4}\nk{i} = {:.4}", inertias[i], stiffnesses[i]).unwrap();
            // The first spring is fixed to the ground; dampers lie between bodies.
            let mut force = if i == 0 { "-k0*x0".to_owned() } else { format!("-k{i}*(x{i} - x{})", i - 1) };
            if i > 0 {
                writeln!(parameters, "d{i} = {:.4}", dampings[i]).unwrap();
                write!(force, " - d{i}*(v{i} - v{})", i - 1).unwrap();
            }
            if i + 1 < bodies {
                let next = i + 1;
                write!(force, " + k{next}*(x{next} - x{i}) + d{next}*(v{next} - v{i})").unwrap();
            }
            if rough[i] > 0.0 {
                writeln!(parameters, "F{i} = {:.4}", rough[i]).unwrap();
                write!(force, " - F{i}*sign(v{i})").unwrap();
            }
            if rotors && i + 1 == bodies {
                writeln!(parameters, "G = {:.4}", weights[i]).unwrap();
                write!(force, " - G*sin(x{i})").unwrap();
            }
            if i == 0 {
                write!(force, " + {drive}").unwrap();
            } else if both && i == 1 {
                force.push_str(" + cos(u)");
            }
            writeln!(dynamics, "x{i} = \"v{i}\"\nv{i} = \"({force})/m{i}\"").unwrap();
        }
        let names = |letter| (0..bodies).map(|i| format!("\"{letter}{i}\"")).collect::<Vec<_>>().join(", ");
        let text = format!(
            "name = \"chain\"\nstates = [{}, {}]\ninputs = [\"u\"]\n[parameters]\n{parameters}[dynamics]\n{dynamics}",
            names('x'),
            names('v'),
        );
        let at = random.random_range(0..bodies);
        let hidden = (random.random_range(0.4..1.0) * (inertias[at] * stiffnesses[at]).sqrt() * 0.3, at);
        Self { bodies, text, hidden }
    }

    fn system(&self) -> System {
        System::parse("chain.toml", &self.text).unwrap()
    }

    /// The same with the hidden term.
    fn truth(&self) -> System {
        let (strength, at) = self.hidden;
        let (head, tail) = self.text.split_once(&format!("v{at} = \"(")).unwrap();
        System::parse("truth.toml", &format!("{head}v{at} = \"(-{strength:.6}*v{at} {tail}")).unwrap()
    }
}

/// A smooth input: amplitude, frequency (Hz) and phase (rad) of its parts.
struct Excitation([[f64; 3]; 3]);

impl Excitation {
    fn draw(random: &mut StdRng) -> Self {
        let mut part = || [(0.4, 1.2), (0.1, 1.2), (0.0, 6.0)].map(|(low, high)| random.random_range(low..high));
        Self([part(), part(), part()])
    }

    fn at(&self, t: f64) -> f64 {
        self.0.iter().map(|[a, f, phase]| a * (TAU * f * t + phase).sin()).sum()
    }

    fn text(&self) -> String {
        self.0.map(|[a, f, phase]| format!("{a}*sin(2*pi*{f}*t + {phase})")).join(" + ")
    }
}

fn run(system: &System, inputs: &Inputs, x0: &[f64]) -> Trajectory {
    let done =
        simulate(Model::new(system, inputs).unwrap(), 0.0, x0, DURATION, &SimulationSettings::default()).unwrap();
    assert!(done.outcome.is_finished(), "{:?}", done.outcome);
    done.trajectory
}

/// The text with each occurrence of the name `u` replaced.
fn with_input(text: &str, u: &str) -> String {
    let word = |c: Option<char>| c.is_some_and(|c| c.is_alphanumeric() || c == '_');
    let mut out = String::new();
    for (i, c) in text.char_indices() {
        let alone = !word(text[..i].chars().next_back()) && !word(text[i + 1..].chars().next());
        if c == 'u' && alone { write!(out, "({u})").unwrap() } else { out.push(c) }
    }
    out
}

/// The affine model, driven so that the old inputs are `u(t)`, moves the old states as the original does.
fn moves_alike(original: &System, affinization: &Affinization, u: &str) {
    let mut affine = affinization.system.clone();
    let mut inputs = Inputs::new();
    let mut x0: BTreeMap<String, f64> = BTreeMap::new();
    let drive = affine.pool.parse(u).unwrap();
    let time = affine.pool.symbol("t");
    let mut derivative = drive;
    let mut rates = vec![derivative];
    for _ in 0..affinization.integrators.values().copied().max().unwrap_or(0) {
        derivative = affine.pool.diff(derivative, time);
        rates.push(derivative);
    }
    match affinization.method {
        Method::None => inputs = inputs.expression("u", u),
        Method::InputChange => {
            for v in &affinization.input_change {
                inputs = inputs.expression(&v.name, &with_input(&affine.pool.text(v.function), u));
            }
        }
        Method::InputAugmentation => {
            let order = affinization.integrators["u"] as usize;
            let origin = affine.pool.int(0);
            for (k, &rate) in rates.iter().enumerate() {
                let name = format!("u{}", "d".repeat(k));
                if k == order {
                    inputs = inputs.expression(&name, &affine.pool.text(rate));
                } else {
                    let now = affine.pool.at(rate, &[(time, origin)]).unwrap();
                    x0.insert(name, affine.value(now).unwrap());
                }
            }
        }
        other => panic!("{other:?} for {}", affinization.why),
    }
    let names = affine.state_names();
    let start: Vec<f64> = names.iter().map(|name| x0.get(name).copied().unwrap_or(0.0)).collect();
    let ours = run(&affine, &inputs, &start);
    let theirs = run(original, &Inputs::new().expression("u", u), &vec![0.0; original.states.len()]);
    for k in 0..=40 {
        let t = DURATION * f64::from(k) / 40.0;
        let (a, b) = (ours.sample(t), theirs.sample(t));
        for (i, name) in original.state_names().iter().enumerate() {
            let same = names.iter().position(|other| other == name).unwrap();
            assert!((a[same] - b[i]).abs() < 1e-5, "{name} at {t} s: {} and {}", a[same], b[i]);
        }
    }
}

/// What sensors tell of a run with sampled inputs: all positions and velocities.
fn record(plant: &System, u: &Excitation, bodies: usize, random: &mut StdRng) -> Record {
    let times: Vec<f64> = (0..=(DURATION * RATE) as usize).map(|k| k as f64 / RATE).collect();
    let commands: Vec<f64> = times.iter().map(|&t| u.at(t)).collect();
    let inputs = Inputs::new().samples("u", Samples::new(times.clone(), commands.clone(), Hold::Previous).unwrap());
    let moved = run(plant, &inputs, &vec![0.0; 2 * bodies]);
    let states: Vec<Vec<f64>> = times.iter().map(|&t| moved.sample(t)).collect();
    let mut columns = BTreeMap::from([("u".to_owned(), commands)]);
    for (i, name) in plant.state_names().into_iter().enumerate() {
        let noise = if i < bodies { 2e-4 } else { 2e-3 };
        let draw = |x: &Vec<f64>| {
            let e: f64 = StandardNormal.sample(random);
            x[i] + noise * e
        };
        columns.insert(name, states.iter().map(draw).collect());
    }
    Record::from_columns("run", times, columns, plant, &RecordSettings::default()).unwrap()
}

fn diagnosed(system: &System, record: Record) -> Report {
    diagnose(system, &[record], &[], &DiagnosisSettings::default(), &mut |_| {}).unwrap()
}

/// Whether the report says viscous friction, or cannot tell it from what it says, or names nothing.
fn viscous_or_silent(report: &Report) -> bool {
    report.verdict != Verdict::CauseFound
        || report.causes.iter().any(|cause| {
            matches!(cause.name, Cause::ViscousFriction | Cause::UnknownTerm)
                || cause.confusable_with.contains(&Cause::ViscousFriction)
        })
}

fn number(variable: &str, otherwise: u64) -> u64 {
    std::env::var(variable).ok().and_then(|text| text.parse().ok()).unwrap_or(otherwise)
}

#[test]
fn a_random_chain_goes_all_the_way() {
    let (cases, first) = (number("BRACKETRY_CHAIN_CASES", 2), number("BRACKETRY_CHAIN_SEED", 1));
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    let mut mistakes: BTreeMap<&str, u64> = BTreeMap::new();
    for seed in first..first + cases {
        let random = &mut StdRng::seed_from_u64(seed);
        let chain = Chain::draw(random);
        let system = chain.system();
        let u = Excitation::draw(random);

        // Pushed at one end, a chain of springs can be moved everywhere, and nowhere with fewer states than it has.
        let analysis = bracketry::analyze(&system, &AnalysisOptions::default()).unwrap();
        for mode in &analysis.report.modes {
            assert_eq!(mode.dimensions.strongly_accessible_dimension, Answer::Known(analysis.states), "{}", chain.text);
        }
        let affinization = system.affinize().unwrap();
        *counts.entry(format!("affine by {:?}", affinization.method)).or_default() += 1;
        moves_alike(&system, &affinization, &u.text());

        let own = diagnosed(&system, record(&system, &u, chain.bodies, random));
        *counts.entry(format!("own data: {:?} {:?}", own.verdict, named(&own))).or_default() += 1;

        let report = diagnosed(&system, record(&chain.truth(), &u, chain.bodies, random));
        *counts.entry(format!("hidden: {:?} {:?}", report.verdict, named(&report))).or_default() += 1;
        for (wrong, kind, report) in [
            (own.verdict != Verdict::NothingFound, "false alarm", &own),
            (!viscous_or_silent(&report), "wrong name", &report),
        ] {
            if wrong {
                *mistakes.entry(kind).or_default() += 1;
                println!("{kind}, seed {seed}: {:?}\n{}", named(report), chain.text);
            }
        }
        if let Some(extended) = &report.evidence.model {
            let text = extended.to_toml().unwrap();
            let again = System::parse("extended.toml", &text).unwrap();
            let start = vec![0.0; again.states.len()];
            run(&again, &Inputs::new().expression("u", &u.text()), &start);
        }
    }
    for (what, count) in counts {
        println!("{count:5} {what}");
    }
    for (kind, count) in mistakes {
        assert!(count as f64 <= MOST_WRONG * cases as f64, "{count} × {kind} in {cases} cases");
    }
}

fn named(report: &Report) -> Vec<Cause> {
    report.causes.iter().map(|cause| cause.name).collect()
}
