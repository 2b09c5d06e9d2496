//! Brackets that are independent over the constants.

use std::ops::Range;

use bracketry_symbolic::{Bindings, Pool};

use crate::algebra::field::{Field, is_plain_zero};
use crate::evidence::Evidence;
use crate::residues::{Echelon, OFFSET};
use crate::undecided::Undecided;

/// Seed of the samples that decide linear dependence over the constants.
const CONSTANTS_SEED: u64 = 0x6272_6163_6b65_7401;

/// Fields that are linearly independent over the constants, grown by brackets.
#[derive(Default)]
pub(crate) struct Words {
    /// Right-normed brackets.
    pub(crate) kept: Vec<Field>,
    /// Those that were kept last.
    pub(crate) fresh: Range<usize>,
}

/// Most values of fields at points that are held at once.
const MAX_VALUES: f64 = 2e7;

impl Words {
    /// Keeps of `candidates` a maximal set that is independent, over the constants, of itself and what is kept.
    ///
    /// k functions are dependent over the constants just when their values at k random points,
    /// written one after the other, are: each point takes one dimension off the combinations
    /// that vanish at all points so far, until only those that vanish everywhere are left. A bracket that is a constant
    /// combination of kept ones adds nothing, nor do its own brackets. (A transcendental or
    /// unbound constant counts as a function here, which keeps more than necessary.)
    pub(crate) fn extend(
        &mut self,
        pool: &mut Pool,
        bindings: &Bindings,
        candidates: Vec<Field>,
        evidence: &mut Evidence,
    ) -> Result<(), Undecided> {
        let start = self.kept.len();
        let mut all = self.kept.clone();
        for c in candidates {
            if !is_plain_zero(pool, &c) && !all.contains(&c) {
                all.push(c);
            }
        }
        if all.len() > start {
            let n = all[0].len();
            let certain = all.len() + 1;
            // Independence at fewer points is independence; only dependence needs them all.
            for points in [(all.len() / n + 2).min(certain), certain] {
                if (all.len() * n) as f64 * points as f64 > MAX_VALUES {
                    return Err(Undecided::TooMany { products: MAX_VALUES });
                }
                let samples = pool.sample_in::<OFFSET>(&all.concat(), bindings, points, CONSTANTS_SEED)?;
                let mut echelon = Echelon::empty(points * n);
                let row = |i: usize| samples.values.iter().flat_map(move |v| v[i * n..(i + 1) * n].iter().copied());
                let independent: Vec<bool> = (0..all.len()).map(|i| echelon.insert(row(i).collect())).collect();
                if echelon.rank() == all.len() || points == certain {
                    evidence.add_rank(&samples, all.len())?;
                    let new = all.into_iter().zip(independent).skip(start);
                    self.kept.extend(new.filter_map(|(field, keep)| keep.then_some(field)));
                    break;
                }
            }
        }
        self.fresh = start..self.kept.len();
        Ok(())
    }
}
