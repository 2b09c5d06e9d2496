//! What the integrator needs to know of a piecewise-smooth system.

/// A piecewise-smooth system `x' = f(t, x, s)` with `s_i ∈ Sgn(σ_i(t, x))`, set-valued where `σ_i = 0` (Filippov).
///
/// `f` must be smooth in `t`, `x` and `s` on every segment between two breaks: the signs are *arguments*, so the
/// integrator holds them at ±1 while `σ_i ≠ 0` and solves for them where `σ_i` stays zero. Methods take `&mut self`
/// so that compiled models can own their scratch memory.
pub trait Switched {
    /// Number of states, `n`.
    fn dim(&self) -> usize;

    /// Number of switching functions, `k`.
    fn switches(&self) -> usize;

    /// Writes `f(t, x, s)` into `dx` (`n`), for signs `s` (`k`).
    fn rhs(&mut self, t: f64, x: &[f64], s: &[f64], dx: &mut [f64]);

    /// Writes the switching functions `σ(t, x)` into `sigma` (`k`).
    fn switching(&mut self, t: f64, x: &[f64], sigma: &mut [f64]);

    /// Writes `∂σ_i/∂x_j` into `gradient[i * n + j]` and `∂σ_i/∂t` into `partial_t[i]`.
    fn switching_gradient(&mut self, t: f64, x: &[f64], gradient: &mut [f64], partial_t: &mut [f64]);

    /// Whether `s_i` may take any value in `[−1, 1]` where `σ_i = 0`. Not so for `|σ_i|` written as `s_i σ_i`, whose
    /// surface is merely crossed.
    fn sticks(&self, switch: usize) -> bool {
        let _ = switch;
        true
    }

    /// Makes the smooth segment that begins at `t` the current one and returns the time at which it ends.
    ///
    /// Until the next call the other methods evaluate this segment's formulas, also at its end, so that jumps of
    /// inputs are met only between steps. The end must lie after `t`; infinity (the default) means no break.
    fn enter_segment(&mut self, t: f64) -> f64 {
        let _ = t;
        f64::INFINITY
    }
}

/// A [`Switched`] system made of closures.
///
/// ```
/// use bracketry_sim::{simulate, Closures, Settings};
/// // A block slides to rest under dry friction: v' = -μ g sgn(v).
/// let block = Closures {
///     dim: 2,
///     switches: 1,
///     rhs: |_t, x: &[f64], s: &[f64], dx: &mut [f64]| {
///         dx[0] = x[1];
///         dx[1] = -0.3 * 9.81 * s[0];
///     },
///     switching: |_t, x: &[f64], sigma: &mut [f64]| sigma[0] = x[1],
///     gradient: |_t, _x: &[f64], g: &mut [f64], _dt: &mut [f64]| g[1] = 1.0,
/// };
/// let run = simulate(block, 0.0, &[0.0, 1.0], 2.0, &Settings::default()).unwrap();
/// let stop = run.trajectory.transitions()[0].t;
/// assert!((stop - 1.0 / (0.3 * 9.81)).abs() < 1e-10);
/// ```
#[derive(Debug, Clone)]
pub struct Closures<F, S, G> {
    /// Number of states.
    pub dim: usize,
    /// Number of switching functions.
    pub switches: usize,
    /// `(t, x, s, dx)`: the right-hand side.
    pub rhs: F,
    /// `(t, x, sigma)`: the switching functions.
    pub switching: S,
    /// `(t, x, gradient, partial_t)`: their derivatives; both slices arrive zeroed.
    pub gradient: G,
}

impl<F, S, G> Switched for Closures<F, S, G>
where
    F: FnMut(f64, &[f64], &[f64], &mut [f64]),
    S: FnMut(f64, &[f64], &mut [f64]),
    G: FnMut(f64, &[f64], &mut [f64], &mut [f64]),
{
    fn dim(&self) -> usize {
        self.dim
    }

    fn switches(&self) -> usize {
        self.switches
    }

    fn rhs(&mut self, t: f64, x: &[f64], s: &[f64], dx: &mut [f64]) {
        (self.rhs)(t, x, s, dx);
    }

    fn switching(&mut self, t: f64, x: &[f64], sigma: &mut [f64]) {
        (self.switching)(t, x, sigma);
    }

    fn switching_gradient(&mut self, t: f64, x: &[f64], gradient: &mut [f64], partial_t: &mut [f64]) {
        gradient.fill(0.0);
        partial_t.fill(0.0);
        (self.gradient)(t, x, gradient, partial_t);
    }
}
