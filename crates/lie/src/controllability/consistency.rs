//! Statements at a point, held against each other.
//!
//! Each statement has a proof of its own; where two of them exclude each other, one of the proofs is wrong, and neither is to be believed.

use crate::controllability::stlc::Verdict;
use crate::reason::Contradiction;

/// What was found at a point, before it is told.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Statements {
    /// Number of states.
    pub(crate) states: usize,
    /// Generic dimensions: accessible, strongly accessible.
    pub(crate) generic: [usize; 2],
    /// The same at the point.
    pub(crate) local: [Option<usize>; 2],
    /// Rank of the Kalman matrix; none where the point is no equilibrium.
    pub(crate) rank: Option<usize>,
    /// Whether an input can move to one side only.
    pub(crate) restricted: bool,
    /// Small-time local controllability with bounded inputs; by jumps of others the state may come back from afar.
    pub(crate) stlc: Verdict,
    /// Whether all uncontrollable eigenvalues have negative real parts.
    pub(crate) decays: Option<bool>,
    /// Whether feedback stabilizes.
    pub(crate) stabilizable: Option<bool>,
    /// Whether this feedback is known to be a continuous function of the state.
    pub(crate) continuous: bool,
    /// Brockett's necessary condition for continuous feedback.
    pub(crate) brockett: Option<bool>,
}

impl Statements {
    /// Two of the statements that exclude each other, if there are any.
    pub(crate) fn contradiction(&self) -> Option<Contradiction> {
        let contradicting = |first: String, second: String| Some(Contradiction { first, second });
        let Statements { states: n, generic, local, rank, .. } = *self;
        for (kind, generic, local) in [("", generic[0], local[0]), ("strongly ", generic[1], local[1])] {
            // Rank is lower semicontinuous.
            if let Some(local) = local.filter(|l| *l > generic) {
                let first = format!("the {kind}accessible dimension at the point is {local}");
                return contradicting(first, format!("{generic} at generic points"));
            }
        }
        if let [Some(all), Some(strong)] = local
            && !(strong..=strong + 1).contains(&all)
        {
            // The algebra is the span of the drift and of its strong part.
            let first = format!("the accessible dimension at the point is {all}");
            return contradicting(first, format!("the strongly accessible dimension is {strong}"));
        }
        let rank_is = |rank| format!("the linearization is controllable in {rank} dimensions");
        if let (Some(rank), Some(strong)) = (rank, local[1])
            && rank > strong
        {
            // At an equilibrium, its columns are values of the brackets ad_f^k g.
            return contradicting(rank_is(rank), format!("the strongly accessible dimension at the point is {strong}"));
        }
        let controllable = rank == Some(n) && !self.restricted;
        if controllable && self.stlc == Verdict::No {
            return contradicting(rank_is(n), "the system is not small-time locally controllable".to_owned());
        }
        if let (Verdict::Yes, Some(all)) = (self.stlc, local[0].filter(|all| *all < n)) {
            let first = "the system is small-time locally controllable".to_owned();
            return contradicting(first, format!("its accessible dimension at the point is {all} of {n}"));
        }
        if self.stlc == Verdict::Yes && self.stabilizable == Some(false) {
            // Clarke, Ledyaev, Sontag, and Subbotin 1997.
            let first = "the system is small-time locally controllable".to_owned();
            return contradicting(first, "no feedback stabilizes it".to_owned());
        }
        let linear = !self.restricted && (controllable || rank.is_some() && self.decays == Some(true));
        let stable = "linear feedback stabilizes the linearization".to_owned();
        match (linear, self.stabilizable, self.brockett) {
            (true, Some(false), _) => contradicting(stable, "no feedback stabilizes the system".to_owned()),
            (_, Some(true), Some(false)) if self.continuous => {
                let first = "continuous feedback of the state stabilizes the system".to_owned();
                contradicting(first, "Brockett's necessary condition does not hold".to_owned())
            }
            (true, _, Some(false)) => contradicting(stable, "Brockett's necessary condition does not hold".to_owned()),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    /// Those of x' = v, v' = u at 0.
    const INTEGRATOR: Statements = Statements {
        states: 2,
        generic: [2, 2],
        local: [Some(2), Some(2)],
        rank: Some(2),
        restricted: false,
        stlc: Verdict::Yes,
        decays: Some(true),
        stabilizable: Some(true),
        continuous: true,
        brockett: Some(true),
    };

    #[test]
    fn statements_that_are_true_together_do_not_contradict_each_other() {
        assert_eq!(INTEGRATOR.contradiction(), None);
        // Brockett's integrator: no feedback that is continuous, but others.
        let nonholonomic = Statements {
            states: 3,
            generic: [3, 3],
            local: [Some(3), Some(3)],
            rank: Some(2),
            decays: Some(false),
            continuous: false,
            brockett: Some(false),
            ..INTEGRATOR
        };
        assert_eq!(nonholonomic.contradiction(), None);
        // u ≥ 0.
        let pushed = Statements {
            restricted: true,
            stlc: Verdict::No,
            stabilizable: Some(false),
            brockett: Some(false),
            ..INTEGRATOR
        };
        assert_eq!(pushed.contradiction(), None);
        // x' = 1 + u x: the drift adds one dimension.
        let drifting = Statements { local: [Some(1), Some(0)], rank: None, stlc: Verdict::No, ..INTEGRATOR };
        assert_eq!(drifting.contradiction(), None);
    }

    #[test]
    fn each_pair_that_excludes_each_other_is_found() {
        let wrong = [
            (Statements { generic: [1, 1], ..INTEGRATOR }, "generic"),
            (Statements { generic: [2, 1], ..INTEGRATOR }, "strongly accessible dimension at the point is 2"),
            (Statements { states: 3, generic: [3, 3], local: [Some(3), Some(1)], ..INTEGRATOR }, "strongly"),
            (Statements { local: [Some(2), Some(1)], ..INTEGRATOR }, "controllable in 2 dimensions"),
            (Statements { stlc: Verdict::No, ..INTEGRATOR }, "not small-time"),
            (Statements { states: 3, generic: [3, 3], ..INTEGRATOR }, "2 of 3"),
            (Statements { stabilizable: Some(false), rank: Some(1), decays: None, ..INTEGRATOR }, "no feedback"),
            (Statements { stlc: Verdict::Inconclusive, stabilizable: Some(false), ..INTEGRATOR }, "no feedback"),
            (Statements { brockett: Some(false), ..INTEGRATOR }, "Brockett"),
            (Statements { rank: Some(1), decays: None, brockett: Some(false), ..INTEGRATOR }, "continuous feedback"),
        ];
        for (statements, expected) in wrong {
            let found = statements.contradiction().unwrap().to_string();
            assert!(found.contains(expected) && found.contains("please report"), "{statements:?}: {found}");
        }
    }
}
