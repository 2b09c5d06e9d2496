//! Verdicts counted by what was hidden.

use bracketry_diagnose::Report;
use bracketry_report::DiagnosisJson;
use bracketry_trials::{Score, SliderTrial};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::error::Error;
use std::fmt::{self, Display, Formatter, Write};

/// One log and its verdict.
pub(crate) struct Row {
    seed: u64,
    hidden: String,
    /// None: the diagnosis ended with an error.
    score: Option<Score>,
    named: String,
    seconds: f64,
    /// All of it, for inspection.
    pub(crate) json: Value,
}

impl Row {
    pub(crate) fn new(trial: &SliderTrial, outcome: Result<(Report, Score), Box<dyn Error>>, seconds: f64) -> Self {
        let names: Vec<&str> = trial.hidden.iter().map(|effect| effect.name()).collect();
        let hidden = if names.is_empty() { "nothing".to_owned() } else { names.join(" + ") };
        let slider = format!("{:?}", trial.slider);
        let (score, named, report) = match outcome {
            Ok((report, score)) => {
                let named: Vec<String> = report
                    .causes
                    .iter()
                    .map(|c| {
                        let set: Vec<String> = c.confusable_with.iter().map(ToString::to_string).collect();
                        if set.is_empty() { c.name.to_string() } else { format!("{} ({})", c.name, set.join(", ")) }
                    })
                    .collect();
                let named = if named.is_empty() { report.verdict.to_string() } else { named.join(" + ") };
                (Some(score), named, serde_json::to_value(DiagnosisJson::of(&report, None)).unwrap_or_default())
            }
            Err(error) => (None, format!("error: {error}"), Value::Null),
        };
        let json = json!({
            "seed": trial.seed, "hidden": hidden, "slider": slider, "score": score.map(Score::name), "named": named,
            "seconds": seconds, "report": report,
        });
        Self { seed: trial.seed, hidden, score, named, seconds, json }
    }
}

impl Display for Row {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let score = self.score.map_or("error", Score::name);
        write!(f, "seed {:5}  {:12} {:22} {} [{:.1} s]", self.seed, score, self.hidden, self.named, self.seconds)
    }
}

/// Shares by what was hidden, then the runs that went wrong.
pub(crate) fn table(rows: &[Row]) -> String {
    let mut groups: BTreeMap<&str, Vec<&Row>> = BTreeMap::new();
    for row in rows {
        groups.entry(&row.hidden).or_default().push(row);
    }
    let mut text = String::from(
        "| hidden | runs | exactly named | truth in the set | partly | wrong name | unexplained | missed | false alarm | errors | s per verdict: median | largest |\n\
         |---|---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for (hidden, rows) in &groups {
        text.push_str(&line(hidden, rows));
    }
    if groups.len() > 1 {
        text.push_str(&line("all", &rows.iter().collect::<Vec<_>>()));
    }
    let good = [Some(Score::Exact), Some(Score::InSet)];
    for row in rows.iter().filter(|row| !good.contains(&row.score)) {
        let _ = writeln!(text, "{row}");
    }
    text
}

fn line(hidden: &str, rows: &[&Row]) -> String {
    let share = |wanted: &[Option<Score>]| {
        let count = rows.iter().filter(|row| wanted.contains(&row.score)).count();
        format!("{:.1} %", 100.0 * count as f64 / rows.len() as f64)
    };
    let mut seconds: Vec<f64> = rows.iter().map(|row| row.seconds).collect();
    seconds.sort_by(f64::total_cmp);
    let cells = [
        hidden.to_owned(),
        rows.len().to_string(),
        share(&[Some(Score::Exact)]),
        share(&[Some(Score::Exact), Some(Score::InSet)]),
        share(&[Some(Score::Partly)]),
        share(&[Some(Score::WrongName)]),
        share(&[Some(Score::Unexplained)]),
        share(&[Some(Score::Missed)]),
        share(&[Some(Score::FalseAlarm)]),
        share(&[None]),
        format!("{:.1}", seconds[seconds.len() / 2]),
        format!("{:.1}", seconds[seconds.len() - 1]),
    ];
    format!("| {} |\n", cells.join(" | "))
}
