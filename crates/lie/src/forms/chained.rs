//! The chained form of two inputs without drift (Murray and Sastry 1993).

use bracketry_symbolic::{Expr, Node, Pool, Symbol};

use crate::algebra::field::{Field, VectorFields, is_plain_zero};
use crate::algebra::involutive::involutive_closure;
use crate::algebra::matrix::{determinant, generic_rank, reduced};
use crate::algebra::rational::readable::{tidy, vanishing_factors};
use crate::algebra::subsets::subsets;
use crate::budget::check_size;
use crate::condition::Condition;
use crate::evidence::Evidence;
use crate::feedback::relative_degree::divisors;
use crate::forms::inversion::inverse;
use crate::undecided::Undecided;

/// Coordinates z = T(x) and inputs v = B(x) u with which x' = g1 u1 + g2 u2 becomes
///
/// z1' = v1, z2' = v2, z3' = z2 v1, …, zn' = z(n−1) v1.
///
/// Every equation was verified exactly. T and B are regular outside of the singular set.
#[derive(Clone, Debug)]
pub struct ChainedForm {
    /// z1 … zn as functions of the states.
    pub coordinates: Vec<Expr>,
    /// B: two rows of two entries, functions of the states.
    pub input_matrix: [[Expr; 2]; 2],
    /// The symbols that stand for z1 … zn in `inverse`.
    pub symbols: Vec<Symbol>,
    /// The states as functions of z1 … zn, one branch where there are several, with T(x(z)) = z verified exactly; `None` if no
    /// closed form was found.
    pub inverse: Option<Vec<Expr>>,
    /// The functions of which at least one vanishes in the singular set; `None` if they are too large to be written out.
    pub singular_factors: Option<Vec<Expr>>,
}

impl ChainedForm {
    /// Where T or B is singular or has no value.
    pub fn singular_set(&self, pool: &Pool) -> Option<Condition> {
        self.singular_factors.as_ref().map(|list| Condition::any_vanishes(pool, list))
    }

    /// The inputs u = B⁻¹ v, for given v.
    pub fn inputs(&self, pool: &mut Pool, v: [Expr; 2]) -> Option<[Expr; 2]> {
        let rows: Vec<Vec<Expr>> = self.input_matrix.iter().map(|row| row.to_vec()).collect();
        let u = crate::algebra::matrix::solve(pool, &rows, &v)?;
        Some([u[0], u[1]])
    }

    /// Shorter and less singular forms first.
    fn rank(&self, pool: &Pool) -> (bool, usize, bool, u64) {
        let factors = self.singular_factors.as_ref();
        let length = self.coordinates.iter().map(|&e| pool.text_size(e).length).fold(0u64, u64::saturating_add);
        (factors.is_none(), factors.map_or(0, Vec::len), self.inverse.is_none(), length)
    }
}

/// Why there is no chained form, or none was found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NoChainedForm {
    /// The chained form is one of two inputs.
    Inputs {
        /// Independent input fields.
        independent: usize,
    },
    /// x' does not vanish with the inputs.
    Drift,
    /// The derived flag E0 = span(g1, g2), E(k+1) = Ek + \[Ek, Ek\] has other dimensions than 2, 3, …, n, so that no
    /// feedback gives a chained form (Murray 1994; Martin and Rouchon 1994).
    DerivedFlag {
        /// Its dimensions at a generic point.
        dimensions: Vec<usize>,
    },
    /// The derived flag admits a chained form near generic points, but its functions were not found in closed form.
    NotFound,
}

/// The chained forms that were found, best first, or why there is none.
#[derive(Clone, Debug)]
pub struct ChainedForms {
    /// Verified forms: fewest singularities first.
    pub forms: Vec<ChainedForm>,
    /// The reason, where there is none.
    pub reason: Option<NoChainedForm>,
}

impl ChainedForms {
    fn none(reason: NoChainedForm) -> Self {
        ChainedForms { forms: Vec::new(), reason: Some(reason) }
    }
}

/// Most pairs of functions from which a form is built.
const MAX_PAIRS: usize = 12;
/// A pair whose form takes more nodes than this is given up.
const MAX_NODES: usize = 60_000;

impl VectorFields {
    /// Chained forms of x' = g1 u1 + g2 u2 near generic points; `known` are functions to try first, such as the outputs of the
    /// model.
    ///
    /// There is one if and only if the derived flag has dimensions 2, 3, …, n. Then z1 and zn are two functions whose differentials
    /// have rank one on E(n−3) (Murray and Sastry 1993, prop. 7; Li and Respondek 2012), and each z(k−1) is dzk/dz1 along the
    /// motion. Functions are sought among `known`, the states, and first integrals.
    ///
    /// # Errors
    /// [`Undecided`] if a function cannot be evaluated exactly or the search is stopped.
    pub fn chained_forms(
        &self,
        pool: &mut Pool,
        known: &[Expr],
        evidence: &mut Evidence,
    ) -> Result<ChainedForms, Undecided> {
        let n = self.states.len();
        for &f in &self.drift {
            if !self.vanishes(pool, f, evidence)? {
                return Ok(ChainedForms::none(NoChainedForm::Drift));
            }
        }
        let independent = generic_rank(pool, &self.controls, &self.bindings, evidence)?;
        if self.controls.len() != 2 || independent != 2 {
            return Ok(ChainedForms::none(NoChainedForm::Inputs { independent }));
        }
        let flag = involutive_closure(pool, &self.states, &self.controls, &self.bindings, evidence)?;
        if flag.growth.iter().copied().ne(2..=n) {
            return Ok(ChainedForms::none(NoChainedForm::DerivedFlag { dimensions: flag.growth }));
        }
        let first = pool.len();
        let pairs = self.chained_pairs(pool, known, &flag.basis, evidence)?;
        let mut forms = Vec::new();
        for pair in pairs {
            let states = pair.iter().all(|&h| known.contains(&h) || matches!(pool.node(h), Node::Sym(_)));
            let turned = charts(pool, pair).into_iter();
            for (h1, h2) in turned.take(if states { 4 } else { 2 }) {
                check_size(pool, first)?;
                let before = pool.len();
                match self.chained_form_of(pool, h1, h2, before, evidence) {
                    Ok(Some(form)) => forms.push(form),
                    Ok(None) | Err(Undecided::TooLarge { .. } | Undecided::Exact(_)) => {}
                    Err(why) => return Err(why),
                }
            }
        }
        forms.sort_by_key(|form: &ChainedForm| form.rank(pool));
        let reason = forms.is_empty().then_some(NoChainedForm::NotFound);
        Ok(ChainedForms { forms, reason })
    }

    /// Pairs of functions whose differentials have rank one on the corank-one distribution of the flag.
    fn chained_pairs(
        &self,
        pool: &mut Pool,
        known: &[Expr],
        flag: &[Field],
        evidence: &mut Evidence,
    ) -> Result<Vec<[Expr; 2]>, Undecided> {
        let n = self.states.len();
        let mut candidates = known.to_vec();
        for &s in &self.states {
            let x = pool.sym(s);
            if !candidates.contains(&x) {
                candidates.push(x);
            }
        }
        if n == 2 {
            return Ok(vec![[candidates[0], candidates[1]]]);
        }
        let (first, corank_one) = (pool.len(), &flag[..n - 1]);
        let mut pairs: Vec<[Expr; 2]> = Vec::new();
        for pair in subsets(candidates.len(), 2) {
            let pair = [candidates[pair[0]], candidates[pair[1]]];
            if self.annihilator_within(pool, &pair, corank_one, evidence)? {
                pairs.push(pair);
            }
        }
        let corank_one = reduced(pool, corank_one, &self.bindings, evidence)?;
        for &h in &candidates {
            if pairs.iter().any(|p| p.contains(&h)) {
                continue;
            }
            match self.completed(pool, h, &corank_one, known, first, evidence) {
                Ok(Some(pair)) => pairs.push([pair[0], pair[1]]),
                Ok(None) | Err(Undecided::TooLarge { .. } | Undecided::Exact(_)) => {}
                Err(why) => return Err(why),
            }
        }
        pairs.truncate(MAX_PAIRS);
        Ok(pairs)
    }

    /// The form with z1 = h1 and zn = h2, if it is one.
    fn chained_form_of(
        &self,
        pool: &mut Pool,
        h1: Expr,
        h2: Expr,
        first: usize,
        evidence: &mut Evidence,
    ) -> Result<Option<ChainedForm>, Undecided> {
        let n = self.states.len();
        let mut along = |pool: &mut Pool, h: Expr| -> Result<[Expr; 2], Undecided> {
            let mut row = [h; 2];
            for (entry, g) in row.iter_mut().zip(&self.controls) {
                let e = pool.lie_derivative(h, &self.states, g);
                *entry = if self.vanishes(pool, e, evidence)? { pool.int(0) } else { tidy(pool, e) };
            }
            Ok(row)
        };
        let a = along(pool, h1)?;
        let Some(pivot) = (0..2).filter(|&i| !pool.is_zero(a[i])).min_by_key(|&i| pool.text_size(a[i]).length) else {
            return Ok(None);
        };
        let mut z = vec![h2];
        // From zn down to z2.
        while z.len() < n - 1 {
            check_size(pool, first)?;
            if pool.len() > first + MAX_NODES {
                return Err(Undecided::TooLarge { nodes: MAX_NODES });
            }
            let d = along(pool, z[z.len() - 1])?;
            let (p, q) = (pool.mul(d[0], a[1]), pool.mul(d[1], a[0]));
            let cross = pool.sub(p, q);
            if !self.vanishes(pool, cross, &mut Evidence::default())? {
                return Ok(None);
            }
            let quotient = pool.div(d[pivot], a[pivot]);
            z.push(tidy(pool, quotient));
        }
        let b = along(pool, z[z.len() - 1])?;
        z.push(h1);
        z.reverse();
        let matrix = [a, b];
        let rows: Vec<Field> = matrix.iter().map(|row| row.to_vec()).collect();
        let jacobian: Vec<Field> = z.iter().map(|&h| pool.gradient(h, &self.states)).collect();
        if generic_rank(pool, &rows, &self.bindings, evidence)? < 2
            || generic_rank(pool, &jacobian, &self.bindings, evidence)? < n
        {
            return Ok(None);
        }
        let singular_factors = self.singularities(pool, &z, &rows, &jacobian);
        let (symbols, inverse) = inverse(pool, &self.states, &z, &self.bindings);
        Ok(Some(ChainedForm { coordinates: z, input_matrix: matrix, symbols, inverse, singular_factors }))
    }

    /// What vanishes where T or B is singular or has no value.
    fn singularities(
        &self,
        pool: &mut Pool,
        coordinates: &[Expr],
        matrix: &[Field],
        jacobian: &[Field],
    ) -> Option<Vec<Expr>> {
        let mut sources = vec![determinant(pool, matrix)?, determinant(pool, jacobian)?];
        sources.extend(divisors(pool, coordinates));
        let mut factors = Vec::new();
        for e in sources {
            for factor in vanishing_factors(pool, e, &self.states, &self.bindings)? {
                if !factors.contains(&factor) {
                    factors.push(factor);
                }
            }
        }
        Some(factors)
    }

    /// Whether the drift is the number zero in every component.
    pub fn is_driftless(&self, pool: &Pool) -> bool {
        is_plain_zero(pool, &self.drift)
    }
}

/// The pair in both orders and turned by 45°, which makes sense for two outputs or states: where one form is singular, another need not be.
fn charts(pool: &mut Pool, [a, b]: [Expr; 2]) -> Vec<(Expr, Expr)> {
    let (sum, difference) = (pool.add(a, b), pool.sub(b, a));
    vec![(a, b), (b, a), (sum, difference), (difference, sum)]
}
