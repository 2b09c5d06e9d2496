//! A problem file as a whole: its keys, the models it names, and the problem it states.

use super::free::Free;
use super::horizon::{KEYS as HORIZON_KEYS, MOST_INTERVALS};
use super::reader::Reader;
use super::scaling::Expected;
use super::tree::Tree;
use crate::ocp::{Ocp, Remembered, Substeps};
use crate::problem::{ControlProblem, FoundValues, FreeValues, Method, ProblemError, Schedule};
use crate::qp::QpSettings;
use bracketry_symbolic::StopFlag;
use bracketry_system::Table;
use bracketry_system::{Accepted, Document, FileError, System};
use std::path::{Path, PathBuf};
use std::sync::Arc;

const KEYS: [&str; 20] = [
    "name",
    "model",
    "plant",
    "horizon",
    "cost",
    "parameters",
    "live_parameters",
    "references",
    "constraints",
    "target",
    "periodic",
    "scale",
    "trust",
    "guess",
    "initial_guess",
    "solve",
    "estimation",
    "run",
    "uncertainty",
    "about",
];

impl ControlProblem {
    /// Reads a problem file; the model is looked for beside it.
    ///
    /// # Errors
    /// [`ProblemError`] with the place in the file and the remedy.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, ProblemError> {
        let path = path.as_ref();
        let doc = Document::read(path)?;
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        let models = |name: &str| {
            System::read_accepting(folder.join(name), Accepted { discrete: true, algebraic: true }).map_err(Box::new)
        };
        Arc::new(Source::new(doc, &folder, models)?).problem(None)
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
        Arc::new(Source::new(Document::new(file, text), folder, models)?).problem(None)
    }
}

/// A problem file with the models that it names.
struct Source {
    doc: Document,
    folder: PathBuf,
    model: System,
    plant: Option<System>,
}

impl Source {
    fn new(
        doc: Document,
        folder: &Path,
        mut models: impl FnMut(&str) -> Result<System, Box<FileError>>,
    ) -> Result<Self, ProblemError> {
        let table = doc.table()?;
        doc.only_keys(&table, &KEYS, "a problem file")?;
        let Some(model) = doc.string(&table, "model")? else {
            return Err(doc.missing("no model is named", "add `model = \"model.toml\"` at the top").into());
        };
        let model = with_own_inputs(models(&model)?)?;
        model.leaves_time_free(&doc)?;
        let plant = doc.string(&table, "plant")?;
        let plant = plant.map(|name| with_own_inputs(models(&name)?)).transpose()?;
        drop(table);
        Ok(Self { doc, folder: folder.to_owned(), model, plant })
    }

    /// The problem, with the values that were found for what is free.
    fn problem(self: &Arc<Self>, found: Option<&FoundValues>) -> Result<ControlProblem, ProblemError> {
        let doc = &self.doc;
        let table = doc.table()?;
        let mut system = self.model.clone();
        let original = system.clone();
        let remembered = Remembered::default();
        let first = Reader {
            doc,
            system: &original,
            folder: &self.folder,
            remembered: &remembered,
            free: None,
            tree: None,
            branch: 0,
        };
        first.fixed_parameters(&table, &mut system)?;
        let horizon = first.required(&table, "horizon", "[horizon] with steps and dt")?;
        let free = first.free(&table, horizon)?;
        free.fix(found, &mut system);
        let mut plant = self.plant.clone().unwrap_or_else(|| system.clone());
        if plant.state_names() != system.state_names() || plant.input_names() != system.input_names() {
            let names =
                |s: &System| format!("states {}, inputs {}", s.state_names().join(" "), s.input_names().join(" "));
            let message =
                format!("model and plant differ: {} in the model, {} in the plant", names(&system), names(&plant));
            return Err(doc.missing(message, "give both the same states and inputs in the same order").into());
        }
        first.suits_the_model(&table, &system, &plant, &free)?;
        let reader = Reader { system: &system, ..first };
        let tree = reader.uncertainty(&table)?;
        if let Some(v) = table.get("uncertainty").filter(|_| tree.is_some() && !system.algebraic.is_empty()) {
            let message = "a scenario tree copies the model, but its algebraic variables cannot be eliminated";
            let remedy = "write equations that are linear in them, or remove the parameters of [uncertainty]";
            return Err(doc.error(v.span(), message, remedy).into());
        }
        if let Some(v) = table.get("periodic").filter(|_| tree.is_some()) {
            let message = "periodic states cannot be combined with uncertain parameters";
            return Err(doc.error(v.span(), message, "remove `periodic`, or the parameters of [uncertainty]").into());
        }
        if let Some(v) = table.get("uncertainty").filter(|_| !free.is_empty()) {
            let message = "uncertainty cannot be combined with free values";
            return Err(doc.error(v.span(), message, "fix the free values, or remove [uncertainty]").into());
        }
        let reader = Reader { tree: tree.as_ref(), ..reader };
        if let Some(run) = doc.sub_table(&table, "run")? {
            reader.plant_parameters(run, &mut plant)?;
        }
        let end_time = free.end_time.as_ref().map(|r| found.and_then(|f| f.end_time).unwrap_or(r.guess));
        let values = Values { end_time, free: &free, found };
        let mut problem = reader.problem(&table, plant.clone(), values, !free.is_empty())?;
        if !free.is_empty() && found.is_none() {
            let varying = reader.varying_parameters(&table)?;
            let system = free.system(&system, &varying);
            let reader = Reader { system: &system, free: Some(&free), ..first };
            let extended = reader.problem(&table, plant, values, true)?;
            let source = Arc::clone(self);
            let with_found = Box::new(move |found: &FoundValues| source.problem(Some(found)));
            let end_time = free.end_time.as_ref().map(|r| r.guess);
            problem.free = Some(Arc::new(FreeValues::new(extended, &free.names(), end_time, with_found)));
        }
        problem.found = found.cloned();
        if let Some(e) = problem.estimation.take_if(|e| e.hands_over()) {
            if let Some(v) = table.get("uncertainty") {
                let message = "uncertainty cannot be combined with an estimator that updates the model";
                let remedy = "remove `parameters` and `disturbances` of [estimation], or [uncertainty]";
                return Err(doc.error(v.span(), message, remedy).into());
            }
            if !problem.live.is_empty() {
                let message = "time-varying parameters cannot be combined with an estimator that updates parameters";
                return Err(doc.missing(message, "make one of them constant").into());
            }
            problem.set_estimation(e)?;
        }
        let checked = problem.ocp.check(problem.system.states.len(), problem.system.inputs.len());
        let checked = checked.map_err(|e| e.with_names(&problem.system.state_names(), &problem.system.input_names()));
        checked.map_err(|e| doc.missing(e.to_string(), "change the value that it names"))?;
        Ok(problem)
    }
}

/// A system without derivatives of inputs: integrators in front of those that have them.
fn with_own_inputs(system: System) -> Result<System, ProblemError> {
    if system.input_derivatives.is_empty() { Ok(system) } else { Ok(system.affinize()?.system) }
}

/// What the values of a problem's free constants are: those found, or the guess.
#[derive(Clone, Copy)]
struct Values<'a> {
    /// End time, s, where it is free.
    end_time: Option<f64>,
    free: &'a Free,
    found: Option<&'a FoundValues>,
}

impl Reader<'_> {
    /// The problem with these values of what is free; `planned` where anything is.
    fn problem(
        &self,
        table: &Table<'_>,
        plant: System,
        values: Values<'_>,
        planned: bool,
    ) -> Result<ControlProblem, ProblemError> {
        // One branch first; the other ones are like it.
        let (tree, this) = (self.tree, Reader { tree: None, ..*self });
        this.problem_of_one(table, plant, values, planned, tree)
    }

    fn problem_of_one(
        &self,
        table: &Table<'_>,
        plant: System,
        values: Values<'_>,
        planned: bool,
        tree: Option<&Tree>,
    ) -> Result<ControlProblem, ProblemError> {
        let system = self.system;
        let (n, m) = (system.states.len(), system.inputs.len());
        let horizon = self.required(table, "horizon", "[horizon] with steps and dt")?;
        self.doc.only_keys(horizon, &HORIZON_KEYS, "[horizon]")?;
        let others: [(&str, &[&str]); 2] = [("steps", &["lengths"]), ("dt", &["lengths", "end_time"])];
        for (key, instead) in others {
            let missing = !horizon.contains_key(key) && !instead.iter().any(|k| horizon.contains_key(*k));
            if let Some(v) = table.get("horizon").filter(|_| missing) {
                let remedy =
                    "write horizon = { steps = 40, dt = 0.05 }: number of intervals and their length in seconds";
                return Err(self.doc.error(v.span(), format!("[horizon] has no `{key}`"), remedy).into());
            }
        }
        let lengths = self.lengths(horizon)?;
        let steps = if horizon.contains_key("lengths") {
            lengths.len()
        } else {
            self.count_up_to(horizon, "steps", None, MOST_INTERVALS)?
        };
        let place = horizon.get("steps").or(horizon.get("lengths"));
        if let Some(v) = place.filter(|_| steps > MOST_INTERVALS) {
            let message = format!("a horizon of {steps} intervals makes programs too large to solve at every sample");
            let remedy = format!("use at most {MOST_INTERVALS}, with a longer dt");
            return Err(self.doc.error(v.span(), message, remedy).into());
        }
        let dt = match lengths.first() {
            Some(first) => *first,
            None => self.interval(horizon, steps, values.end_time)?,
        };
        let mut ocp = Ocp::new(n, m, steps, dt);
        if lengths.iter().any(|l| *l != dt) {
            ocp.lengths = lengths;
        }
        match system.period {
            Some(period) => self.steps_of_the_map(horizon, period, &mut ocp)?,
            None => self.discretization(horizon, &mut ocp)?,
        }
        self.steps_of_the_plant(horizon, &plant, dt)?;

        let no_run = Table::new();
        let (run, mut start) = self.run(table, &no_run, steps)?;
        values.free.start(values.found, system, &mut start.x0);
        let points = start.samples + ocp.samples_of_horizon();
        let schedule = Schedule {
            parameters: self.parameters(table, points, dt)?,
            references: self.references(table, points, dt)?,
        };
        schedule.write(&mut ocp, 0, points);
        let live = Schedule::names(&schedule.parameters);
        // Costs and constraints see the live parameters change.
        let names = [live.clone(), Schedule::names(&schedule.references)].concat();
        if let Some(free) = self.free {
            free.bound(&mut ocp);
        }
        let mut remembered = self.input_rates(table, dt)?;
        if let Some(free) = self.free {
            free.remember(&ocp, &mut remembered);
        }
        if let Some(input) = remembered.time_scale {
            schedule.scale_time(&mut ocp, input, points);
        }
        self.same_lengths(horizon, &ocp, !remembered.inputs.is_empty(), "rates of inputs")?;
        let reader = Reader { remembered: &remembered, ..*self };
        remembered.inputs.iter().for_each(|&j| ocp.remember(j));
        let costs = reader.costs(table, &names, &mut ocp)?;
        let references = reader.reference_uses(table, &schedule.references, &names)?;
        self.ranges(&mut ocp);
        reader.constraints(table, &names, &mut ocp)?;
        self.starts_within_bounds(run, &mut ocp)?;
        let mut guess = self.guess(table, &ocp)?;
        self.initial_guess(table, &ocp, &mut guess)?;
        if let Some(free) = self.free {
            free.guess(&mut guess);
        }
        let Expected { cost_level: level, explicit_steps, long_interval } =
            self.expected_sizes(&start.x0, &guess, &mut ocp)?;
        self.targets(table, &mut ocp)?;
        reader.periodic(table, &start.x0, &names, &mut ocp)?;
        self.scales(table, &mut ocp)?;
        Self::default_penalties(level, &mut ocp);
        self.end_of_horizon(table, &live, level, &mut ocp)?;
        let chance = match self.free {
            // The values found are put into the file, which is read once more.
            Some(_) => None,
            None => reader.chance(table, &names, &live, (&start.x0, &guess[0]), &mut ocp)?,
        };
        self.check_what_is_asked(table, costs, &ocp, planned)?;
        // The problem that is solved for what is free sees the initial state alone.
        let estimation = if self.free.is_some() { None } else { self.estimation(table, &start, &ocp)? };
        let measured = estimation.as_ref().map_or_else(|| system.state_names(), |e| e.names.clone());
        let conditions = self.conditions(run, start.samples, &measured)?;
        if planned && !start.given {
            let message = "[run] is missing: free values are found for an initial state";
            return Err(self.doc.missing(message, "add [run] with x0").into());
        }
        // The multiplier of a bound cannot well exceed what the whole horizon costs.
        let hard_weight = (10.0 * dt * level).max(QpSettings::default().hard_weight);
        let empty = Table::new();
        let solve_table = self.doc.sub_table(table, "solve")?.unwrap_or(&empty);
        let (mut solve, method_reason) = self.solve(solve_table, hard_weight, &ocp.input_bounds, planned)?;
        self.finite_rest(solve_table, &ocp, &mut solve.rest_input)?;
        let plans = matches!(solve.method, Method::Plan { .. });
        self.same_lengths(
            horizon,
            &ocp,
            plans,
            "the method \"plan\", which shortens the horizon interval by interval,",
        )?;
        if let Some(v) = table.get("uncertainty").filter(|_| matches!(solve.method, Method::StickSlip { .. })) {
            let message = "the method \"stick-slip\" has no scenario tree";
            return Err(self.doc.error(v.span(), message, "write method = \"rti\", \"sqp\", or \"plan\"").into());
        }
        let mut problem = ControlProblem {
            method: solve.method,
            method_reason,
            qp: solve.qp,
            smoothing: solve.smoothing,
            policy: solve.policy,
            rest_input: solve.rest_input,
            live,
            schedule,
            references,
            remarks: long_interval.into_iter().collect(),
            guess,
            x0: start.x0,
            has_run: start.given,
            u0: self.input_before(run, &ocp)?,
            samples: start.samples,
            plant_substeps: start.plant_substeps.unwrap_or(match ocp.substeps {
                Substeps::Fixed(s) => s,
                Substeps::AtLeast(s) => s.max(explicit_steps),
            }),
            conditions,
            estimation,
            stop: StopFlag::default(),
            free: None,
            chance,
            scenarios: None,
            compiled: None,
            found: None,
            system: system.clone(),
            plant,
            ocp,
        };
        if let Some(tree) = tree {
            let reader = Reader { remembered: &remembered, ..*self };
            problem.scenarios = Some(Arc::new(reader.scenarios(table, tree, &problem, &names, level)?));
        }
        Ok(problem)
    }
}
