//! A diagnosis as text.

use std::fmt::{self, Formatter};
use std::path::Path;

use bracketry_diagnose::{
    Candidate, Effort, Gain, NamedCause, RefittedParameter, Report, Windows, measured, p_value, probability,
    significant,
};

use bracketry_system::{TimeUnit, counted};

use super::sentences::{closeness, combination, flag as flag_text, note as note_text, reason, regime};
use super::table::{Table, percent, short};

/// Candidates that the text lists; JSON has them all.
const LISTED: usize = 8;

/// A report for a reader, as `bracketry diagnose` prints it, with the file to which the extended model was written.
pub fn text(report: &Report, extended_model: Option<&Path>) -> String {
    struct Text<'a>(&'a Report, Option<&'a Path>);
    impl fmt::Display for Text<'_> {
        fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
            write_report(f, self.0, self.1)
        }
    }
    Text(report, extended_model).to_string()
}

fn write_report(f: &mut Formatter<'_>, report: &Report, extended_model: Option<&Path>) -> fmt::Result {
    let time = report.quantities.time_unit;
    writeln!(f, "{}: {}", report.model, report.verdict)?;
    writeln!(f, "  {}", reason(&report.reason))?;
    for cause in &report.causes {
        writeln!(f)?;
        write_cause(f, cause)?;
    }
    if !report.places.is_empty() {
        let mut table = Table::new(["equation", "when", "share of the excess", "share of the time"]);
        for p in report.places.iter().chain(&report.regimes) {
            table.row([&p.equation, &regime(&p.regime), &percent(p.share), &p.time.map_or_else(String::new, percent)]);
        }
        write!(f, "\nWhere the refitted model is wrong: by motion, then by acceleration, position, and tilt\n{table}")?;
    }
    if let Some(excess) = &report.excess {
        write!(f, "\nResidual over noise (1 = noise only): {} refitted", short(excess.refitted))?;
        if let Some(extended) = excess.extended {
            write!(f, ", {} extended", short(extended))?;
        }
        writeln!(f, "; p {} for noise alone", probability(excess.p_value))?;
    }
    if let Some(gain) = &report.gain {
        writeln!(f)?;
        write_gain(f, gain, time)?;
    }
    write_parameters(f, &report.parameters)?;
    write_candidates(f, &report.candidates)?;
    for audit in &report.data {
        write!(f, "\n{audit}")?;
    }
    if !report.notes.is_empty() {
        writeln!(f, "\nNotes")?;
        for note in &report.notes {
            writeln!(f, "  {}", note_text(note))?;
        }
    }
    if let Some(path) = extended_model {
        writeln!(f, "\nExtended model: {}", path.display())?;
    }
    if let Some(Windows { count, seconds }) = report.windows {
        writeln!(f, "\nFitted in {} of {}", counted(count, "window", "windows"), time.text(short(seconds)))?;
    }
    let Effort { fits, linearizations, simulations, steps, rejected, .. } = report.effort;
    let (fits, linearizations) =
        (counted(fits as usize, "fit", "fits"), counted(linearizations as usize, "linearization", "linearizations"));
    write!(f, "\n{} s: {fits}, {linearizations}, and ", short(report.seconds))?;
    let simulations = counted(simulations as usize, "simulation of a window", "simulations of windows");
    writeln!(f, "{simulations}, with {steps} accepted and {rejected} rejected steps")
}

fn write_cause(f: &mut Formatter<'_>, cause: &NamedCause) -> fmt::Result {
    writeln!(f, "{} in {}: {}", cause.name, cause.equation, cause.term)?;
    for (name, value) in cause.parameters.iter() {
        writeln!(f, "  {name} = {value}")?;
    }
    match cause.p_value {
        Some(p) => write!(f, "  p {}", probability(p))?,
        None => write!(f, "  without it some of the data cannot be simulated: no p-value")?,
    }
    match cause.share {
        Some(share) => writeln!(f, "; without it {} of the excess would remain", percent(share))?,
        None => writeln!(f)?,
    }
    for line in cause.combination.iter().flat_map(combination) {
        writeln!(f, "  {line}")?;
    }
    for flag in &cause.flags {
        writeln!(f, "  caution: {}", flag_text(flag))?;
    }
    if !cause.confusable_with.is_empty() {
        let names: Vec<String> = cause.confusable_with.iter().map(ToString::to_string).collect();
        writeln!(f, "  this experiment cannot distinguish it from: {}", names.join(", "))?;
    }
    for rival in &cause.rivals {
        writeln!(f, "    {} in {}: {} ({})", rival.name, rival.equation, rival.term, closeness(rival.closeness))?;
    }
    if !cause.separating_experiment.is_empty() {
        writeln!(f, "  to distinguish them: {}", cause.separating_experiment)?;
    }
    Ok(())
}

fn write_gain(f: &mut Formatter<'_>, gain: &Gain, time: TimeUnit) -> fmt::Result {
    let data = if gain.held_out { "held-out data" } else { "the data of the fit" };
    writeln!(f, "Gain on {data}: {}", gain.metric)?;
    if gain.horizons_s.is_empty() {
        writeln!(f, "  no predictions: the horizons exceed the held-out data")?;
    }
    let mut table = Table::new(["horizon", "as given", "refitted", "extended", "refitted/extended", "predictions"]);
    for (k, horizon) in gain.horizons_s.iter().enumerate() {
        table.row([
            time.text(horizon),
            percent(gain.as_given[k]),
            percent(gain.before[k]),
            percent(gain.after[k]),
            format!("{} ×", short(gain.before[k] / gain.after[k])),
            gain.predictions[k].to_string(),
        ]);
    }
    if !gain.horizons_s.is_empty() {
        write!(f, "{table}")?;
    }
    if let (Some(before), Some(after)) = (gain.equation_error_before, gain.equation_error_after) {
        write!(f, "  force error relative to the applied force: ")?;
        if let Some(given) = gain.equation_error_as_given {
            write!(f, "{} as given, ", percent(given))?;
        }
        write!(f, "{} refitted, {} extended", percent(before), percent(after))?;
        if let Some(bandwidth) = gain.equation_bandwidth_hz {
            write!(f, " (derivatives up to {} {})", short(bandwidth), time.frequency())?;
        }
        writeln!(f)?;
    }
    Ok(())
}

fn write_parameters(f: &mut Formatter<'_>, parameters: &[RefittedParameter]) -> fmt::Result {
    if parameters.is_empty() {
        return Ok(());
    }
    let mut table = Table::new(["parameter", "before", "after", "±", "95 %", "unit"]);
    for p in parameters {
        let interval = p
            .interval
            .map_or_else(String::new, |[low, high]| format!("{} … {}", measured(low, p.std), measured(high, p.std)));
        let before = p.before.to_string();
        table.row([&p.name, &before, &measured(p.after, p.std), &significant(p.std, 2), &interval, &p.unit]);
    }
    write!(f, "\nParameters of the model, refitted\n{table}")
}

fn write_candidates(f: &mut Formatter<'_>, candidates: &[Candidate]) -> fmt::Result {
    if candidates.is_empty() {
        return Ok(());
    }
    let mut table = Table::new(["", "candidate", "in", "term", "explains", "95 %", "p"]);
    for c in candidates.iter().take(LISTED) {
        let interval =
            c.interval.map_or_else(String::new, |[low, high]| format!("{} … {}", percent(low), percent(high)));
        let mark = if c.chosen { "*" } else { "" };
        let name = c.name.to_string();
        table.row([
            mark,
            &name,
            &c.equation,
            c.term.text(),
            &c.share.map_or_else(String::new, percent),
            &interval,
            &p_value(c.p_value),
        ]);
    }
    write!(f, "\nCandidates, each alone with all parameters refitted (share of the excess)\n{table}")?;
    if candidates.len() > LISTED {
        writeln!(f, "  and {} more", candidates.len() - LISTED)?;
    }
    Ok(())
}
