//! The one system of a design: copies of models under the same inputs, their sensitivities, and integrals of products of what is measured.

use crate::exact::Free;
use crate::options::ExperimentError;
use crate::setup::Setup;
use crate::smooth::Smooth;
use bracketry_mpc::{CostFunction, MpcError};
use bracketry_symbolic::{Expr, Rational, Symbol};
use bracketry_system::System;
use rustc_hash::FxHashMap;

/// Information that is known before, as one over the square of a relative standard deviation of ten: it keeps what the data do not tell from
/// being infinitely uncertain, and tells nothing beside data.
const PRIOR: (i64, i64) = (1, 100);

/// What is measured of a model in the plan, in units of the noise.
pub(crate) struct Shown {
    /// One expression per column.
    pub(crate) outputs: Vec<Expr>,
    /// Their derivatives by relative changes of the free parameters, one list per parameter.
    pub(crate) sensitivities: Vec<Vec<Expr>>,
}

/// The system of a design while it is put together.
pub(crate) struct Composed {
    pub(crate) system: System,
    pub(crate) x0: Vec<f64>,
    /// States with limits: place, and place in the limits of the setup.
    pub(crate) limited: Vec<(usize, usize)>,
}

impl Composed {
    /// The inputs. Where their rates are limited, these are what is chosen, and the inputs are states.
    pub(crate) fn new(setup: &Setup) -> Self {
        let mut system = System { name: "experiment".to_owned(), ..System::default() };
        let mut x0 = Vec::new();
        for input in &setup.inputs {
            let symbol = system.pool.symbol(&input.name);
            if setup.is_linear() {
                let rate = system.pool.symbol(&format!("{}#rate", input.name));
                system.inputs.push(rate);
                let rate = system.pool.sym(rate);
                system.states.push(symbol);
                system.dynamics.push(rate);
                x0.push(input.rest);
            } else {
                system.inputs.push(symbol);
            }
        }
        Self { system, x0, limited: Vec::new() }
    }

    fn add_state(&mut self, name: &str, rate: Expr, start: f64) -> Expr {
        let symbol = self.system.pool.symbol(name);
        self.system.states.push(symbol);
        self.system.dynamics.push(rate);
        self.x0.push(start);
        self.system.pool.sym(symbol)
    }

    /// Adds a model, with sensitivities of its free parameters and starts; parameters and starts have the values given, else their own.
    pub(crate) fn add(
        &mut self,
        model: &Smooth,
        tag: &str,
        setup: &Setup,
        values: &[(&Free, f64)],
        free: &[Free],
        noise: &[f64],
    ) -> Result<Shown, ExperimentError> {
        let mut own = model.system.clone();
        let outputs: Vec<Expr> = setup.columns.iter().map(|c| quantity(&mut own, c)).collect();
        let mut map: FxHashMap<Expr, Expr> = FxHashMap::default();
        let mut states = Vec::new();
        for name in own.state_names() {
            let (from, to) = (own.pool.var(&name), own.pool.var(&format!("{name}{tag}")));
            map.insert(from, to);
            states.push(format!("{name}{tag}"));
        }
        let mut held: FxHashMap<Expr, Expr> = FxHashMap::default();
        for p in own.parameters.clone() {
            let name = own.pool.name(p.symbol).to_owned();
            let (from, to) = (own.pool.sym(p.symbol), own.pool.var(&format!("{name}{tag}")));
            let given = values
                .iter()
                .find(|v| v.0.state.is_none() && v.0.name == name)
                .and_then(|v| Rational::try_from(v.1).ok());
            let value = own.pool.rational(given.unwrap_or(p.value));
            map.insert(from, to);
            held.insert(to, value);
        }
        let roots: Vec<Expr> = own.dynamics.iter().chain(&outputs).copied().collect();
        let mut roots = own.pool.substitute_all(&roots, &map);
        roots.extend(held.iter().flat_map(|(a, b)| [*a, *b]));
        // What a pool has exported, another one reads.
        let roots = self.system.pool.import(&own.pool.export(&roots)).unwrap_or_default();
        let (rows, pairs) = roots.split_at(states.len() + outputs.len());
        let held: FxHashMap<Expr, Expr> = pairs.chunks_exact(2).map(|p| (p[0], p[1])).collect();
        let (dynamics, outputs) = rows.split_at(states.len());
        let mut start = model.x0.clone();
        for (free, value) in values {
            free.state.into_iter().for_each(|k| start[k] = *value);
        }
        for ((name, own), (&rate, &x0)) in states.iter().zip(own.state_names()).zip(dynamics.iter().zip(&start)) {
            if let Some(k) = setup.states.iter().position(|l| l.name == own) {
                self.limited.push((self.system.states.len(), k));
            }
            self.add_state(name, rate, x0);
        }
        let symbols: Vec<Symbol> = states.iter().map(|n| self.system.pool.symbol(n)).collect();
        let mut sensitivities = Vec::new();
        for p in free {
            sensitivities.push(self.add_sensitivity(p, tag, &symbols, (dynamics, outputs)));
        }
        self.hold(&held);
        let pool = &mut self.system.pool;
        let mut in_units = |rows: &[Expr], factor: f64| -> Result<Vec<Expr>, ExperimentError> {
            let rows = pool.substitute_all(rows, &held);
            let scaled = rows.into_iter().zip(noise).map(|(e, std)| {
                let factor = number(factor / std)?;
                let factor = pool.rational(factor);
                Ok(pool.mul(factor, e))
            });
            scaled.collect()
        };
        Ok(Shown {
            outputs: in_units(outputs, 1.0)?,
            sensitivities: sensitivities
                .iter()
                .zip(free)
                .map(|(s, p)| in_units(s, p.scale))
                .collect::<Result<_, _>>()?,
        })
    }

    /// Adds S' = (∂f/∂x) S + ∂f/∂p, which starts at 0, or at 1 in the state whose start it belongs to; returns (∂h/∂x) S + ∂h/∂p.
    fn add_sensitivity(
        &mut self,
        p: &Free,
        tag: &str,
        states: &[Symbol],
        (dynamics, outputs): (&[Expr], &[Expr]),
    ) -> Vec<Expr> {
        let parameter = self.system.pool.symbol(&format!("{}{tag}", p.name));
        let names: Vec<String> = states.iter().map(|s| format!("d{}/d{}", self.system.pool.name(*s), p.name)).collect();
        let along: Vec<Expr> = names.iter().map(|n| self.system.pool.var(n)).collect();
        let pool = &mut self.system.pool;
        let mut rate = |e: Expr| {
            let through = pool.lie_derivative(e, states, &along);
            let direct = pool.diff(e, parameter);
            pool.add(through, direct)
        };
        let rates: Vec<Expr> = dynamics.iter().map(|e| rate(*e)).collect();
        let shown = outputs.iter().map(|e| rate(*e)).collect();
        for (k, (name, rate)) in names.iter().zip(rates).enumerate() {
            self.add_state(name, rate, if p.state == Some(k) { 1.0 } else { 0.0 });
        }
        shown
    }

    /// Puts the values of parameters into all equations.
    fn hold(&mut self, held: &FxHashMap<Expr, Expr>) {
        let dynamics = self.system.pool.substitute_all(&self.system.dynamics.clone(), held);
        self.system.dynamics = dynamics;
    }

    /// Adds the integrals of the products of lists of measured quantities over the sampling period: the matrix of sums over the samples.
    pub(crate) fn add_products(&mut self, lists: &[Vec<Expr>], sample: f64) -> Result<Vec<Vec<Expr>>, ExperimentError> {
        let per_sample = number(1.0 / sample)?;
        let mut matrix = vec![Vec::new(); lists.len()];
        for i in 0..lists.len() {
            for j in 0..=i {
                let pool = &mut self.system.pool;
                let products: Vec<Expr> = lists[i].iter().zip(&lists[j]).map(|(a, b)| pool.mul(*a, *b)).collect();
                let (sum, factor) = (pool.sum(products), pool.rational(per_sample.clone()));
                let rate = pool.mul(factor, sum);
                let integral = self.add_state(&format!("q#{i}#{j}"), rate, 0.0);
                matrix[i].push(integral);
                if i != j {
                    matrix[j].push(integral);
                }
            }
        }
        Ok(matrix)
    }

    /// −log det of the information matrix, prior included: the criterion D, to be minimized.
    pub(crate) fn determinant(&mut self, information: &[Vec<Expr>]) -> Expr {
        let pivots = self.pivots(information, information.len());
        let pool = &mut self.system.pool;
        let logarithms: Vec<Expr> = pivots.into_iter().map(|p| pool.call(bracketry_symbolic::Func::Log, p)).collect();
        let sum = pool.sum(logarithms);
        pool.neg(sum)
    }

    /// −log(1 + λ), where λ is the square of the last list of the products without what combinations of the others explain: what a
    /// refit leaves, to first order.
    pub(crate) fn remainder(&mut self, products: &[Vec<Expr>]) -> Expr {
        let pivots = self.pivots(products, products.len() - 1);
        let pool = &mut self.system.pool;
        let (one, left) = (pool.int(1), pivots[products.len() - 1]);
        let above = pool.add(one, left);
        let logarithm = pool.call(bracketry_symbolic::Func::Log, above);
        pool.neg(logarithm)
    }

    /// The pivots of Gaussian elimination of a symmetric matrix, the prior added to the first of its diagonal.
    fn pivots(&mut self, matrix: &[Vec<Expr>], with_prior: usize) -> Vec<Expr> {
        let pool = &mut self.system.pool;
        let prior = pool.ratio(PRIOR.0, PRIOR.1);
        let mut rows = matrix.to_vec();
        for i in 0..with_prior {
            rows[i][i] = pool.add(rows[i][i], prior);
        }
        for k in 0..rows.len() {
            for i in k + 1..rows.len() {
                let factor = pool.div(rows[i][k], rows[k][k]);
                for j in k + 1..rows.len() {
                    let taken = pool.mul(factor, rows[k][j]);
                    rows[i][j] = pool.sub(rows[i][j], taken);
                }
            }
        }
        (0..rows.len()).map(|k| rows[k][k]).collect()
    }

    /// The criterion as a cost of the end.
    pub(crate) fn cost(&mut self, criterion: Expr) -> Result<CostFunction, MpcError> {
        let (time, states) = (self.system.pool.symbol("t"), self.system.states.clone());
        CostFunction::compile(&mut self.system.pool, time, &states, &[], &[], criterion)
    }
}

/// An output or a state.
fn quantity(system: &mut System, name: &str) -> Expr {
    match system.outputs.iter().find(|o| o.0 == name) {
        Some(output) => output.1,
        None => system.pool.var(name),
    }
}

fn number(value: f64) -> Result<Rational, ExperimentError> {
    let wrong = || ExperimentError::Value {
        what: "a scale".to_owned(),
        value,
        remedy: "give finite numbers that are not zero",
    };
    Rational::try_from(value).map_err(|_| wrong())
}
