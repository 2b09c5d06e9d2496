//! Verdicts over two parameters: a grid of exact points, with the curves on which ranks change.

use std::time::Instant;

use bracketry_symbolic::{Expr, Function, Pool, Rational, Symbol, Tape};
use bracketry_system::System;
use rustc_hash::FxHashMap;
use serde::Serialize;

use crate::linear::matrix::{RationalMatrix, quotient_by_reachable};
use crate::linear::spectrum::Spectrum;
use crate::parameters::aspect::{Aspect, Linear};
use crate::parameters::cases::{parameter_cases, subject};
use crate::parameters::report::{ParameterError, ParameterOptions, ParameterReport};

/// Values of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterRange {
    /// Its name.
    pub name: String,
    /// Least value.
    pub low: Rational,
    /// Greatest value.
    pub high: Rational,
}

impl ParameterRange {
    /// Two ranges such as `a=0..2,b=-1..1`.
    ///
    /// # Errors
    /// [`ParameterError::Map`] for any other text.
    ///
    /// ```
    /// use bracketry_lie::parameters::ParameterRange;
    /// let [a, b] = ParameterRange::two("a=0..2, b=-1..1/2").unwrap();
    /// assert_eq!((a.name.as_str(), b.high.to_string().as_str()), ("a", "1/2"));
    /// assert!(ParameterRange::two("a=0..2").is_err());
    /// ```
    pub fn two(text: &str) -> Result<[Self; 2], ParameterError> {
        let fault = || ParameterError::Map { text: text.to_owned() };
        let range = |part: &str| {
            let (name, ends) = part.split_once('=')?;
            let (low, high) = ends.split_once("..")?;
            let mut pool = Pool::new();
            let mut number = |text: &str| {
                let e = pool.parse(text.trim()).ok()?;
                let e = pool.simplify(e);
                pool.number(e).cloned()
            };
            let (low, high) = (number(low)?, number(high)?);
            (low < high).then(|| ParameterRange { name: name.trim().to_owned(), low, high })
        };
        let parts: Option<Vec<Self>> = text.split(',').map(range).collect();
        match parts.as_deref() {
            Some([a, b]) if a.name != b.name => Ok([a.clone(), b.clone()]),
            _ => Err(fault()),
        }
    }

    /// The middles of `cells` parts.
    fn centers(&self, cells: usize) -> Vec<Rational> {
        let width = (&self.high - &self.low) / Rational::from(2 * cells);
        (0..cells).map(|k| &self.low + &width * Rational::from(2 * k + 1)).collect()
    }
}

/// The linearization at the middle of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct MapCell {
    /// Eigenvalues of A with positive real part.
    pub unstable: usize,
    /// Eigenvalues of A on the imaginary axis.
    pub on_axis: usize,
    /// Dimension of what the inputs do not reach to first order.
    pub uncontrollable: usize,
    /// Whether all uncontrollable eigenvalues have negative real part.
    pub stabilizable: bool,
}

/// Where a rank changes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MapCurve {
    /// A function of the two parameters that vanishes there.
    pub condition: Function,
    /// The aspects with the verdict there.
    pub changes: Vec<(Aspect, String)>,
    /// Its values at the grid `trace_x` × `trace_y`, row by row.
    #[serde(skip)]
    pub values: Vec<Vec<f64>>,
}

/// A single point at which ranks change.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MapPoint {
    /// Values of the two parameters.
    pub at: [f64; 2],
    /// The aspects with the verdict there.
    pub changes: Vec<(Aspect, String)>,
}

/// Verdicts over two parameters, the others at their values.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ParameterMap {
    /// The parameters.
    pub names: [String; 2],
    /// Middles of the columns.
    pub x: Vec<f64>,
    /// Middles of the rows.
    pub y: Vec<f64>,
    /// By row and column; none where the equations have no rational linearization at an equilibrium, or time was up.
    pub cells: Vec<Vec<Option<MapCell>>>,
    /// Where ranks change.
    pub curves: Vec<MapCurve>,
    /// Single points at which ranks change again, with the verdicts there.
    pub points: Vec<MapPoint>,
    /// The exact cases in these two parameters.
    pub report: ParameterReport,
    /// Places at which curves are traced.
    #[serde(skip)]
    pub trace_x: Vec<f64>,
    /// The same for the other parameter.
    #[serde(skip)]
    pub trace_y: Vec<f64>,
}

/// Places along each axis at which curves are traced.
const TRACE: usize = 161;
/// Most cells along each axis.
const MAX_CELLS: usize = 200;

/// Verdicts over two parameters.
///
/// The ranks of `report` hold in every cell off the curves; the cells tell the half-planes of the linearization's
/// eigenvalues at their middles, exactly.
///
/// # Errors
/// [`ParameterError`] as for [`parameter_cases`].
pub fn parameter_map(
    system: &System,
    ranges: &[ParameterRange; 2],
    cells: usize,
    options: &ParameterOptions,
) -> Result<ParameterMap, ParameterError> {
    let start = Instant::now();
    let cells = cells.clamp(2, MAX_CELLS);
    let names = [ranges[0].name.clone(), ranges[1].name.clone()];
    let options = ParameterOptions { parameters: names.to_vec(), ..options.clone() };
    let report = parameter_cases(system, &options)?;
    let mut system = system.clone();
    let deadline = options.time_limit.and_then(|limit| start.checked_add(limit));
    let find = |n: &String| system.parameters.iter().map(|p| p.symbol).find(|&s| system.pool.name(s) == n);
    let symbols: Vec<Symbol> = names.iter().filter_map(find).collect();
    let (subject, _) = subject(&mut system, &symbols)?;
    system.pool.set_deadline(deadline);
    let (x, y) = (ranges[0].centers(cells), ranges[1].centers(cells));
    let mut rows = Vec::with_capacity(cells);
    for b in &y {
        let row = x.iter().map(|a| cell(&mut system.pool, subject.linear.as_ref(), &symbols, [a, b]));
        rows.push(row.collect());
    }
    let number = |q: &Rational| q.to_f64().value();
    let trace = |r: &ParameterRange| -> Vec<f64> {
        let (low, high) = (number(&r.low), number(&r.high));
        (0..TRACE).map(|k| low + (high - low) * k as f64 / (TRACE - 1) as f64).collect()
    };
    let (trace_x, trace_y) = (trace(&ranges[0]), trace(&ranges[1]));
    let (curves, points) = changes(&report, &names, (&trace_x, &trace_y));
    Ok(ParameterMap {
        names,
        x: x.iter().map(number).collect(),
        y: y.iter().map(number).collect(),
        cells: rows,
        curves,
        points,
        report,
        trace_x,
        trace_y,
    })
}

/// The linearization at a point of the map.
fn cell(pool: &mut Pool, linear: Option<&Linear>, symbols: &[Symbol], at: [&Rational; 2]) -> Option<MapCell> {
    let linear = linear?;
    if pool.reached_limit().is_some() {
        return None;
    }
    let values: FxHashMap<Expr, Expr> =
        symbols.iter().zip(at).map(|(&s, v)| (pool.sym(s), pool.rational(v.clone()))).collect();
    let n = linear.a.len();
    let mut matrix = |rows: &[Vec<Expr>]| -> Option<RationalMatrix> {
        let rows = rows.iter().map(|row| {
            let row = pool.substitute_all(row, &values);
            row.into_iter()
                .map(|e| {
                    let e = pool.simplify(e);
                    pool.number(e).cloned()
                })
                .collect::<Option<Vec<Rational>>>()
        });
        Some(RationalMatrix::new(rows.collect::<Option<Vec<_>>>()?, n))
    };
    let (a, b) = (matrix(&linear.a)?, matrix(&linear.b)?);
    let whole = Spectrum::of(&a);
    let rest = quotient_by_reachable(&a, &b);
    let uncontrollable = rest.rows().len();
    let part = Spectrum::of(&rest);
    Some(MapCell {
        unstable: whole.right,
        on_axis: whole.on_axis,
        uncontrollable,
        stabilizable: part.right + part.on_axis == 0,
    })
}

type Changes = (Vec<MapCurve>, Vec<MapPoint>);

/// Curves and points of the cases.
fn changes(report: &ParameterReport, names: &[String; 2], (x, y): (&[f64], &[f64])) -> Changes {
    let (mut curves, mut points): Changes = Default::default();
    for a in &report.aspects {
        for case in &a.cases {
            let change = (a.aspect, case.value.to_string());
            if let [condition] = &case.conditions[..] {
                match curves.iter_mut().find(|c| c.condition == *condition) {
                    Some(c) => c.changes.push(change),
                    None => curves.push(MapCurve {
                        condition: condition.clone(),
                        changes: vec![change],
                        values: grid(condition, names, x, y),
                    }),
                }
                continue;
            }
            let value = |name: &String| {
                let solved = case.solved.iter().find(|s| s.0 == *name)?;
                solved.1.pool().number(solved.1.expr()).map(|q| q.to_f64().value())
            };
            let (Some(px), Some(py)) = (value(&names[0]), value(&names[1])) else { continue };
            match points.iter_mut().find(|p| p.at == [px, py]) {
                Some(p) => p.changes.push(change),
                None => points.push(MapPoint { at: [px, py], changes: vec![change] }),
            }
        }
    }
    (curves, points)
}

/// Values of a function of the two parameters; not a number where it has none.
fn grid(f: &Function, names: &[String; 2], x: &[f64], y: &[f64]) -> Vec<Vec<f64>> {
    let mut pool = f.pool().clone();
    let arguments = [pool.symbol(&names[0]), pool.symbol(&names[1])];
    let Ok(tape) = Tape::compile(&pool, &arguments, &[f.expr()]) else {
        return vec![vec![f64::NAN; x.len()]; y.len()];
    };
    let mut scratch = Vec::new();
    let mut value = |a: f64, b: f64| {
        let mut out = [f64::NAN];
        tape.eval(&[a, b], &mut scratch, &mut out);
        out[0]
    };
    y.iter().map(|&b| x.iter().map(|&a| value(a, b)).collect()).collect()
}
