//! The text of a transformation: comments above a model file, or why there is none.

use bracketry_lie::forms::{
    Block, BlockKind, Form, FormNote, FormOutcome, NormalForm, Obstacle, Part, PartKind, Transformation,
};
use bracketry_lie::{Function, Named};
use bracketry_system::{WriteError, readable};

/// The form in words.
pub(super) fn form_name(form: Form) -> &'static str {
    match form {
        Form::Brunovsky => "Brunovsky form",
        Form::ByrnesIsidori => "Byrnes–Isidori form",
        Form::Kalman => "Kalman decomposition",
        Form::Accessible => "decomposition by accessibility",
        Form::Observable => "decomposition by observability",
        Form::Observer => "observer form",
        Form::Flat => "flat parametrization",
        Form::Chained => "chained form",
    }
}

/// A note as a sentence.
pub(super) fn note(n: &FormNote) -> String {
    match n {
        FormNote::OutputOmitted { output } => {
            format!("the output {output} has no closed form in the new coordinates and is omitted")
        }
        FormNote::RangesLost => "the old inputs have ranges, which are not transferred to the new inputs".to_owned(),
        FormNote::ParameterValues => "the change was confirmed for the given parameter values only".to_owned(),
        FormNote::Linearized => "the model is not linear: this is its linear approximation at the point".to_owned(),
        FormNote::Branch { through } => {
            let at: Vec<String> = through.iter().map(|(name, v)| format!("{name} = {}", readable(*v))).collect();
            format!("the inverse has several branches: this is the one through {}", at.join(", "))
        }
        FormNote::InternalDrivenByInputs => {
            "inputs enter the equations of the internal states: no coordinates without them were found".to_owned()
        }
        FormNote::Extended => {
            "the old states are those of the model with integrators in front of inputs (part `extended`): a dynamic \
             feedback"
                .to_owned()
        }
        FormNote::OutputChanged { output, function } => {
            format!("the first coordinate is a function of the output {output}: {}", function.text())
        }
        FormNote::NoZeroDynamics { why } => format!("no zero dynamics: {why}"),
    }
}

/// What to do where a form was not found.
pub(super) fn next_step(why: &Obstacle) -> Option<&'static str> {
    Some(match why {
        Obstacle::NotAffine { .. } => "make the model affine first: bracketry affinize MODEL > affine.toml",
        Obstacle::Switches { .. } => "transform the equations of one mode, with each sign replaced by 1 or -1",
        Obstacle::Delay { .. } => "remove [delays] to see the form without the delay",
        Obstacle::DependentInputs { .. } => "remove redundant inputs",
        Obstacle::NotSquare { .. } | Obstacle::NotSingle { .. } => "choose outputs with --output NAME",
        Obstacle::NoLinearizingOutputs | Obstacle::CoordinatesNotFound { .. } => {
            "name a candidate function in [outputs] or [definitions]: these are tried first"
        }
        Obstacle::NoFlatOutputs { .. } | Obstacle::FlatnessOpen { .. } => {
            "name candidate flat outputs in [outputs] or [definitions]: these are tried first"
        }
        Obstacle::OutputInjection { .. } | Obstacle::InputInjection { .. } => {
            "try another output (--output), or an extended Kalman filter: [estimation] in a problem file"
        }
        Obstacle::NotObservable { .. } => "see what the outputs determine: bracketry transform MODEL --to observable",
        Obstacle::NoInverse { .. } => "give a point near which to invert (--at), or simpler states",
        Obstacle::NotAtRest { .. } => "find an equilibrium first: bracketry trim MODEL --out out",
        Obstacle::Irrational => "choose a point with rational values, or use bracketry linearize for numbers",
        Obstacle::NoOutputs => "add a table [outputs]",
        Obstacle::NotInvolutive { .. } | Obstacle::NoRelativeDegree { .. } => {
            "check for a dynamic feedback: bracketry analyze MODEL reports the dynamic extension and flatness"
        }
        _ => return None,
    })
}

fn block(b: &Block) -> String {
    let what = match &b.kind {
        BlockKind::Chain => "chain of integrators".to_owned(),
        BlockKind::Output { output } => format!("output {output} with its derivatives"),
        BlockKind::Internal { free_of_inputs: true } => "internal, without inputs".to_owned(),
        BlockKind::Internal { free_of_inputs: false } => "internal".to_owned(),
        BlockKind::ControllableObservable => "controllable and observable".to_owned(),
        BlockKind::ControllableUnobservable => "controllable, not observable".to_owned(),
        BlockKind::UncontrollableObservable => "observable, not controllable".to_owned(),
        BlockKind::UncontrollableUnobservable => "neither controllable nor observable".to_owned(),
        BlockKind::Accessible => "accessible".to_owned(),
        BlockKind::Inaccessible => "influenced by no input".to_owned(),
        BlockKind::Observable => "observable".to_owned(),
        BlockKind::Unobservable => "not observable".to_owned(),
        BlockKind::Observer => format!("linear up to functions of {} and the inputs", b.states[0]),
        BlockKind::FlatOutput => "flat output with its derivatives".to_owned(),
        BlockKind::Chained => "chained form".to_owned(),
    };
    format!("{}: {what}", b.states.join(", "))
}

fn list(heading: &str, functions: &Named<Function>, lines: &mut Vec<String>) {
    if functions.is_empty() {
        return;
    }
    lines.push(heading.to_owned());
    lines.extend(functions.0.iter().map(|(name, e)| format!("  {name} = {}", e.text())));
}

fn found(form: &NormalForm) -> Vec<String> {
    let mut lines = Vec::new();
    list("new states", &form.coordinates, &mut lines);
    match &form.inverse {
        Some(inverse) => list("old states", inverse, &mut lines),
        None => lines.push("the old states were not found as functions of the new ones in closed form".to_owned()),
    }
    list("feedback", &form.feedback, &mut lines);
    list("new inputs", &form.new_inputs, &mut lines);
    list("feedback that makes the last derivatives new inputs", &form.linearizing_feedback, &mut lines);
    lines.extend(form.blocks.iter().map(block));
    match &form.singular_set {
        Some(set) if set.is_nowhere() => lines.push("nowhere singular".to_owned()),
        Some(set) => lines.push(format!("singular where {set}")),
        None => lines.push("the singular set is too large to print".to_owned()),
    }
    if let Some(valid) = &form.inverse_valid {
        lines.push(format!("the formulas of the old states hold where {valid}"));
    }
    match form.regular_at_point {
        Some(true) => lines.push("regular at the point".to_owned()),
        Some(false) => lines.push("singular at the point: the form holds near generic points only".to_owned()),
        None => {}
    }
    lines.extend(form.notes.iter().map(|n| format!("note: {}", note(n))));
    lines.push("confirmed by transforming back".to_owned());
    lines
}

/// A transformation in lines: the change, its inverse, the feedback, and what limits them; or why there is no such form.
pub fn transformation_text(t: &Transformation) -> String {
    let name = form_name(t.form);
    let lines = match &t.outcome {
        FormOutcome::Found(form) => {
            let mut lines = vec![format!("{}: {name}", t.model)];
            lines.extend(found(form));
            lines
        }
        FormOutcome::Impossible(why) => reasons(&format!("{} has no {name}: {why}", t.model), why),
        FormOutcome::NotFound(why) => reasons(&format!("{}: {name} not found: {why}", t.model), why),
    };
    lines.join("\n") + "\n"
}

fn reasons(first: &str, why: &Obstacle) -> Vec<String> {
    let mut lines = vec![first.to_owned()];
    if let Obstacle::NoInverse { coordinates } = why {
        let list: Vec<String> = coordinates.iter().map(ToString::to_string).collect();
        lines.push(format!("  coordinates: {}", list.join(", ")));
    }
    lines.extend(next_step(why).map(|step| format!("  next: {step}")));
    lines
}

/// The model file of the form, below the text as comments.
///
/// # Errors
/// [`WriteError`] for an equation that is too long to be written out.
pub fn transformation_model(t: &Transformation, form: &NormalForm) -> Result<String, WriteError> {
    let comments: Vec<String> = transformation_text(t).lines().map(|l| format!("# {l}")).collect();
    Ok(format!("{}\n{}", comments.join("\n"), form.system.to_toml()?))
}

/// The model file of a part.
///
/// # Errors
/// [`WriteError`] for an equation that is too long to be written out.
pub fn part_text(part: &Part) -> Result<String, WriteError> {
    let what = match part.kind {
        PartKind::ZeroDynamics => "zero dynamics: the motion that remains while inputs hold the outputs",
        PartKind::Minimal => "the controllable and observable part: a minimal realization",
        PartKind::Inaccessible => "the part that no input influences",
        PartKind::Observable => "the part that the outputs determine",
        PartKind::Extended => "the model with integrators in front of inputs: a dynamic feedback",
    };
    Ok(format!("# {what}\n{}", part.system.to_toml()?))
}
