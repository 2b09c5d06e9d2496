//! What one joint does to another.

use bracketry_symbolic::{Expr, Func, Joint, Notation, Pool, Relation};

use super::builder::{Builder, amplitude, dissipation, shape};
use super::structure::Coordinate;
use crate::effect::{Cause, Coefficient};
use crate::error::DiagnoseError;
use crate::formula::Formula;

impl Builder {
    /// Couplings between joints.
    pub(crate) fn add_joints(&mut self) -> Result<(), DiagnoseError> {
        let joints: Vec<Coordinate> = self.structure.coordinates.iter().filter(|c| c.is_joint()).cloned().collect();
        for (i, a) in joints.iter().enumerate() {
            for b in joints[i + 1..].iter().filter(|b| b.kind == a.kind) {
                self.turns_with_both(a, b)?;
                self.one_way(a, b)?;
                self.one_way(b, a)?;
            }
        }
        Ok(())
    }

    /// A part that turns with both joints, as a motor that drives through a differential: its inertia, its viscous and its
    /// dry friction.
    ///
    /// With the slip s = v_a + r v_b = nᵀv and M v' = Q the model, the part adds the forces −n T, T = f s + c sgn(s) + I s'.
    /// Since s' = nᵀM⁻¹(Q − n T), this is T = (f s + c sgn(s) + I α)/(1 + I μ) with α = nᵀv' of the model and
    /// μ = nᵀM⁻¹n (Sherman and Morrison 1950), and v' changes by −M⁻¹n T.
    fn turns_with_both(&mut self, a: &Coordinate, b: &Coordinate) -> Result<(), DiagnoseError> {
        let (v, w) = (self.state(a.rate), self.state(b.rate));
        let on = format!("{v}_{w}");
        let viscous = self.name("joint_viscous", &on);
        let dry = self.name("joint_coulomb", &on);
        let inertia = self.name("joint_inertia", &on);
        let r = self.name("joint_ratio", &on);
        let ratio = self.system.pool.var(&r);
        let mut direction = a.force.clone();
        for &(row, e) in &b.force {
            let e = self.system.pool.mul(e, ratio);
            match direction.iter_mut().find(|d| d.0 == row) {
                Some(d) => d.1 = self.system.pool.add(d.1, e),
                None => direction.push((row, e)),
            }
        }
        let entry = |row: usize| direction.iter().find(|d| d.0 == row).map_or("0".to_owned(), |d| self.text(d.1));
        let mobility = format!("({} + {r}*({}))", entry(a.rate), entry(b.rate));
        let rhs = |row: usize| self.text(self.system.dynamics[row]);
        let acceleration = format!("({} + {r}*({}))", rhs(a.rate), rhs(b.rate));
        let slip = format!("({v} + {r}*{w})");
        let law =
            format!("-({viscous}*{slip} + {dry}*sign{slip} + {inertia}*{acceleration})/(1 + {inertia}*{mobility})");
        let term = Formula::new(
            format!("-({viscous}*s + {dry}*sign(s) + {inertia}*der(s)), s = {v} + {r}*{w}"),
            shared([&viscous, &dry, &inertia], [&v, &r, &w]),
        );
        let part = |name: String, unit: String, what: &str| Coefficient {
            min: 0.0,
            ..dissipation(name, unit, format!("{what} shared by {v} and {w}"))
        };
        let coefficients = vec![
            part(viscous, a.unit(0, 1), "viscous friction"),
            part(dry, a.unit(0, 0), "dry friction"),
            part(inertia, a.inertia_unit(), "inertia"),
            Coefficient {
                nominal: 1.0,
                min: f64::NEG_INFINITY,
                ..shape(
                    r,
                    self.settings.joint_ratios.clone(),
                    "1",
                    format!("revolutions of the shared part per revolution of {w}"),
                )
            },
        ];
        self.described(Cause::JointCoupling, a.rate, term, &direction, &law, coefficients)
    }

    /// What joint b does to joint a through gears, bearings and cables.
    fn one_way(&mut self, a: &Coordinate, b: &Coordinate) -> Result<(), DiagnoseError> {
        let other = self.state(b.rate);
        let own = vec![(a.rate, self.system.pool.int(1))];
        let acceleration = self.text(self.system.dynamics[b.rate]);
        self.coupled(a, b, ("acceleration", "1"), &own, &format!("({acceleration})"))?;
        self.coupled(a, b, ("velocity", &a.unit(0, 1)), &a.force, &format!("(-{other})"))?;
        self.coupled(a, b, ("friction", &a.unit(0, 0)), &a.force, &format!("(-sign({other}))"))?;
        if let Some(q) = b.position {
            let q = self.state(q);
            self.coupled(a, b, ("position", &a.unit(1, 0)), &a.force, &format!("(-{q})"))?;
        }
        if let Some(u) = b.input
            && !self.system.pool.depends_on(self.system.dynamics[a.rate], self.system.inputs[u])
        {
            let name = self.system.symbol_name(self.system.inputs[u]).to_owned();
            self.coupled(a, b, ("drive", "1"), &a.force, &name)?;
        }
        Ok(())
    }

    fn coupled(
        &mut self,
        a: &Coordinate,
        b: &Coordinate,
        (what, unit): (&str, &str),
        direction: &[(usize, Expr)],
        law: &str,
    ) -> Result<(), DiagnoseError> {
        let (v, other) = (self.state(a.rate), self.state(b.rate));
        let k = self.name(&format!("joint_{what}_{other}"), &v);
        let about = format!("effect of the {what} of {other} on {v}");
        let c = amplitude(k.clone(), unit, about);
        self.along(Cause::JointCoupling, a.rate, direction, &format!("{k}*{law}"), vec![c])
    }
}

/// What two coordinates share, over their common slip s = v + r w.
fn shared(coefficients: [&String; 3], [v, r, w]: [&String; 3]) -> Notation {
    let mut pool = Pool::new();
    let (s, rate) = (pool.var("s"), pool.var("der(s)"));
    let sign = pool.call(Func::Sign, s);
    let terms = coefficients.map(|c| pool.var(c)).into_iter().zip([s, sign, rate]);
    let terms: Vec<Expr> = terms.map(|(c, e)| pool.mul(c, e)).collect();
    let sum = pool.sum(terms);
    let law = pool.neg(sum);
    let [v, r, w] = [v, r, w].map(|name| pool.var(name));
    let scaled = pool.mul(r, w);
    let slip = pool.add(v, scaled);
    let dotted = |name: &str| (name == "der(s)").then(|| Notation::symbol("s").dotted(1));
    let law = pool.notation(law).with_symbols(&dotted);
    Notation::List(Joint::Quad, vec![law, Notation::symbol("s").relation(Relation::Equal, pool.notation(slip))])
}
