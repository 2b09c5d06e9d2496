//! Building blocks for terms that no cause of the library stands for.

use std::f64::consts::TAU;

use bracketry_symbolic::Expr;
use bracketry_system::System;

use super::builder::{Builder, amplitude, log_grid, shape};
use super::structure::Kind;
use crate::effect::{Cause, Coefficient, Effect};
use crate::error::DiagnoseError;
use crate::record::Record;
use crate::settings::LibrarySettings;

/// The equation that a term is added to.
struct Place {
    row: usize,
    force: Vec<(usize, Expr)>,
    unit: String,
    q: Option<String>,
    v: String,
    is_rate: bool,
    /// What kind of joint it is, for which the library has couplings.
    joint: Option<Kind>,
}

/// Smooth functions of the variables of the model (powers, products, sines of a profiled frequency, saturating and fading
/// functions), as forces on each coordinate and as rates of each state of first order: effects of the cause
/// [`Cause::UnknownTerm`] with one amplitude each, from which a sparse combination may describe what is missing.
///
/// What [`super::candidates`] proposes for the same equation is not repeated, and no name of a coefficient occurs there.
///
/// # Errors
/// As [`super::candidates`].
pub fn dictionary(
    system: &System,
    records: &[Record],
    settings: &LibrarySettings,
) -> Result<Vec<Effect>, DiagnoseError> {
    let mut builder = Builder::new(system, records, settings);
    let one = builder.system.pool.int(1);
    let mut places: Vec<Place> = Vec::new();
    for c in builder.structure.coordinates.clone() {
        let q = c.position.map(|q| builder.state(q));
        let v = builder.state(c.rate);
        let joint = c.is_joint().then_some(c.kind);
        places.push(Place { row: c.rate, force: c.force, unit: c.force_unit, q, v, is_rate: true, joint });
    }
    for row in builder.structure.others.clone() {
        let v = builder.state(row);
        places.push(Place {
            row,
            force: vec![(row, one)],
            unit: String::new(),
            q: None,
            v,
            is_rate: false,
            joint: None,
        });
    }
    let inputs: Vec<String> = builder
        .system
        .inputs
        .iter()
        .filter(|u| builder.system.pool.symbols_of(&builder.system.dynamics).contains(u))
        .map(|&u| builder.system.symbol_name(u).to_owned())
        .collect();
    for place in &places {
        let mut terms = Terms { builder: &mut builder, place, count: 0 };
        terms.of_rate()?;
        terms.of_position()?;
        for u in &inputs {
            terms.of_input(u)?;
        }
        for other in places.iter().filter(|o| o.row != place.row) {
            terms.of_other(other)?;
        }
    }
    Ok(builder.effects)
}

/// Adds the terms of one equation.
struct Terms<'a> {
    builder: &'a mut Builder,
    place: &'a Place,
    count: usize,
}

impl Terms<'_> {
    fn add(&mut self, function: &str) -> Result<(), DiagnoseError> {
        self.add_with(function, None)
    }

    /// A term `c f`; a shape stands in `f` as `#`.
    fn add_with(&mut self, function: &str, trials: Option<(Vec<f64>, &str)>) -> Result<(), DiagnoseError> {
        self.count += 1;
        let k = self.builder.name(&format!("c{}", self.count), &self.place.v);
        let about = format!("amplitude of a term in the equation of {}", self.place.v);
        let mut coefficients = vec![amplitude(k.clone(), "", about)];
        let mut law = format!("{k}*{function}");
        if let Some((trials, about)) = trials {
            let s = self.builder.name(&format!("s{}", self.count), &self.place.v);
            law = law.replace('#', &s);
            coefficients.push(shape(s, trials, "", about));
        }
        if function == "1" {
            coefficients[0] = Coefficient { unit: self.place.unit.clone(), ..coefficients[0].clone() };
        }
        self.builder.along(Cause::UnknownTerm, self.place.row, &self.place.force, &law, coefficients)
    }

    fn of_rate(&mut self) -> Result<(), DiagnoseError> {
        let v = self.place.v.clone();
        for f in [format!("{v}^2"), format!("{v}^3"), format!("{v}^5")] {
            self.add(&f)?;
        }
        let fastest = self.builder.data.extent(&v).unwrap_or(1.0);
        let speeds = log_grid(0.02 * fastest, 0.5 * fastest, self.builder.settings.speed_trials);
        self.add_with(&format!("tanh({v}/#)"), Some((speeds.clone(), "where the function saturates")))?;
        self.add_with(&format!("exp(-abs({v})/#)"), Some((speeds, "where the function decays")))?;
        if self.place.is_rate {
            self.add(&format!("sqrt(abs({v}))*sign({v})"))
        } else {
            self.add(&format!("sqrt(abs({v}))"))
        }
    }

    fn of_position(&mut self) -> Result<(), DiagnoseError> {
        let (Some(q), v) = (self.place.q.clone(), self.place.v.clone()) else { return Ok(()) };
        for f in ["{q}^2", "{q}*{v}", "{q}^2*{v}", "sign({v})*{q}", "sign({v})*{q}^2", "abs({q})", "sign({q})"] {
            let f = f.replace("{q}", &q).replace("{v}", &v);
            self.add(&f)?;
        }
        let extent = self.builder.data.extent(&q).unwrap_or(1.0);
        let waves: Vec<f64> =
            (-1..=self.builder.settings.most_waves).map(|k| TAU / (2.0 * extent) * 2f64.powi(k)).collect();
        for f in [
            "sin(#*{q})",
            "cos(#*{q})",
            "{v}*sin(#*{q})",
            "{v}*cos(#*{q})",
            "sign({v})*sin(#*{q})",
            "sign({v})*cos(#*{q})",
        ] {
            let f = f.replace("{q}", &q).replace("{v}", &v);
            self.add_with(&f, Some((waves.clone(), "waves per unit of the coordinate, times 2 pi")))?;
        }
        Ok(())
    }

    fn of_input(&mut self, u: &str) -> Result<(), DiagnoseError> {
        let v = self.place.v.clone();
        for f in
            [format!("{u}^2"), format!("{u}^3"), format!("{u}*abs({u})"), format!("{u}*{v}"), format!("{u}*abs({v})")]
        {
            self.add(&f)?;
        }
        match self.place.q.clone() {
            Some(q) => self.add(&format!("{u}*{q}")),
            None => Ok(()),
        }
    }

    fn of_other(&mut self, other: &Place) -> Result<(), DiagnoseError> {
        let (v, w) = (self.place.v.clone(), &other.v);
        let coupled = self.place.joint.is_some() && self.place.joint == other.joint;
        if !coupled {
            self.add(w)?;
        }
        for f in [format!("{w}^2"), format!("{v}*{w}"), format!("abs({w})*{w}")] {
            self.add(&f)?;
        }
        let Some(p) = &other.q else { return Ok(()) };
        if !coupled {
            self.add(p)?;
        }
        self.add(&format!("{p}^2"))?;
        self.add(&format!("{p}*{v}"))?;
        match self.place.q.clone() {
            Some(q) => self.add(&format!("{p}*{q}")),
            None => Ok(()),
        }
    }
}
