//! Whether the measured outputs tell of every parameter and disturbance.

use super::augmented::Augmented;
use super::problem::{DisturbanceChannel, EstimationProblem};
use crate::error::{MpcError, check_length};
use bracketry_numerics::eigen::svd;
use nalgebra::DMatrix;

/// Singular values below this fraction of the largest count as zero.
const RANK: f64 = 1e-9;
/// Share in an unobservable direction from which a quantity is named.
const SHARE: f64 = 1e-3;

impl EstimationProblem {
    /// Checks that states, parameters and disturbances can all be told from the measured outputs near the state `x` with the
    /// input `u`: the observability matrix (C; CF; CF²; …) of the linearized flow has full rank. Every quantity counts in
    /// units of its initial standard deviation, where it has one. With dry friction choose a state that slides.
    ///
    /// # Errors
    /// [`MpcError::NotObservable`] names what cannot be told, or cannot be told apart from one another. Where the linearized flow is not
    /// finite, or grows beyond all numbers, nothing can be said, and there is no error.
    ///
    /// ```
    /// use bracketry_mpc::estimation::{Disturbance, DisturbanceChannel, EstimationProblem, MeasuredOutput};
    /// use bracketry_system::System;
    /// let text = "states = [\"x\", \"v\"]\ninputs = [\"a\"]\ndynamics = { x = \"v\", v = \"a\" }";
    /// let mass = System::parse("mass.toml", text).unwrap();
    /// let mut problem = EstimationProblem::new(&mass, 0.1, &[0.0, 0.0]);
    /// problem.outputs = vec![MeasuredOutput::new("x", 1e-3)];
    /// problem.disturbances = vec![Disturbance::new(DisturbanceChannel::Input("a".into()), 1.0, 0.1)];
    /// assert!(problem.check_observability(&[0.0, 0.0], &[0.0]).is_ok());
    /// problem.disturbances.push(Disturbance::new(DisturbanceChannel::State("v".into()), 1.0, 0.1));
    /// let error = problem.check_observability(&[0.0, 0.0], &[0.0]).unwrap_err();
    /// assert!(error.to_string().contains("the disturbance of a, the disturbance of v"));
    /// ```
    pub fn check_observability(&self, x: &[f64], u: &[f64]) -> Result<(), MpcError> {
        let mut model = Augmented::new(self)?;
        check_length("the state", x.len(), model.states)?;
        check_length("the input", u.len(), model.inputs)?;
        let mut z = model.start.clone();
        z.as_mut_slice()[..x.len()].copy_from_slice(x);
        let n = model.size();
        let rest = vec![0.0; model.noise.len()];
        let f = model.interval(0.0, z.as_slice(), u, &rest, false).f;
        let (_, mut c) = model.outputs(0.0, z.as_slice());
        for (mut row, (variance, _)) in c.row_iter_mut().zip(&model.sensors) {
            row /= variance.sqrt();
        }
        let scale = model.start_std.map(|s| if s > 0.0 { s } else { 1.0 });
        let p = c.nrows();
        let mut matrix = DMatrix::zeros(n * p.max(1), n);
        for k in 0..n {
            for i in 0..p {
                for j in 0..n {
                    matrix[(k * p + i, j)] = c[(i, j)] * scale[j];
                }
            }
            c = &c * &f;
        }
        let Some(svd) = svd(&matrix) else { return Ok(()) };
        let largest = svd.singular_values.max();
        let Some(directions) = svd.v_t else { return Ok(()) };
        let mut unseen = vec![false; n];
        for (direction, &s) in directions.row_iter().zip(&svd.singular_values) {
            if s <= RANK * largest || largest == 0.0 {
                unseen.iter_mut().zip(direction.iter()).for_each(|(u, d)| *u |= d.abs() > SHARE);
            }
        }
        let names: Vec<String> =
            self.quantities().into_iter().zip(unseen).filter(|(_, u)| *u).map(|(n, _)| n).collect();
        if names.is_empty() { Ok(()) } else { Err(MpcError::NotObservable { names }) }
    }

    /// What states, parameters and disturbances are called in messages.
    fn quantities(&self) -> Vec<String> {
        let mut names: Vec<String> = self.system.state_names().iter().map(|n| format!("the state {n}")).collect();
        names.extend(self.parameters.iter().map(|p| format!("the parameter {}", p.name)));
        names.extend(self.disturbances.iter().map(|d| match &d.channel {
            DisturbanceChannel::Input(name) | DisturbanceChannel::State(name) => format!("the disturbance of {name}"),
            DisturbanceChannel::Output(i) => format!("the disturbance of `{}`", self.outputs[*i].expression),
        }));
        names
    }
}
