//! Whether runs for validation are predicted.

use bracketry_system::System;

use super::alarm::Alarm;
use super::explanation::Explanation;
use super::held_out::{thinned, window_length};
use super::limits::{MUCH_MORE, NEAR_NOISE};
use super::settings::Settings;
use crate::report::Mispredicted;
use crate::{DiagnoseError, Record, Study, StudySettings};

/// The runs for validation, with the size of their residual over noise, that the explanation predicts much worse than the data
/// of its fit: parameters and coefficients stay, only initial states are fitted.
///
/// # Errors
/// Records that do not fit the model: [`DiagnoseError`].
pub(super) fn mispredicted(
    system: &System,
    like: &Study,
    explanation: &Explanation,
    validate: &[Record],
    settings: &Settings,
) -> Result<Vec<Mispredicted>, DiagnoseError> {
    let mut found = Vec::new();
    for record in validate {
        let length = StudySettings { window: window_length(like), ..settings.study.clone() };
        let study = Study::new(system, std::slice::from_ref(record), &length)?;
        let windows = study.evaluate(&explanation.fit, &thinned(study.windows().len()))?;
        let alarm = Alarm::of(&windows, system.states.len(), 0);
        if alarm.p_value < settings.significance && alarm.size > NEAR_NOISE.max(MUCH_MORE * explanation.alarm.size) {
            found.push(Mispredicted { record: record.name.clone(), size: alarm.size });
        }
    }
    Ok(found)
}
