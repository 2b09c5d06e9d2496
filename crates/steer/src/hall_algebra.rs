//! The free associative algebra truncated at a degree, with numbers as coefficients: products of flows as series.
//!
//! The flow of x' = Σ vᵢ(t) Xᵢ(x) acts on functions as a series S(t) with S' = S Σ vᵢ Xᵢ; of two flows one after the other, the
//! first stands on the left (Chen 1957; Lafferriere and Sussmann 1991).

use bracketry_lie::algebra::HallBasis;
use bracketry_numerics::least_squares::Factored;
use nalgebra::{DMatrix, DVector};

/// Singular values below this part of the largest are taken for zero.
const RANK: f64 = 1e-12;

/// A series: coefficients of all words in m letters of at most `degree` letters, by length, then as numbers to base m.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Series {
    letters: usize,
    /// One list per length.
    parts: Vec<Vec<f64>>,
}

impl Series {
    pub(crate) fn zero(letters: usize, degree: usize) -> Self {
        Series { letters, parts: (0..=degree).map(|d| vec![0.0; letters.pow(d as u32)]).collect() }
    }

    pub(crate) fn one(letters: usize, degree: usize) -> Self {
        let mut s = Self::zero(letters, degree);
        s.parts[0][0] = 1.0;
        s
    }

    /// exp(a X) for one letter X.
    pub(crate) fn exponential(letters: usize, degree: usize, letter: usize, a: f64) -> Self {
        let mut s = Self::one(letters, degree);
        let (mut word, mut coefficient) = (0, 1.0);
        for d in 1..=degree {
            word = word * letters + letter;
            coefficient *= a / d as f64;
            s.parts[d][word] = coefficient;
        }
        s
    }

    pub(crate) fn product(&self, other: &Series) -> Self {
        let degree = self.parts.len() - 1;
        let mut out = Self::zero(self.letters, degree);
        for (p, a) in self.parts.iter().enumerate() {
            for (q, b) in other.parts.iter().enumerate().take(degree + 1 - p) {
                let target = &mut out.parts[p + q];
                for (i, x) in a.iter().enumerate().filter(|(_, x)| **x != 0.0) {
                    for (j, y) in b.iter().enumerate() {
                        target[i * b.len() + j] += x * y;
                    }
                }
            }
        }
        out
    }

    pub(crate) fn plus(&self, scale: f64, other: &Series) -> Self {
        let mut out = self.clone();
        for (a, b) in out.parts.iter_mut().flatten().zip(other.parts.iter().flatten()) {
            *a += scale * b;
        }
        out
    }

    /// The inverse of a product of exponentials: words backward with signs.
    pub(crate) fn inverse(&self) -> Self {
        let mut out = self.clone();
        for (d, part) in self.parts.iter().enumerate() {
            for (i, x) in part.iter().enumerate() {
                let (mut rest, mut backward) = (i, 0);
                for _ in 0..d {
                    backward = backward * self.letters + rest % self.letters;
                    rest /= self.letters;
                }
                out.parts[d][backward] = if d % 2 == 0 { *x } else { -x };
            }
        }
        out
    }
}

/// The elements of a Hall basis as series, and coordinates in them.
pub(crate) struct HallAlgebra {
    pub(crate) basis: HallBasis,
    pub(crate) letters: usize,
    pub(crate) degree: usize,
    pub(crate) elements: Vec<Series>,
    /// Decompositions of the matrices whose columns are the elements of one length.
    spans: Vec<Factored>,
}

/// A flow of one input field for a time, which is negative for the flow backward.
pub(crate) type Step = (usize, f64);

impl HallAlgebra {
    /// Of the basis of all elements of at most `degree` letters; `None` if it is too large.
    pub(crate) fn new(letters: usize, degree: usize) -> Option<Self> {
        let basis = HallBasis::new(letters, degree).ok()?;
        let mut elements: Vec<Series> = Vec::new();
        for (i, element) in basis.elements().iter().enumerate() {
            elements.push(match element.factors {
                None => {
                    let mut s = Series::zero(letters, degree);
                    s.parts[1][i] = 1.0;
                    s
                }
                Some((a, b)) => {
                    let (ab, ba) = (elements[a].product(&elements[b]), elements[b].product(&elements[a]));
                    ab.plus(-1.0, &ba)
                }
            });
        }
        let mut spans = Vec::new();
        for d in 1..=degree {
            let columns: Vec<DVector<f64>> =
                basis.of_length(d).map(|i| DVector::from_vec(elements[i].parts[d].clone())).collect();
            if columns.is_empty() {
                return None;
            }
            spans.push(Factored::new(&DMatrix::from_columns(&columns), RANK)?);
        }
        Some(HallAlgebra { basis, letters, degree, elements, spans })
    }

    /// Flows of single input fields whose product is S, up to the degree: for each length the elements that are still
    /// missing, as iterated commutators, whose higher-order parts are compensated later.
    pub(crate) fn flows(&self, target: &Series) -> Vec<Step> {
        let mut steps: Vec<Step> = Vec::new();
        let mut so_far = Series::one(self.letters, self.degree);
        for d in 1..=self.degree {
            let rest = so_far.inverse().product(target);
            let part = DVector::from_vec(rest.parts[d].clone());
            let coordinates = self.spans[d - 1].solve(&part, 0.0);
            for (i, &c) in self.basis.of_length(d).zip(coordinates.iter()) {
                // Rounding.
                if c.abs() < 1e-13 {
                    continue;
                }
                let more = self.commutator(i, c);
                for &(letter, a) in &more {
                    so_far = so_far.product(&Series::exponential(self.letters, self.degree, letter, a));
                }
                steps.extend(more);
            }
        }
        merged(steps)
    }

    /// Flows whose product is exp(c B) up to longer brackets, for element B.
    fn commutator(&self, element: usize, c: f64) -> Vec<Step> {
        let Some((a, b)) = self.basis.elements()[element].factors else { return vec![(element, c)] };
        let (p, q) = (self.basis.elements()[a].length() as f64, self.basis.elements()[b].length() as f64);
        let root = |k: f64| c.abs().powf(k / (p + q));
        let first = self.commutator(a, root(p));
        let second = self.commutator(b, c.signum() * root(q));
        let backward = |steps: &[Step]| -> Vec<Step> { steps.iter().rev().map(|&(l, a)| (l, -a)).collect() };
        [first.clone(), second.clone(), backward(&first), backward(&second)].concat()
    }
}

/// Neighboring flows of the same field as one.
fn merged(steps: Vec<Step>) -> Vec<Step> {
    let mut out: Vec<Step> = Vec::new();
    for (letter, a) in steps {
        match out.last_mut() {
            Some(last) if last.0 == letter => last.1 += a,
            _ => out.push((letter, a)),
        }
        if out.last().is_some_and(|last| last.1.abs() < 1e-14) {
            out.pop();
        }
    }
    out
}
