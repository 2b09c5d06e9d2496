//! Which variables of a program stand at the place of others.

/// Variables of the list (x, u) at a grid point that stand at the place of another variable there, as (from, to). At the first grid point,
/// initial states that are decided on are inputs; at later ones, constant inputs are the states that carry them on.
#[derive(Clone, Debug, Default)]
pub(crate) struct Moves {
    pub(super) first: Vec<(usize, usize)>,
    pub(super) later: Vec<(usize, usize)>,
}

impl Moves {
    /// Those of grid point k.
    pub(crate) fn at(&self, k: usize) -> &[(usize, usize)] {
        if k == 0 { &self.first } else { &self.later }
    }

    /// The place of a variable at grid point k.
    pub(crate) fn place(&self, k: usize, variable: usize) -> usize {
        self.at(k).iter().find(|(from, _)| *from == variable).map_or(variable, |(_, to)| *to)
    }
}
