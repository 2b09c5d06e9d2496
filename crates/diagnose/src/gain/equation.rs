//! The force error: the residual of the equations when states and accelerations come from the data.

use bracketry_system::System;

use super::evaluation::{Equations, Evaluated};
use crate::effect::Effect;
use crate::error::DiagnoseError;
use crate::record::Record;
use crate::settings::EquationSettings;
use crate::study::Estimate;

/// Residual of one equation in one stretch of a record, over time.
#[derive(Clone, Debug)]
pub struct ForceResidual {
    /// Index of the record.
    pub record: usize,
    /// The state whose time derivative the equation gives.
    pub equation: String,
    /// The input in whose unit the values are; `None`: they are time derivatives of the state.
    pub input: Option<String>,
    /// Sample of each value.
    pub samples: Vec<usize>,
    /// Applied minus needed: `(f − x')/(∂f/∂u)`, or `f − x'`.
    pub values: Vec<f64>,
    /// What they are compared with: the input, or `x'`.
    pub reference: Vec<f64>,
    /// The state itself.
    pub state: Vec<f64>,
    /// `|∂f/∂u|` over its root mean square, 1 without an input: how much a force matters there.
    pub weights: Vec<f64>,
    /// Bandwidth, Hz.
    pub bandwidth: f64,
}

impl ForceResidual {
    /// The part at some samples.
    pub(super) fn only(mut self, samples: impl Fn(usize) -> bool) -> Self {
        let kept: Vec<bool> = self.samples.iter().map(|&k| samples(k)).collect();
        for list in [&mut self.values, &mut self.reference, &mut self.state, &mut self.weights] {
            let mut inside = kept.iter();
            list.retain(|_| inside.next() == Some(&true));
        }
        self.samples.retain(|&k| samples(k));
        self
    }
}

/// Residuals of the equations of a model in records, by record, stretch without a gap, and equation, with states and
/// accelerations from smoothing splines. `effects` and `values` (parameters and coefficients by name) change the model; without
/// them it is taken as it stands.
///
/// Equations that need states which no measured column gives, directly or as a derivative, and stretches that are too short
/// or too noisy, are left out; so are samples at which the input hardly acts, `|∂f/∂u|` below a share of its root mean square.
///
/// # Errors
/// [`DiagnoseError`] for effects that do not fit the model.
pub fn force_residuals(
    system: &System,
    effects: &[Effect],
    values: &[Estimate],
    records: &[Record],
    settings: &EquationSettings,
) -> Result<Vec<ForceResidual>, DiagnoseError> {
    let equations = Equations::new(system, effects, values, false, settings)?;
    let stretches = records.iter().enumerate().flat_map(|(index, record)| equations.evaluate(index, record));
    Ok(stretches.flat_map(|stretch| in_stretch(&equations, &stretch)).collect())
}

/// The residuals of the equations in one stretch.
fn in_stretch(equations: &Equations, stretch: &Evaluated) -> Vec<ForceResidual> {
    let made = stretch.rows.iter().filter_map(|row| {
        let weights = weights(&row.gain);
        let weak: Vec<bool> = weights.iter().map(|w| *w < equations.settings.weak_input).collect();
        let missing: Vec<f64> = row
            .model
            .iter()
            .zip(&row.rate)
            .zip(row.gain.iter().zip(&weak))
            .map(|((f, rate), (gain, weak))| if *weak { f64::NAN } else { (f - rate) / gain })
            .collect();
        let kept: Vec<usize> = stretch.kept.clone().filter(|&k| !weak[k]).collect();
        let at = |list: &[f64]| kept.iter().map(|&k| list[k]).collect::<Vec<f64>>();
        let state = stretch.states[row.state].as_ref()?;
        Some(ForceResidual {
            record: stretch.record,
            equation: equations.state_name(row.state),
            input: row.input.map(|i| equations.input_name(i)),
            samples: kept.iter().map(|k| stretch.from + k).collect(),
            values: at(&stretch.smooth(&missing)?),
            reference: at(&stretch.smooth(row.input.map_or(&row.rate, |i| &stretch.inputs[i]))?),
            state: at(state),
            weights: at(&weights),
            bandwidth: stretch.bandwidth,
        })
    });
    made.filter(|r| r.values.iter().chain(&r.reference).all(|v| v.is_finite())).collect()
}

/// The force error, `‖residual‖/‖reference‖` over all samples of an equation, each with its weight: forces count by what they do to the
/// rate; of several equations the root mean square. `None` if no equation could be evaluated.
pub fn force_error(residuals: &[ForceResidual]) -> Option<f64> {
    let mut names: Vec<&str> = residuals.iter().map(|r| r.equation.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    let square =
        |values: &[f64], weights: &[f64]| values.iter().zip(weights).map(|(v, w)| (v * w).powi(2)).sum::<f64>();
    let mut sum = 0.0;
    for name in &names {
        let of = residuals.iter().filter(|r| r.equation == *name);
        let (left, whole) =
            of.fold((0.0, 0.0), |(a, b), r| (a + square(&r.values, &r.weights), b + square(&r.reference, &r.weights)));
        sum += left / whole;
    }
    let error = (sum / names.len() as f64).sqrt();
    error.is_finite().then_some(error)
}

/// `|∂f/∂u|` over its root mean square.
fn weights(gains: &[f64]) -> Vec<f64> {
    let rms = (gains.iter().map(|g| g * g).sum::<f64>() / gains.len() as f64).sqrt();
    gains.iter().map(|g| g.abs() / rms).collect()
}
