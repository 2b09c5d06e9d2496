//! States between samples.

use crate::Course;

/// The states of a plant at increasing times. Between two samples positions follow the cubic that has their velocities
/// (Hermite), velocities a straight line.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SampledCourse {
    times: Vec<f64>,
    states: Vec<[f64; 6]>,
}

impl SampledCourse {
    /// A course that begins, and so far ends, at `t`.
    pub fn new(t: f64, state: [f64; 6]) -> Self {
        Self { times: vec![t], states: vec![state] }
    }

    /// Adds a sample, not before the last one; at the same time as the last one it is a jump.
    pub fn push(&mut self, t: f64, state: [f64; 6]) {
        self.times.push(t);
        self.states.push(state);
    }

    /// Times of the samples in seconds. A time that occurs twice is a jump.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// States at the samples.
    pub fn states(&self) -> &[[f64; 6]] {
        &self.states
    }

    /// Samples another course at its ends and every `interval` seconds between.
    pub fn of<C: Course>(course: &C, interval: f64) -> Self {
        let (start, end) = (course.start(), course.end());
        let mut sampled = Self::new(start, course.state_at(start));
        let parts = ((end - start) / interval).ceil().max(0.0);
        for part in 1..=parts as usize {
            let t = if part as f64 == parts { end } else { start + (end - start) * part as f64 / parts };
            sampled.push(t, course.state_at(t));
        }
        sampled
    }
}

impl Course for SampledCourse {
    fn start(&self) -> f64 {
        self.times.first().copied().unwrap_or(0.0)
    }

    fn end(&self) -> f64 {
        self.times.last().copied().unwrap_or(0.0)
    }

    fn state_at(&self, t: f64) -> [f64; 6] {
        let after = self.times.partition_point(|&at| at <= t);
        let (Some(&b), Some(&a)) = (self.states.get(after), self.states.get(after.wrapping_sub(1))) else {
            let outside = if after == 0 { self.states.first() } else { self.states.last() };
            return outside.copied().unwrap_or([0.0; 6]);
        };
        let h = self.times[after] - self.times[after - 1];
        let s = (t - self.times[after - 1]) / h;
        let r = 1.0 - s;
        std::array::from_fn(|i| {
            if i < 3 {
                let chord = b[i] - a[i];
                let (rise, fall) = (h * a[i + 3] - chord, chord - h * b[i + 3]);
                a[i] + s * (chord + r * (r * rise + s * fall))
            } else {
                r * a[i] + s * b[i]
            }
        })
    }

    fn join(&mut self, later: &Self) {
        // The first sample is kept even where it repeats the last one: between them the state may have jumped.
        let repeated = self.states.last() == later.states.first() && self.times.last() == later.times.first();
        let from = usize::from(repeated);
        self.times.extend(&later.times[from.min(later.times.len())..]);
        self.states.extend(&later.states[from.min(later.states.len())..]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cubic(t: f64) -> [f64; 6] {
        let x = 1.0 + t * (2.0 + t * (3.0 - t));
        [x, t, t * t, 2.0 + t * (6.0 - 3.0 * t), 1.0, 2.0 * t]
    }

    #[test]
    fn positions_are_exact_for_cubics_and_jumps_are_kept() {
        let mut course = SampledCourse::new(0.0, cubic(0.0));
        course.push(0.5, cubic(0.5));
        let mut later = SampledCourse::new(0.5, [9.0; 6]);
        later.push(2.0, [9.0, 9.0, 9.0, 0.0, 0.0, 0.0]);
        course.join(&later);
        assert!((course.state_at(0.3)[0] - cubic(0.3)[0]).abs() < 1e-15);
        assert!((course.state_at(0.3)[2] - 0.09).abs() < 1e-15);
        assert_eq!(course.state_at(0.5), [9.0; 6]);
        assert_eq!((course.start(), course.end()), (0.0, 2.0));
        assert_eq!((course.state_at(-1.0), course.state_at(7.0)[0]), (cubic(0.0), 9.0));
    }
}
