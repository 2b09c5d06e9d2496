//! Inputs that do not act as they are logged: gain, dead zone, saturation.

use std::cmp::Ordering;

use bracketry_numerics::statistics::extremes;
use bracketry_symbolic::Symbol;

use super::builder::{Builder, amplitude, dissipation};
use crate::effect::{Cause, Coefficient};
use crate::error::DiagnoseError;
use crate::record::Record;

/// Shares of the largest input at which a saturation is tried. What is cut off grows faster than the cut, so that a limit is found from its
/// neighborhood alone.
const LIMITS: [f64; 6] = [0.9, 0.75, 0.6, 0.45, 0.3, 0.2];

impl Builder {
    /// Effects on the way from each input to the equations.
    pub(crate) fn add_actuators(&mut self, records: &[Record]) -> Result<(), DiagnoseError> {
        for index in 0..self.system.inputs.len() {
            self.gain(index)?;
            // A motion that is an input has no actuator of which the model speaks.
            if self.system.input_derivatives.iter().all(|d| d.input != index) {
                self.dead_zone(index)?;
                self.saturation(index, records)?;
            }
        }
        Ok(())
    }

    /// The input and its derivatives act scaled.
    fn gain(&mut self, index: usize) -> Result<(), DiagnoseError> {
        let name = self.input(index);
        let derivatives = self.system.input_derivatives.iter().filter(|d| d.input == index).map(|d| d.symbol);
        let symbols: Vec<Symbol> = std::iter::once(self.system.inputs[index]).chain(derivatives).collect();
        let Some(row) = self.first_row(&symbols) else { return Ok(()) };
        let used = self.system.pool.symbols_of(&self.system.dynamics);
        let k = self.name("gain", &name);
        let about = format!("relative change of {name}: 0 means as commanded");
        let c = Coefficient { min: -1.0, ..amplitude(k.clone(), "1", about) };
        let pairs = symbols.iter().filter(|s| used.contains(s)).map(|&s| {
            let text = self.system.symbol_name(s).to_owned();
            (text.clone(), format!("((1 + {k})*{text})"))
        });
        let pairs = pairs.collect();
        self.substitution(Cause::InputGain, row, name, pairs, vec![c])
    }

    /// Values up to a size do not reach the equations, and larger ones less it.
    fn dead_zone(&mut self, index: usize) -> Result<(), DiagnoseError> {
        let Some(row) = self.first_row(&[self.system.inputs[index]]) else { return Ok(()) };
        let name = self.input(index);
        let k = self.name("dead_zone", &name);
        let about = format!("dead zone: {name} up to this size has no effect");
        let c = Coefficient { min: 0.0, ..dissipation(k.clone(), "", about) };
        let law = format!("(max({name} - {k}, 0) + min({name} + {k}, 0))");
        self.substitution(Cause::DeadZone, row, name.clone(), vec![(name, law)], vec![c])
    }

    /// Values beyond a limit act as the limit: in both directions, or in one.
    fn saturation(&mut self, index: usize, records: &[Record]) -> Result<(), DiagnoseError> {
        let Some(row) = self.first_row(&[self.system.inputs[index]]) else { return Ok(()) };
        let name = self.input(index);
        let values = records.iter().filter_map(|r| r.inputs.get(index)).flat_map(|signal| &signal.values);
        let (low, high) = extremes(values.copied());
        if low.partial_cmp(&high) != Some(Ordering::Less) {
            return Ok(());
        }
        let both = low < 0.0 && high > 0.0;
        let peak = high.max(-low);
        let sides = [(both, peak, 0.0, "limit"), (true, high, low, "upper_limit"), (true, low, high, "lower_limit")];
        for (_, far, near, base) in sides.into_iter().filter(|side| side.0) {
            let k = self.name(base, &name);
            let law = match base {
                "limit" => format!("max(-{k}, min({k}, {name}))"),
                "upper_limit" => format!("min({name}, {k})"),
                _ => format!("max({name}, {k})"),
            };
            let about = format!("{}: {name} beyond it has no further effect", base.replace('_', " "));
            let at = |share: f64| near + share * (far - near);
            let c = Coefficient {
                nominal: far,
                min: at(0.02).min(far),
                max: at(0.02).max(far),
                trials: LIMITS.map(at).to_vec(),
                physical_sign: if far > near { -1 } else { 1 },
                ..amplitude(k, "", about)
            };
            self.substitution(Cause::Saturation, row, name.clone(), vec![(name.clone(), law)], vec![c])?;
        }
        Ok(())
    }

    fn input(&self, index: usize) -> String {
        self.system.symbol_name(self.system.inputs[index]).to_owned()
    }

    /// The first equation in which one of the symbols stands, those of motions first.
    fn first_row(&self, symbols: &[Symbol]) -> Option<usize> {
        let coordinates = self.structure.coordinates.iter().map(|c| c.rate);
        let mut rows = coordinates.chain(self.structure.others.iter().copied());
        rows.find(|&row| symbols.iter().any(|&s| self.system.pool.depends_on(self.system.dynamics[row], s)))
    }
}
