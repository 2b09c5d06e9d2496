//! The report for a reader.

use std::fmt::{self, Display, Formatter};

use super::table::{Table, percent, short};
use super::{Candidate, NamedCause, RefittedParameter, Report, Value, Verdict};
use crate::gain::Gain;
use crate::numbers::{measured, probability, significant};

/// Candidates that the text lists; JSON has them all.
const LISTED: usize = 8;

impl Display for Verdict {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Verdict::CauseFound => "cause found",
            Verdict::NothingFound => "nothing found",
            Verdict::Unexplained => "unexplained",
            Verdict::Uninformative => "the data cannot tell",
        })
    }
}

impl Display for Value {
    /// `0.520 ± 0.010 kg/s (95 %: 0.50 … 0.54)`.
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "{} ± {}", measured(self.value, self.std), significant(self.std, 2))?;
        if !self.unit.is_empty() {
            write!(f, " {}", self.unit)?;
        }
        match self.interval {
            Some([low, high]) => write!(f, " (95 %: {} … {})", measured(low, self.std), measured(high, self.std)),
            None => Ok(()),
        }
    }
}

impl Display for Report {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}: {}", self.model, self.verdict)?;
        writeln!(f, "  {}", self.reason)?;
        for cause in &self.causes {
            write!(f, "\n{cause}")?;
        }
        if !self.places.is_empty() {
            let mut table = Table::new(["equation", "when", "share of the excess error", "share of the time"]);
            for p in self.places.iter().chain(&self.regimes) {
                table.row([&p.equation, &p.regime, &percent(p.share), &p.time.map_or_else(String::new, percent)]);
            }
            write!(
                f,
                "\nWhere the refitted model is wrong: by motion, then by acceleration, position and tilt\n{table}"
            )?;
        }
        if let Some(excess) = &self.excess {
            write!(f, "\nResidual over noise (1 = noise only): {} refitted", short(excess.refitted))?;
            if let Some(extended) = excess.extended {
                write!(f, ", {} extended", short(extended))?;
            }
            writeln!(f, "; p {} for noise alone", probability(excess.p_value))?;
        }
        if let Some(gain) = &self.gain {
            write!(f, "\n{gain}")?;
        }
        write_parameters(f, &self.parameters)?;
        write_candidates(f, &self.candidates)?;
        for audit in &self.data {
            write!(f, "\n{audit}")?;
        }
        if !self.notes.is_empty() {
            writeln!(f, "\nNotes")?;
            for note in &self.notes {
                writeln!(f, "  {note}")?;
            }
        }
        if let Some(path) = &self.extended_model {
            writeln!(f, "\nExtended model: {}", path.display())?;
        }
        writeln!(f, "\n{} s", short(self.seconds))
    }
}

impl Display for NamedCause {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        writeln!(f, "{} in {}: {}", self.name, self.equation, self.term)?;
        for (name, value) in &self.parameters {
            writeln!(f, "  {name} = {value}")?;
        }
        match self.p_value {
            Some(p) => write!(f, "  p {}", probability(p))?,
            None => write!(f, "  without it some of the data cannot be simulated: no p-value")?,
        }
        match self.share {
            Some(share) => writeln!(f, "; without it {} of the excess error would remain", percent(share))?,
            None => writeln!(f)?,
        }
        for flag in &self.flags {
            writeln!(f, "  caution: {flag}")?;
        }
        if !self.confusable_with.is_empty() {
            let names: Vec<String> = self.confusable_with.iter().map(ToString::to_string).collect();
            writeln!(f, "  this experiment cannot tell it from: {}", names.join(", "))?;
        }
        for rival in &self.rivals {
            writeln!(f, "    {} in {}: {} ({})", rival.name, rival.equation, rival.term, rival.why)?;
        }
        if !self.separating_experiment.is_empty() {
            writeln!(f, "  to tell them apart: {}", self.separating_experiment)?;
        }
        Ok(())
    }
}

impl Display for Gain {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let data = if self.held_out { "held-out data" } else { "the data of the fit" };
        writeln!(f, "Gain on {data}: {}", self.metric)?;
        let mut table = Table::new(["horizon", "as given", "refitted", "extended", "refitted/extended", "predictions"]);
        for (k, horizon) in self.horizons_s.iter().enumerate() {
            table.row([
                format!("{horizon} s"),
                percent(self.as_given[k]),
                percent(self.before[k]),
                percent(self.after[k]),
                format!("{} ×", short(self.before[k] / self.after[k])),
                self.predictions[k].to_string(),
            ]);
        }
        write!(f, "{table}")?;
        if let (Some(before), Some(after)) = (self.equation_error_before, self.equation_error_after) {
            write!(f, "  force error relative to the applied force: ")?;
            if let Some(given) = self.equation_error_as_given {
                write!(f, "{} as given, ", percent(given))?;
            }
            write!(f, "{} refitted, {} extended", percent(before), percent(after))?;
            if let Some(bandwidth) = self.equation_bandwidth_hz {
                write!(f, " (derivatives up to {} Hz)", short(bandwidth))?;
            }
            writeln!(f)?;
        }
        Ok(())
    }
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
            &c.term,
            &c.share.map_or_else(String::new, percent),
            &interval,
            probability(c.p_value).trim_start_matches("= "),
        ]);
    }
    write!(f, "\nWhat was tried, each alone with all parameters refitted (share of the excess error)\n{table}")?;
    if candidates.len() > LISTED {
        writeln!(f, "  and {} more", candidates.len() - LISTED)?;
    }
    Ok(())
}
