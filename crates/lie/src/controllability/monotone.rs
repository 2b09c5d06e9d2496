//! Functions of the state that no input lowers, however large it is.

use bracketry_symbolic::{Function, Pool};

use crate::algebra::field::Field;
use crate::algebra::integrals::search::integrals;
use crate::algebra::rational::readable::tidy;
use crate::controllability::impulses::is_entire;
use crate::controllability::local::Frame;
use crate::controllability::sign::{NearOrigin, Sign};
use crate::evidence::Evidence;
use crate::reason::{Monotone, StlcReason};
use crate::residues::Fp;
use crate::undecided::Undecided;

/// A function φ with dφ(x0) ≠ 0 that is constant along all input fields and rises (or falls) along the drift everywhere.
///
/// Then φ(x) ≥ φ(x0) on all that is reached, and x0 is no interior point of it, whatever the inputs are and however far the
/// state goes. φ is sought among the integrals of the input fields, so that it does not depend on the coordinates in which
/// the system is given; it and its rate have to be defined for all states.
pub(crate) fn monotone_function(
    pool: &mut Pool,
    frame: &Frame,
    evidence: &mut Evidence,
) -> Result<Option<StlcReason>, Undecided> {
    let fields = &frame.fields;
    let states = fields.states.clone();
    if fields.controls.is_empty() {
        return Ok(None);
    }
    let known = [&fields.drift[..], &fields.controls.concat()].concat();
    let found = integrals(pool, &states, &fields.controls, &known, &fields.bindings, evidence)?;
    let (variables, offsets) = frame.deviations(pool);
    let everywhere = NearOrigin { frame, variables, everywhere: true };
    for function in found.functions {
        let gradient: Field = pool.gradient(function, &states);
        let steady = frame.evaluate(pool, &[gradient], evidence)?.concat().iter().all(|d| *d == Fp::ZERO);
        let rate = pool.lie_derivative(function, &states, &fields.drift);
        let rate = tidy(pool, rate);
        if steady || !is_entire(pool, &[function, rate], &states) {
            continue;
        }
        let moved = pool.substitute(rate, &offsets);
        let change = match everywhere.sign(pool, moved) {
            Sign::Zero => Monotone::Constant,
            Sign::Positive | Sign::NonNegative => Monotone::Rises,
            Sign::Negative | Sign::NonPositive => Monotone::Falls,
            Sign::Unknown => continue,
        };
        let function = Function::new(pool, function);
        return Ok(Some(StlcReason::HalfSpace { function, change, one_sided: false }));
    }
    Ok(None)
}
