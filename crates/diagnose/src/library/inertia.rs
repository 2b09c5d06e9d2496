//! Inertial forces of moving frames.

use bracketry_symbolic::Expr;

use super::builder::{Builder, amplitude};
use super::names::derivative_name;
use super::physical_terms::physical_terms;
use super::structure::{Coordinate, Kind, is_angle, is_constant};
use super::terms::slope;
use crate::effect::{Cause, Coefficient};
use crate::error::DiagnoseError;

/// The rotation of a frame: its angle, rate and acceleration as texts.
struct Rotation {
    name: String,
    rate: String,
    acceleration: String,
    /// The coordinate, if the angle is a state.
    row: Option<usize>,
}

impl Builder {
    /// Inertial couplings between coordinates and rotations, in the equations and in the load of dry friction.
    pub(crate) fn add_inertia(&mut self) -> Result<(), DiagnoseError> {
        let rotations = self.rotations();
        for c in self.structure.coordinates.clone() {
            for r in &rotations {
                if r.row != Some(c.rate) && self.feels(&c, r) {
                    self.moving_frame(&c, r)?;
                }
            }
        }
        self.load_of_other_axes()?;
        self.existing()
    }

    /// Inputs and coordinates that are angles.
    fn rotations(&mut self) -> Vec<Rotation> {
        let mut rotations = Vec::new();
        for u in self.system.inputs.clone() {
            if is_angle(&mut self.system, u) {
                let name = self.system.symbol_name(u).to_owned();
                let (rate, acceleration) = (derivative_name(&name, 1), derivative_name(&name, 2));
                rotations.push(Rotation { name, rate, acceleration, row: None });
            }
        }
        for c in &self.structure.coordinates {
            if c.kind == Kind::Angle
                && let Some(q) = c.position
            {
                let acceleration = format!("({})", self.text(self.system.dynamics[c.rate]));
                let (name, rate) = (self.state(q), self.state(c.rate));
                rotations.push(Rotation { name, rate, acceleration, row: Some(c.rate) });
            }
        }
        rotations
    }

    /// Whether a translation takes place in a frame that turns: its equation contains the angle or a derivative of it.
    fn feels(&self, c: &Coordinate, r: &Rotation) -> bool {
        let used = self.system.pool.symbols_of(&[self.system.dynamics[c.rate]]);
        let names = [r.name.clone(), derivative_name(&r.name, 1), derivative_name(&r.name, 2)];
        let rate = r.row.map(|row| self.state(row));
        c.kind == Kind::Angle
            || used.iter().any(|&s| {
                let name = self.system.symbol_name(s);
                names.iter().any(|n| n == name) || rate.as_deref() == Some(name)
            })
    }

    /// A body has one load. Where dry friction of one axis follows a load that changes and that of another axis does not,
    /// it may have to.
    fn load_of_other_axes(&mut self) -> Result<(), DiagnoseError> {
        let mut loads = Vec::new();
        for c in self.structure.translations().cloned().collect::<Vec<_>>() {
            let Some((friction, p)) = c.friction.clone().and_then(|f| f.coefficient.map(|p| (f, p))) else { continue };
            let Some(level) = friction.level.iter().find(|l| l.0 == c.rate).map(|l| l.1) else { continue };
            let load = slope(&mut self.system.pool, level, p);
            let constant = is_constant(&self.system, load);
            loads.push((c, friction, p, load, constant));
        }
        let Some(changing) = loads.iter().find(|l| !l.4).map(|l| (l.2, l.3, self.state(l.0.rate))) else {
            return Ok(());
        };
        for (c, friction, p, load, constant) in loads {
            if !constant || p != changing.0 {
                continue;
            }
            let v = self.state(c.rate);
            let k = self.name("load", &v);
            let missing = self.system.pool.sub(load, changing.1);
            let p = self.system.pool.sym(p);
            let entry = self.system.pool.mul(p, missing);
            let entry = self.system.pool.mul(entry, friction.direction);
            let about =
                format!("1: friction against {v} follows the load that acts against {}; 0: it does not", changing.2);
            let coefficient = amplitude(k.clone(), "1", about);
            self.along(Cause::InertialCoupling, c.rate, &[(c.rate, entry)], &k, vec![coefficient])?;
        }
        Ok(())
    }

    fn inertial(
        &mut self,
        c: &Coordinate,
        on: &str,
        direction: &[(usize, Expr)],
        law: &str,
    ) -> Result<(), DiagnoseError> {
        let v = self.state(c.rate);
        let k = self.name(&format!("inertia_{on}"), &v);
        let about = format!("inertial coupling into {v}");
        self.along(
            Cause::InertialCoupling,
            c.rate,
            direction,
            &format!("{k}*{law}"),
            vec![amplitude(k.clone(), "", about)],
        )
    }

    /// Centrifugal, Euler and Coriolis terms of one rotation in one equation.
    fn moving_frame(&mut self, c: &Coordinate, r: &Rotation) -> Result<(), DiagnoseError> {
        let own = vec![(c.rate, self.system.pool.int(1))];
        let (rate, acceleration) = (&r.rate, &r.acceleration);
        match c.kind {
            Kind::Translation => {
                let others: Vec<(String, String)> = self
                    .structure
                    .translations()
                    .filter_map(|t| t.position.map(|q| (q, t.rate)))
                    .collect::<Vec<_>>()
                    .into_iter()
                    .map(|(q, v)| (self.state(q), self.state(v)))
                    .collect();
                for (q, v) in others {
                    self.inertial(c, &format!("{q}_{}_squared", r.name), &own, &format!("{q}*{rate}^2"))?;
                    self.inertial(c, &format!("{q}_{}_acceleration", r.name), &own, &format!("{q}*{acceleration}"))?;
                    self.inertial(c, &format!("{v}_{}_rate", r.name), &own, &format!("{v}*{rate}"))?;
                }
                self.inertial(c, &format!("{}_acceleration", r.name), &own, acceleration)?;
                self.inertial(c, &format!("{}_squared", r.name), &own, &format!("{rate}^2"))?;
                self.load(c, r)
            }
            Kind::Angle => {
                let Some(q) = c.position.map(|q| self.state(q)) else { return Ok(()) };
                self.inertial(c, &format!("sin2_{}_squared", r.name), &own, &format!("sin(2*{q})*{rate}^2"))?;
                self.inertial(c, &format!("cos2_{}_squared", r.name), &own, &format!("cos(2*{q})*{rate}^2"))?;
                if r.row.is_none() {
                    return self.inertial(c, &format!("{}_acceleration", r.name), &own, acceleration);
                }
                let (a, w) = (format!("({} - {q})", r.name), self.state(c.rate));
                self.inertial(c, &format!("sin_{}_squared", r.name), &own, &format!("sin{a}*{rate}^2"))?;
                self.inertial(c, &format!("cos_{}_acceleration", r.name), &own, &format!("cos{a}*{acceleration}"))?;
                self.inertial(c, &format!("sin_{}_rates", r.name), &own, &format!("sin({})*{rate}*{w}", r.name))?;
                self.inertial(c, &format!("sin_{}_alone", r.name), &own, &format!("sin({})*{rate}^2", r.name))
            }
        }
    }

    /// The load of dry friction on a body that moves in a turning frame.
    fn load(&mut self, c: &Coordinate, r: &Rotation) -> Result<(), DiagnoseError> {
        let Some(friction) = c.friction.clone() else { return Ok(()) };
        // Only where the model says that the load changes with this rotation.
        let Some(input) = self.system.pool.find_symbol(&r.name) else { return Ok(()) };
        let level = friction.level.iter().find(|l| l.0 == c.rate).map(|l| l.1);
        let turning = level.is_some_and(|l| self.system.pool.depends_on(l, input));
        if !turning || r.row.is_some() {
            return Ok(());
        }
        let (Some(q), v) = (c.position.map(|q| self.state(q)), self.state(c.rate)) else { return Ok(()) };
        // A body has one load: what changes it changes its friction along every axis with the same coefficient.
        let axes: Vec<(usize, Expr)> = self
            .structure
            .translations()
            .filter_map(|t| {
                Some((t.rate, t.friction.as_ref().filter(|f| f.coefficient == friction.coefficient)?.direction))
            })
            .collect();
        let mut direction = Vec::with_capacity(axes.len());
        for (row, along) in axes {
            let minus = self.system.pool.neg(along);
            let per_load = match friction.coefficient {
                Some(p) => {
                    let p = self.system.pool.sym(p);
                    self.system.pool.mul(minus, p)
                }
                None => minus,
            };
            direction.push((row, per_load));
        }
        let (rate, acceleration) = (&r.rate, &r.acceleration);
        self.inertial(c, &format!("load_{v}_{}_rate", r.name), &direction, &format!("{v}*{rate}"))?;
        self.inertial(c, &format!("load_{q}_{}_acceleration", r.name), &direction, &format!("{q}*{acceleration}"))?;
        self.inertial(c, &format!("load_{}_squared", r.name), &direction, &format!("{rate}^2"))
    }

    /// Terms of the equations that come from the motion of a frame, in another size: all that a model says of them may be
    /// a factor off, even of the wrong sign.
    fn existing(&mut self) -> Result<(), DiagnoseError> {
        let derivatives: Vec<_> = self.system.input_derivatives.iter().map(|d| d.symbol).collect();
        for c in self.structure.coordinates.clone() {
            let row = self.system.dynamics[c.rate];
            for term in physical_terms(&mut self.system, &self.structure, row) {
                let used = self.system.pool.symbols_of(&[term]);
                if !used.iter().any(|s| derivatives.contains(s)) {
                    continue;
                }
                let v = self.state(c.rate);
                let k = self.name("scale", &v);
                let about = format!("relative change of a term in the equation of {v}: 0 means unchanged");
                let coefficient = Coefficient { sign_flipped: Some(-2.0), ..amplitude(k.clone(), "1", about) };
                self.along(Cause::InertialCoupling, c.rate, &[(c.rate, term)], &k, vec![coefficient])?;
            }
        }
        Ok(())
    }
}
