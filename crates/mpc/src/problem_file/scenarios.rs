//! The control problem of all branches of a scenario tree, read from the same file as that of one model.

use super::reader::{Located, Parsed, Reader};
use super::scaling::Expected;
use super::tree::Tree;
use crate::controller::{Brake, FailurePolicy};
use crate::ocp::{Bounds, CostKind, CostNames, Ocp, PreviousInput, Substeps};
use crate::problem::{ControlProblem, ProblemError, RunConditions, ScenarioTree};
use bracketry_symbolic::Named;
use bracketry_system::{Table, Value};

/// Tables whose expressions may name uncertain parameters.
const WITH_PARAMETERS: [&str; 3] = ["cost", "constraints", "target"];

impl Reader<'_> {
    /// The problem of all branches; `own` is that of one branch, `names` are the references of its costs, `level` is that of its
    /// cost.
    pub(super) fn scenarios(
        &self,
        table: &Table<'_>,
        tree: &Tree,
        own: &ControlProblem,
        names: &[String],
        level: f64,
    ) -> Result<ScenarioTree, ProblemError> {
        self.check_tree(table, tree, own, names)?;
        let count = tree.branches();
        let (n, m) = (own.ocp.model_states(), own.ocp.inputs());
        let mut ocp = own.ocp.repeated(count);
        ocp.branching = Some(tree.branching());
        let mut state_bounds: Vec<Bounds> = Vec::new();
        for s in 0..count {
            let reader = Reader { system: &tree.systems[tree.last(s)], tree: Some(tree), branch: s, ..*self };
            let mut branch = own.ocp.clone();
            branch.state_bounds.fill(Bounds::FREE);
            branch.input_bounds.fill((f64::NEG_INFINITY, f64::INFINITY));
            branch.path_constraints.clear();
            branch.norm_constraints.clear();
            branch.targets.clear();
            reader.ranges(&mut branch);
            reader.constraints(table, names, &mut branch)?;
            reader.targets(table, &mut branch)?;
            // Weights of violations are those of the model's own values.
            for (b, o) in branch.state_bounds.iter_mut().zip(&own.ocp.state_bounds) {
                b.softness = o.softness;
            }
            for (c, o) in branch.path_constraints.iter_mut().zip(&own.ocp.path_constraints) {
                c.bounds.softness = o.bounds.softness;
            }
            for (c, o) in branch.norm_constraints.iter_mut().zip(&own.ocp.norm_constraints) {
                c.softness = o.softness;
            }
            state_bounds.extend_from_slice(&branch.state_bounds[..n]);
            ocp.input_bounds[s * m..(s + 1) * m].copy_from_slice(&branch.input_bounds);
            ocp.path_constraints.extend(branch.path_constraints);
            ocp.norm_constraints.extend(branch.norm_constraints);
            branch.targets.iter_mut().for_each(|t| t.state += s * n);
            ocp.targets.extend(branch.targets);
        }
        ocp.state_bounds[..count * n].copy_from_slice(&state_bounds);
        ocp.substeps = self.substeps_of_branches(tree, own)?;
        let reader = Reader { tree: Some(tree), ..*self };
        reader.costs(table, names, &mut ocp)?;
        let live = [own.live.clone(), tree.live()].concat();
        reader.end_of_horizon(table, &live, level, &mut ocp)?;
        let rest_input = own.rest_input.repeat(count);
        let repeated = |rows: &[Vec<f64>]| rows.iter().map(|row| row.repeat(count)).collect();
        let problem = ControlProblem {
            system: tree.product.clone(),
            plant: tree.product.clone(),
            policy: repeated_policy(&own.policy, count, (n, m)),
            rest_input,
            live,
            guess: repeated(&own.guess),
            x0: own.x0.repeat(count),
            u0: own.u0.repeat(count),
            conditions: RunConditions::default(),
            estimation: None,
            ocp,
            ..own.clone()
        };
        let checked = problem.ocp.check(problem.system.states.len(), problem.system.inputs.len());
        checked.map_err(|e| self.doc.missing(e.to_string(), "change the value that it names"))?;
        let values = |c: &super::tree::Combination| {
            Named(c.values.iter().map(|(name, v)| (name.clone(), v.to_f64().value())).collect())
        };
        Ok(ScenarioTree {
            own: own.ocp.clone(),
            problem,
            nominal: tree.nominal(self.system),
            robust_horizon: tree.robust_horizon,
            combinations: tree.combinations.iter().map(values).collect(),
        })
    }

    /// Integration steps of an interval that are enough for every branch.
    fn substeps_of_branches(&self, tree: &Tree, own: &ControlProblem) -> Result<Substeps, ProblemError> {
        let mut substeps = own.ocp.substeps;
        for system in &tree.systems {
            let mut ocp = own.ocp.clone();
            let reader = Reader { system, ..*self };
            let Expected { .. } = reader.expected_sizes(&own.x0, &own.guess, &mut ocp)?;
            if let (Substeps::AtLeast(most), Substeps::AtLeast(s)) = (substeps, ocp.substeps) {
                substeps = Substeps::AtLeast(most.max(s));
            }
        }
        Ok(substeps)
    }

    /// Refuses what a tree cannot be combined with.
    fn check_tree(&self, table: &Table<'_>, tree: &Tree, own: &ControlProblem, names: &[String]) -> Parsed<()> {
        let place = || table.get("uncertainty").map_or(0..0, toml::Spanned::span);
        if let Some(name) = tree.names().find(|n| own.live.iter().any(|l| l == n)) {
            let message = format!("`{name}` is uncertain, and also live or a function of time");
            return Err(self.doc.error(place(), message, "keep it in one of the two places").into());
        }
        if tree.robust_horizon > own.ocp.steps {
            let message = format!("the robust horizon is longer than the {} intervals of the horizon", own.ocp.steps);
            return Err(self.doc.error(place(), message, "shorten `robust_horizon`: 1 or 2 is usual").into());
        }
        if tree.robust_horizon > 1 {
            for key in WITH_PARAMETERS {
                for v in self.doc.sub_table(table, key)?.into_iter().flat_map(Table::values) {
                    self.without_uncertain(v, tree, names)?;
                }
            }
        }
        Ok(())
    }

    /// Refuses uncertain parameters in what is the same over the horizon.
    fn without_uncertain(&self, v: Located<'_, '_>, tree: &Tree, names: &[String]) -> Parsed<()> {
        match v.get_ref() {
            Value::Array(list) => list.iter().try_for_each(|v| self.without_uncertain(v, tree, names)),
            Value::Table(t) => t.values().try_for_each(|v| self.without_uncertain(v, tree, names)),
            Value::String(_) => {
                let symbols: Vec<String> = names.iter().cloned().chain(tree.names().map(str::to_owned)).collect();
                let (context, mut pool) = CostNames::new(self.system, CostKind::Stage, &symbols);
                let mut context = context.with_remembered(self.remembered);
                // What is no expression is looked at elsewhere.
                let Ok(e) = self.doc.expression(v, "expression", &mut pool, &mut context) else { return Ok(()) };
                let uses = |name: &&str| {
                    let symbol = pool.symbol(name);
                    pool.depends_on(e, symbol)
                };
                let mut uncertain = tree.names();
                match uncertain.find(uses) {
                    None => Ok(()),
                    Some(name) => {
                        let message =
                            format!("with a robust horizon above 1, `{name}` can be used in the dynamics only");
                        let remedy = "write robust_horizon = 1, or replace it by a number";
                        Err(self.doc.error(v.span(), message, remedy).into())
                    }
                }
            }
            _ => Ok(()),
        }
    }
}

/// The failure policy with the brakes of one branch in all of them.
fn repeated_policy(policy: &FailurePolicy, count: usize, (n, m): (usize, usize)) -> FailurePolicy {
    let FailurePolicy::BrakeToRest { after, brakes } = policy else { return policy.clone() };
    let of_branch =
        |s: usize| brakes.iter().map(move |b| Brake { input: s * m + b.input, velocity: s * n + b.velocity, ..*b });
    FailurePolicy::BrakeToRest { after: *after, brakes: (0..count).flat_map(of_branch).collect() }
}

impl Ocp {
    /// The numbers of the problem once per branch, without costs, constraints, and targets.
    fn repeated(&self, count: usize) -> Self {
        let (n, m) = (self.model_states(), self.inputs());
        let previous =
            |s: usize| self.previous_inputs.iter().map(move |p| PreviousInput { input: s * m + p.input, rate: p.rate });
        let mut ocp = self.clone();
        ocp.input_bounds = self.input_bounds.repeat(count);
        ocp.input_trust = self.input_trust.repeat(count);
        ocp.state_bounds = repeated(&self.state_bounds, n, count);
        ocp.state_scale = repeated(&self.state_scale, n, count);
        ocp.state_size = repeated(&self.state_size, n.min(self.state_size.len()), count);
        ocp.state_trust = repeated(&self.state_trust, n, count);
        ocp.previous_inputs = (0..count).flat_map(previous).collect();
        // The one input of the tree that is applied is rounded.
        ocp.input_values.clear();
        ocp.path_constraints.clear();
        ocp.norm_constraints.clear();
        ocp.targets.clear();
        for row in &mut ocp.margins.states {
            *row = repeated(row, n, count);
        }
        ocp.margins.path = vec![self.margins.path.clone(); count].concat();
        (ocp.stage, ocp.terminal, ocp.terminal_set) = (None, None, None);
        ocp
    }
}

/// A list over the states of the dynamics and the previous inputs, for all branches.
fn repeated<T: Copy>(list: &[T], states: usize, count: usize) -> Vec<T> {
    let (states, previous) = list.split_at(states);
    [states.repeat(count), previous.repeat(count)].concat()
}
