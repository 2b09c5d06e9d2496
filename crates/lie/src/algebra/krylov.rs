//! Closures under brackets of linear systems.
//!
//! For x' = A x + d + B u with constant A, d, and B, all brackets of the constant input fields vanish, and [f, b] = −A b. So the strong
//! accessibility distribution is the smallest A-invariant subspace that contains the columns of B (Kalman 1960, *On the general theory of
//! control systems*), and the accessibility distribution is spanned by it and the drift. Ranks are those of matrices of numbers, which are
//! taken modulo a prime, one new vector at a time.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use bracketry_symbolic::{Pool, Rational, Residue, Undecided as Exact};

use crate::algebra::closure::Closure;
use crate::algebra::field::{Field, VectorFields};
use crate::algebra::linear_fields::LinearFields;
use crate::algebra::word::Word;
use crate::budget::check_size;
use crate::evidence::Evidence;
use crate::residues::OFFSET;
use crate::undecided::Undecided;

/// Seed of the point at which the drift is taken.
const SEED: u64 = 0x6b72_796c_6f76;

/// Most products of one closure, about half a minute of them.
const MAX_PRODUCTS: f64 = 1e10;

/// From so many states on, linear systems are recognized; with fewer, the general closure is as fast.
pub(crate) const LARGE: usize = 41;

/// The second prime is 2^61 less this.
const OTHER_OFFSET: u64 = 1;

/// A sparse vector: places and entries.
type Sparse<F> = Vec<(usize, F)>;

/// The closures of a linear system.
pub(crate) struct Krylov<'a> {
    fields: &'a VectorFields,
    linear: LinearFields,
}

impl<'a> Krylov<'a> {
    /// None where the fields are not seen to be those of a linear system.
    pub(crate) fn of(pool: &Pool, fields: &'a VectorFields) -> Option<Self> {
        Some(Krylov { fields, linear: LinearFields::of(pool, fields)? })
    }

    /// The same for a large system; none for a small one.
    pub(crate) fn of_large(pool: &Pool, fields: &'a VectorFields) -> Option<Self> {
        (fields.states.len() >= LARGE).then(|| Self::of(pool, fields)).flatten()
    }

    /// The accessibility distribution, with the drift, or the strong one.
    ///
    /// # Errors
    /// [`Undecided`] at a limit.
    pub(crate) fn close(
        &self,
        pool: &mut Pool,
        with_drift: bool,
        evidence: &mut Evidence,
    ) -> Result<Closure, Undecided> {
        let Chosen { growth, vectors } = self.choose(pool, with_drift, evidence)?;
        let mut words: Vec<Word> = Vec::with_capacity(vectors.len());
        for vector in &vectors {
            words.push(match *vector {
                Vector::Drift => Word::Generator(0),
                Vector::Input(k) => Word::Generator(k + 1),
                Vector::Image(of) => Word::bracket(Word::Generator(0), words[of].clone()),
            });
        }
        let n = self.fields.states.len();
        let (zero, one) = (pool.int(0), pool.int(1));
        // Where they span everything, coordinate fields do.
        let unit = |i: usize| -> Field { (0..n).map(|j| if i == j { one } else { zero }).collect() };
        let full = vectors.len() == n;
        let basis = if full { (0..n).map(unit).collect() } else { self.brackets(pool, &vectors)? };
        Ok(Closure { growth, basis, words })
    }

    /// The dimensions of span{ad_f^j g_i, j ≤ k}, and brackets of which the first so many span it.
    ///
    /// # Errors
    /// [`Undecided`] at a limit.
    pub(crate) fn flag(&self, pool: &mut Pool, evidence: &mut Evidence) -> Result<(Vec<usize>, Vec<Field>), Undecided> {
        let Chosen { growth, vectors } = self.choose(pool, false, evidence)?;
        let brackets = self.brackets(pool, &vectors)?;
        Ok((growth, brackets))
    }

    /// The growth of its dimension alone, which takes no more memory than the vectors have entries.
    ///
    /// # Errors
    /// [`Undecided`] at a limit.
    pub(crate) fn growth(
        &self,
        pool: &mut Pool,
        with_drift: bool,
        evidence: &mut Evidence,
    ) -> Result<Vec<usize>, Undecided> {
        Ok(self.choose(pool, with_drift, evidence)?.growth)
    }

    /// Independent vectors modulo one prime; modulo another one too where they are not everything, as a rank may be too small where the
    /// prime divides a minor, and is never too large.
    fn choose(&self, pool: &mut Pool, with_drift: bool, evidence: &mut Evidence) -> Result<Chosen, Undecided> {
        let found = self.choose_modulo::<OFFSET>(pool, with_drift, evidence)?;
        if found.vectors.len() == self.fields.states.len() {
            return Ok(found);
        }
        let other = self.choose_modulo::<OTHER_OFFSET>(pool, with_drift, evidence)?;
        Ok(if other.growth > found.growth { other } else { found })
    }

    fn choose_modulo<const C: u64>(
        &self,
        pool: &mut Pool,
        with_drift: bool,
        evidence: &mut Evidence,
    ) -> Result<Chosen, Undecided> {
        let n = self.fields.states.len();
        let residues = |v: &Sparse<Rational>| -> Result<Sparse<Residue<C>>, Undecided> {
            let residue = |c: &Rational| Residue::from_rational(c).ok_or_else(|| no_residue(c));
            v.iter().map(|(i, c)| Ok((*i, residue(c)?))).collect()
        };
        let columns = self.linear.columns.iter().map(residues).collect::<Result<Vec<_>, _>>()?;
        let mut span = SparseSpan::empty(n);
        let mut vectors = Vec::new();
        if with_drift {
            let drift = pool.sample_in::<C>(&self.fields.drift, &self.fields.bindings, 1, SEED)?;
            let entries = drift.values.iter().flatten().copied().enumerate().filter(|(_, x)| !x.is_zero());
            if span.insert(&entries.collect()) {
                vectors.push(Vector::Drift);
            }
        }
        // Vectors of the last round with their numbers; the drift's own bracket vanishes.
        let mut fresh: Vec<(Sparse<Residue<C>>, usize)> = Vec::new();
        for (k, b) in self.linear.inputs.iter().enumerate() {
            let b = residues(b)?;
            if span.insert(&b) {
                fresh.push((b, vectors.len()));
                vectors.push(Vector::Input(k));
            }
        }
        let mut growth = vec![vectors.len()];
        let mut any = !vectors.is_empty();
        while any && vectors.len() < n {
            let mut next = Vec::new();
            for (v, of) in fresh {
                if let Some(limit) = pool.reached_limit() {
                    return Err(limit.into());
                }
                let image = span.times(&columns, &v);
                if span.insert(&image) {
                    next.push((image, vectors.len()));
                    vectors.push(Vector::Image(of));
                }
                if span.products > MAX_PRODUCTS {
                    return Err(Undecided::TooMany { products: MAX_PRODUCTS });
                }
            }
            fresh = next;
            any = !fresh.is_empty();
            growth.push(vectors.len());
        }
        evidence.add_linear_rank(vectors.len());
        Ok(Chosen { growth, vectors })
    }

    /// The vectors as fields, exactly.
    fn brackets(&self, pool: &mut Pool, vectors: &[Vector]) -> Result<Vec<Field>, Undecided> {
        let (n, zero) = (self.fields.states.len(), pool.int(0));
        let first = pool.len();
        let mut exact: Vec<Sparse<Rational>> = Vec::with_capacity(vectors.len());
        let mut made: Vec<Field> = Vec::with_capacity(vectors.len());
        for vector in vectors {
            exact.push(match *vector {
                Vector::Drift => Vec::new(),
                Vector::Input(k) => self.linear.inputs[k].clone(),
                Vector::Image(of) => negative_image(&self.linear.columns, &exact[of]),
            });
            if matches!(vector, Vector::Drift) {
                made.push(self.fields.drift.clone());
                continue;
            }
            check_size(pool, first)?;
            let mut field = vec![zero; n];
            for (i, c) in exact.iter().last().into_iter().flatten() {
                field[*i] = pool.rational(c.clone());
            }
            made.push(field);
        }
        Ok(made)
    }
}

/// A vector of a closure.
#[derive(Clone, Copy)]
enum Vector {
    /// The drift.
    Drift,
    /// The input field with this number.
    Input(usize),
    /// The bracket of the drift with the vector of this number.
    Image(usize),
}

/// Independent vectors, the first `growth[k]` of them after k rounds of brackets.
struct Chosen {
    growth: Vec<usize>,
    vectors: Vec<Vector>,
}

fn no_residue(c: &Rational) -> Exact {
    Exact::OtherPrime { text: c.to_string(), reason: "its denominator is a multiple of a prime in use" }
}

/// −A v.
fn negative_image(columns: &[Sparse<Rational>], v: &Sparse<Rational>) -> Sparse<Rational> {
    let mut image = std::collections::BTreeMap::new();
    for (j, x) in v {
        for (i, a) in &columns[*j] {
            *image.entry(*i).or_insert(Rational::ZERO) -= a * x;
        }
    }
    image.into_iter().filter(|(_, x)| *x != Rational::ZERO).collect()
}

/// A span of sparse vectors modulo the prime.
struct SparseSpan<const C: u64> {
    /// Rows with 1 at their first place, by that place.
    rows: Vec<Option<Sparse<Residue<C>>>>,
    /// A vector that is worked on: its entries, its places in order, and whether a place is among them.
    work: Vec<Residue<C>>,
    places: BinaryHeap<Reverse<usize>>,
    listed: Vec<bool>,
    /// Products so far.
    products: f64,
}

impl<const C: u64> SparseSpan<C> {
    fn empty(n: usize) -> Self {
        SparseSpan {
            rows: vec![None; n],
            work: vec![Residue::ZERO; n],
            places: BinaryHeap::new(),
            listed: vec![false; n],
            products: 0.0,
        }
    }

    fn add(&mut self, i: usize, x: Residue<C>) {
        self.work[i] += x;
        if !self.listed[i] {
            self.listed[i] = true;
            self.places.push(Reverse(i));
        }
    }

    /// The next place of the vector that is worked on, with its entry; both are taken away.
    fn next(&mut self) -> Option<(usize, Residue<C>)> {
        let Reverse(i) = self.places.pop()?;
        self.listed[i] = false;
        Some((i, std::mem::replace(&mut self.work[i], Residue::ZERO)))
    }

    /// −A v.
    fn times(&mut self, columns: &[Sparse<Residue<C>>], v: &Sparse<Residue<C>>) -> Sparse<Residue<C>> {
        for (j, x) in v {
            for (i, a) in &columns[*j] {
                self.add(*i, -(*a * *x));
            }
            self.products += columns[*j].len() as f64;
        }
        std::iter::from_fn(|| self.next()).filter(|(_, x)| !x.is_zero()).collect()
    }

    /// Adds a vector; false if it is in the span already.
    fn insert(&mut self, v: &Sparse<Residue<C>>) -> bool {
        for (i, x) in v {
            self.add(*i, *x);
        }
        let mut rest: Sparse<Residue<C>> = Vec::new();
        while let Some((i, x)) = self.next() {
            if x.is_zero() {
                continue;
            }
            let Some(row) = self.rows[i].take() else {
                rest.push((i, x));
                continue;
            };
            for (j, y) in &row[1..] {
                self.add(*j, -(x * *y));
            }
            self.products += row.len() as f64;
            self.rows[i] = Some(row);
        }
        let Some((first, lead)) = rest.first().copied() else { return false };
        let scale = lead.inv().unwrap_or(Residue::ONE);
        for (_, x) in &mut rest {
            *x *= scale;
        }
        self.rows[first] = Some(rest);
        true
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use bracketry_symbolic::Bindings;
    use proptest::prelude::*;

    fn entries(most: usize) -> impl Strategy<Value = Vec<i64>> {
        prop::collection::vec(prop_oneof![3 => Just(0i64), 1 => -3i64..4], most)
    }

    proptest! {
        /// Dimensions, brackets, and distributions are those of the general closure.
        #[test]
        fn closures_of_linear_systems_are_those_of_vector_fields(
            n in 1usize..7, a in entries(36), b in entries(12), d in entries(6), m in 0usize..3,
        ) {
            let mut pool = Pool::new();
            let names: Vec<String> = (0..n).map(|i| format!("x{i}")).collect();
            let states = names.iter().map(|name| pool.symbol(name)).collect();
            let gain = pool.symbol("k");
            let rate = |pool: &mut Pool, i: usize| {
                let terms: Vec<String> = (0..n).map(|j| format!("{}/3*k*(x{j} + 1)", a[i * n + j])).collect();
                pool.parse(&format!("{} + {}", terms.join(" + "), d[i])).unwrap()
            };
            let drift: Field = (0..n).map(|i| rate(&mut pool, i)).collect();
            let controls = (0..m).map(|c| (0..n).map(|i| pool.int(b[c * n + i])).collect()).collect();
            let mut bindings = Bindings::new();
            bindings.bind(gain, Rational::from(7));
            let fields = VectorFields::new(states, drift, controls, bindings).unwrap();
            let evidence = &mut Evidence::default();
            for with_drift in [true, false] {
                let linear = Krylov::of(&pool, &fields).unwrap();
                let found = linear.close(&mut pool, with_drift, evidence).unwrap();
                let expected = if with_drift {
                    fields.accessibility(&mut pool, evidence).unwrap()
                } else {
                    fields.strong_accessibility(&mut pool, evidence).unwrap()
                };
                prop_assert_eq!(&found.growth, &expected.growth);
                prop_assert_eq!(&found.words, &expected.words);
                if !with_drift {
                    let (dims, brackets) = linear.flag(&mut pool, evidence).unwrap();
                    let flag = fields.linearization_flag(&mut pool, evidence).unwrap();
                    prop_assert_eq!(&dims, &flag.dims);
                    prop_assert!(flag.involutive.iter().all(|i| *i) && flag.involutive.len() == dims.len());
                    for dim in dims {
                        let rank = pool.rank(&brackets[..dim], &fields.bindings).unwrap().rank;
                        prop_assert!(dim == 0 || rank == dim);
                    }
                }
                let both = [&found.basis[..], &expected.basis].concat();
                if !both.is_empty() {
                    let rank = pool.rank(&both, &fields.bindings).unwrap().rank;
                    prop_assert_eq!((rank, found.basis.len()), (expected.basis.len(), expected.basis.len()));
                }
            }
        }
    }

    #[test]
    fn what_is_not_linear_or_not_known_is_no_linear_system() {
        for (rate, input) in [("x*y", "1"), ("sin(x)", "1"), ("x^2", "1"), ("k*x", "1"), ("pi*x", "1"), ("y", "x")] {
            let mut pool = Pool::new();
            let states = ["x", "y"].map(|s| pool.symbol(s)).to_vec();
            let drift = ["0", rate].map(|e| pool.parse(e).unwrap()).to_vec();
            let control = ["0", input].map(|e| pool.parse(e).unwrap()).to_vec();
            let fields = VectorFields::new(states, drift, vec![control], Bindings::new()).unwrap();
            assert!(Krylov::of(&pool, &fields).is_none(), "{rate} {input}");
        }
    }
}
