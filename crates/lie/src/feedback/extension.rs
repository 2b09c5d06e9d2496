//! Integrators in front of inputs, until the outputs decouple.

use bracketry_symbolic::{Expr, Pool, Symbol};
use rustc_hash::FxHashMap;

use crate::algebra::field::VectorFields;
use crate::algebra::matrix::{generic_rank, solve};
use crate::algebra::rational::readable::{common_factor, tidy};
use crate::algebra::subsets::subsets;
use crate::budget::check_size;
use crate::evidence::Evidence;
use crate::feedback::relative_degree::RelativeDegree;
use crate::undecided::Undecided;

/// A dynamic feedback after which the outputs have a vector relative degree.
#[derive(Clone, Debug)]
pub struct DynamicExtension {
    /// The extended system; its inputs are `new_inputs`.
    pub fields: VectorFields,
    /// How many integrators each of the given inputs got.
    pub integrators: Vec<usize>,
    /// The states that were added, with their time derivatives as functions of states and new inputs.
    pub added: Vec<(Symbol, Expr)>,
    /// The given inputs as functions of states and new inputs.
    pub inputs: Vec<Expr>,
    /// The inputs of the extended system.
    pub new_inputs: Vec<Symbol>,
    /// Relative degrees of the outputs and decoupling matrix of the extended system.
    pub degrees: RelativeDegree,
}

impl DynamicExtension {
    /// Whether the extended system is linear in the outputs and their derivatives after static
    /// feedback: the relative degrees add up to its dimension. The outputs are then flat.
    pub fn linearizes(&self) -> bool {
        self.degrees.total() == Some(self.fields.states.len())
    }
}

/// How an extension is limited.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ExtensionLimits {
    /// Most integrators together.
    pub integrators: usize,
    /// Most new nodes of the pool.
    pub nodes: usize,
}

impl VectorFields {
    /// The dynamic extension algorithm (Descusse and Moog 1985; Nijmeijer and van der Schaft 1990,
    /// ch. 8) for as many outputs as inputs: while the decoupling matrix is singular, the inputs
    /// of a smallest set of dependent rows get integrators, after a change of inputs where they
    /// are more than the rank of these rows. `inputs` names the inputs.
    ///
    /// `None` if no input reaches an output or the limit is reached; the outputs need not be invertible.
    ///
    /// # Errors
    /// [`Undecided`] if a function cannot be evaluated exactly or grows too large.
    pub fn dynamic_extension(
        &self,
        pool: &mut Pool,
        outputs: &[Expr],
        inputs: &[Symbol],
        limits: ExtensionLimits,
        evidence: &mut Evidence,
    ) -> Result<Option<DynamicExtension>, Undecided> {
        let m = self.controls.len();
        if outputs.len() != m || inputs.len() != m || m == 0 {
            return Ok(None);
        }
        let first = pool.len();
        let degrees = self.relative_degree(pool, outputs, evidence)?;
        let given = inputs.iter().map(|&u| pool.sym(u)).collect();
        let mut now = DynamicExtension {
            fields: self.clone(),
            integrators: vec![0; m],
            added: Vec::new(),
            inputs: given,
            new_inputs: inputs.to_vec(),
            degrees,
        };
        loop {
            if now.degrees.degrees.iter().any(Option::is_none) {
                return Ok(None);
            }
            if now.degrees.is_vector() {
                return Ok(Some(now));
            }
            if now.added.len() >= limits.integrators {
                return Ok(None);
            }
            check_size(pool, first)?;
            if pool.len() > first + limits.nodes {
                return Err(Undecided::TooLarge { nodes: limits.nodes });
            }
            let rows = now.dependent_rows(pool, evidence)?;
            if !now.extend(pool, &rows, evidence)? {
                return Ok(None);
            }
            // What was free of inputs before still is.
            let derivatives = std::mem::take(&mut now.degrees.derivatives);
            now.degrees = now.fields.relative_degree_from(pool, derivatives, evidence)?;
        }
    }
}

impl DynamicExtension {
    /// A smallest set of dependent rows of the decoupling matrix.
    fn dependent_rows(&self, pool: &mut Pool, evidence: &mut Evidence) -> Result<Vec<usize>, Undecided> {
        let a = &self.degrees.decoupling;
        let dependent = |pool: &mut Pool, set: &[usize], evidence: &mut Evidence| {
            let rows: Vec<Vec<Expr>> = set.iter().map(|&i| a[i].clone()).collect();
            Ok::<bool, Undecided>(generic_rank(pool, &rows, &self.fields.bindings, evidence)? < set.len())
        };
        let mut set: Vec<usize> = (0..a.len()).collect();
        for i in (0..a.len()).rev() {
            let without: Vec<usize> = set.iter().copied().filter(|&k| k != i).collect();
            if dependent(pool, &without, evidence)? {
                set = without;
            }
        }
        Ok(set)
    }

    /// A symbol that the system does not use: a number is put behind the name, or else underscores where needed.
    fn fresh(&self, pool: &mut Pool, name: &str, numbered: bool) -> Symbol {
        let mut roots = self.fields.controls.concat();
        roots.extend(self.fields.drift.iter().chain(&self.inputs).chain(self.degrees.derivatives.iter().flatten()));
        let mut taken = pool.symbols_of(&roots);
        taken.extend(self.fields.states.iter().chain(&self.new_inputs));
        let mut k = 1;
        let mut wanted = if numbered { format!("{name}1") } else { name.to_owned() };
        while let Some(s) = pool.find_symbol(&wanted) {
            if !taken.contains(&s) && self.fields.bindings.get(s).is_none() {
                return s;
            }
            k += 1;
            wanted = if numbered { format!("{name}{k}") } else { format!("{wanted}_") };
        }
        pool.symbol(&wanted)
    }

    /// Puts integrators in front of the inputs of these rows; false if that cannot be written out.
    fn extend(&mut self, pool: &mut Pool, rows: &[usize], evidence: &mut Evidence) -> Result<bool, Undecided> {
        let a = &self.degrees.decoupling;
        let m = self.new_inputs.len();
        let present: Vec<usize> = (0..m).filter(|&j| rows.iter().any(|&i| !pool.is_zero(a[i][j]))).collect();
        let rank = rows.len() - 1;
        if present.len() == rank {
            let none = vec![Vec::new(); rank];
            // A factor that all derivatives share belongs to the new state: y' = a(x) z with z = c(x) u.
            let scale = match present.as_slice() {
                &[j] => {
                    let column: Vec<Expr> = rows.iter().map(|&i| a[i][j]).collect();
                    common_factor(pool, &column, &self.fields.states)
                }
                _ => None,
            };
            self.integrate(pool, &present, &[], &none, scale);
            return Ok(true);
        }
        // Combinations of inputs: B⁻¹ A of independent rows, with pivot columns where that is shortest.
        let top: Vec<Vec<Expr>> = rows[..rank].iter().map(|&i| a[i].clone()).collect();
        let mut best: Option<(u64, Vec<usize>, Vec<Vec<Expr>>)> = None;
        for places in subsets(present.len(), rank) {
            let pivots: Vec<usize> = places.into_iter().map(|k| present[k]).collect();
            let b: Vec<Vec<Expr>> = top.iter().map(|row| pivots.iter().map(|&j| row[j]).collect()).collect();
            if generic_rank(pool, &b, &self.fields.bindings, evidence)? < rank {
                continue;
            }
            let others: Vec<usize> = present.iter().copied().filter(|j| !pivots.contains(j)).collect();
            let mut shares = vec![Vec::new(); rank];
            for &j in &others {
                let column: Vec<Expr> = top.iter().map(|row| row[j]).collect();
                let Some(x) = solve(pool, &b, &column) else { return Ok(false) };
                for (share, x) in shares.iter_mut().zip(x) {
                    share.push(x);
                }
            }
            let length = shares.iter().flatten().fold(0u64, |sum, &x| {
                let size = pool.text_size(x);
                sum.saturating_add(size.length).saturating_add(20 * size.quotients)
            });
            if best.as_ref().is_none_or(|b| length < b.0) {
                best = Some((length, pivots, shares));
            }
        }
        let Some((_, pivots, shares)) = best else { return Ok(false) };
        let others: Vec<usize> = present.iter().copied().filter(|j| !pivots.contains(j)).collect();
        self.integrate(pool, &pivots, &others, &shares, None);
        Ok(true)
    }

    /// New states ζ with `u_p = ζ_p/scale − Σ_j share_pj u_j` for the inputs p in `pivots`, j in
    /// `others`, and ζ_p' the new inputs.
    fn integrate(
        &mut self,
        pool: &mut Pool,
        pivots: &[usize],
        others: &[usize],
        shares: &[Vec<Expr>],
        scale: Option<Expr>,
    ) {
        let zero = pool.int(0);
        let mut values: FxHashMap<Expr, Expr> = FxHashMap::default();
        let old = self.fields.controls.clone();
        for (&p, share) in pivots.iter().zip(shares) {
            let input = self.new_inputs[p];
            let combined = scale.is_some() || share.iter().any(|&x| !pool.is_zero(x));
            let state = if combined { self.fresh(pool, "z", true) } else { input };
            let z = pool.sym(state);
            let z = scale.map_or(z, |c| pool.div(z, c));
            let mut value = z;
            for (&j, &x) in others.iter().zip(share) {
                let u = pool.sym(self.new_inputs[j]);
                let term = pool.mul(x, u);
                value = pool.sub(value, term);
                for (g, &h) in self.fields.controls[j].iter_mut().zip(&old[p]) {
                    let term = pool.mul(x, h);
                    let e = pool.sub(*g, term);
                    *g = tidy(pool, e);
                }
            }
            if combined {
                let u = pool.sym(input);
                values.insert(u, value);
            }
            for (f, &h) in self.fields.drift.iter_mut().zip(&old[p]) {
                let term = pool.mul(z, h);
                let e = pool.add(*f, term);
                *f = if scale.is_some() { tidy(pool, e) } else { e };
            }
            let rate = format!("{}d", pool.name(state));
            let rate = self.fresh(pool, &rate, false);
            self.new_inputs[p] = rate;
            let derivative = pool.sym(rate);
            self.fields.states.push(state);
            self.added.push((state, derivative));
            self.integrators[p] += 1;
        }
        let n = self.fields.states.len();
        for field in std::iter::once(&mut self.fields.drift).chain(&mut self.fields.controls) {
            field.resize(n, zero);
        }
        for (k, &p) in pivots.iter().enumerate() {
            let mut g = vec![zero; n];
            g[n - pivots.len() + k] = pool.int(1);
            self.fields.controls[p] = g;
        }
        for e in self.inputs.iter_mut().chain(self.added.iter_mut().map(|a| &mut a.1)) {
            let new = pool.substitute(*e, &values);
            *e = if new == *e { new } else { tidy(pool, new) };
        }
    }
}
