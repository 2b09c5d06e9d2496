//! A scenario tree: the model once per branch, in one system.
//!
//! With C combinations of uncertain parameters and a robust horizon of r intervals there are C^r branches. In the branch with the
//! digits c_0 … c_{r−1} to the base C, combination c_k holds over interval k, and c_{r−1} after the last of them. Branches with the
//! same c_0 … c_{k−1} have the same past at grid point k, and so the same input over interval k (Lucia, Finkler, and Engell 2013).

use crate::ocp::{Branching, Remembered};
use bracketry_symbolic::{Expr, Pool, Rational};
use bracketry_system::System;

/// Values of the uncertain parameters, and what they weigh.
#[derive(Clone, Debug)]
pub(super) struct Combination {
    pub(super) values: Vec<(String, Rational)>,
    pub(super) weight: f64,
}

/// The branches of a problem.
pub(super) struct Tree {
    pub(super) combinations: Vec<Combination>,
    /// The model with the values of every combination. Its pool has the names of the copies.
    pub(super) systems: Vec<System>,
    pub(super) robust_horizon: usize,
    /// The model once per branch: states and inputs of the first branch, then those of the second one. Where the robust horizon is
    /// longer than an interval, the uncertain parameters are live ones, [`Tree::live`].
    pub(super) product: System,
}

/// Name of the copy in branch s.
fn copy(name: &str, s: usize) -> String {
    format!("{name}@{}", s + 1)
}

/// Name of the value of an input over the interval before.
fn before(name: &str) -> String {
    format!("{name}#before")
}

impl Tree {
    pub(super) fn new(system: &System, combinations: Vec<Combination>, robust_horizon: usize) -> Self {
        let mut tree = Self { combinations, systems: Vec::new(), robust_horizon, product: System::default() };
        let mut product = system.clone();
        let names = |names: Vec<String>, s: usize| names.into_iter().map(move |n| copy(&n, s));
        let branches = tree.branches();
        product.states =
            (0..branches).flat_map(|s| names(system.state_names(), s)).map(|n| product.pool.symbol(&n)).collect();
        product.inputs =
            (0..branches).flat_map(|s| names(system.input_names(), s)).map(|n| product.pool.symbol(&n)).collect();
        product.dynamics = Vec::new();
        for s in 0..branches {
            let mut values = Vec::new();
            for (name, value) in &tree.combinations[tree.last(s)].values {
                let own = if robust_horizon == 1 {
                    product.pool.rational(value.clone())
                } else {
                    product.pool.var(&copy(name, s))
                };
                values.push((product.pool.var(name), own));
            }
            let dynamics = product.pool.substitute_all(&system.dynamics, &values.into_iter().collect());
            let renamed = renamed(system, s, &mut product.pool, &dynamics);
            product.dynamics.extend(renamed);
        }
        tree.replace_parameters(&mut product);
        product.definitions.clear();
        product.outputs.clear();
        product.input_ranges.clear();
        product.input_delays.clear();
        product.static_levels.clear();
        product.point = None;
        let with_values = |c: &Combination| {
            let mut own = System { pool: product.pool.clone(), ..system.clone() };
            for (name, value) in &c.values {
                own.set_parameter(name, value.clone());
            }
            own
        };
        tree.systems = tree.combinations.iter().map(with_values).collect();
        tree.product = product;
        tree
    }

    /// Puts the copies of the uncertain parameters, where there are any, in their place.
    fn replace_parameters(&self, product: &mut System) {
        let names: Vec<String> = self.names().map(str::to_owned).collect();
        let pool = &mut product.pool;
        let (uncertain, mut kept): (Vec<_>, Vec<_>) =
            product.parameters.drain(..).partition(|p| names.iter().any(|n| n == pool.name(p.symbol)));
        if self.robust_horizon > 1 {
            for s in 0..self.branches() {
                for (name, value) in &self.combinations[self.last(s)].values {
                    let Some(p) = uncertain.iter().find(|p| pool.name(p.symbol) == name) else { continue };
                    let (mut own, value) = (p.clone(), value.clone());
                    own.symbol = pool.symbol(&copy(name, s));
                    own.value = value;
                    kept.push(own);
                }
            }
        }
        product.parameters = kept;
    }

    /// Number of branches.
    pub(super) fn branches(&self) -> usize {
        self.combinations.len().pow(self.robust_horizon as u32)
    }

    /// The combination of branch s over interval k.
    fn combination(&self, s: usize, k: usize) -> usize {
        let later = self.robust_horizon.saturating_sub(k + 1) as u32;
        s / self.combinations.len().pow(later) % self.combinations.len()
    }

    /// The combination that holds in branch s in the end.
    pub(super) fn last(&self, s: usize) -> usize {
        s % self.combinations.len()
    }

    /// Weight of branch s: the product of those of its combinations.
    pub(super) fn weight(&self, s: usize) -> f64 {
        (0..self.robust_horizon).map(|k| self.combinations[self.combination(s, k)].weight).product()
    }

    /// Names of the uncertain parameters.
    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        self.combinations.first().into_iter().flat_map(|c| c.values.iter().map(|v| v.0.as_str()))
    }

    /// Names of the copies of the uncertain parameters that are live ones.
    pub(super) fn live(&self) -> Vec<String> {
        let branches = if self.robust_horizon > 1 { self.branches() } else { 0 };
        (0..branches).flat_map(|s| self.names().map(move |n| copy(n, s))).collect()
    }

    /// Which branches share their inputs, and the values of the live copies.
    pub(super) fn branching(&self) -> Branching {
        let branches = self.branches();
        let leader = |s: usize, k: usize| {
            let tail = self.combinations.len().pow((self.robust_horizon - k) as u32);
            s - s % tail
        };
        let leaders = (0..self.robust_horizon).map(|k| (0..branches).map(|s| leader(s, k)).collect()).collect();
        let values = |k: usize| {
            let of_branch = |s: usize| self.combinations[self.combination(s, k)].values.iter();
            (0..branches).flat_map(of_branch).map(|v| v.1.to_f64().value()).collect()
        };
        let parameters =
            if self.robust_horizon > 1 { (0..self.robust_horizon).map(values).collect() } else { Vec::new() };
        Branching { branches, leaders, parameters }
    }

    /// The branch of the model's own values from start to end; the first one where these are in no combination.
    pub(super) fn nominal(&self, system: &System) -> usize {
        let own = |c: &Combination| {
            c.values.iter().all(|(name, value)| {
                system.parameters.iter().any(|p| system.symbol_name(p.symbol) == name && p.value == *value)
            })
        };
        let c = self.combinations.iter().position(own).unwrap_or(0);
        (0..self.robust_horizon).fold(0, |s, _| s * self.combinations.len() + c)
    }

    /// What the problem of all branches remembers where one branch remembers `own`.
    pub(super) fn remembered(&self, own: &Remembered) -> Remembered {
        let m = self.product.inputs.len() / self.branches();
        let inputs = (0..self.branches()).flat_map(|s| own.inputs.iter().map(move |j| s * m + j)).collect();
        Remembered { inputs, ..own.clone() }
    }
}

/// Expressions over the names of `system` as those of branch s.
pub(super) fn renamed(system: &System, s: usize, pool: &mut Pool, expressions: &[Expr]) -> Vec<Expr> {
    let (states, inputs) = (system.state_names(), system.input_names());
    let mut map = Vec::new();
    for name in states.iter().chain(&inputs) {
        map.push((pool.var(name), pool.var(&copy(name, s))));
    }
    for name in &inputs {
        map.push((pool.var(&before(name)), pool.var(&before(&copy(name, s)))));
    }
    pool.substitute_all(expressions, &map.into_iter().collect())
}
