//! Whether columns are what the model takes them for: their sign, their unit, which is which.

use bracketry_symbolic::{Expr, Named, Node};
use bracketry_system::System;

use super::alarm::Alarm;
use super::held_out::thinned;
use super::motion::without_findings;
use super::write::refitted;
use crate::effort::Counter;
use crate::library::OF_COLUMNS;
use crate::numbers::significant;
use crate::report::{
    Closeness, ColumnFault, Excess, NamedCause, Outcome, Report, Rescaling, Rival, ScaledColumn, Verdict, VerdictReason,
};
use crate::settings::DiagnosisSettings;
use crate::{DiagnoseError, Estimate, Fit, Formula, Quantity, Record, Study, WindowFit};

/// Reads the columns in every way in which files are usually wrong, before the model as it stands, and refits it with the best ones. A
/// report if that leaves noise with parameters near their values, and the columns as they are do not.
///
/// # Errors
/// [`DiagnoseError`] as [`Study::new`].
pub(super) fn wrong_columns(
    system: &System,
    plain: &Study,
    settings: &DiagnosisSettings,
    counter: &Counter,
) -> Result<Option<Report>, DiagnoseError> {
    let limits = &settings.verdict.columns;
    let trial = Trial { system, records: plain.records(), settings, counter };
    let some = thinned(plain.windows().len(), limits.windows);
    let share = settings.study.solver.settled_share;
    let as_it_is = trial.judged(plain, &some, share)?;
    if as_it_is.is_noise(settings) {
        return Ok(None);
    }
    // The window that shows most comes first: most readings fail there already.
    let worst = as_it_is.worst();
    let as_it_is = [trial.judged(plain, &[worst], limits.roughly)?.mean, as_it_is.mean];
    let mut tried: Vec<(f64, Reading)> = Vec::new();
    for reading in readings(system, &plain.records()[0]) {
        let study = trial.study(&reading)?;
        if trial.judged(&study, &[worst], limits.roughly)?.mean < limits.worth * as_it_is[0] {
            let mean = trial.judged(&study, &some, share)?.mean;
            if mean < limits.worth * as_it_is[1] {
                tried.push((mean, reading));
            }
        }
    }
    tried.sort_by(|a, b| a.0.total_cmp(&b.0));
    tried.truncate(limits.refitted);
    let mut found: Vec<(Fit, Alarm, Reading)> = Vec::new();
    for (_, reading) in tried {
        let study = trial.study(&reading)?;
        // Most that leave more than noise do so in a few windows.
        let Some((few, _)) = trial.explains(&study, &some, None) else { continue };
        if let Some((fit, alarm)) = trial.explains(&study, &trial.windows(&study), Some(&few)) {
            found.push((fit, alarm, reading));
        }
    }
    let Some(best) = found.iter().map(|f| moved(&f.0)).min_by(f64::total_cmp) else { return Ok(None) };
    let as_read = plain.fit(&[], &trial.windows(plain), None).ok();
    let base = as_read
        .as_ref()
        .map(|fit| Alarm::of(&fit.windows, system.states.len(), fit.values.len(), &settings.verdict.alarm));
    if let (Some(fit), Some(alarm)) = (&as_read, &base) {
        // Refitted parameters explain the data of the columns as they are, without having moved as far as a unit, or several of them together.
        let explains = alarm.p_value >= settings.significance || alarm.size <= limits.noise;
        let like_a_unit = is_far(fit, limits.change) || several_moved(fit, limits.together);
        if explains && (!like_a_unit || best > limits.exact) {
            return Ok(None);
        }
    }
    // The simplest first: signs, then what needs the least change of parameters.
    found.sort_by_key(|(_, _, reading)| reading.rank());
    if found[0].2.rank() > 1 {
        found.sort_by(|a, b| moved(&a.0).total_cmp(&moved(&b.0)));
    }
    Ok(Some(report(system, &found, base.as_ref(), plain)))
}

/// One way to read the columns.
#[derive(Clone, Debug, PartialEq)]
enum Reading {
    Measured(usize, Rescaling),
    AllMeasured(Rescaling),
    Input(usize, Rescaling),
    SwappedMeasured(usize, usize),
    SwappedInputs(usize, usize),
    As(usize, Quantity),
}

impl Reading {
    /// Simple ones first: the sign of one column, that of all, then the rest.
    fn rank(&self) -> usize {
        match self {
            Self::Measured(_, Rescaling::Sign) | Self::Input(_, Rescaling::Sign) => 0,
            Self::AllMeasured(Rescaling::Sign) => 1,
            _ => 2,
        }
    }

    fn fault(&self, system: &System, record: &Record) -> ColumnFault {
        let measured = |c: usize| record.measured[c].name.clone();
        let input = |i: usize| system.symbol_name(system.inputs[i]).to_owned();
        match *self {
            Self::Measured(c, by) => ColumnFault::Scaled { columns: ScaledColumn::Column(measured(c)), by },
            Self::AllMeasured(by) => ColumnFault::Scaled { columns: ScaledColumn::AllMeasured, by },
            Self::Input(i, by) => ColumnFault::Scaled { columns: ScaledColumn::Column(input(i)), by },
            Self::SwappedMeasured(a, b) => ColumnFault::Swapped { first: measured(a), second: measured(b) },
            Self::SwappedInputs(a, b) => ColumnFault::Swapped { first: input(a), second: input(b) },
            Self::As(c, quantity) => {
                ColumnFault::OtherQuantity { column: measured(c), quantity: name_of(system, quantity) }
            }
        }
    }

    /// The records, read in this way. Places of measured columns are those of the first record; others may have other columns.
    fn of(&self, system: &System, records: &[Record]) -> Vec<Record> {
        let names: Vec<&str> = records[0].measured.iter().map(|m| m.name.as_str()).collect();
        let place = |record: &Record, c: usize| record.measured.iter().position(|m| m.name == names[c]);
        let mut read = records.to_vec();
        for record in &mut read {
            match *self {
                Self::Measured(c, by) => {
                    if let Some(c) = place(record, c) {
                        rescale_measured(record, c, by);
                    }
                }
                Self::AllMeasured(by) => {
                    for c in 0..record.measured.len() {
                        rescale_measured(record, c, by);
                    }
                }
                Self::Input(i, by) => {
                    let derivatives = system.input_derivatives.iter().zip(&mut record.input_derivatives);
                    let derivatives = derivatives.filter(|(d, _)| d.input == i).map(|(_, signal)| (signal, 0.0));
                    let input = record.inputs.get_mut(i).map(|signal| (signal, by.offset()));
                    for (signal, offset) in input.into_iter().chain(derivatives) {
                        signal.values.iter_mut().for_each(|v| *v = by.factor() * *v + offset);
                    }
                }
                Self::SwappedMeasured(a, b) => {
                    let quantities = [records[0].measured[b].quantity, records[0].measured[a].quantity];
                    for (c, quantity) in [a, b].into_iter().zip(quantities) {
                        if let Some(c) = place(record, c) {
                            record.measured[c].quantity = quantity;
                        }
                    }
                }
                Self::SwappedInputs(a, b) => record.inputs.swap(a, b),
                Self::As(c, quantity) => {
                    if let Some(c) = place(record, c) {
                        record.measured[c].quantity = quantity;
                    }
                }
            }
        }
        read
    }
}

fn rescale_measured(record: &mut Record, column: usize, by: Rescaling) {
    let Some(m) = record.measured.get_mut(column) else { return };
    m.values.iter_mut().for_each(|v| *v = by.factor() * *v + by.offset());
    m.noise *= by.factor().abs();
}

/// Whether nothing in the model is a position with its rate: then its measured states and inputs may be temperatures.
fn may_have_temperatures(system: &System) -> bool {
    let is_state = |e: &Expr| matches!(system.pool.node(*e), Node::Sym(s) if system.states.contains(&s));
    !system.dynamics.iter().any(is_state)
}

fn name_of(system: &System, quantity: Quantity) -> String {
    match quantity {
        Quantity::State(k) => system.symbol_name(system.states[k]).to_owned(),
        Quantity::Output(k) => system.outputs[k].0.clone(),
    }
}

fn readings(system: &System, record: &Record) -> Vec<Reading> {
    let (measured, inputs) = (record.measured.len(), record.inputs.len());
    let mut all = Vec::new();
    let temperatures = may_have_temperatures(system).then(Rescaling::temperatures);
    for by in Rescaling::all().chain(temperatures.into_iter().flatten()) {
        all.extend((0..measured).map(|c| Reading::Measured(c, by)));
        all.extend((measured > 1).then_some(Reading::AllMeasured(by)));
        all.extend((0..inputs).map(|i| Reading::Input(i, by)));
    }
    all.extend((0..measured).flat_map(|a| (0..a).map(move |b| Reading::SwappedMeasured(b, a))));
    // Inputs of which derivatives are used are motions that belong to them.
    if system.input_derivatives.is_empty() {
        all.extend((0..inputs).flat_map(|a| (0..a).map(move |b| Reading::SwappedInputs(b, a))));
    }
    let quantities =
        (0..system.states.len()).map(Quantity::State).chain((0..system.outputs.len()).map(Quantity::Output));
    for quantity in quantities {
        all.extend(
            (0..measured).filter(|&c| record.measured[c].quantity != quantity).map(|c| Reading::As(c, quantity)),
        );
    }
    all
}

struct Trial<'a> {
    system: &'a System,
    records: &'a [Record],
    settings: &'a DiagnosisSettings,
    counter: &'a Counter,
}

/// How well the model as it stands follows some windows.
struct Judged {
    /// Mean square of the residual in units of the noise; infinite where a window cannot be simulated.
    mean: f64,
    windows: Vec<WindowFit>,
    states: usize,
}

impl Judged {
    /// The window that is followed worst.
    fn worst(&self) -> usize {
        let mean = |w: &WindowFit| if w.count > 0 { w.square / w.count as f64 } else { f64::INFINITY };
        self.windows.iter().max_by(|a, b| mean(a).total_cmp(&mean(b))).map_or(0, |w| w.window)
    }

    fn is_noise(&self, settings: &DiagnosisSettings) -> bool {
        let alarm = Alarm::of(&self.windows, self.states, 0, &settings.verdict.alarm);
        self.mean.is_finite() && alarm.p_value >= settings.significance
    }
}

impl Trial<'_> {
    fn study(&self, reading: &Reading) -> Result<Study, DiagnoseError> {
        let records = reading.of(self.system, self.records);
        Study::counted(self.system, &records, &self.settings.study, self.counter)
    }

    /// The fit to some windows, if it leaves noise with parameters near their values.
    fn explains(&self, study: &Study, windows: &[usize], start: Option<&Fit>) -> Option<(Fit, Alarm)> {
        let fit = study.fit(&[], windows, start).ok()?;
        let (verdict, states) = (&self.settings.verdict, self.system.states.len());
        let alarm = Alarm::of(&fit.windows, states, fit.values.len(), &verdict.alarm);
        let noise = alarm.p_value >= self.settings.significance || alarm.size <= verdict.columns.noise;
        (noise && !is_far(&fit, verdict.columns.far)).then_some((fit, alarm))
    }

    fn windows(&self, study: &Study) -> Vec<usize> {
        thinned(study.windows().len(), self.settings.verdict.search.most_windows)
    }

    fn judged(&self, study: &Study, windows: &[usize], share: f64) -> Result<Judged, DiagnoseError> {
        let windows = study.evaluate_until(&study.nominal(), windows, share)?;
        let (square, count) = windows.iter().fold((0.0, 0), |(s, n), w| (s + w.square, n + w.count));
        let mean = if windows.iter().all(|w| w.count > 0) { square / count as f64 } else { f64::INFINITY };
        Ok(Judged { mean, windows, states: self.system.states.len() })
    }
}

/// By how much a parameter has changed, as a factor above 1; infinite where its sign has.
fn change(e: &Estimate) -> f64 {
    let ratio = e.value / e.nominal;
    if e.nominal == 0.0 {
        1.0
    } else if ratio > 0.0 {
        ratio.max(1.0 / ratio)
    } else {
        f64::INFINITY
    }
}

/// The changes of the parameters that the data determine.
fn changes(fit: &Fit) -> impl Iterator<Item = f64> {
    let known = fit.values.iter().enumerate().filter(|(j, _)| !fit.unidentified.contains(j));
    known.map(|(_, e)| change(e))
}

/// The largest of them.
fn moved(fit: &Fit) -> f64 {
    changes(fit).fold(1.0, f64::max)
}

/// Whether two parameters or more that the data determine have moved by more than a factor.
fn several_moved(fit: &Fit, by: f64) -> bool {
    changes(fit).filter(|change| *change > by).count() > 1
}

fn is_far(fit: &Fit, most: f64) -> bool {
    moved(fit) > most
}

/// The column, or what is measured.
fn place(fault: &ColumnFault) -> String {
    let columns = fault.columns();
    if columns.is_empty() { "all measured columns".to_owned() } else { columns.join(", ") }
}

/// What it has to be, as `-u` or `0.001*x`.
fn term(fault: &ColumnFault) -> Formula {
    let text = match fault {
        ColumnFault::Scaled { by: Rescaling::Sign, .. } => format!("-{}", place(fault).replace(' ', "_")),
        ColumnFault::Scaled { by, .. } => {
            let column = place(fault).replace(' ', "_");
            let factor = significant(by.factor(), 6);
            match by.offset() {
                0.0 => format!("{factor}*{column}"),
                offset if by.factor() == 1.0 => format!("{column}{offset:+.2}"),
                offset => format!("{factor}*{column}{offset:+.2}"),
            }
        }
        ColumnFault::Swapped { first, second } => format!("{first} <-> {second}"),
        ColumnFault::OtherQuantity { column, quantity } => format!("{column} -> {quantity}"),
    };
    Formula::from(text.as_str())
}

fn report(system: &System, found: &[(Fit, Alarm, Reading)], base: Option<&Alarm>, plain: &Study) -> Report {
    let record = &plain.records()[0];
    let (fit, alarm, reading) = &found[0];
    let fault = reading.fault(system, record);
    let others: Vec<ColumnFault> = found[1..].iter().map(|f| f.2.fault(system, record)).collect();
    let mut confusable_with: Vec<_> = Vec::new();
    for other in &others {
        if other.cause() != fault.cause() && !confusable_with.contains(&other.cause()) {
            confusable_with.push(other.cause());
        }
    }
    let rivals = others.iter().map(|other| Rival {
        name: other.cause(),
        equation: place(other),
        term: term(other),
        closeness: Closeness::Equal,
    });
    let cause = NamedCause {
        name: fault.cause(),
        equation: place(&fault),
        term: term(&fault),
        parameters: Named(Vec::new()),
        p_value: base.map(|b| b.p_value),
        confusable_with,
        separating_experiment: if others.is_empty() { String::new() } else { OF_COLUMNS.to_owned() },
        rivals: rivals.collect(),
        share: None,
        flags: Vec::new(),
        combination: None,
    };
    let size = base.map(|b| b.size);
    Report {
        verdict: Verdict::of_columns(&fault),
        reason: VerdictReason {
            outcome: Outcome::WrongColumns { fault, size, corrected: alarm.size },
            caveats: Vec::new(),
        },
        causes: vec![cause],
        parameters: refitted(system, &fit.values, 1.0),
        excess: base.map(|b| Excess { refitted: b.size, extended: Some(alarm.size), p_value: b.p_value }),
        ..without_findings(system)
    }
}
