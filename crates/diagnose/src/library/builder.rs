//! Putting effects together: names, texts, typical sizes, and what the model has already.

use bracketry_numerics::statistics::rms;
use bracketry_symbolic::{Expr, Notation, Pool, Symbol};
use bracketry_system::System;
use rustc_hash::FxHashSet;

use super::names::{ModelNames, symbols};
use super::probe::Probe;
use super::stretch::stretched;
use super::structure::{Structure, pairs};
use crate::effect::{Cause, Change, Coefficient, Effect, Path, Role};
use crate::error::DiagnoseError;
use crate::formula::Formula;
use crate::record::Record;
use crate::settings::LibrarySettings;

/// Collects the effects for one model.
pub(crate) struct Builder {
    /// A working copy of the model.
    pub(crate) system: System,
    pub(crate) structure: Structure,
    /// Points along the trajectory of the data.
    pub(crate) data: Probe,
    /// Points in general position.
    fixed: Probe,
    taken: FxHashSet<String>,
    pub(crate) effects: Vec<Effect>,
    /// Of each effect with one amplitude: its column at the points in general position.
    known: Vec<(Cause, Vec<Vec<f64>>)>,
    pub(crate) settings: LibrarySettings,
}

/// A parameter without a typical size yet: an amplitude that vanishes at 0.
pub(crate) fn amplitude(name: String, unit: impl Into<String>, about: impl Into<String>) -> Coefficient {
    Coefficient {
        name,
        role: Role::Amplitude,
        nominal: 0.0,
        scale: 1.0,
        min: f64::NEG_INFINITY,
        max: f64::INFINITY,
        trials: Vec::new(),
        physical_sign: 0,
        sign_flipped: None,
        period_of: None,
        unit: unit.into(),
        about: about.into(),
    }
}

/// An amplitude that physics wants to be positive.
pub(crate) fn dissipation(name: String, unit: impl Into<String>, about: impl Into<String>) -> Coefficient {
    Coefficient { physical_sign: 1, ..amplitude(name, unit, about) }
}

/// A positive shape, tried at several values.
pub(crate) fn shape(name: String, trials: Vec<f64>, unit: impl Into<String>, about: impl Into<String>) -> Coefficient {
    let nominal = trials.get(trials.len() / 2).copied().unwrap_or(1.0);
    let smallest = trials.iter().copied().fold(nominal, f64::min);
    Coefficient {
        role: Role::Shape,
        nominal,
        scale: nominal.abs(),
        min: 0.1 * smallest,
        trials,
        ..amplitude(name, unit, about)
    }
}

/// `count` values from `from` to `to` in equal ratios.
pub(crate) fn log_grid(from: f64, to: f64, count: usize) -> Vec<f64> {
    let steps = (count.max(2) - 1) as f64;
    (0..count).map(|i| from * (to / from).powf(i as f64 / steps)).collect()
}

impl Builder {
    /// Finds the structure of a model; records give the points along the trajectory of the data.
    pub(crate) fn new(system: &System, records: &[Record], settings: &LibrarySettings) -> Self {
        let mut system = system.clone();
        let pairs = pairs(&mut system);
        let data = Probe::of_records(&system, records, &pairs, settings);
        let structure = Structure::of(&mut system, &pairs);
        let symbols = symbols(&system).map(|s| system.symbol_name(s).to_owned());
        let taken = symbols.chain(system.definitions.iter().map(|d| d.0.clone())).collect();
        let fixed = Probe::fixed(&system);
        let settings = settings.clone();
        Builder { system, structure, data, fixed, taken, effects: Vec::new(), known: Vec::new(), settings }
    }

    /// Name of a state.
    pub(crate) fn state(&self, index: usize) -> String {
        self.system.symbol_name(self.system.states[index]).to_owned()
    }

    /// Text of an expression.
    pub(crate) fn text(&self, e: Expr) -> String {
        self.system.pool.text(e)
    }

    /// A name that nothing has: `base` for what it acts on.
    pub(crate) fn name(&mut self, base: &str, on: &str) -> String {
        let wanted = if on.is_empty() { base.to_owned() } else { format!("{base}_{on}") };
        let mut name = wanted.clone();
        let mut number = 2;
        while !self.taken.insert(name.clone()) {
            name = format!("{wanted}_{number}");
            number += 1;
        }
        name
    }

    /// Adds an effect whose law acts along a direction: `law` times an entry in each row.
    pub(crate) fn along(
        &mut self,
        cause: Cause,
        equation: usize,
        direction: &[(usize, Expr)],
        law: &str,
        coefficients: Vec<Coefficient>,
    ) -> Result<(), DiagnoseError> {
        let own = direction.iter().find(|d| d.0 == equation).or(direction.first());
        let Some(&(_, entry)) = own else {
            return self.described(cause, equation, "".into(), direction, law, coefficients);
        };
        let mut names = ModelNames::new(&mut self.system).with_coefficients(&mut self.system.pool, &coefficients);
        let read = names.read(&mut self.system.pool, law)?;
        let whole = self.system.pool.mul(read, entry);
        let notation = names.notation(&self.system.pool, whole);
        let term = Formula::new(product(law, &self.text(entry)), notation);
        self.described(cause, equation, term, direction, law, coefficients)
    }

    /// As [`Builder::along`], with another formula for the reader.
    pub(crate) fn described(
        &mut self,
        cause: Cause,
        equation: usize,
        term: Formula,
        direction: &[(usize, Expr)],
        law: &str,
        coefficients: Vec<Coefficient>,
    ) -> Result<(), DiagnoseError> {
        // As the law writes them: the text of the product would have roots where the law means the direction of friction.
        let terms =
            direction.iter().map(|&(row, entry)| (row, format!("({})*({})", bare(law), self.text(entry)))).collect();
        self.terms(cause, equation, term, terms, coefficients)
    }

    /// Adds an effect of one term per row; `term` is for the reader.
    pub(crate) fn terms(
        &mut self,
        cause: Cause,
        equation: usize,
        term: Formula,
        terms: Vec<(usize, String)>,
        coefficients: Vec<Coefficient>,
    ) -> Result<(), DiagnoseError> {
        let terms = terms.into_iter().map(|(row, text)| (self.state(row), text)).collect();
        let equation_name = self.state(equation);
        self.finish(
            Effect { cause, equation: equation_name, term, coefficients, change: Change::Terms(terms) },
            equation,
        )
    }

    /// Adds an effect that replaces expressions; `term` is for the reader.
    pub(crate) fn substitution(
        &mut self,
        cause: Cause,
        equation: usize,
        on: String,
        pairs: Vec<(String, String)>,
        coefficients: Vec<Coefficient>,
    ) -> Result<(), DiagnoseError> {
        let mut names = ModelNames::new(&mut self.system).with_coefficients(&mut self.system.pool, &coefficients);
        let mut term = Formula::from("");
        if let Some((a, b)) = pairs.first() {
            let pool = &mut self.system.pool;
            let (old, new) = (names.read(pool, a)?, names.read(pool, b)?);
            term = replacement(&names, pool, [old, new], [a, bare(b)]);
        }
        let change = Change::Substitution { states: Vec::new(), pairs };
        self.finish(Effect { cause, equation: on, term, coefficients, change }, equation)
    }

    /// Adds an effect on the limit surface of a contact whose friction has components over the root of `square`: rates, by index, are as
    /// many times as long as `lengths` say; see [`Change::Stretch`].
    pub(crate) fn stretch(
        &mut self,
        cause: Cause,
        equation: usize,
        square: Expr,
        lengths: &[(usize, String)],
        coefficients: Vec<Coefficient>,
    ) -> Result<(), DiagnoseError> {
        let slips: Vec<usize> =
            self.structure.translations().filter(|c| c.friction.is_some()).map(|c| c.rate).collect();
        let slips: Vec<String> = slips.into_iter().map(|rate| self.state(rate)).collect();
        let lengths: Vec<(String, String)> =
            lengths.iter().map(|(rate, length)| (self.state(*rate), length.clone())).collect();
        let (on, square) = (self.state(equation), self.text(square));
        let mut names = ModelNames::new(&mut self.system).with_coefficients(&mut self.system.pool, &coefficients);
        let pool = &mut self.system.pool;
        let component = names.read(pool, &format!("{on}/sqrt({square})"))?;
        let pairs = stretched(pool, &mut names, &square, &slips, &lengths, &[])?;
        let term = pairs.iter().find(|pair| pair.0 == component).map_or_else(
            || Formula::from(""),
            |&(old, new)| {
                let texts = [old, new].map(|e| pool.text(e));
                replacement(&names, pool, [old, new], texts.each_ref().map(String::as_str))
            },
        );
        let change = Change::Stretch { square, slips, lengths, spins: Vec::new() };
        self.finish(Effect { cause, equation: on, term, coefficients, change }, equation)
    }

    /// Adds an effect in signal paths.
    pub(crate) fn path(&mut self, cause: Cause, path: Path, signals: Vec<String>, term: Formula, c: Coefficient) {
        let equation = signals.join(", ");
        self.effects.push(Effect {
            cause,
            equation,
            term,
            coefficients: vec![c],
            change: Change::Path { path, signals },
        });
    }

    /// Sets typical sizes and keeps the effect unless the model has it already.
    fn finish(&mut self, mut effect: Effect, row: usize) -> Result<(), DiagnoseError> {
        let mut extended = self.system.clone();
        effect.apply(&mut extended)?;
        let columns = columns(&mut extended, &effect);
        if let [column] = &columns.iter().flatten().collect::<Vec<_>>()[..] {
            let values = self.fixed.values(&mut extended, column);
            // What has trials need not have a slope where it vanishes.
            let nothing = values.iter().flatten().all(|v| v.abs() < 1e-12)
                && effect.coefficients.iter().all(|c| c.role == Role::Shape || c.trials.is_empty());
            if nothing || self.is_parameter(&mut extended, &values) || self.is_known(effect.cause, &values) {
                return Ok(());
            }
            if effect.coefficients.len() == 1 {
                self.known.push((effect.cause, values));
            }
        }
        self.scale(&mut effect, row, &mut extended, columns);
        self.effects.push(effect);
        Ok(())
    }

    /// An effect that no model has already, with typical sizes.
    pub(crate) fn scaled(&mut self, mut effect: Effect, row: usize) -> Result<Effect, DiagnoseError> {
        let mut extended = self.system.clone();
        effect.apply(&mut extended)?;
        let columns = columns(&mut extended, &effect);
        self.scale(&mut effect, row, &mut extended, columns);
        Ok(effect)
    }

    /// Sets the typical sizes of amplitudes by their columns in the equations of the extended model.
    fn scale(&mut self, effect: &mut Effect, row: usize, extended: &mut System, columns: Vec<Option<Vec<Expr>>>) {
        let own = self.system.dynamics[row];
        let typical = self.data.rms(&mut self.system, &[own])[0];
        for (c, column) in effect.coefficients.iter_mut().zip(columns) {
            let Some(column) = column else { continue };
            let sizes = self.data.rms(extended, &column);
            let own = if sizes[row] > 0.0 { sizes[row] } else { sizes.iter().copied().fold(0.0, f64::max) };
            let size = self.settings.typical_share * typical / own;
            let room = (c.max - c.nominal).max(c.nominal - c.min);
            let tried = c.trials.get(c.trials.len() / 2).map_or(1.0, |trial| (trial - c.nominal).abs());
            c.scale = if size.is_finite() && size > 0.0 { size.min(room) } else { room.min(tried) };
        }
    }

    /// Whether a column is that of a parameter that is not zero, up to a constant factor: to refit the parameter is the
    /// same.
    fn is_parameter(&self, extended: &mut System, column: &[Vec<f64>]) -> bool {
        let parameters: Vec<Symbol> = self
            .system
            .parameters
            .iter()
            .filter(|p| Some(p.symbol) != self.structure.gravity && p.value.to_f64().value() != 0.0)
            .map(|p| p.symbol)
            .collect();
        parameters.into_iter().any(|p| {
            let rows = extended.dynamics.clone();
            let by: Vec<Expr> = rows.into_iter().map(|f| extended.pool.diff(f, p)).collect();
            parallel(column, &self.fixed.values(extended, &by))
        })
    }

    /// Whether an effect of the same cause has this column; for inertial couplings, an effect of any cause.
    fn is_known(&self, cause: Cause, column: &[Vec<f64>]) -> bool {
        let rival = |other: Cause| other == cause || cause == Cause::InertialCoupling;
        self.known.iter().any(|(other, values)| rival(*other) && parallel(column, values))
    }
}

/// The product of a law and an entry, for the reader: the law as it was written first.
fn product(law: &str, entry: &str) -> String {
    let depths = |text: &str| {
        let mut depth = 0;
        text.char_indices().skip(1).any(|(_, c)| {
            depth += i32::from(c == '(') - i32::from(c == ')');
            depth == 0 && (c == '+' || c == '-')
        })
    };
    match entry {
        "1" => bare(law).to_owned(),
        "-1" => format!("-({})", bare(law)),
        _ => match entry.strip_prefix("1/") {
            Some(below) => format!("{law}/{below}"),
            None if depths(entry) => format!("{law}*({entry})"),
            None => format!("{law}*{entry}"),
        },
    }
}

/// That one expression is replaced by another, for the reader.
fn replacement(names: &ModelNames, pool: &Pool, pair: [Expr; 2], texts: [&str; 2]) -> Formula {
    let [old, new] = pair.map(|e| names.notation(pool, e));
    Formula::new(texts.join(" -> "), Notation::Row(vec![old, Notation::Sign('→'), new]))
}

/// A text without the parentheses around all of it.
fn bare(text: &str) -> &str {
    let Some(inner) = text.strip_prefix('(').and_then(|t| t.strip_suffix(')')) else { return text };
    let mut depth = 0;
    for c in inner.chars() {
        depth += i32::from(c == '(') - i32::from(c == ')');
        if depth < 0 {
            return text;
        }
    }
    inner
}

/// The derivatives of the equations by each amplitude, where the amplitudes vanish; none for shapes.
fn columns(extended: &mut System, effect: &Effect) -> Vec<Option<Vec<Expr>>> {
    let by = |c: &Coefficient, extended: &mut System| {
        let symbol = extended.pool.symbol(&c.name);
        let rows = extended.dynamics.clone();
        rows.into_iter().map(|f| extended.pool.diff(f, symbol)).collect()
    };
    effect.coefficients.iter().map(|c| (c.role == Role::Amplitude).then(|| by(c, extended))).collect()
}

/// Whether two families of vectors agree up to one factor.
fn parallel(a: &[Vec<f64>], b: &[Vec<f64>]) -> bool {
    let pairs: Vec<(f64, f64)> = a
        .iter()
        .flatten()
        .zip(b.iter().flatten())
        .map(|(x, y)| (*x, *y))
        .filter(|(x, y)| x.is_finite() && y.is_finite())
        .collect();
    let (size_a, size_b) = (rms(pairs.iter().map(|p| p.0)), rms(pairs.iter().map(|p| p.1)));
    if size_a == 0.0 || size_b == 0.0 {
        return false;
    }
    let cosine = pairs.iter().map(|(x, y)| x * y).sum::<f64>() / (pairs.len() as f64 * size_a * size_b);
    1.0 - cosine.abs() < 1e-9
}
