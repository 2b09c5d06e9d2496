//! Forces that depend on the way: hysteresis.

use super::builder::{Builder, dissipation, shape};
use super::structure::Coordinate;
use crate::effect::{Cause, Change, Coefficient, Effect, HiddenState};
use crate::formula::Formula;

/// The distances after which a reversed force has changed its sign from which fits start, over the extent of the coordinate.
const DISTANCES: [f64; 3] = [0.03, 0.1, 0.3];
/// The largest such distance: beyond it the force is that of a spring.
const FARTHEST: f64 = 2.0;
/// The force from which fits start, over that which a typical acceleration needs.
const FORCE: f64 = 0.2;
/// The share β of the loop from which fits start.
const LOOP: f64 = 0.9;

impl Builder {
    /// Hysteresis of Bouc and Wen with exponent 1 (Wen 1976), whose force is `-F z`;
    /// with β = 1 it is the friction of Dahl:
    ///
    /// ```text
    /// z' = (v − β |v| z − (1 − β) v |z|)/s
    /// ```
    pub(crate) fn hysteresis(&mut self, c: &Coordinate) -> Option<Effect> {
        let (q, v) = (self.state(c.position?), self.state(c.rate));
        let entry = c.force.iter().find(|(row, _)| *row == c.rate)?.1;
        let sizes = [self.system.dynamics[c.rate], entry].map(|e| self.data.rms(&mut self.system, &[e])[0]);
        let (force, extent) = (FORCE * sizes[0] / sizes[1], self.data.extent(&q)?);
        if !(force > 0.0 && force.is_finite()) {
            return None;
        }
        let names = ["hysteresis_force", "hysteresis_distance", "hysteresis_loop", "hysteresis"];
        let [f, s, b, z] = names.map(|base| self.name(base, &v));
        let coefficients = vec![
            Coefficient {
                min: 0.0,
                scale: force,
                trials: vec![force],
                ..dissipation(f.clone(), c.force_unit.clone(), format!("largest force of the hysteresis against {v}"))
            },
            Coefficient {
                max: FARTHEST * extent,
                ..shape(
                    s.clone(),
                    DISTANCES.map(|share| share * extent).to_vec(),
                    c.length_unit.clone(),
                    "distance over which the force builds up",
                )
            },
            Coefficient {
                min: 0.0,
                max: 1.0,
                trials: Vec::new(),
                ..shape(
                    b.clone(),
                    vec![LOOP],
                    "1",
                    "share of the loop: 1 is the friction of Dahl, 1/2 unloads along a straight line",
                )
            },
        ];
        let rate = format!("({v} - {b}*abs({v})*{z} - (1 - {b})*{v}*abs({z}))/{s}");
        let states = vec![HiddenState { name: z.clone(), rate, like: None, scale: 1.0 }];
        let terms = c.force.iter().map(|&(row, e)| (self.state(row), format!("-{f}*{z}*({})", self.text(e))));
        let change = Change::Hidden { states, change: Box::new(Change::Terms(terms.collect())) };
        let term = Formula::from(format!("a force of at most {f} against {v} that builds up over {s}").as_str());
        Some(Effect { cause: Cause::Hysteresis, equation: v, term, coefficients, change })
    }
}
