//! Changing a model by an effect.

use bracketry_symbolic::{Expr, Pool, Rational, Symbol};
use bracketry_system::{Parameter, System};

use super::names::{ModelNames, state_index, symbols};
use super::replace::replace_all;
use super::stretch::{merged, stretched};
use crate::effect::{Change, Coefficient, Effect};
use crate::error::DiagnoseError;

/// Makes the changes of several effects in a model: terms first, then substitutions, so that these act on what others
/// add as well (friction that is coupled over the axes is so in every term), then what changes the roots that these bring. Coefficients
/// that have one value only become numbers: what they replace is gone.
///
/// # Errors
/// As [`Effect::apply`].
pub(crate) fn apply_all(effects: &[Effect], system: &mut System) -> Result<(), DiagnoseError> {
    let turn = |effect: &Effect| match effect.change {
        Change::Terms(_) | Change::Hidden { .. } => 0,
        Change::Substitution { .. } => 1,
        Change::Stretch { .. } | Change::Several(_) => 2,
        Change::TrackedPoint { .. } | Change::Path { .. } => 3,
    };
    let effects = merged(&parted(effects));
    for effect in (0..4).flat_map(|now| effects.iter().filter(move |e| turn(e) == now)) {
        effect.apply(system)?;
        for (c, value) in effect.coefficients.iter().filter_map(|c| Some((c, decimal(c.settled()?)?))) {
            let symbol = system.pool.symbol(&c.name);
            let map = std::iter::once((system.pool.sym(symbol), system.pool.rational(value))).collect();
            let rows = system.dynamics.clone();
            system.dynamics = system.pool.substitute_all(&rows, &map);
            system.parameters.retain(|p| p.symbol != symbol);
            drop_lost_static_levels(system);
        }
    }
    Ok(())
}

/// The effects with each of several changes apart; the first of them brings the coefficients.
fn parted(effects: &[Effect]) -> Vec<Effect> {
    let mut parted = Vec::with_capacity(effects.len());
    for effect in effects {
        let Change::Several(changes) = &effect.change else {
            parted.push(effect.clone());
            continue;
        };
        let mut coefficients = effect.coefficients.clone();
        for change in changes {
            let coefficients = std::mem::take(&mut coefficients);
            parted.push(Effect { change: change.clone(), coefficients, ..effect.clone() });
        }
    }
    parted
}

impl Effect {
    /// Makes the change in a model: the coefficients become parameters at their nominal values, so that the equations
    /// keep their values as long as the amplitudes are not given others.
    ///
    /// Terms and substitutions are read with the names of the model (states, inputs and their derivatives, parameters,
    /// definitions) and those of the coefficients. Derivatives of inputs that the model did not use are appended to
    /// [`System::input_derivatives`]; if [`TIME_INPUT`](crate::TIME_INPUT) is used, an input of that name is appended. A change of what
    /// is measured or of a signal's path is none of the equations and leaves the system as it is. Static levels of signs that are replaced are
    /// dropped.
    ///
    /// # Errors
    /// [`DiagnoseError::Term`] for an expression that cannot be read, [`DiagnoseError::UnknownName`] for an equation
    /// that the model does not have, [`DiagnoseError::NameTaken`] for a coefficient that it has already,
    /// [`DiagnoseError::NothingReplaced`] for a substitution that does not occur. The system is then unchanged.
    pub fn apply(&self, system: &mut System) -> Result<(), DiagnoseError> {
        if matches!(self.change, Change::Path { .. } | Change::TrackedPoint { .. }) {
            return Ok(());
        }
        let mut changed = system.clone();
        self.add_coefficients(&mut changed)?;
        let mut names = ModelNames::new(&mut changed);
        change_equations(&self.change, &mut changed, &mut names)?;
        names.register(&mut changed);
        *system = changed;
        Ok(())
    }

    fn add_coefficients(&self, system: &mut System) -> Result<(), DiagnoseError> {
        for c in &self.coefficients {
            if symbols(system).any(|s| system.pool.name(s) == c.name)
                || system.definitions.iter().any(|(n, _)| *n == c.name)
            {
                return Err(DiagnoseError::NameTaken { name: c.name.clone() });
            }
            let parameter = parameter(c, system.pool.symbol(&c.name))?;
            system.parameters.push(parameter);
        }
        Ok(())
    }
}

fn change_equations(change: &Change, system: &mut System, names: &mut ModelNames) -> Result<(), DiagnoseError> {
    match change {
        Change::Terms(terms) => {
            for (state, text) in terms {
                let row = state_index(system, state)?;
                let term = names.read(&mut system.pool, text)?;
                system.dynamics[row] = system.pool.add(system.dynamics[row], term);
            }
        }
        Change::Substitution { states, pairs } => {
            let mut replaced = Vec::with_capacity(pairs.len());
            for (from, to) in pairs {
                let from = names.read(&mut system.pool, from)?;
                replaced.push((from, names.read(&mut system.pool, to)?));
            }
            let rows: Vec<usize> = if states.is_empty() {
                (0..system.states.len()).collect()
            } else {
                states.iter().map(|s| state_index(system, s)).collect::<Result<_, _>>()?
            };
            if !replace(system, &rows, &replaced) {
                let text = pairs.iter().map(|p| p.0.as_str()).collect::<Vec<_>>().join(", ");
                return Err(DiagnoseError::NothingReplaced { text });
            }
        }
        Change::Stretch { square, slips, lengths, spins } => {
            let pairs = stretched(&mut system.pool, names, square, slips, lengths, spins)?;
            let rows: Vec<usize> = (0..system.states.len()).collect();
            if !replace(system, &rows, &pairs) && !lengths.is_empty() {
                return Err(DiagnoseError::NothingReplaced { text: format!("1/sqrt({square})") });
            }
        }
        Change::Several(changes) => {
            for change in changes {
                change_equations(change, system, names)?;
            }
        }
        Change::Hidden { states, change } => {
            let zero = system.pool.int(0);
            for state in states {
                if symbols(system).any(|s| system.pool.name(s) == state.name) {
                    return Err(DiagnoseError::NameTaken { name: state.name.clone() });
                }
                let symbol = system.pool.symbol(&state.name);
                names.add(&state.name, system.pool.sym(symbol));
                system.states.push(symbol);
                if let Some(point) = &mut system.point {
                    point.states.push(zero);
                }
            }
            for state in states {
                let rate = names.read(&mut system.pool, &state.rate)?;
                system.dynamics.push(rate);
            }
            change_equations(change, system, names)?;
        }
        Change::Path { .. } | Change::TrackedPoint { .. } => {}
    }
    Ok(())
}

/// Replaces expressions in some equations; whether any has changed.
fn replace(system: &mut System, rows: &[usize], pairs: &[(Expr, Expr)]) -> bool {
    let old: Vec<Expr> = rows.iter().map(|&r| system.dynamics[r]).collect();
    let new = replace_all(&mut system.pool, &old, pairs);
    if old == new {
        return false;
    }
    for (&row, e) in rows.iter().zip(new) {
        system.dynamics[row] = e;
    }
    drop_lost_static_levels(system);
    true
}

/// The decimal that a model file would show, not the binary fraction behind it; `None` if `x` is not finite.
pub(crate) fn decimal(x: f64) -> Option<Rational> {
    let mut pool = Pool::new();
    let e = pool.parse(&format!("{x:e}")).ok()?;
    pool.number(e).cloned()
}

/// The parameter that a coefficient becomes, at its nominal value.
pub(crate) fn parameter(c: &Coefficient, symbol: Symbol) -> Result<Parameter, DiagnoseError> {
    let Some(value) = decimal(c.nominal) else {
        return Err(DiagnoseError::Setting {
            name: "the nominal value of a coefficient",
            value: c.nominal,
            requirement: "finite",
        });
    };
    let bound = |x: f64| if x.is_finite() { decimal(x) } else { None };
    let text = |t: &str| if t.is_empty() { None } else { Some(t.to_owned()) };
    Ok(Parameter { symbol, value, min: bound(c.min), max: bound(c.max), unit: text(&c.unit), about: text(&c.about) })
}

/// Drops static levels whose sign or unit vector does not occur any more.
fn drop_lost_static_levels(system: &mut System) {
    if system.static_levels.is_empty() {
        return;
    }
    let form = system.set_valued_form();
    let levels = std::mem::take(&mut system.static_levels);
    system.static_levels = levels.into_iter().filter(|l| system.switch_of(&form, l).is_some()).collect();
}
