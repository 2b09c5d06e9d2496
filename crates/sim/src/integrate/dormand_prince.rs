//! One explicit step.

use super::step::{Attempt, Control, Step};
use super::tableau::{A, C, D, E};
use crate::friction::Field;

/// The stages of a step of length `h`, its end, its continuous extension and its error.
pub(super) fn attempt(step: &mut Step, field: &mut Field<'_>, h: f64, control: Control<'_>) -> Attempt {
    for i in 1..7 {
        for j in 0..step.x.len() {
            let sum: f64 = (0..i).map(|l| A[i][l] * step.k[l][j]).sum();
            step.end[j] = step.x[j] + h * sum;
        }
        if !field.evaluate((step.t + C[i] * h, &step.end), &mut step.k[i]) {
            return if step.end.iter().all(|v| v.is_finite()) { Attempt::Unsolvable } else { Attempt::NonFinite };
        }
        if !step.k[i].iter().all(|v| v.is_finite()) {
            return Attempt::NonFinite;
        }
        step.signs[i].copy_from_slice(&field.s);
    }
    step.extend(h, |k, j, _| h * (0..7).map(|i| D[i] * k[i][j]).sum::<f64>());
    let of_state = |j: usize| (0..7).map(|i| E[i] * step.k[i][j]).sum::<f64>() * h;
    let of_sign = |c: usize| (0..7).map(|l| E[l] * step.signs[l][c]).sum::<f64>();
    step.judge(field, control, of_state, of_sign)
}
