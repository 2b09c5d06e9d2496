//! The Brunovsky form: chains of integrators by static feedback and a change of coordinates.

use bracketry_symbolic::{Expr, Symbol};

use crate::algebra::matrix::generic_rank;
use crate::algebra::rational::readable::tidy;
use crate::feedback::outputs::named_functions;
use crate::feedback::relative_degree::RelativeDegree;
use crate::forms::change::{Feedback, Plan};
use crate::forms::frame::Frame;
use crate::forms::normal_form::{BlockKind, NormalForm};
use crate::forms::obstacle::{Obstacle, Stop};

impl Frame {
    /// `z_(i,1)' = z_(i,2), …, z_(i,κ_i)' = v_i` with `u = α(x) + β(x) v` (Jakubczyk and Respondek 1980; Hunt, Su, and Meyer
    /// 1983; Isidori 1995, thm. 5.2.3).
    pub(crate) fn brunovsky(&mut self) -> Result<NormalForm, Stop> {
        self.without_delays()?;
        let m = self.fields.controls.len();
        if m == 0 {
            return Err(Stop::No(Obstacle::NoInputs));
        }
        let pool = &mut self.system.pool;
        let rank = generic_rank(pool, &self.fields.controls, &self.fields.bindings, &mut self.evidence)?;
        if rank < m {
            return Err(Stop::Unknown(Obstacle::DependentInputs { inputs: m, rank }));
        }
        let flag = self.fields.linearization_flag(pool, &mut self.evidence)?;
        if let Some(index) = flag.involutive.iter().position(|&i| !i) {
            return Err(Stop::No(Obstacle::NotInvolutive { index }));
        }
        let states = self.fields.states.len();
        if !flag.linearizable() {
            let dimension = flag.dims.last().copied().unwrap_or(0);
            return Err(Stop::No(Obstacle::NotReached { dimension, states }));
        }
        let preferred = named_functions(&self.system);
        let pool = &mut self.system.pool;
        let Some(outputs) = self.fields.linearizing_outputs(pool, &flag, &preferred, &mut self.evidence)? else {
            return Err(Stop::Unknown(Obstacle::NoLinearizingOutputs));
        };
        let degrees = outputs.degrees;
        let (z, v) = (self.fresh("z", states), self.fresh("v", m));
        let feedback = self.decoupling_feedback(&degrees, v)?;
        let known = self.chains(&degrees, &z, &feedback.new);
        let singular = degrees.singular_factors(&mut self.system.pool, &self.fields);
        let mut next = 0;
        let blocks = degrees.derivatives.iter().map(|list| {
            next += list.len();
            (BlockKind::Chain, (next - list.len()..next).collect())
        });
        let plan = Plan {
            blocks: blocks.collect(),
            coordinates: degrees.derivatives.concat(),
            new: z,
            feedback: Some(feedback),
            known: known.into_iter().map(Some).collect(),
            inverse: None,
            regular: Some(degrees.decoupling),
            singular,
            keep_names: false,
            suffix: "brunovsky",
            notes: Vec::new(),
        };
        Ok(self.change(plan)?.form)
    }

    /// `u = A⁻¹(v − b)` and `v = b + A u`.
    pub(crate) fn decoupling_feedback(&mut self, degrees: &RelativeDegree, new: Vec<Symbol>) -> Result<Feedback, Stop> {
        let inputs = self.inputs();
        let pool = &mut self.system.pool;
        let references: Vec<Expr> = new.iter().map(|&v| pool.sym(v)).collect();
        let nodes = pool.len();
        let law = degrees
            .feedback(pool, &references)
            .ok_or(Stop::Unknown(crate::undecided::Undecided::TooLarge { nodes }.into()))?;
        let mut inverse = Vec::new();
        for (&b, row) in degrees.drift.iter().zip(&degrees.decoupling) {
            let mut v = b;
            for (&a, &u) in row.iter().zip(&inputs) {
                let term = pool.mul(a, u);
                v = pool.add(v, term);
            }
            inverse.push(tidy(pool, v));
        }
        Ok(Feedback { new, law, inverse })
    }

    /// The rates of chains of integrators.
    pub(crate) fn chains(&mut self, degrees: &RelativeDegree, z: &[Symbol], v: &[Symbol]) -> Vec<Expr> {
        let mut rates = Vec::new();
        for (list, &v) in degrees.derivatives.iter().zip(v) {
            for k in 1..=list.len() {
                let next = if k < list.len() { z[rates.len() + 1] } else { v };
                rates.push(self.system.pool.sym(next));
            }
        }
        rates
    }
}
