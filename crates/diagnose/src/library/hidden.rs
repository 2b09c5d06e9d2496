//! Effects with states that no column shows: elastic joints, hidden vibrations, hysteresis.

use bracketry_system::System;

use super::builder::{Builder, dissipation, log_grid, shape};
use super::paths::interval;
use super::structure::Coordinate;
use crate::effect::{Cause, Change, Coefficient, Effect, HiddenState};
use crate::formula::Formula;
use crate::record::Record;
use crate::settings::LibrarySettings;

/// The inertia from which the fit of a hidden mass starts, over that of its coordinate.
const INERTIA: f64 = 0.3;
/// The largest inertia of a hidden mass, over that of its coordinate.
const MOST: f64 = 10.0;
/// The damping ratio from which a fit starts.
const DAMPING: f64 = 0.1;

/// For each coordinate, hysteresis, and a mass that hangs on it by a spring and a damper and that no column shows, with an
/// oscillation no longer than a `window`, in s: an elastic joint, or where no input
/// drives the coordinate a hidden vibration. With the gap r to the coordinate q and the speed w of the mass
///
/// ```text
/// r' = w − q',  w' = −ω² r − 2 ζ ω (w − q'),  and the force J (ω² r + 2 ζ ω (w − q')) acts on q.
/// ```
pub(crate) fn hidden_states(
    system: &System,
    records: &[Record],
    window: f64,
    settings: &LibrarySettings,
) -> Vec<Effect> {
    let mut builder = Builder::new(system, records, settings);
    let (slowest, fastest) = (1.0 / window, settings.highest_frequency / interval(records));
    let frequencies = log_grid(1.2 * slowest, fastest, settings.frequency_trials);
    let coordinates = builder.structure.coordinates.clone();
    let mut effects = Vec::new();
    for c in coordinates.iter().filter(|_| slowest < fastest) {
        effects.extend(builder.hidden_mass(c, (slowest, &frequencies)));
    }
    for c in &coordinates {
        effects.extend(builder.hysteresis(c));
    }
    effects
}

impl Builder {
    fn hidden_mass(&mut self, c: &Coordinate, (slowest, frequencies): (f64, &[f64])) -> Option<Effect> {
        let v = self.state(c.rate);
        let entry = c.force.iter().find(|(row, _)| *row == c.rate)?.1;
        let inertia = 1.0 / self.data.rms(&mut self.system, &[entry])[0];
        let speed = self.data.extent(&v)?;
        if !inertia.is_finite() {
            return None;
        }
        let names = ["hidden_inertia", "hidden_frequency", "hidden_damping", "hidden_gap", "hidden_speed"];
        let [j, f, z, r, w] = names.map(|base| self.name(base, &v));
        let pull = format!("((2*pi*{f})^2*{r} + 4*pi*{f}*{z}*({w} - {v}))");
        let unit = c.inertia_unit();
        let coefficients = vec![
            Coefficient {
                min: 0.0,
                max: MOST * inertia,
                scale: INERTIA * inertia,
                trials: vec![INERTIA * inertia],
                ..dissipation(j.clone(), unit, format!("inertia that hangs on {v} by a spring"))
            },
            Coefficient {
                min: slowest,
                ..shape(
                    f.clone(),
                    frequencies.to_vec(),
                    self.system.quantities.time_unit.frequency(),
                    "its natural frequency with the coordinate held",
                )
            },
            Coefficient {
                min: 0.0,
                max: 1.0,
                trials: Vec::new(),
                ..shape(z.clone(), vec![DAMPING], "1", "its damping ratio with the coordinate held")
            },
        ];
        let middle = frequencies[frequencies.len() / 2];
        let states = vec![
            HiddenState {
                name: r.clone(),
                rate: format!("{w} - {v}"),
                like: None,
                scale: speed / (std::f64::consts::TAU * middle),
            },
            HiddenState { name: w, rate: format!("-{pull}"), like: Some(v.clone()), scale: speed },
        ];
        let terms = c.force.iter().map(|&(row, e)| (self.state(row), format!("{j}*{pull}*({})", self.text(e))));
        let change = Change::Hidden { states, change: Box::new(Change::Terms(terms.collect())) };
        let cause = if c.input.is_some() { Cause::ElasticJoint } else { Cause::HiddenVibration };
        let term = Formula::from(format!("an inertia {j} hangs on {v} by a spring").as_str());
        Some(Effect { cause, equation: v, term, coefficients, change })
    }
}
