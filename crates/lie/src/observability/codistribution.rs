//! What the outputs tell about states and parameters.

use bracketry_symbolic::{Bindings, Expr, Pool, Symbol};

use crate::algebra::annihilator::annihilator;
use crate::algebra::field::{Field, VectorFields, is_plain_zero};
use crate::algebra::span::independent;
use crate::budget::check_growth;
use crate::evidence::Evidence;
use crate::residues::unit_row;
use crate::residues::{Echelon, Fp, OFFSET};
use crate::undecided::Undecided;

/// Points and seed of the samples at which it is read off what a codistribution determines.
const POINTS: usize = 3;
const SEED: u64 = 0x6272_6163_6b65_7406;

/// What the outputs determine at a generic point, for inputs that vary freely.
#[derive(Clone)]
pub struct Observability {
    /// States, then unknown parameters.
    pub variables: Vec<Symbol>,
    /// Independent differentials, by `variables`, of repeated Lie derivatives of the outputs.
    pub codistribution: Vec<Vec<Expr>>,
    /// The functions whose differentials these are.
    pub functions: Vec<Expr>,
    bindings: Bindings,
}

impl Observability {
    /// Dimension of the codistribution.
    pub fn rank(&self) -> usize {
        self.codistribution.len()
    }

    /// Whether the outputs determine the value of `function` locally.
    ///
    /// # Errors
    /// [`Undecided`] if a function cannot be evaluated exactly.
    pub fn determines(&self, pool: &mut Pool, function: Expr, evidence: &mut Evidence) -> Result<bool, Undecided> {
        let mut all = self.codistribution.clone();
        all.push(pool.gradient(function, &self.variables));
        Ok(independent(pool, &all, &self.bindings, evidence)?.len() == self.rank())
    }

    /// The same for each of the variables.
    ///
    /// # Errors
    /// [`Undecided`] if a function cannot be evaluated exactly.
    pub fn determined_variables(&self, pool: &mut Pool, evidence: &mut Evidence) -> Result<Vec<bool>, Undecided> {
        let n = self.variables.len();
        if self.rank() == n {
            return Ok(vec![true; n]);
        }
        if let Some(spans) = self.spans(pool, evidence)? {
            return Ok((0..n).map(|i| spans.iter().any(|s| s.contains(&unit_row(i, n)))).collect());
        }
        let mut list = Vec::with_capacity(n);
        for &s in &self.variables {
            let x = pool.sym(s);
            list.push(self.determines(pool, x, evidence)?);
        }
        Ok(list)
    }

    /// A smallest set of `candidates` that, once known, makes the outputs determine all of
    /// `candidates`; `None` if that cannot be decided.
    ///
    /// Knowing p adds dp to the codistribution, which stays closed under Lie derivatives because
    /// p is constant. Modulo the codistribution the sets that do are the bases of the span of the
    /// candidates' differentials: all have the same size, and the first independent ones are one.
    ///
    /// # Errors
    /// [`Undecided`] if a function cannot be evaluated exactly.
    pub fn fix_to_determine(
        &self,
        pool: &mut Pool,
        candidates: &[Symbol],
        evidence: &mut Evidence,
    ) -> Result<Option<Vec<Symbol>>, Undecided> {
        let Some(mut spans) = self.spans(pool, evidence)? else { return Ok(None) };
        let Some(span) = spans.first_mut() else { return Ok(None) };
        let n = self.variables.len();
        let place = |s: &Symbol| self.variables.iter().position(|v| v == s);
        Ok(Some(candidates.iter().filter(|s| place(s).is_some_and(|i| span.insert(unit_row(i, n)))).copied().collect()))
    }

    /// Independent vector fields on the variables along which no output changes, whatever the
    /// inputs: states and parameters that their flows connect cannot be told apart.
    ///
    /// # Errors
    /// [`Undecided`] if a function cannot be evaluated exactly.
    pub fn unobservable_directions(&self, pool: &mut Pool, evidence: &mut Evidence) -> Result<Vec<Field>, Undecided> {
        if self.rank() == self.variables.len() {
            return Ok(Vec::new());
        }
        annihilator(pool, &self.variables, &self.codistribution, &self.bindings, evidence)
    }

    /// Spans of the codistribution at random points at which it has full rank; `None` where a
    /// root of a square leaves its sign open.
    fn spans(&self, pool: &mut Pool, evidence: &mut Evidence) -> Result<Option<Vec<Echelon>>, Undecided> {
        let n = self.variables.len();
        if self.codistribution.is_empty() {
            return Ok(Some(vec![Echelon::empty(self.variables.len())]));
        }
        let Ok(samples) = pool.sample_in::<OFFSET>(&self.codistribution.concat(), &self.bindings, POINTS, SEED) else {
            return Ok(None);
        };
        if samples.ambiguous_signs > 0 {
            return Ok(None);
        }
        evidence.add_rank(&samples, self.rank())?;
        let spans = samples.values.iter().map(|values| {
            let rows: Vec<Vec<Fp>> = values.chunks(n).map(<[Fp]>::to_vec).collect();
            Echelon::new(&rows, n)
        });
        let full: Vec<Echelon> = spans.filter(|s| s.rank() == self.rank()).collect();
        Ok((!full.is_empty()).then_some(full))
    }
}

impl VectorFields {
    /// The Hermann–Krener rank condition for the states and the `unknown` parameters, which
    /// are treated as further states with derivative zero (and as generic, bound or not).
    ///
    /// Over the field of functions `L_X(a dh) = (X·a) dh + a dL_X h`, so only Lie derivatives
    /// of functions with a new independent differential need to be formed.
    ///
    /// # Errors
    /// [`Undecided`] if a function cannot be evaluated exactly.
    pub fn observability(
        &self,
        pool: &mut Pool,
        outputs: &[Expr],
        unknown: &[Symbol],
        evidence: &mut Evidence,
    ) -> Result<Observability, Undecided> {
        self.observability_given(pool, outputs, unknown, &[], evidence)
    }

    /// [`Self::observability`] where the states `known` are known functions of time, such as
    /// those of integrators in front of inputs: their differentials count as zero.
    ///
    /// The Lie derivatives of the differentials of known states are again such differentials as
    /// long as the rates of known states depend on no other state; then the codistribution
    /// modulo them is closed.
    ///
    /// # Errors
    /// [`Undecided`] if a function cannot be evaluated exactly.
    pub fn observability_given(
        &self,
        pool: &mut Pool,
        outputs: &[Expr],
        unknown: &[Symbol],
        known: &[Symbol],
        evidence: &mut Evidence,
    ) -> Result<Observability, Undecided> {
        let variables: Vec<Symbol> =
            self.states.iter().chain(unknown).filter(|s| !known.contains(s)).copied().collect();
        let mut bindings = Bindings::new();
        let mut roots = self.controls.concat();
        roots.extend(&self.drift);
        roots.extend(outputs);
        for s in pool.symbols_of(&roots) {
            if let Some(v) = self.bindings.get(s).filter(|_| !unknown.contains(&s)) {
                bindings.bind(s, v.clone());
            }
        }
        let first_node = pool.len();
        let mut differentials = Vec::new();
        let mut functions = Vec::new();
        let mut fresh = Vec::new();
        let mut candidates: Vec<Expr> = outputs.to_vec();
        while !candidates.is_empty() && differentials.len() < variables.len() {
            for h in candidates.drain(..) {
                check_growth(pool, first_node, [&[h], &[]], variables.len())?;
                let d = pool.gradient(h, &variables);
                // A function of known states alone tells nothing new, and neither do its derivatives.
                if is_plain_zero(pool, &d) {
                    continue;
                }
                differentials.push(d);
                if independent(pool, &differentials, &bindings, evidence)?.len() == differentials.len() {
                    fresh.push(h);
                    functions.push(h);
                } else {
                    differentials.pop();
                }
            }
            for h in fresh.drain(..) {
                for x in std::iter::once(&self.drift).chain(&self.controls) {
                    let l = pool.lie_derivative(h, &self.states, x);
                    if pool.number(l).is_none() {
                        candidates.push(l);
                    }
                }
            }
        }
        Ok(Observability { variables, codistribution: differentials, functions, bindings })
    }
}
