//! Parameters, forces, and gains that change during a run: at an instant, or slowly.

use bracketry_symbolic::{Expr, Notation};
use bracketry_system::System;

use super::builder::{Builder, amplitude, shape};
use super::names::{TIME_INPUT, symbols};
use super::paths::interval;
use crate::effect::{Cause, Change, Coefficient, Effect};
use crate::error::DiagnoseError;
use crate::formula::Formula;
use crate::record::Record;
use crate::settings::LibrarySettings;

/// What may change: the state in whose equation it stands, its name, and the change of the equations by a text that stands for how
/// much.
struct Place {
    row: usize,
    name: String,
    unit: String,
    about: String,
    change: Box<dyn Fn(&str) -> Change>,
}

/// A change at an instant, and the same change as one that takes longer: what the first must be told from.
pub(crate) struct Jump {
    /// At an instant, a [`Cause::ParameterJump`]; its coefficients are the change and the time.
    pub(crate) sudden: Effect,
    /// Along a straight line over some time, a [`Cause::UnknownTerm`]; its coefficients are the change, the time of its middle, and its
    /// duration.
    pub(crate) slow: Effect,
}

/// Changes during the run of the named parameters, of constant forces, and of the gains of inputs.
///
/// A change at an instant is spread over one interval between samples, within which the data do not tell its time, so that it has a
/// derivative by that time.
///
/// # Errors
/// As [`super::candidates`].
pub(crate) fn jumps(
    system: &System,
    parameters: &[usize],
    records: &[Record],
    settings: &LibrarySettings,
) -> Result<Vec<Jump>, DiagnoseError> {
    // Where the model has another meaning for the name of the time, nothing can be said of it.
    if symbols(system).any(|s| system.symbol_name(s) == TIME_INPUT)
        || system.definitions.iter().any(|d| d.0 == TIME_INPUT)
    {
        return Ok(Vec::new());
    }
    let mut builder = Builder::new(system, records, settings);
    let places: Vec<Place> =
        [builder.parameters(parameters), builder.forces(), builder.gains()].into_iter().flatten().collect();
    let mut list = Vec::with_capacity(places.len());
    for place in places {
        let (sudden, slow) = (builder.sudden(&place, records)?, builder.slow(&place, records)?);
        list.push(Jump { sudden, slow });
    }
    Ok(list)
}

/// First and last time of records.
fn span(records: &[Record]) -> (f64, f64) {
    let times = records.iter().filter_map(|r| Some((*r.times.first()?, *r.times.last()?)));
    times.fold((f64::INFINITY, f64::NEG_INFINITY), |(from, to), (a, b)| (from.min(a), to.max(b)))
}

/// From 0 to 1 over `duration` around the time `at`.
fn step(at: &str, duration: &str) -> String {
    format!("min(max(({TIME_INPUT} - {at})/{duration} + 1/2, 0), 1)")
}

impl Builder {
    /// Parameters of the equations that are not zero.
    fn parameters(&self, indices: &[usize]) -> Vec<Place> {
        let system = &self.system;
        let of = |&index: &usize| {
            let parameter = &system.parameters[index];
            let row = system.dynamics.iter().position(|f| system.pool.depends_on(*f, parameter.symbol))?;
            let name = system.symbol_name(parameter.symbol).to_owned();
            let old = name.clone();
            (parameter.value.to_f64().value() != 0.0).then(|| Place {
                row,
                unit: parameter.unit.clone().unwrap_or_default(),
                about: format!("change of {name}"),
                change: Box::new(move |by| substituted(std::slice::from_ref(&old), |old| format!("({old} + {by})"))),
                name,
            })
        };
        indices.iter().filter_map(of).collect()
    }

    /// A constant force on each coordinate, and a constant rate of each state of first order.
    fn forces(&mut self) -> Vec<Place> {
        let one = self.system.pool.int(1);
        let coordinates = self.structure.coordinates.iter().map(|c| (c.rate, c.force.clone(), c.force_unit.clone()));
        let rate_unit = |row: usize| self.system.quantities.unit_of_derivative(&self.state(row), 1).unwrap_or_default();
        let others = self.structure.others.iter().map(|&row| (row, vec![(row, one)], rate_unit(row)));
        let place = |(row, direction, unit)| {
            let direction: Vec<(usize, Expr)> = direction;
            let along: Vec<(String, String)> =
                direction.iter().map(|&(row, entry)| (self.state(row), self.text(entry))).collect();
            let change = move |by: &str| {
                Change::Terms(along.iter().map(|(row, entry)| (row.clone(), format!("({by})*({entry})"))).collect())
            };
            let v = self.state(row);
            let what = if self.structure.others.contains(&row) { "constant rate of" } else { "constant force on" };
            let about = format!("change of the {what} {v}");
            Place { row, name: format!("force_{v}"), unit, about, change: Box::new(change) }
        };
        coordinates.chain(others).map(place).collect()
    }

    /// The gain of each input.
    fn gains(&self) -> Vec<Place> {
        let system = &self.system;
        let of = |index: usize| {
            let name = system.symbol_name(system.inputs[index]).to_owned();
            let derivatives = system.input_derivatives.iter().filter(|d| d.input == index).map(|d| d.symbol);
            let used = system.pool.symbols_of(&system.dynamics);
            let symbols: Vec<_> =
                std::iter::once(system.inputs[index]).chain(derivatives).filter(|s| used.contains(s)).collect();
            let row = system.dynamics.iter().position(|&f| symbols.iter().any(|&s| system.pool.depends_on(f, s)))?;
            let signals: Vec<String> = symbols.iter().map(|&s| system.symbol_name(s).to_owned()).collect();
            Some(Place {
                row,
                name: format!("gain_{name}"),
                unit: "1".to_owned(),
                about: format!("change of the gain of {name}"),
                change: Box::new(move |by| substituted(&signals, |u| format!("((1 + {by})*{u})"))),
            })
        };
        (0..system.inputs.len()).filter_map(of).collect()
    }

    fn sudden(&mut self, place: &Place, records: &[Record]) -> Result<Effect, DiagnoseError> {
        let (from, to) = span(records);
        let change = self.change_of(place, "jump");
        let at = Coefficient {
            min: from,
            max: to,
            ..shape(
                self.name("jump_time", &place.name),
                vec![0.5 * (from + to)],
                self.system.quantities.time_unit.name(),
                "time of the change, in the log",
            )
        };
        let law = format!("{}*{}", change.name, step(&at.name, &format!("{:e}", interval(records))));
        let how = format!("from t = {}", at.name);
        self.changing(Cause::ParameterJump, place, &law, &how, vec![change, at])
    }

    fn slow(&mut self, place: &Place, records: &[Record]) -> Result<Effect, DiagnoseError> {
        let (from, to) = span(records);
        let all = to - from;
        let shares = |start: f64, shares: [f64; 3]| shares.map(|s| start + s * all).to_vec();
        let change = self.change_of(place, "ramp");
        let middle = self.name("ramp_time", &place.name);
        let at = Coefficient {
            min: from,
            max: to,
            ..shape(
                middle,
                shares(from, [0.25, 0.5, 0.75]),
                self.system.quantities.time_unit.name(),
                "time of the middle of the change, in the log",
            )
        };
        let lasting = self.name("ramp_duration", &place.name);
        let duration = Coefficient {
            min: interval(records),
            max: 2.0 * all,
            ..shape(
                lasting,
                shares(0.0, [0.25, 0.5, 1.0]),
                self.system.quantities.time_unit.name(),
                "time that the change takes",
            )
        };
        let law = format!("{}*{}", change.name, step(&at.name, &duration.name));
        let how = format!("along a straight line of {} around t = {}", duration.name, at.name);
        self.changing(Cause::UnknownTerm, place, &law, &how, vec![change, at, duration])
    }

    fn change_of(&mut self, place: &Place, base: &str) -> Coefficient {
        amplitude(self.name(base, &place.name), place.unit.clone(), place.about.clone())
    }

    /// The effect of a law in a place.
    fn changing(
        &mut self,
        cause: Cause,
        place: &Place,
        law: &str,
        how: &str,
        coefficients: Vec<Coefficient>,
    ) -> Result<Effect, DiagnoseError> {
        let (what, by) = (&place.name, &coefficients[0].name);
        let is_parameter = self.system.parameters.iter().any(|p| self.system.symbol_name(p.symbol) == what);
        let text = if is_parameter { format!("{what} -> {what} + {by} {how}") } else { format!("{by} {how}") };
        let mut notation = vec![Notation::symbol(by.clone()), Notation::text(format!(" {how}"))];
        if is_parameter {
            let sum = Notation::Sum(vec![Notation::symbol(what.clone()), Notation::symbol(by.clone())]);
            let shown = [Notation::symbol(what.clone()), Notation::Sign('→'), sum];
            notation.splice(..1, shown);
        }
        let term = Formula::new(text, Notation::Row(notation));
        let change = (place.change)(law);
        self.scaled(Effect { cause, equation: self.state(place.row), term, coefficients, change }, place.row)
    }
}

fn substituted(names: &[String], new: impl Fn(&str) -> String) -> Change {
    Change::Substitution { states: Vec::new(), pairs: names.iter().map(|n| (n.clone(), new(n))).collect() }
}
