//! Newton's method on the smoothed problem, and the two ends that smoothing cannot reach: rest and pivoting.

use super::points::{FrictionPoints, LANES};
use super::small::{Basis, cholesky, dot, solve, sum, times};
use super::statics::{Statics, statics};

/// Newton steps of one level of smoothing, and of the problem without smoothing.
const LEVEL_STEPS: usize = 20;
/// Decrement (velocity in units of `|v*|`, squared) at which Newton's method has converged.
const CONVERGED: f64 = 1e-28;
/// Least smoothing, in units of the largest slip speed.
const LEAST_SMOOTHING: f64 = 1e-13;

/// What a step cannot be computed from.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ContactError {
    /// The mass matrix is not symmetric positive definite and finite.
    #[error("the mass matrix must be symmetric, positive definite, and finite")]
    Mass,
    /// The velocity without friction is not finite.
    #[error("the velocity without friction has the entry {value}; it must be finite")]
    Velocity {
        /// The entry.
        value: f64,
    },
    /// A point has rows that are not finite, or a bound that is negative or not finite.
    #[error("contact point {index}: rows and bound must be finite and the bound not negative; its bound is {bound}")]
    Point {
        /// Index of the point.
        index: usize,
        /// Its bound.
        bound: f64,
    },
}

/// How the body moves at the end of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Slip {
    /// Friction holds it: the velocity is zero exactly.
    Held,
    /// It moves about points that do not slip, as many as counted.
    Pivoting {
        /// Points at rest.
        points: usize,
    },
    /// Every point with friction slips.
    Sliding,
}

/// One implicit step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactStep<const N: usize> {
    /// Velocity at the end of the step.
    pub velocity: [f64; N],
    /// Impulse of friction in the velocity coordinates, `−Σ J_iᵀ λ_i = M (v − v*)`.
    pub impulse: [f64; N],
    /// Which points slip.
    pub slip: Slip,
    /// Duality gap: primal less dual value at the returned velocity and multipliers. The velocity differs from the exact
    /// one by at most `sqrt(2 gap)` in the norm of `M`.
    pub gap: f64,
    /// Error of the impulse balance, `|M (v − v*) + Σ J_iᵀ λ_i|` in the norm of `M⁻¹`.
    pub residual: f64,
    /// Newton steps.
    pub iterations: usize,
}

/// Solves steps of [`FrictionPoints`]; keeps its memory between them.
#[derive(Debug, Clone, Default)]
pub struct FrictionSolver<const N: usize> {
    /// The points in coordinates in which `M` has the diagonal 1 and `v*` the length 1.
    points: FrictionPoints<N>,
    /// The same with the bounds of the points that pivot, or of all others, set to zero.
    slipping: FrictionPoints<N>,
    resting: FrictionPoints<N>,
    multipliers: Vec<[f64; 2]>,
    iterations: usize,
}

/// The problem in scaled coordinates.
#[derive(Clone, Copy)]
struct Scaled<const N: usize> {
    mass: [[f64; N]; N],
    free: [f64; N],
    factor: [[f64; N]; N],
}

/// A solution in scaled coordinates: velocity, and `y` for the multipliers of the points at rest.
struct Solution<const N: usize> {
    velocity: [f64; N],
    slip: Slip,
    /// Smoothing of the multipliers of the points that slip.
    eps: f64,
    rest: Option<[f64; N]>,
}

impl<const N: usize> FrictionSolver<N> {
    /// A solver without memory yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// The step from the velocity `free` that the other forces alone would give; `guess` is a velocity near the result, such
    /// as the one of the step before.
    ///
    /// # Errors
    /// [`ContactError`] for a mass, velocity or point without meaning.
    ///
    /// ```
    /// use bracketry_sim::{FrictionPoints, FrictionSolver};
    /// // A point mass of 2 kg that friction slows by at most 1 N s.
    /// let mut points = FrictionPoints::new();
    /// points.push([[1.0, 0.0], [0.0, 1.0]], 1.0);
    /// let mut solver = FrictionSolver::new();
    /// let mass = [[2.0, 0.0], [0.0, 2.0]];
    /// let step = solver.step(&mass, &[3.0, 4.0], &points, &[3.0, 4.0]).unwrap();
    /// assert!((step.velocity[0] - 2.7).abs() < 1e-14 && (step.velocity[1] - 3.6).abs() < 1e-14);
    /// assert_eq!(solver.step(&mass, &[0.3, 0.4], &points, &[0.0; 2]).unwrap().velocity, [0.0, 0.0]);
    /// ```
    pub fn step(
        &mut self,
        mass: &[[f64; N]; N],
        free: &[f64; N],
        points: &FrictionPoints<N>,
        guess: &[f64; N],
    ) -> Result<ContactStep<N>, ContactError> {
        if let Some(value) = free.iter().find(|v| !v.is_finite()) {
            return Err(ContactError::Velocity { value: *value });
        }
        if let Some(index) = points.invalid() {
            return Err(ContactError::Point { index, bound: points.bound(index) });
        }
        let units = check_mass(mass)?;
        // v = size · units · z.
        let stretched: [f64; N] = std::array::from_fn(|i| free[i] / units[i]);
        let largest = stretched.iter().fold(0.0f64, |m, z| m.max(z.abs()));
        self.multipliers.clear();
        self.iterations = 0;
        let undisturbed =
            |slip| ContactStep { velocity: *free, impulse: [0.0; N], slip, gap: 0.0, residual: 0.0, iterations: 0 };
        if largest == 0.0 {
            self.multipliers.resize(points.len(), [0.0; 2]);
            return Ok(undisturbed(Slip::Held));
        }
        let size = largest * stretched.iter().map(|z| (z / largest).powi(2)).sum::<f64>().sqrt();
        let mass = std::array::from_fn(|i| std::array::from_fn(|j| mass[i][j] * units[i] * units[j]));
        let scaled =
            Scaled { free: stretched.map(|z| z / size), factor: cholesky(&mass, N).ok_or(ContactError::Mass)?, mass };
        self.scale_points(points, &units, size)?;
        let (fastest, _) = self.points.speeds(&scaled.free);
        if fastest == 0.0 {
            self.multipliers.resize(points.len(), [0.0; 2]);
            return Ok(undisturbed(Slip::Sliding));
        }
        let guess = std::array::from_fn(|i| {
            let z = guess[i] / units[i] / size;
            if z.is_finite() { z } else { 0.0 }
        });
        let solution = self.solve(&scaled, &guess, fastest);
        let (gap, residual) = self.certify(&scaled, &solution);
        self.store_multipliers(&solution, size);
        let velocity = std::array::from_fn(|i| size * units[i] * solution.velocity[i]);
        let change = sum(&solution.velocity, -1.0, &scaled.free);
        let impulse = times(&scaled.mass, &change);
        Ok(ContactStep {
            velocity,
            impulse: std::array::from_fn(|i| size * impulse[i] / units[i]),
            slip: solution.slip,
            gap: gap * size * size,
            residual: residual * size,
            iterations: self.iterations,
        })
    }

    /// Multipliers `λ_i` of the last step, the impulses on what the body touches; on the body acts `−λ_i`.
    pub fn multipliers(&self) -> &[[f64; 2]] {
        &self.multipliers
    }

    fn scale_points(&mut self, points: &FrictionPoints<N>, units: &[f64; N], size: f64) -> Result<(), ContactError> {
        self.points.clone_from(points);
        let mut overflow = 0.0;
        for chunk in self.points.chunks_mut() {
            for row in &mut chunk.rows {
                for (entry, unit) in row.iter_mut().zip(units) {
                    for l in 0..LANES {
                        entry[l] *= unit;
                        // 0 as long as all is finite.
                        overflow += 0.0 * entry[l];
                    }
                }
            }
            for bound in &mut chunk.bound {
                // A bound beyond all loads holds as well as any greater one.
                *bound = (*bound / size).min(1e100);
            }
        }
        if overflow == 0.0 {
            return Ok(());
        }
        let index = self.points.invalid().unwrap_or_default();
        Err(ContactError::Point { index, bound: points.bound(index) })
    }

    fn solve(&mut self, scaled: &Scaled<N>, guess: &[f64; N], fastest: f64) -> Solution<N> {
        let load = times(&scaled.mass, &scaled.free);
        // A motion on which the load does more work than friction proves that not everything is held.
        let slips = |z: &[f64; N]| dot(&load, z) > self.points.dissipation(z) * (1.0 + 1e-14);
        let mut start = *guess;
        if !slips(guess) {
            if slips(&scaled.free) {
                start = scaled.free;
            } else {
                let (answer, steps) = statics(&self.points, &load);
                self.iterations += steps;
                match answer {
                    Statics::Held(y) => {
                        return Solution { velocity: [0.0; N], slip: Slip::Held, eps: 0.0, rest: Some(y) };
                    }
                    Statics::Slips(y) => {
                        // The best multiple of the motion found.
                        let gain = dot(&load, &y) - self.points.dissipation(&y);
                        let length = gain / dot(&y, &times(&scaled.mass, &y));
                        start = if length.is_finite() { y.map(|y| length * y) } else { scaled.free };
                    }
                }
            }
        }
        self.slide(scaled, &start, fastest)
    }

    /// The solution that does not rest, from a velocity near it.
    fn slide(&mut self, scaled: &Scaled<N>, start: &[f64; N], fastest: f64) -> Solution<N> {
        let mut z = *start;
        if self.points.speeds(&z).1 > 1e-6 * fastest {
            let (exact, converged) = newton(&self.points, scaled, &z, 0.0, None, &mut self.iterations);
            if converged {
                return Solution { velocity: exact, slip: Slip::Sliding, eps: 0.0, rest: None };
            }
            z = exact;
        }
        let mut eps = 0.03 * fastest;
        loop {
            (z, _) = newton(&self.points, scaled, &z, eps, None, &mut self.iterations);
            let slowest = self.points.speeds(&z).1;
            if slowest > 3.0 * eps {
                let (exact, converged) = newton(&self.points, scaled, &z, 0.0, None, &mut self.iterations);
                if converged {
                    return Solution { velocity: exact, slip: Slip::Sliding, eps: 0.0, rest: None };
                }
            }
            // Points at rest slip by a multiple of eps, all others more and more slowly less.
            let slow = 0.1 * (eps * fastest).sqrt();
            if slowest <= slow
                && let Some(solution) = self.pivot(scaled, &z, slow)
            {
                return solution;
            }
            if eps < LEAST_SMOOTHING * fastest {
                return Solution { velocity: z, slip: Slip::Sliding, eps, rest: None };
            }
            eps *= 0.1;
        }
    }

    /// The solution with the points slower than `slow` at rest, if it is one.
    fn pivot(&mut self, scaled: &Scaled<N>, near: &[f64; N], slow: f64) -> Option<Solution<N>> {
        self.slipping.clone_from(&self.points);
        self.resting.clone_from(&self.points);
        let mut held = Basis::new();
        let mut count = 0;
        for (slipping, resting) in self.slipping.chunks_mut().iter_mut().zip(self.resting.chunks_mut()) {
            let speed = slipping.speed(near);
            for lane in 0..LANES {
                if speed[lane] <= slow && slipping.bound[lane] > 0.0 {
                    slipping.bound[lane] = 0.0;
                    count += 1;
                    for row in &resting.rows {
                        held.add(&row.map(|entry| entry[lane]), 1e-9);
                    }
                } else {
                    resting.bound[lane] = 0.0;
                }
            }
        }
        let free = held.complement();
        let mut start = [0.0; N];
        for vector in free.vectors() {
            start = sum(&start, dot(vector, near), vector);
        }
        let (velocity, converged) =
            newton(&self.slipping, scaled, &start, 0.0, Some(free.vectors()), &mut self.iterations);
        if !converged {
            return None;
        }
        let gradient = self.slipping.smoothed(&velocity, 0.0).gradient;
        let change = sum(&scaled.free, -1.0, &velocity);
        let load = sum(&times(&scaled.mass, &change), -1.0, &gradient);
        let (answer, steps) = statics(&self.resting, &load);
        self.iterations += steps;
        match answer {
            Statics::Held(y) => {
                Some(Solution { velocity, slip: Slip::Pivoting { points: count }, eps: 0.0, rest: Some(y) })
            }
            Statics::Slips(_) => None,
        }
    }

    /// Duality gap and error of the balance, in scaled coordinates.
    fn certify(&mut self, scaled: &Scaled<N>, solution: &Solution<N>) -> (f64, f64) {
        let momentum = times(&scaled.mass, &sum(&solution.velocity, -1.0, &scaled.free));
        let (mut loss, friction) = match (&solution.rest, solution.slip) {
            (Some(y), Slip::Held) => (0.0, self.points.impulse(y, 1.0).1),
            (Some(y), _) => {
                let slipping = self.slipping.impulse(&solution.velocity, 0.0).1;
                (0.0, sum(&slipping, 1.0, &self.resting.impulse(y, 1.0).1))
            }
            (None, _) => self.points.impulse(&solution.velocity, solution.eps),
        };
        if solution.eps == 0.0 {
            loss = 0.0;
        }
        let balance = sum(&momentum, 1.0, &friction);
        let error = dot(&balance, &solve(&scaled.factor, &balance, N)).max(0.0);
        (loss + 0.5 * error, error.sqrt())
    }

    /// Multipliers of a solution, in the units of the caller.
    fn store_multipliers(&mut self, solution: &Solution<N>, size: f64) {
        for index in 0..self.points.len() {
            let resting = match solution.slip {
                Slip::Held => true,
                Slip::Pivoting { .. } => self.resting.bound(index) > 0.0,
                Slip::Sliding => false,
            };
            let (motion, eps) = match solution.rest {
                Some(y) if resting => (y, 1.0),
                _ => (solution.velocity, solution.eps),
            };
            let slip = self.points.slip(index, &motion);
            let norm = (slip[0] * slip[0] + slip[1] * slip[1] + eps * eps).sqrt();
            let factor = if norm > 0.0 { size * self.points.bound(index) / norm } else { 0.0 };
            self.multipliers.push(slip.map(|u| factor * u));
        }
    }
}

/// Checks the mass matrix; the units of velocity in which it has the diagonal 1.
fn check_mass<const N: usize>(mass: &[[f64; N]; N]) -> Result<[f64; N], ContactError> {
    let mut units = [0.0; N];
    for i in 0..N {
        for j in 0..N {
            let size = mass[i][i].sqrt() * mass[j][j].sqrt();
            let symmetric = (mass[i][j] - mass[j][i]).abs() <= 1e-12 * size;
            if !(mass[i][j].is_finite() && mass[i][i] > 0.0 && symmetric) {
                return Err(ContactError::Mass);
            }
        }
        units[i] = 1.0 / mass[i][i].sqrt();
    }
    Ok(units)
}

/// Newton's method with backtracking on `½ (z − z*)ᵀ M (z − z*) + Σ c_i sqrt(|J_i z|² + eps²)`, on the span of `within`
/// if that is given. The last iterate, and whether the method has converged.
fn newton<const N: usize>(
    points: &FrictionPoints<N>,
    scaled: &Scaled<N>,
    start: &[f64; N],
    eps: f64,
    within: Option<&[[f64; N]]>,
    iterations: &mut usize,
) -> ([f64; N], bool) {
    let evaluate = |z: &[f64; N]| {
        let mut all = points.smoothed(z, eps);
        let change = sum(z, -1.0, &scaled.free);
        let momentum = times(&scaled.mass, &change);
        all.value += 0.5 * dot(&change, &momentum);
        all.gradient = sum(&all.gradient, 1.0, &momentum);
        for i in 0..N {
            all.hessian[i] = sum(&all.hessian[i], 1.0, &scaled.mass[i]);
        }
        all
    };
    let mut z = *start;
    let mut here = evaluate(&z);
    let mut before = f64::INFINITY;
    for _ in 0..LEVEL_STEPS {
        *iterations += 1;
        let Some(direction) = direction(&here.gradient, &here.hessian, within) else {
            return (z, false);
        };
        let decrement = -dot(&here.gradient, &direction);
        // At the rounding of the gradient the decrement stops falling.
        if decrement <= CONVERGED || (decrement <= 1e-22 && decrement > 0.25 * before) {
            return (z, true);
        }
        before = decrement;
        let slack = 4.0 * f64::EPSILON * here.value.abs();
        let mut length = 1.0;
        loop {
            let trial = sum(&z, length, &direction);
            let there = evaluate(&trial);
            if there.value <= here.value - 1e-4 * length * decrement + slack {
                (z, here) = (trial, there);
                break;
            }
            length *= 0.5;
            if length < 1e-5 {
                return (z, false);
            }
        }
    }
    (z, false)
}

/// Newton direction `−H⁻¹ g`, on the span of `within` if that is given.
fn direction<const N: usize>(
    gradient: &[f64; N],
    hessian: &[[f64; N]; N],
    within: Option<&[[f64; N]]>,
) -> Option<[f64; N]> {
    let Some(within) = within else {
        return Some(solve(&cholesky(hessian, N)?, gradient, N).map(|d| -d));
    };
    let n = within.len();
    let (mut reduced, mut slope) = ([[0.0; N]; N], [0.0; N]);
    for i in 0..n {
        slope[i] = dot(&within[i], gradient);
        let image = times(hessian, &within[i]);
        for j in 0..n {
            reduced[i][j] = dot(&within[j], &image);
        }
    }
    let coefficients = solve(&cholesky(&reduced, n)?, &slope, n);
    let mut result = [0.0; N];
    for i in 0..n {
        result = sum(&result, -coefficients[i], &within[i]);
    }
    Some(result)
}
