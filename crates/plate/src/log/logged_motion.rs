//! The plate motion in a log: smooth pieces between jumps.

use crate::{PlateKinematics, PlateMotion};
use bracketry_numerics::spline::ReinschSpline;

/// Neighbors on either side that a jump is compared with, and how many times theirs it must be.
const NEIGHBORS: usize = 8;
const SIGNIFICANT: f64 = 12.0;
/// Jumps of the displacement (m) or tilt (rad) below this are rounding.
const SMALLEST_JUMP: f64 = 1e-7;

/// A sampled motion of the plate: smooth pieces between jumps.
#[derive(Clone, Debug)]
pub struct LoggedMotion {
    /// Start of each piece with its splines of displacement and tilt.
    pieces: Vec<(f64, ReinschSpline, ReinschSpline)>,
    end: f64,
}

/// What jumps where one smooth piece of a motion follows another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jump {
    /// When, in seconds.
    pub t: f64,
    /// Change of the displacement, in meters.
    pub displacement: f64,
    /// Change of its rate, in m/s.
    pub velocity: f64,
}

impl LoggedMotion {
    pub(super) fn new(t: &[f64], displacement: &[f64], tilt: &[f64]) -> Self {
        let mut starts = vec![0];
        starts.extend((1..t.len()).filter(|k| jumps(displacement, *k) || jumps(tilt, *k)));
        let ends = starts.iter().skip(1).copied().chain([t.len()]);
        let piece = |(from, to): (&usize, usize)| {
            let part = *from..to;
            let fit = |column: &[f64]| ReinschSpline::fit(&t[part.clone()], &column[part.clone()]);
            (t[*from], fit(displacement), fit(tilt))
        };
        Self { pieces: starts.iter().zip(ends).map(piece).collect(), end: t[t.len() - 1] }
    }

    /// First and last time, in seconds.
    pub fn span(&self) -> (f64, f64) {
        (self.pieces[0].0, self.end)
    }

    /// The jumps between smooth pieces.
    pub fn jumps(&self) -> Vec<Jump> {
        let jump = |w: &[(f64, ReinschSpline, ReinschSpline)]| {
            let (before, after) = (w[0].1.at(w[1].0), w[1].1.at(w[1].0));
            Jump { t: w[1].0, displacement: after[0] - before[0], velocity: after[1] - before[1] }
        };
        self.pieces.windows(2).map(jump).collect()
    }

    /// The sampled times of the piece that holds at `at`, from `t` on, up to the start of the next one.
    pub(crate) fn knots(&self, at: f64, t: f64) -> Vec<f64> {
        let index = self.pieces.partition_point(|p| p.0 <= at).max(1) - 1;
        let end = self.pieces.get(index + 1).map_or(self.end, |p| p.0);
        let inner = self.pieces[index].1.knots().iter().copied().filter(|s| *s > t && *s < end);
        std::iter::once(t).chain(inner).chain((end > t).then_some(end)).collect()
    }

    /// The motion at `t` within the piece that holds at `at`.
    pub fn within(&self, at: f64, t: f64) -> PlateKinematics {
        let index = self.pieces.partition_point(|p| p.0 <= at).max(1) - 1;
        let (_, displacement, tilt) = &self.pieces[index];
        let ([displacement, velocity, acceleration], [tilt, tilt_rate, tilt_acceleration]) =
            (displacement.at(t), tilt.at(t));
        PlateKinematics { displacement, velocity, acceleration, tilt, tilt_rate, tilt_acceleration }
    }
}

impl PlateMotion for LoggedMotion {
    fn at(&mut self, t: f64) -> PlateKinematics {
        self.within(t, t)
    }
}

/// Whether a column jumps from row `k − 1` to row `k`: the third difference there is significant against its neighbors, which
/// a smooth motion changes slowly.
fn jumps(column: &[f64], k: usize) -> bool {
    let third = |k: usize| (column[k] - 3.0 * column[k - 1] + 3.0 * column[k - 2] - column[k - 3]).abs();
    // A jump at row k shows in the third differences that end at k, k + 1 and k + 2 as 1, −2, 1 times itself.
    if k < 3 || k + 2 >= column.len() {
        return false;
    }
    let here = third(k).min(third(k + 2)).min(0.5 * third(k + 1));
    let around = (k.saturating_sub(NEIGHBORS).max(3)..k)
        .chain(k + 3..(k + 3 + NEIGHBORS).min(column.len()))
        .map(third)
        .fold(0.0, f64::max);
    here > SMALLEST_JUMP && here > SIGNIFICANT * around
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_jump_is_found_where_it_is_and_nowhere_else() {
        let t: Vec<f64> = (0..1000).map(|k| f64::from(k) * 2e-3).collect();
        let wave = |t: f64, size: f64| size * (0.51 - 0.5 * (18.8 * t).cos() - 0.1 * (37.7 * t).cos());
        let x: Vec<f64> = t.iter().map(|t| wave(*t, if *t < 0.9999 { 0.03 } else { 0.025 })).collect();
        let mut motion = LoggedMotion::new(&t, &x, &vec![0.0; 1000]);
        let jumps = motion.jumps();
        assert_eq!(jumps.len(), 1);
        assert!((jumps[0].t - 1.0).abs() < 1e-12);
        assert!((jumps[0].displacement - (wave(1.0, 0.025) - wave(1.0, 0.03))).abs() < 1e-6);
        // The acceleration is that of the wave on both sides, with no impulse between.
        let exact =
            |t: f64, size: f64| size * (0.5 * 18.8 * 18.8 * (18.8 * t).cos() + 0.1 * 37.7 * 37.7 * (37.7 * t).cos());
        for at in [0.5, 0.98, 1.02, 1.5] {
            let size = if at < 1.0 { 0.03 } else { 0.025 };
            assert!((motion.at(at).acceleration - exact(at, size)).abs() < 0.02, "{at}");
        }
        assert!(motion.at(1.0).acceleration.abs() < 20.0);
    }
}
