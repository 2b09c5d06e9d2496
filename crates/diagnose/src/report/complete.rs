//! What follows from the fits of a report: intervals, the extended model, the gain.

use super::table::significant;
use super::{Report, Verdict};
use crate::error::DiagnoseError;
use crate::extend::ExtendedModel;
use crate::gain::{Fitted, NO_FORCE, bootstrap, measure_gain};
use crate::record::Record;
use crate::study::{Fit, Study, StudySettings};

impl Report {
    /// Adds to a report with causes the intervals of its numbers, the extended model, and the gain; `refitted` and `extended` are
    /// fits to all windows of the study. Other reports get the fits only.
    pub(crate) fn complete(
        &mut self,
        study: &Study,
        refitted: &Fit,
        extended: &Fit,
        validate: &[Record],
        settings: &StudySettings,
        seed: u64,
    ) -> Result<(), DiagnoseError> {
        let all: Vec<usize> = (0..study.windows().len()).collect();
        let at_extended = study.linearize(extended, &[], &all)?;
        if let Some(steps) = bootstrap(&at_extended, &extended.limited, seed) {
            for (j, (estimate, step)) in extended.values.iter().zip(steps).enumerate() {
                // What the data do not tell keeps near the prior in every resample.
                if let Some(step) = step.filter(|_| !extended.unidentified.contains(&j)) {
                    self.set_interval(&estimate.name, step.map(|s| estimate.value + s));
                }
            }
        }
        self.note_limits(refitted, extended);
        self.evidence.refitted = Some(refitted.clone());
        if self.verdict != Verdict::CauseFound {
            return Ok(());
        }
        self.evidence.extended = Some(extended.clone());
        let model = ExtendedModel::new(study.system(), extended)?;
        self.notes.extend(model.notes.iter().map(|note| format!("extended model: {note}")));
        self.evidence.model = Some(model);
        let at_refitted = study.linearize(refitted, &[], &all)?;
        let fitted = Fitted { refitted, at_refitted: &at_refitted, extended, at_extended: &at_extended };
        match measure_gain(study, &fitted, validate, settings)? {
            Some((gain, held_out)) => {
                if gain.equation_error_after.is_none() {
                    self.notes.push(format!("no force error: {NO_FORCE}"));
                }
                self.gain = Some(gain);
                if extended.effects.is_empty() {
                    let note = "gain: only parameters are wrong, so that `before` is the model as given";
                    self.notes.push(note.to_owned());
                }
                self.evidence.held_out = Some(held_out);
            }
            None => self.notes.push("the data are too short to measure the gain on a part of their own".to_owned()),
        }
        Ok(())
    }

    /// Says which numbers stopped at a limit and which the data do not tell: neither has an interval.
    fn note_limits(&mut self, refitted: &Fit, extended: &Fit) {
        for (fit, which) in [(extended, ""), (refitted, " of the model without causes")] {
            if !which.is_empty() && extended.effects.is_empty() {
                continue;
            }
            for estimate in fit.limited.iter().filter_map(|&j| fit.values.get(j)) {
                self.notes.push(format!(
                    "{}{which} stopped at its limit, {}: the best value lies there or beyond; a wider min or max in the model \
                     file, or a value nearer to the truth, lets it move on",
                    estimate.name,
                    significant(estimate.value, 4)
                ));
            }
        }
        let hardly: Vec<&str> =
            extended.unidentified.iter().filter_map(|&j| extended.values.get(j)).map(|e| e.name.as_str()).collect();
        if !hardly.is_empty() {
            self.notes.push(format!("the data hardly tell {}: no interval", hardly.join(", ")));
        }
    }

    fn set_interval(&mut self, name: &str, interval: [f64; 2]) {
        for p in self.parameters.iter_mut().filter(|p| p.name == name) {
            p.interval = Some(interval);
        }
        for (_, value) in self.causes.iter_mut().flat_map(|c| &mut c.parameters).filter(|(n, _)| n == name) {
            value.interval = Some(interval);
        }
    }
}
