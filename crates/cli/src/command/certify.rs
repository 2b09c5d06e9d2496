//! `bracketry certify`.

use std::path::{Path, PathBuf};

use anyhow::Context;
use bracketry::certify::{Certificate, Certification, CertifyOptions, Find, certify, check, portrait, with_feedback};
use bracketry::report::certificates::{certification_json, certification_text, check_text, region_figure};
use bracketry::system::{System, point};
use clap::{Args, ValueEnum};
use serde_json::json as object;

use super::limits::{Limits, TimeLimit};
use super::output::{figure, folder, json, line, print, write};
use super::{CommonArgs, Outcome};

/// Shown by the help.
pub(crate) const EXAMPLES: [(&str, &str); 3] = [
    ("A region of attraction of the model's point", "bracketry certify models/duffing.toml --find region --out out"),
    (
        "The region of attraction of a closed loop, drawn",
        "bracketry certify cart.toml --with \"u=-2*x-3*v\" --find region --out out",
    ),
    ("Check a certificate from a file", "bracketry certify models/duffing.toml --check out/certificate_region.json"),
];

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Sought {
    /// A Lyapunov function on the whole space
    Lyapunov,
    /// A region of attraction
    Region,
    /// A storage function for inputs and outputs
    Passivity,
    /// Functions that are constant along all motions
    Conserved,
    /// All of them; passivity only where there are as many outputs as inputs
    All,
}

/// Arguments of `certify`.
#[derive(Args)]
pub(crate) struct CertifyArgs {
    /// Model file (TOML)
    #[arg(value_hint = clap::ValueHint::FilePath)]
    pub(crate) model: PathBuf,
    /// Equilibrium instead of the model's point, such as x=1/2,u=-1; unnamed states and inputs are 0
    #[arg(long, value_name = "NAME=VALUE,…")]
    at: Option<String>,
    /// Feedback that sets an input, such as u=-x-2*v; may be repeated
    #[arg(long = "with", value_name = "INPUT=EXPRESSION")]
    with: Vec<String>,
    /// What to find; several, separated by commas
    #[arg(long, value_enum, value_delimiter = ',', default_value = "all")]
    find: Vec<Sought>,
    /// Largest degree of the functions
    #[arg(long, default_value_t = 4, value_name = "2|4")]
    degree: u32,
    #[command(flatten)]
    pub(crate) time_limit: TimeLimit,
    /// The two states of the figure, the first two by default
    #[arg(long, value_name = "STATE,STATE", value_delimiter = ',')]
    axes: Vec<String>,
    /// Check a certificate written by this command against the model, without a search
    #[arg(long, value_name = "FILE", value_hint = clap::ValueHint::FilePath)]
    check: Option<PathBuf>,
}

impl CertifyArgs {
    /// The model at its point, with the loop closed.
    fn system(&self, limits: &Limits) -> anyhow::Result<System> {
        let mut system = limits.read(&self.model)?;
        if let Some(at) = &self.at {
            system.point = Some(point(&mut system, at).with_context(|| format!("--at {at}"))?);
        }
        let path = self.model.display().to_string();
        with_feedback(&system, &self.with).with_context(|| format!("{path}: --with {}", self.with.join(" --with ")))
    }

    fn options(&self, system: &System) -> CertifyOptions {
        let ports = !system.inputs.is_empty() && system.inputs.len() == system.outputs.len();
        let mut find = Vec::new();
        for sought in &self.find {
            match sought {
                Sought::Lyapunov => find.push(Find::Lyapunov),
                Sought::Region => find.push(Find::Region),
                Sought::Passivity => find.push(Find::Passivity),
                Sought::Conserved => find.push(Find::Conserved),
                Sought::All => {
                    find.extend([Find::Conserved, Find::Lyapunov, Find::Region]);
                    find.extend(ports.then_some(Find::Passivity));
                }
            }
        }
        let time_limit = Some(self.time_limit.get());
        CertifyOptions { find, degree: self.degree, time_limit, stop: system.pool.stop_flag().clone() }
    }

    /// Indices of the states of the picture; none for a model with one state.
    fn axes(&self, system: &System) -> anyhow::Result<Option<[usize; 2]>> {
        match &self.axes[..] {
            [] => Ok((system.states.len() > 1).then_some([0, 1])),
            [a, b] if a != b => {
                let index = |name: &String| {
                    let names = system.state_names().join(", ");
                    system
                        .state_index(name.trim())
                        .with_context(|| format!("--axes: `{name}` is not a state: the model has {names}"))
                };
                Ok(Some([index(a)?, index(b)?]))
            }
            _ => anyhow::bail!("--axes: give two different states, such as --axes x,v"),
        }
    }
}

/// Prints what is proved; with --out, also the certificates as files and the picture of a region.
pub(crate) fn run(args: &CertifyArgs, output: &CommonArgs) -> anyhow::Result<Outcome> {
    let system = args.system(&output.limits)?;
    if let Some(path) = &args.check {
        return check_file(&system, path, output);
    }
    let axes = args.axes(&system)?;
    let found = certify(&system, &args.options(&system)).context("--degree")?;
    let (text, value) = (certification_text(&found), json(&certification_json(&found))?);
    let mut written = Vec::new();
    if let Some(dir) = &output.out {
        folder(dir)?;
        write(&dir.join("certify.txt"), &text)?;
        write(&dir.join("certify.json"), &value)?;
        written = files(&found, dir)?;
        if let (Some(axes), Some(proof)) =
            (axes, found.region.as_ref().and_then(|f| f.proof()).filter(|p| p.level.is_some()))
        {
            let picture = portrait(&system, proof, axes)?;
            if figure(&region_figure(&system.name, &system.quantities, &picture), &dir.join("region")) {
                written.extend(["region.svg", "region.png"].map(str::to_owned));
            }
        }
    }
    print(if output.json { &value } else { &text })?;
    if let (Some(dir), false) = (&output.out, output.json) {
        let names = ["certify.txt".to_owned(), "certify.json".to_owned()].into_iter().chain(written);
        line(&format!("written to {}: {}", dir.display(), names.collect::<Vec<_>>().join(", ")))?;
    }
    Ok(if found.is_proved() { Outcome::Done } else { Outcome::Negative })
}

/// One file for each certificate.
fn files(found: &Certification, dir: &Path) -> anyhow::Result<Vec<String>> {
    let single = [("lyapunov", &found.lyapunov), ("region", &found.region), ("passivity", &found.passivity)];
    let mut proofs: Vec<(String, &Certificate)> = Vec::new();
    for (name, finding) in single {
        proofs.extend(finding.as_ref().and_then(|f| f.proof()).map(|p| (name.to_owned(), &p.certificate)));
    }
    for (k, p) in found.conserved.iter().flat_map(|c| c.polynomials.iter().enumerate()) {
        proofs.push((format!("conserved_{}", k + 1), &p.certificate));
    }
    let mut names = Vec::new();
    for (name, certificate) in proofs {
        let name = format!("certificate_{name}.json");
        write(&dir.join(&name), &json(certificate)?)?;
        names.push(name);
    }
    Ok(names)
}

fn check_file(system: &System, path: &Path, output: &CommonArgs) -> anyhow::Result<Outcome> {
    let place = || path.display().to_string();
    let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {}", place()))?;
    let certificate: Certificate = serde_json::from_str(&text).with_context(|| {
        format!("{}: is not a certificate: give a file certificate_….json written by certify --out", place())
    })?;
    let outcome = check(system, &certificate);
    let text = check_text(&system.name, &outcome);
    let value = object!({"model": system.name, "valid": outcome.is_ok(), "conclusion": outcome.as_ref().ok(), "text": text.trim_end()});
    print(&if output.json { json(&value)? } else { text })?;
    Ok(if outcome.is_ok() { Outcome::Done } else { Outcome::Negative })
}
