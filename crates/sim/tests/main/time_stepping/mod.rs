//! Implicit time steps (Moreau 1988, Jean 1999) of a unit mass under any sum of friction terms: independent of switches and events.

/// Friction with the dissipation `weight · |rows v|`, and its force at the last step.
#[derive(Debug, Clone)]
pub(crate) struct Term {
    weight: f64,
    rows: Vec<Vec<f64>>,
    force: Vec<f64>,
    /// Square of the norm of the rows, from above.
    size: f64,
}

impl Term {
    pub(crate) fn new<const N: usize>(weight: f64, rows: [Vec<f64>; N]) -> Self {
        let size = rows.iter().flatten().map(|r| r * r).sum();
        Self { weight, force: vec![0.0; N], rows: rows.into_iter().collect(), size }
    }
}

/// Minimizes `½|v − v*|² + h Σ weight · |rows v|` from `v = v*`, by passes over the terms, each of which gets the force in its ball that
/// makes its own slip least.
pub(crate) fn rest_of_step(v: &mut [f64], h: f64, terms: &mut [Term]) {
    for term in &*terms {
        for (row, force) in term.rows.iter().zip(&term.force) {
            v.iter_mut().zip(row).for_each(|(v, r)| *v -= h * r * force);
        }
    }
    for _ in 0..400 {
        let mut change = 0.0f64;
        for term in &mut *terms {
            let slip: Vec<f64> = term.rows.iter().map(|row| row.iter().zip(&*v).map(|(r, v)| r * v).sum()).collect();
            let mut next: Vec<f64> = term.force.iter().zip(&slip).map(|(f, u)| f + u / (h * term.size)).collect();
            let size = next.iter().map(|f| f * f).sum::<f64>().sqrt();
            if size > term.weight {
                next = next.iter().map(|f| f * term.weight / size).collect();
            }
            for ((row, force), next) in term.rows.iter().zip(&mut term.force).zip(next) {
                v.iter_mut().zip(row).for_each(|(v, r)| *v -= h * r * (next - *force));
                change = change.max((next - *force).abs());
                *force = next;
            }
        }
        if change < 1e-10 {
            return;
        }
    }
}
