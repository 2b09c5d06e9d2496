//! Faults put into a closed loop on purpose.

use crate::controller::StepLimits;

/// One thing that goes wrong at a sample.
#[derive(Clone, Debug, PartialEq)]
pub enum Fault {
    /// These measured outputs are not a number.
    NotANumber {
        /// Their indices; indices beyond the outputs are without effect.
        outputs: Vec<usize>,
    },
    /// Nothing is measured.
    LostSample,
    /// A blow: added to the state of the plant before it is measured; entries that are missing are 0.
    Disturbance(Vec<f64>),
    /// The solver of this sample gets no more than this many iterations.
    SolverLimit(u32),
    /// The controller gets no more than this time for this sample, s.
    TimeLimit(f64),
}

impl StepLimits {
    /// The limits among some faults.
    pub(crate) fn of(faults: &[Fault]) -> Self {
        let mut limits = Self::default();
        for f in faults {
            match f {
                Fault::SolverLimit(n) => limits.iterations = limits.iterations.min(*n),
                Fault::TimeLimit(s) => limits.time = limits.time.min(*s),
                _ => {}
            }
        }
        limits
    }
}

/// Changes the state of the plant by the disturbances among some faults.
pub(crate) fn disturb(faults: &[Fault], x: &mut [f64]) {
    for f in faults {
        if let Fault::Disturbance(d) = f {
            x.iter_mut().zip(d).for_each(|(x, d)| *x += d);
        }
    }
}

/// Changes a measurement by the losses among some faults.
pub(crate) fn lose(faults: &[Fault], y: &mut [f64]) {
    for f in faults {
        match f {
            Fault::LostSample => y.fill(f64::NAN),
            Fault::NotANumber { outputs } => {
                for &i in outputs {
                    if let Some(v) = y.get_mut(i) {
                        *v = f64::NAN;
                    }
                }
            }
            _ => {}
        }
    }
}
