//! `bracketry affinize`.

use std::path::PathBuf;

use anyhow::Context;
use bracketry::report::analysis::{AffinizationReport, candidates, changes};
use bracketry::system::{Candidate, System};
use clap::Args;
use serde_json::json as object;

use super::limits::TimeLimit;
use super::output::{folder, json, line, print, write};
use super::style::{error, warning};
use super::{CommonArgs, Outcome};

/// Shown by the help.
pub(crate) const EXAMPLES: [(&str, &str); 2] = [
    ("The affine model as a model file", "bracketry affinize models/plate_published.toml > plate_affine.toml"),
    ("Another of the listed candidates", "bracketry affinize models/plate_published.toml --candidate 1"),
];

/// Arguments of `affinize`.
#[derive(Args)]
pub(crate) struct AffinizeArgs {
    /// Model file (TOML)
    #[arg(value_hint = clap::ValueHint::FilePath)]
    pub(crate) model: PathBuf,
    /// Use the listed candidate with this number instead of the one that adds the fewest states
    #[arg(long, allow_negative_numbers = true, value_name = "K")]
    candidate: Option<usize>,
    #[command(flatten)]
    pub(crate) time_limit: TimeLimit,
}

/// Writes the affine model as a model file, below a list of all candidates.
pub(crate) fn affinize(args: &AffinizeArgs, output: &CommonArgs) -> anyhow::Result<Outcome> {
    let path = args.model.display().to_string();
    let mut system = output.limits.read(&args.model)?;
    system.pool.set_deadline(output.limits.deadline());
    let mut affinization = match system.affinize() {
        Ok(found) => found,
        Err(why) => {
            error(&format!("{path}: {why}"));
            return Ok(Outcome::Negative);
        }
    };
    // Of what is printed nothing is to be left out.
    let unlimited = affinization.candidates.iter_mut().filter_map(|c| c.system.as_mut());
    for made in unlimited.chain([&mut affinization.system]) {
        made.pool.set_deadline(None);
    }
    if system.pool.reached_limit().is_some() {
        warning("time or memory limit reached: expressions may not be simplified (--time-limit, --memory-limit)");
    }
    let report = AffinizationReport::new(&affinization, None);
    let candidate = args.candidate.map(|k| numbered(&affinization.candidates, k).context(path)).transpose()?;
    let chosen = candidate.map_or(&affinization.system, |c| c.1);
    let text = chosen.to_toml()?;
    if let Some(dir) = &output.out {
        folder(dir)?;
        write(&dir.join("affine.toml"), &text)?;
    }
    if output.json {
        print(&match candidate {
            None => json(&report)?,
            Some((candidate, model)) => json(&object!({"candidate": candidate, "model": model}))?,
        })?;
        return Ok(Outcome::Done);
    }
    let mut comments = candidates(&affinization, candidate.map(|c| c.0));
    if candidate.is_none_or(|c| c.0.chosen) {
        comments.extend(changes(&affinization));
    }
    for comment in comments {
        line(&format!("# {comment}"))?;
    }
    print(&text)?;
    Ok(Outcome::Done)
}

/// A candidate by its number from 1, with its affine system.
fn numbered(candidates: &[Candidate], k: usize) -> anyhow::Result<(&Candidate, &System)> {
    let candidate = k.checked_sub(1).and_then(|k| candidates.get(k)).with_context(|| {
        format!(
            "--candidate {k}: there {}",
            match candidates.len() {
                1 => "is 1 candidate".to_owned(),
                n => format!("are {n} candidates, numbered from 1"),
            }
        )
    })?;
    let system = candidate.system.as_ref();
    let system = system.with_context(|| format!("--candidate {k} was rejected: {}", candidate.why))?;
    Ok((candidate, system))
}
