//! Instants at which a gap closes.

/// Resolution of event times in s.
const TIME_RESOLUTION: f64 = 1e-12;

/// The end, on the negative side, of an interval of [`TIME_RESOLUTION`] in which `f` changes sign, given `f(low) = at_low ≥ 0`
/// and `f(high) < 0`: false position with the Illinois rule, bisection where that is slow.
pub(super) fn locate(mut low: f64, mut at_low: f64, mut high: f64, mut f: impl FnMut(f64) -> f64) -> f64 {
    let mut at_high = f(high);
    let mut side = 0;
    for round in 0..200 {
        let width = high - low;
        if width <= TIME_RESOLUTION {
            break;
        }
        let secant = high - at_high * width / (at_high - at_low);
        let middle = if round % 3 == 2 || !(secant > low && secant < high) {
            0.5 * (low + high)
        } else {
            // A step to the other side of the root shrinks the interval from both ends.
            secant.clamp(low + 0.1 * TIME_RESOLUTION, high - 0.1 * TIME_RESOLUTION)
        };
        if middle <= low || middle >= high {
            break;
        }
        let value = f(middle);
        if value < 0.0 {
            (high, at_high) = (middle, value);
            if side == -1 {
                at_low *= 0.5;
            }
            side = -1;
        } else {
            (low, at_low) = (middle, value);
            if side == 1 {
                at_high *= 0.5;
            }
            side = 1;
        }
    }
    high
}
