//! Systems under construction, with what is known of them.

use std::fmt::Write;

use bracketry_system::System;
use serde_json::{Value, json};

/// What is asked of a system.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Question {
    /// The report of the analysis.
    #[default]
    Analysis,
    /// An operating point.
    Equilibrium,
    /// Verdicts by cases of parameters.
    Parameters,
}

/// What an entry of the report must be.
#[derive(Clone, Debug)]
pub(crate) enum Expected {
    /// This value.
    Is(Value),
    /// A list of so many entries; fewer count as unknown.
    Count(usize),
    /// Eigenvalues, real and imaginary parts.
    Spectrum(Vec<(f64, f64)>),
    /// This number, up to the accuracy to which multiple solutions are found.
    Near(f64),
    /// These texts in any order; others are wrong, fewer count as unknown.
    Set(Vec<String>),
}

/// A system in coordinates in which its answers are seen.
#[derive(Default)]
pub(crate) struct Model {
    pub(crate) question: Question,
    /// Names and rates.
    pub(crate) states: Vec<(String, String)>,
    pub(crate) inputs: Vec<String>,
    pub(crate) outputs: Vec<String>,
    pub(crate) parameters: Vec<(String, i64)>,
    /// Lower and upper ends, by input.
    pub(crate) ranges: Vec<(String, i64, i64)>,
    /// Entries of the report by path, such as `modes.0.accessible_dimension`.
    pub(crate) truth: Vec<(String, Expected)>,
}

impl Model {
    /// Another state; its rate is 0 until it is set.
    pub(crate) fn state(&mut self) -> usize {
        self.states.push((format!("s{}", self.states.len() + 1), "0".to_owned()));
        self.states.len() - 1
    }

    pub(crate) fn name(&self, state: usize) -> String {
        self.states[state].0.clone()
    }

    /// Another input, by its name.
    pub(crate) fn input(&mut self) -> String {
        self.inputs.push(format!("u{}", self.inputs.len() + 1));
        self.inputs[self.inputs.len() - 1].clone()
    }

    pub(crate) fn rate(&mut self, state: usize, rate: impl Into<String>) {
        self.states[state].1 = rate.into();
    }

    pub(crate) fn add(&mut self, state: usize, term: &str) {
        let rate = &mut self.states[state].1;
        *rate = format!("{rate} + {term}");
    }

    pub(crate) fn is(&mut self, path: &str, value: impl Into<Value>) {
        self.truth.push((path.to_owned(), Expected::Is(value.into())));
    }

    pub(crate) fn count(&mut self, path: &str, count: usize) {
        self.truth.push((path.to_owned(), Expected::Count(count)));
    }

    pub(crate) fn near(&mut self, path: &str, value: f64) {
        self.truth.push((path.to_owned(), Expected::Near(value)));
    }

    pub(crate) fn set(&mut self, path: &str, texts: Vec<String>) {
        self.truth.push((path.to_owned(), Expected::Set(texts)));
    }

    pub(crate) fn spectrum(&mut self, path: &str, values: &[(f64, f64)]) {
        self.truth.push((path.to_owned(), Expected::Spectrum(values.to_vec())));
    }

    /// A chain of integrators from `last` to the new states, the last of which moves with `input`.
    pub(crate) fn chain(&mut self, length: usize, input: &str) -> Vec<usize> {
        let states: Vec<usize> = (0..length).map(|_| self.state()).collect();
        for pair in states.windows(2) {
            let next = self.name(pair[1]);
            self.rate(pair[0], next);
        }
        self.rate(states[length - 1], input);
        states
    }

    /// The same as a system, at rest in the origin.
    pub(crate) fn system(&self) -> System {
        let list = |names: &mut dyn Iterator<Item = &String>| -> String {
            names.map(|n| format!("{n:?}")).collect::<Vec<_>>().join(", ")
        };
        let mut text = format!("name = \"known\"\nstates = [{}]\n", list(&mut self.states.iter().map(|s| &s.0)));
        let _ = writeln!(text, "inputs = [{}]", list(&mut self.inputs.iter()));
        let _ = writeln!(text, "[dynamics]");
        for (name, rate) in &self.states {
            let _ = writeln!(text, "{name} = {}", json!(rate));
        }
        let _ = writeln!(text, "[parameters]");
        for (name, value) in &self.parameters {
            let _ = writeln!(text, "{name} = {value}");
        }
        let _ = writeln!(text, "[ranges]");
        for (name, min, max) in &self.ranges {
            let _ = writeln!(text, "{name} = {{ min = {min}, max = {max} }}");
        }
        let _ = writeln!(text, "[outputs]");
        for (i, output) in self.outputs.iter().enumerate() {
            let _ = writeln!(text, "y{} = {}", i + 1, json!(output));
        }
        let _ = writeln!(text, "[point]");
        for (name, _) in &self.states {
            let _ = writeln!(text, "{name} = 0");
        }
        System::parse("known", &text).unwrap_or_else(|e| panic!("{e}\n{text}"))
    }
}
