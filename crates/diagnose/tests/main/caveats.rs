//! What speaks against a verdict is said: inputs that go on otherwise between samples, other units and signs, runs for validation that
//! are not predicted, data without motion, dead sensors, another time.

use crate::tier;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

use bracketry_diagnose::{
    Cause, Caveat, ColumnFault, DiagnoseError, DiagnosisSettings, Flag, NoMotion, Note, Outcome, Record,
    RecordSettings, Report, Rescaling, ScaledColumn, Verdict, diagnose,
};
use bracketry_sim::Hold;
use bracketry_system::System;
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, Normal};

/// The spring as the model has it.
const SPRING: &str = r#"
    states = ["x", "v"]
    inputs = ["F"]
    parameters = { m = 1.0, k = 20.0, c = 0.5 }
    dynamics = { x = "v", v = "(F - k*x - c*v)/m" }
"#;
/// Time between samples, s.
pub(crate) const STEP: f64 = 0.01;
/// Steps of the integration between samples.
const SUB: usize = 20;

pub(crate) fn spring() -> System {
    System::parse("spring.toml", SPRING).unwrap()
}

/// How a run of a spring was made.
#[derive(Clone, Copy)]
struct Run {
    seed: u64,
    /// Mass, kg.
    mass: f64,
    /// Whether the force was held from one sample to the next; else it is smooth.
    held: bool,
    /// Whether the velocity was measured.
    velocity: bool,
    /// Standard deviation of the noise over the size of the column.
    noise: f64,
    /// Quadratic drag, which the model lacks, kg/m.
    drag: f64,
}

const RUN: Run = Run { seed: 1, mass: 1.03, held: true, velocity: true, noise: 0.01, drag: 0.0 };

impl Run {
    /// Eight seconds of `m x'' = F − 20 x − 0.5 x' − drag |x'| x'` by Runge–Kutta steps of fourth order.
    fn columns(self) -> BTreeMap<String, Vec<f64>> {
        let mut random = StdRng::seed_from_u64(self.seed);
        let lines: Vec<(f64, f64)> =
            (0..12).map(|_| (random.random_range(0.2..2.5), random.random_range(0.0..TAU))).collect();
        let force = |t: f64| lines.iter().map(|(f, p)| (TAU * f * t + p).sin()).sum::<f64>() * 1.6;
        let samples = 800;
        let (mut x, mut v) = (0.1, 0.0);
        let mut columns = BTreeMap::from(["t", "F", "x", "v"].map(|name| (name.to_owned(), Vec::new())));
        for k in 0..samples {
            let t = k as f64 * STEP;
            for (name, value) in [("t", t), ("F", force(t)), ("x", x), ("v", v)] {
                columns.get_mut(name).unwrap().push(value);
            }
            let h = STEP / SUB as f64;
            for i in 0..SUB {
                let at = |share: f64| if self.held { force(t) } else { force(t + (i as f64 + share) * h) };
                let rate = |x: &[f64; 2], share: f64| {
                    [x[1], (at(share) - 20.0 * x[0] - (0.5 + self.drag * x[1].abs()) * x[1]) / self.mass]
                };
                [x, v] = crate::integrate::step(rate, &[x, v], h);
            }
        }
        if !self.velocity {
            columns.remove("v");
        }
        for name in ["x", "v"] {
            let Some(values) = columns.get_mut(name) else { continue };
            let size = (values.iter().map(|v| v * v).sum::<f64>() / samples as f64).sqrt();
            let noise = Normal::new(0.0, self.noise * size).unwrap();
            for v in values.iter_mut() {
                *v += noise.sample(&mut random);
            }
        }
        columns
    }

    fn record(self) -> Record {
        read(self.columns(), None).unwrap()
    }
}

fn read(mut columns: BTreeMap<String, Vec<f64>>, hold: Option<Hold>) -> Result<Record, DiagnoseError> {
    let times = columns.remove("t").unwrap();
    let settings = RecordSettings { hold, ..RecordSettings::default() };
    Record::from_columns("run.csv", times, columns, &spring(), &settings)
}

/// A run with one column times a factor.
fn times(run: Run, column: &str, factor: f64) -> Record {
    let mut columns = run.columns();
    columns.get_mut(column).unwrap().iter_mut().for_each(|v| *v *= factor);
    read(columns, None).unwrap()
}

fn verdict(record: Record, validate: &[Record]) -> Report {
    diagnose(&spring(), &[record], validate, &DiagnosisSettings::default(), &mut |_| {}).unwrap()
}

/// By which hold between samples the model explains the data without a cause.
fn other_hold(report: &Report) -> Option<Hold> {
    report.reason.caveats.iter().find_map(|caveat| match caveat {
        Caveat::OtherHold(other) => Some(other.hold),
        _ => None,
    })
}

fn has_curves(report: &Report) -> bool {
    report.notes.iter().any(|note| matches!(note, Note::Curves(_)))
}

fn is_mispredicted(report: &Report) -> bool {
    report.reason.caveats.iter().any(|caveat| matches!(caveat, Caveat::Mispredicted(_)))
}

#[test]
fn a_smooth_input_that_is_read_as_held_is_told_from_a_cause() {
    let report = verdict(Run { held: false, ..RUN }.record(), &[]);
    assert!(other_hold(&report) == Some(Hold::Linear), "{report:?}");
    assert_eq!(report.verdict, Verdict::Unexplained, "{report:?}");
    let held = verdict(RUN.record(), &[]);
    assert_eq!(held.verdict, Verdict::NothingFound, "{held:?}");
    assert!(other_hold(&held).is_none(), "{held:?}");
}

#[test]
fn a_held_input_that_is_read_as_straight_lines_is_told_from_a_delay() {
    let report = verdict(read(RUN.columns(), Some(Hold::Linear)).unwrap(), &[]);
    assert!(other_hold(&report) == Some(Hold::Previous), "{report:?}");
    for cause in &report.causes {
        assert!(cause.flags.contains(&Flag::HalfSample { lines: true }), "{report:?}");
    }
}

#[test]
fn data_without_noise_show_what_is_missing_and_nothing_else() {
    let smooth = Run { held: false, noise: 0.0, ..RUN };
    let straight = |run: Run| verdict(read(run.columns(), Some(Hold::Linear)).unwrap(), &[]);
    let right = straight(smooth);
    assert_eq!(right.verdict, Verdict::NothingFound, "{right:?}");
    assert!(has_curves(&right), "{right:?}");
    let dragged = straight(Run { drag: 0.3, ..smooth });
    let named: Vec<Cause> = dragged.causes.iter().map(|c| c.name).collect();
    assert_eq!(named, [Cause::QuadraticDrag], "{dragged:?}");
    let (_, drag) = &dragged.causes[0].parameters[0];
    assert!((drag.value - 0.3).abs() < 1e-4, "{dragged:?}");
    // Beside noise, what lines cut off at the bends does not matter.
    let noisy = straight(Run { held: false, ..RUN });
    assert_eq!(noisy.verdict, Verdict::NothingFound, "{noisy:?}");
    assert!(!has_curves(&noisy), "{noisy:?}");
}

/// What is wrong with the columns is the verdict, with what the columns are to be, and is found without a search for causes.
#[test]
fn columns_that_are_read_wrongly_are_the_verdict() {
    let scaled = |column: &str, by| ColumnFault::Scaled { columns: ScaledColumn::Column(column.to_owned()), by };
    let (x, v, force) = ("x".to_owned(), "v".to_owned(), "F".to_owned());
    let unseen = Run { velocity: false, ..RUN };
    let mut cases: Vec<(Record, Verdict, ColumnFault)> = Vec::new();
    // The unit of a column is times its factor what the model takes it for. The model is linear, so that all measured columns in one unit and
    // the force in the inverse unit are alike.
    for by in Rescaling::all().step_by(tier::cases(3, 1)) {
        let verdict = if by == Rescaling::Sign { Verdict::WrongSign } else { Verdict::WrongUnit };
        cases.push((times(RUN, "F", 1.0 / by.factor()), verdict, scaled(&force, by)));
        cases.push((times(unseen, "x", 1.0 / by.factor()), verdict, scaled(&x, by)));
    }
    cases.push((times(RUN, "x", -1.0), Verdict::WrongSign, scaled(&x, Rescaling::Sign)));
    cases.push((times(RUN, "v", -1.0), Verdict::WrongSign, scaled(&v, Rescaling::Sign)));
    let mut columns = RUN.columns();
    let (position, velocity) = (columns["x"].clone(), columns["v"].clone());
    columns.insert(x.clone(), velocity);
    columns.insert(v.clone(), position.clone());
    let swapped = ColumnFault::Swapped { first: v.clone(), second: x.clone() };
    cases.push((read(columns.clone(), None).unwrap(), Verdict::SwappedColumns, swapped));
    columns.insert(x.clone(), position);
    let other = ColumnFault::OtherQuantity { column: v, quantity: x };
    cases.push((read(columns, None).unwrap(), Verdict::WrongColumn, other));
    for (record, expected, fault) in cases {
        let report = verdict(record, &[]);
        assert_eq!(report.verdict, expected, "{fault:?}: {report:?}");
        let cause = &report.causes[0];
        let Outcome::WrongColumns { fault: found, corrected, .. } = &report.reason.outcome else {
            panic!("{report:?}")
        };
        assert!((0.9..1.1).contains(corrected), "{fault:?}: {report:?}");
        let expected_factor = factor(&fault);
        let named = found == &fault || cause.rivals.iter().any(|r| fault.columns() == [r.equation.as_str()]);
        let alike = expected_factor.zip(factor(found)).is_some_and(|(a, b)| is_near(a, b) || is_near(a, 1.0 / b));
        assert!(named || alike, "{fault:?}: {report:?}");
        // Six readings, each to a few windows and to all of them, and the columns as they are.
        assert!(report.effort.fits <= 13 && report.candidates.is_empty(), "{fault:?}: {:?}", report.effort);
    }
    // Neither the right columns nor a term that the model lacks are taken for them.
    for run in [RUN, unseen, Run { mass: 1.3, ..RUN }, Run { drag: 0.5, ..RUN }, Run { drag: 0.5, ..unseen }] {
        let report = verdict(run.record(), &[]);
        assert!(matches!(report.verdict, Verdict::NothingFound | Verdict::CauseFound), "{report:?}");
    }
}

/// Runs of which each has columns of its own are read in the same way, by the names of their columns.
#[test]
fn runs_may_have_other_columns() {
    let mut first = RUN.columns();
    first.get_mut("x").unwrap().iter_mut().for_each(|v| *v *= -1.0);
    let mut second = Run { seed: 2, velocity: false, ..RUN }.columns();
    second.get_mut("x").unwrap().iter_mut().for_each(|v| *v *= -1.0);
    let mut third = Run { seed: 3, ..RUN }.columns();
    third.remove("x");
    for others in [vec![second.clone()], vec![third.clone()], vec![third, second]] {
        let mut records = vec![read(first.clone(), None).unwrap()];
        records.extend(others.into_iter().map(|columns| read(columns, None).unwrap()));
        let report = diagnose(&spring(), &records, &[], &DiagnosisSettings::default(), &mut |_| {}).unwrap();
        assert_eq!(report.verdict, Verdict::WrongSign, "{report:?}");
        assert_eq!(report.causes[0].equation, "x", "{report:?}");
    }
}

/// By what a column has to be multiplied.
fn factor(fault: &ColumnFault) -> Option<f64> {
    match fault {
        ColumnFault::Scaled { by, .. } => Some(by.factor()),
        _ => None,
    }
}

/// Whether parameters known to three per cent do not tell the factors apart.
fn is_near(a: f64, b: f64) -> bool {
    (0.9..1.1).contains(&(a / b))
}

#[test]
fn a_run_for_validation_that_is_not_predicted_is_told() {
    let another = |mass: f64| Run { seed: 2, mass, ..RUN }.record();
    let report = verdict(RUN.record(), &[another(1.5)]);
    assert_eq!(report.verdict, Verdict::NothingFound, "{report:?}");
    let noted = report.notes.iter().any(|note| matches!(note, Note::Mispredicted(_)));
    assert!(is_mispredicted(&report) && noted, "{report:?}");
    assert!(!is_mispredicted(&verdict(RUN.record(), &[another(1.03)])));
}

#[test]
fn data_without_motion_say_nothing() {
    let mut random = StdRng::seed_from_u64(3);
    let noise = Normal::new(0.0, 1.0).unwrap();
    let noisy: Vec<f64> = (0..800).map(|_| noise.sample(&mut random)).collect();
    let mut spike = vec![0.0; 800];
    spike[300] = 1e6;
    for values in [vec![0.0; 800], noisy, spike] {
        let mut columns = Run { velocity: false, ..RUN }.columns();
        columns.insert("F".into(), vec![0.0; 800]);
        columns.insert("x".into(), values);
        let report = verdict(read(columns, None).unwrap(), &[]);
        assert_eq!(report.verdict, Verdict::Uninformative, "{report:?}");
        assert!(report.reason.outcome == Outcome::NoMotion(NoMotion::StillInputs), "{report:?}");
        // Nothing that looks like a result.
        assert!(report.parameters.is_empty() && report.candidates.is_empty() && report.excess.is_none(), "{report:?}");
    }
    assert_ne!(verdict(RUN.record(), &[]).verdict, Verdict::Uninformative);
}

#[test]
fn inputs_without_a_motion_point_at_the_sensors() {
    let mut columns = Run { velocity: false, ..RUN }.columns();
    columns.insert("x".into(), vec![0.2; 800]);
    let report = verdict(read(columns, None).unwrap(), &[]);
    assert_eq!(report.verdict, Verdict::Uninformative, "{report:?}");
    assert!(report.reason.outcome == Outcome::NoMotion(NoMotion::DrivenInputs), "{report:?}");
}

/// A spring that is let go tells its frequency and damping, not its mass.
#[test]
fn what_no_input_moves_has_no_interval() {
    let mut columns = Run { velocity: false, ..RUN }.columns();
    let mut random = StdRng::seed_from_u64(4);
    let noise = Normal::new(0.0, 1e-5).unwrap();
    let decay = |t: &f64| 0.1 * (-0.25 * t).exp() * (19.9375_f64.sqrt() * t).cos() + noise.sample(&mut random);
    let x: Vec<f64> = columns["t"].iter().map(decay).collect();
    columns.insert("x".into(), x);
    columns.insert("F".into(), vec![0.0; 800]);
    let report = verdict(read(columns, None).unwrap(), &[]);
    assert!(other_hold(&report).is_none(), "{report:?}");
    let mass = report.parameters.iter().find(|p| p.name == "m").unwrap();
    let hardly = report.notes.iter().any(|note| matches!(note, Note::HardlyIdentifiable(_)));
    assert!(mass.interval.is_none() && hardly, "{report:?}");
}

#[test]
fn values_that_cannot_be_squared_are_refused_with_their_place() {
    for (column, factor) in [("x", 1e150), ("x", 1e-150), ("F", 1e150)] {
        let mut columns = Run { velocity: false, ..RUN }.columns();
        columns.get_mut(column).unwrap().iter_mut().for_each(|v| *v *= factor);
        let message = read(columns, None).unwrap_err().to_string();
        assert!(message.contains(&format!("column `{column}`: the largest value")), "{message}");
        assert!(message.len() < 300, "{message}");
    }
}

#[test]
fn a_sensor_that_shows_no_motion_beside_one_that_does_is_refused() {
    for (dead, other) in [("x", "v"), ("v", "x")] {
        let mut columns = RUN.columns();
        columns.insert(dead.into(), vec![3.0; 800]);
        let message = read(columns, None).unwrap_err().to_string();
        assert!(message.contains(&format!("`{dead}` never changes, although `{other}`")), "{message}");
        assert!(message.contains("remove the column"), "{message}");
    }
    // At rest both are still.
    let mut columns = RUN.columns();
    for name in ["x", "v"] {
        columns.insert(name.into(), vec![0.0; 800]);
    }
    assert!(read(columns, None).is_ok());
}

#[test]
fn a_clock_in_milliseconds_is_refused() {
    let mut columns = Run { velocity: false, ..RUN }.columns();
    columns.get_mut("t").unwrap().iter_mut().for_each(|t| *t *= 1e3);
    let record = read(columns, None).unwrap();
    let error = diagnose(&spring(), &[record], &[], &DiagnosisSettings::default(), &mut |_| {}).unwrap_err();
    assert!(matches!(error, DiagnoseError::TimeScale { turns, .. } if turns > 5.0), "{error}");
    assert!(error.to_string().contains("milliseconds"), "{error}");
}

/// A motor whose current follows the held voltage within a few samples, with dry friction that the model lacks. Lines between the samples of
/// the voltage leave errors at high frequencies, which are no noise: the hold is right.
#[test]
fn errors_that_the_wrong_hold_adds_are_not_taken_for_noise() {
    let model = "states = ['i', 'w']\ninputs = ['u']\nparameters = { L = 0.02, R = 1, K = 0.1, J = 0.002, b = 0.001 }\n\
                 [dynamics]\ni = '(u - R*i - K*w)/L'\nw = '(K*i - b*w)/J'\n[outputs]\ni = 'i'\nw = 'w'\n";
    let system = System::parse("motor.toml", model).unwrap();
    for seed in 1..4 {
        let mut random = StdRng::seed_from_u64(seed);
        let (mut z, mut u) = ([0.0, 0.0], 0.0);
        let mut columns = BTreeMap::from(["u", "i", "w"].map(|name| (name.to_owned(), Vec::new())));
        let mut times = Vec::new();
        for k in 0..1500 {
            if k % 25 == 0 {
                u = random.random_range(-6.0..6.0);
            }
            times.push(f64::from(k) * STEP);
            let noise = Normal::new(0.0, 0.005).unwrap();
            for (name, value) in
                [("u", u), ("i", z[0] + noise.sample(&mut random)), ("w", z[1] + noise.sample(&mut random))]
            {
                columns.get_mut(name).unwrap().push(value);
            }
            let rate = |z: &[f64; 2], _: f64| {
                [(u - z[0] - 0.1 * z[1]) / 0.02, (0.1 * z[0] - 0.001 * z[1] - 0.03 * (1e3 * z[1]).tanh()) / 0.002]
            };
            for _ in 0..SUB {
                z = crate::integrate::step(rate, &z, STEP / SUB as f64);
            }
        }
        let record = Record::from_columns("run.csv", times, columns, &system, &RecordSettings::default()).unwrap();
        let report = diagnose(&system, &[record], &[], &DiagnosisSettings::default(), &mut |_| {}).unwrap();
        assert!(report.causes.iter().any(|c| c.name == Cause::CoulombFriction), "{seed}: {:?}", report.verdict);
        assert_eq!(other_hold(&report), None, "{seed}");
    }
}
