//! The Kalman decomposition of a linear model, or of the linear approximation at a point.

use bracketry_symbolic::{Echelon, Expr, Rational, Symbol};
use bracketry_system::System;
use rustc_hash::FxHashMap;

use crate::error::Error;
use crate::forms::change::{Feedback, Plan};
use crate::forms::frame::Frame;
use crate::forms::normal_form::{BlockKind, FormNote, NormalForm, Part, PartKind};
use crate::forms::obstacle::{Obstacle, Stop};
use crate::linear::matrix::RationalMatrix;
use crate::operating::linear_model::{LinearModel, Rest};

type Vector = Vec<Rational>;

/// The four subspaces, each by a basis, in the order of [`KINDS`].
const KINDS: [BlockKind; 4] = [
    BlockKind::ControllableObservable,
    BlockKind::ControllableUnobservable,
    BlockKind::UncontrollableObservable,
    BlockKind::UncontrollableUnobservable,
];

/// A system that is linear as it stands, or its approximation.
struct Linear {
    a: RationalMatrix,
    b: RationalMatrix,
    c: RationalMatrix,
    /// The system with linear equations.
    system: System,
    exact: bool,
}

/// The form, and the frame with what its decisions rest on.
pub(crate) fn kalman(system: &System, outputs: Vec<usize>) -> Result<Result<(NormalForm, Frame), Stop>, Error> {
    let linear = match linear_system(system, &outputs) {
        Ok(linear) => linear,
        Err(stop) => return Ok(Err(stop)),
    };
    let mut frame = match Frame::new(linear.system.clone(), outputs)? {
        Ok(frame) => frame,
        Err(stop) => return Ok(Err(stop)),
    };
    Ok(frame.kalman(&linear).map(|form| (form, frame)))
}

/// The linear system, with all of A, B, C rational.
fn linear_system(original: &System, outputs: &[usize]) -> Result<Linear, Stop> {
    let found = |system: &System| {
        LinearModel::new(system).map_err(|why| Stop::Unknown(Obstacle::NotLinearizable { why: why.to_string() }))
    };
    let model = found(original)?;
    let Some([a, b, c, d]) = model.rational.clone() else { return Err(Stop::Unknown(Obstacle::Irrational)) };
    let mut system = original.clone();
    let zero = system.pool.int(0);
    let (n, m) = (system.states.len(), system.inputs.len());
    let point = system.point.clone();
    let centers: Vec<Expr> = match &point {
        Some(p) => p.states.iter().chain(&p.inputs).copied().collect(),
        None => vec![zero; n + m],
    };
    let variables: Vec<Symbol> = system.states.iter().chain(&system.inputs).copied().collect();
    let at: FxHashMap<Expr, Expr> = variables.iter().zip(&centers).map(|(&s, &v)| (system.pool.sym(s), v)).collect();
    let functions: Vec<Expr> = system.outputs.iter().map(|o| o.1).collect();
    let equations: Vec<Expr> = system.dynamics.iter().chain(&functions).copied().collect();
    let equations = system.with_values(&equations);
    let values = system.pool.substitute_all(&equations, &at);
    let rows: Vec<Vector> = joined(&a, &b).into_iter().chain(joined(&c, &d)).collect();
    let mut affine = Vec::new();
    for (row, &value) in rows.iter().zip(&values) {
        let sum = around(&mut system, row, &variables, &centers);
        affine.push(system.pool.add(sum, value));
    }
    let mut exact = true;
    for (&e, &l) in equations.iter().zip(&affine) {
        let difference = system.pool.sub(e, l);
        exact &= crate::algebra::span::vanishes(&mut system.pool, difference, &bracketry_symbolic::Bindings::new());
    }
    if !exact {
        if let Rest::Moving { residual } = model.rest {
            return Err(Stop::Unknown(Obstacle::NotAtRest { residual }));
        }
        // At rest, whatever rounding says.
        for (row, e) in rows.iter().zip(&mut affine).take(n) {
            *e = around(&mut system, row, &variables, &centers);
        }
    }
    let affine: Vec<Expr> = affine.into_iter().map(|e| system.pool.simplify(e)).collect();
    system.dynamics = affine[..n].to_vec();
    for (output, &e) in system.outputs.iter_mut().zip(&affine[n..]) {
        output.1 = e;
    }
    for k in 0..system.input_delays.len() {
        let delay = system.input_delays[k].delay;
        system.input_delays[k].delay = system.with_values(&[delay])[0];
    }
    system.parameters.clear();
    let chosen = outputs.iter().map(|&k| c.rows()[k].clone()).collect();
    let c = if original.outputs.is_empty() { c } else { RationalMatrix::new(chosen, n) };
    Ok(Linear { a, b, c, system, exact })
}

/// The rows of [A, B].
fn joined(a: &RationalMatrix, b: &RationalMatrix) -> Vec<Vector> {
    a.rows().iter().zip(b.rows()).map(|(x, y)| x.iter().chain(y).cloned().collect()).collect()
}

/// Σ r_i (x_i − c_i)
fn around(system: &mut System, row: &[Rational], variables: &[Symbol], centers: &[Expr]) -> Expr {
    let pool = &mut system.pool;
    let mut sum = pool.int(0);
    for ((r, &s), &c) in row.iter().zip(variables).zip(centers) {
        let (r, x) = (pool.rational(r.clone()), pool.sym(s));
        let difference = pool.sub(x, c);
        let term = pool.mul(r, difference);
        sum = pool.add(sum, term);
    }
    sum
}

/// Those of `vectors` that are independent of `span`, to which they are added.
fn complement(span: &mut Echelon<Rational>, vectors: &[Vector]) -> Vec<Vector> {
    vectors.iter().filter(|v| span.insert((*v).clone())).cloned().collect()
}

/// Bases of the four parts (Kalman 1963): R ∩ N, complements of it in R and in N, and a complement of R + N, where R is the
/// controllable and N the unobservable subspace.
fn parts(linear: &Linear) -> [Vec<Vector>; 4] {
    let n = linear.a.rows().len();
    let transposed = linear.a.transposed();
    let reachable = Echelon::invariant(linear.b.transposed().rows(), n, |v| linear.a.times(v));
    let observable = Echelon::invariant(linear.c.rows(), n, |v| transposed.times(v));
    let hidden = observable.null_space();
    // In both: Σ λ_i n_i with no component outside of R.
    let outside = Echelon::new(&reachable.null_space(), n);
    let coefficients: Vec<Vector> = outside
        .rows
        .iter()
        .map(|w| hidden.iter().map(|v| w.iter().zip(v).fold(Rational::ZERO, |s, (x, y)| s + x * y)).collect())
        .collect();
    let both: Vec<Vector> = RationalMatrix::new(coefficients, hidden.len())
        .null_space()
        .iter()
        .map(|c| (0..n).map(|i| c.iter().zip(&hidden).fold(Rational::ZERO, |s, (c, v)| s + c * &v[i])).collect())
        .collect();
    let mut span = Echelon::new(&both, n);
    let both = span.rows.clone();
    let controllable = complement(&mut span, &reachable.rows);
    let hidden_only = complement(&mut span, &hidden);
    let units: Vec<Vector> = span
        .free_columns()
        .map(|j| (0..n).map(|i| if i == j { Rational::ONE } else { Rational::ZERO }).collect())
        .collect();
    [controllable, both, units, hidden_only]
}

impl Frame {
    fn kalman(&mut self, linear: &Linear) -> Result<NormalForm, Stop> {
        let n = self.system.states.len();
        let bases = parts(linear);
        let mut blocks = Vec::new();
        let mut columns: Vec<Vector> = Vec::new();
        for (kind, basis) in KINDS.into_iter().zip(&bases) {
            blocks.push((kind, (columns.len()..columns.len() + basis.len()).collect()));
            columns.extend(basis.iter().cloned());
        }
        let back = RationalMatrix::new(columns, n).transposed();
        let Some(change) = back.inverse() else {
            return Err(Stop::Unknown(Obstacle::CoordinatesNotFound { missing: n }));
        };
        let point = self.system.point.clone().filter(|_| !linear.exact);
        let zero = self.system.pool.int(0);
        let states = self.system.states.clone();
        let centers = point.as_ref().map_or_else(|| vec![zero; n], |p| p.states.clone());
        let mut coordinates = Vec::new();
        for row in change.rows() {
            let t = around(&mut self.system, row, &states, &centers);
            coordinates.push(self.system.pool.simplify(t));
        }
        let new = self.fresh("z", n);
        let mut inverse = Vec::new();
        for (row, &center) in back.rows().iter().zip(&centers) {
            let value = around(&mut self.system, row, &new, &vec![zero; n]);
            let value = self.system.pool.add(value, center);
            inverse.push(self.system.pool.simplify(value));
        }
        let shift = point.map(|p| p.inputs).filter(|list| list.iter().any(|&u| !self.system.pool.is_zero(u)));
        let feedback = match shift {
            None => None,
            Some(centers) => Some(self.shifted(&centers)?),
        };
        let plan = Plan {
            coordinates,
            new: new.clone(),
            feedback,
            known: vec![None; n],
            inverse: Some(inverse),
            regular: None,
            singular: Some(Vec::new()),
            blocks,
            keep_names: false,
            suffix: "kalman",
            notes: if linear.exact { Vec::new() } else { vec![FormNote::Linearized] },
        };
        let mut form = self.change(plan)?.form;
        let size = bases[0].len();
        if size > 0 && size < n {
            form.parts.push(minimal(&form.system, size));
        }
        Ok(form)
    }

    /// v = u − u₀
    fn shifted(&mut self, centers: &[Expr]) -> Result<Feedback, Stop> {
        self.without_delays()?;
        let new = self.fresh("v", centers.len());
        let inputs = self.inputs();
        let pool = &mut self.system.pool;
        let law = new.iter().zip(centers).map(|(&v, &c)| {
            let v = pool.sym(v);
            pool.add(v, c)
        });
        let law = law.collect();
        let inverse = inputs.into_iter().zip(centers).map(|(u, &c)| pool.sub(u, c)).collect();
        Ok(Feedback { new, law, inverse })
    }
}

/// The first `size` states alone, all others at zero: a minimal realization.
fn minimal(form: &System, size: usize) -> Part {
    let mut system = form.clone();
    let zero = system.pool.int(0);
    let others: FxHashMap<Expr, Expr> = system.states[size..].iter().map(|&s| (system.pool.sym(s), zero)).collect();
    let mut put = |list: &[Expr]| -> Vec<Expr> {
        let list = system.pool.substitute_all(list, &others);
        list.into_iter().map(|e| system.pool.simplify(e)).collect()
    };
    let dynamics = put(&form.dynamics[..size]);
    let outputs = put(&form.outputs.iter().map(|o| o.1).collect::<Vec<_>>());
    system.dynamics = dynamics;
    system.outputs = form.outputs.iter().map(|o| o.0.clone()).zip(outputs).collect();
    system.states.truncate(size);
    system.name = form.name.replace("_kalman", "_minimal");
    if let Some(point) = &mut system.point {
        point.states.truncate(size);
    }
    Part { kind: PartKind::Minimal, system }
}
