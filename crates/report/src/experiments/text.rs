//! The text of an experiment.

use std::fmt::Write as _;

use bracketry_diagnose::significant;
use bracketry_experiment::{CLEAR, Design, Discrimination, IDENTIFIED, Identification, RESOLVED, Separation};
use bracketry_sim::Hold;
use bracketry_system::readable;

/// A number of which only the size matters.
fn short(value: f64) -> String {
    significant(value, 3)
}

/// Inputs, limits, and what was assumed.
fn design(out: &mut String, d: &Design) {
    let hold = match d.signals.hold {
        Hold::Previous => "constant between samples",
        Hold::Linear => "linear between samples",
    };
    let (samples, time) = (d.signals.times.len() - 1, d.quantities.time_unit);
    let _ = writeln!(
        out,
        "{}, {samples} samples, one every {}; inputs {hold}",
        time.text(readable(d.duration())),
        time.text(readable(d.sample))
    );
    for limit in &d.limits {
        let _ = writeln!(out, "  {} within {} to {}", limit.name, readable(limit.low), readable(limit.high));
    }
    for n in &d.noise {
        let _ = writeln!(out, "  noise of {}: standard deviation {} ({})", n.column, short(n.std), n.source.words());
    }
}

/// What is assumed beside the noise, and how it was found.
fn assumptions(out: &mut String, d: &Design, models: &str, start: &str, fixed: &[String]) {
    let known = if fixed.is_empty() { String::new() } else { format!("; known parameters: {}", fixed.join(", ")) };
    let _ = writeln!(out, "assumed: white noise{start}{known}");
    let _ = writeln!(
        out,
        "computed by exact simulation of {models}, which keeps all limits; starts of the optimization: {}",
        d.starts
    );
    if d.is_cut {
        let _ =
            writeln!(out, "note: the time limit ended the search; with a larger --time-limit, the result may change");
    }
}

fn separation(s: &Separation) -> String {
    let values: Vec<String> = s.parameters.iter().map(|(name, v)| format!("{name} = {}", short(*v))).collect();
    let with = if values.is_empty() { String::new() } else { format!("{} and ", values.join(", ")) };
    format!(
        "  if {} is true, {} with {with}another start still misses it by chi-square {}, {} standard deviations (as given: chi-square {})",
        s.truth,
        s.refitted,
        short(s.chi_square),
        short(s.deviations),
        short(s.as_given)
    )
}

/// An experiment that tells two explanations apart, in text.
pub fn discrimination_text(d: &Discrimination) -> String {
    let [a, b] = &d.names;
    let mut out = format!("experiment that tells {a} from {b}\n");
    design(&mut out, &d.design);
    let _ = writeln!(out, "expected differences after a refit of the explanation that is not true:");
    for s in &d.separations {
        let _ = writeln!(out, "{}", separation(s));
    }
    let _ = writeln!(
        out,
        "  the best of the simple inputs within the same limits: {} standard deviations",
        short(d.before)
    );
    let weaker = d.weaker().deviations;
    if d.resolves() {
        let _ = writeln!(out, "resolved: {} standard deviations, at least {RESOLVED} are required", short(weaker));
        if !d.is_clear() {
            let _ = writeln!(
                out,
                "  note: this holds for a comparison of both refits over the whole run; `bracketry diagnose`, which fits the start of every \
                 window, may need {CLEAR}"
            );
        }
    } else {
        let _ = writeln!(out, "not resolved: {} standard deviations, at least {RESOLVED} are required", short(weaker));
        let _ = writeln!(
            out,
            "  what would help: a longer --duration, wider --limits, a shorter --sample, less noise, another measured column, or \
             parameters that are known (--fix)"
        );
    }
    assumptions(&mut out, &d.design, "both explanations", "", &d.fixed);
    out
}

/// An experiment that identifies parameters, in text.
pub fn identification_text(d: &Identification) -> String {
    let names: Vec<&str> = d.parameters.iter().map(|p| p.name.as_str()).collect();
    let mut out = format!("experiment that identifies {} of {}\n", names.join(", "), d.model.name);
    design(&mut out, &d.design);
    let _ = writeln!(
        out,
        "expected standard deviations, and those of the best of the simple inputs within the same limits:"
    );
    for p in &d.parameters {
        let unit = p.unit.as_deref().map_or(String::new(), |u| format!(" {u}"));
        let std = |s: Option<f64>| s.map_or("not identified".to_owned(), |s| format!("± {}{unit}", short(s)));
        let _ = writeln!(
            out,
            "  {} = {}{unit} {} (simple input: {})",
            p.name,
            readable(p.value),
            std(p.std_after),
            std(p.std_before)
        );
    }
    for (i, row) in d.correlation.iter().enumerate() {
        for (j, r) in row.iter().enumerate().take(i) {
            let _ = writeln!(out, "  correlation of {} and {}: {r:.3}", names[j], names[i]);
        }
    }
    if let Some(shorter) = d.shorter {
        let _ = writeln!(
            out,
            "  determinant of the Fisher information: as if all standard deviations were divided by {}",
            short(shorter)
        );
    }
    if d.is_identified() {
        let _ = writeln!(out, "identified: every standard deviation is at most {IDENTIFIED} of its value");
    } else {
        let open: Vec<&str> = d.parameters.iter().filter(|p| !p.identified).map(|p| p.name.as_str()).collect();
        let _ = writeln!(out, "not identified: {}", open.join(", "));
        let _ = writeln!(
            out,
            "  what would help: fewer --parameters at a time, a longer --duration, wider --limits, less noise, or another measured \
             column; `bracketry analyze` says which parameters the outputs determine at all"
        );
    }
    assumptions(&mut out, &d.design, "the model", ", the start as in the model", &d.fixed);
    out
}
