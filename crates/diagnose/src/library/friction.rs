//! Friction and drag against the rates of coordinates.

use bracketry_symbolic::{Expr, Func};

use super::builder::{Builder, amplitude, dissipation, log_grid, shape};
use super::structure::{Coordinate, Kind, is_constant};
use super::terms::slope;
use crate::effect::{Cause, Change, Coefficient};
use crate::error::DiagnoseError;

impl Builder {
    /// Effects of friction against each rate.
    pub(crate) fn add_friction(&mut self) -> Result<(), DiagnoseError> {
        let coordinates = self.structure.coordinates.clone();
        for (i, c) in coordinates.iter().enumerate() {
            if self.spins_freely(c) {
                self.yaw_friction(c)?;
                self.quadratic_drag(c)?;
                continue;
            }
            self.viscous_and_coulomb(c)?;
            // A unit vector has one law for all its components.
            let square = c.friction.as_ref().and_then(|f| f.square);
            let group: Vec<&Coordinate> = match square {
                Some(_) => {
                    coordinates.iter().filter(|o| o.friction.as_ref().is_some_and(|f| f.square == square)).collect()
                }
                None => vec![c],
            };
            if square.is_none() || coordinates[..i].iter().all(|o| group.iter().all(|g| g.rate != o.rate)) {
                self.stribeck(&group)?;
            }
            self.quadratic_drag(c)?;
            self.asymmetry(c)?;
        }
        self.coupling()?;
        self.pressure_radius()?;
        self.anisotropy()
    }

    fn viscous_and_coulomb(&mut self, c: &Coordinate) -> Result<(), DiagnoseError> {
        let v = self.state(c.rate);
        let k = self.name("viscous", &v);
        let coefficient = dissipation(k.clone(), c.unit(0, 1), format!("viscous friction against {v}"));
        self.along(Cause::ViscousFriction, c.rate, &c.force, &format!("-{k}*{v}"), vec![coefficient])?;
        if c.has_dry_friction {
            return Ok(());
        }
        let k = self.name("coulomb", &v);
        let coefficient = Coefficient {
            min: 0.0,
            ..dissipation(k.clone(), c.force_unit.clone(), format!("Coulomb friction against {v}"))
        };
        self.along(Cause::CoulombFriction, c.rate, &c.force, &format!("-{k}*sign({v})"), vec![coefficient])
    }

    /// What a unit of the friction coefficient takes from each row, the unit and the value of the coefficient.
    fn friction_unit(&mut self, c: &Coordinate) -> (Vec<(usize, Expr)>, String, f64) {
        let Some(friction) = &c.friction else { return (c.force.clone(), c.force_unit.clone(), 0.0) };
        let Some(p) = friction.coefficient else { return (friction.level.clone(), "1".to_owned(), 1.0) };
        let level = friction.level.iter().map(|&(row, e)| (row, slope(&mut self.system.pool, e, p))).collect();
        let parameter = self.system.parameters.iter().find(|q| q.symbol == p);
        let unit = parameter.and_then(|q| q.unit.clone()).unwrap_or_default();
        (level, unit, parameter.map_or(1.0, |q| q.value.to_f64().value()))
    }

    /// Friction that changes at low speed, Gaussian and exponential: Stribeck friction, or a concave law where the
    /// coefficient is negative. It is a change of Coulomb friction: where the model has none, that comes with it, for friction
    /// that is there at low speeds only is no friction of sliding bodies.
    fn stribeck(&mut self, group: &[&Coordinate]) -> Result<(), DiagnoseError> {
        let Some(first) = group.first() else { return Ok(()) };
        let v = self.state(first.rate);
        let square = first.friction.as_ref().and_then(|f| f.square).map(|s| self.text(s));
        let fastest = group.iter().filter_map(|c| self.data.extent(&self.state(c.rate))).fold(0.0, f64::max);
        let fastest = if fastest > 0.0 { fastest } else { 1.0 };
        let (least, most) = self.settings.stribeck_range;
        let trials = log_grid(least * fastest, most * fastest, self.settings.stribeck_trials);
        for (form, exponent) in [("gauss", 2), ("exp", 1)] {
            let k = self.name(if exponent == 2 { "stribeck" } else { "stribeck_exp" }, &v);
            let s = self.name(&format!("{k}_velocity"), "");
            let fade = match (&square, exponent) {
                (Some(square), 2) => format!("exp(-({square})/{s}^2)"),
                (Some(square), _) => format!("exp(-sqrt({square})/{s})"),
                (None, 2) => format!("exp(-({v}/{s})^2)"),
                (None, _) => format!("exp(-abs({v})/{s})"),
            };
            let mut terms: Vec<(usize, Expr)> = Vec::new();
            let (mut unit, mut at_rest) = (String::new(), 0.0);
            for c in group {
                let (level, u, value) = self.friction_unit(c);
                (unit, at_rest) = (u, value);
                let rate = self.system.pool.sym(self.system.states[c.rate]);
                let sign = self.system.pool.call(Func::Sign, rate);
                let direction = c.friction.as_ref().map_or(sign, |f| f.direction);
                for (row, e) in level {
                    let e = self.system.pool.mul(e, direction);
                    match terms.iter_mut().find(|t| t.0 == row) {
                        Some(t) => t.1 = self.system.pool.add(t.1, e),
                        None => terms.push((row, e)),
                    }
                }
            }
            let sliding = (!first.has_dry_friction).then(|| {
                let name = self.name(&format!("{k}_sliding"), "");
                let about = format!("dry friction at speeds {v} well above the Stribeck speed");
                Coefficient { min: 0.0, ..dissipation(name, unit.clone(), about) }
            });
            let about = format!(
                "static minus sliding friction ({form}: decays with speed); negative: a concave law, friction grows from rest"
            );
            let c = Coefficient { min: -at_rest, ..amplitude(k.clone(), unit, about) };
            let unit = first.speed_unit();
            let speed = shape(s, trials.clone(), unit, "speed at which the change of friction decays");
            let law = match &sliding {
                Some(level) => format!("-({} + {k}*{fade})", level.name),
                None => format!("-{k}*{fade}"),
            };
            let coefficients = sliding.into_iter().chain([c, speed]).collect();
            self.along(Cause::StribeckFriction, first.rate, &terms, &law, coefficients)?;
        }
        Ok(())
    }

    fn quadratic_drag(&mut self, c: &Coordinate) -> Result<(), DiagnoseError> {
        let v = self.state(c.rate);
        let k = self.name("drag", &v);
        let coefficient = dissipation(k.clone(), c.unit(0, 2), format!("drag proportional to the square of {v}"));
        self.along(Cause::QuadraticDrag, c.rate, &c.force, &format!("-{k}*abs({v})*{v}"), vec![coefficient])
    }

    /// Friction that depends on the direction. Its Coulomb part is a constant while the body moves; where the friction of
    /// the model holds the body, the constant shifts the forces that it withstands, as direction-dependent friction does.
    fn asymmetry(&mut self, c: &Coordinate) -> Result<(), DiagnoseError> {
        let v = self.state(c.rate);
        let b = self.name("asymmetry_viscous", &v);
        let about = format!("half the difference of viscous friction between {v} > 0 and {v} < 0");
        let viscous = amplitude(b.clone(), c.unit(0, 1), about);
        if c.friction.is_none() {
            return self.along(Cause::FrictionAsymmetry, c.rate, &c.force, &format!("-{b}*abs({v})"), vec![viscous]);
        }
        let a = self.name("asymmetry_coulomb", &v);
        let about = format!("half the difference of Coulomb friction between {v} > 0 and {v} < 0");
        let coulomb = amplitude(a.clone(), c.force_unit.clone(), about);
        let law = format!("-({a} + {b}*abs({v}))");
        self.along(Cause::FrictionAsymmetry, c.rate, &c.force, &law, vec![coulomb, viscous])
    }

    /// A rotation without friction against its rate, of a body that also slides.
    fn spins_freely(&mut self, c: &Coordinate) -> bool {
        let slides = self.structure.translations().any(|t| t.has_dry_friction);
        let rate = self.system.states[c.rate];
        c.kind == Kind::Angle
            && slides
            && c.input.is_none()
            && !c.has_dry_friction
            && !self.system.pool.depends_on(self.system.dynamics[c.rate], rate)
    }

    /// The level of dry friction of the contact that a body slides on, as the equation of one translation has it; where the load
    /// changes in one of them, that one, for a body has one load. None where nothing depends on states or inputs.
    fn changing_level(&self) -> Option<Expr> {
        let levels = self.structure.translations().filter_map(|t| {
            let friction = t.friction.as_ref()?;
            friction.level.iter().find(|l| l.0 == t.rate).map(|l| l.1)
        });
        levels.into_iter().find(|&level| !is_constant(&self.system, level))
    }

    /// Friction of a sliding contact against the spin: shared with the slip, which makes it an ellipsoidal limit surface, viscous,
    /// or Coulomb's. Dry friction is in proportion to the load. Trials of the radius are shares of the length at which slip and spin of the
    /// data are as fast: a body that is moved slips faster than its parts turn.
    fn yaw_friction(&mut self, c: &Coordinate) -> Result<(), DiagnoseError> {
        let w = self.state(c.rate);
        let slips: Vec<String> =
            self.structure.translations().filter(|t| t.has_dry_friction).map(|t| self.state(t.rate)).collect();
        let (dry, unit, per) = match self.changing_level() {
            Some(level) => (vec![(c.rate, level)], "1/m", ", per friction of the contact against its slip"),
            None => (c.force.clone(), "rad/s^2", ""),
        };

        let k = self.name("spin_ratio", &w);
        let rho = self.name("spin_gyration", &w);
        let slip = slips.iter().filter_map(|v| self.data.extent(v)).fold(0.0, f64::max);
        let spin = self.data.extent(&w).unwrap_or(1.0);
        let radius = if slip > 0.0 { slip / spin } else { 0.1 };
        // With the radius that counts in the slip as a share of that of the inertia, the data tell how strong the friction is, and hardly at
        // which radius: two lengths would both be uncertain.
        let about = "lever arm of the spin in the slip, divided by the radius of gyration of the body: 0 means no friction against the spin";
        let ratio = Coefficient { min: 0.0, trials: vec![0.7], ..dissipation(k.clone(), "1", about) };
        let about = "radius of gyration of the body about the axis of the spin";
        let gyration = shape(rho.clone(), log_grid(0.03 * radius, 0.1 * radius, 3), "m", about);
        let law = format!("-{k}/{rho}*unit({k}*{rho}*{w}, {})", slips.join(", "));
        self.along(Cause::YawFriction, c.rate, &dry, &law, vec![ratio, gyration])?;
        self.share_slip(&w, &format!("{k}*{rho}"));

        let k = self.name("spin_viscous", &w);
        let coefficient = dissipation(k.clone(), c.unit(0, 1), format!("viscous friction against the spin {w}"));
        self.along(Cause::YawFriction, c.rate, &c.force, &format!("-{k}*{w}"), vec![coefficient])?;

        let k = self.name("spin_coulomb", &w);
        let about = format!("Coulomb friction against the spin {w}{per}");
        let coefficient = Coefficient { min: 0.0, ..dissipation(k.clone(), unit, about) };
        self.along(Cause::YawFriction, c.rate, &dry, &format!("-{k}*sign({w})"), vec![coefficient])
    }

    /// The effect added last also lets the spin take part in the slip of the contact, whose friction then has components over the root of
    /// `vx² + vy² + l² w²`, an ellipsoidal limit surface (Goyal, Ruina, and Papadopoulos 1991): a body that spins slides more easily.
    fn share_slip(&mut self, w: &str, length: &str) {
        let sliding: Vec<Coordinate> = self.structure.translations().filter(|c| c.has_dry_friction).cloned().collect();
        let slips: Vec<String> = sliding.iter().map(|c| self.state(c.rate)).collect();
        let square = match sliding.first().and_then(|c| c.friction.as_ref()?.square) {
            Some(square) => self.text(square),
            None => slips.iter().map(|v| format!("{v}^2")).collect::<Vec<_>>().join(" + "),
        };
        let spins = vec![(w.to_owned(), length.to_owned())];
        if let Some(effect) = self.effects.last_mut().filter(|e| e.cause == Cause::YawFriction) {
            let shared = Change::Stretch { square, slips, lengths: Vec::new(), spins };
            effect.change = Change::Several(vec![effect.change.clone(), shared]);
        }
    }

    /// Per-axis dry friction becomes friction against the direction of the slip.
    pub(crate) fn coupling(&mut self) -> Result<(), DiagnoseError> {
        let axes: Vec<(usize, Expr)> = self
            .structure
            .translations()
            .filter_map(|c| c.friction.as_ref().filter(|f| f.square.is_none()).map(|f| (c.rate, f.direction)))
            .collect();
        if axes.len() < 2 {
            return Ok(());
        }
        let names: Vec<String> = axes.iter().map(|a| self.state(a.0)).collect();
        let k = self.name("coupling", &names.join("_"));
        let pairs = axes
            .iter()
            .zip(&names)
            .map(|(&(_, direction), v)| {
                let old = self.text(direction);
                let mut along = vec![v.as_str()];
                along.extend(names.iter().filter(|o| *o != v).map(String::as_str));
                let new = format!("(1 - {k})*{old} + {k}*unit({})", along.join(", "));
                (old, new)
            })
            .collect();
        let about = "1: dry friction acts against the direction of the slip; 0: along each axis independently";
        // Altogether or not at all: a small part of it changes nothing where friction on each axis holds a body that in truth
        // slips along the other one, and in a mixture of both the forces on a body at rest are not determined.
        let c = Coefficient { min: 1.0, max: 1.0, trials: vec![1.0], ..dissipation(k, "1", about) };
        self.substitution(Cause::FrictionCoupling, axes[0].0, names.join(", "), pairs, vec![c])
    }

    /// Dry friction that differs between axes.
    fn anisotropy(&mut self) -> Result<(), DiagnoseError> {
        let axes: Vec<Coordinate> = self.structure.translations().filter(|c| c.friction.is_some()).cloned().collect();
        if axes.len() < 2 {
            return Ok(());
        }
        // The others' friction is the reference.
        for c in &axes[1..] {
            let Some(friction) = &c.friction else { continue };
            let v = self.state(c.rate);
            let k = self.name("anisotropy", &v);
            let about = format!("dry friction against {v} relative to that along the other axes, minus 1");
            let coefficient = Coefficient { min: -1.0, ..amplitude(k.clone(), "1", about) };
            let direction = self.text(friction.direction);
            if let Some(square) = friction.square {
                self.elliptic(c, square, &k, coefficient)?;
                continue;
            }
            self.along(
                Cause::AnisotropicFriction,
                c.rate,
                &friction.level,
                &format!("-{k}*({direction})"),
                vec![coefficient],
            )?;
        }
        Ok(())
    }

    /// An elliptic limit surface: with D = diag(1, …, 1 + k, …) the friction acts along D² v/|D v|, so that dissipation is
    /// greatest among all forces within the ellipse. All components of the unit vector get the new root.
    ///
    /// Where the root holds a spin w too, as `sqrt(vx^2 + vy^2 + S w^2)`, the friction of a footprint against it is that of its parts,
    /// which slip across the mean slip: to second order in the spin `det(D)² |v|²/|D v|²` times as great as with the same friction along
    /// all axes, which depends on the direction of the slip. Its mean over the data has a coefficient of its own.
    fn elliptic(
        &mut self,
        c: &Coordinate,
        square: Expr,
        k: &str,
        coefficient: Coefficient,
    ) -> Result<(), DiagnoseError> {
        let mut coefficients = vec![coefficient];
        let mut lengths = vec![(c.rate, format!("(1 + {k})"))];
        for spin in self.spins_within(square) {
            let w = self.state(spin);
            let q = self.name("anisotropy_spin", &w);
            let about = format!(
                "root of the friction against the spin {w} over that with equal friction along all axes, minus 1"
            );
            coefficients.push(Coefficient { min: -1.0, ..amplitude(q.clone(), "1", about) });
            lengths.push((spin, format!("(1 + {q})")));
        }
        self.stretch(Cause::AnisotropicFriction, c.rate, square, &lengths, coefficients)
    }

    /// The rates of angles under a root.
    fn spins_within(&self, square: Expr) -> Vec<usize> {
        let angles = self.structure.coordinates.iter().filter(|c| c.kind == Kind::Angle).map(|c| c.rate);
        angles.filter(|&spin| self.system.pool.depends_on(square, self.system.states[spin])).collect()
    }

    /// Pressure farther out or in than the model has it, as under a body that stands on its rim: where the root of the contact's
    /// friction holds a spin w, as `sqrt(vx^2 + vy^2 + S w^2)`, the second moment S of the pressure is (1 + q)² times as large.
    /// The inertia of the body stays.
    fn pressure_radius(&mut self) -> Result<(), DiagnoseError> {
        let Some(square) = self.structure.translations().find_map(|c| c.friction.as_ref()?.square) else {
            return Ok(());
        };
        for spin in self.spins_within(square) {
            let w = self.state(spin);
            let q = self.name("pressure_radius", &w);
            let about = "radius of gyration of the pressure over that of the model, minus 1".to_owned();
            let coefficient = Coefficient { min: -1.0, ..amplitude(q.clone(), "1", about) };
            let lengths = [(spin, format!("(1 + {q})"))];
            self.stretch(Cause::PressureRadius, spin, square, &lengths, vec![coefficient])?;
        }
        Ok(())
    }
}
