//! What one joint does to another.

use bracketry_symbolic::Expr;

use super::builder::{Builder, amplitude, dissipation, shape};
use super::structure::{Coordinate, Kind};
use crate::effect::{Cause, Coefficient};
use crate::error::DiagnoseError;

/// Ratios tried for friction between two joints.
const RATIOS: [f64; 4] = [-1.0, -0.5, 0.5, 1.0];

impl Builder {
    /// Couplings between joints: rotations, or translations with drives of their own.
    pub(crate) fn add_joints(&mut self) -> Result<(), DiagnoseError> {
        let joints: Vec<Coordinate> = self
            .structure
            .coordinates
            .iter()
            .filter(|c| c.position.is_some() && (c.kind == Kind::Angle || c.input.is_some()))
            .cloned()
            .collect();
        for a in &joints {
            for b in &joints {
                if a.kind != b.kind {
                    continue;
                }
                if a.rate != b.rate {
                    self.one_way(a, b)?;
                }
                if a.rate < b.rate {
                    self.friction_between(a, b)?;
                }
            }
        }
        Ok(())
    }

    /// What joint b does to joint a through gears, bearings and cables.
    fn one_way(&mut self, a: &Coordinate, b: &Coordinate) -> Result<(), DiagnoseError> {
        let (v, other) = (self.state(a.rate), self.state(b.rate));
        let own = vec![(a.rate, self.system.pool.int(1))];
        let acceleration = self.text(self.system.dynamics[b.rate]);
        let parts: [(&str, &[(usize, Expr)], String, &str); 4] = [
            ("acceleration", &own, format!("({acceleration})"), "acceleration"),
            ("rate", &a.force, format!("(-{other})"), "velocity"),
            ("sign", &a.force, format!("(-sign({other}))"), "dry friction"),
            ("position", &a.force, b.position.map_or(String::new(), |q| format!("(-{})", self.state(q))), "position"),
        ];
        for (base, direction, law, what) in parts {
            self.coupled(a.rate, &v, &other, base, direction, &law, what)?;
        }
        if let Some(u) = b.input
            && !self.system.pool.depends_on(self.system.dynamics[a.rate], self.system.inputs[u])
        {
            let name = self.system.symbol_name(self.system.inputs[u]).to_owned();
            self.coupled(a.rate, &v, &other, "drive", &a.force, &name, "drive")?;
        }
        Ok(())
    }

    fn coupled(
        &mut self,
        row: usize,
        v: &str,
        other: &str,
        base: &str,
        direction: &[(usize, Expr)],
        law: &str,
        what: &str,
    ) -> Result<(), DiagnoseError> {
        let k = self.name(&format!("joint_{base}_{other}"), v);
        let about = format!("what the {what} of {other} does to {v}");
        self.along(Cause::JointCoupling, row, direction, &format!("{k}*{law}"), vec![amplitude(k.clone(), "", about)])
    }

    /// Friction against v_a + r v_b: a dissipative force on both.
    fn friction_between(&mut self, a: &Coordinate, b: &Coordinate) -> Result<(), DiagnoseError> {
        let (v, w) = (self.state(a.rate), self.state(b.rate));
        for (base, unit, dry) in [("joint_viscous", a.unit(0, 1), false), ("joint_coulomb", a.unit(0, 0), true)] {
            let on = format!("{v}_{w}");
            let k = self.name(base, &on);
            let r = self.name(&format!("{base}_ratio"), &on);
            let slip = format!("({v} + {r}*{w})");
            let law = if dry { format!("-{k}*sign{slip}") } else { format!("-{k}*{slip}") };
            let ratio = self.system.pool.var(&r);
            let mut direction = a.force.clone();
            for &(row, e) in &b.force {
                let e = self.system.pool.mul(e, ratio);
                match direction.iter_mut().find(|d| d.0 == row) {
                    Some(d) => d.1 = self.system.pool.add(d.1, e),
                    None => direction.push((row, e)),
                }
            }
            let c = dissipation(k.clone(), unit, format!("friction between {v} and {w}"));
            let c = if dry { Coefficient { min: 0.0, ..c } } else { c };
            let about = format!("part of {w} in the slip velocity");
            let ratio = Coefficient { min: f64::NEG_INFINITY, ..shape(r, RATIOS.to_vec(), "1", about) };
            self.along(Cause::JointCoupling, a.rate, &direction, &law, vec![c, ratio])?;
        }
        Ok(())
    }
}
