//! Constant combinations of given functions that are constant along given fields.

use bracketry_symbolic::{Bindings, Expr, Pool, Symbol};

use crate::algebra::field::Field;
use crate::residues::{Echelon, Fp, OFFSET};
use crate::undecided::Undecided;

/// Seed of the samples that the coefficients are solved from.
const SEED: u64 = 0x6272_6163_6b65_7403;
/// Points that add no condition before the combinations count as found.
const IDLE_POINTS: usize = 3;

/// One function of an ansatz.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Column {
    /// A product of atoms, by ascending index.
    Product(Vec<usize>),
    /// A function by its index.
    Function(usize),
}

/// The functions whose combinations are tried, with what their derivatives are computed from.
#[derive(Clone, Debug, Default)]
pub(super) struct Ansatz {
    /// What products are made of.
    pub(super) atoms: Vec<Expr>,
    /// Functions of which only the derivative is evaluated.
    pub(super) functions: Vec<Expr>,
    /// Simple ones first: a combination is led by its last column.
    pub(super) columns: Vec<Column>,
}

impl Ansatz {
    /// The expression of a column.
    pub(super) fn expression(&self, pool: &mut Pool, column: usize) -> Expr {
        match &self.columns[column] {
            Column::Function(k) => self.functions[*k],
            Column::Product(atoms) => {
                let mut product = pool.int(1);
                for run in atoms.chunk_by(|a, b| a == b) {
                    let power = pool.powi(self.atoms[run[0]], run.len() as i64);
                    product = pool.mul(product, power);
                }
                product
            }
        }
    }

    /// The ansatz with these columns only.
    pub(super) fn restricted(&self, columns: &[usize]) -> Ansatz {
        let mut small = Ansatz::default();
        for &c in columns {
            let column = match &self.columns[c] {
                Column::Function(k) => {
                    small.functions.push(self.functions[*k]);
                    Column::Function(small.functions.len() - 1)
                }
                Column::Product(atoms) => {
                    let mut product: Vec<usize> = atoms
                        .iter()
                        .map(|&a| {
                            let atom = self.atoms[a];
                            small.atoms.iter().position(|&b| b == atom).unwrap_or_else(|| {
                                small.atoms.push(atom);
                                small.atoms.len() - 1
                            })
                        })
                        .collect();
                    product.sort_unstable();
                    Column::Product(product)
                }
            };
            small.columns.push(column);
        }
        small
    }

    /// Expressions from which [`Self::rows`] computes the derivatives along `directions` fields.
    pub(super) fn roots(&self, pool: &mut Pool, states: &[Symbol], fields: &[Field]) -> Vec<Expr> {
        let mut roots = self.atoms.clone();
        for y in fields {
            for &h in self.atoms.iter().chain(&self.functions) {
                roots.push(pool.lie_derivative(h, states, y));
            }
        }
        roots
    }

    /// The derivatives of all columns, one row per field, from the values of the roots.
    fn rows(&self, values: &[Fp]) -> Vec<Vec<Fp>> {
        let (atoms, derivatives) = values.split_at(self.atoms.len());
        let each = self.atoms.len() + self.functions.len();
        derivatives
            .chunks(each.max(1))
            .map(|d| {
                self.columns
                    .iter()
                    .map(|column| match column {
                        Column::Function(k) => d[self.atoms.len() + k],
                        Column::Product(product) => {
                            let mut total = Fp::ZERO;
                            for (i, &a) in product.iter().enumerate() {
                                let mut term = d[a];
                                for (_, &b) in product.iter().enumerate().filter(|(j, _)| *j != i) {
                                    term *= atoms[b];
                                }
                                total += term;
                            }
                            total
                        }
                    })
                    .collect()
            })
            .collect()
    }

    /// The combinations with derivative zero along the fields behind `roots`, at the values of
    /// the constants in `bindings`.
    pub(super) fn constant_combinations(
        &self,
        pool: &mut Pool,
        roots: &[Expr],
        bindings: &Bindings,
    ) -> Result<Vec<Vec<Fp>>, Undecided> {
        let columns = self.columns.len();
        let mut echelon = Echelon::empty(columns);
        let samples = pool.sample_in::<OFFSET>(roots, bindings, columns + IDLE_POINTS, SEED)?;
        if samples.ambiguous_signs > 0 {
            return Err(bracketry_symbolic::Undecided::Sign.into());
        }
        let mut idle = 0;
        for values in &samples.values {
            let mut fresh = false;
            for row in self.rows(values) {
                fresh |= echelon.insert(row);
            }
            idle = if fresh { 0 } else { idle + 1 };
            if idle == IDLE_POINTS {
                break;
            }
        }
        Ok(echelon.null_space())
    }

    /// The gradients of all columns at one point, then those of `found`, one row each.
    pub(super) fn gradients(
        &self,
        pool: &mut Pool,
        states: &[Symbol],
        bindings: &Bindings,
        found: &[Expr],
    ) -> Result<Vec<Vec<Fp>>, Undecided> {
        let (zero, one) = (pool.int(0), pool.int(1));
        let units: Vec<Field> =
            (0..states.len()).map(|i| (0..states.len()).map(|j| if i == j { one } else { zero }).collect()).collect();
        let mut roots = self.roots(pool, states, &units);
        let own = roots.len();
        for &phi in found {
            roots.extend(pool.gradient(phi, states));
        }
        let samples = pool.sample_in::<OFFSET>(&roots, bindings, 1, SEED ^ 1)?;
        let Some(values) = samples.values.first() else { return Ok(Vec::new()) };
        let by_state = self.rows(&values[..own]);
        let columns = (0..self.columns.len()).map(|c| by_state.iter().map(|row| row[c]).collect());
        Ok(columns.chain(values[own..].chunks(states.len()).map(<[Fp]>::to_vec)).collect())
    }
}
