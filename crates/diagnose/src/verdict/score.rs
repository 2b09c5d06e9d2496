//! What candidates would gain, from the linearized problem.

use bracketry_numerics::eigen::symmetric_eigen;
use nalgebra::{DMatrix, DVector};

use crate::{Column, Linearization, Normal};

/// Share of a column's response that must be left after the refitted parameters have taken what they can: the square of the
/// sine of its angle to them. Below, it is the rounding of finite differences.
const LEAST_ANGLE: f64 = 1e-7;

/// A candidate at one trial value of its shapes: the columns of its amplitudes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Group {
    /// Place among the candidates.
    pub(crate) candidate: usize,
    /// Which trial.
    pub(crate) trial: usize,
    /// Places among the candidates' columns of the [`Scores`].
    pub(crate) columns: Vec<usize>,
    /// By column, the coefficient of the effect that it belongs to.
    pub(crate) coefficients: Vec<usize>,
}

/// What a set of columns would gain.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Gained {
    /// Decrease of the sum of squares.
    pub(crate) square: f64,
    /// The step in units of the linearization's scales, per column.
    pub(crate) step: DVector<f64>,
}

/// The candidates' normal equations after the fitted columns have been eliminated.
///
/// The fitted columns (parameters of the model, coefficients of effects in the fit) follow every step of a candidate at
/// their best: with `A = G_CB G_BB⁻¹` over all windows, a window's gradient is `h = g_C − A g_B` and its matrix
/// `H = [−A I] G [−A I]ᵀ`.
pub(crate) struct Scores {
    /// Candidates at their trials.
    pub(crate) groups: Vec<Group>,
    /// Places of the candidates' columns in the linearization.
    pub(crate) columns: Vec<usize>,
    /// Sum over windows.
    pub(crate) gram: DMatrix<f64>,
    /// Sum over windows.
    pub(crate) gradient: DVector<f64>,
    /// Per window: the diagonal of the matrix, and the gradient.
    windows: Vec<(DVector<f64>, DVector<f64>)>,
    /// Whether the data can tell the column from the fitted ones.
    identifiable: Vec<bool>,
}

/// The normal equations of windows, added up, with what is read of each window by itself.
#[derive(Default)]
pub(crate) struct Sums {
    /// Places of the fitted columns and of those of candidates.
    base: Vec<usize>,
    columns: Vec<usize>,
    gram: DMatrix<f64>,
    windows: Vec<OfWindow>,
}

/// What is read of one window.
struct OfWindow {
    /// `G_BB`, `G_CB` and the diagonal of `G_CC`.
    base: DMatrix<f64>,
    cross: DMatrix<f64>,
    own: DVector<f64>,
    /// `g_B` and `g_C`.
    base_gradient: DVector<f64>,
    gradient: DVector<f64>,
}

impl Sums {
    /// Adds a window.
    pub(crate) fn add(&mut self, all: &[Column], normal: &Normal) {
        if self.windows.is_empty() {
            let is_candidate = |&i: &usize| matches!(all[i], Column::Candidate { .. });
            (self.columns, self.base) = (0..all.len()).partition(is_candidate);
            self.gram = DMatrix::zeros(all.len(), all.len());
        }
        let (base, columns) = (&self.base, &self.columns);
        self.windows.push(OfWindow {
            base: pick(&normal.gram, base, base),
            cross: pick(&normal.gram, columns, base),
            own: DVector::from_iterator(columns.len(), columns.iter().map(|&c| normal.gram[(c, c)])),
            base_gradient: pick_vector(&normal.gradient, base),
            gradient: pick_vector(&normal.gradient, columns),
        });
        self.gram += &normal.gram;
    }

    /// The scores, with the columns and priors of `linearization`.
    pub(crate) fn scores(self, linearization: &Linearization) -> Scores {
        let Self { base, columns, gram: all, windows } = self;
        let (nb, nc) = (base.len(), columns.len());
        let cross = pick(&all, &columns, &base);
        let mut of_base = pick(&all, &base, &base);
        for (i, &b) in base.iter().enumerate() {
            of_base[(i, i)] += linearization.prior[b];
        }
        let follow = solve_all(&of_base, &cross.transpose()).transpose();
        let back = &cross * follow.transpose();
        let gram = pick(&all, &columns, &columns) - &back - back.transpose() + &follow * &of_base * follow.transpose();
        let pull = DVector::from_iterator(nb, base.iter().map(|&b| linearization.prior[b] * linearization.pull[b]));
        let mut gradient = -(&follow * pull);
        let windows: Vec<_> = windows
            .into_iter()
            .map(|window| {
                let own = window.gradient - &follow * window.base_gradient;
                gradient += &own;
                // The diagonal of H: A (A G_BB − 2 G_CB)ᵀ beside that of G_CC.
                let moved = &follow * window.base - 2.0 * window.cross;
                (window.own + DVector::from_fn(nc, |c, _| follow.row(c).dot(&moved.row(c))), own)
            })
            .collect();
        let identifiable = (0..nc)
            .map(|c| all[(columns[c], columns[c])])
            .enumerate()
            .map(|(c, own)| own > 0.0 && own.is_finite() && gram[(c, c)] > LEAST_ANGLE * own)
            .collect();
        Scores { groups: groups(&linearization.columns, &columns), columns, gram, gradient, windows, identifiable }
    }
}

impl Scores {
    /// Of windows that a linearization holds.
    #[cfg(test)]
    pub(crate) fn new(linearization: &Linearization) -> Self {
        let mut sums = Sums::default();
        linearization.windows.iter().for_each(|normal| sums.add(&linearization.columns, normal));
        sums.scores(linearization)
    }

    /// Number of windows.
    pub(crate) fn window_count(&self) -> usize {
        self.windows.len()
    }

    /// Whether the data can tell a column from the fitted ones.
    pub(crate) fn identifiable(&self, column: usize) -> bool {
        self.identifiable[column]
    }

    /// Best step of `columns` together and what it gains.
    pub(crate) fn gain(&self, columns: &[usize]) -> Gained {
        let kept: Vec<usize> = (0..columns.len()).filter(|&i| self.identifiable[columns[i]]).collect();
        let mut step = DVector::zeros(columns.len());
        let inner: Vec<usize> = kept.iter().map(|&i| columns[i]).collect();
        let gradient = pick_vector(&self.gradient, &inner);
        let solved = solve(&pick(&self.gram, &inner, &inner), &gradient);
        for (i, &k) in kept.iter().enumerate() {
            step[k] = solved[i];
        }
        Gained { square: gradient.dot(&solved), step }
    }

    /// As [`Self::gain`], with the sign of each step as `signs` want it (0: any). Columns whose best step has the wrong sign
    /// stay at zero, beginning with the one that matters least.
    pub(crate) fn gain_with_signs(&self, columns: &[usize], signs: &[i8]) -> Gained {
        let mut active: Vec<usize> = (0..columns.len()).collect();
        loop {
            let inner: Vec<usize> = active.iter().map(|&i| columns[i]).collect();
            let gained = self.gain(&inner);
            let wrong = active
                .iter()
                .enumerate()
                .filter(|&(place, &i)| f64::from(signs[i]) * gained.step[place] < 0.0)
                .min_by(|a, b| {
                    let size =
                        |place: usize, i: usize| gained.step[place].powi(2) * self.gram[(columns[i], columns[i])];
                    size(a.0, *a.1).total_cmp(&size(b.0, *b.1))
                })
                .map(|(place, _)| place);
            let Some(wrong) = wrong else {
                let mut step = DVector::zeros(columns.len());
                for (place, &i) in active.iter().enumerate() {
                    step[i] = gained.step[place];
                }
                return Gained { square: gained.square, step };
            };
            active.remove(wrong);
        }
    }

    /// How much more the windows' gradients scatter than white noise of variance `phi` would let them, over all candidates:
    /// 1 for white noise, more where the residual is correlated or depends on the motion. Also the number of
    /// independent directions among the candidates' columns.
    ///
    /// Each column's own best step is taken out first, so that an effect that is the same in all windows does not count.
    pub(crate) fn inflation(&self, phi: f64) -> (f64, f64) {
        let windows = self.windows.len() as f64;
        let used: Vec<usize> = (0..self.columns.len()).filter(|&c| self.identifiable[c]).collect();
        if used.is_empty() || windows < 2.0 {
            return (1.0, 1.0);
        }
        let mut sum = 0.0;
        for &c in &used {
            let step = self.gradient[c] / self.gram[(c, c)];
            let scatter: f64 = self.windows.iter().map(|(h, g)| (g[c] - h[c] * step).powi(2)).sum();
            sum += scatter / self.gram[(c, c)] * windows / (windows - 1.0);
        }
        let mut correlation_square = 0.0;
        for &a in &used {
            for &b in &used {
                correlation_square += self.gram[(a, b)].powi(2) / (self.gram[(a, a)] * self.gram[(b, b)]);
            }
        }
        let independent = (used.len() as f64).powi(2) / correlation_square;
        (sum / used.len() as f64 / phi, independent.max(1.0))
    }
}

/// Candidates' columns by candidate and trial.
fn groups(all: &[Column], columns: &[usize]) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    for (place, &c) in columns.iter().enumerate() {
        let Column::Candidate { candidate, coefficient, trial } = all[c] else { continue };
        match groups.iter_mut().find(|g| g.candidate == candidate && g.trial == trial) {
            Some(group) => {
                group.columns.push(place);
                group.coefficients.push(coefficient);
            }
            None => {
                groups.push(Group { candidate, trial, columns: vec![place], coefficients: vec![coefficient] });
            }
        }
    }
    groups
}

fn pick(matrix: &DMatrix<f64>, rows: &[usize], columns: &[usize]) -> DMatrix<f64> {
    DMatrix::from_fn(rows.len(), columns.len(), |i, j| matrix[(rows[i], columns[j])])
}

fn pick_vector(vector: &DVector<f64>, rows: &[usize]) -> DVector<f64> {
    DVector::from_iterator(rows.len(), rows.iter().map(|&r| vector[r]))
}

/// Solution of a symmetric positive semidefinite system, directions without weight left alone.
fn solve(matrix: &DMatrix<f64>, right: &DVector<f64>) -> DVector<f64> {
    solve_all(matrix, &DMatrix::from_column_slice(right.len(), 1, right.as_slice())).column(0).into_owned()
}

fn solve_all(matrix: &DMatrix<f64>, right: &DMatrix<f64>) -> DMatrix<f64> {
    let n = matrix.nrows();
    if n == 0 {
        return DMatrix::zeros(0, right.ncols());
    }
    // Unit diagonal first: columns have units of their own.
    let size: Vec<f64> = (0..n).map(|i| matrix[(i, i)].max(0.0).sqrt()).collect();
    let inverse = |i: usize| if size[i] > 0.0 { 1.0 / size[i] } else { 0.0 };
    let scaled = DMatrix::from_fn(n, n, |i, j| matrix[(i, j)] * inverse(i) * inverse(j));
    let right = DMatrix::from_fn(n, right.ncols(), |i, j| right[(i, j)] * inverse(i));
    // Of numbers that are none, nothing is known.
    let Some(eigen) = symmetric_eigen(scaled) else { return DMatrix::from_element(n, right.ncols(), f64::NAN) };
    let mut inner = eigen.eigenvectors.transpose() * right;
    for (i, &value) in eigen.eigenvalues.iter().enumerate() {
        let factor = if value > 1e-10 { 1.0 / value } else { 0.0 };
        inner.row_mut(i).scale_mut(factor);
    }
    let solved = &eigen.eigenvectors * inner;
    DMatrix::from_fn(n, solved.ncols(), |i, j| solved[(i, j)] * inverse(i))
}
