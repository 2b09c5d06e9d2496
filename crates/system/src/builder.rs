//! Systems built by calls.

use std::cell::RefCell;
use std::ops::{Bound, RangeBounds};

use bracketry_symbolic::{Expr, Node, Rational, Symbol};
use rustc_hash::{FxHashMap, FxHashSet};

use crate::rules::{Declared, ModelError, check_parameter, check_range};
use crate::scope::{Derivatives, Scope};
use crate::system::{InputDelay, InputRange, Parameter, Point, StaticLevel, System};
use crate::term::{Operand, Sheet, Term};
use crate::time_unit::TimeUnit;

/// A [`System`] in the making: what a model file says, said by calls.
///
/// Names become [`Term`]s, which are computed with as with numbers. What is wrong is told once, by [`Builder::build`].
///
/// ```
/// use bracketry_system::System;
/// let b = System::builder("unicycle");
/// let [x, y, th] = b.states(["x", "y", "th"]);
/// let [u1, u2] = b.inputs(["u1", "u2"]);
/// b.dynamics(x, u1 * th.cos());
/// b.dynamics(y, u1 * th.sin());
/// b.dynamics(th, u2);
/// b.output("range2", (x * x + y * y) / 2);
/// let unicycle = b.build()?;
/// assert_eq!(unicycle.pool.text(unicycle.dynamics[0]), "u1*cos(th)");
/// # Ok::<(), bracketry_system::ModelError>(())
/// ```
///
/// Dry friction is `sign`; its static level is a multiple of the sliding one:
///
/// ```
/// use bracketry_system::System;
/// let b = System::builder("block");
/// let [p, v] = b.states(["p", "v"]);
/// let u = b.input("u");
/// let (m, c) = (b.parameter("m", 2.0), b.parameter("c", 0.3));
/// b.dynamics(p, v);
/// b.dynamics(v, (u - c * v.sign()) / m);
/// b.static_level([v], 1.5);
/// let block = b.build()?;
/// assert_eq!(block.modes().unwrap().len(), 2);
/// # Ok::<(), bracketry_system::ModelError>(())
/// ```
pub struct Builder {
    sheet: Sheet,
    draft: RefCell<Draft>,
}

/// What was said so far; its pool is that of the sheet.
#[derive(Default)]
struct Draft {
    system: System,
    declared: Declared,
    /// Names that formulas may use.
    names: FxHashMap<String, Expr>,
    derivatives: Derivatives,
    /// What names in formulas stood for.
    met: FxHashSet<Expr>,
    rates: FxHashMap<Symbol, Expr>,
    point: Vec<(Symbol, Expr)>,
    static_levels: Vec<StaticLevel>,
}

impl System {
    /// Begins a system of this name.
    pub fn builder(name: impl Into<String>) -> Builder {
        let system = System { name: name.into(), ..System::default() };
        Builder { sheet: Sheet::default(), draft: RefCell::new(Draft { system, ..Draft::default() }) }
    }
}

impl Builder {
    fn term(&self, expr: Expr) -> Term<'_> {
        Term { sheet: &self.sheet, expr }
    }

    fn check(&self, result: Result<(), ModelError>) {
        if let Err(error) = result {
            self.sheet.refuse(error);
        }
    }

    fn declare(&self, name: &str, kind: &'static str) -> (Symbol, Term<'_>) {
        let mut draft = self.draft.borrow_mut();
        self.check(draft.declared.add(name, kind));
        let mut pool = self.sheet.pool.borrow_mut();
        let symbol = pool.symbol(name);
        let expr = pool.sym(symbol);
        draft.names.insert(name.to_owned(), expr);
        (symbol, self.term(expr))
    }

    /// The symbol that a term is, if it is one.
    fn symbol(&self, term: Term<'_>) -> Option<Symbol> {
        match self.sheet.pool.borrow().node(self.sheet.expr(term.into())) {
            Node::Sym(s) => Some(s),
            _ => None,
        }
    }

    /// A new state.
    pub fn state(&self, name: &str) -> Term<'_> {
        let (symbol, term) = self.declare(name, "state");
        self.draft.borrow_mut().system.states.push(symbol);
        term
    }

    /// New states, in order.
    pub fn states<const N: usize>(&self, names: [&str; N]) -> [Term<'_>; N] {
        names.map(|name| self.state(name))
    }

    /// A new input.
    pub fn input(&self, name: &str) -> Term<'_> {
        let (symbol, term) = self.declare(name, "input");
        self.draft.borrow_mut().system.inputs.push(symbol);
        term
    }

    /// New inputs, in order.
    pub fn inputs<const N: usize>(&self, names: [&str; N]) -> [Term<'_>; N] {
        names.map(|name| self.input(name))
    }

    /// A new parameter with its value.
    pub fn parameter(&self, name: &str, value: impl Into<f64>) -> Term<'_> {
        let (symbol, term) = self.declare(name, "parameter");
        let value = self.sheet.exact(value.into());
        let parameter = Parameter { symbol, value, min: None, max: None, unit: None, about: None };
        self.draft.borrow_mut().system.parameters.push(parameter);
        term
    }

    /// Unit and description of a parameter, a state, or an input, which reports and figures show.
    pub fn describe(&self, term: Term<'_>, unit: &str, about: &str) {
        let symbol = self.symbol(term);
        let system = &mut self.draft.borrow_mut().system;
        if let Some(p) = system.parameters.iter_mut().find(|p| Some(p.symbol) == symbol) {
            (p.unit, p.about) = (Some(unit.to_owned()), Some(about.to_owned()));
        } else if system.states.iter().chain(&system.inputs).any(|s| Some(*s) == symbol) {
            let name = term.to_string();
            system.quantities.set_unit(&name, unit);
            system.quantities.set_label(&name, about);
        } else {
            self.refuse(
                format!("`{term}` is neither a parameter nor a state nor an input"),
                "describe parameters, states, and inputs",
            );
        }
    }

    /// The unit of the time in the equations; seconds where none is stated.
    pub fn time_unit(&self, unit: TimeUnit) {
        self.draft.borrow_mut().system.quantities.time_unit = unit;
    }

    /// The values that an input or a parameter can take, ends included: `b.range(u, -1.0..=1.0)`, `b.range(u, 0.0..)`.
    pub fn range(&self, term: Term<'_>, range: impl RangeBounds<f64>) {
        let end = |bound: Bound<&f64>| -> Option<Rational> {
            match bound {
                Bound::Included(value) => Some(self.sheet.exact(*value)),
                Bound::Excluded(value) => {
                    self.refuse(format!("the range of `{term}` excludes its end {value}"), "write a..=b");
                    None
                }
                Bound::Unbounded => None,
            }
        };
        let (min, max) = (end(range.start_bound()), end(range.end_bound()));
        let (name, symbol) = (term.to_string(), self.symbol(term));
        let system = &mut self.draft.borrow_mut().system;
        if let Some(p) = system.parameters.iter_mut().find(|p| Some(p.symbol) == symbol) {
            self.check(check_parameter(&name, &p.value, min.as_ref(), max.as_ref()));
            (p.min, p.max) = (min, max);
        } else if let Some(&input) = system.inputs.iter().find(|u| Some(**u) == symbol) {
            self.check(check_range(&name, min.as_ref(), max.as_ref()));
            system.input_ranges.push(InputRange { input, min, max });
        } else {
            self.refuse(
                format!("`{name}` is neither an input nor a parameter"),
                "give ranges to inputs and parameters",
            );
        }
    }

    /// Seconds that an input acts later than it is commanded: a number, or an expression of parameters.
    pub fn delay<'b>(&'b self, input: Term<'b>, delay: impl Into<Operand<'b>>) {
        let (symbol, delay) = (self.symbol(input), self.sheet.expr(delay.into()));
        let system = &mut self.draft.borrow_mut().system;
        match system.inputs.iter().find(|u| Some(**u) == symbol) {
            Some(&input) => system.input_delays.push(InputDelay { input, delay }),
            None => self.refuse(format!("`{input}` is not an input"), "give delays to inputs"),
        }
    }

    /// The time derivative of an order from 1 of an input.
    pub fn derivative(&self, input: Term<'_>, order: u32) -> Term<'_> {
        let symbol = self.symbol(input);
        let name = input.to_string();
        let draft = &mut *self.draft.borrow_mut();
        match draft.system.inputs.iter().position(|u| Some(*u) == symbol) {
            Some(index) if order > 0 => {
                self.term(draft.derivatives.get(&mut self.sheet.pool.borrow_mut(), index, &name, order))
            }
            _ => {
                let remedy = "only inputs have derivatives, of an order from 1; use the state's own equation instead";
                self.refuse(format!("`{name}` is not an input with a derivative of order {order}"), remedy);
                self.term(self.sheet.expr(0.into()))
            }
        }
    }

    /// The components of the unit vector along a vector, set-valued in the unit ball where that vanishes: coupled dry
    /// friction.
    pub fn unit<'b, const N: usize>(&'b self, vector: [Term<'b>; N]) -> [Term<'b>; N] {
        if let [only] = vector[..] {
            return vector.map(|_| only.sign());
        }
        let squares: Vec<Expr> = vector.iter().map(|v| v.pow(2).expr).collect();
        let square = self.sheet.pool.borrow_mut().sum(squares);
        vector.map(|v| v / self.term(square).sqrt())
    }

    /// π.
    pub fn pi(&self) -> Term<'_> {
        let pi = self.sheet.pool.borrow_mut().pi();
        self.term(pi)
    }

    /// An expression in the syntax of model files, over the names that are declared.
    pub fn formula(&self, text: &str) -> Term<'_> {
        let draft = &mut *self.draft.borrow_mut();
        let pool = &mut *self.sheet.pool.borrow_mut();
        let inputs: Vec<String> = draft.system.inputs.iter().map(|&u| pool.name(u).to_owned()).collect();
        let Draft { names, derivatives, met, .. } = draft;
        let mut scope = Scope { plain: names, inputs: &inputs, derivatives, met };
        let read = pool.parse_with(text, &mut scope).unwrap_or_else(|e| {
            self.refuse(format!("`{text}`: {}", e.message), e.remedy);
            pool.int(0)
        });
        self.term(read)
    }

    /// Gives an expression a name, which formulas may use.
    pub fn define<'b>(&'b self, name: &str, value: impl Into<Operand<'b>>) -> Term<'b> {
        let expr = self.sheet.expr(value.into());
        let draft = &mut *self.draft.borrow_mut();
        self.check(draft.declared.add(name, "definition"));
        draft.names.insert(name.to_owned(), expr);
        draft.system.definitions.push((name.to_owned(), expr));
        self.term(expr)
    }

    /// The equation of a state: its time derivative.
    pub fn dynamics<'b>(&'b self, state: Term<'b>, rate: impl Into<Operand<'b>>) {
        let (symbol, rate) = (self.symbol(state), self.sheet.expr(rate.into()));
        let draft = &mut *self.draft.borrow_mut();
        match symbol.filter(|s| draft.system.states.contains(s)) {
            None => self.refuse(format!("surplus equation: `{state}` is not a state"), "declare it as a state"),
            Some(symbol) => {
                if draft.rates.insert(symbol, rate).is_some() {
                    self.refuse(format!("surplus equation: `{state}` has one already"), "remove one of them");
                }
            }
        }
    }

    /// What is measured.
    pub fn output<'b>(&'b self, name: &str, value: impl Into<Operand<'b>>) {
        let expr = self.sheet.expr(value.into());
        let outputs = &mut self.draft.borrow_mut().system.outputs;
        if outputs.iter().any(|o| o.0 == name) {
            self.refuse(format!("there is an output `{name}` already"), "rename one of them");
        }
        outputs.push((name.to_owned(), expr));
    }

    /// The value of a state or input at the point where local statements are made; those that get none are 0.
    pub fn point<'b>(&'b self, of: Term<'b>, value: impl Into<Operand<'b>>) {
        let (symbol, value) = (self.symbol(of), self.sheet.expr(value.into()));
        if !self.sheet.pool.borrow().symbols_of(&[value]).is_empty() {
            self.refuse(format!("the value of `{of}` at the point is not constant"), "give a number");
        }
        let draft = &mut *self.draft.borrow_mut();
        match symbol.filter(|s| draft.system.states.contains(s) || draft.system.inputs.contains(s)) {
            Some(symbol) => draft.point.push((symbol, value)),
            None => self
                .refuse(format!("`{of}` is neither a state nor an input"), "a point gives values to states and inputs"),
        }
    }

    /// How far the argument of a sign, or those of a unit vector, may go before what sticks breaks loose: static over
    /// sliding level, at least 1.
    pub fn static_level<'b, const N: usize>(&'b self, of: [Term<'b>; N], ratio: impl Into<Operand<'b>>) {
        let components = of.iter().map(|&t| self.sheet.expr(t.into())).collect();
        let ratio = self.sheet.expr(ratio.into());
        self.draft.borrow_mut().static_levels.push(StaticLevel { components, ratio });
    }

    fn refuse(&self, message: impl Into<String>, remedy: impl Into<String>) {
        self.sheet.refuse(ModelError::new(message, remedy));
    }

    /// The system.
    ///
    /// # Errors
    /// [`ModelError`] for the first thing that is wrong: a name that is reserved or stands for two things, an unknown
    /// name in a formula, a surplus or missing equation, a range without values, a delay or static level that is none.
    pub fn build(self) -> Result<System, ModelError> {
        let Builder { sheet, draft } = self;
        let Draft { mut system, rates, point, static_levels, derivatives, met, .. } = draft.into_inner();
        if let Some(error) = sheet.error.into_inner() {
            return Err(error);
        }
        system.pool = sheet.pool.into_inner();
        if system.states.is_empty() {
            return Err(ModelError::new("the model has no states", "declare some with `states`"));
        }
        for s in &system.states {
            let Some(&rate) = rates.get(s) else {
                let name = system.pool.name(*s);
                let message = format!("missing equation: state `{name}` has no time derivative");
                return Err(ModelError::new(message, "give it with `dynamics`"));
            };
            system.dynamics.push(rate);
        }
        system.input_derivatives = derivatives.list();
        system.find_canceled([], &met);
        if !point.is_empty() {
            let zero = system.pool.int(0);
            // What is said last holds.
            let values = |symbols: &[Symbol]| -> Vec<Expr> {
                let last = |s: &Symbol| point.iter().rfind(|p| p.0 == *s);
                symbols.iter().map(|s| last(s).map_or(zero, |p| p.1)).collect()
            };
            system.point = Some(Point { states: values(&system.states), inputs: values(&system.inputs) });
        }
        for delay in &system.input_delays {
            system.check_delay(system.pool.name(delay.input), delay.delay)?;
        }
        system.mark_dry_friction();
        for level in static_levels {
            let form = system.set_valued_form();
            let names: Vec<String> = level.components.iter().map(|&c| system.pool.text(c)).collect();
            system.check_switch(&names.join(", "), &form, &level)?;
            system.check_ratio(&names.join(", "), &level)?;
            system.static_levels.push(level);
        }
        Ok(system)
    }
}
