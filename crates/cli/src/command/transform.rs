//! `bracketry transform`.

use std::path::{Path, PathBuf};

use anyhow::Context;
use bracketry::lie::forms::{Form, NormalForm, TransformOptions, Transformation};
use bracketry::lie::transform as transformed;
use bracketry::report::forms::{part_text, transformation_json, transformation_model, transformation_text};
use clap::Args;

use super::limits::TimeLimit;
use super::output::{folder, json, print, write};
use super::progress::spinner;
use super::{CommonArgs, Outcome};

/// Shown by the help.
pub(crate) const EXAMPLES: [(&str, &str); 3] = [
    (
        "Feedback linearization as a model file",
        "bracketry transform models/flexible_joint.toml --to brunovsky > chain.toml",
    ),
    (
        "Outputs, internal states, and zero dynamics",
        "bracketry transform models/tora.toml --to byrnes-isidori --out out",
    ),
    ("Controllable and observable parts", "bracketry transform models/quadruple_tank.toml --to kalman --json"),
];

/// Arguments of `transform`.
#[derive(Args)]
pub(crate) struct TransformArgs {
    /// Model file (TOML)
    #[arg(value_hint = clap::ValueHint::FilePath)]
    pub(crate) model: PathBuf,
    /// Form: brunovsky (chains of integrators by static feedback), byrnes-isidori (outputs with their derivatives, internal
    /// states, zero dynamics), kalman (controllable and observable parts), accessible (what no input influences, separated
    /// from the rest), observable (what the outputs determine, separated from the rest), observer (linear up to functions of the output), flat (states and inputs from flat outputs),
    /// chained (two inputs without drift)
    #[arg(long, value_name = "FORM")]
    to: Form,
    /// Point near which branches are chosen, instead of the model's, such as x=0.1,th=pi/2; unnamed states and inputs are 0
    #[arg(long, value_name = "NAME=VALUE,…")]
    at: Option<String>,
    /// Output for the form; by default all outputs of the model; may be repeated
    #[arg(long = "output", value_name = "NAME", value_delimiter = ',')]
    outputs: Vec<String>,
    #[command(flatten)]
    pub(crate) time_limit: TimeLimit,
}

/// Prints the model in another form, with the change, its inverse, and the feedback as comments.
pub(crate) fn transform(args: &TransformArgs, output: &CommonArgs) -> anyhow::Result<Outcome> {
    let mut system = output.limits.read(&args.model)?;
    if let Some(at) = &args.at {
        system.point = Some(bracketry::point(&mut system, at).context("--at")?);
    }
    let options = TransformOptions { outputs: args.outputs.clone(), time_limit: Some(args.time_limit.get()) };
    let progress = spinner(args.to.name());
    let result = transformed(&system, args.to, &options).with_context(|| args.model.display().to_string())?;
    progress.finish_and_clear();
    let text = match result.found() {
        Some(form) => transformation_model(&result, form)?,
        None => transformation_text(&result),
    };
    if let Some(out) = &output.out {
        save(&result, out, &text)?;
    }
    print(&if output.json { json(&transformation_json(&result))? } else { text })?;
    Ok(if result.found().is_some() { Outcome::Done } else { Outcome::Negative })
}

/// Writes the model to a file `….toml`, or the model, its parts, and the report to a folder.
fn save(result: &Transformation, out: &Path, text: &str) -> anyhow::Result<()> {
    if out.extension().is_some_and(|e| e == "toml") && !out.is_dir() {
        return match result.found() {
            Some(_) => write(out, text),
            None => Ok(()),
        };
    }
    folder(out)?;
    write(&out.join("transform.json"), &json(&transformation_json(result))?)?;
    write(&out.join("transform.txt"), &transformation_text(result))?;
    let Some(NormalForm { parts, .. }) = result.found() else { return Ok(()) };
    write(&out.join("transformed.toml"), text)?;
    for part in parts {
        write(&out.join(format!("{}.toml", part.kind.name())), &part_text(part)?)?;
    }
    Ok(())
}
