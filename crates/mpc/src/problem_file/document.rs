//! A problem file as a whole: its keys, the models it names, and the problem it states.

use super::horizon::KEYS as HORIZON_KEYS;
use super::reader::Reader;
use crate::ocp::Ocp;
use crate::problem::{ControlProblem, ProblemError};
use crate::qp::QpSettings;
use bracketry_symbolic::StopFlag;
use bracketry_system::Table;
use bracketry_system::{Document, FileError, System};
use std::path::Path;

const KEYS: [&str; 17] = [
    "name",
    "model",
    "plant",
    "horizon",
    "cost",
    "parameters",
    "references",
    "constraints",
    "target",
    "scale",
    "trust",
    "guess",
    "initial_guess",
    "solve",
    "estimation",
    "run",
    "about",
];

/// Most intervals of a horizon.
const MOST_INTERVALS: usize = 20_000;

impl ControlProblem {
    /// Reads a problem file; the model is looked for beside it.
    ///
    /// # Errors
    /// [`ProblemError`] with the place in the file and the remedy.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, ProblemError> {
        let path = path.as_ref();
        let doc = Document::read(path)?;
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        Self::from_document(&doc, &folder, |name| System::read(folder.join(name)).map_err(Box::new))
    }

    /// Reads a problem from text; `models` finds the models that it names.
    ///
    /// # Errors
    /// As [`ControlProblem::read`].
    pub fn parse(
        file: &str,
        text: &str,
        models: impl FnMut(&str) -> Result<System, Box<FileError>>,
    ) -> Result<Self, ProblemError> {
        let folder = Path::new(file).parent().unwrap_or(Path::new(""));
        Self::from_document(&Document::new(file, text), folder, models)
    }

    fn from_document(
        doc: &Document,
        folder: &Path,
        mut models: impl FnMut(&str) -> Result<System, Box<FileError>>,
    ) -> Result<Self, ProblemError> {
        let table = doc.table()?;
        doc.only_keys(&table, &KEYS, "a problem file")?;
        let Some(model) = doc.string(&table, "model")? else {
            return Err(doc.missing("no model is named", "add `model = \"model.toml\"` at the top").into());
        };
        let mut system = with_own_inputs(models(&model)?)?;
        system.leaves_time_free(doc)?;
        let original = system.clone();
        Reader { doc, system: &original }.fixed_parameters(&table, &mut system)?;
        let mut plant = match doc.string(&table, "plant")? {
            Some(name) => with_own_inputs(models(&name)?)?,
            None => system.clone(),
        };
        if plant.state_names() != system.state_names() || plant.input_names() != system.input_names() {
            let names =
                |s: &System| format!("states {}, inputs {}", s.state_names().join(" "), s.input_names().join(" "));
            let message =
                format!("model and plant differ: {} in the model, {} in the plant", names(&system), names(&plant));
            return Err(doc.missing(message, "give both the same states and inputs in the same order").into());
        }
        let reader = Reader { doc, system: &system };
        if let Some(run) = doc.sub_table(&table, "run")? {
            reader.plant_parameters(run, &mut plant)?;
        }
        let mut problem = reader.problem(&table, folder, plant)?;
        if let Some(e) = problem.estimation.as_ref().filter(|e| e.hands_over()) {
            if !problem.live.is_empty() {
                let message = "time-varying parameters cannot be combined with an estimator that updates parameters";
                return Err(doc.missing(message, "make one of them constant").into());
            }
            (problem.live, problem.system) = (e.problem.live_parameters(), e.problem.controller_model()?);
        }
        let checked = problem.ocp.check(problem.system.states.len(), problem.system.inputs.len());
        checked.map_err(|e| doc.missing(e.to_string(), "change the value that it names"))?;
        Ok(problem)
    }
}

/// A system without derivatives of inputs: integrators in front of those that have them.
fn with_own_inputs(system: System) -> Result<System, ProblemError> {
    if system.input_derivatives.is_empty() { Ok(system) } else { Ok(system.affinize()?.system) }
}

impl Reader<'_> {
    fn problem(&self, table: &Table<'_>, folder: &Path, plant: System) -> Result<ControlProblem, ProblemError> {
        let system = self.system;
        let (n, m) = (system.states.len(), system.inputs.len());
        let horizon = self.required(table, "horizon", "[horizon] with steps and dt")?;
        self.doc.only_keys(horizon, &HORIZON_KEYS, "[horizon]")?;
        let steps = self.count(horizon, "steps", None)?;
        if let Some(v) = horizon.get("steps").filter(|_| steps > MOST_INTERVALS) {
            let message = format!("a horizon of {steps} intervals makes programs too large to solve at every sample");
            let remedy = format!("take at most {MOST_INTERVALS}, with a longer dt");
            return Err(self.doc.error(v.span(), message, remedy).into());
        }
        let dt = self.positive(horizon, "dt", None)?;
        let mut ocp = Ocp::new(n, m, steps, dt);
        self.discretization(horizon, &mut ocp)?;

        let (run, start) = self.run(table, steps)?;
        let live = self.parameters(table, start.samples + steps, &mut ocp)?;
        let names = self.references(table, start.samples + steps, &live, &mut ocp)?;
        self.costs(table, &names, &mut ocp)?;
        self.ranges(&mut ocp);
        self.constraints(table, &names, &mut ocp)?;
        let mut guess = self.guess(table, &ocp)?;
        self.initial_guess(table, folder, &ocp, &mut guess)?;
        let level = self.expected_sizes(&start.x0, &guess, &mut ocp)?;
        self.targets(table, &mut ocp)?;
        self.scales(table, &mut ocp)?;
        Self::default_penalties(level, &mut ocp);
        self.end_of_horizon(table, &live, level, &mut ocp)?;
        let estimation = self.estimation(table, &start, &ocp)?;
        let measured = estimation.as_ref().map_or_else(|| system.state_names(), |e| e.names.clone());
        let conditions = self.conditions(run, &measured)?;
        // The multiplier of a bound cannot well exceed what the whole horizon costs.
        let hard_weight = (10.0 * dt * level).max(QpSettings::default().hard_weight);
        let empty = Table::new();
        let solve = self.doc.sub_table(table, "solve")?.unwrap_or(&empty);
        let solve = self.solve(solve, hard_weight, &ocp.input_bounds)?;
        Ok(ControlProblem {
            method: solve.method,
            qp: solve.qp,
            smoothing: solve.smoothing,
            policy: solve.policy,
            rest_input: solve.rest_input,
            live,
            guess,
            x0: start.x0,
            samples: start.samples,
            plant_substeps: start.plant_substeps.unwrap_or(ocp.substeps.least()),
            conditions,
            estimation,
            stop: StopFlag::default(),
            system: system.clone(),
            plant,
            ocp,
        })
    }
}
