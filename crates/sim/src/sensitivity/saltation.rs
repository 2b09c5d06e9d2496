//! How sensitivities jump with the field.

/// The saltation matrix `I + (f⁺ − f⁻) ∇σᵀ/σ̇⁻` of an event: it transfers a small change of the state across it.
///
/// The event is a sliding switch that reaches `σ = 0` at the rate `σ̇⁻`, where the field jumps from `f⁻` to `f⁺`. A changed
/// state meets it earlier or later by `∂τ = −∇σ·δx/σ̇⁻` (Leine and Nijmeijer 2004, ch. 7). Where a switch breaks loose the field
/// does not jump, and the matrix is the identity. The vectors have `n` entries, one per state; nothing is allocated.
///
/// ```
/// use bracketry_sim::Saltation;
/// // A block with v' = a − sgn v, a = −0.5, stops (v = 0, v' = −1.5) and sticks: its speed is forgotten.
/// let stop = Saltation { jump: &[0.0, 1.5], gradient: &[0.0, 1.0], rate: -1.5 };
/// let mut sensitivity = [1.0, 0.4, 0.0, 1.0]; // ∂(x, v)/∂(x0, v0), by rows
/// stop.apply(&mut sensitivity);
/// assert_eq!(sensitivity, [1.0, 0.4, 0.0, 0.0]);
/// assert_eq!(stop.matrix(), [1.0, 0.0, 0.0, 0.0]);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Saltation<'a> {
    /// `f⁺ − f⁻`: the field after the change of mode, less that before.
    pub jump: &'a [f64],
    /// `∇σ` at the event; of a unit vector `∇|σ|`.
    pub gradient: &'a [f64],
    /// `σ̇⁻`, the rate at which σ reaches zero. At a rate of 0 the matrix does not exist: its entries are not finite.
    pub rate: f64,
}

impl Saltation<'_> {
    /// Multiplies a sensitivity matrix of `n` rows, stored by rows, from the left.
    pub fn apply(&self, sensitivity: &mut [f64]) {
        let n = self.jump.len();
        let width = sensitivity.len() / n.max(1);
        for c in 0..width {
            let along: f64 = (0..n).map(|j| self.gradient[j] * sensitivity[j * width + c]).sum();
            let earlier = along / self.rate;
            for (j, jump) in self.jump.iter().enumerate().filter(|(_, jump)| **jump != 0.0) {
                sensitivity[j * width + c] += jump * earlier;
            }
        }
    }

    /// The matrix, `n × n` by columns.
    pub fn matrix(&self) -> Vec<f64> {
        let column = |(j, gradient): (usize, &f64)| {
            let factor = gradient / self.rate;
            self.jump.iter().enumerate().map(move |(i, jump)| f64::from(u8::from(i == j)) + jump * factor)
        };
        self.gradient.iter().enumerate().flat_map(column).collect()
    }
}
