//! Choices of an analysis.

use std::time::{Duration, Instant};

use bracketry_symbolic::{Pool, Rational};

use crate::controllability::input_values::{InputValues, Side};

/// Time limit of an analysis unless another is asked for.
pub(crate) const TIME_LIMIT: Duration = Duration::from_mins(2);

/// Choices of an analysis.
#[derive(Clone, Debug)]
pub struct AnalysisOptions {
    /// Width of the tanh that replaces `sign` in the smoothed model.
    pub epsilon: Rational,
    /// How far brackets are formed at the point.
    pub limits: Limits,
    /// Brackets to be told, such as `[g1,[f,g1]]`; an input field also goes by the name of its input.
    pub brackets: Vec<String>,
    /// Functions of states and parameters of which it is asked whether the outputs determine them.
    pub determined: Vec<String>,
    /// Inputs, by name, that can move from their value at the point to one side only.
    pub one_sided: Vec<(String, Side)>,
    /// The values that inputs take, by name, for local controllability; all others take all real numbers.
    pub ranges: Vec<(String, InputValues)>,
    /// Whether flat outputs are searched for, which takes most of the time of a large model; without, the report says nothing of
    /// flatness.
    pub flatness: bool,
    /// Wall-clock time after which what is undecided is unknown; `None` for no limit.
    pub time_limit: Option<Duration>,
}

impl Default for AnalysisOptions {
    fn default() -> Self {
        AnalysisOptions {
            epsilon: Rational::ONE / Rational::from(100),
            limits: Limits::default(),
            brackets: Vec::new(),
            determined: Vec::new(),
            one_sided: Vec::new(),
            ranges: Vec::new(),
            flatness: true,
            time_limit: Some(TIME_LIMIT),
        }
    }
}

impl AnalysisOptions {
    /// When an analysis that started at `start` ends, which is no later than the deadline that the pool has already.
    pub(crate) fn deadline(&self, start: Instant, pool: &Pool) -> Option<Instant> {
        let own = self.time_limit.and_then(|limit| start.checked_add(limit));
        own.into_iter().chain(pool.deadline()).min()
    }
}

/// How far brackets are formed at a point before the answer is "unknown".
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Longest bracket, in letters.
    pub length: usize,
    /// Most brackets that are kept.
    pub brackets: usize,
    /// Most new nodes in the pool.
    pub nodes: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Limits { length: 12, brackets: 400, nodes: 200_000 }
    }
}
