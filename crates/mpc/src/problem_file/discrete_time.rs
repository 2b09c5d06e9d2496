//! Models that are discrete in time or have algebraic variables: what their problems may say.

use super::free::Free;
use super::reader::{Parsed, Reader};
use crate::integrator::Integrator;
use crate::ocp::{Ocp, Substeps};
use bracketry_system::{System, Table};

/// Fraction of a period by which the sampling period may differ from a multiple of it: both are rounded.
const ROUNDING: f64 = 1e-9;

impl Reader<'_> {
    /// Refuses what a model that is discrete in time or has algebraic variables cannot do.
    pub(super) fn suits_the_model(
        &self,
        table: &Table<'_>,
        system: &System,
        plant: &System,
        free: &Free,
    ) -> Parsed<()> {
        let place = |key: &str| table.get(key).map_or(0..0, toml::Spanned::span);
        if !system.algebraic.is_empty() && table.contains_key("estimation") {
            let message = "the estimators support algebraic variables only if they can be eliminated";
            return Err(self
                .doc
                .error(place("estimation"), message, "remove [estimation]: the states are then measured")
                .into());
        }
        if system.period.is_none() {
            return Ok(());
        }
        if !system.is_smooth() {
            let message = "a discrete-time controller model must be smooth, without `sign`, `abs`, `min`, and `max`";
            let remedy = "write limits in [constraints], and name a model that has them as `plant`";
            return Err(self.doc.error(place("model"), message, remedy).into());
        }
        if free.end_time.is_some() {
            let message = "the end time of a discrete-time model cannot be free";
            return Err(self.doc.error(place("horizon"), message, "give steps and dt").into());
        }
        if table.contains_key("estimation") {
            let message = "the estimators support continuous-time models only; this model is discrete in time";
            let remedy = "remove [estimation] to measure the states, or write the model in continuous time";
            return Err(self.doc.error(place("estimation"), message, remedy).into());
        }
        let run = self.doc.sub_table(table, "run")?;
        let chosen = run.is_some_and(|run| run.contains_key("plant_substeps"));
        if plant.period.is_none() && plant.is_smooth() && !chosen {
            let message = "the plant is continuous in time and the model discrete, so the integration of the plant is not \
                 defined";
            let remedy = "add plant_substeps = 20 to [run]: Runge–Kutta steps of the plant per sample";
            return Err(self.doc.error(place("plant"), message, remedy).into());
        }
        Ok(())
    }

    /// The horizon of a model that is discrete in time: `dt` is a multiple of its period, and nothing is integrated.
    pub(super) fn steps_of_the_map(&self, horizon: &Table<'_>, period: f64, ocp: &mut Ocp) -> Parsed<()> {
        for key in ["integrator", "stages", "substeps", "growth", "lengths"] {
            if let Some(v) = horizon.get(key) {
                let message =
                    format!("`{key}` does not apply: the model is discrete in time, with a period of {period}");
                return Err(self.doc.error(v.span(), message, "write steps and dt alone, with dt the period").into());
            }
        }
        ocp.integrator = Integrator::Map;
        ocp.substeps = Substeps::Fixed(self.periods(horizon, period, ocp.dt, "model")?);
        self.blocks(horizon, ocp)
    }

    /// The sampling period is a multiple of the period of a plant that is discrete in time.
    pub(super) fn steps_of_the_plant(&self, horizon: &Table<'_>, plant: &System, dt: f64) -> Parsed<()> {
        match plant.period {
            Some(period) => self.periods(horizon, period, dt, "plant").map(|_| ()),
            None => Ok(()),
        }
    }

    /// How many periods of the model or plant a sample lasts.
    fn periods(&self, horizon: &Table<'_>, period: f64, dt: f64, whose: &str) -> Parsed<usize> {
        let ratio = dt / period;
        if ratio.round() >= 1.0 && (ratio - ratio.round()).abs() <= ROUNDING * ratio.max(1.0) {
            return Ok(ratio.round() as usize);
        }
        let place = ["dt", "end_time", "lengths"].into_iter().find_map(|key| horizon.get(key));
        let message =
            format!("the {whose} is discrete in time with a period of {period}, and dt = {dt} is not a multiple of it");
        let remedy = format!("write dt = {period}, or a multiple of it, over which the input is held");
        Err(self.doc.error(place.map_or(0..0, toml::Spanned::span), message, remedy).into())
    }
}
