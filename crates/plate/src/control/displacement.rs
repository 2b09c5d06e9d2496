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

/// Turns in rad beyond which the way round the other side may be the shorter one.
const FAR_ROUND: f64 = 2.2;

/// The pose with its yaw as near as whole turns bring it, and where that is far, the one that is reached the other way round.
pub(super) fn ways_round(yaw: f64, [x, y, target]: [f64; 3]) -> Vec<[f64; 3]> {
    let near = nearest_turn(target, yaw);
    let mut ways = vec![[x, y, near]];
    if (near - yaw).abs() > FAR_ROUND {
        ways.push([x, y, near - TAU.copysign(near - yaw)]);
    }
    ways
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_far_turn_has_two_ways_round_and_they_end_alike() {
        for (yaw, target) in [(0.3, 3.0), (-2.0, 0.9), (7.0, 3.9)] {
            let ways = ways_round(yaw, [0.1, 0.2, target]);
            let turns: Vec<f64> = ways.iter().map(|way| way[2] - yaw).collect();
            assert_eq!(turns.len(), 2);
            assert!(turns[0] * turns[1] < 0.0 && turns[0].abs() <= PI);
            assert!((turns[0] - turns[1]).abs() - TAU < 1e-12);
            assert!(ways.iter().all(|way| ((way[2] - target) / TAU).fract().abs() < 1e-12 && way[..2] == [0.1, 0.2]));
        }
        assert_eq!(ways_round(0.0, [0.0, 0.0, 1.5]), [[0.0, 0.0, 1.5]]);
    }

    #[test]
    fn the_same_way_is_repeated_wholly_half_of_it_by_half_and_the_way_back_not_at_all() {
        let way = [0.05, -0.02, 0.4];
        assert!((repetition(&way, &way) - 1.0).abs() < 1e-12);
        assert!((repetition(&way.map(|x| 0.5 * x), &way) - 0.5).abs() < 1e-12);
        assert_eq!(repetition(&way.map(|x| -x), &way), 0.0);
        assert_eq!(repetition(&way, &[0.0; 3]), 0.0);
    }
}
