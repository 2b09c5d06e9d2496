//! Points at which expressions are compared: in general position, or those that the data pass through.

use bracketry_numerics::statistics::rms;
use bracketry_symbolic::{Expr, SplitMix64, Symbol};
use bracketry_system::System;
use rustc_hash::FxHashMap;

use super::names::{TIME_INPUT, derivative_name};
use crate::record::Record;
use crate::settings::LibrarySettings;
use crate::signal::{Measured, Quantity};

/// Values of states, inputs and derivatives of inputs by name.
#[derive(Clone, Debug)]
pub(crate) struct Probe {
    columns: FxHashMap<String, Vec<f64>>,
    len: usize,
}

impl Probe {
    /// A few points in general position, the same for each model.
    pub(crate) fn fixed(system: &System) -> Self {
        let mut names: Vec<String> = system.arguments().iter().map(|&s| system.symbol_name(s).to_owned()).collect();
        for u in system.input_names() {
            names.extend([derivative_name(&u, 1), derivative_name(&u, 2)]);
        }
        names.push(TIME_INPUT.to_owned());
        let len = 32;
        let mut random = SplitMix64::new(0);
        let columns = names.into_iter().map(|n| (n, (0..len).map(|_| 1.5 * random.symmetric()).collect())).collect();
        Probe { columns, len }
    }

    /// Points along the records. States that were not measured come from difference quotients where they are
    /// rates of measured ones, and stay 0 otherwise. Meant for typical sizes, not for estimates.
    pub(crate) fn of_records(
        system: &System,
        records: &[Record],
        pairs: &[(usize, usize)],
        settings: &LibrarySettings,
    ) -> Self {
        let total: usize = records.iter().map(|r| r.times.len()).sum();
        let stride = total.div_ceil(settings.most_points).max(1);
        let mut probe = Probe { columns: FxHashMap::default(), len: 0 };
        for record in records {
            let columns = columns(system, record, pairs, settings.clear_of_noise);
            let n = record.times.len();
            for (name, values) in columns {
                let kept = (0..n).step_by(stride).map(|k| values.get(k).copied().filter(|v| v.is_finite()));
                let all = probe.columns.entry(name).or_insert_with(|| vec![0.0; probe.len]);
                all.extend(kept.map(|v| v.unwrap_or(0.0)));
            }
            probe.len += n.div_ceil(stride);
            for all in probe.columns.values_mut() {
                all.resize(probe.len, 0.0);
            }
        }
        probe
    }

    /// The values of expressions at all points, parameters at their values; NaN where they have none.
    pub(crate) fn values(&self, system: &mut System, expressions: &[Expr]) -> Vec<Vec<f64>> {
        let arguments: Vec<Symbol> = system.arguments();
        let Ok(tape) = system.compile(&arguments, expressions) else {
            return vec![vec![f64::NAN; expressions.len()]; self.len];
        };
        let columns: Vec<Option<&Vec<f64>>> =
            arguments.iter().map(|&s| self.columns.get(system.symbol_name(s))).collect();
        let (mut work, mut x) = (Vec::new(), vec![0.0; arguments.len()]);
        (0..self.len)
            .map(|k| {
                for (x, column) in x.iter_mut().zip(&columns) {
                    *x = column.map_or(0.0, |c| c[k]);
                }
                let mut out = vec![f64::NAN; expressions.len()];
                tape.eval(&x, &mut work, &mut out);
                out
            })
            .collect()
    }

    /// Root mean square of each expression over the points where it is finite; 0 if there are none.
    pub(crate) fn rms(&self, system: &mut System, expressions: &[Expr]) -> Vec<f64> {
        let values = self.values(system, expressions);
        (0..expressions.len()).map(|i| rms(values.iter().map(|v| v[i]))).collect()
    }

    /// The size that a state or input stays below at 99 of 100 points; none if it is always 0.
    pub(crate) fn extent(&self, name: &str) -> Option<f64> {
        let mut sizes: Vec<f64> = self.columns.get(name)?.iter().map(|v| v.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        let last = sizes.len().checked_sub(1)?;
        Some(sizes[last * 99 / 100]).filter(|s| *s > 0.0)
    }
}

/// Every quantity of a record that the names of the model stand for.
fn columns(system: &System, record: &Record, pairs: &[(usize, usize)], clear: f64) -> Vec<(String, Vec<f64>)> {
    let mut columns = Vec::new();
    let name = |s: Symbol| system.symbol_name(s).to_owned();
    let mut states: Vec<Option<(Vec<f64>, f64)>> = vec![None; system.states.len()];
    for m in &record.measured {
        if let Some(i) = measured_state(system, m)
            && states[i].is_none()
        {
            states[i] = Some((m.values.clone(), m.noise));
        }
    }
    for &(q, v) in pairs {
        if let (Some((values, noise)), None) = (&states[q], &states[v]) {
            let ratio = unit_ratio(system, q, v);
            let slope = slope(&record.times, values, clear * *noise);
            states[v] = Some((slope.into_iter().map(|s| s / ratio).collect(), 0.0));
        }
    }
    for (&s, values) in system.states.iter().zip(states) {
        columns.extend(values.map(|(v, _)| (name(s), v)));
    }
    for (i, (&u, signal)) in system.inputs.iter().zip(&record.inputs).enumerate() {
        let mut last = signal.values.clone();
        for order in 1..=2 {
            let given = system.input_derivatives.iter().position(|d| d.input == i && d.order == order);
            let next = match given.and_then(|k| record.input_derivatives.get(k)) {
                Some(signal) => signal.values.clone(),
                None => slope(&record.times, &last, clear * (1e-3 * rms(last.iter().copied()))),
            };
            columns.push((derivative_name(&name(u), order), next.clone()));
            last = next;
        }
        columns.push((name(u), signal.values.clone()));
    }
    columns.push((TIME_INPUT.to_owned(), record.times.clone()));
    columns
}

/// The state that a column shows as it is.
fn measured_state(system: &System, m: &Measured) -> Option<usize> {
    match m.quantity {
        Quantity::State(i) => Some(i),
        Quantity::Output(o) => {
            let (_, e) = system.outputs.get(o)?;
            let shown = system.pool.symbols_of(&[*e]);
            let state = system.states.iter().position(|s| shown == [*s])?;
            let mut pool = system.pool.clone();
            (pool.sym(system.states[state]) == *e).then_some(state)
        }
    }
}

/// k in q' = k v, at the values of the parameters.
fn unit_ratio(system: &System, q: usize, v: usize) -> f64 {
    let mut system = system.clone();
    let slope = system.pool.diff(system.dynamics[q], system.states[v]);
    system.value(slope).filter(|k| *k != 0.0).unwrap_or(1.0)
}

/// Central difference quotients over as few samples as make differences of at least this size.
fn slope(times: &[f64], values: &[f64], least: f64) -> Vec<f64> {
    let n = times.len().min(values.len());
    let difference = |k: usize, h: usize| {
        let (a, b) = (k.saturating_sub(h), (k + h).min(n - 1));
        (values[b] - values[a], times[b] - times[a])
    };
    let mut h = 1;
    while 2 * h < n / 20 && rms((0..n).map(|k| difference(k, h).0)) < least {
        h *= 2;
    }
    (0..n)
        .map(|k| {
            let (dv, dt) = difference(k, h);
            if dt > 0.0 { dv / dt } else { 0.0 }
        })
        .collect()
}
