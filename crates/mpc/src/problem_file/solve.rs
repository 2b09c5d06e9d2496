//! How a problem file wants to be solved.

use super::reader::{Parsed, Reader};
use crate::controller::{Brake, FailurePolicy};
use crate::problem::{Convergence, Feedback, Method, MethodReason};
use crate::qp::{ProgramForm, QpSettings};
use crate::sqp::Hessian;
use bracketry_system::{Table, Value};

const KEYS: [&str; 18] = [
    "method",
    "initial_iterations",
    "iterations",
    "max_iterations",
    "tolerance",
    "hessian",
    "qp_tolerance",
    "backend",
    "block",
    "smoothing",
    "margin",
    "proximal",
    "guarded",
    "time_limit",
    "policy",
    "brake",
    "brake_after",
    "rest",
];

/// Settings that only one method has.
const SETTINGS_OF_ONE: [(&str, Name); 6] = [
    ("initial_iterations", Name::Rti),
    ("iterations", Name::Rti),
    ("time_limit", Name::Rti),
    ("proximal", Name::Rti),
    ("guarded", Name::Rti),
    ("hessian", Name::Sqp),
];

/// What the table `[solve]` says.
pub(super) struct Solve {
    pub(super) method: Method,
    pub(super) qp: QpSettings,
    pub(super) smoothing: Vec<f64>,
    pub(super) policy: FailurePolicy,
    pub(super) rest_input: Vec<f64>,
}

/// Names of the methods.
#[derive(Clone, Copy, PartialEq)]
enum Name {
    Automatic,
    Rti,
    Sqp,
    Plan,
    StickSlip,
}

/// Names of the failure policies.
#[derive(Clone, Copy)]
enum PolicyName {
    Shift,
    Brake,
    Rest,
}

impl Reader<'_> {
    /// The table `[solve]`, and why it has this method: it names it, or has a setting of it alone. Where anything is free, it is
    /// `planned`.
    pub(super) fn solve(
        &self,
        solve: &Table<'_>,
        hard_weight: f64,
        input_bounds: &[(f64, f64)],
        planned: bool,
    ) -> Parsed<(Solve, MethodReason)> {
        self.doc.only_keys(solve, &KEYS, "[solve]")?;
        let methods = [("rti", Name::Rti), ("sqp", Name::Sqp), ("plan", Name::Plan), ("stick-slip", Name::StickSlip)];
        let named = self.choice(solve, "method", "method", &methods)?;
        let other = self.system.period.is_some() || !self.system.algebraic.is_empty();
        if let Some(v) = solve.get("method").filter(|_| named == Name::StickSlip && other) {
            let message = "the method \"stick-slip\" follows x' = f(x, u); the model is discrete in time or has algebraic variables";
            let remedy = "write method = \"rti\", \"sqp\", or \"plan\", or remove it";
            return Err(self.doc.error(v.span(), message, remedy).into());
        }
        let with = |name: Name| self.solve_by(name, solve, hard_weight, input_bounds);
        if planned {
            if let Some(v) = solve.get("method").filter(|_| named != Name::Plan) {
                let message = "this method has a moving horizon: it cannot optimize an end time, a parameter, or an initial state";
                let remedy = "write method = \"plan\", or remove it; or fix the free values";
                return Err(self.doc.error(v.span(), message, remedy).into());
            }
            if solve.contains_key("method") {
                return Ok((with(named)?, MethodReason::Given));
            }
            // Without the margin and the coarse tolerance of a plan that is asked for: what is found is the optimum.
            let plan = with(Name::Plan)?;
            let mut solved = with(Name::Sqp)?;
            if let (Method::Sqp { convergence, .. }, Method::Plan { feedback, .. }) = (solved.method, plan.method) {
                let margin = self.not_negative(solve, "margin", 0.0)?;
                solved.method = Method::Plan { convergence, margin, feedback };
            }
            return Ok((solved, MethodReason::Free));
        }
        let setting = SETTINGS_OF_ONE.into_iter().find(|(key, _)| solve.contains_key(*key));
        let (name, reason) = match setting {
            _ if solve.contains_key("method") => (named, MethodReason::Given),
            Some((key, name)) => (name, MethodReason::Setting { key: key.into() }),
            None => (Name::Automatic, MethodReason::Given),
        };
        Ok((with(name)?, reason))
    }

    /// The table `[solve]` for a method. Every key is checked, also where the method does not use it.
    fn solve_by(&self, name: Name, solve: &Table<'_>, hard_weight: f64, input_bounds: &[(f64, f64)]) -> Parsed<Solve> {
        let planned = name == Name::Plan;
        let initial_iterations = self.count(solve, "initial_iterations", Some(1))?;
        let mut feedback = Feedback { iterations: self.count(solve, "iterations", Some(1))?, ..Feedback::default() };
        let convergence = Convergence {
            max_iterations: self.count(solve, "max_iterations", Some(100))?,
            tolerance: self.positive(solve, "tolerance", Some(if planned { 1e-2 } else { 1e-8 }))?,
            defect_tolerance: if planned { 1e-3 } else { 1e-6 },
            hessian: self.hessian(solve, name)?,
        };
        let tolerance = self.positive(solve, "qp_tolerance", Some(1e-8))?;
        let smoothing = self.smoothing(solve)?;
        let margin = self.not_negative(solve, "margin", if planned { 0.05 } else { 0.0 })?;
        for (key, value, remedy) in [
            ("margin", margin, "write the share of the bounds reserved for the feedback, such as 0.05"),
            ("tolerance", convergence.tolerance, "write the relative cost decrease at which to stop, such as 1e-8"),
        ] {
            if let Some(v) = solve.get(key).filter(|_| value >= 1.0) {
                return Err(self.doc.error(v.span(), format!("`{key}` must be below 1"), remedy).into());
            }
        }
        feedback.proximal = self.not_negative(solve, "proximal", if planned { 0.5 } else { 0.0 })?;
        feedback.guarded = self.boolean(solve, "guarded", planned)?;
        let backend = self.backend(solve)?;
        feedback.time_limit = self.positive(solve, "time_limit", Some(f64::INFINITY))?;
        if let Some(v) = solve.get("time_limit").filter(|_| matches!(name, Name::Sqp | Name::StickSlip)) {
            let message = "`time_limit` applies to the methods \"rti\" and \"plan\" only";
            return Err(self.doc.error(v.span(), message, "lower max_iterations instead, or change the method").into());
        }
        Ok(Solve {
            method: match name {
                Name::Automatic => Method::Automatic { convergence },
                Name::Rti => Method::Rti { initial_iterations, feedback },
                Name::Sqp => Method::Sqp { convergence, first: feedback },
                Name::Plan => Method::Plan { convergence, margin, feedback },
                Name::StickSlip => {
                    Method::StickSlip { iterations: feedback.iterations.max(convergence.max_iterations) }
                }
            },
            qp: QpSettings { form: backend, tolerance, hard_weight, ..QpSettings::default() },
            smoothing,
            rest_input: self.rest(solve, input_bounds)?,
            policy: self.policy(solve)?,
        })
    }

    /// The input of rest; empty where the file has none.
    fn rest(&self, solve: &Table<'_>, input_bounds: &[(f64, f64)]) -> Parsed<Vec<f64>> {
        let Some(t) = self.doc.sub_table(solve, "rest")? else { return Ok(Vec::new()) };
        let mut rest: Vec<f64> = input_bounds.iter().map(|b| 0f64.clamp(b.0, b.1)).collect();
        for (key, v) in t {
            let j = self.input(key.get_ref(), key.span())?;
            let value = self.constant(v, key.get_ref())?;
            let (min, max) = input_bounds[j];
            if !(min..=max).contains(&value) {
                let message = format!("`{}` at rest is outside its bounds", key.get_ref());
                return Err(self.doc.error(v.span(), message, format!("choose from {min} to {max}")).into());
            }
            rest[j] = value;
        }
        Ok(rest)
    }

    /// The second derivatives of the programs of a converged solution.
    fn hessian(&self, solve: &Table<'_>, method: Name) -> Parsed<Hessian> {
        let hessians =
            [("automatic", Hessian::Automatic), ("gauss-newton", Hessian::GaussNewton), ("exact", Hessian::Exact)];
        let hessian = self.choice(solve, "hessian", "Hessian", &hessians)?;
        let unused = hessian == Hessian::Exact && !matches!(method, Name::Sqp | Name::Plan);
        if let Some(v) = solve.get("hessian").filter(|_| unused) {
            let message = "this method does not use the exact Hessian: `hessian` applies to the methods \"sqp\" and \"plan\" only";
            let remedy = match SETTINGS_OF_ONE.iter().find(|(key, _)| solve.contains_key(*key)) {
                Some((key, _)) if !solve.contains_key("method") => {
                    format!("`{key}` chooses \"rti\": remove it, or write method = \"sqp\"; or remove `hessian`")
                }
                _ => "write method = \"sqp\" or \"plan\", or remove `hessian`".to_owned(),
            };
            return Err(self.doc.error(v.span(), message, remedy).into());
        }
        Ok(hessian)
    }

    /// The form in which the quadratic programs are solved.
    fn backend(&self, solve: &Table<'_>) -> Parsed<ProgramForm> {
        let in_blocks = matches!(self.doc.string(solve, "backend")?.as_deref(), Some("stagewise" | "condensed"));
        if let Some(v) = solve.get("block").filter(|_| !in_blocks) {
            let remedy = "add backend = \"stagewise\" or \"condensed\"";
            return Err(self
                .doc
                .error(v.span(), "`block` applies to the backends \"stagewise\" and \"condensed\" only", remedy)
                .into());
        }
        let block = if in_blocks { self.count(solve, "block", Some(1_000_000))? } else { 0 };
        let forms = [
            ("automatic", ProgramForm::Automatic),
            ("stagewise", ProgramForm::Stagewise { block }),
            ("sparse", ProgramForm::Sparse),
            ("condensed", ProgramForm::Condensed { block }),
        ];
        self.choice(solve, "backend", "backend", &forms)
    }

    /// What is applied when a sample has no solution.
    fn policy(&self, solve: &Table<'_>) -> Parsed<FailurePolicy> {
        let policies = [("shift", PolicyName::Shift), ("brake", PolicyName::Brake), ("rest", PolicyName::Rest)];
        let named = self.choice(solve, "policy", "policy", &policies)?;
        let brakes = self.doc.sub_table(solve, "brake")?;
        let implied = brakes.is_some() && !solve.contains_key("policy");
        let policy = match if implied { PolicyName::Brake } else { named } {
            PolicyName::Shift => FailurePolicy::ShiftedInput,
            PolicyName::Brake => {
                let after = self.whole(solve, "brake_after", 0)?;
                FailurePolicy::BrakeToRest { after, brakes: self.brakes(brakes, solve)? }
            }
            PolicyName::Rest => FailurePolicy::RestInput,
        };
        let brakes_are_used = matches!(policy, FailurePolicy::BrakeToRest { .. });
        for key in ["brake", "brake_after"] {
            if let Some(v) = solve.get(key).filter(|_| !brakes_are_used) {
                let message = format!("`{key}` is not used by this policy");
                return Err(self.doc.error(v.span(), message, "write policy = \"brake\", or remove it").into());
            }
        }
        Ok(policy)
    }

    fn brakes(&self, brakes: Option<&Table<'_>>, solve: &Table<'_>) -> Parsed<Vec<Brake>> {
        let remedy = "write brake = { u = { velocity = \"v\", rate = 10 } }: u = rest - rate*v";
        let Some(t) = brakes else {
            let span = solve.get("policy").map_or(0..0, toml::Spanned::span);
            return Err(self.doc.error(span, "the table `brake` is missing", remedy).into());
        };
        let mut list = Vec::new();
        for (key, v) in t {
            let input = self.input(key.get_ref(), key.span())?;
            let Value::Table(entry) = v.get_ref() else {
                return Err(self.doc.error(v.span(), "a brake must be a table", remedy).into());
            };
            self.doc.only_keys(entry, &["velocity", "rate"], "a brake")?;
            let (Some(name), Some(place)) = (self.doc.string(entry, "velocity")?, entry.get("velocity")) else {
                return Err(self.doc.error(v.span(), "the brake names no velocity", remedy).into());
            };
            let velocity = self.state(&name, place.span())?;
            if !entry.contains_key("rate") {
                return Err(self.doc.error(v.span(), "the brake has no rate", remedy).into());
            }
            list.push(Brake { input, velocity, rate: self.not_negative(entry, "rate", 0.0)? });
        }
        Ok(list)
    }

    /// The widths of smoothing; empty where the file has none.
    fn smoothing(&self, solve: &Table<'_>) -> Parsed<Vec<f64>> {
        let Some(v) = solve.get("smoothing") else { return Ok(Vec::new()) };
        let mut widths = Vec::new();
        match v.get_ref() {
            Value::Array(list) => {
                for w in list {
                    widths.push(self.constant(w, "smoothing")?);
                }
            }
            _ => widths.push(self.constant(v, "smoothing")?),
        }
        if widths.is_empty() || widths.iter().any(|w| *w <= 0.0) {
            let remedy = "give a positive width, or a list of them from wide to narrow";
            return Err(self.doc.error(v.span(), "`smoothing` must be positive", remedy).into());
        }
        if widths.windows(2).any(|w| w[1] >= w[0]) {
            let remedy = "order the widths from wide to narrow, each once: the loop uses the last";
            return Err(self.doc.error(v.span(), "`smoothing` does not decrease", remedy).into());
        }
        Ok(widths)
    }
}
