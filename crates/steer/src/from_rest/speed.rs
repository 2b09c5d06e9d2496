//! How fast an input can be at a place, if it starts and ends at rest within its bounds.

use bracketry_symbolic::{Expr, Func2, Pool, Rational, Symbol};

use super::bounds::Span;
use super::model::Channel;

/// What stands for the speed of an input.
pub(crate) struct SpeedLimit {
    /// The symbol of the speed in the equations.
    pub(crate) speed: Symbol,
    /// The same as a function of the place and of a ratio.
    pub(crate) limited: Expr,
    /// The ratio of the speed to its limit, between −1 and 1.
    pub(crate) ratio: Symbol,
}

/// With x between `low` and `high` and x'' between −β and α: x'² ≤ 2 β (high − x), because the input stops before `high`, or has come
/// from rest there; and x'² ≤ 2 α (x − low). Bounds of the speed hold, too. `None` where the equations do not contain both, or
/// the bounds are not finite.
pub(crate) fn speed_limit(pool: &mut Pool, channel: &Channel, spans: &[Span]) -> Option<SpeedLimit> {
    let ([Some(place), Some(speed), _], [of_place, of_speed, of_top]) = (&channel.symbols[..], spans) else {
        return None;
    };
    if !of_place.is_finite() || !of_top.is_finite() || of_place.width() <= 0.0 {
        return None;
    }
    let x = pool.sym(*place);
    let two = pool.int(2);
    let low = end(pool, of_place, 0)?;
    let high = end(pool, of_place, 1)?;
    let back = end(pool, of_top, 0)?;
    let back = pool.neg(back);
    let forth = end(pool, of_top, 1)?;
    let (to_high, from_low) = (pool.sub(high, x), pool.sub(x, low));
    let stops = pool.mul(back, to_high);
    let starts = pool.mul(forth, from_low);
    let least = pool.call2(Func2::Min, stops, starts);
    let mut square = pool.mul(two, least);
    if of_speed.is_finite() {
        let most = of_speed.outward().iter().fold(0.0f64, |most, v| most.max(v.abs()));
        let most = pool.rational(Rational::try_from(most).ok()?);
        let most = pool.powi(most, 2);
        square = pool.call2(Func2::Min, square, most);
    }
    let root = pool.sqrt(square);
    let ratio = pool.symbol(&format!("ratio of der({})", channel.name));
    let factor = pool.sym(ratio);
    Some(SpeedLimit { speed: *speed, limited: pool.mul(factor, root), ratio })
}

/// An end of an interval, rounded outward if it is not rational.
fn end(pool: &mut Pool, span: &Span, side: usize) -> Option<Expr> {
    let exact = match &span.exact[side] {
        Some(exact) => exact.clone(),
        None => Rational::try_from(span.outward()[side]).ok()?,
    };
    Some(pool.rational(exact))
}
