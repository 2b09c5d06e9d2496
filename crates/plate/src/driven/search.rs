//! What is looked for along a trajectory: the least load, crossings.

use super::interface::Course;
use crate::PlateMotion;
use crate::model::normal_load;

/// The least normal load over a course, looked at [`PARTS`] times.
pub(crate) fn least_load<C: Course, M: PlateMotion>(course: &C, motion: &mut M, height: f64) -> f64 {
    let (start, length) = (course.start(), course.end() - course.start());
    (0..=PARTS)
        .map(|part| {
            let t = start + length * f64::from(part) / f64::from(PARTS);
            normal_load(&course.state_at(t), &motion.at(t), height)
        })
        .fold(f64::INFINITY, f64::min)
}

/// Parts of a course in which a rate is taken to change its sign once at most.
const PARTS: u32 = 64;

/// First time, to 1 ns, at which coordinate `index` satisfies `direction·(q − level) ≥ 0`. Where it has an extremum close
/// to the level, that is examined, so that no crossing between two samples is missed.
pub(crate) fn crossing<C: Course>(course: &C, index: usize, level: f64, direction: f64) -> Option<f64> {
    let beyond = |t: f64| direction * (course.state_at(t)[index] - level) >= 0.0;
    let approaches = |t: f64| direction * course.state_at(t)[index + 3] > 0.0;
    let (start, end) = (course.start(), course.end());
    let mut before = start;
    if beyond(before) {
        return Some(before);
    }
    for part in 1..=PARTS {
        let at = if part == PARTS { end } else { start + (end - start) * f64::from(part) / f64::from(PARTS) };
        let extremum = (approaches(before) && !approaches(at)).then(|| bisect(before, at, |t| !approaches(t)));
        for at in extremum.into_iter().chain([at]) {
            if beyond(at) {
                return Some(bisect(before, at, beyond));
            }
        }
        before = at;
    }
    None
}

/// The end of the interval from `a` (false) to `b` (true) at which a condition becomes true, to 1 ns.
fn bisect(mut a: f64, mut b: f64, condition: impl Fn(f64) -> bool) -> f64 {
    while b - a > 1e-9 {
        let m = 0.5 * (a + b);
        if condition(m) { b = m } else { a = m }
    }
    b
}
