//! The forces of sticking switches that do not determine each other: those whose switching functions depend on each other, as `vx`,
//! `vy`, and `|(vx, vy)|` do in friction between that of the axes and that of the plane.
//!
//! What sticks needs `M s = b`, of which only the sum of the forces is determined. They hold if *some* solution has every `s_i` within
//! its bound, `|s_i| ≤ r_i`: if `b` lies in the sum of the intervals and balls. Any other choice, as that of the least norm, would let
//! go too early. This is the *analytic center* of the solutions: the one with the greatest `Σ w_i r_i √(1 − |s_i|²/r_i²)`, so
//! that `s` is smooth in `b` up to where the last solution vanishes. With the multipliers `y` of `M s = b`,
//! `s_i = r_i z_i/√(1 + |z_i|²)`, `z_i = M_iᵀ y/w_i`, and `y` minimizes the convex `Σ w_i r_i √(1 + |z_i|²) − b·y` (Boyd and Vandenberghe
//! 2004, sections 5.1 and 11.2). There is none if and only if a `y` has `b·y > Σ r_i |M_iᵀ y|` (theorem of the alternative); then all
//! bounds are widened by the factor that just lets one in.

use super::surfaces::{divide, norm};
use nalgebra::DMatrix;
use std::ops::Range;

/// What is left of a row of unit length, of which the others explain the rest, that means a row of its own.
const INDEPENDENT: f64 = 1e-10;
/// Most Newton steps. On the boundary of what can be held the iterates grow by half each.
const STEPS: usize = 80;
/// Multipliers above which the curvature along them needs care.
const STEEP: f64 = 100.0;
/// Balance of forces, relative to the sum of all.
const BALANCE: f64 = 1e-14;
/// How precisely the factor of the bounds is known: a part of its excess over 1.
const PART_OF_EXCESS: f64 = 0.1;
/// Excess over 1 that is rounding.
const LEAST_EXCESS: f64 = 1e-12;

/// Components of one switch among those that stick, with its bound `r` and its weight `w`.
#[derive(Debug, Clone)]
struct Group {
    part: Range<usize>,
    bound: f64,
    weight: f64,
}

/// Solver of the shared forces, with its memory.
#[derive(Debug, Clone)]
pub(crate) struct Sharing {
    /// By component of all switches: its switch.
    switch: Vec<usize>,
    /// By switch: how large its argument may become.
    bounds: Vec<f64>,
    groups: Vec<Group>,
    /// Rank of the equations; their rows come first, orthonormal.
    rank: usize,
    y: Vec<f64>,
    trial: Vec<f64>,
    z: Vec<f64>,
    gradient: Vec<f64>,
    hessian: Vec<f64>,
    direction: Vec<f64>,
}

/// The equations `Q s = b` with orthonormal rows, by rows of length `m`.
#[derive(Clone, Copy)]
struct Equations<'a> {
    rows: &'a [f64],
    right: &'a [f64],
    m: usize,
}

/// Whether bounds let a solution in.
enum Bounds {
    Hold,
    /// Not below this factor of the bounds.
    TooNarrow(f64),
}

impl Sharing {
    /// For switches with these components and bounds.
    pub(crate) fn new(parts: &[Range<usize>], bounds: &[f64]) -> Self {
        let switch: Vec<usize> = parts.iter().enumerate().flat_map(|(i, part)| part.clone().map(move |_| i)).collect();
        let k = switch.len();
        let row = || vec![0.0; k];
        Self {
            bounds: bounds.to_vec(),
            groups: Vec::with_capacity(parts.len()),
            rank: 0,
            y: row(),
            trial: row(),
            z: row(),
            gradient: row(),
            hessian: vec![0.0; k * k],
            direction: row(),
            switch,
        }
    }

    /// Solves `M s = b` for the components `sticking`: `matrix` holds the `m × m` entries of `M` by rows, `right` `b`; both are used
    /// up. Rows that depend on others are taken to agree with them, which the caller checks. False if something is not finite.
    pub(crate) fn solve(&mut self, sticking: &[usize], matrix: &mut [f64], right: &mut [f64], s: &mut [f64]) -> bool {
        let m = sticking.len();
        if !matrix.iter().chain(&*right).all(|v| v.is_finite()) {
            return false;
        }
        self.rank = orthonormalize(matrix, right, m);
        let r = self.rank;
        let equations = Equations { rows: &matrix[..r * m], right: &right[..r], m };
        if r < m {
            self.group(sticking, &equations);
            self.widen(&equations, s);
        } else {
            s.fill(0.0);
        }
        // The least change to what the equations say; without redundancy the solution itself.
        for (row, &b) in equations.rows.chunks_exact(m).zip(equations.right) {
            let error = b - dot(row, s);
            s.iter_mut().zip(row).for_each(|(s, q)| *s += error * q);
        }
        s.iter().all(|v| v.is_finite())
    }

    /// The switches among the components that stick. Weighted by their influence, they are loaded evenly.
    fn group(&mut self, sticking: &[usize], equations: &Equations<'_>) {
        self.groups.clear();
        let mut first = 0;
        while first < sticking.len() {
            let switch = self.switch[sticking[first]];
            let count = sticking[first..].iter().take_while(|&&c| self.switch[c] == switch).count();
            let part = first..first + count;
            first = part.end;
            let weight = part.clone().map(|c| equations.column_norm(c)).fold(0.0, f64::max);
            // One that moves nothing takes no part of what the others may resist.
            if weight > 0.0 {
                self.groups.push(Group { part, bound: self.bounds[switch], weight });
            }
        }
    }

    /// The center within the bounds, or within the bounds times a factor that exceeds the least one by part of its excess over 1.
    fn widen(&mut self, equations: &Equations<'_>, s: &mut [f64]) {
        let (mut low, mut high, mut factor) = (1.0f64, f64::INFINITY, 1.0f64);
        self.y.fill(0.0);
        // Each pass narrows the interval of the factor to less than 3/4.
        for _ in 0..120 {
            match self.center(equations, factor) {
                Bounds::Hold => {
                    high = factor;
                    self.signs(factor, s);
                    if factor == 1.0 {
                        return;
                    }
                    low = low.max(self.least_factor(equations));
                }
                Bounds::TooNarrow(least) => {
                    low = low.max(least).max(factor);
                    self.y.fill(0.0);
                }
            }
            if high - low <= (PART_OF_EXCESS * (low - 1.0)).max(LEAST_EXCESS) {
                return;
            }
            factor = if high.is_finite() { low + 0.3 * (high - low) } else { low + (low - 1.0).max(LEAST_EXCESS) };
        }
    }

    /// Minimizes `factor Σ w_i r_i √(1 + |z_i|²) − b·y` from the present `y` by Newton's method.
    fn center(&mut self, equations: &Equations<'_>, factor: f64) -> Bounds {
        let r = self.rank;
        let total: f64 = factor * self.groups.iter().map(|g| g.weight * g.bound).sum::<f64>();
        self.turn(equations);
        for _ in 0..STEPS {
            if dot(&self.y[..r], equations.right) > factor * self.resistance() * (1.0 + 1e-14) {
                return Bounds::TooNarrow(self.least_factor(equations));
            }
            self.differentiate(equations, factor);
            if self.gradient[..r].iter().all(|g| g.abs() <= BALANCE * total)
                || !(self.newton_step(equations) || self.graded_step(equations, factor))
            {
                return Bounds::Hold;
            }
            let slope = dot(&self.gradient[..r], &self.direction[..r]);
            let value = self.value(equations, factor);
            let slack = 4.0 * f64::EPSILON * (factor * self.resistance() + total);
            self.trial[..r].copy_from_slice(&self.y[..r]);
            let mut length = 1.0;
            loop {
                for a in 0..r {
                    self.y[a] = self.trial[a] + length * self.direction[a];
                }
                self.turn(equations);
                if self.value(equations, factor) <= value + 1e-4 * length * slope + slack || length < 1e-9 {
                    break;
                }
                length *= 0.5;
            }
        }
        Bounds::Hold
    }

    /// `z = M_iᵀ y/w_i` for the present `y`.
    fn turn(&mut self, equations: &Equations<'_>) {
        self.z[..equations.m].fill(0.0);
        for (row, &y) in equations.rows.chunks_exact(equations.m).zip(&self.y) {
            self.z.iter_mut().zip(row).for_each(|(z, q)| *z += q * y);
        }
        for group in &self.groups {
            divide(&mut self.z[group.part.clone()], group.weight);
        }
    }

    fn value(&self, equations: &Equations<'_>, factor: f64) -> f64 {
        let root = |g: &Group| g.weight * g.bound * (1.0 + square(&self.z[g.part.clone()])).sqrt();
        factor * self.groups.iter().map(root).sum::<f64>() - dot(&self.y[..self.rank], equations.right)
    }

    /// What the forces can do against the motion `y`: `Σ r_i |M_iᵀ y|`.
    fn resistance(&self) -> f64 {
        self.groups.iter().map(|g| g.weight * g.bound * norm(&self.z[g.part.clone()])).sum()
    }

    /// A factor of the bounds below which none lets a solution in, by the present `y`.
    fn least_factor(&self, equations: &Equations<'_>) -> f64 {
        let resistance = self.resistance();
        if resistance > 0.0 { dot(&self.y[..self.rank], equations.right) / resistance } else { 0.0 }
    }

    fn differentiate(&mut self, equations: &Equations<'_>, factor: f64) {
        let (r, m) = (self.rank, equations.m);
        for (g, b) in self.gradient.iter_mut().zip(equations.right) {
            *g = -b;
        }
        self.hessian[..r * r].fill(0.0);
        for group in &self.groups {
            let z = &self.z[group.part.clone()];
            let root = (1.0 + square(z)).sqrt();
            let scale = factor * group.bound / root;
            let part = |a: usize| &equations.rows[a * m..(a + 1) * m][group.part.clone()];
            for a in 0..r {
                let along = dot(part(a), z);
                self.gradient[a] += scale * along;
                for b in 0..=a {
                    // (1 + |z|²) q_a·q_b − (q_a·z)(q_b·z), where the part along z must not come from a difference.
                    let across = cross(part(a), part(b), z);
                    let entry = scale / (group.weight * root * root) * (dot(part(a), part(b)) + across);
                    self.hessian[a * r + b] += entry;
                }
            }
        }
    }

    /// The direction of Newton's method, by Cholesky's factorization; false where that is not precise.
    fn newton_step(&mut self, equations: &Equations<'_>) -> bool {
        let r = self.rank;
        if self.z[..equations.m].iter().any(|z| z.abs() > STEEP) {
            return false;
        }
        let l = &mut self.hessian;
        for a in 0..r {
            for b in 0..=a {
                let known: f64 = (0..b).map(|c| l[a * r + c] * l[b * r + c]).sum();
                let rest = l[a * r + b] - known;
                if a != b {
                    l[a * r + b] = rest / l[b * r + b];
                } else if rest > 0.0 {
                    l[a * r + a] = rest.sqrt();
                } else {
                    return false;
                }
            }
        }
        let d = &mut self.direction;
        for a in 0..r {
            let known: f64 = (0..a).map(|c| l[a * r + c] * d[c]).sum();
            d[a] = (-self.gradient[a] - known) / l[a * r + a];
        }
        for a in (0..r).rev() {
            let known: f64 = (a + 1..r).map(|c| l[c * r + a] * d[c]).sum();
            d[a] = (d[a] - known) / l[a * r + a];
        }
        d[..r].iter().all(|v| v.is_finite())
    }

    /// The same near the boundary, where the curvature along `z` is too small for sums: by the factorization of the root of the Hessian, whose
    /// rows are graded (Cox and Higham 1998).
    #[cold]
    fn graded_step(&mut self, equations: &Equations<'_>, factor: f64) -> bool {
        let (r, m) = (self.rank, equations.m);
        let mut rows: Vec<Vec<f64>> = Vec::new();
        for group in &self.groups {
            let z = &self.z[group.part.clone()];
            let (size, root) = (norm(z), (1.0 + square(z)).sqrt());
            let scale = (factor * group.bound / (root * group.weight)).sqrt();
            let part = |a: usize| &equations.rows[a * m..(a + 1) * m][group.part.clone()];
            // Across z the curvature is 1/root, along it 1/root³.
            let unit: Vec<f64> = z.iter().map(|z| if size > 0.0 { z / size } else { 0.0 }).collect();
            let along: Vec<f64> = (0..r).map(|a| dot(part(a), &unit)).collect();
            rows.push(along.iter().map(|q| scale / root * q).collect());
            if z.len() > 1 || size == 0.0 {
                for (c, unit) in unit.iter().enumerate() {
                    rows.push((0..r).map(|a| scale * (part(a)[c] - unit * along[a])).collect());
                }
            }
        }
        rows.sort_by(|p, q| norm(q).total_cmp(&norm(p)));
        rows.resize(rows.len().max(r), vec![0.0; r]);
        let graded = DMatrix::from_fn(rows.len(), r, |row, a| rows[row][a]).col_piv_qr();
        let mut step = -DMatrix::from_column_slice(r, 1, &self.gradient[..r]).transpose();
        graded.p().permute_columns(&mut step);
        let mut step = step.transpose();
        let triangle = graded.r();
        if !(triangle.tr_solve_upper_triangular_mut(&mut step) && triangle.solve_upper_triangular_mut(&mut step)) {
            return false;
        }
        let mut step = step.transpose();
        graded.p().inv_permute_columns(&mut step);
        self.direction[..r].copy_from_slice(step.as_slice());
        step.iter().all(|v| v.is_finite())
    }

    /// `s_i = factor r_i z_i/√(1 + |z_i|²)`.
    fn signs(&self, factor: f64, s: &mut [f64]) {
        s.fill(0.0);
        for group in &self.groups {
            let z = &self.z[group.part.clone()];
            let scale = factor * group.bound / (1.0 + square(z)).sqrt();
            s[group.part.clone()].iter_mut().zip(z).for_each(|(s, z)| *s = scale * z);
        }
    }
}

impl Equations<'_> {
    fn column_norm(&self, c: usize) -> f64 {
        self.rows.iter().skip(c).step_by(self.m).map(|q| q * q).sum::<f64>().sqrt()
    }
}

/// Replaces the rows of `m` equations by orthonormal ones with the same solutions, as far as they are independent (Gram–Schmidt, the
/// longest rest first); how many.
fn orthonormalize(matrix: &mut [f64], right: &mut [f64], m: usize) -> usize {
    for (row, b) in matrix.chunks_exact_mut(m).zip(&mut *right) {
        normalize(row, b);
    }
    for rank in 0..m {
        let rest = |a: usize| norm(&matrix[a * m..(a + 1) * m]);
        let Some(pivot) = (rank..m).max_by(|&a, &b| rest(a).total_cmp(&rest(b))) else {
            return rank;
        };
        if rest(pivot) <= INDEPENDENT {
            return rank;
        }
        (0..m).for_each(|c| matrix.swap(rank * m + c, pivot * m + c));
        right.swap(rank, pivot);
        let (known, others) = matrix.split_at_mut(rank * m);
        let (new, others) = others.split_at_mut(m);
        // Once more across what is known: a short rest is not yet.
        normalize(new, &mut right[rank]);
        for (row, a) in known.chunks_exact(m).zip(0..) {
            let b = right[a];
            subtract(new, &mut right[rank], (row, b));
        }
        normalize(new, &mut right[rank]);
        let b = right[rank];
        for (other, right) in others.chunks_exact_mut(m).zip(&mut right[rank + 1..]) {
            subtract(other, right, (new, b));
        }
    }
    m
}

/// Scales an equation to a row of unit length, if it has a length.
fn normalize(row: &mut [f64], right: &mut f64) {
    let size = norm(row);
    if size > 0.0 {
        divide(row, size);
        *right /= size;
    }
}

/// Takes off an equation what another one with a row of unit length says.
fn subtract(row: &mut [f64], right: &mut f64, (unit, b): (&[f64], f64)) {
    let along = dot(row, unit);
    row.iter_mut().zip(unit).for_each(|(q, u)| *q -= along * u);
    *right -= along * b;
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn square(v: &[f64]) -> f64 {
    dot(v, v)
}

/// `|z|² p·q − (p·z)(q·z)`, as the sum of products of minors (Lagrange's identity).
fn cross(p: &[f64], q: &[f64], z: &[f64]) -> f64 {
    let mut sum = 0.0;
    for a in 0..z.len() {
        for b in 0..a {
            sum += (p[a] * z[b] - p[b] * z[a]) * (q[a] * z[b] - q[b] * z[a]);
        }
    }
    sum
}
