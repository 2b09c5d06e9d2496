//! Tables and a scenario of a motion, which `simulate` and `control` read.

use std::fmt::Write as _;

use bracketry_sim::Hold;
use bracketry_steer::Steering;

/// Rows of the trajectory.
const ROWS: usize = 400;

/// The inputs as a table with its header: a column t and one per input; `None` without a motion.
pub fn steering_inputs(s: &Steering) -> Option<(Vec<String>, Vec<Vec<f64>>)> {
    let signals = s.signals.as_ref()?;
    let header = std::iter::once("t".to_owned()).chain(s.system.input_names()).collect();
    let row = |(t, u): (&f64, &Vec<f64>)| std::iter::once(*t).chain(u.iter().copied()).collect();
    Some((header, signals.times.iter().zip(&signals.values).map(row).collect()))
}

/// The states over time as a table with its header.
pub fn steering_trajectory(s: &Steering) -> Option<(Vec<String>, Vec<Vec<f64>>)> {
    let (run, signals) = (s.motion.as_ref()?, s.signals.as_ref()?);
    let header = std::iter::once("t".to_owned()).chain(s.system.state_names()).collect();
    let times = (0..=ROWS).map(|k| signals.duration() * k as f64 / ROWS as f64);
    let rows = times.map(|t| std::iter::once(t).chain(run.trajectory.sample(t)).collect()).collect();
    Some((header, rows))
}

/// A scenario that replays the motion from the table of inputs in `table`.
pub fn steering_scenario(s: &Steering, table: &str) -> Option<String> {
    let signals = s.signals.as_ref()?;
    let hold = match signals.hold {
        Hold::Previous => "previous",
        Hold::Linear => "linear",
    };
    let mut text =
        format!("# Replays a motion of {}.\nduration = {}\n\n[x0]\n", s.system.name, float(signals.duration()));
    for (name, x) in s.system.state_names().iter().zip(&s.from) {
        let _ = writeln!(text, "{name} = {}", float(*x));
    }
    let _ = write!(text, "\n[samples]\nfile = \"{table}\"\nhold = \"{hold}\"\n");
    Some(text)
}

/// A number as TOML reads it back exactly.
fn float(x: f64) -> String {
    format!("{x:?}")
}
