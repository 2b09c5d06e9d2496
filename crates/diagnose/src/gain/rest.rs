//! Equations where dry friction holds: there they give a set of rates.

use bracketry_symbolic::{Expr, Symbol, Tape};
use bracketry_system::{SwitchKind, System};

use crate::error::DiagnoseError;
use crate::settings::EquationSettings;

/// The signs in the equations of a model, and the equations with these as arguments.
#[derive(Clone)]
pub(super) struct Rest {
    /// Of arguments, then signs: the right-hand sides of all states.
    field: Tape,
    /// Surfaces, then their gradients by the states, surface by surface.
    surfaces: Tape,
    /// Whether the sign of a switch is set-valued at zero.
    jumps: Vec<bool>,
    states: usize,
    work: Vec<f64>,
    values: Vec<f64>,
    arguments: Vec<f64>,
    results: Vec<f64>,
}

impl Rest {
    /// `None` for a model without signs, and for one with unit vectors or with signs within signs.
    pub(super) fn new(system: &mut System, arguments: &[Symbol]) -> Result<Option<Self>, DiagnoseError> {
        let form = system.set_valued_form();
        let signs: Vec<Symbol> = form.switches.iter().map(|s| s.sign).collect();
        let mut expressions: Vec<Expr> = form.switches.iter().map(|s| s.surface).collect();
        let nested = system.pool.symbols_of(&expressions).iter().any(|s| signs.contains(s));
        let jumps: Vec<bool> = form.switches.iter().map(|s| s.kind == SwitchKind::Jump).collect();
        if nested || !form.unit_vectors.is_empty() || !jumps.contains(&true) {
            return Ok(None);
        }
        let states = system.states.clone();
        for switch in &form.switches {
            expressions.extend(states.iter().map(|&x| system.pool.diff(switch.surface, x)));
        }
        let all: Vec<Symbol> = arguments.iter().chain(&signs).copied().collect();
        let name = system.name.clone();
        let compile = |arguments: &[Symbol], expressions: &[Expr]| {
            system
                .compile(arguments, expressions)
                .map_err(|e| DiagnoseError::Term { text: name.clone(), message: e.to_string() })
        };
        let field = compile(&all, &form.dynamics)?;
        let surfaces = compile(arguments, &expressions)?;
        Ok(Some(Self {
            values: vec![0.0; surfaces.n_outputs()],
            results: vec![0.0; field.n_outputs()],
            field,
            surfaces,
            jumps,
            states: states.len(),
            work: Vec::new(),
            arguments: Vec::new(),
        }))
    }

    /// Smallest and largest right-hand side of every state over the signs that noise of the states, by its standard deviation,
    /// leaves undecided at a sample; `None` where it leaves none.
    pub(super) fn range(
        &mut self,
        arguments: &[f64],
        noise: &[f64],
        settings: &EquationSettings,
    ) -> Option<Vec<[f64; 2]>> {
        self.surfaces.eval(arguments, &mut self.work, &mut self.values);
        let n = self.jumps.len();
        let (surfaces, gradients) = self.values.split_at(n);
        let deviation = |i: usize| {
            let gradient = &gradients[i * self.states..(i + 1) * self.states];
            gradient.iter().zip(noise).map(|(g, s)| (g * s).powi(2)).sum::<f64>().sqrt()
        };
        let near = |i: usize| surfaces[i].abs() <= settings.undecided_sign * deviation(i);
        let undecided: Vec<usize> = (0..n).filter(|&i| self.jumps[i] && near(i)).collect();
        if undecided.is_empty() || undecided.len() > settings.most_undecided {
            return None;
        }
        let first = arguments.len();
        self.arguments.clear();
        self.arguments.extend_from_slice(arguments);
        self.arguments.extend(surfaces.iter().map(|s| s.signum()));
        let mut ranges = vec![[f64::INFINITY, f64::NEG_INFINITY]; self.results.len()];
        for corner in 0..1_usize << undecided.len() {
            for (bit, i) in undecided.iter().enumerate() {
                self.arguments[first + i] = if corner >> bit & 1 == 1 { 1.0 } else { -1.0 };
            }
            self.field.eval(&self.arguments, &mut self.work, &mut self.results);
            for (range, f) in ranges.iter_mut().zip(&self.results) {
                *range = [range[0].min(*f), range[1].max(*f)];
            }
        }
        Some(ranges)
    }
}
