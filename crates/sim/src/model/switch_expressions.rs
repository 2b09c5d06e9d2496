//! The expressions of a switched system that are compiled: its switches, their surfaces and gradients, derivatives of the field.

use super::drive::Driven;
use super::inputs::InputError;
use bracketry_symbolic::{Expr, Func, Func2, Rational, Symbol};
use bracketry_system::{Switch, SwitchKind, SwitchedForm, System};
use rustc_hash::FxHashMap;

/// A switch of a compiled model.
#[derive(Debug, Clone)]
pub(crate) struct ModelSwitch {
    pub(crate) name: String,
    pub(crate) components: usize,
    pub(crate) sticks: bool,
    /// Static over sliding level.
    pub(crate) static_ratio: f64,
}

/// Which derivatives of the field to compile.
#[derive(Clone, Copy)]
pub(crate) struct Differentiate<'a> {
    pub(crate) by_state: bool,
    pub(crate) by: &'a [String],
}

/// Expressions without set-valued parts, but for the symbols `kept`: signs as functions, and components of unit vectors
/// as quotients that are zero where σ is.
pub(crate) fn without_set_values(system: &mut System, expressions: &[Expr], kept: &[Symbol]) -> Vec<Expr> {
    let mut alone = system.clone();
    let form = alone.set_valued_form_of(expressions);
    if form.unit_vectors.is_empty() && kept.is_empty() {
        return expressions.to_vec();
    }
    let pool = &mut alone.pool;
    let mut values: FxHashMap<Expr, Expr> = FxHashMap::default();
    for switch in form.signs().iter().filter(|s| !kept.contains(&s.sign)) {
        let surface = pool.substitute(switch.surface, &values);
        let (symbol, sign) = (pool.sym(switch.sign), pool.call(Func::Sign, surface));
        values.insert(symbol, sign);
    }
    // Smaller than any size of σ that could be told from zero.
    let tiny = pool.rational(Rational::ONE / Rational::from(10u8).pow(300));
    for vector in &form.unit_vectors {
        let square = pool.substitute(vector.square, &values);
        let size = pool.sqrt(square);
        let size = pool.call2(Func2::Max, size, tiny);
        for switch in form.switches[vector.switches.clone()].iter().filter(|s| !kept.contains(&s.sign)) {
            let surface = pool.substitute(switch.surface, &values);
            let (symbol, component) = (pool.sym(switch.sign), pool.div(surface, size));
            values.insert(symbol, component);
        }
    }
    let expressions = pool.substitute_all(&[form.dynamics, form.outputs].concat(), &values);
    system.pool = alone.pool;
    expressions
}

/// Signs, then unit vectors.
pub(crate) fn model_switches(driven: &mut Driven, form: &SwitchedForm) -> Result<Vec<ModelSwitch>, InputError> {
    let switch =
        |name: &str, components, sticks| ModelSwitch { name: name.to_owned(), components, sticks, static_ratio: 1.0 };
    let signs = form.signs().iter().map(|s| switch(&s.name, 1, s.kind == SwitchKind::Jump));
    let vectors = form.unit_vectors.iter().map(|v| switch(&v.name, v.switches.len(), true));
    let mut switches: Vec<ModelSwitch> = signs.chain(vectors).collect();
    let system = &mut driven.system;
    for level in system.static_levels.clone() {
        // One of a switch that the inputs make constant has nothing to act on.
        let Some(i) = system.switch_of(form, &level) else { continue };
        let live: Vec<(Expr, Expr)> = driven
            .driving
            .live_values()
            .filter_map(|(slot, value)| {
                let number = Rational::try_from(value).ok()?;
                Some((system.pool.sym(driven.slots[slot]), system.pool.rational(number)))
            })
            .collect();
        let ratio = system.pool.substitute(level.ratio, &live.into_iter().collect());
        let ratio = system.value(ratio).unwrap_or(f64::NAN);
        if !(1.0..f64::INFINITY).contains(&ratio) {
            return Err(InputError::StaticLevel { switch: switches[i].name.clone(), ratio });
        }
        switches[i].static_ratio = ratio;
    }
    Ok(switches)
}

/// The surfaces with the signs of inner switches as functions again (an inner switch comes before an outer one).
pub(crate) fn plain_surfaces(system: &mut System, switches: &[Switch]) -> Result<Vec<Expr>, InputError> {
    let mut signs: FxHashMap<Expr, Expr> = FxHashMap::default();
    let mut surfaces = Vec::new();
    for outer in switches {
        let used = system.pool.symbols_of(&[outer.surface]);
        if let Some(inner) = switches.iter().find(|inner| inner.kind == SwitchKind::Jump && used.contains(&inner.sign))
        {
            return Err(InputError::NestedJump { outer: outer.name.clone(), inner: inner.name.clone() });
        }
        let surface = system.pool.substitute(outer.surface, &signs);
        let symbol = system.pool.sym(outer.sign);
        let sign = system.pool.call(Func::Sign, surface);
        signs.insert(symbol, sign);
        surfaces.push(surface);
    }
    Ok(surfaces)
}

/// The derivatives of the dynamics by states, signs and live numbers, one after the other, then those of the switching functions by
/// live numbers; none if a live number moves the surface of a sign on which the dynamics jump. Unit vectors turn with their σ.
pub(crate) fn derivatives(
    driven: &mut Driven,
    form: &SwitchedForm,
    surfaces: &[Expr],
    wanted: Differentiate<'_>,
) -> Result<Option<Vec<Expr>>, InputError> {
    let mut numbers = Vec::with_capacity(wanted.by.len());
    for name in wanted.by {
        let slot = driven.driving.live_slot(name);
        numbers.push(driven.slots[slot.ok_or_else(|| InputError::UnknownLive { name: name.clone() })?]);
    }
    let pool = &mut driven.system.pool;
    let jumps: Vec<Expr> = form.signs().iter().filter(|s| s.kind == SwitchKind::Jump).map(|s| s.surface).collect();
    if pool.symbols_of(&jumps).iter().any(|s| numbers.contains(s)) {
        return Ok(None);
    }
    let mut symbols = Vec::new();
    if wanted.by_state {
        symbols.extend(&driven.system.states);
    }
    symbols.extend(form.switches.iter().map(|s| s.sign));
    symbols.extend(&numbers);
    let mut all = Vec::with_capacity(symbols.len() * form.dynamics.len());
    for symbol in symbols {
        all.extend(form.dynamics.iter().map(|&f| pool.diff(f, symbol)));
    }
    for number in numbers {
        all.extend(surfaces.iter().map(|&surface| pool.diff(surface, number)));
    }
    Ok(Some(all))
}

/// The dynamics and `∂f_j/∂s_i` by columns, if these do not depend on the signs.
pub(crate) fn with_derivatives_by_signs(
    system: &mut System,
    switches: &[Switch],
    dynamics: &[Expr],
) -> Option<Vec<Expr>> {
    let mut all = dynamics.to_vec();
    for switch in switches {
        all.extend(dynamics.iter().map(|&f| system.pool.diff(f, switch.sign)));
    }
    let used = system.pool.symbols_of(&all[dynamics.len()..]);
    switches.iter().all(|switch| !used.contains(&switch.sign)).then_some(all)
}

/// `∂σ_i/∂x_j` by rows, then `∂σ_i/∂t` including what moves with time; `surfaces` as [`plain_surfaces`] gives them.
pub(crate) fn surface_gradients(driven: &mut Driven, switches: &[Switch], surfaces: &[Expr]) -> Vec<Expr> {
    let pool = &mut driven.system.pool;
    let mut signs: FxHashMap<Expr, Expr> = FxHashMap::default();
    for (switch, surface) in switches.iter().zip(surfaces) {
        let symbol = pool.sym(switch.sign);
        let sign = pool.call(Func::Sign, *surface);
        signs.insert(symbol, sign);
    }
    let mut all = Vec::new();
    for switch in switches {
        all.extend(pool.gradient(switch.surface, &driven.system.states));
    }
    for switch in switches {
        let mut sum = pool.diff(switch.surface, driven.time);
        for (symbol, rate) in &driven.rates {
            let by_slot = pool.diff(switch.surface, *symbol);
            let term = pool.mul(by_slot, *rate);
            sum = pool.add(sum, term);
        }
        all.push(sum);
    }
    pool.substitute_all(&all, &signs)
}
