//! Windows that no fit has seen.

use super::explanation::Explanation;
use crate::{DiagnoseError, Study};

/// At most `most` evenly spread windows out of `count`.
pub(crate) fn thinned(count: usize, most: usize) -> Vec<usize> {
    (0..count).step_by(count.div_ceil(most).max(1)).collect()
}

/// Length of the windows of a study, s.
pub(crate) fn window_length(study: &Study) -> Option<f64> {
    study.windows().first().and_then(|w| {
        let times = &study.records()[w.record].times;
        Some(times.get(w.to - 1)? - times.get(w.from)?)
    })
}

/// Windows kept apart: parameters and coefficients stay, only initial states are fitted. Records for validation play no part, so
/// that the gain which they show is independent of what was chosen.
pub(crate) struct UnseenWindows {
    study: Study,
    windows: Vec<usize>,
}

impl UnseenWindows {
    /// At most `most` windows of a study that are not among `seen`; `None` if there are none.
    pub(crate) fn new(study: &Study, seen: &[usize], most: usize) -> Option<Self> {
        let unseen: Vec<usize> = (0..study.windows().len()).filter(|w| !seen.contains(w)).collect();
        let windows: Vec<usize> = thinned(unseen.len(), most).into_iter().map(|i| unseen[i]).collect();
        (!windows.is_empty()).then(|| Self { study: study.clone(), windows })
    }

    /// By how many standard errors `b` leaves more over than `a`, from the differences by window.
    pub(crate) fn worse(&self, b: &Explanation, a: &Explanation) -> Result<f64, DiagnoseError> {
        let of_b = self.study.evaluate(&b.fit, &self.windows)?;
        let of_a = self.study.evaluate(&a.fit, &self.windows)?;
        let differences: Vec<f64> = of_b
            .iter()
            .zip(&of_a)
            .filter(|(b, a)| b.count > 0 && a.count == b.count)
            .map(|(b, a)| b.square - a.square)
            .collect();
        let n = differences.len() as f64;
        if n < 3.0 {
            return Ok(0.0);
        }
        let mean = differences.iter().sum::<f64>() / n;
        let variance = differences.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (n - 1.0);
        let error = (variance / n).sqrt();
        Ok(if error > 0.0 { mean / error } else { 0.0 })
    }
}
