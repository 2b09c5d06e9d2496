//! Whether runs for validation are predicted.

use bracketry_system::System;

use super::alarm::Alarm;
use super::explanation::Explanation;
use super::held_out::{thinned, window_length};
use crate::report::Mispredicted;
use crate::settings::DiagnosisSettings;
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
    settings: &DiagnosisSettings,
) -> Result<Vec<Mispredicted>, DiagnoseError> {
    let limits = &settings.verdict;
    let mut found = Vec::new();
    for record in validate {
        let length = StudySettings { window: window_length(like), ..settings.study.clone() };
        let study = Study::counted(system, std::slice::from_ref(record), &length, like.counter())?;
        let windows = study.evaluate(&explanation.fit, &thinned(study.windows().len(), limits.search.most_windows))?;
        let alarm = Alarm::of(&windows, system.states.len(), 0, &limits.alarm);
        let large = limits.search.near_noise.max(limits.naming.much_more * explanation.alarm.size);
        if alarm.p_value < settings.significance && alarm.size > large {
            found.push(Mispredicted { record: record.name.clone(), size: alarm.size });
        }
    }
    Ok(found)
}
