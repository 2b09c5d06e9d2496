//! An integration of its own, apart from the library's.

/// A step of the classical Runge–Kutta method of fourth order: `rate` of the state and of the share of the step that is over.
pub(crate) fn step<const N: usize>(rate: impl Fn(&[f64; N], f64) -> [f64; N], x: &[f64; N], h: f64) -> [f64; N] {
    let moved = |k: &[f64; N], by: f64| std::array::from_fn(|i| x[i] + by * h * k[i]);
    let k1 = rate(x, 0.0);
    let k2 = rate(&moved(&k1, 0.5), 0.5);
    let k3 = rate(&moved(&k2, 0.5), 0.5);
    let k4 = rate(&moved(&k3, 1.0), 1.0);
    std::array::from_fn(|i| x[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]))
}
