//! What a transformation hands back.

use std::str::FromStr;

use bracketry_symbolic::{Function, Named, closest_name};
use bracketry_system::System;
use serde::Serialize;

use crate::condition::Condition;
use crate::error::Error;
use crate::evidence::Evidence;
use crate::forms::obstacle::Obstacle;

/// A form that a system can be brought into.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Form {
    /// Chains of integrators, by static feedback (Brunovsky).
    Brunovsky,
    /// Outputs with their derivatives, and internal states (Byrnes and Isidori).
    ByrnesIsidori,
    /// Controllable and observable parts of a linear system (Kalman).
    Kalman,
    /// The accessible part, and the functions that no input influences.
    Accessible,
    /// The observable part, and the states that no output tells.
    Observable,
    /// Linear up to functions of the output and the inputs (Krener and Isidori).
    Observer,
    /// States and inputs as functions of flat outputs and their derivatives.
    Flat,
    /// z1' = v1, z2' = v2, z3' = z2 v1, … for two inputs without drift (Murray and Sastry).
    Chained,
}

impl Form {
    /// All forms.
    pub const ALL: [Form; 8] = [
        Form::Brunovsky,
        Form::ByrnesIsidori,
        Form::Kalman,
        Form::Accessible,
        Form::Observable,
        Form::Observer,
        Form::Flat,
        Form::Chained,
    ];

    /// Its name in commands.
    pub fn name(self) -> &'static str {
        match self {
            Form::Brunovsky => "brunovsky",
            Form::ByrnesIsidori => "byrnes-isidori",
            Form::Kalman => "kalman",
            Form::Accessible => "accessible",
            Form::Observable => "observable",
            Form::Observer => "observer",
            Form::Flat => "flat",
            Form::Chained => "chained",
        }
    }
}

/// A name that is no form.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{name}` is not a form: {remedy}")]
pub struct UnknownForm {
    /// The name.
    pub name: String,
    /// What to write instead.
    pub remedy: String,
}

impl FromStr for Form {
    type Err = UnknownForm;

    fn from_str(name: &str) -> Result<Self, UnknownForm> {
        let wanted = name.replace('_', "-");
        Form::ALL.into_iter().find(|f| f.name() == wanted).ok_or_else(|| {
            let known: Vec<&str> = Form::ALL.into_iter().map(Form::name).collect();
            let remedy = match closest_name(&wanted, known.iter().copied()) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("write one of {}", known.join(", ")),
            };
            UnknownForm { name: name.to_owned(), remedy }
        })
    }
}

/// What a group of new states is.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum BlockKind {
    /// A function with its derivatives, of which the last is a new input.
    Chain,
    /// An output with its derivatives.
    Output {
        /// Its name.
        output: String,
    },
    /// What the outputs leave open.
    Internal {
        /// Whether no input enters its equations directly.
        free_of_inputs: bool,
    },
    /// Controllable and observable.
    ControllableObservable,
    /// Controllable, not observable.
    ControllableUnobservable,
    /// Observable, not controllable.
    UncontrollableObservable,
    /// Neither controllable nor observable.
    UncontrollableUnobservable,
    /// Accessible.
    Accessible,
    /// What no input influences.
    Inaccessible,
    /// Told by the outputs.
    Observable,
    /// Told by no output.
    Unobservable,
    /// Linear up to functions of the first of these states and the inputs.
    Observer,
    /// A flat output with its derivatives.
    FlatOutput,
    /// The states of a chained form.
    Chained,
}

/// A group of new states.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Block {
    /// What it is.
    #[serde(flatten)]
    pub kind: BlockKind,
    /// Its states.
    pub states: Vec<String>,
}

/// What a system is that is part of the form.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum PartKind {
    /// The motion left while the outputs are held at zero.
    ZeroDynamics,
    /// The controllable and observable part: a minimal realization.
    Minimal,
    /// The part that no input influences.
    Inaccessible,
    /// The part that the outputs tell.
    Observable,
    /// The model with the integrators of a dynamic feedback, whose states the new coordinates are functions of.
    Extended,
}

impl PartKind {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            PartKind::ZeroDynamics => "zero_dynamics",
            PartKind::Minimal => "minimal",
            PartKind::Inaccessible => "inaccessible",
            PartKind::Observable => "observable",
            PartKind::Extended => "extended",
        }
    }
}

/// A system of its own within the form.
#[derive(Clone, Debug)]
pub struct Part {
    /// What it is.
    pub kind: PartKind,
    /// Its equations.
    pub system: System,
}

/// What limits a form.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum FormNote {
    /// An output has no closed form in the new coordinates and is omitted.
    OutputOmitted {
        /// Its name.
        output: String,
    },
    /// The old inputs have ranges, which the new inputs do not show.
    RangesLost,
    /// The change holds for the given values of the parameters, and maybe for no others.
    ParameterValues,
    /// The form is that of the linear approximation at the point.
    Linearized,
    /// The inverse is the branch through this point.
    Branch {
        /// The old states there.
        through: Vec<(String, f64)>,
    },
    /// The internal coordinates could not be chosen such that no input enters their equations.
    InternalDrivenByInputs,
    /// Coordinates and feedback are those of the model with integrators in front of inputs, a dynamic feedback.
    Extended,
    /// The first coordinate is a function of the output in place of the output itself.
    OutputChanged {
        /// Its name.
        output: String,
        /// ψ(y), as a function of the state.
        function: Function,
    },
    /// The motion left while the outputs are held was not found.
    NoZeroDynamics {
        /// Why.
        why: Obstacle,
    },
}

/// A system in new coordinates.
#[derive(Clone, Debug)]
pub struct NormalForm {
    /// The equations in the new coordinates.
    pub system: System,
    /// Each new state as a function of the old ones, z = T(x).
    pub coordinates: Named<Function>,
    /// Each old state as a function of the new ones; none if that was not found in closed form.
    pub inverse: Option<Named<Function>>,
    /// Each old input as a function of old states and new inputs; empty if the inputs stay.
    pub feedback: Named<Function>,
    /// The feedback that would turn the last derivatives of the outputs into new inputs v1, v2, …, where the form keeps the old
    /// inputs; empty for other forms.
    pub linearizing_feedback: Named<Function>,
    /// Each new input as a function of old states and inputs; empty if the inputs stay.
    pub new_inputs: Named<Function>,
    /// Where change or feedback is singular.
    pub singular_set: Option<Condition>,
    /// Where the formulas of the inverse hold, besides: what they divide by.
    pub inverse_valid: Option<Condition>,
    /// Whether the change and the feedback are regular at the model's point; none without a point, or where that is open.
    pub regular_at_point: Option<bool>,
    /// Groups of the new states, in their order.
    pub blocks: Vec<Block>,
    /// Systems within.
    pub parts: Vec<Part>,
    /// What limits the result.
    pub notes: Vec<FormNote>,
}

/// How a transformation ended.
#[derive(Clone, Debug)]
pub enum FormOutcome {
    /// The form, confirmed by transforming back.
    Found(Box<NormalForm>),
    /// There is no such form near a generic point.
    Impossible(Obstacle),
    /// It was not found; it may exist.
    NotFound(Obstacle),
}

/// A transformation of a model.
#[derive(Clone, Debug)]
pub struct Transformation {
    /// Name of the model.
    pub model: String,
    /// The form that was asked for.
    pub form: Form,
    /// How it ended.
    pub outcome: FormOutcome,
    /// What the exact decisions rest on.
    pub certificate: Evidence,
    /// Wall-clock time.
    pub seconds: f64,
}

impl Transformation {
    /// The form, if it was found.
    pub fn found(&self) -> Option<&NormalForm> {
        match &self.outcome {
            FormOutcome::Found(form) => Some(form),
            FormOutcome::Impossible(_) | FormOutcome::NotFound(_) => None,
        }
    }
}

/// A transformation that could not be attempted.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TransformError {
    /// An output that the model does not have.
    #[error("the model has no output `{name}`: {remedy}")]
    UnknownOutput {
        /// The name.
        name: String,
        /// What to write instead.
        remedy: String,
    },
    /// An output that is given twice.
    #[error("the output `{name}` is given twice: remove one")]
    Twice {
        /// The name.
        name: String,
    },
    /// The model cannot be analyzed.
    #[error(transparent)]
    Lie(#[from] Error),
    /// The equations divide by zero everywhere.
    #[error(transparent)]
    Denominator(#[from] bracketry_system::ZeroDenominator),
}
