//! The fields of each mode of a system that switches.

use bracketry_symbolic::{Bindings, Expr, Function, ZeroTest};
use bracketry_system::System;
use rustc_hash::FxHashMap;

use crate::algebra::field::{Field, VectorFields};
use crate::condition::Condition;
use crate::error::Error;
use crate::undecided::Undecided;
use serde::{Serialize, Serializer};

/// Switching functions with their signs, ±1.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Signs(pub Vec<(Function, i8)>);

impl Signs {
    /// Where all of them hold.
    pub fn condition(&self) -> Condition {
        let sign = |(f, sign): &(Function, i8)| {
            if *sign > 0 { Condition::Positive(f.clone()) } else { Condition::Negative(f.clone()) }
        };
        Condition::All(self.0.iter().map(sign).collect())
    }
}

impl Serialize for Signs {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(f, sign)| (f, sign)))
    }
}

/// The fields that hold while all switching functions keep their signs.
#[derive(Clone)]
pub struct ModeFields {
    /// The switching functions and their signs; none for a smooth system.
    pub signs: Signs,
    /// Drift and input fields, parameters bound to their values.
    pub fields: VectorFields,
    /// The switching functions with the signs of inner ones put in, in the pool of the fields.
    pub(crate) surfaces: Vec<Expr>,
}

impl ModeFields {
    /// The signs of the switching functions, ±1.
    pub(crate) fn sign_list(&self) -> Vec<i8> {
        self.signs.0.iter().map(|s| s.1).collect()
    }
}

/// The fields of every mode of a system that is affine in its inputs, all in its pool, even after its deadline.
///
/// # Errors
/// [`Error::NotAffine`], also for a switching function that depends on an input;
/// [`Error::NoStates`], [`Error::Modes`], [`Error::Undecided`].
pub fn mode_fields(system: &mut System) -> Result<Vec<ModeFields>, Error> {
    let deadline = system.pool.deadline();
    system.pool.set_deadline(None);
    let modes = fields_of_modes(system);
    system.pool.set_deadline(deadline);
    modes
}

fn fields_of_modes(system: &mut System) -> Result<Vec<ModeFields>, Error> {
    if !system.input_derivatives.is_empty() {
        return Err(Error::NotAffine { equation: "a derivative of an input".to_owned() });
    }
    let form = system.switched_form();
    let bindings = parameter_bindings(system);
    let pool = &mut system.pool;
    let surfaces: Vec<Expr> = form.switches.iter().map(|s| s.surface).collect();
    if let Some(s) = form.switches.iter().find(|s| system.inputs.iter().any(|&u| pool.depends_on(s.surface, u))) {
        return Err(Error::NotAffine { equation: format!("the switching function {}", s.name) });
    }
    if surfaces.len() > bracketry_system::MAX_ENUMERATED_SWITCHES {
        return Err(Error::Modes { switches: surfaces.len() });
    }
    let zero = pool.int(0);
    let no_input: FxHashMap<Expr, Expr> = system.inputs.iter().map(|&u| (pool.sym(u), zero)).collect();
    let drift = pool.substitute_all(&form.dynamics, &no_input);
    let mut controls = Vec::new();
    for &u in &system.inputs {
        let column: Field = form.dynamics.iter().map(|&e| pool.diff(e, u)).collect();
        for (i, &d) in column.iter().enumerate() {
            // Most use no input at all, which is seen at once.
            for v in pool.symbols_of(&[d]).into_iter().filter(|v| system.inputs.contains(v)) {
                let second = pool.diff(d, v);
                match pool.zero_test(second, &Bindings::new()) {
                    ZeroTest::Zero(_) => {}
                    ZeroTest::NonZero => {
                        let equation = format!("the derivative of {}", pool.name(system.states[i]));
                        return Err(Error::NotAffine { equation });
                    }
                    ZeroTest::Unknown(why) => return Err(Undecided::from(why).into()),
                }
            }
        }
        controls.push(pool.substitute_all(&column, &no_input));
    }
    let k = form.switches.len();
    let raw: Vec<Expr> = surfaces;
    let surfaces: Vec<Function> = form.switches.iter().map(|s| Function::new(pool, s.surface)).collect();
    let mut modes = Vec::with_capacity(1 << k);
    for bits in 0..1usize << k {
        let signs: Vec<i8> = (0..k).map(|i| if bits >> (k - 1 - i) & 1 == 0 { 1 } else { -1 }).collect();
        let values: FxHashMap<Expr, Expr> =
            form.switches.iter().zip(&signs).map(|(s, &v)| (pool.sym(s.sign), pool.int(i64::from(v)))).collect();
        let fields = VectorFields::new(
            system.states.clone(),
            pool.substitute_all(&drift, &values),
            controls.iter().map(|g| pool.substitute_all(g, &values)).collect(),
            bindings.clone(),
        )?;
        let signs = Signs(surfaces.iter().cloned().zip(signs).collect());
        let surfaces = pool.substitute_all(&raw, &values);
        modes.push(ModeFields { signs, fields, surfaces });
    }
    Ok(modes)
}

/// The parameters of a system bound to their values.
pub(crate) fn parameter_bindings(system: &System) -> Bindings {
    let mut bindings = Bindings::new();
    for p in &system.parameters {
        bindings.bind(p.symbol, p.value.clone());
    }
    bindings
}
