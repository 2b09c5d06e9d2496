//! The compiled functions of a model.

use super::drive::Driven;
use super::inputs::InputError;
use super::switch_expressions::{
    Differentiate, ModelSwitch, derivatives, model_switches, plain_surfaces, surface_gradients,
    with_derivatives_by_signs, without_set_values,
};
use bracketry_symbolic::{Expr, Pool, Symbol, Tape};
use bracketry_system::SwitchedForm;
use std::sync::OnceLock;

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

/// The field's derivatives by the states, compiled where they are asked for first: most fields are not stiff.
#[derive(Default)]
pub(super) struct FieldJacobian {
    pool: Pool,
    arguments: Vec<Symbol>,
    states: Vec<Symbol>,
    field: Vec<Expr>,
    compiled: OnceLock<Option<SparseJacobian>>,
}

/// Row, column and value of the derivatives that are not zero everywhere.
#[derive(Debug)]
pub(super) struct SparseJacobian {
    pub(super) entries: Vec<(usize, usize)>,
    pub(super) tape: Tape,
}

impl std::fmt::Debug for FieldJacobian {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("FieldJacobian").field("compiled", &self.compiled).finish_non_exhaustive()
    }
}

impl FieldJacobian {
    /// The compiled derivatives; none where they cannot be compiled.
    pub(super) fn get(&self) -> Option<&SparseJacobian> {
        self.compiled.get_or_init(|| self.compile()).as_ref()
    }

    fn compile(&self) -> Option<SparseJacobian> {
        let mut pool = self.pool.clone();
        let (mut entries, mut derivatives) = (Vec::new(), Vec::new());
        for (i, &f) in self.field.iter().enumerate() {
            for (j, e) in pool.gradient(f, &self.states).into_iter().enumerate() {
                if !pool.is_zero(e) {
                    entries.push((i, j));
                    derivatives.push(e);
                }
            }
        }
        let tape = Tape::compile(&pool, &self.arguments, &derivatives).ok()?;
        Some(SparseJacobian { entries, tape })
    }
}

/// Functions of time, states, slots and, for some, signs.
#[derive(Debug)]
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
    pub(super) jacobian: FieldJacobian,
}

impl Tapes {
    /// Compiles a driven system, whose last `measures` outputs see the signs, and its switches; the expressions leave the system.
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
        let field = compile(&all, &form.dynamics)?;
        let (outputs, driving) = driven.outputs.split_at(driven.outputs.len() - inputs);
        let mut tapes = Self {
            field,
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
            jacobian: FieldJacobian::default(),
        };
        let field = pool.substitute_all(&form.dynamics, &driven.values);
        let (states, pool) = (driven.system.states.clone(), std::mem::take(pool));
        tapes.jacobian = FieldJacobian { pool, arguments: all, states, field, compiled: OnceLock::new() };
        Ok((tapes, switches))
    }
}
