//! Substituting the inputs of a system by what drives them.

use super::driving::Driving;
use super::impulses::jumps;
use super::inputs::{Drive, Hold, InputError, Inputs, Samples};
use bracketry_symbolic::{Expr, Names, Pool, Symbol};
use bracketry_system::{InputDerivative, System};
use rustc_hash::FxHashMap;
use std::collections::BTreeMap;

/// Name of time in the pool; no model can declare it.
pub(crate) const TIME: &str = "(t)";

/// A system whose inputs have been substituted.
pub(crate) struct Driven {
    /// The system; the inputs and live numbers that remain are slots.
    pub(crate) system: System,
    /// The symbol of time.
    pub(crate) time: Symbol,
    /// Outputs, then inputs, as expressions.
    pub(crate) outputs: Vec<Expr>,
    /// The symbols that stay arguments besides time and states.
    pub(crate) slots: Vec<Symbol>,
    /// Their values.
    pub(crate) driving: Driving,
    /// Time derivatives of slots that move.
    pub(crate) rates: Vec<(Symbol, Expr)>,
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
    /// A slot that follows samples; of a linear signal also the slope, as the slot's rate.
    fn follow(&mut self, symbol: Symbol, of: (&str, u32), samples: &Samples, delay: f64) {
        self.slots.push(symbol);
        self.driving.add_samples(of, samples.clone(), delay);
        if samples.hold == Hold::Linear {
            let name = format!("(slope of {})", self.system.symbol_name(symbol));
            let slope = self.system.pool.symbol(&name);
            self.slots.push(slope);
            self.driving.add_slope();
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
            self.slots.push(symbol);
            self.driving.add_live(name, *value);
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

/// Substitutes expressions, makes slots of the others, and checks that every derivative the system uses is known.
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
        driving: Driving::default(),
        rates: Vec::new(),
        values: FxHashMap::default(),
        impulses: Vec::new(),
    };
    let mut scope = driven.numbers(inputs)?;
    let mut map: FxHashMap<Expr, Expr> = FxHashMap::default();
    let delays = driven.input_delays(&known)?;
    for (index, (name, &delay)) in known.iter().zip(&delays).enumerate() {
        let symbol = driven.system.inputs[index];
        let derivatives = driven.system.input_derivatives.iter().filter(|d| d.input == index).copied().collect();
        let this = driven.system.pool.sym(symbol);
        let input = Input { index, name, symbol, this, delay, derivatives };
        match inputs.drives.get(name) {
            None if inputs.derivatives.keys().any(|(given, _)| given == name) => {
                driven.by_derivatives(&input, &inputs.derivatives)?;
            }
            None => driven.by_hand(&input, &mut map),
            Some(Drive::Expression(text)) => driven.by_expression(&input, text, &mut scope, &mut map)?,
            Some(Drive::Samples(samples)) => driven.by_samples(&input, samples, &inputs.derivatives, &mut map)?,
        }
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

/// An input of the system.
struct Input<'a> {
    index: usize,
    name: &'a str,
    symbol: Symbol,
    this: Expr,
    /// s
    delay: f64,
    /// Those of its derivatives that the system uses.
    derivatives: Vec<InputDerivative>,
}

/// Samples of derivatives, by input and order.
type Derivatives = BTreeMap<(String, u32), Samples>;

impl Driven {
    /// Only derivatives of the input are given, by samples.
    fn by_derivatives(&mut self, input: &Input<'_>, given: &Derivatives) -> Result<(), InputError> {
        let used = [&self.system.dynamics[..], &outputs_of(&self.system)].concat();
        if self.system.pool.symbols_of(&used).contains(&input.symbol) {
            return Err(InputError::OnlyDerivatives { input: input.name.to_owned() });
        }
        self.slots.push(input.symbol);
        self.driving.add_held(0.0);
        self.driving.push_input(None);
        for d in &input.derivatives {
            let samples = given.get(&(input.name.to_owned(), d.order)).ok_or_else(|| input.missing(d.order))?;
            self.follow(d.symbol, (input.name, d.order), samples, input.delay);
        }
        Ok(())
    }

    /// The input is held, its derivatives are zero.
    fn by_hand(&mut self, input: &Input<'_>, map: &mut FxHashMap<Expr, Expr>) {
        self.slots.push(input.symbol);
        let slot = self.driving.add_held(input.delay);
        self.driving.push_input(Some(slot));
        for d in &input.derivatives {
            let (e, zero) = (self.system.pool.sym(d.symbol), self.system.pool.int(0));
            map.insert(e, zero);
        }
    }

    fn by_expression(
        &mut self,
        input: &Input<'_>,
        text: &str,
        scope: &mut Scope,
        map: &mut FxHashMap<Expr, Expr>,
    ) -> Result<(), InputError> {
        self.driving.push_input(None);
        let parsed = self.system.pool.parse_with(text, scope);
        let parsed = parsed.map_err(|source| InputError::Expression { input: input.name.to_owned(), source })?;
        let mut e = self.at_command(parsed, input.index);
        map.insert(input.this, e);
        let highest = input.derivatives.iter().map(|d| d.order).max().unwrap_or(0);
        let mut impulsive = false;
        for order in 1..=highest {
            impulsive = impulsive || jumps(&mut self.system.pool, e, self.time);
            e = self.system.pool.diff(e, self.time);
            for d in input.derivatives.iter().filter(|d| d.order == order) {
                let symbol = self.system.pool.sym(d.symbol);
                map.insert(symbol, e);
                if impulsive {
                    self.impulses.push((input.name.to_owned(), order));
                }
            }
        }
        Ok(())
    }

    fn by_samples(
        &mut self,
        input: &Input<'_>,
        samples: &Samples,
        given: &Derivatives,
        map: &mut FxHashMap<Expr, Expr>,
    ) -> Result<(), InputError> {
        self.driving.push_input(None);
        self.follow(input.symbol, (input.name, 0), samples, input.delay);
        let slope = self.rates.last().filter(|(s, _)| *s == input.symbol).map(|(_, rate)| *rate);
        for d in &input.derivatives {
            let e = self.system.pool.sym(d.symbol);
            match (given.get(&(input.name.to_owned(), d.order)), slope) {
                (Some(samples), _) => self.follow(d.symbol, (input.name, d.order), samples, input.delay),
                (None, Some(slope)) if d.order == 1 => {
                    map.insert(e, slope);
                }
                _ => return Err(input.missing(d.order)),
            }
        }
        Ok(())
    }
}

impl Input<'_> {
    fn missing(&self, order: u32) -> InputError {
        InputError::MissingDerivative { input: self.name.to_owned(), order }
    }
}

fn outputs_of(system: &System) -> Vec<Expr> {
    system.outputs.iter().map(|(_, e)| *e).collect()
}
