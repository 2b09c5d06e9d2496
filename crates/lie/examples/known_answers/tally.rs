//! Counts of answers.

use std::collections::BTreeMap;
use std::fmt;

use crate::judge::Judgment;

/// Right, unknown and wrong answers.
#[derive(Clone, Copy, Default)]
struct Counts([usize; 3]);

/// Counts by class and question, and the slowest systems.
#[derive(Default)]
pub(crate) struct Tally {
    answers: BTreeMap<(&'static str, String), Counts>,
    /// Seconds and number of the slowest system of each class, and the number of systems.
    times: BTreeMap<&'static str, (f64, usize, usize)>,
    /// Systems without an answer.
    pub(crate) failed: usize,
}

impl Tally {
    pub(crate) fn time(&mut self, class: &'static str, index: usize, seconds: f64) {
        let entry = self.times.entry(class).or_default();
        entry.2 += 1;
        if seconds > entry.0 {
            (entry.0, entry.1) = (seconds, index);
        }
    }

    pub(crate) fn add(&mut self, class: &'static str, question: &str, judgment: Judgment) {
        self.answers.entry((class, question.to_owned())).or_default().0[judgment as usize] += 1;
    }

    fn sum(&self, of: impl Fn(&(&'static str, String)) -> bool) -> [usize; 3] {
        let mut sum = [0; 3];
        for (_, counts) in self.answers.iter().filter(|a| of(a.0)) {
            for (s, c) in sum.iter_mut().zip(counts.0) {
                *s += c;
            }
        }
        sum
    }

    pub(crate) fn wrong(&self) -> usize {
        self.sum(|_| true)[2]
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "| class | question | right | unknown | wrong |\n|---|---|---:|---:|---:|")?;
        for ((class, question), Counts([right, unknown, wrong])) in &self.answers {
            writeln!(f, "| {class} | `{question}` | {right} | {unknown} | {wrong} |")?;
        }
        writeln!(f, "\n| class | systems | right | unknown | wrong | slowest |\n|---|---:|---:|---:|---:|---|")?;
        for (class, (seconds, index, systems)) in &self.times {
            let [right, unknown, wrong] = self.sum(|a| a.0 == *class);
            writeln!(f, "| {class} | {systems} | {right} | {unknown} | {wrong} | {seconds:.2} s (system {index}) |")?;
        }
        let [right, unknown, wrong] = self.sum(|_| true);
        let share = 100.0 * unknown as f64 / (right + unknown + wrong).max(1) as f64;
        let slowest = self.times.values().map(|t| t.0).fold(0.0, f64::max);
        writeln!(
            f,
            "\n{right} right, {unknown} unknown ({share:.1} %), {wrong} wrong; {} systems without an answer; slowest {slowest:.2} s",
            self.failed
        )
    }
}
