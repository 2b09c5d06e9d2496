//! `bracketry export`.

use std::path::PathBuf;

use anyhow::Context;
use bracketry::export::{ExportOptions, KeptParameters, Target, export};
use bracketry::report::export::{export_json, export_text};
use bracketry::system::System;
use clap::Args;

use super::output::{folder, json, print, write};
use super::{CommonArgs, Outcome};

/// Shown by the help.
pub(crate) const EXAMPLES: [(&str, &str); 3] = [
    ("C source and header", "bracketry export models/cart_pole.toml --language c --out out"),
    (
        "CasADi functions with two parameters as arguments",
        "bracketry export models/cart_pole.toml --language casadi --parameters M,m --out out",
    ),
    ("Print a Julia module", "bracketry export models/two_link_arm.toml --language julia --parameters all"),
];

/// Arguments of `export`.
#[derive(Args)]
pub(crate) struct ExportArgs {
    /// Model file (TOML)
    #[arg(value_hint = clap::ValueHint::FilePath)]
    pub(crate) model: PathBuf,
    /// Language: c (C99, header and source), rust (module), python (NumPy), casadi (Python, casadi.Function), julia (module)
    #[arg(long, value_name = "LANGUAGE")]
    language: Target,
    /// Parameters that become arguments of the functions, or `all`; the others are constants with their values
    #[arg(long, value_name = "NAMES|all", value_delimiter = ',')]
    parameters: Vec<String>,
    /// Name of module and files, and prefix of C functions, instead of that of the model
    #[arg(long, value_name = "NAME")]
    name: Option<String>,
}

/// Prints the source, or writes its files into a folder and prints what they hold.
pub(crate) fn run(args: &ExportArgs, output: &CommonArgs) -> anyhow::Result<Outcome> {
    let system = System::read(&args.model)?;
    let options = ExportOptions {
        target: args.language,
        parameters: KeptParameters::from_names(args.parameters.clone()),
        name: args.name.clone(),
    };
    let made = export(&system, &options).with_context(|| args.model.display().to_string())?;
    if let Some(dir) = &output.out {
        folder(dir)?;
        for file in &made.files {
            write(&dir.join(&file.name), &file.text)?;
        }
    }
    print(&match (output.json, &output.out) {
        (true, _) => json(&export_json(&made))?,
        (false, Some(_)) => export_text(&made),
        (false, None) => made.single,
    })?;
    Ok(Outcome::Done)
}
