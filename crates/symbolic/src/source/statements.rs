//! The instructions of a tape as statements of a language.

use super::language::Language;
use super::operation::{Level, Term, constant, operation, repeats_operands};
use crate::tape::Tape;

/// What is used once and is no longer than this stands where it is used.
const LONGEST_PART: usize = 60;

/// The body of a function: assignments to locals, and the results as expressions of arguments and locals.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Statements {
    /// One assignment a line, without indentation.
    pub lines: Vec<String>,
    /// The results of the tape, in order.
    pub results: Vec<String>,
    /// By argument: whether anything uses it.
    pub used: Vec<bool>,
}

impl Tape {
    /// The instructions as statements, for arguments of these names (or other text that stands for a value) and locals
    /// `prefix0`, `prefix1`, …
    ///
    /// They round as the tape does: the same operations on the same operands. What is used more than once is computed once
    /// and has a local; what is used once stands where it is used, unless it is long. Small integer powers are products;
    /// `sign`, `abs`, `min`, `max` treat NaN as the tape does (in CasADi as CasADi does).
    ///
    /// # Panics
    /// If the number of names is not that of the tape's arguments.
    pub fn statements(&self, language: Language, arguments: &[String], prefix: &str) -> Statements {
        assert_eq!(arguments.len(), self.n_inputs(), "number of arguments");
        let first = self.n_inputs() + self.constants().len();
        let (uses, mut whole) = (self.uses(), vec![false; self.registers()]);
        for c in self.code() {
            if repeats_operands(language, c.op) {
                whole[c.a as usize] = true;
                whole[c.b as usize] = true;
            }
        }
        let mut terms: Vec<Term> = arguments.iter().map(|a| Term::atom(a.clone())).collect();
        terms.extend(self.constants().iter().map(|&v| constant(language, v)));
        let mut lines = Vec::new();
        for (i, c) in self.code().iter().enumerate() {
            let mut term = operation(language, c.op, &terms[c.a as usize], &terms[c.b as usize]);
            let own = first + i;
            if uses[own] > 1 || whole[own] || term.level == Level::Choice || term.text.len() > LONGEST_PART {
                let local = format!("{prefix}{}", lines.len());
                lines.push(match language {
                    Language::Rust => format!("let {local} = {};", term.text),
                    Language::C => format!("const double {local} = {};", term.text),
                    Language::Python | Language::NumPy | Language::Casadi | Language::Julia => {
                        format!("{local} = {}", term.text)
                    }
                });
                term = Term::atom(local);
            }
            terms.push(term);
        }
        let results = self.outputs().iter().map(|&r| terms[r as usize].text.clone()).collect();
        Statements { lines, results, used: uses[..self.n_inputs()].iter().map(|&n| n > 0).collect() }
    }

    /// How often each register is an operand or a result.
    fn uses(&self) -> Vec<u32> {
        let mut uses = vec![0; self.registers()];
        for c in self.code() {
            uses[c.a as usize] += 1;
            // Operations of one argument hold it twice.
            uses[c.b as usize] += u32::from(c.op.takes_two());
        }
        for &r in self.outputs() {
            uses[r as usize] += 1;
        }
        uses
    }
}
