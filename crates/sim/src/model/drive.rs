//! Substituting the inputs of a system by what drives them.

use super::impulses::jumps;
use super::inputs::{Drive, Hold, InputError, Inputs, Samples};
use bracketry_symbolic::{Expr, Names, Pool, Symbol};
use bracketry_system::System;
use rustc_hash::FxHashMap;

/// Name of time in the pool; no model can declare it.
pub(crate) const TIME: &str = "(t)";

/// Where the value of a slot comes from.
#[derive(Debug, Clone)]
pub(crate) enum Source {
    /// It lasts until it is set.
    Held(f64),
    /// The value of a table of samples.
    Value(usize),
    /// The slope of a table of samples.
    Slope(usize),
}

/// A system whose inputs have been substituted.
pub(crate) struct Driven {
    /// The system; the inputs and live numbers that remain are slots.
    pub(crate) system: System,
    /// The symbol of time.
    pub(crate) time: Symbol,
    /// Outputs, then inputs, as expressions.
    pub(crate) outputs: Vec<Expr>,
    /// The symbols that stay arguments besides time and states, with their sources.
    pub(crate) slots: Vec<Symbol>,
    pub(crate) sources: Vec<Source>,
    pub(crate) tables: Vec<Samples>,
    /// By how much each is shifted, s.
    pub(crate) delays: Vec<f64>,
    /// Input and order of derivative of each table.
    pub(crate) tabulated: Vec<(String, u32)>,
    /// Time derivatives of slots that move.
    pub(crate) rates: Vec<(Symbol, Expr)>,
    /// The slot of each held input.
    pub(crate) held: Vec<Option<usize>>,
    /// Delayed held inputs: slot and table.
    pub(crate) queues: Vec<(usize, usize)>,
    /// The slot of each live number.
    pub(crate) live: Vec<(String, usize)>,
    /// Parameters → their values, but for live ones.
    pub(crate) values: FxHashMap<Expr, Expr>,
    /// Input derivatives, by input and order, whose impulses are left out.
    pub(crate) impulses: Vec<(String, u32)>,
}

/// The names an input expression may use.
struct Scope(FxHashMap<String, Expr>);

impl Names for Scope {
    fn lookup(&mut self, _pool: &mut Pool, name: &str) -> Option<Expr> {
        self.0.get(name).copied()
    }

    fn known(&self) -> Vec<String> {
        self.0.keys().cloned().collect()
    }
}

impl Driven {
    fn slot(&mut self, symbol: Symbol, source: Source) -> usize {
        self.slots.push(symbol);
        self.sources.push(source);
        self.slots.len() - 1
    }

    /// A slot that follows samples; of a linear signal also the slope, as the slot's rate.
    fn follow(&mut self, symbol: Symbol, (input, order): (&str, u32), samples: &Samples, delay: f64) {
        self.tables.push(samples.clone().delayed(delay));
        self.delays.push(delay);
        self.tabulated.push((input.to_owned(), order));
        let table = self.tables.len() - 1;
        self.slot(symbol, Source::Value(table));
        if samples.hold == Hold::Linear {
            let name = format!("(slope of {})", self.system.symbol_name(symbol));
            let slope = self.system.pool.symbol(&name);
            self.slot(slope, Source::Slope(table));
            let rate = self.system.pool.sym(slope);
            self.rates.push((symbol, rate));
        }
    }

    /// The delays of all inputs in seconds.
    fn input_delays(&mut self, names: &[String]) -> Result<Vec<f64>, InputError> {
        let delays = self.system.delay_values().into_iter().zip(names);
        delays
            .map(|(delay, name)| {
                delay.filter(|d| *d >= 0.0 && d.is_finite()).ok_or_else(|| InputError::Delay { input: name.clone() })
            })
            .collect()
    }

    /// An expression of time, taken earlier by the delay of an input.
    fn at_command(&mut self, e: Expr, input: usize) -> Expr {
        let symbol = self.system.inputs[input];
        let Some(delay) = self.system.input_delays.iter().find(|d| d.input == symbol).map(|d| d.delay) else {
            return e;
        };
        let delay = self.system.with_values(&[delay])[0];
        let pool = &mut self.system.pool;
        let time = pool.sym(self.time);
        let earlier = pool.sub(time, delay);
        pool.substitute(e, &FxHashMap::from_iter([(time, earlier)]))
    }

    /// A slot of a held input; with a delay, a table of what was set.
    fn hold(&mut self, symbol: Symbol, delay: f64) -> usize {
        if delay == 0.0 {
            return self.slot(symbol, Source::Held(0.0));
        }
        self.tables.push(Samples::silence());
        self.delays.push(delay);
        self.tabulated.push((String::new(), 0));
        let table = self.tables.len() - 1;
        let slot = self.slot(symbol, Source::Value(table));
        self.queues.push((slot, table));
        slot
    }

    /// Live numbers and parameters.
    fn numbers(&mut self, inputs: &Inputs) -> Result<Scope, InputError> {
        let mut scope = FxHashMap::default();
        let time = self.system.pool.sym(self.time);
        scope.insert("t".to_owned(), time);
        for (name, value) in &inputs.live {
            let symbol = self.system.pool.symbol(name);
            if self.system.states.contains(&symbol) || self.system.inputs.contains(&symbol) {
                return Err(InputError::NameTaken { name: name.clone() });
            }
            let slot = self.slot(symbol, Source::Held(*value));
            self.live.push((name.clone(), slot));
            let e = self.system.pool.sym(symbol);
            scope.insert(name.clone(), e);
        }
        for p in self.system.parameters.clone() {
            let name = self.system.symbol_name(p.symbol).to_owned();
            if scope.contains_key(&name) && self.slots.contains(&p.symbol) {
                continue;
            }
            let e = self.system.pool.sym(p.symbol);
            let value = self.system.pool.rational(p.value);
            self.values.insert(e, value);
            scope.entry(name).or_insert(e);
        }
        Ok(Scope(scope))
    }
}

/// Substitutes expressions, makes slots of the rest, and checks that every derivative the system uses is known.
pub(crate) fn drive(system: &System, inputs: &Inputs) -> Result<Driven, InputError> {
    let mut system = system.clone();
    let known = system.input_names();
    for name in inputs.drives.keys().chain(inputs.derivatives.keys().map(|(name, _)| name)) {
        if !known.contains(name) {
            return Err(InputError::UnknownInput { name: name.clone(), known });
        }
    }
    let time = system.pool.symbol(TIME);
    let mut driven = Driven {
        system,
        time,
        outputs: Vec::new(),
        slots: Vec::new(),
        sources: Vec::new(),
        tables: Vec::new(),
        delays: Vec::new(),
        tabulated: Vec::new(),
        rates: Vec::new(),
        held: Vec::new(),
        queues: Vec::new(),
        live: Vec::new(),
        values: FxHashMap::default(),
        impulses: Vec::new(),
    };
    let mut scope = driven.numbers(inputs)?;
    let mut map: FxHashMap<Expr, Expr> = FxHashMap::default();
    let delays = driven.input_delays(&known)?;
    for (input, name) in known.iter().enumerate() {
        let delay = delays[input];
        let symbol = driven.system.inputs[input];
        let this = driven.system.pool.sym(symbol);
        let mut derivatives = driven.system.input_derivatives.clone();
        derivatives.retain(|d| d.input == input);
        let mut held = None;
        match inputs.drives.get(name) {
            None if inputs.derivatives.keys().any(|(given, _)| given == name) => {
                let used = [&driven.system.dynamics[..], &outputs_of(&driven.system)].concat();
                if driven.system.pool.symbols_of(&used).contains(&symbol) {
                    return Err(InputError::OnlyDerivatives { input: name.clone() });
                }
                driven.slot(symbol, Source::Held(0.0));
                for d in derivatives {
                    match inputs.derivatives.get(&(name.clone(), d.order)) {
                        Some(samples) => driven.follow(d.symbol, (name, d.order), samples, delay),
                        None => return Err(InputError::MissingDerivative { input: name.clone(), order: d.order }),
                    }
                }
            }
            None => {
                held = Some(driven.hold(symbol, delay));
                for d in derivatives {
                    let (e, zero) = (driven.system.pool.sym(d.symbol), driven.system.pool.int(0));
                    map.insert(e, zero);
                }
            }
            Some(Drive::Expression(text)) => {
                let mut e = driven
                    .system
                    .pool
                    .parse_with(text, &mut scope)
                    .map_err(|source| InputError::Expression { input: name.clone(), source })?;
                e = driven.at_command(e, input);
                map.insert(this, e);
                let highest = derivatives.iter().map(|d| d.order).max().unwrap_or(0);
                let mut impulsive = false;
                for order in 1..=highest {
                    impulsive = impulsive || jumps(&mut driven.system.pool, e, time);
                    e = driven.system.pool.diff(e, time);
                    for d in derivatives.iter().filter(|d| d.order == order) {
                        let symbol = driven.system.pool.sym(d.symbol);
                        map.insert(symbol, e);
                        if impulsive {
                            driven.impulses.push((name.clone(), order));
                        }
                    }
                }
            }
            Some(Drive::Samples(samples)) => {
                driven.follow(symbol, (name, 0), samples, delay);
                let slope = driven.rates.last().filter(|(s, _)| *s == symbol).map(|(_, rate)| *rate);
                for d in derivatives {
                    let e = driven.system.pool.sym(d.symbol);
                    match (inputs.derivatives.get(&(name.clone(), d.order)), slope) {
                        (Some(samples), _) => driven.follow(d.symbol, (name, d.order), samples, delay),
                        (None, Some(slope)) if d.order == 1 => {
                            map.insert(e, slope);
                        }
                        _ => return Err(InputError::MissingDerivative { input: name.clone(), order: d.order }),
                    }
                }
            }
        }
        driven.held.push(held);
    }
    let system = &mut driven.system;
    let measured = outputs_of(system);
    let inputs: Vec<Expr> = system.inputs.clone().into_iter().map(|s| system.pool.sym(s)).collect();
    system.dynamics = system.pool.substitute_all(&system.dynamics, &map);
    driven.outputs = system.pool.substitute_all(&[measured, inputs].concat(), &map);
    system.outputs.clear();
    for level in &mut system.static_levels {
        level.components = system.pool.substitute_all(&level.components, &map);
    }
    Ok(driven)
}

fn outputs_of(system: &System) -> Vec<Expr> {
    system.outputs.iter().map(|(_, e)| *e).collect()
}
