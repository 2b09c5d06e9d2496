//! Differential flatness: proofs and disproofs, and flat outputs.

use bracketry_symbolic::{Expr, Pool, Symbol};

use crate::algebra::field::{Field, VectorFields, bracket, is_plain_zero};
use crate::algebra::integrals::search::integrals_of_involutive;
use crate::algebra::involutive::involutive_closure;
use crate::algebra::matrix::{generic_rank, reduced};
use crate::algebra::rational::readable::tidy;
use crate::algebra::span::independent;
use crate::algebra::subsets::subsets;
use crate::evidence::Evidence;
use crate::feedback::extension::{DynamicExtension, ExtensionLimits};
use crate::feedback::ruled::velocities_not_ruled;
use crate::feedback::static_linearization::LinearizationFlag;
use crate::reason::FlatnessReason;
use crate::undecided::Undecided;

/// Whether a system is flat near a generic point (Fliess, Lévine, Martin, and Rouchon 1995).
#[derive(Clone, Debug)]
pub(crate) struct Flatness {
    /// The verdict; `None` if neither was proven.
    pub(crate) flat: Option<bool>,
    /// Flat outputs, if they were found; verified by `extension` or by linearization.
    pub(crate) outputs: Vec<Expr>,
    /// The dynamic feedback that linearizes the system by these outputs; `None` if they were not
    /// found, or none is needed.
    pub(crate) extension: Option<DynamicExtension>,
    /// What the verdict rests on.
    pub(crate) reason: FlatnessReason,
}

/// Most tuples of outputs for which the dynamic extension algorithm is run.
const MAX_TUPLES: usize = 30;
/// Most new nodes of the pool for one of them.
const MAX_TUPLE_NODES: usize = 20_000;
/// Most new nodes in the whole search.
const MAX_SEARCH_NODES: usize = 100_000;
/// Most integrators in front of one input in the search for a linearizable prolongation.
const MAX_PROLONGATION: usize = 3;
/// Most integrators together: the derivatives grow with their number.
pub(crate) const MAX_INTEGRATORS: usize = 5;

/// What is known of a system before its flatness is asked for.
pub(crate) struct Known<'a> {
    /// Names of the inputs.
    pub(crate) inputs: &'a [Symbol],
    /// Functions to try first: the outputs and definitions of the model.
    pub(crate) functions: &'a [Expr],
    /// How many of `functions` are outputs of the model.
    pub(crate) outputs: usize,
    /// Dimension of the strong accessibility distribution.
    pub(crate) strong_dimension: Option<usize>,
    pub(crate) flag: &'a LinearizationFlag,
    /// The dynamic extension for the outputs of the model, if there is one.
    pub(crate) extension: Option<&'a DynamicExtension>,
}

impl Flatness {
    fn no(reason: FlatnessReason) -> Self {
        Flatness { flat: Some(false), outputs: Vec::new(), extension: None, reason }
    }

    fn yes(reason: FlatnessReason) -> Self {
        Flatness { flat: Some(true), outputs: Vec::new(), extension: None, reason }
    }

    fn by_extension(extension: DynamicExtension, outputs: Vec<Expr>, reason: FlatnessReason) -> Self {
        let needed = extension.integrators.iter().any(|&k| k > 0);
        Flatness { flat: Some(true), outputs, extension: needed.then_some(extension), reason }
    }
}

impl VectorFields {
    /// Flat outputs, functions of the state, as far as the criteria here find any: as many as inputs, which must be independent;
    /// `known` are functions to try first. [`VectorFields::dynamic_extension`] for them gives states and inputs.
    ///
    /// # Errors
    /// [`Undecided`] if a function cannot be evaluated exactly or the search is stopped.
    pub fn flat_outputs(
        &self,
        pool: &mut Pool,
        inputs: &[Symbol],
        known: &[Expr],
        evidence: &mut Evidence,
    ) -> Result<Option<Vec<Expr>>, Undecided> {
        if inputs.len() != self.controls.len()
            || generic_rank(pool, &self.controls, &self.bindings, evidence)? < inputs.len()
        {
            return Ok(None);
        }
        let flag = self.linearization_flag(pool, evidence)?;
        let outputs = if known.len() == inputs.len() { known.len() } else { 0 };
        let known = Known { inputs, functions: known, outputs, strong_dimension: None, flag: &flag, extension: None };
        let found = self.flatness(pool, &known, evidence)?;
        Ok(Some(found.outputs).filter(|list| list.len() == inputs.len()))
    }

    /// Decides on flatness as far as the criteria here go. The input fields must be independent.
    pub(crate) fn flatness(
        &self,
        pool: &mut Pool,
        known: &Known<'_>,
        evidence: &mut Evidence,
    ) -> Result<Flatness, Undecided> {
        let (n, m) = (self.states.len(), self.controls.len());
        if known.strong_dimension.is_some_and(|d| d < n) {
            return Ok(Flatness::no(FlatnessReason::NotAccessible));
        }
        if known.flag.linearizable() {
            // The verdict does not wait for the outputs.
            let found = self.linearizing_functions(pool, known.flag, known.functions, evidence);
            let outputs = found.ok().flatten().unwrap_or_default();
            return Ok(Flatness { outputs, ..Flatness::yes(FlatnessReason::StaticFeedback) });
        }
        if m == 1 {
            return Ok(Flatness::no(FlatnessReason::OneInput));
        }
        if velocities_not_ruled(pool, self) {
            return Ok(Flatness::no(FlatnessReason::NotRuled));
        }
        let mut search = Search { system: self, known, first: pool.len(), tuples: 0 };
        let driftless = is_plain_zero(pool, &self.drift);
        let accessible = known.strong_dimension == Some(n);
        let mut proven = None;
        if driftless && m == 2 {
            match search.two_inputs_without_drift(pool, evidence)? {
                Some(found) if found.flat == Some(false) => return Ok(found),
                found => proven = found,
            }
        } else if accessible && n == m + 1 {
            proven = Some(Flatness::yes(FlatnessReason::OneInputLess));
        } else if accessible && driftless && n == m + 2 {
            proven = Some(Flatness::yes(FlatnessReason::TwoInputsLess));
        }
        if let Some(found) = proven.take_if(|p| !p.outputs.is_empty()) {
            return Ok(found);
        }
        let found = search.outputs(pool, evidence);
        if let Ok(Some(found)) = found {
            let reason = proven.map_or(found.reason.clone(), |p| p.reason);
            return Ok(Flatness { reason, ..found });
        }
        if let Some(proven) = proven {
            return Ok(proven);
        }
        if let Some(found) = search.prolongation(pool, evidence) {
            return Ok(found);
        }
        let reason = match found {
            Err(why) => why.into(),
            Ok(_) => FlatnessReason::NotFound,
        };
        Ok(Flatness { flat: None, outputs: Vec::new(), extension: None, reason })
    }

    /// The system with `count` integrators in front of one input.
    fn prolonged(&self, pool: &mut Pool, input: usize, count: usize) -> VectorFields {
        let mut system = self.clone();
        let (zero, one) = (pool.int(0), pool.int(1));
        for k in 0..count {
            let state = pool.symbol(&format!("integral {k} of input {input}"));
            let z = pool.sym(state);
            let g = std::mem::take(&mut system.controls[input]);
            for (f, &h) in system.drift.iter_mut().zip(&g) {
                let term = pool.mul(z, h);
                *f = pool.add(*f, term);
            }
            system.states.push(state);
            let n = system.states.len();
            system.drift.push(zero);
            system.controls[input] = vec![zero; n];
            system.controls[input][n - 1] = one;
            for field in &mut system.controls {
                field.resize(n, zero);
            }
        }
        system
    }
}

struct Search<'a> {
    system: &'a VectorFields,
    known: &'a Known<'a>,
    first: usize,
    tuples: usize,
}

impl Search<'_> {
    fn exhausted(&self, pool: &Pool) -> bool {
        self.tuples >= MAX_TUPLES || pool.len() > self.first + MAX_SEARCH_NODES
    }

    /// Runs the dynamic extension algorithm for a tuple of outputs.
    fn attempt(
        &mut self,
        pool: &mut Pool,
        outputs: &[Expr],
        evidence: &mut Evidence,
    ) -> Result<Option<DynamicExtension>, Undecided> {
        let rows: Vec<Field> = outputs.iter().map(|&h| pool.gradient(h, &self.system.states)).collect();
        if generic_rank(pool, &rows, &self.system.bindings, evidence)? < outputs.len() {
            return Ok(None);
        }
        if let Some(known) = self.known.extension.filter(|_| outputs == &self.known.functions[..self.known.outputs]) {
            return Ok(Some(known.clone()).filter(DynamicExtension::linearizes));
        }
        self.tuples += 1;
        let limits =
            ExtensionLimits { integrators: MAX_INTEGRATORS.min(self.system.states.len()), nodes: MAX_TUPLE_NODES };
        match self.system.dynamic_extension(pool, outputs, self.known.inputs, limits, evidence) {
            Ok(found) => Ok(found.filter(DynamicExtension::linearizes)),
            // Too large an expression says nothing about other outputs.
            Err(Undecided::TooLarge { .. }) => Ok(None),
            Err(why) => Err(why),
        }
    }

    /// Flat outputs among functions of the state.
    fn outputs(&mut self, pool: &mut Pool, evidence: &mut Evidence) -> Result<Option<Flatness>, Undecided> {
        let m = self.system.controls.len();
        let model = &self.known.functions[..self.known.outputs];
        if model.len() == m
            && let Some(found) = self.attempt(pool, model, evidence)?
        {
            return Ok(Some(Flatness::by_extension(found, model.to_vec(), FlatnessReason::ModelOutputs)));
        }
        if let Some(found) = self.integrals(pool, evidence)? {
            return Ok(Some(found));
        }
        let mut candidates = self.known.functions.to_vec();
        for h in self.states_by_degree(pool, evidence)? {
            if !candidates.contains(&h) {
                candidates.push(h);
            }
        }
        for tuple in subsets(candidates.len().min(12), m) {
            if self.exhausted(pool) {
                break;
            }
            let outputs: Vec<Expr> = tuple.iter().map(|&i| candidates[i]).collect();
            if outputs == model {
                continue;
            }
            if let Some(found) = self.attempt(pool, &outputs, evidence)? {
                return Ok(Some(Flatness::by_extension(found, outputs, FlatnessReason::Functions)));
            }
        }
        Ok(None)
    }

    /// The states, those first that the inputs reach last.
    fn states_by_degree(&self, pool: &mut Pool, evidence: &mut Evidence) -> Result<Vec<Expr>, Undecided> {
        let states: Vec<Expr> = self.system.states.iter().map(|&s| pool.sym(s)).collect();
        let degrees = self.system.relative_degree(pool, &states, evidence)?.degrees;
        let mut order: Vec<usize> = (0..states.len()).filter(|&i| degrees[i].is_some()).collect();
        order.sort_by_key(|&i| std::cmp::Reverse(degrees[i]));
        Ok(order.into_iter().map(|i| states[i]).collect())
    }

    /// Functions that some inputs reach late: integrals of the closure of all input fields with `ad_f^k Y`, for Y of a
    /// subset of the input fields, or one of their characteristic combinations. The one that leaves as many functions as there
    /// are inputs.
    fn integrals(&mut self, pool: &mut Pool, evidence: &mut Evidence) -> Result<Option<Flatness>, Undecided> {
        let (n, m) = (self.system.states.len(), self.system.controls.len());
        if is_plain_zero(pool, &self.system.drift) || n <= m {
            return Ok(None);
        }
        for size in 0..m {
            for subset in subsets(m, size) {
                let fields = subset.iter().map(|&i| self.system.controls[i].clone()).collect();
                if let Some(found) = self.reached_late(pool, fields, evidence)? {
                    return Ok(Some(found));
                }
            }
        }
        for y in self.system.characteristic_inputs(pool, evidence)? {
            if let Some(found) = self.reached_late(pool, vec![y], evidence)? {
                return Ok(Some(found));
            }
        }
        Ok(None)
    }

    /// Flat outputs among the functions that `last` reach later than the other inputs.
    fn reached_late(
        &mut self,
        pool: &mut Pool,
        mut last: Vec<Field>,
        evidence: &mut Evidence,
    ) -> Result<Option<Flatness>, Undecided> {
        let (n, m) = (self.system.states.len(), self.system.controls.len());
        let mut span = self.system.controls.clone();
        for _ in 0..n {
            if self.exhausted(pool) {
                return Ok(None);
            }
            let closure = involutive_closure(pool, &self.system.states, &span, &self.system.bindings, evidence)?;
            let left = n - closure.dimension();
            if left == m {
                let mut known = self.known.functions.to_vec();
                known.extend(self.system.circular_functions(pool));
                let (basis, bindings) = (&closure.basis, &self.system.bindings);
                let found = integrals_of_involutive(pool, &self.system.states, basis, &known, bindings, evidence)?;
                let outputs: Vec<Expr> = found.functions.iter().map(|&h| tidy(pool, h)).collect();
                if outputs.len() == m
                    && let Some(extension) = self.attempt(pool, &outputs, evidence)?
                {
                    return Ok(Some(Flatness::by_extension(extension, outputs, FlatnessReason::Functions)));
                }
            }
            if left <= m || last.is_empty() {
                break;
            }
            for y in &mut last {
                *y = bracket(pool, &self.system.states, &self.system.drift, y);
            }
            let before = span.len();
            span.extend(last.iter().cloned());
            span = independent(pool, &span, &self.system.bindings, evidence)?;
            if span.len() == before {
                break;
            }
        }
        Ok(None)
    }

    /// Martin and Rouchon 1994: x' = u1 g1 + u2 g2 is flat near a generic point just when the
    /// derived flag E_{k+1} = E_k + [E_k, E_k] has dimensions 2, 3, 4, …, n. Outputs φ1, φ2 are then flat
    /// just when their common annihilator lies in E_{n−3} (Li and Respondek 2012).
    fn two_inputs_without_drift(
        &mut self,
        pool: &mut Pool,
        evidence: &mut Evidence,
    ) -> Result<Option<Flatness>, Undecided> {
        let system = self.system;
        let (n, states, bindings) = (system.states.len(), &system.states, &system.bindings);
        let flag = involutive_closure(pool, states, &system.controls, bindings, evidence)?;
        let reason = |expected| FlatnessReason::DerivedFlag { dimensions: flag.growth.clone(), expected };
        if flag.growth.iter().copied().ne(2..=n) {
            return Ok(Some(Flatness::no(reason(Some(n)))));
        }
        let mut found = Flatness::yes(reason(None));
        if n < 3 {
            return Ok(Some(found));
        }
        let corank_one = &flag.basis[..n - 1];
        let mut candidates = self.known.functions.to_vec();
        for &s in states {
            let x = pool.sym(s);
            if !candidates.contains(&x) {
                candidates.push(x);
            }
        }
        for pair in subsets(candidates.len(), 2) {
            let pair: Vec<Expr> = pair.into_iter().map(|i| candidates[i]).collect();
            if system.annihilator_within(pool, &pair, corank_one, evidence)? {
                found.outputs = pair;
                break;
            }
        }
        if found.outputs.is_empty() {
            let corank_one = reduced(pool, corank_one, bindings, evidence)?;
            for &h in &candidates {
                if let Some(pair) =
                    system.completed(pool, h, &corank_one, self.known.functions, self.first, evidence)?
                {
                    found.outputs = pair;
                    break;
                }
            }
        }
        // Flat outputs of a chain need an integrator for every state but two.
        if !found.outputs.is_empty()
            && n - 2 <= MAX_INTEGRATORS
            && let Some(extension) = self.attempt(pool, &found.outputs.clone(), evidence)?
        {
            found.extension = Some(extension);
        }
        Ok(Some(found))
    }

    /// Whether the system becomes linearizable by static feedback with integrators in front of one input.
    fn prolongation(&self, pool: &mut Pool, evidence: &mut Evidence) -> Option<Flatness> {
        for count in 1..=MAX_PROLONGATION {
            for input in 0..self.system.controls.len() {
                if pool.len() > self.first + MAX_SEARCH_NODES {
                    return None;
                }
                let extended = self.system.prolonged(pool, input, count);
                let Ok(flag) = extended.linearization_flag(pool, evidence) else { continue };
                if flag.linearizable() {
                    let input = pool.name(self.known.inputs[input]).to_owned();
                    return Some(Flatness::yes(FlatnessReason::Prolongation { integrators: count, input }));
                }
            }
        }
        None
    }
}
