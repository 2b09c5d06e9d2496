//! Integration between events: one step, explicit or implicit, with its continuous extension.

mod dense;
mod dormand_prince;
mod newton;
mod radau;
mod regime;
mod step;
mod stiff;
mod stiffness;
mod tableau;

pub(crate) use dense::{interpolate, node_weights};
pub(crate) use regime::Regime;
pub(crate) use step::{Attempt, Control, Method, Step};
pub(crate) use stiffness::{Approach, Stiffness};

use crate::friction::Field;

/// The stages of a step of length `h`, its end, its continuous extension and its error.
pub(crate) fn attempt(step: &mut Step, field: &mut Field<'_>, h: f64, control: Control<'_>) -> Attempt {
    let method = match step.method {
        Method::Explicit => dormand_prince::attempt,
        Method::Directions => radau::attempt,
        Method::Stiff => stiff::attempt,
    };
    method(step, field, h, control)
}
