//! Functions of the state that no input influences.

use bracketry_symbolic::{Bindings, Expr, Fp, Func, Node, Pool, Rational, Symbol};

use crate::echelon::Echelon;
use crate::error::Undecided;
use crate::evidence::Evidence;
use crate::fields::{Field, VectorFields, is_plain_zero};
use crate::growth::independent;

/// Independent functions whose evolution no input influences.
#[derive(Clone, Debug)]
pub struct Autonomous {
    /// The functions that were found; their differentials are independent at a generic point.
    pub functions: Vec<Expr>,
    /// How many more exist near a generic point.
    pub missing: usize,
}

/// Seed of the samples that the coefficients are solved from.
const SEED: u64 = 0x6272_6163_6b65_7403;
/// Largest numerator and denominator of a coefficient; 2·bound² < 2^61 makes reconstruction unique.
const BOUND: u64 = 1 << 29;
/// Most products of two atoms in the quadratic ansatz.
const MAX_PRODUCTS: usize = 400;
/// Most trigonometric and other functions of the model in the quadratic ansatz.
const MAX_CALLS: usize = 8;

impl VectorFields {
    /// Functions φ with dφ = 0 along the strong accessibility distribution that `basis` spans:
    /// constant combinations of the states first, then of products of two of the states and
    /// functions (sin, cos, exp, …) in the model.
    ///
    /// By Frobenius' theorem there are exactly n − dim of them near a generic point.
    ///
    /// # Errors
    /// [`Undecided`] if a function in the fields cannot be evaluated exactly.
    pub fn autonomous(
        &self,
        pool: &mut Pool,
        basis: &[Field],
        evidence: &mut Evidence,
    ) -> Result<Autonomous, Undecided> {
        let wanted = self.states.len() - basis.len();
        let mut found = Found { functions: Vec::new(), differentials: Vec::new(), wanted };
        let states: Vec<Expr> = self.states.iter().map(|&s| pool.sym(s)).collect();
        if wanted > 0 {
            self.solve(pool, basis, &states, &mut found, evidence)?;
        }
        if found.functions.len() < wanted {
            let mut atoms = states;
            atoms.extend(self.calls(pool));
            // Products first: pivots are taken from the left, so what remains free, and hence
            // leads each solution, is as simple as possible.
            let mut ansatz = Vec::new();
            for (i, &a) in atoms.iter().enumerate() {
                for &b in &atoms[..=i] {
                    ansatz.push(pool.mul(a, b));
                }
            }
            ansatz.truncate(MAX_PRODUCTS);
            ansatz.reverse();
            ansatz.extend(atoms);
            self.solve(pool, basis, &ansatz, &mut found, evidence)?;
        }
        let missing = wanted - found.functions.len();
        Ok(Autonomous { functions: found.functions, missing })
    }

    /// Functions of the states that occur in the model.
    fn calls(&self, pool: &Pool) -> Vec<Expr> {
        let mut roots = self.controls.concat();
        roots.extend(&self.drift);
        pool.reachable(&roots)
            .into_iter()
            .filter(|&e| match pool.node(e) {
                Node::Call(f, a) => {
                    !matches!(f, Func::Sign | Func::Abs)
                        && pool.symbols_of(&[a]).iter().any(|s| self.states.contains(s))
                }
                _ => false,
            })
            .take(MAX_CALLS)
            .collect()
    }

    /// Adds the constant combinations of `ansatz` that are constant along `basis`.
    fn solve(
        &self,
        pool: &mut Pool,
        basis: &[Field],
        ansatz: &[Expr],
        found: &mut Found,
        evidence: &mut Evidence,
    ) -> Result<(), Undecided> {
        let columns = ansatz.len();
        let rows: Vec<Vec<Expr>> =
            basis.iter().map(|y| ansatz.iter().map(|&a| pool.lie_derivative(a, &self.states, y)).collect()).collect();
        let mut echelon = Echelon::new();
        if !rows.is_empty() {
            // Each point takes a dimension off the combinations that vanish so far, until only
            // those that vanish everywhere are left.
            let points = columns + 1;
            let samples = pool.sample(&rows.concat(), &self.bindings, points, SEED)?;
            evidence.add_rank(&samples, columns)?;
            for row in samples.values.iter().flat_map(|v| v.chunks(columns)) {
                echelon.insert(row.to_vec());
            }
        }
        for c in echelon.nullspace(columns) {
            if found.functions.len() == found.wanted {
                break;
            }
            let Some(coefficients) = rational(&c) else { continue };
            let phi = combination(pool, &readable(coefficients), ansatz);
            found.offer(pool, phi, &self.states, &self.bindings, evidence)?;
        }
        Ok(())
    }
}

struct Found {
    functions: Vec<Expr>,
    differentials: Vec<Field>,
    wanted: usize,
}

impl Found {
    /// Keeps `phi` if its differential is independent of those of the functions kept so far.
    fn offer(
        &mut self,
        pool: &mut Pool,
        phi: Expr,
        states: &[Symbol],
        bindings: &Bindings,
        evidence: &mut Evidence,
    ) -> Result<(), Undecided> {
        let d = pool.gradient(phi, states);
        if is_plain_zero(pool, &d) {
            return Ok(());
        }
        let mut all = self.differentials.clone();
        all.push(d);
        if independent(pool, &all, bindings, evidence)?.len() == all.len() {
            self.differentials = all;
            self.functions.push(phi);
        }
        Ok(())
    }
}

fn rational(c: &[Fp]) -> Option<Vec<Rational>> {
    c.iter().map(|x| x.to_rational(BOUND)).collect()
}

/// The same vector with small integers where there are such, else with leading entry 1.
fn readable(c: Vec<Rational>) -> Vec<Rational> {
    let Some(lead) = c.iter().find(|x| **x != Rational::ZERO).cloned() else { return c };
    let unit: Vec<Rational> = c.iter().map(|x| x / &lead).collect();
    let small = (1..=12i64).find_map(|k| {
        let scaled: Vec<Rational> = unit.iter().map(|x| x * Rational::from(k)).collect();
        scaled.iter().all(Rational::is_int).then_some(scaled)
    });
    small.unwrap_or(unit)
}

fn combination(pool: &mut Pool, c: &[Rational], terms: &[Expr]) -> Expr {
    let mut sum = pool.int(0);
    for (c, &t) in c.iter().zip(terms) {
        if *c != Rational::ZERO {
            let c = pool.rational(c.clone());
            let p = pool.mul(c, t);
            sum = pool.add(sum, p);
        }
    }
    sum
}
