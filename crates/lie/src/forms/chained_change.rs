//! The chained form as a change of coordinates and inputs.

use bracketry_symbolic::Expr;

use crate::feedback::outputs::named_functions;
use crate::forms::chained::{ChainedForm, NoChainedForm};
use crate::forms::change::{Feedback, Plan};
use crate::forms::frame::Frame;
use crate::forms::normal_form::{BlockKind, NormalForm};
use crate::forms::obstacle::{Obstacle, Stop};
use crate::undecided::Undecided;

impl Frame {
    /// The first chained form that was found (see [`ChainedForm`]), as a system.
    pub(crate) fn chained(&mut self) -> Result<NormalForm, Stop> {
        self.without_delays()?;
        let n = self.fields.states.len();
        let known = named_functions(&self.system);
        let found = self.fields.chained_forms(&mut self.system.pool, &known, &mut self.evidence)?;
        let Some(form) = found.forms.into_iter().next() else {
            return Err(match found.reason {
                Some(NoChainedForm::Inputs { independent }) => Stop::No(Obstacle::NotTwoInputs { independent }),
                Some(NoChainedForm::Drift) => Stop::No(Obstacle::Drift),
                Some(NoChainedForm::DerivedFlag { dimensions }) => Stop::No(Obstacle::DerivedFlag { dimensions }),
                Some(NoChainedForm::NotFound) | None => Stop::Unknown(Obstacle::CoordinatesNotFound { missing: n }),
            });
        };
        let (z, v) = (self.fresh("z", n), self.fresh("v", 2));
        let inputs = self.inputs();
        let pool = &mut self.system.pool;
        let [v1, v2] = [pool.sym(v[0]), pool.sym(v[1])];
        let law = form.inputs(pool, [v1, v2]).ok_or(Undecided::TooLarge { nodes: pool.len() })?;
        let inverse = form.input_matrix.iter().map(|row| {
            let (a, b) = (pool.mul(row[0], inputs[0]), pool.mul(row[1], inputs[1]));
            pool.add(a, b)
        });
        let inverse: Vec<Expr> = inverse.collect();
        let mut known = vec![Some(v1), Some(v2)];
        for k in 2..n {
            let before = pool.sym(z[k - 1]);
            known.push(Some(pool.mul(before, v1)));
        }
        let regular = self.jacobian_with_inputs(&form);
        let plan = Plan {
            coordinates: form.coordinates,
            new: z,
            feedback: Some(Feedback { new: v, law: law.to_vec(), inverse }),
            known,
            inverse: None,
            regular: Some(regular),
            singular: form.singular_factors,
            blocks: vec![(BlockKind::Chained, (0..n).collect())],
            keep_names: false,
            suffix: "chained",
            notes: Vec::new(),
        };
        Ok(self.change(plan)?.form)
    }

    /// The Jacobian of T and the matrix B of the inputs, block by block: regular where both are.
    fn jacobian_with_inputs(&mut self, form: &ChainedForm) -> Vec<Vec<Expr>> {
        let pool = &mut self.system.pool;
        let zero = pool.int(0);
        let n = form.coordinates.len();
        let mut rows = pool.jacobian(&form.coordinates, &self.fields.states);
        for row in &mut rows {
            row.extend([zero; 2]);
        }
        rows.extend(form.input_matrix.iter().map(|row| {
            let mut all = vec![zero; n];
            all.extend(row);
            all
        }));
        rows
    }
}
