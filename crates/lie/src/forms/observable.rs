//! The local decomposition into an observable part and one that no output tells.

use bracketry_symbolic::Expr;

use crate::algebra::rational::readable::tidy;
use crate::feedback::outputs::fed_through;
use crate::forms::frame::Frame;
use crate::forms::normal_form::{BlockKind, NormalForm, PartKind};
use crate::forms::obstacle::{Obstacle, Stop};
use crate::forms::parts::{free_of, independent_of};
use crate::modes::parameter_bindings;

impl Frame {
    /// `z1' = f1(z1, u)`, `z2' = f2(z1, z2, u)`, `y = h(z1)`, where z1 are functions whose differentials span the observability
    /// codistribution (Hermann and Krener 1977; Isidori 1995, prop. 1.9.1).
    pub(crate) fn observable(&mut self) -> Result<NormalForm, Stop> {
        let outputs = self.output_functions();
        if outputs.is_empty() {
            return Err(Stop::No(Obstacle::NoOutputs));
        }
        if fed_through(&self.system) {
            return Err(Stop::Unknown(Obstacle::FedThrough));
        }
        let n = self.fields.states.len();
        let pool = &mut self.system.pool;
        let told = self.fields.observability(pool, &outputs, &[], &mut self.evidence)?;
        let rank = told.rank();
        let determined = told.determined_variables(pool, &mut self.evidence)?;
        let states = self.state_functions();
        let mut simple: Vec<Expr> =
            states.iter().zip(&determined).filter(|(_, known)| **known).map(|(&s, _)| s).collect();
        if simple.len() < rank {
            let hidden = told.unobservable_directions(&mut self.system.pool, &mut self.evidence)?;
            if hidden.len() == n - rank {
                simple.extend(self.constants_along(&hidden)?);
            }
        }
        // Outputs with their derivatives always do, in either order.
        let derivatives = self.with_derivatives(&told.functions);
        let last_first: Vec<Expr> = derivatives.iter().rev().copied().collect();
        let mut sets = Vec::new();
        for candidates in [simple, derivatives, last_first] {
            let seen = self.completion(&[], &candidates)?;
            if seen.len() == rank && !sets.contains(&seen) {
                sets.push(seen);
            }
        }
        let blocks = vec![(BlockKind::Observable, (0..rank).collect()), (BlockKind::Unobservable, (rank..n).collect())];
        self.first_of(sets, |frame, seen, rest| {
            let coordinates = seen.iter().chain(rest).copied().collect();
            let mut form = frame.decomposed(coordinates, blocks.clone(), "observable")?;
            independent_of(&mut form, 0..rank, rank..n, &[])?;
            frame.outputs_free_of_hidden(&mut form, rank)?;
            if rank > 0 && rank < n {
                let inputs = form.system.inputs.clone();
                frame.add_part(&mut form, PartKind::Observable, 0..rank, &inputs);
            }
            Ok(form)
        })
    }

    /// The functions, then those of their derivatives along drift and inputs that are no numbers.
    fn with_derivatives(&mut self, functions: &[Expr]) -> Vec<Expr> {
        let mut list = functions.to_vec();
        let pool = &mut self.system.pool;
        for &h in functions {
            for field in std::iter::once(&self.fields.drift).chain(&self.fields.controls) {
                let e = pool.lie_derivative(h, &self.fields.states, field);
                let e = tidy(pool, e);
                if pool.number(e).is_none() && !list.contains(&e) {
                    list.push(e);
                }
            }
        }
        list
    }

    /// The outputs that the form is about do not depend on the hidden states, and are seen not to.
    fn outputs_free_of_hidden(&mut self, form: &mut NormalForm, rank: usize) -> Result<(), Stop> {
        let hidden = form.system.states[rank..].to_vec();
        let bindings = parameter_bindings(&form.system);
        for name in self.output_names() {
            let Some(k) = form.system.outputs.iter().position(|o| o.0 == name) else { continue };
            let h = form.system.outputs[k].1;
            let free = free_of(&mut form.system, h, &hidden, &bindings);
            form.system.outputs[k].1 = free.ok_or(Stop::Unknown(Obstacle::Unconfirmed { name }))?;
        }
        Ok(())
    }
}
