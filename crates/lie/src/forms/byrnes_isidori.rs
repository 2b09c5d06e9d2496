//! The Byrnes–Isidori form: outputs with their derivatives, and the states that they leave open.

use bracketry_symbolic::{Expr, Function};
use bracketry_system::Point;
use rustc_hash::FxHashMap;

use crate::algebra::matrix::{generic_rank, solve};
use crate::algebra::rational::readable::tidy;
use crate::algebra::span::involutive;
use crate::feedback::outputs::fed_through;
use crate::feedback::relative_degree::RelativeDegree;
use crate::forms::change::{Changed, Plan};
use crate::forms::frame::Frame;
use crate::forms::normal_form::{BlockKind, FormNote, NormalForm, Part, PartKind};
use crate::forms::obstacle::{Obstacle, Stop};
use crate::undecided::Undecided;

/// The internal coordinates η.
struct Internal {
    functions: Vec<Expr>,
    /// Whether L_g η = 0.
    free_of_inputs: bool,
}

impl Frame {
    /// `ξ_(i,k)' = ξ_(i,k+1)`, `ξ_(i,r_i)' = b_i(ξ, η) + Σ a_ij(ξ, η) u_j`, `η' = q(ξ, η) + p(ξ, η) u` (Byrnes and Isidori
    /// 1988; Isidori 1995, sec. 5.1), with p = 0 where the distribution of the inputs is involutive and the functions
    /// constant along it are found.
    pub(crate) fn byrnes_isidori(&mut self) -> Result<NormalForm, Stop> {
        let degrees = self.square_relative_degree()?;
        let (n, m) = (self.fields.states.len(), self.fields.controls.len());
        let xi = degrees.derivatives.concat();
        let internal = self.internal(&xi)?;
        let (new_xi, new_eta) = (self.fresh("xi", xi.len()), self.fresh("eta", n - xi.len()));
        let new: Vec<_> = new_xi.iter().chain(&new_eta).copied().collect();
        let mut known: Vec<Option<Expr>> = vec![None; n];
        let mut next = 0;
        let names = self.output_names();
        let mut blocks = Vec::new();
        for (list, output) in degrees.derivatives.iter().zip(names) {
            for k in 0..list.len() - 1 {
                known[next + k] = Some(self.system.pool.sym(new[next + k + 1]));
            }
            blocks.push((BlockKind::Output { output }, (next..next + list.len()).collect()));
            next += list.len();
        }
        blocks.push((BlockKind::Internal { free_of_inputs: internal.free_of_inputs }, (next..n).collect()));
        let singular = (next == n).then(|| degrees.singular_factors(&mut self.system.pool, &self.fields)).flatten();
        let notes = if internal.free_of_inputs || next == n { vec![] } else { vec![FormNote::InternalDrivenByInputs] };
        let plan = Plan {
            coordinates: xi.into_iter().chain(internal.functions).collect(),
            new: new.clone(),
            feedback: None,
            known,
            inverse: None,
            regular: None,
            singular,
            blocks,
            keep_names: false,
            suffix: "byrnes_isidori",
            notes,
        };
        let changed = self.change(plan)?;
        let mut form = self.with_feedback(&changed, &degrees, m);
        if next < n {
            self.add_zero_dynamics(&mut form, &changed, &degrees, next);
        }
        Ok(form)
    }

    /// The vector relative degree of as many outputs as inputs.
    fn square_relative_degree(&mut self) -> Result<RelativeDegree, Stop> {
        let m = self.fields.controls.len();
        if m == 0 {
            return Err(Stop::No(Obstacle::NoInputs));
        }
        let outputs = self.output_functions();
        if outputs.is_empty() {
            return Err(Stop::No(Obstacle::NoOutputs));
        }
        if outputs.len() != m {
            return Err(Stop::Unknown(Obstacle::NotSquare { outputs: outputs.len(), inputs: m }));
        }
        if fed_through(&self.system) {
            return Err(Stop::No(Obstacle::FedThrough));
        }
        let pool = &mut self.system.pool;
        let degrees = self.fields.relative_degree(pool, &outputs, &mut self.evidence)?;
        if let Some(k) = degrees.degrees.iter().position(Option::is_none) {
            let output = self.output_names().swap_remove(k);
            return Err(Stop::No(Obstacle::Unreached { output }));
        }
        if !degrees.is_vector() {
            return Err(Stop::No(Obstacle::NoRelativeDegree { rank: degrees.rank, outputs: outputs.len() }));
        }
        Ok(degrees)
    }

    /// Functions that complete ξ to coordinates: constant along the inputs where such are found, else states.
    fn internal(&mut self, xi: &[Expr]) -> Result<Internal, Stop> {
        let n = self.fields.states.len();
        let missing = n - xi.len();
        if missing == 0 {
            return Ok(Internal { functions: Vec::new(), free_of_inputs: true });
        }
        let controls = self.fields.controls.clone();
        let mut along = self.constant_states(&controls)?;
        let found = self.completion(xi, &along)?;
        if found.len() == missing {
            return Ok(Internal { functions: found, free_of_inputs: true });
        }
        let (fields, evidence) = (&self.fields, &mut self.evidence);
        if involutive(&mut self.system.pool, &fields.states, &controls, 0, &fields.bindings, evidence)? {
            along.extend(self.constants_along(&controls)?);
            let found = self.completion(xi, &along)?;
            if found.len() == missing {
                return Ok(Internal { functions: found, free_of_inputs: true });
            }
        }
        let states = self.state_functions();
        let functions = self.completion(xi, &states)?;
        Ok(Internal { functions, free_of_inputs: false })
    }

    /// The form with the feedback that makes the last derivatives new inputs, told but not applied.
    fn with_feedback(&mut self, changed: &Changed, degrees: &RelativeDegree, m: usize) -> NormalForm {
        let mut form = changed.form.clone();
        let v = self.fresh("v", m);
        if let Ok(feedback) = self.decoupling_feedback(degrees, v) {
            let pool = &self.system.pool;
            let law = self.system.inputs.iter().zip(&feedback.law);
            form.linearizing_feedback.0 =
                law.map(|(&u, &e)| (pool.name(u).to_owned(), Function::new(pool, e))).collect();
        }
        form
    }

    /// η' = q(0, η) + p(0, η) u with the u that keeps ξ = 0.
    fn add_zero_dynamics(&mut self, form: &mut NormalForm, changed: &Changed, degrees: &RelativeDegree, split: usize) {
        match self.held(changed, degrees, split) {
            Ok(part) => form.parts.push(part),
            Err(why) => form.notes.push(FormNote::NoZeroDynamics { why }),
        }
    }

    fn held(&mut self, changed: &Changed, degrees: &RelativeDegree, split: usize) -> Result<Part, Obstacle> {
        let inputs = self.inputs();
        let new = &changed.form.system;
        let (states, point) = (new.states.clone(), new.point.clone());
        let pool = &mut self.system.pool;
        let zero = pool.int(0);
        let mut held: FxHashMap<Expr, Expr> = states[..split].iter().map(|&s| (pool.sym(s), zero)).collect();
        let mut next = 0;
        // The last rate of every output, b + A u = 0; the output itself keeps its value at the point.
        let mut last = Vec::new();
        for list in &degrees.derivatives {
            if let Some(point) = &point {
                // The new system's pool is a copy of this one, made when all of the point was there.
                let value = Function::new(&new.pool, point.states[next]).copied_into(pool);
                held.insert(pool.sym(states[next]), value);
            }
            next += list.len();
            last.push(next - 1);
        }
        let on_set: Vec<Expr> = pool.substitute_all(&changed.rates, &held);
        let none: FxHashMap<Expr, Expr> = inputs.iter().map(|&u| (u, zero)).collect();
        let (mut a, mut b) = (Vec::new(), Vec::new());
        for &k in &last {
            let row: Vec<Expr> = self.system.inputs.iter().map(|&u| pool.diff(on_set[k], u)).collect();
            a.push(row.into_iter().map(|e| tidy(pool, e)).collect::<Vec<_>>());
            let drift = pool.substitute(on_set[k], &none);
            b.push(pool.neg(drift));
        }
        if generic_rank(pool, &a, &self.fields.bindings, &mut self.evidence)? < a.len() {
            return Err(Obstacle::SingularWhereHeld);
        }
        let values = solve(pool, &a, &b).ok_or(Undecided::TooLarge { nodes: pool.len() })?;
        let law: FxHashMap<Expr, Expr> = inputs.iter().copied().zip(values).collect();
        let rates: Vec<Expr> = pool.substitute_all(&on_set[split..], &law);
        let rates: Vec<Expr> = rates.into_iter().map(|e| tidy(pool, e)).collect();
        for &e in &rates {
            // A division by zero has no value.
            self.fields.vanishes(pool, e, &mut self.evidence)?;
        }
        let mut system = new.clone();
        system.point = point.map(|p| Point { states: p.states[split..].to_vec(), inputs: Vec::new() });
        system.dynamics = rates.iter().map(|&e| Function::new(pool, e).copied_into(&mut system.pool)).collect();
        system.name = format!("{}_zero_dynamics", self.system.name);
        system.states = states[split..].to_vec();
        system.inputs.clear();
        system.input_ranges.clear();
        system.input_delays.clear();
        system.outputs.clear();
        Ok(Part { kind: PartKind::ZeroDynamics, system })
    }
}
