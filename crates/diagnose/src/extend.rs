//! The extended model: the given one with fitted parameters and the effects that were found.

use std::fmt;

use bracketry_symbolic::{Expr, Symbol};
use bracketry_system::{InputDelay, InputDerivative, System, WriteError};
use rustc_hash::FxHashMap;

use crate::effect::{Change, Effect, Path};
use crate::error::DiagnoseError;
use crate::library::{
    ModelNames, TIME_INPUT, apply_all, decimal, derivative_name, input_index, parameter, symbols, unknown,
};
use crate::numbers::significant;
use crate::study::{Estimate, Fit};

/// Digits that a fitted value keeps below its standard deviation: enough for a simulation to stay the same where two values are
/// known a thousand times better together than each alone.
const EXTRA_DIGITS: i32 = 5;

/// A model with fitted values, and what its equations cannot say.
#[derive(Clone, Debug)]
pub struct ExtendedModel {
    /// The equations.
    pub system: System,
    /// Delays that are no part of the model.
    pub notes: Vec<OutsideDelay>,
    /// Outputs that stand for measured states, by name of the state.
    measured: FxHashMap<String, usize>,
}

/// A delay that a model's equations cannot say: of measured columns, or a negative one of inputs.
#[derive(Clone, Debug, PartialEq)]
pub struct OutsideDelay {
    /// The delay, s.
    pub delay: f64,
    /// Whether inputs are late; otherwise measured columns are.
    pub inputs: bool,
    /// Names of the inputs or columns.
    pub signals: Vec<String>,
}

impl fmt::Display for OutsideDelay {
    /// As a comment in the model file.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = if self.inputs { "input" } else { "measured column" };
        let names = self.signals.join(", ");
        write!(f, "a delay of {:.3e} s of the {what} {names} is not part of these equations", self.delay)
    }
}

impl ExtendedModel {
    /// The given model with the values and effects of a fit. Fitted values are rounded to a hundred-thousandth of their standard
    /// deviation; it stands in the parameter's description, times `width`, the factor by which correlation of the residuals
    /// widens it (1 for none). Limits that a fitted value breaks are dropped.
    ///
    /// A lag of an input `u` becomes a state `u_lagged` that the equations use in place of `u` (and its derivatives, by
    /// `τ u_lagged' = u − u_lagged`), a filter of a measured column a state that an output shows, the time a state with derivative 1, an offset of a measured column, or a tracked
    /// point off the center of mass, an output. A delay of
    /// an input stands in the model's table of delays, on top of one that it had.
    ///
    /// # Errors
    /// [`DiagnoseError`] for an effect that does not fit the model.
    pub fn new(system: &System, fit: &Fit, width: f64) -> Result<Self, DiagnoseError> {
        let system = equations(system, &fit.effects, &fit.values)?;
        let mut extended = Self { system, notes: Vec::new(), measured: FxHashMap::default() };
        extended.system.mark_dry_friction();
        // Offsets stand behind filters.
        let is_filter = |e: &&Effect| e.is_filter();
        let (filters, others): (Vec<&Effect>, Vec<&Effect>) = fit.effects.iter().partition(is_filter);
        for effect in filters.into_iter().chain(others) {
            match &effect.change {
                Change::Path { path, signals } => extended.add_path(effect, *path, signals, &fit.values)?,
                Change::TrackedPoint { position, angle, .. } => {
                    extended.add_tracked_point(effect, position, angle, &fit.values)?;
                }
                Change::Terms(_)
                | Change::Substitution { .. }
                | Change::Stretch { .. }
                | Change::Several(_)
                | Change::Hidden { .. } => {}
            }
        }
        extended.time_as_state();
        for estimate in &fit.values {
            describe(&mut extended.system, estimate, width);
        }
        if !fit.effects.is_empty() {
            extended.system.name.push_str("_extended");
        }
        Ok(extended)
    }

    /// The text of a model file, with the notes as comments at its top.
    ///
    /// # Errors
    /// [`WriteError`] for an equation that is too long to be written out.
    pub fn to_toml(&self) -> Result<String, WriteError> {
        let notes = self.notes.iter().map(|note| format!("# {note}\n"));
        Ok(notes.chain([self.system.to_toml()?]).collect())
    }

    fn add_path(
        &mut self,
        effect: &Effect,
        path: Path,
        signals: &[String],
        values: &[Estimate],
    ) -> Result<(), DiagnoseError> {
        let Some(coefficient) = effect.coefficients.first() else { return Ok(()) };
        let value = values.iter().find(|e| e.name == coefficient.name).map_or(coefficient.nominal, |e| e.value);
        if path == Path::SensorDelay || path == Path::InputDelay && value < 0.0 {
            let inputs = path == Path::InputDelay;
            self.notes.push(OutsideDelay { delay: value, inputs, signals: signals.to_vec() });
            return Ok(());
        }
        let symbol = self.system.pool.symbol(&coefficient.name);
        let entry = parameter(coefficient, symbol)?;
        self.system.parameters.push(entry);
        if let Some(estimate) = values.iter().find(|e| e.name == coefficient.name) {
            set_fitted(&mut self.system, estimate);
        }
        for name in signals {
            match path {
                Path::ActuatorLag => add_lag(&mut self.system, name, symbol)?,
                Path::InputDelay => add_delay(&mut self.system, name, symbol)?,
                Path::SensorLag | Path::DigitalFilter => self.add_filter(name, symbol)?,
                Path::SensorDelay | Path::SensorBias => {
                    let offset = self.system.pool.sym(symbol);
                    self.add_offset(name, offset)?;
                }
                Path::SensorDrift => {
                    let mut names = ModelNames::new(&mut self.system);
                    let text = format!("{}*{TIME_INPUT}", coefficient.name);
                    let offset = names.read(&mut self.system.pool, &text)?;
                    names.register(&mut self.system);
                    self.add_offset(name, offset)?;
                }
            }
        }
        Ok(())
    }

    /// The measured position becomes an output; the equations stay those of the center of mass.
    fn add_tracked_point(
        &mut self,
        effect: &Effect,
        position: &[String; 2],
        angle: &str,
        values: &[Estimate],
    ) -> Result<(), DiagnoseError> {
        let mut symbols = Vec::new();
        for coefficient in &effect.coefficients {
            let symbol = self.system.pool.symbol(&coefficient.name);
            let entry = parameter(coefficient, symbol)?;
            self.system.parameters.push(entry);
            if let Some(estimate) = values.iter().find(|e| e.name == coefficient.name) {
                set_fitted(&mut self.system, estimate);
            }
            symbols.push(coefficient.name.clone());
        }
        let [along, across] = &symbols[..] else { return Ok(()) };
        for (column, text) in position.iter().zip([
            format!("{along}*cos({angle}) - {across}*sin({angle})"),
            format!("{along}*sin({angle}) + {across}*cos({angle})"),
        ]) {
            let shift = ModelNames::new(&mut self.system).read(&mut self.system.pool, &text)?;
            self.add_offset(column, shift)?;
        }
        Ok(())
    }

    /// Adds an offset to an output; a measured state gets an output of its own.
    fn add_offset(&mut self, column: &str, offset: Expr) -> Result<(), DiagnoseError> {
        let output = self.output_of(column)?;
        let exact = self.system.outputs[output].1;
        self.system.outputs[output].1 = self.system.pool.add(exact, offset);
        Ok(())
    }

    /// Lets an output show a state that follows it with the time constant `tau`; a measured state gets an output of its own.
    fn add_filter(&mut self, column: &str, tau: Symbol) -> Result<(), DiagnoseError> {
        let output = self.output_of(column)?;
        let name = free_name(&self.system, &format!("{column}_filtered"));
        let System { pool, states, inputs, dynamics, outputs, point, .. } = &mut self.system;
        let filtered = pool.symbol(&name);
        let (exact, y, tau) = (outputs[output].1, pool.sym(filtered), pool.sym(tau));
        let difference = pool.sub(exact, y);
        if let Some(point) = point {
            let symbols = states.iter().chain(inputs.iter()).map(|&s| pool.sym(s)).collect::<Vec<_>>();
            let values = point.states.iter().chain(&point.inputs).copied();
            let at = pool.substitute(exact, &symbols.into_iter().zip(values).collect());
            point.states.push(at);
        }
        states.push(filtered);
        dynamics.push(pool.div(difference, tau));
        outputs[output].1 = y;
        Ok(())
    }

    /// The output that a measured column shows; a measured state gets one of its own.
    fn output_of(&mut self, column: &str) -> Result<usize, DiagnoseError> {
        let system = &mut self.system;
        let own = system.outputs.iter().position(|(name, _)| name == column);
        if let Some(known) = own.or_else(|| self.measured.get(column).copied()) {
            return Ok(known);
        }
        let index = system.state_index(column);
        let index = index.ok_or_else(|| unknown("measured column", column, &system.state_names()))?;
        let name = free_name(system, &format!("{column}_measured"));
        let state = system.pool.sym(system.states[index]);
        system.outputs.push((name, state));
        self.measured.insert(column.to_owned(), system.outputs.len() - 1);
        Ok(system.outputs.len() - 1)
    }

    /// Where terms use the time, it becomes a state that starts at 0.
    fn time_as_state(&mut self) {
        let system = &mut self.system;
        let Some(index) = system.input_index(TIME_INPUT) else { return };
        let time = system.inputs.remove(index);
        system.input_derivatives.retain(|d| d.input != index);
        for d in &mut system.input_derivatives {
            d.input -= usize::from(d.input > index);
        }
        system.states.push(time);
        let one = system.pool.int(1);
        system.dynamics.push(one);
        if let Some(point) = &mut system.point {
            let at = point.inputs.remove(index);
            point.states.push(at);
        }
    }
}

/// A model with effects applied, parameters at their fitted values; effects in signal paths are omitted.
pub(crate) fn equations(system: &System, effects: &[Effect], values: &[Estimate]) -> Result<System, DiagnoseError> {
    let mut system = system.clone();
    apply_all(effects, &mut system)?;
    for estimate in values {
        set_fitted(&mut system, estimate);
    }
    Ok(system)
}

/// Gives the parameter of an estimate its fitted value; one that belongs to a signal path has none here.
fn set_fitted(system: &mut System, estimate: &Estimate) {
    if let Some(value) = decimal(rounded(estimate.value, estimate.std)) {
        system.set_parameter(&estimate.name, value);
    }
}

/// Says in the description of a parameter that it was fitted; limits that it breaks are dropped.
fn describe(system: &mut System, estimate: &Estimate, width: f64) {
    let pool = &system.pool;
    let Some(p) = system.parameters.iter_mut().find(|p| pool.name(p.symbol) == estimate.name) else { return };
    if p.min.as_ref().is_some_and(|min| p.value < *min) {
        p.min = None;
    }
    if p.max.as_ref().is_some_and(|max| p.value > *max) {
        p.max = None;
    }
    let std = estimate.widened(width);
    let fitted = format!("fitted, std {}, previously {}", significant(std, 2), rounded(estimate.nominal, std));
    p.about = Some(p.about.as_ref().map_or(fitted.clone(), |about| format!("{about} ({fitted})")));
}

/// `value` to [`EXTRA_DIGITS`] below `std`.
fn rounded(value: f64, std: f64) -> f64 {
    if !(std > 0.0 && std.is_finite()) || value == 0.0 {
        return value;
    }
    let digits = (value.abs().log10().floor() - std.log10().floor()) as i32 + EXTRA_DIGITS;
    let digits = digits.clamp(1, 16) as usize;
    format!("{value:.digits$e}").parse().unwrap_or(value)
}

/// Lets an input act later by the parameter `delay`.
fn add_delay(system: &mut System, input: &str, delay: Symbol) -> Result<(), DiagnoseError> {
    let index = input_index(system, input)?;
    let (input, delay) = (system.inputs[index], system.pool.sym(delay));
    match system.input_delays.iter_mut().find(|d| d.input == input) {
        Some(known) => known.delay = system.pool.add(known.delay, delay),
        None => system.input_delays.push(InputDelay { input, delay }),
    }
    Ok(())
}

/// Replaces an input by a state that follows it with the time constant `tau`.
fn add_lag(system: &mut System, input: &str, tau: Symbol) -> Result<(), DiagnoseError> {
    let index = input_index(system, input)?;
    let name = free_name(system, &format!("{input}_lagged"));
    let pool = &mut system.pool;
    let (input, lagged) = (system.inputs[index], pool.symbol(&name));
    let (u, y, tau) = (pool.sym(input), pool.sym(lagged), pool.sym(tau));
    let difference = pool.sub(u, y);
    let rate = pool.div(difference, tau);

    // y⁽ᵏ⁾ = (u⁽ᵏ⁻¹⁾ − y⁽ᵏ⁻¹⁾)/τ takes the place of u⁽ᵏ⁾.
    let used: Vec<InputDerivative> = system.input_derivatives.iter().copied().filter(|d| d.input == index).collect();
    let highest = used.iter().map(|d| d.order).max().unwrap_or(0);
    let symbol_of = |pool: &mut bracketry_symbolic::Pool, order: u32| {
        let known = used.iter().find(|d| d.order == order).map(|d| d.symbol);
        let base = pool.name(input).to_owned();
        known.unwrap_or_else(|| pool.symbol(&derivative_name(&base, order)))
    };
    let mut map: FxHashMap<Expr, Expr> = FxHashMap::from_iter([(u, y)]);
    let mut derivatives = Vec::new();
    let (mut of_input, mut of_lagged) = (u, y);
    for order in 1..=highest {
        let difference = pool.sub(of_input, of_lagged);
        of_lagged = pool.div(difference, tau);
        let symbol = symbol_of(pool, order);
        of_input = pool.sym(symbol);
        map.insert(of_input, of_lagged);
        if order < highest {
            derivatives.push(InputDerivative { input: index, order, symbol });
        }
    }
    system.input_derivatives.retain(|d| d.input != index);
    system.input_derivatives.extend(derivatives);
    system.input_derivatives.sort_by_key(|d| (d.input, d.order));
    system.dynamics = pool.substitute_all(&system.dynamics, &map);
    for (_, e) in system.outputs.iter_mut().chain(&mut system.definitions) {
        *e = pool.substitute(*e, &map);
    }
    for level in &mut system.static_levels {
        level.components = pool.substitute_all(&level.components, &map);
    }
    system.states.push(lagged);
    system.dynamics.push(rate);
    if let Some(point) = &mut system.point {
        point.states.push(point.inputs[index]);
    }
    Ok(())
}

/// `wanted`, with underscores after it while the model has such a name.
fn free_name(system: &System, wanted: &str) -> String {
    let taken = |name: &str| {
        symbols(system).any(|s| system.symbol_name(s) == name)
            || system.definitions.iter().chain(&system.outputs).any(|(n, _)| n == name)
    };
    let mut name = wanted.to_owned();
    while taken(&name) {
        name.push('_');
    }
    name
}
