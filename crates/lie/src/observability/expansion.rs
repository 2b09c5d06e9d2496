//! Power series in time of functions along a trajectory, with their derivatives by initial values and parameters.
//!
//! At time zero the values come from a random point of a prime field, at which exponentials, sines, and roots keep
//! their relations. Each further coefficient follows from the ones before: products by convolution, quotients from
//! a·(1/a) = 1, and a function b = f(a) from b' = f'(a) a' (Knuth 1998, section 4.7).

use bracketry_symbolic::{Residue, SplitMix64};

use crate::observability::series::{Reg, SeriesProgram, Step};
use crate::undecided::Undecided;

/// Most numbers that the coefficients may take (of 8 bytes each).
const MAX_NUMBERS: usize = 25_000_000;

/// Coefficients of all series so far, at one point.
pub(crate) struct Expansion<'a, const C: u64> {
    program: &'a SeriesProgram,
    /// By step and order.
    values: Vec<Vec<Residue<C>>>,
    /// Derivatives by the variables: by step, all of order 0, then all of order 1 …
    slopes: Vec<Vec<Residue<C>>>,
    orders: usize,
    input: SplitMix64,
    /// Field operations so far.
    pub(crate) products: f64,
}

impl<'a, const C: u64> Expansion<'a, C> {
    /// The values at time zero; `sampled` are those of the program's sampled expressions. Inputs follow from `seed`.
    ///
    /// # Errors
    /// [`bracketry_symbolic::Undecided::DivisionByZero`] if the point has no values.
    pub(crate) fn start(program: &'a SeriesProgram, sampled: &[Residue<C>], seed: u64) -> Result<Self, Undecided> {
        let d = program.directions;
        let steps = program.steps.len();
        let (values, slopes) = (vec![Vec::new(); steps], vec![Vec::new(); steps]);
        let mut e = Expansion { program, values, slopes, orders: 1, input: SplitMix64::new(seed), products: 0.0 };
        for (r, step) in program.steps.iter().enumerate() {
            let value = match step {
                Step::Constant { sample }
                | Step::Parameter { sample, .. }
                | Step::State { sample, .. }
                | Step::Chain { sample, .. } => sampled[*sample],
                Step::Input | Step::Unknown { .. } => Residue::new(e.input.next_u64()),
                Step::Add(a, b) => e.values[*a][0] + e.values[*b][0],
                Step::Mul(a, b) => e.values[*a][0] * e.values[*b][0],
                Step::Inverse(a) => e.values[*a][0].inv().ok_or(bracketry_symbolic::Undecided::DivisionByZero)?,
            };
            e.values[r].push(value);
        }
        for (r, step) in program.steps.iter().enumerate() {
            let mut slope = vec![Residue::ZERO; d];
            match step {
                Step::Constant { .. } | Step::Input | Step::State { direction: None, .. } => {}
                Step::Parameter { direction, .. }
                | Step::State { direction: Some(direction), .. }
                | Step::Unknown { first: direction } => {
                    slope[*direction] = Residue::ONE;
                }
                Step::Add(a, b) => {
                    add_scaled(&mut slope, &e.slopes[*a], Residue::ONE);
                    add_scaled(&mut slope, &e.slopes[*b], Residue::ONE);
                }
                Step::Mul(a, b) => {
                    add_scaled(&mut slope, &e.slopes[*a], e.values[*b][0]);
                    add_scaled(&mut slope, &e.slopes[*b], e.values[*a][0]);
                }
                Step::Inverse(a) => add_scaled(&mut slope, &e.slopes[*a], -(e.values[r][0] * e.values[r][0])),
                Step::Chain { terms, .. } => {
                    for (a, derivative) in terms {
                        add_scaled(&mut slope, &e.slopes[*a], e.values[*derivative][0]);
                    }
                }
            }
            e.slopes[r] = slope;
        }
        Ok(e)
    }

    /// The derivatives by the variables of the latest coefficient of each output.
    pub(crate) fn rows(&self) -> impl Iterator<Item = Vec<Residue<C>>> {
        let d = self.program.directions;
        let from = (self.orders - 1) * d;
        self.program.outputs.iter().map(move |&r| {
            let slopes = &self.slopes[r];
            if slopes.len() > from { slopes[from..from + d].to_vec() } else { vec![Residue::ZERO; d] }
        })
    }

    /// The gradients of the further functions at the point.
    pub(crate) fn gradients(&self) -> impl Iterator<Item = &[Residue<C>]> {
        self.program.functions.iter().map(|&r| &self.slopes[r][..self.program.directions])
    }

    /// Number of coefficients.
    pub(crate) fn orders(&self) -> usize {
        self.orders
    }

    /// One more coefficient; false if that takes too much memory.
    pub(crate) fn extend(&mut self) -> bool {
        let k = self.orders;
        if self.program.numbers(k + 1) > MAX_NUMBERS {
            return false;
        }
        let inverse = Residue::new(k as u64).inv().unwrap_or(Residue::ONE);
        for r in 0..self.program.steps.len() {
            if self.program.still[r] {
                continue;
            }
            let (value, slope) = self.coefficient(r, k, inverse);
            self.values[r].push(value);
            self.slopes[r].extend(slope);
        }
        self.orders += 1;
        true
    }

    /// Coefficient k > 0 of a step and its derivatives, given the ones before; `inverse` is that of k.
    fn coefficient(&mut self, r: Reg, k: usize, inverse: Residue<C>) -> (Residue<C>, Vec<Residue<C>>) {
        let d = self.program.directions;
        let mut slope = vec![Residue::ZERO; d];
        let value = match &self.program.steps[r] {
            Step::Constant { .. } | Step::Parameter { .. } => Residue::ZERO,
            Step::Input => Residue::new(self.input.next_u64()),
            Step::Unknown { first } => {
                // Coefficients beyond the last variable are not asked for.
                if let Some(s) = slope.get_mut(*first + k) {
                    *s = Residue::ONE;
                }
                Residue::new(self.input.next_u64())
            }
            Step::State { state, .. } => {
                // k x_k is coefficient k − 1 of the rate.
                let rate = self.program.rates[*state];
                self.add_slopes(&mut slope, rate, k - 1, inverse);
                self.at(rate, k - 1) * inverse
            }
            Step::Add(a, b) => {
                self.add_slopes(&mut slope, *a, k, Residue::ONE);
                self.add_slopes(&mut slope, *b, k, Residue::ONE);
                self.at(*a, k) + self.at(*b, k)
            }
            Step::Mul(a, b) => {
                let mut sum = Residue::ZERO;
                let (first, last) = self.overlap(*a, *b, k);
                for i in first..=last {
                    let (x, y) = (self.at(*a, i), self.at(*b, k - i));
                    sum += x * y;
                    self.add_slopes(&mut slope, *a, i, y);
                    self.add_slopes(&mut slope, *b, k - i, x);
                }
                self.products += (2 * (last - first + 1) * d) as f64;
                sum
            }
            Step::Inverse(a) => {
                // Σ a_i r_(k−i) = 0
                let lead = -self.at(r, 0);
                let mut sum = Residue::ZERO;
                for i in 1..=k {
                    let (x, y) = (self.at(*a, i), self.at(r, k - i));
                    sum += x * y;
                    self.add_slopes(&mut slope, *a, i, y);
                    self.add_slopes(&mut slope, r, k - i, x);
                }
                let value = lead * sum;
                self.add_slopes(&mut slope, *a, 0, value);
                for s in &mut slope {
                    *s *= lead;
                }
                self.products += (2 * k * d) as f64;
                value
            }
            Step::Chain { terms, .. } => {
                let mut sum = Residue::ZERO;
                for &(a, derivative) in terms {
                    if self.program.still[a] {
                        continue;
                    }
                    for i in 1..=k {
                        let share = Residue::new(i as u64) * inverse;
                        let (x, y) = (share * self.at(a, i), self.at(derivative, k - i));
                        sum += x * y;
                        self.add_slopes(&mut slope, a, i, share * y);
                        self.add_slopes(&mut slope, derivative, k - i, x);
                    }
                    self.products += (2 * k * d) as f64;
                }
                sum
            }
        };
        (value, slope)
    }

    /// The i for which coefficient i of `a` and coefficient k − i of `b` may both differ from zero.
    fn overlap(&self, a: Reg, b: Reg, k: usize) -> (usize, usize) {
        let still = &self.program.still;
        (if still[b] { k } else { 0 }, if still[a] { 0 } else { k })
    }

    /// Coefficient k of a step.
    pub(crate) fn at(&self, r: Reg, k: usize) -> Residue<C> {
        self.values[r].get(k).copied().unwrap_or_default()
    }

    /// slope += c · (derivatives of coefficient k of a step)
    fn add_slopes(&self, slope: &mut [Residue<C>], r: Reg, k: usize, c: Residue<C>) {
        let d = self.program.directions;
        if let Some(s) = self.slopes[r].get(k * d..(k + 1) * d) {
            add_scaled(slope, s, c);
        }
    }
}

fn add_scaled<const C: u64>(sum: &mut [Residue<C>], v: &[Residue<C>], c: Residue<C>) {
    if c.is_zero() {
        return;
    }
    for (s, &x) in sum.iter_mut().zip(v) {
        if !x.is_zero() {
            *s += c * x;
        }
    }
}
