//! Loops that turn a velocity without friction, and stop it.

use super::bounds::Span;
use super::held::{Motion, Test, Where};
use super::model::RestModel;
use super::sign::Holds;
use super::strokes::Loop;

/// The coordinate that a closed loop moves, and the sign, if this is proven; the simulated change tells which sign to prove.
///
/// The velocity w of the coordinate has no friction, and all others are held along the loop. The loop runs twice, the second
/// time with the last input multiplied by −κ. If w' is linear in that input and has one sign along the first run, w has this sign
/// there, and returns to zero for some κ near 1 if the loop is short: the sign of w at the end changes with κ, because w' is
/// multiplied by −κ up to a change of the coordinate that tends to zero with the duration.
pub(crate) fn proven(model: &mut RestModel, closed: &Loop, change: &[f64]) -> Option<(usize, f64)> {
    let closing = closed.closing?;
    let spans = closed.spans(model);
    let held = Test::new(model, &spans, Where::Near).run();
    let mut moving = (0..held.motions.len()).filter(|&c| held.motions[c] != Motion::Never);
    let (Some(c), None) = (moving.next(), moving.next()) else { return None };
    let sign = change[c].signum();
    let top = model.channels[closing.input].order();
    let input = model.channels[closing.input].symbols[top]?;
    let rate = Test::new(model, &spans, Where::Near).driven_rate(c, closing.velocity)?;
    let pool = &mut model.system.pool;
    let slope = pool.diff(rate, input);
    let curvature = pool.diff(slope, input);
    let zero = pool.int(0);
    let without = pool.at(rate, &[(input, zero)]).ok()?;
    if !model.is_zero(curvature) || !model.is_zero(without) {
        return None;
    }
    for (row, _) in &closed.pieces[..closing.from_piece] {
        let mut here = spans.clone();
        for (channel, (spans, value)) in model.channels.iter().zip(here.iter_mut().zip(row)) {
            spans[channel.order()] = Span::between(*value, *value);
        }
        if Test::new(model, &here, Where::Near).driven_sign(c, closing.velocity, sign) != Holds::Always {
            return None;
        }
    }
    Some((c, sign))
}
