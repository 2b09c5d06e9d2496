//! Branches of a scenario tree.

/// Copies of a system in one problem: its states, inputs, and previous inputs are those of the first branch, then those of the
/// second one, and so on.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Branching {
    /// Number of branches S.
    pub branches: usize,
    /// For every interval before the branches have parted: the branch whose inputs each branch takes over, the first of those with
    /// the same past. A row has S entries.
    pub leaders: Vec<Vec<usize>>,
    /// Values of live parameters of the dynamics that follow those of [`Ocp::parameters`](crate::Ocp::parameters), a row per interval of the horizon; the
    /// last row holds beyond the last one. None where the branches keep their parameters.
    pub parameters: Vec<Vec<f64>>,
}

impl Branching {
    /// The leader of a branch over an interval; itself where the branches have parted.
    pub(super) fn leader(&self, k: usize, branch: usize) -> usize {
        self.leaders.get(k).and_then(|row| row.get(branch)).copied().unwrap_or(branch)
    }
}
