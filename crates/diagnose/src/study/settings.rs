//! How a study cuts and fits.

/// How a study cuts and fits.
#[derive(Clone, Debug, PartialEq)]
pub struct StudySettings {
    /// Length of the windows, s; `None`: a sixteenth of the data, or what [`Study::with_best_windows`](crate::Study::with_best_windows) chooses.
    pub window: Option<f64>,
    /// Names of parameters that keep their values.
    pub fixed: Vec<String>,
    /// Most iterations of a fit.
    pub iterations: usize,
}

impl Default for StudySettings {
    fn default() -> Self {
        Self { window: None, fixed: Vec::new(), iterations: 15 }
    }
}
