//! The estimator of a problem file.

use super::conditions::Start;
use super::reader::{Key, Located, Parsed, Reader};
use crate::estimation::{
    Disturbance, DisturbanceChannel, EstimatedParameter, EstimationProblem, MeasuredOutput, MovingHorizonSettings,
    Outliers,
};
use crate::ocp::{Ocp, VectorFunction};
use crate::problem::{Estimation, EstimatorKind};
use bracketry_system::{Table, Value};

const KEYS: [&str; 11] = [
    "kind",
    "horizon",
    "iterations",
    "outputs",
    "initial",
    "initial_std",
    "process_noise",
    "parameters",
    "disturbances",
    "outliers",
    "smoothing",
];
/// Default process noise over one second, and default standard deviation of the initial state, in units of a state's scale.
const DEFAULT_NOISE: f64 = 0.01;
const DEFAULT_STD: f64 = 0.1;

/// Most intervals that an estimator looks back on: its programs grow with them, at every sample.
const MOST_INTERVALS: usize = 5000;

impl Reader<'_> {
    /// The table `[estimation]`.
    pub(super) fn estimation(&self, table: &Table<'_>, start: &Start, ocp: &Ocp) -> Parsed<Option<Estimation>> {
        let Some(t) = self.doc.sub_table(table, "estimation")? else { return Ok(None) };
        let place = table.get("estimation").map_or(0..0, toml::Spanned::span);
        self.doc.only_keys(t, &KEYS, "[estimation]")?;
        let kinds = [("mhe", EstimatorKind::MovingHorizon), ("ekf", EstimatorKind::ExtendedKalman)];
        let kind = self.choice(t, "kind", "estimator", &kinds)?;
        let mut problem = EstimationProblem::new(self.system, ocp.dt, &start.x0);
        problem.integrator = ocp.integrator;
        problem.substeps = ocp.substeps;
        problem.smoothing = self.positive(t, "smoothing", Some(problem.smoothing))?;
        problem.initial_std = ocp.state_scale[..ocp.model_states()].iter().map(|s| DEFAULT_STD * s).collect();
        problem.process_noise = ocp.state_scale[..ocp.model_states()].iter().map(|s| DEFAULT_NOISE * s).collect();
        for (key, list, least) in [
            ("initial", &mut problem.initial, f64::NEG_INFINITY),
            ("initial_std", &mut problem.initial_std, 0.0),
            ("process_noise", &mut problem.process_noise, 0.0),
        ] {
            for (name, v) in self.doc.sub_table(t, key)?.into_iter().flatten() {
                let value = self.constant(v, name.get_ref())?;
                if value < least {
                    let message = format!("`{key}` of `{}` must not be negative", name.get_ref());
                    return Err(self.doc.error(v.span(), message, "give a standard deviation, 0 or more").into());
                }
                list[self.state(name.get_ref(), name.span())?] = value;
            }
        }
        if t.contains_key("outliers") {
            problem.outliers = Outliers::Huber(self.positive(t, "outliers", None)?);
        }
        let mut names = Vec::new();
        let remedy = "add [estimation.outputs] with name = standard deviation of its noise";
        let Some(outputs) = self.doc.sub_table(t, "outputs")? else {
            return Err(self.doc.missing("the estimator has no measurements", remedy).into());
        };
        for (key, v) in outputs {
            problem.outputs.push(self.output(key, v)?);
            names.push(key.get_ref().to_string());
        }
        if names.is_empty() {
            return Err(self.doc.missing("the estimator has no measurements", remedy).into());
        }
        self.read_parameters(t, &mut problem)?;
        self.read_disturbances(t, &names, &mut problem)?;
        for key in ["horizon", "iterations"] {
            if let Some(v) = t.get(key).filter(|_| kind != EstimatorKind::MovingHorizon) {
                let message = format!("an extended Kalman filter has no `{key}`");
                return Err(self.doc.error(v.span(), message, "write kind = \"mhe\", or remove it").into());
            }
        }
        // A run never looks back on more intervals than it has samples.
        let horizon = self.count(t, "horizon", Some(MovingHorizonSettings::default().horizon))?.min(start.samples);
        if let Some(v) = t.get("horizon").filter(|_| horizon > MOST_INTERVALS) {
            let message = format!("the estimation horizon exceeds {MOST_INTERVALS} intervals");
            return Err(self.doc.error(v.span(), message, "use fewer: 10 to 50 are usual").into());
        }
        let settings = MovingHorizonSettings {
            horizon,
            iterations: self.count(t, "iterations", Some(1))?,
            ..MovingHorizonSettings::default()
        };
        let estimation = Estimation { kind, problem, settings, names };
        if let Err(e) = estimation.estimator() {
            let remedy =
                "change `outputs`, `parameters`, or `disturbances`: they define what is measured and estimated";
            return Err(self.doc.error(place, e.to_string(), remedy).into());
        }
        Ok(Some(estimation))
    }

    /// The parameters that are estimated.
    fn read_parameters(&self, t: &Table<'_>, problem: &mut EstimationProblem) -> Parsed<()> {
        for (key, v) in self.doc.sub_table(t, "parameters")?.into_iter().flatten() {
            let name = key.get_ref();
            let known = self.system.parameter_names();
            if !known.iter().any(|k| k == name) {
                return Err(self.unknown(name, key.span(), "parameter", &known));
            }
            let (std, walk, min, max) = self.walk(v, name)?;
            problem.parameters.push(EstimatedParameter { name: name.to_string(), std, walk, min, max });
        }
        Ok(())
    }

    /// The disturbances that are estimated; `names` are those of the outputs.
    fn read_disturbances(&self, t: &Table<'_>, names: &[String], problem: &mut EstimationProblem) -> Parsed<()> {
        for (key, v) in self.doc.sub_table(t, "disturbances")?.into_iter().flatten() {
            let name = key.get_ref().to_string();
            let channel = if self.system.input_index(&name).is_some() {
                DisturbanceChannel::Input(name)
            } else if self.system.state_index(&name).is_some() {
                DisturbanceChannel::State(name)
            } else if let Some(i) = names.iter().position(|n| *n == name) {
                DisturbanceChannel::Output(i)
            } else {
                let mut known = self.system.input_names();
                known.extend(self.system.state_names());
                return Err(self.unknown(&name, key.span(), "input, state, or output", &known));
            };
            let (std, walk, min, max) = self.walk(v, key.get_ref())?;
            problem.disturbances.push(Disturbance { channel, std, walk, min, max });
        }
        Ok(())
    }

    /// A measured output: the standard deviation of its noise, or a table with it.
    fn output(&self, key: &Key<'_>, v: Located<'_, '_>) -> Parsed<MeasuredOutput> {
        let name = key.get_ref();
        let mut output = MeasuredOutput::new(name.to_string(), 0.0);
        if let Value::Table(t) = v.get_ref() {
            self.doc.only_keys(t, &["std", "period", "expression"], "a measured output")?;
            output.std = self.positive(t, "std", None)?;
            output.period = t.contains_key("period").then(|| self.positive(t, "period", None)).transpose()?;
            if let Some(text) = self.doc.string(t, "expression")? {
                output.expression = text;
            }
        } else {
            output.std = self.constant(v, name)?;
            if output.std <= 0.0 {
                let message = format!("the noise of `{name}` must be positive");
                let remedy = "for an exact output give a tiny one, 1e-6 of its range";
                return Err(self.doc.error(v.span(), message, remedy).into());
            }
        }
        if let Err(e) = VectorFunction::parse(self.system, &[], &[&output.expression]) {
            let remedy = "measure a state, an output of the model, or give expression = \"…\"";
            return Err(self.doc.error(key.span(), e.to_string(), remedy).into());
        }
        Ok(output)
    }

    /// Standard deviation at the start, random walk, bounds.
    fn walk(&self, v: Located<'_, '_>, name: &str) -> Parsed<(f64, f64, f64, f64)> {
        let Value::Table(t) = v.get_ref() else {
            let remedy = format!("write {name} = {{ std = 0.1, walk = 0.01 }}");
            return Err(self.doc.error(v.span(), format!("the entry of `{name}` must be a table"), remedy).into());
        };
        self.doc.only_keys(t, &["std", "walk", "min", "max"], "what is estimated")?;
        let end = |key: &str, free: f64| self.number(t, key, Some(free)).map(|n| n.0);
        let (min, max) = (end("min", f64::NEG_INFINITY)?, end("max", f64::INFINITY)?);
        if min > max {
            let message = format!("the bounds of `{name}` contradict each other: min {min} > max {max}");
            return Err(self.doc.error(v.span(), message, "exchange them").into());
        }
        Ok((self.not_negative(t, "std", 0.0)?, self.not_negative(t, "walk", 0.0)?, min, max))
    }
}
