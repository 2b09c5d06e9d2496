//! A closed loop in pictures.

use bracketry_mpc::ControlProblem;
use bracketry_plot::{Dash, Drawing, Panel, PlotError, Series, TimeSeries};

use crate::Controlled;
use crate::simulation::{friction_bands, friction_colors};

impl Controlled {
    /// States with targets, bounds and the modes of friction, inputs, and the time of each solution.
    ///
    /// # Errors
    /// [`PlotError`] for numbers that no axis holds.
    pub fn figure(&self, problem: &ControlProblem) -> Result<Drawing, PlotError> {
        let run = &self.run.closed_loop;
        let (states, inputs) = (problem.plant.state_names(), problem.plant.input_names());
        let estimated = problem.estimation.is_some();
        let mut chart = friction_colors(TimeSeries::new()).title(format!("Closed loop, {}", problem.system.name));
        for (k, name) in states.iter().enumerate() {
            let values: Vec<f64> = run.x.iter().map(|x| x[k]).collect();
            let label = if estimated { "true state" } else { "" };
            let mut panel = Panel::new(name.clone()).series(Series::new(label, run.t.clone(), values));
            if estimated {
                let values: Vec<f64> = run.estimates.iter().map(|x| x[k]).collect();
                panel =
                    panel.series(Series::new("estimate", run.t[..values.len()].to_vec(), values).dash(Dash::Dashed));
            }
            for target in problem.ocp.targets.iter().filter(|t| t.state == k) {
                panel = panel.target(target.value);
            }
            let b = problem.ocp.state_bounds[k];
            for bound in [b.min, b.max].into_iter().filter(|b| b.is_finite()) {
                panel = panel.bound(bound);
            }
            panel = friction_bands(panel, &self.recording.trajectory, &self.switches, name);
            chart = chart.panel(panel);
        }
        for (k, name) in inputs.iter().enumerate() {
            let mut panel = Panel::new(format!("input {name}")).series(held(&run.t, run.u.iter().map(|u| u[k])));
            let (min, max) = problem.ocp.input_bounds[k];
            for bound in [min, max].into_iter().filter(|b| b.is_finite()) {
                panel = panel.bound(bound);
            }
            chart = chart.panel(panel);
        }
        let milliseconds = run.steps.iter().map(|s| 1e3 * s.timings.total());
        chart = chart.panel(Panel::new("solve time [ms]").series(held(&run.t, milliseconds)));
        chart.draw()
    }
}

/// Values that are held from each time to the next, the last one to the end.
fn held(t: &[f64], values: impl Iterator<Item = f64>) -> Series {
    let mut values: Vec<f64> = values.collect();
    values.extend(values.last().copied());
    Series::new("", t[..values.len().min(t.len())].to_vec(), values).step()
}
