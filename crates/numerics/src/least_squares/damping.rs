/// How an iteration damps its steps: less after a step that helped, more until one does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Damping {
    /// The damping of the next trial.
    pub value: f64,
    /// It does not become less than this.
    pub least: f64,
    /// From here on no step is tried.
    pub most: f64,
    /// Factor after a step that was accepted.
    pub lower: f64,
    /// Factor after a step that was rejected.
    pub raise: f64,
    /// Most trials of one step.
    pub trials: usize,
    /// Where the damping is at most this, the first trial of a step has none: that of Newton's method.
    pub undamped: f64,
}

impl Default for Damping {
    fn default() -> Self {
        Self { value: 1e-3, least: 1e-12, most: 1e12, lower: 0.1, raise: 10.0, trials: usize::MAX, undamped: 0.0 }
    }
}

/// What came of a trial.
#[derive(Clone, Debug, PartialEq)]
pub enum Trial<T> {
    /// The step helps.
    Accepted(T),
    /// It does not; one with more damping may.
    Rejected,
    /// None will help.
    Last,
}

impl Damping {
    /// Tries steps with more and more damping. `None` where none was accepted.
    ///
    /// ```
    /// use bracketry_numerics::least_squares::{Damping, Trial};
    /// let mut damping = Damping::default();
    /// let found = damping.search(|d| if d > 0.5 { Trial::Accepted(d) } else { Trial::Rejected });
    /// assert_eq!(found, Some(1.0));
    /// assert_eq!(damping.value, 0.1);
    /// ```
    pub fn search<T>(&mut self, mut trial: impl FnMut(f64) -> Trial<T>) -> Option<T> {
        for k in 0..self.trials {
            if self.value >= self.most {
                break;
            }
            let is_undamped = k == 0 && self.value <= self.undamped;
            match trial(if is_undamped { 0.0 } else { self.value }) {
                Trial::Accepted(found) => {
                    self.value = (self.lower * self.value).max(self.least);
                    return Some(found);
                }
                Trial::Rejected => self.value *= self.raise,
                Trial::Last => break,
            }
        }
        None
    }
}
