//! The compiled functions of a model.

use super::drive::Driven;
use super::inputs::InputError;
use super::switch_expressions::{
    Differentiate, ModelSwitch, derivatives, model_switches, plain_surfaces, surface_gradients,
    with_derivatives_by_signs, without_set_values,
};
use bracketry_symbolic::{Expr, Symbol, Tape};
use bracketry_system::SwitchedForm;

/// Derivatives of the field, compiled.
#[derive(Debug, Clone)]
pub(super) struct Derivatives {
    /// By states, where asked for, by signs, by live numbers: `n` each. Then those of the switching functions by live numbers.
    pub(super) tape: Tape,
    /// How many live numbers.
    pub(super) numbers: usize,
    /// Whether those by states are there.
    pub(super) by_state: bool,
    /// Whether some of those of the switching functions are not zero.
    pub(super) surfaces_move: bool,
}

/// Functions of time, states, slots and, for some, signs.
#[derive(Debug, Clone)]
pub(super) struct Tapes {
    pub(super) field: Tape,
    /// The field and its derivatives by the signs, if it is affine in them.
    pub(super) affine: Option<Tape>,
    pub(super) surfaces: Tape,
    pub(super) gradients: Tape,
    pub(super) inputs: Tape,
    pub(super) outputs: Tape,
    pub(super) measures: Tape,
    pub(super) derivatives: Option<Derivatives>,
}

impl Tapes {
    /// Compiles a driven system, whose last `measures` outputs see the signs, and its switches.
    pub(super) fn compile(
        driven: &mut Driven,
        form: &SwitchedForm,
        measures: usize,
        differentiate: Option<Differentiate<'_>>,
    ) -> Result<(Self, Vec<ModelSwitch>), InputError> {
        let inputs = driven.system.inputs.len();
        let last = driven.outputs.len() - inputs;
        let measures: Vec<Expr> = driven.outputs.drain(last - measures..last).collect();
        let actual: Vec<Symbol> = form.switches.iter().map(|s| s.sign).collect();
        let measures = without_set_values(&mut driven.system, &measures, &actual);
        driven.outputs = without_set_values(&mut driven.system, &driven.outputs, &[]);
        let surfaces = plain_surfaces(&mut driven.system, &form.switches)?;
        let gradients = surface_gradients(driven, &form.switches, &surfaces);
        let affine = with_derivatives_by_signs(&mut driven.system, &form.switches, &form.dynamics);
        let by = match differentiate {
            Some(wanted) => derivatives(driven, form, &surfaces, wanted)?.map(|all| (all, wanted)),
            None => None,
        };
        let switches = model_switches(driven, form)?;

        let mut smooth = vec![driven.time];
        smooth.extend(driven.system.states.iter().chain(&driven.slots));
        let all = [&smooth[..], &actual].concat();
        let pool = &mut driven.system.pool;
        let zero = pool.int(0);
        let mut compile = |arguments: &[Symbol], expressions: &[Expr]| {
            let expressions = pool.substitute_all(expressions, &driven.values);
            Tape::compile(pool, arguments, &expressions)
        };
        let (outputs, driving) = driven.outputs.split_at(driven.outputs.len() - inputs);
        let tapes = Self {
            field: compile(&all, &form.dynamics)?,
            affine: affine.map(|expressions| compile(&all, &expressions)).transpose()?,
            surfaces: compile(&smooth, &surfaces)?,
            gradients: compile(&smooth, &gradients)?,
            inputs: compile(&smooth, driving)?,
            outputs: compile(&smooth, outputs)?,
            measures: compile(&all, &measures)?,
            derivatives: match by {
                Some((expressions, Differentiate { by_state, by })) => {
                    let of_surfaces = &expressions[expressions.len() - surfaces.len() * by.len()..];
                    let surfaces_move = of_surfaces.iter().any(|e| *e != zero);
                    Some(Derivatives { tape: compile(&all, &expressions)?, numbers: by.len(), by_state, surfaces_move })
                }
                None => None,
            },
        };
        Ok((tapes, switches))
    }
}
