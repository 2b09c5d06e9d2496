//! Whether a value lies inside the convex hull of the values of a function.

use bracketry_symbolic::{Expr, SplitMix64, Symbol, Tape};

use crate::system::System;

/// Sampled inputs per distance from the point.
const SAMPLES: usize = 120;
/// Distances from the point, and from the origin, at which inputs are sampled.
const DISTANCES: [f64; 4] = [0.1, 1.0, 3.0, 10.0];
/// Most functions that are looked at together.
const MAX_DIMENSION: usize = 6;

/// A point with the limits of its inputs.
pub(crate) struct Center<'a> {
    pub(crate) at: &'a [f64],
    /// Least and greatest value of each input.
    pub(crate) limits: &'a [[f64; 2]],
}

/// True if the point's value of the functions lies inside the convex hull of values that they take; false where that
/// was not seen. `functions` must be free of names other than the inputs.
///
/// Some 1000 values are sampled; the point lies inside if the hull of these comes near to all corners of a
/// cross-polytope around it.
pub(crate) fn surrounds_point(system: &System, functions: &[Expr], inputs: &[Symbol], point: &Center<'_>) -> bool {
    if functions.is_empty() || functions.len() > MAX_DIMENSION {
        return false;
    }
    let Ok(tape) = Tape::compile(&system.pool, inputs, functions) else { return false };
    let mut scratch = Vec::new();
    let mut value = |u: &[f64]| {
        let mut out = vec![0.0; functions.len()];
        tape.eval(u, &mut scratch, &mut out);
        out.iter().all(|v| v.is_finite()).then_some(out)
    };
    let Some(center) = value(point.at) else { return false };
    let mut random = SplitMix64::new(1);
    let mut points = Vec::new();
    for distance in DISTANCES {
        for k in 0..2 * SAMPLES {
            let scale = if k % 2 == 0 { 1.0 } else { 0.0 };
            let sampled = point
                .at
                .iter()
                .zip(point.limits)
                .map(|(&a, &[least, greatest])| (scale * a + distance * random.symmetric()).clamp(least, greatest));
            let u: Vec<f64> = sampled.collect();
            if let Some(v) = value(&u) {
                points.push(v.iter().zip(&center).map(|(a, b)| a - b).collect::<Vec<f64>>());
            }
        }
    }
    surrounds_origin(&points)
}

/// Whether the convex hull of the points holds a neighborhood of the origin.
fn surrounds_origin(points: &[Vec<f64>]) -> bool {
    let Some(n) = points.first().map(Vec::len) else { return false };
    // Every direction on its own scale, so that the polytope is not flat.
    let sizes: Vec<f64> = (0..n)
        .map(|i| {
            let up = points.iter().map(|p| p[i]).fold(0.0, f64::max);
            let down = points.iter().map(|p| -p[i]).fold(0.0, f64::max);
            up.min(down)
        })
        .collect();
    if sizes.iter().any(|s| *s <= 1e-6) {
        return false;
    }
    let scaled: Vec<Vec<f64>> = points.iter().map(|p| p.iter().zip(&sizes).map(|(x, s)| x / s).collect()).collect();
    // Points within δ/(2n) of the corners ±δ e_i hold the origin inside.
    let delta = 0.02;
    (0..n).all(|i| {
        [delta, -delta].into_iter().all(|d| {
            let mut corner = vec![0.0; n];
            corner[i] = d;
            hull_comes_near(&scaled, &corner, delta / (2.0 * n as f64))
        })
    })
}

/// Whether the convex hull comes nearer than `near` to `target`, by the method of Frank and Wolfe (1956): each step goes
/// from the best combination so far toward the farthest point in the direction of the target. False also where that is not
/// seen.
fn hull_comes_near(points: &[Vec<f64>], target: &[f64], near: f64) -> bool {
    const STEPS: usize = 3000;
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let Some(mut x) = points.first().cloned() else { return false };
    for _ in 0..STEPS {
        let gap: Vec<f64> = target.iter().zip(&x).map(|(t, x)| t - x).collect();
        if dot(&gap, &gap) < near * near {
            return true;
        }
        let Some(best) = points.iter().max_by(|a, b| dot(a, &gap).total_cmp(&dot(b, &gap))) else { return false };
        // All points lie on this side of a plane that the target is beyond.
        if dot(best, &gap) < dot(target, &gap) - near * dot(&gap, &gap).sqrt() {
            return false;
        }
        let step: Vec<f64> = best.iter().zip(&x).map(|(p, x)| p - x).collect();
        let (progress, length) = (dot(&gap, &step), dot(&step, &step));
        if progress <= 1e-14 || length == 0.0 {
            return false;
        }
        let t = (progress / length).min(1.0);
        for (x, s) in x.iter_mut().zip(&step) {
            *x += t * s;
        }
    }
    false
}
