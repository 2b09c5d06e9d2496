//! What the integrator needs to know of a piecewise-smooth system.

/// A piecewise-smooth system `x' = f(t, x, s)` with set-valued switches (Filippov): signs `s ∈ Sgn(σ(t, x))`, any value
/// in `[−1, 1]` where `σ = 0`, and unit vectors `s = σ/|σ|` of several components, any value in the unit ball where
/// `σ = 0` (dry friction on a plane).
///
/// `f` must be smooth in `t`, `x` and `s` on every segment between two breaks: the signs and directions are *arguments*, so
/// the integrator sets them while `σ ≠ 0` and solves for them where `σ` stays zero. With `k` components in all, those
/// of one switch follow each other, and the switches each other. Switches may share components of σ. Methods take
/// `&mut self` so that compiled models can own their scratch memory.
pub trait Switched {
    /// Number of states, `n`.
    fn dim(&self) -> usize;

    /// Number of switches.
    fn switches(&self) -> usize;

    /// Number of components of one switch: 1 (the default) for a sign, more for a unit vector.
    fn components(&self, switch: usize) -> usize {
        let _ = switch;
        1
    }

    /// Number of components of all switches, `k`.
    fn arguments(&self) -> usize {
        (0..self.switches()).map(|i| self.components(i)).sum()
    }

    /// Writes `f(t, x, s)` into `dx` (`n`), for signs and directions `s` (`k`).
    fn rhs(&mut self, t: f64, x: &[f64], s: &[f64], dx: &mut [f64]);

    /// If `f` is affine in the signs: writes `f(t, x, s)` into `dx` and `∂f_j/∂s_i` into `by_sign[i * n + j]`. False (the
    /// default) if it is not, or if that is not known; then the signs are solved for by iteration.
    fn affine(&mut self, t: f64, x: &[f64], s: &[f64], dx: &mut [f64], by_sign: &mut [f64]) -> bool {
        let _ = (t, x, s, dx, by_sign);
        false
    }

    /// Writes `∂f_i/∂x_j` for given signs and directions into `jacobian[i * n + j]`, which arrives zeroed, for the steps that stiff
    /// fields need. False (the default) if it is not known; then it is found by differences.
    fn jacobian(&mut self, t: f64, x: &[f64], s: &[f64], jacobian: &mut [f64]) -> bool {
        let _ = (t, x, s, jacobian);
        false
    }

    /// Writes the switching functions `σ(t, x)` into `sigma` (`k`).
    fn switching(&mut self, t: f64, x: &[f64], sigma: &mut [f64]);

    /// Writes `∂σ_i/∂x_j` into `gradient[i * n + j]` and `∂σ_i/∂t` into `partial_t[i]` for every component `i`.
    fn switching_gradient(&mut self, t: f64, x: &[f64], gradient: &mut [f64], partial_t: &mut [f64]);

    /// Whether the sign `switch` may take any value in `[−1, 1]` where its `σ = 0`. Not so for `|σ|` written as `s σ`,
    /// whose surface is merely crossed.
    fn sticks(&self, switch: usize) -> bool {
        let _ = switch;
        true
    }

    /// How large the argument of a sticking switch may become before it breaks loose, at least 1: static over sliding
    /// level of dry friction.
    fn static_ratio(&self, switch: usize) -> f64 {
        let _ = switch;
        1.0
    }

    /// Makes the smooth segment that starts at `t` the current one and returns the time at which it ends.
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
/// use bracketry_sim::{simulate, Closures, SimulationSettings};
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
/// let run = simulate(block, 0.0, &[0.0, 1.0], 2.0, &SimulationSettings::default()).unwrap();
/// let stop = run.trajectory.mode_changes()[0].t;
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

/// A [`Switched`] system whose signs are taken together as unit vectors.
///
/// ```
/// use bracketry_sim::{simulate, Closures, Coupled, SimulationSettings};
/// // A block slides on a plane: v' = -μ g v/|v|, along a straight line, until it stops at |v|/(μ g).
/// let block = Closures {
///     dim: 2,
///     switches: 2,
///     rhs: |_t, _x: &[f64], s: &[f64], dx: &mut [f64]| {
///         dx[0] = -0.3 * 9.81 * s[0];
///         dx[1] = -0.3 * 9.81 * s[1];
///     },
///     switching: |_t, x: &[f64], sigma: &mut [f64]| sigma.copy_from_slice(x),
///     gradient: |_t, _x: &[f64], g: &mut [f64], _dt: &mut [f64]| g.copy_from_slice(&[1.0, 0.0, 0.0, 1.0]),
/// };
/// let run = simulate(Coupled::new(block, vec![2]), 0.0, &[0.3, 0.4], 1.0, &SimulationSettings::default()).unwrap();
/// let stop = run.trajectory.mode_changes()[0];
/// assert!((stop.t - 0.5 / (0.3 * 9.81)).abs() < 1e-10);
/// ```
#[derive(Debug, Clone)]
pub struct Coupled<S> {
    system: S,
    components: Vec<usize>,
    ratios: Vec<f64>,
}

impl<S: Switched> Coupled<S> {
    /// Takes the signs of `system` together, `components[i]` of them as switch `i`, in order. What is left of the signs
    /// stays signs; numbers beyond them count as far as there are signs.
    pub fn new(system: S, components: Vec<usize>) -> Self {
        let mut left = system.switches();
        let mut list: Vec<usize> = Vec::new();
        for wanted in components.into_iter().chain(std::iter::repeat(1)) {
            if left == 0 {
                break;
            }
            let taken = wanted.clamp(1, left);
            left -= taken;
            list.push(taken);
        }
        let ratios = vec![1.0; list.len()];
        Self { system, components: list, ratios }
    }

    /// Gives a switch a static level above its sliding level: `ratio` of them, at least 1. Without effect for a switch that
    /// does not exist.
    #[must_use]
    pub fn with_static_ratio(mut self, switch: usize, ratio: f64) -> Self {
        if let Some(r) = self.ratios.get_mut(switch) {
            *r = ratio.max(1.0);
        }
        self
    }
}

impl<S: Switched> Switched for Coupled<S> {
    fn dim(&self) -> usize {
        self.system.dim()
    }

    fn switches(&self) -> usize {
        self.components.len()
    }

    fn components(&self, switch: usize) -> usize {
        self.components[switch]
    }

    fn rhs(&mut self, t: f64, x: &[f64], s: &[f64], dx: &mut [f64]) {
        self.system.rhs(t, x, s, dx);
    }

    fn jacobian(&mut self, t: f64, x: &[f64], s: &[f64], jacobian: &mut [f64]) -> bool {
        self.system.jacobian(t, x, s, jacobian)
    }

    fn switching(&mut self, t: f64, x: &[f64], sigma: &mut [f64]) {
        self.system.switching(t, x, sigma);
    }

    fn switching_gradient(&mut self, t: f64, x: &[f64], gradient: &mut [f64], partial_t: &mut [f64]) {
        self.system.switching_gradient(t, x, gradient, partial_t);
    }

    fn sticks(&self, switch: usize) -> bool {
        let first: usize = self.components[..switch].iter().sum();
        self.components[switch] > 1 || self.system.sticks(first)
    }

    fn static_ratio(&self, switch: usize) -> f64 {
        self.ratios[switch]
    }

    fn enter_segment(&mut self, t: f64) -> f64 {
        self.system.enter_segment(t)
    }
}
