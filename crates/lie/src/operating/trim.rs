//! Equilibria and operating points.

use bracketry_symbolic::{Expr, Function, Pool, Rational, SplitMix64, Symbol, Tape};
use bracketry_system::{Point, System};
use nalgebra::DVector;
use serde::Serialize;

use crate::operating::confirm::confirmed;
use crate::operating::equations::Equations;
use crate::operating::solver::{Found, judged, nearest, neighbors, solve};

/// What is asked of an operating point.
#[derive(Clone, Debug, Default)]
pub struct TrimOptions {
    /// States and inputs with given values: constants, in the pool of the system.
    pub fixed: Vec<(String, Expr)>,
    /// Inputs that are searched; all others stay at the value of the model's point.
    pub free: Vec<String>,
    /// States whose derivative need not vanish, such as the position of a vehicle at constant speed.
    pub moving: Vec<String>,
    /// Number of random starts in addition to the model's point.
    pub starts: usize,
    /// Of the random starts.
    pub seed: u64,
}

/// How a search for an operating point ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum TrimStatus {
    /// The equations hold.
    Found,
    /// The equations hold at the point given, which lies outside the range of an input; none was found inside.
    OutOfRange,
    /// No start led to a solution; the point given is the best one seen.
    NotFound,
}

/// What a variable of an operating point is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum TrimRole {
    /// It was searched.
    Free,
    /// Its value was asked for.
    Fixed,
    /// It stayed at the value of the model's point.
    Held,
}

/// A state or input of an operating point.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TrimValue {
    /// Its name.
    pub name: String,
    /// What it is.
    pub role: TrimRole,
    /// Its value.
    pub value: f64,
    /// The exact value, where the point is confirmed exactly.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exact: Option<Function>,
}

/// What is to be said of an operating point.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum TrimNote {
    /// The equations leave so many variables open; of all solutions the one next to the model's point is given.
    Underdetermined {
        /// Dimension of the set of solutions.
        dimensions: usize,
    },
    /// The Jacobian has not full rank at the solution, in floating point: a multiple root, or coefficients of very different size.
    Degenerate {
        /// How far a coordinate may be from the solution, relative to the size of the point; rounding where the signs of the equations, or of
        /// their derivatives, enclose it.
        accuracy: f64,
    },
    /// The equations vanish to rounding at a point that is not taken for a solution: none of them changes its sign there, and no exact values
    /// confirm it. It may be a multiple solution, or one of equations that only come near zero.
    NotConfirmed,
    /// The model's point differs from this solution by rounding only, and is taken for it.
    WithinRounding {
        /// Largest difference of a coordinate.
        distance: f64,
    },
    /// An input is outside its range.
    OutOfRange {
        /// The input.
        input: String,
        /// Its value.
        value: f64,
    },
    /// A switching function vanishes: where it is dry friction, forces around this point are balanced too; sign(0) is 0 here.
    Switching {
        /// The switching function.
        name: String,
    },
    /// The search ended at its time or memory limit.
    Limit {
        /// Starts that were tried.
        tried: usize,
        /// Starts that were to be tried.
        starts: usize,
    },
    /// The equations use the derivative of an input, which is 0 here.
    Derivative {
        /// The input.
        input: String,
    },
}

/// An operating point, or the best point on the way to one.
#[derive(Clone, Debug, PartialEq)]
pub struct Trim {
    /// How the search ended.
    pub status: TrimStatus,
    /// The states, in the order of the model.
    pub states: Vec<TrimValue>,
    /// The inputs.
    pub inputs: Vec<TrimValue>,
    /// The derivative of each state at the point.
    pub derivatives: Vec<(String, f64)>,
    /// The largest absolute derivative of those that shall vanish.
    pub residual: f64,
    /// Whether the equations hold exactly at the exact values, parameters at theirs.
    pub exact: bool,
    /// What is to be said.
    pub notes: Vec<TrimNote>,
    /// Other solutions that the starts led to, states and inputs in order; there may be more.
    pub others: Vec<Vec<f64>>,
}

impl Trim {
    /// The point for a model: exact values where they are known, else the numbers.
    pub fn point(&self, system: &mut System) -> Point {
        let mut expressions = |list: &[TrimValue]| {
            let constant = |v: &TrimValue| {
                if let Some(exact) = &v.exact {
                    return exact.copied_into(&mut system.pool);
                }
                let number = Rational::try_from(v.value).unwrap_or(Rational::ZERO);
                system.pool.rational(number)
            };
            list.iter().map(constant).collect::<Vec<_>>()
        };
        Point { states: expressions(&self.states), inputs: expressions(&self.inputs) }
    }
}

/// Why no search was made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TrimError {
    /// A name that is neither a state nor an input, or not of the kind that the option needs.
    #[error("the model has no {expected} `{name}`: it has {known}")]
    UnknownName {
        /// The name.
        name: String,
        /// What it should be.
        expected: &'static str,
        /// Names that would do.
        known: String,
    },
    /// A variable is asked for twice.
    #[error("`{name}` is fixed and free: remove one")]
    FixedAndFree {
        /// The name.
        name: String,
    },
    /// An equation has no value.
    #[error("the equations of `{model}` cannot be evaluated: {reason}")]
    NotCompiled {
        /// The model.
        model: String,
        /// Why.
        reason: bracketry_symbolic::CompileError,
    },
}

/// A point nearer to a solution than this, relative to its size, differs from it by rounding.
pub(super) const ROUNDING: f64 = 1e-6;

/// Solutions nearer to each other than this are one.
const SAME: f64 = 1e-5;

/// Most further solutions that are listed.
const MAX_OTHERS: usize = 8;

/// Searches an operating point: values of the free states and inputs at which the derivatives of all states (but those that
/// may move) vanish, by Levenberg–Marquardt iterations from the model's point and from random ones, up to the
/// [limits](Pool::reached_limit) of the system's pool.
///
/// # Errors
/// [`TrimError`] for names that the model does not have.
pub fn trim(system: &System, options: &TrimOptions) -> Result<Trim, TrimError> {
    let mut search = Search::new(system, options)?;
    let starts = search.starts(options);
    let mut found: Vec<Found> = Vec::new();
    let limits = search.equations.limits.clone();
    let free_of_limits = vec![[f64::NEG_INFINITY, f64::INFINITY]; limits.len()];
    let mut best: Option<Found> = None;
    let mut limit = None;
    for inside in [true, false] {
        search.equations.limits = if inside { limits.clone() } else { free_of_limits.clone() };
        if !inside && limits == free_of_limits {
            break;
        }
        for (tried, start) in starts.iter().enumerate() {
            if tried > 0 && system.pool.reached_limit().is_some() {
                limit = Some(TrimNote::Limit { tried, starts: starts.len() });
                break;
            }
            let end = solve(&mut search.equations, start);
            if end.solved && search.is_solution(&end) {
                if found.iter().all(|f| (&f.z - &end.z).amax() > SAME * (1.0 + end.z.amax())) {
                    found.push(end);
                }
            } else if best.as_ref().is_none_or(|b| end.residual < b.residual) {
                best = Some(end);
            }
            // One solution does where there is a whole set of them.
            if found.first().is_some_and(|f| f.rank < f.z.len()) || found.len() > MAX_OTHERS {
                break;
            }
        }
        if !found.is_empty() {
            let status = if inside { TrimStatus::Found } else { TrimStatus::OutOfRange };
            return Ok(search.finished(status, found, limit));
        }
        if limit.is_some() {
            break;
        }
    }
    let best = best.unwrap_or_else(|| solve(&mut search.equations, &starts[0]));
    let is_unconfirmed = best.solved;
    let mut found = search.finished(TrimStatus::NotFound, vec![best], limit);
    if is_unconfirmed {
        found.notes.push(TrimNote::NotConfirmed);
    }
    Ok(found)
}

pub(super) struct Search<'a> {
    system: &'a System,
    pub(super) equations: Equations,
    /// The equations as expressions of the free variables, parameters at their values.
    pub(super) exact: (Pool, Vec<Expr>),
    pub(super) free: Vec<Symbol>,
    roles: Vec<TrimRole>,
    /// States, then inputs, where the search starts.
    start: Vec<f64>,
    /// The same as constants, of the pool in `exact`.
    constants: Vec<Expr>,
    all: Vec<Symbol>,
}

impl<'a> Search<'a> {
    fn new(system: &'a System, options: &TrimOptions) -> Result<Self, TrimError> {
        let mut s = system.clone();
        let all: Vec<Symbol> = s.states.iter().chain(&s.inputs).copied().collect();
        let n = s.states.len();
        let place = |name: &str, expected: &'static str, of: std::ops::Range<usize>| {
            let names: Vec<&str> = all[of.clone()].iter().map(|&v| system.symbol_name(v)).collect();
            names.iter().position(|&other| other == name).map(|k| k + of.start).ok_or_else(|| TrimError::UnknownName {
                name: name.to_owned(),
                expected,
                known: names.join(", "),
            })
        };
        let zero = s.pool.int(0);
        let mut constants = vec![zero; all.len()];
        if let Some(point) = &s.point {
            for (c, &v) in constants.iter_mut().zip(point.states.iter().chain(&point.inputs)) {
                *c = v;
            }
        }
        let mut roles: Vec<TrimRole> =
            (0..all.len()).map(|k| if k < n { TrimRole::Free } else { TrimRole::Held }).collect();
        for name in &options.free {
            roles[place(name, "state or input", 0..all.len())?] = TrimRole::Free;
        }
        for (name, value) in &options.fixed {
            let k = place(name, "state or input", 0..all.len())?;
            if options.free.contains(name) {
                return Err(TrimError::FixedAndFree { name: name.clone() });
            }
            (roles[k], constants[k]) = (TrimRole::Fixed, *value);
        }
        let moving = options.moving.iter().map(|name| place(name, "state", 0..n)).collect::<Result<Vec<_>, _>>()?;
        let mut known = rustc_hash::FxHashMap::default();
        for (k, role) in roles.iter().enumerate() {
            if *role != TrimRole::Free {
                known.insert(s.pool.sym(all[k]), constants[k]);
            }
        }
        for d in &s.input_derivatives {
            known.insert(s.pool.sym(d.symbol), zero);
        }
        let resting: Vec<Expr> = (0..n).filter(|k| !moving.contains(k)).map(|k| s.dynamics[k]).collect();
        let resting = s.pool.substitute_all(&resting, &known);
        let exact = s.with_values(&resting);
        let free: Vec<Symbol> = (0..all.len()).filter(|&k| roles[k] == TrimRole::Free).map(|k| all[k]).collect();
        let limits = free.iter().map(|u| limits(&s, *u)).collect();
        let failed = |reason| TrimError::NotCompiled { model: system.name.clone(), reason };
        let canceled = s.pool.substitute_all(&s.canceled, &known);
        let equations = Equations::new(&s, &resting, &canceled, &free, limits).map_err(failed)?;
        let start = constants.iter().map(|&c| s.value(c).unwrap_or(0.0)).collect();
        Ok(Search { system, equations, exact: (s.pool, exact), free, roles, start, constants, all })
    }

    fn values_of_free(&self, all: &[f64]) -> DVector<f64> {
        DVector::from_iterator(
            self.free.len(),
            all.iter().zip(&self.roles).filter(|(_, r)| **r == TrimRole::Free).map(|(v, _)| *v),
        )
    }

    /// The model's point, the origin, and random points around both, nearer ones first.
    fn starts(&self, options: &TrimOptions) -> Vec<DVector<f64>> {
        let first = self.values_of_free(&self.start);
        let mut starts = vec![first.clone(), DVector::zeros(first.len())];
        let mut random = SplitMix64::new(options.seed);
        for k in 0..options.starts {
            let reach = [0.3, 1.0, 3.0, 10.0][k % 4];
            starts.push(first.map(|v| v + reach * (1.0 + v.abs()) * random.symmetric()));
        }
        starts
    }

    fn finished(mut self, status: TrimStatus, mut found: Vec<Found>, limit: Option<TrimNote>) -> Trim {
        let first = self.values_of_free(&self.start);
        let mut notes: Vec<TrimNote> = limit.into_iter().collect();
        let mut chosen = found.swap_remove(0);
        let open = self.free.len() - chosen.rank;
        let solved = status != TrimStatus::NotFound;
        let beside = if solved && open > 0 { neighbors(&mut self.equations, &chosen) } else { Vec::new() };
        let one_of_many = beside.iter().any(|other| self.is_solution(other));
        if one_of_many {
            // The nearest solutions may tend to a point where there is none.
            let near = nearest(&mut self.equations, chosen.clone(), &first);
            if self.is_solution(&near) {
                chosen = near;
            }
            notes.push(TrimNote::Underdetermined { dimensions: open });
        } else if solved && open > 0 {
            let (z, accuracy) = self.located(&chosen);
            chosen = judged(&mut self.equations, z);
            notes.push(TrimNote::Degenerate { accuracy });
        }
        let slack = if solved && open > 0 && !one_of_many { 1e-3 } else { 0.0 };
        let exact = if solved { self.confirmed(&chosen, slack) } else { None };
        let distance = (&chosen.z - &first).amax();
        let given = solved && self.system.point.is_some();
        if given && distance > 0.0 && distance <= ROUNDING * (1.0 + first.amax()) {
            notes.push(TrimNote::WithinRounding { distance });
        }
        let others = found.iter().map(|f| self.whole(&f.z)).collect();
        let values = self.whole(&chosen.z);
        self.notes_on(&values, &mut notes);
        let derivatives = self.derivatives(&values);
        let is_exact = exact.is_some();
        let (states, inputs) = self.described(&values, exact.as_deref());
        Trim { status, states, inputs, derivatives, residual: chosen.residual, exact: is_exact, notes, others }
    }

    /// Exact values of all variables, in the pool of `exact`.
    pub(super) fn confirmed(&mut self, found: &Found, slack: f64) -> Option<Vec<Expr>> {
        let (pool, equations) = &mut self.exact;
        let free = confirmed(pool, equations, &self.free, found.z.as_slice(), slack)?;
        let mut free = free.into_iter();
        let mut all = Vec::new();
        for (k, role) in self.roles.iter().enumerate() {
            all.push(if *role == TrimRole::Free { free.next()? } else { self.constants[k] });
        }
        Some(all)
    }

    /// States, then inputs.
    fn whole(&self, z: &DVector<f64>) -> Vec<f64> {
        let mut free = z.iter().copied();
        self.roles
            .iter()
            .zip(&self.start)
            .map(|(role, &held)| if *role == TrimRole::Free { free.next().unwrap_or(held) } else { held })
            .collect()
    }

    fn described(&self, values: &[f64], exact: Option<&[Expr]>) -> (Vec<TrimValue>, Vec<TrimValue>) {
        let pool = &self.exact.0;
        let mut list: Vec<TrimValue> = Vec::new();
        for (k, &symbol) in self.all.iter().enumerate() {
            let exact = exact.map(|list| Function::new(pool, list[k]));
            let number = exact.as_ref().and_then(number_of);
            let value = number.unwrap_or(values[k]);
            let name = self.system.symbol_name(symbol).to_owned();
            list.push(TrimValue { name, role: self.roles[k], value, exact });
        }
        let inputs = list.split_off(self.system.states.len());
        (list, inputs)
    }

    fn derivatives(&self, values: &[f64]) -> Vec<(String, f64)> {
        let mut at = values.to_vec();
        at.extend(self.system.input_derivatives.iter().map(|_| 0.0));
        let mut out = vec![f64::NAN; self.system.states.len()];
        if let Ok(tape) = self.system.compile(&self.system.arguments(), &self.system.dynamics) {
            tape.eval(&at, &mut Vec::new(), &mut out);
        }
        self.system.state_names().into_iter().zip(out).collect()
    }

    fn notes_on(&self, values: &[f64], notes: &mut Vec<TrimNote>) {
        let n = self.system.states.len();
        for (k, &u) in self.system.inputs.iter().enumerate() {
            let ([low, high], value) = (limits(self.system, u), values[n + k]);
            let slack = 1e-9 * (1.0 + value.abs());
            if value < low - slack || value > high + slack {
                notes.push(TrimNote::OutOfRange { input: self.system.symbol_name(u).to_owned(), value });
            }
        }
        for d in self.system.input_derivatives.iter().filter(|d| d.order == 1) {
            let input = self.system.symbol_name(self.system.inputs[d.input]).to_owned();
            notes.push(TrimNote::Derivative { input });
        }
        let mut s = self.system.clone();
        for switch in s.switched_form().switches {
            let Ok(tape) = s.compile(&self.all, &[switch.surface]) else { continue };
            let mut out = [f64::NAN];
            tape.eval(values, &mut Vec::new(), &mut out);
            if out[0].abs() <= 1e-9 {
                notes.push(TrimNote::Switching { name: switch.name });
            }
        }
    }
}

/// The number that a constant is.
fn number_of(constant: &Function) -> Option<f64> {
    let tape = Tape::compile(constant.pool(), &[], &[constant.expr()]).ok()?;
    let mut out = [f64::NAN];
    tape.eval(&[], &mut Vec::new(), &mut out);
    out[0].is_finite().then_some(out[0])
}

/// Least and greatest value of a variable: the range of an input, all numbers for a state.
fn limits(system: &System, variable: Symbol) -> [f64; 2] {
    let range = system.input_ranges.iter().find(|r| r.input == variable);
    let end = |e: Option<&Rational>, free: f64| e.map_or(free, |e| e.to_f64().value());
    [end(range.and_then(|r| r.min.as_ref()), f64::NEG_INFINITY), end(range.and_then(|r| r.max.as_ref()), f64::INFINITY)]
}
