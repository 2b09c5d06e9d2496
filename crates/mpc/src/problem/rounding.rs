//! What it costs that inputs take values of finite sets alone.

use super::control_problem::ControlProblem;
use super::method::Method;
use super::notes::Note;
use super::open_loop::Rehearsal;
use super::verdict::floor;
use crate::closed_loop::ClosedLoop;
use crate::controller::{Controller, SumUpRounding};
use crate::error::MpcError;
use crate::trajectory::PlannedTrajectory;
use bracketry_symbolic::Named;
use serde::Serialize;

/// Share of the relaxed cost by which rounding adds to it that is worth mentioning.
const MUCH: f64 = 0.1;

/// Inputs of finite sets, and what rounding to them costs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RoundingReport {
    /// The values of every such input.
    pub inputs: Named<Vec<f64>>,
    /// Cost and penalties over the horizon of the inputs of the first plan, which lie between the values, on the controller's model.
    pub relaxed_cost: f64,
    /// The same with these inputs rounded.
    pub rounded_cost: f64,
    /// The second cost less the first one.
    pub gap: f64,
    /// Cost and penalties of the run over its first horizon; none where the run is shorter, or the intervals differ in length.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub loop_cost: Option<f64>,
    /// Largest |∫ (relaxed − rounded) dt| of an input over the run, in its unit times seconds.
    pub accumulated_error: f64,
}

impl ControlProblem {
    /// Whether any input takes values of a finite set alone.
    pub(super) fn has_finite_inputs(&self) -> bool {
        self.ocp.input_values.iter().any(|values| !values.is_empty())
    }

    /// What rounding costs; none where no input is rounded, or there is no plan. `run` has the previous inputs among its states.
    ///
    /// # Errors
    /// If the pieces of the problem do not fit together.
    pub(super) fn rounding_report(
        &self,
        controller: &dyn Controller,
        run: &ClosedLoop,
    ) -> Result<Option<RoundingReport>, MpcError> {
        let Some(plan) = controller.relaxed_plan() else { return Ok(None) };
        let mut rehearsal = match self.method {
            Method::StickSlip { .. } => Rehearsal::exact(self)?,
            _ => Rehearsal::smoothed(self)?,
        };
        let mut relaxed = plan.clone();
        let mut rounded = plan.clone();
        for (j, values) in self.ocp.input_values.iter().enumerate().filter(|(_, values)| !values.is_empty()) {
            let mut rounding = SumUpRounding::new(values)?;
            for k in 0..rounded.steps() {
                let u = &mut rounded.u_mut(k)[j];
                *u = rounding.round(*u, self.ocp.length(k));
            }
        }
        let (relaxed_cost, rounded_cost) = (rehearsal.cost(&mut relaxed), rehearsal.cost(&mut rounded));
        let steps = self.ocp.steps;
        let whole = self.ocp.is_uniform() && run.u.len() >= steps;
        let looped = whole.then(|| PlannedTrajectory::from_rows(&run.x[..=steps], &run.u[..steps])).transpose()?;
        let finite =
            self.ocp.input_values.iter().zip(self.system.input_names()).filter(|(values, _)| !values.is_empty());
        Ok(Some(RoundingReport {
            inputs: Named(finite.map(|(values, name)| (name, values.clone())).collect()),
            relaxed_cost,
            rounded_cost,
            gap: rounded_cost - relaxed_cost,
            loop_cost: looped.map(|z| self.value(&z)),
            accumulated_error: controller.figures().rounding_error.unwrap_or(0.0),
        }))
    }

    /// Says where rounding costs much.
    pub(super) fn note_on_rounding(&self, report: &RoundingReport) -> Option<Note> {
        let RoundingReport { relaxed_cost: relaxed, rounded_cost, loop_cost, .. } = *report;
        let rounded = loop_cost.map_or(rounded_cost, |cost| cost.max(rounded_cost));
        let much = MUCH * relaxed.abs() + floor(self, self.ocp.steps);
        // A cost that is no number is much, too.
        let cheap = rounded - relaxed <= much;
        (!cheap).then_some(Note::RoundingCosts { relaxed, rounded })
    }
}
