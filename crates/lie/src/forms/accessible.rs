//! The local decomposition into an accessible part and one that no input influences.

use bracketry_symbolic::Expr;

use crate::algebra::rational::readable::tidy;
use crate::forms::change::Plan;
use crate::forms::frame::Frame;
use crate::forms::normal_form::{BlockKind, NormalForm, PartKind};
use crate::forms::obstacle::{Obstacle, Stop};
use crate::forms::parts::independent_of;

impl Frame {
    /// `z1' = f1(z1, z2) + Σ u_j g_j(z1, z2)`, `z2' = f2(z2)`, where z2 are functions that are constant along the strong
    /// accessibility distribution (Sussmann and Jurdjevic 1972; Isidori 1995, prop. 1.7.1; Nijmeijer and van der Schaft 1990,
    /// prop. 3.24).
    pub(crate) fn accessible(&mut self) -> Result<NormalForm, Stop> {
        let n = self.fields.states.len();
        let closure = self.fields.strong_accessibility(&mut self.system.pool, &mut self.evidence)?;
        let d = closure.dimension();
        let wanted = n - d;
        let mut candidates = self.constant_states(&closure.basis)?;
        if candidates.len() < wanted {
            candidates.extend(self.constants_along(&closure.basis)?);
        }
        let functions = self.completion(&[], &candidates)?;
        if functions.len() < wanted {
            return Err(Stop::Unknown(Obstacle::CoordinatesNotFound { missing: wanted - functions.len() }));
        }
        let blocks = vec![(BlockKind::Accessible, (0..d).collect()), (BlockKind::Inaccessible, (d..n).collect())];
        self.first_of(vec![functions], |frame, functions, rest| {
            let coordinates = rest.iter().chain(functions).copied().collect();
            let mut form = frame.decomposed(coordinates, blocks.clone(), "accessible")?;
            let inputs = form.system.inputs.clone();
            independent_of(&mut form, d..n, 0..d, &inputs)?;
            if d > 0 && d < n {
                frame.add_part(&mut form, PartKind::Inaccessible, d..n, &[]);
            }
            Ok(form)
        })
    }

    /// The first form that is found, over sets of functions and over states that complete them to coordinates, taken from the
    /// first or from the last one on.
    pub(crate) fn first_of(
        &mut self,
        sets: Vec<Vec<Expr>>,
        make: impl Fn(&mut Frame, &[Expr], &[Expr]) -> Result<NormalForm, Stop>,
    ) -> Result<NormalForm, Stop> {
        let states = self.state_functions();
        let backward: Vec<Expr> = states.iter().rev().copied().collect();
        let missing = self.fields.states.len();
        let mut failed = Stop::Unknown(Obstacle::CoordinatesNotFound { missing });
        let mut first = true;
        for functions in sets {
            let mut tried: Vec<Vec<Expr>> = Vec::new();
            for order in [&states, &backward] {
                let mut rest = self.completion(&functions, order)?;
                rest.sort_by_key(|h| states.iter().position(|s| s == h));
                if tried.contains(&rest) {
                    continue;
                }
                // Every attempt makes its symbols in a pool of its own.
                let mut attempt = self.clone();
                let found = make(&mut attempt, &functions, &rest);
                self.evidence = attempt.evidence;
                match found {
                    Ok(form) => return Ok(form),
                    Err(stop) if attempt.system.pool.reached_limit().is_some() => {
                        return Err(stop);
                    }
                    Err(stop) if first => (failed, first) = (stop, false),
                    Err(_) => {}
                }
                tried.push(rest);
            }
        }
        Err(failed)
    }

    /// A change of coordinates that keeps the inputs and the names of states.
    pub(crate) fn decomposed(
        &mut self,
        coordinates: Vec<Expr>,
        blocks: Vec<(BlockKind, Vec<usize>)>,
        suffix: &'static str,
    ) -> Result<NormalForm, Stop> {
        let coordinates: Vec<Expr> = coordinates.into_iter().map(|t| tidy(&mut self.system.pool, t)).collect();
        let n = coordinates.len();
        let plan = Plan {
            new: self.fresh("z", n),
            coordinates,
            feedback: None,
            known: vec![None; n],
            inverse: None,
            regular: None,
            singular: None,
            blocks,
            keep_names: true,
            suffix,
            notes: Vec::new(),
        };
        Ok(self.change(plan)?.form)
    }
}
