//! Constant, elastic, and periodic forces, and play.

use std::f64::consts::TAU;

use bracketry_symbolic::{Expr, Symbol};

use super::builder::{Builder, amplitude, dissipation, log_grid, shape};
use super::names::TIME_INPUT;
use super::structure::{Coordinate, Kind, is_angle, is_constant};
use crate::effect::{Cause, Coefficient};
use crate::error::DiagnoseError;

impl Builder {
    /// Forces that depend on position or time, or on nothing.
    pub(crate) fn add_forces(&mut self) -> Result<(), DiagnoseError> {
        let tilted = self.tilt_of_angle_inputs()?;
        for c in self.structure.coordinates.clone() {
            let v = self.state(c.rate);
            let k = self.name("bias", &v);
            let coefficient = amplitude(k.clone(), c.force_unit.clone(), format!("constant force on {v}"));
            self.along(Cause::ConstantBias, c.rate, &c.force, &k, vec![coefficient])?;
            if c.kind == Kind::Translation && !tilted.contains(&c.rate) {
                self.tilt(&c)?;
            }
            self.stiffness(&c)?;
            self.periodic(&c)?;
        }
        self.lift_off()?;
        self.backlash()
    }

    /// Equations of states that are neither positions nor rates.
    pub(crate) fn add_first_order(&mut self) -> Result<(), DiagnoseError> {
        for row in self.structure.others.clone() {
            let x = self.state(row);
            let one = [(row, self.system.pool.int(1))];
            let k = self.name("bias", &x);
            let coefficient = amplitude(
                k.clone(),
                self.system.quantities.unit_of_derivative(&x, 1).unwrap_or_default(),
                format!("constant rate of {x}"),
            );
            self.along(Cause::ConstantBias, row, &one, &k, vec![coefficient])?;
            for (cause, base, law, about) in [
                (Cause::Leak, "leak", format!("*{x}"), "proportional to"),
                (Cause::QuadraticLoss, "quadratic_loss", format!("*abs({x})*{x}"), "with the square of"),
            ] {
                let k = self.name(base, &x);
                let coefficient = dissipation(k.clone(), "", format!("loss {about} {x}"));
                self.along(cause, row, &one, &format!("-{k}{law}"), vec![coefficient])?;
            }
        }
        Ok(())
    }

    /// Gravity that enters through the angle of an input: the angle is off by a constant. Returns the rates of the
    /// coordinates that this covers.
    fn tilt_of_angle_inputs(&mut self) -> Result<Vec<usize>, DiagnoseError> {
        let Some(g) = self.structure.gravity else { return Ok(Vec::new()) };
        let mut covered = Vec::new();
        for u in self.system.inputs.clone() {
            if !is_angle(&mut self.system, u) {
                continue;
            }
            let rows: Vec<usize> = self
                .structure
                .coordinates
                .clone()
                .iter()
                .filter(|c| {
                    // Where the angle is small, gravity changes with it in this equation.
                    let weight = self.system.pool.diff(self.system.dynamics[c.rate], g);
                    let change = self.system.pool.diff(weight, u);
                    let (u, zero) = (self.system.pool.sym(u), self.system.pool.int(0));
                    let change = self.system.pool.substitute(change, &std::iter::once((u, zero)).collect());
                    let change = self.system.pool.simplify(change);
                    !self.system.pool.is_zero(change)
                })
                .map(|c| c.rate)
                .collect();
            let Some(&first) = rows.first() else { continue };
            let name = self.system.symbol_name(u).to_owned();
            let k = self.name("tilt", &name);
            let about = format!("offset of the angle {name} in the gravity terms");
            let c = Coefficient { min: -1.0, max: 1.0, ..amplitude(k.clone(), "rad", about) };
            let on = self.state(first);
            let pairs = vec![(name.clone(), format!("({name} + {k})"))];
            self.substitution(Cause::Tilt, first, on, pairs, vec![c])?;
            covered.extend(rows);
        }
        Ok(covered)
    }

    /// A slope under a translation: a constant force. The load of its friction changes with the square of the slope only.
    fn tilt(&mut self, c: &Coordinate) -> Result<(), DiagnoseError> {
        let v = self.state(c.rate);
        let k = self.name("tilt", &v);
        if let (Some(g), None) = (self.structure.gravity, c.input) {
            let g = self.system.symbol_name(g).to_owned();
            let about = format!("slope along {v}");
            let coefficient = Coefficient { min: -1.0, max: 1.0, ..amplitude(k.clone(), "rad", about) };
            return self.along(Cause::Tilt, c.rate, &c.force, &format!("-{g}*{k}"), vec![coefficient]);
        }
        let about = format!("component of the weight on a slope, against {v}");
        let coefficient = amplitude(k.clone(), c.force_unit.clone(), about);
        self.along(Cause::Tilt, c.rate, &c.force, &format!("-{k}"), vec![coefficient])
    }

    fn stiffness(&mut self, c: &Coordinate) -> Result<(), DiagnoseError> {
        let Some(q) = c.position.map(|q| self.state(q)) else { return Ok(()) };
        for (cause, base, power) in [(Cause::LinearStiffness, "stiffness", 1), (Cause::CubicStiffness, "hardening", 3)]
        {
            let k = self.name(base, &q);
            let unit = c.unit(power, 0);
            let about = format!("force toward {q} = 0, of degree {power}");
            let law = if power == 1 { format!("-{k}*{q}") } else { format!("-{k}*{q}^3") };
            self.along(cause, c.rate, &c.force, &law, vec![dissipation(k, unit, about)])?;
        }
        Ok(())
    }

    /// Disturbances that repeat in position (cogging, eccentricity) or in time.
    fn periodic(&mut self, c: &Coordinate) -> Result<(), DiagnoseError> {
        let v = self.state(c.rate);
        if let Some(q) = c.position.map(|q| self.state(q)) {
            let extent = self.data.extent(&q).unwrap_or(1.0);
            let trials = match c.kind {
                Kind::Angle => self.settings.ripples_per_turn.iter().map(|n| TAU / n).collect(),
                Kind::Translation => log_grid(extent / 20.0, extent, 6),
            };
            self.wave(c, "ripple", &q, &q, trials, &c.length_unit)?;
        }
        self.wave(c, "hum", &v, TIME_INPUT, log_grid(0.02, 2.0, 6), self.system.quantities.time_unit.name())
    }

    fn wave(
        &mut self,
        c: &Coordinate,
        base: &str,
        on: &str,
        along: &str,
        trials: Vec<f64>,
        unit: &str,
    ) -> Result<(), DiagnoseError> {
        let (a, b) = (self.name(&format!("{base}_sin"), on), self.name(&format!("{base}_cos"), on));
        let p = self.name(&format!("{base}_period"), on);
        let about = |part: &str| format!("{part} of the disturbance that is periodic in {along}");
        let coefficients = vec![
            amplitude(a.clone(), c.force_unit.clone(), about("sine part")),
            amplitude(b.clone(), c.force_unit.clone(), about("cosine part")),
            Coefficient { period_of: Some(along.to_owned()), ..shape(p.clone(), trials, unit, about("period")) },
        ];
        let law = format!("({a}*sin(2*pi*{along}/{p}) + {b}*cos(2*pi*{along}/{p}))");
        self.along(Cause::PeriodicDisturbance, c.rate, &c.force, &law, coefficients)
    }

    /// Dry friction whose load can become negative: there it vanishes.
    fn lift_off(&mut self) -> Result<(), DiagnoseError> {
        for c in self.structure.coordinates.clone() {
            let Some(friction) = c.friction.clone() else { continue };
            let Some(&(_, level)) = friction.level.iter().find(|l| l.0 == c.rate) else { continue };
            let load = match friction.coefficient {
                Some(p) => self.system.pool.diff(level, p),
                None => level,
            };
            let load = self.system.pool.simplify(load);
            let values = self.data.values(&mut self.system, &[load]);
            let (least, most) =
                values.iter().fold((f64::INFINITY, 0.0f64), |(a, b), v| (a.min(v[0]), b.max(v[0].abs())));
            // Terms that the model lacks may make the load smaller still.
            if least > 0.3 * most || most == 0.0 {
                continue;
            }
            let v = self.state(c.rate);
            let k = self.name("lift_off", &v);
            let zero = self.system.pool.int(0);
            let lost = self.system.pool.call2(bracketry_symbolic::Func2::Min, level, zero);
            let entry = self.system.pool.mul(lost, friction.direction);
            let about = format!("1: friction against {v} vanishes where the load is negative; 0: it changes sign");
            let coefficient = Coefficient { min: 0.0, max: 1.0, ..dissipation(k.clone(), "1", about) };
            self.along(Cause::LiftOff, c.rate, &[(c.rate, entry)], &k, vec![coefficient])?;
        }
        Ok(())
    }

    /// Play between what drives and what is driven.
    ///
    /// Where the equations contain an elastic force between two positions (states or inputs), it acts only beyond half
    /// the width on either side. Of a force input the play is not seen: the gap would need a state of its own.
    fn backlash(&mut self) -> Result<(), DiagnoseError> {
        let positions: Vec<(usize, usize, Kind)> =
            self.structure.coordinates.iter().filter_map(|c| c.position.map(|q| (q, c.rate, c.kind))).collect();
        let mut partners: Vec<Symbol> = positions.iter().map(|p| self.system.states[p.0]).collect();
        partners.extend(self.system.inputs.clone());
        for &(q, row, kind) in &positions {
            let s = self.system.states[q];
            for (i, &other) in partners.iter().enumerate() {
                if other == s {
                    continue;
                }
                let f = self.system.dynamics[row];
                let (by_own, by_other) = (self.system.pool.diff(f, s), self.system.pool.diff(f, other));
                let sum = self.system.pool.add(by_own, by_other);
                let sum = self.system.pool.simplify(sum);
                let stiffness = self.system.pool.simplify(by_other);
                let constant = is_constant(&self.system, stiffness);
                if !self.system.pool.is_zero(sum) || self.system.pool.is_zero(stiffness) || !constant {
                    continue;
                }
                // Each pair of states once, with both reactions.
                let mirrored = positions.iter().position(|p| self.system.states[p.0] == other);
                if mirrored.is_some_and(|j| positions[j].0 < q) {
                    continue;
                }
                let mut rows: Vec<(usize, Expr)> = vec![(row, stiffness)];
                if let Some(j) = mirrored {
                    let reaction = self.system.pool.diff(self.system.dynamics[positions[j].1], other);
                    rows.push((positions[j].1, reaction));
                }
                let (a, b) = (self.system.symbol_name(s).to_owned(), self.system.symbol_name(partners[i]).to_owned());
                let k = self.name("play", &format!("{b}_{a}"));
                let about = format!("backlash between {b} and {a}");
                let coefficient = Coefficient { min: 0.0, ..dissipation(k.clone(), kind.unit(), about) };
                // d → max(d − k/2, 0) + min(d + k/2, 0)
                let d = format!("({b} - {a})");
                let law = format!("(max({d} - {k}/2, 0) + min({d} + {k}/2, 0) - {d})");
                self.along(Cause::Backlash, row, &rows, &law, vec![coefficient])?;
            }
        }
        Ok(())
    }
}
