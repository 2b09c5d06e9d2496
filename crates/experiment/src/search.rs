//! From starts to inputs that keep all limits on the exact models.

use crate::exact::{Exact, Run};
use crate::options::{ExperimentError, ExperimentOptions};
use crate::plan::{Pieces, Plan};
use crate::setup::Setup;
use crate::signals::Signals;
use crate::starts::weaker;
use std::time::Instant;

/// Share of the width of a limit by which it may be left: rounding of the simulation.
const ROUNDING: f64 = 1e-9;
/// Room that a plan leaves to the limits of states at first, as a share of their widths.
const FIRST_MARGIN: f64 = 0.01;
/// Plans with more room, where exact motions leave the limits.
const ROUNDS: usize = 3;
/// Factor by which inputs that leave limits are weakened, and how often.
const WEAKER: (f64, usize) = (0.8, 40);
/// Inputs that are compared on the exact models.
const COMPARED: usize = 3;

/// Inputs with the exact runs under them.
pub(crate) struct Candidate {
    pub(crate) pieces: Pieces,
    pub(crate) signals: Signals,
    pub(crate) runs: Vec<Run>,
}

/// What a search found.
pub(crate) struct Search {
    /// The best by the plan, best first.
    pub(crate) candidates: Vec<Candidate>,
    /// Number of starts that were tried.
    pub(crate) starts: usize,
}

/// Makes the problem with these margins of the limits of states; the inputs show how large the states become.
pub(crate) type Build<'b> = dyn FnMut(&[f64], &[Pieces]) -> Result<Plan, ExperimentError> + 'b;

/// What a search needs.
pub(crate) struct Searcher<'a> {
    pub(crate) setup: &'a Setup,
    /// The models whose states keep their limits.
    pub(crate) exacts: &'a [&'a Exact<'a>],
    pub(crate) options: &'a ExperimentOptions,
    pub(crate) deadline: Option<Instant>,
}

impl Candidate {
    pub(crate) fn copy(&self) -> Self {
        Self { pieces: self.pieces.clone(), signals: self.signals.clone(), runs: self.runs.clone() }
    }
}

impl Searcher<'_> {
    /// Simple inputs that keep the limits: the references, at least one.
    pub(crate) fn simple(&self) -> Result<Vec<Candidate>, ExperimentError> {
        let mut kept = Vec::new();
        for pieces in self.setup.simple() {
            kept.extend(self.kept(&pieces)?);
        }
        if kept.is_empty() {
            let model = self.exacts.iter().map(|e| e.system.name.clone()).collect::<Vec<_>>().join(", ");
            return Err(ExperimentError::Simulation { model });
        }
        Ok(kept)
    }

    /// Whether no further optimization is started.
    pub(crate) fn is_late(&self) -> bool {
        self.options.stop.is_raised() || self.deadline.is_some_and(|d| Instant::now() >= d)
    }

    /// The exact runs under inputs, with the shares by which they leave the limits; none where a simulation stops.
    fn run(&self, pieces: &Pieces) -> Result<Option<(Candidate, Vec<f64>)>, ExperimentError> {
        let signals = self.setup.signals(pieces);
        let mut excess = vec![0.0; self.setup.states.len()];
        let mut runs = Vec::new();
        for exact in self.exacts {
            let Some(run) = exact.run(&signals, &[])? else { return Ok(None) };
            let own = exact.excess(&run, &self.setup.states);
            excess.iter_mut().zip(own).for_each(|(e, v): (&mut f64, f64)| *e = e.max(v));
            runs.push(run);
        }
        Ok(Some((Candidate { pieces: pieces.clone(), signals, runs }, excess)))
    }

    /// The inputs, weakened until all limits are kept; none where that does not help.
    pub(crate) fn kept(&self, pieces: &Pieces) -> Result<Option<Candidate>, ExperimentError> {
        let mut factor = 1.0;
        for _ in 0..WEAKER.1 {
            if let Some((candidate, excess)) = self.run(&weaker(self.setup, pieces, factor))?
                && excess.iter().all(|e| *e <= ROUNDING)
            {
                return Ok(Some(candidate));
            }
            // A simulation that takes long takes long for weaker inputs too.
            if self.is_late() {
                break;
            }
            factor *= WEAKER.0;
        }
        Ok(None)
    }

    /// The best inputs for a problem that `build` makes with these margins of the limits of states, from simple and random starts.
    pub(crate) fn search(
        &self,
        simple: &[Candidate],
        also: &[Pieces],
        build: &mut Build<'_>,
    ) -> Result<Search, ExperimentError> {
        let mut starts: Vec<Pieces> = also.to_vec();
        starts.extend(simple.iter().map(|c| c.pieces.clone()).filter(|c| !also.contains(c)));
        for start in self.setup.random(self.options.starts, self.options.seed) {
            starts.extend(self.kept(&start)?.map(|c| c.pieces));
        }
        let mut margins = vec![FIRST_MARGIN; self.setup.states.len()];
        let mut plan = build(&margins, &starts)?;
        let mut found: Vec<(f64, Pieces)> = Vec::new();
        let mut tried = 0;
        for start in &starts {
            if tried > 0 && self.is_late() {
                break;
            }
            tried += 1;
            found.push((plan.value(start)?, start.clone()));
            found.extend(plan.improve(start)?);
        }
        found.retain(|f| f.0.is_finite());
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        found.truncate(COMPARED);
        let mut candidates = Vec::new();
        for (_, mut pieces) in found {
            for _ in 0..ROUNDS {
                let Some((_, excess)) = self.run(&pieces)? else { break };
                if excess.iter().all(|e| *e <= ROUNDING) || self.is_late() {
                    break;
                }
                margins.iter_mut().zip(&excess).for_each(|(m, e)| *m += 1.5 * e);
                plan = build(&margins, &starts)?;
                if let Some((_, better)) = plan.improve(&pieces)? {
                    pieces = better;
                }
            }
            candidates.extend(self.kept(&pieces)?);
        }
        Ok(Search { candidates, starts: tried })
    }
}
