//! Ways between poses.

use std::f64::consts::{PI, TAU};

/// Distance in m at which a turn moves an object as far as a displacement does, to compare the two.
const ARM: f64 = 0.1;

/// How far a move repeats another: their common part as a share of the other, from 0 to 1.
pub(super) fn repetition(way: &[f64; 3], last: &[f64; 3]) -> f64 {
    let product = |a: &[f64; 3], b: &[f64; 3]| a[0] * b[0] + a[1] * b[1] + ARM * ARM * a[2] * b[2];
    let square = product(last, last);
    if square > 0.0 { (product(way, last) / square).clamp(0.0, 1.0) } else { 0.0 }
}

/// The angle that differs from `angle` by whole turns and is nearest to `to`.
pub(super) fn nearest_turn(angle: f64, to: f64) -> f64 {
    to + (angle - to + PI).rem_euclid(TAU) - PI
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_way_is_repeated_wholly_half_of_it_by_half_and_the_way_back_not_at_all() {
        let way = [0.05, -0.02, 0.4];
        assert!((repetition(&way, &way) - 1.0).abs() < 1e-12);
        assert!((repetition(&way.map(|x| 0.5 * x), &way) - 0.5).abs() < 1e-12);
        assert_eq!(repetition(&way.map(|x| -x), &way), 0.0);
        assert_eq!(repetition(&way, &[0.0; 3]), 0.0);
    }
}
