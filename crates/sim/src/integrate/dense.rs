//! Continuous extensions of steps.

use bracketry_numerics::collocation::RADAU_3_NODES;

/// The embedded third-order error of the implicit method (that of Hairer and Wanner 1996, without their filter) is this times the
/// third divided difference of the field over the start and the nodes.
pub(super) const EMBEDDED: f64 = 0.0275;

/// The continuous extension at `theta ∈ [0, 1]` of a step with the five coefficient vectors `r` (Hairer's `rcont`).
pub(crate) fn interpolate(r: &[f64], n: usize, theta: f64, x: &mut [f64]) {
    let rest = 1.0 - theta;
    for j in 0..n {
        x[j] = r[j] + theta * (r[n + j] + rest * (r[2 * n + j] + theta * (r[3 * n + j] + rest * r[4 * n + j])));
    }
}

/// Start and nodes of an implicit step.
fn nodes() -> [f64; 4] {
    [0.0, RADAU_3_NODES[0], RADAU_3_NODES[1], RADAU_3_NODES[2]]
}

/// Lagrange's weights at `theta` for the start and the nodes of an implicit step.
pub(crate) fn node_weights(theta: f64) -> [f64; 4] {
    let nodes = nodes();
    std::array::from_fn(|i| (0..4).filter(|&l| l != i).map(|l| (theta - nodes[l]) / (nodes[i] - nodes[l])).product())
}

/// Third divided difference over the start and the nodes of an implicit step.
pub(crate) fn third_difference(f: [f64; 4]) -> f64 {
    let nodes = nodes();
    (0..4).map(|i| f[i] / (0..4).filter(|&l| l != i).map(|l| nodes[i] - nodes[l]).product::<f64>()).sum()
}
