//! What may change with the parameters, and the matrices whose ranks decide on it.

use std::fmt;

use bracketry_symbolic::{Expr, Pool, Symbol};
use rustc_hash::FxHashMap;
use serde::Serialize;

use crate::algebra::field::{Field, VectorFields, bracket, is_plain_zero};
use crate::algebra::rational::readable::tidy;
use crate::algebra::span::{independent, independent_rows};
use crate::budget::check_growth;
use crate::evidence::Evidence;
use crate::undecided::Undecided;

/// A verdict that depends on ranks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Aspect {
    /// Dimension of the accessibility algebra at a generic state.
    Accessibility,
    /// Dimension of the strong accessibility algebra at a generic state.
    StrongAccessibility,
    /// Whether static feedback and coordinates make the system linear and controllable near a generic state.
    StaticLinearization,
    /// Relative degrees of the outputs and the rank of the decoupling matrix at a generic state.
    RelativeDegree,
    /// Rank of the observability codistribution at a generic state, parameters known.
    Observability,
    /// Rank of [B, A B, A² B, …] of the linearization at the point, an equilibrium.
    LinearControllability,
    /// Rank of [C; C A; C A²; …] of the linearization at the point, an equilibrium.
    LinearObservability,
}

impl Aspect {
    /// All of them, in the order of reports.
    pub const ALL: [Aspect; 7] = [
        Aspect::Accessibility,
        Aspect::StrongAccessibility,
        Aspect::LinearControllability,
        Aspect::Observability,
        Aspect::LinearObservability,
        Aspect::RelativeDegree,
        Aspect::StaticLinearization,
    ];
}

/// The verdict on an aspect.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum AspectValue {
    /// A dimension or rank.
    Dimension(usize),
    /// Whether it is possible.
    Possible(bool),
    /// Relative degrees.
    Degrees {
        /// By output; none where no input ever reaches it.
        degrees: Vec<Option<usize>>,
        /// Rank of the decoupling matrix.
        rank: usize,
    },
}

impl fmt::Display for AspectValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            AspectValue::Dimension(d) => write!(f, "{d}"),
            AspectValue::Possible(yes) => f.write_str(if *yes { "yes" } else { "no" }),
            AspectValue::Degrees { degrees, rank } => {
                let list: Vec<String> =
                    degrees.iter().map(|d| d.map_or("none".to_owned(), |d| d.to_string())).collect();
                write!(f, "{}; decoupling rank {rank}", list.join(", "))
            }
        }
    }
}

/// A verdict that holds for generic values of the symbols, and the matrices, of full row rank at generic values, one of
/// which loses rank wherever the verdict differs.
pub(crate) struct Generic {
    pub(crate) value: AspectValue,
    pub(crate) matrices: Vec<Vec<Vec<Expr>>>,
}

/// A smooth control-affine system whose parameters may be symbols.
#[derive(Clone)]
pub(crate) struct Subject {
    pub(crate) fields: VectorFields,
    pub(crate) outputs: Vec<Expr>,
    /// A (rows), B (columns), C (rows) at the point if it is an equilibrium for all parameters.
    pub(crate) linear: Option<Linear>,
}

#[derive(Clone)]
pub(crate) struct Linear {
    pub(crate) a: Vec<Vec<Expr>>,
    pub(crate) b: Vec<Vec<Expr>>,
    pub(crate) c: Vec<Vec<Expr>>,
}

impl Subject {
    /// The system with expressions in place of symbols.
    pub(crate) fn with(&self, pool: &mut Pool, values: &FxHashMap<Expr, Expr>) -> Subject {
        let mut put = |list: &[Expr]| -> Vec<Expr> {
            let list = pool.substitute_all(list, values);
            list.into_iter().map(|e| tidy(pool, e)).collect()
        };
        let mut fields = self.fields.clone();
        fields.drift = put(&fields.drift);
        fields.controls = fields.controls.iter().map(|g| put(g)).collect();
        let outputs = put(&self.outputs);
        let linear = self.linear.as_ref().map(|l| Linear {
            a: l.a.iter().map(|r| put(r)).collect(),
            b: l.b.iter().map(|r| put(r)).collect(),
            c: l.c.iter().map(|r| put(r)).collect(),
        });
        Subject { fields, outputs, linear }
    }

    /// All expressions that an aspect rests on.
    pub(crate) fn roots_of(&self, aspect: Aspect) -> Vec<Expr> {
        let mut roots = self.roots();
        if let (Aspect::LinearControllability | Aspect::LinearObservability, Some(l)) = (aspect, &self.linear) {
            roots.extend([&l.a, &l.b, &l.c].into_iter().flat_map(|rows| rows.concat()));
        }
        roots
    }

    /// All expressions of the equations.
    pub(crate) fn roots(&self) -> Vec<Expr> {
        let mut roots = self.fields.drift.clone();
        roots.extend(self.fields.controls.concat());
        roots.extend(&self.outputs);
        roots
    }

    /// The verdict for generic values of the symbols.
    ///
    /// # Errors
    /// [`Undecided`] if something cannot be evaluated exactly or grows too large.
    pub(crate) fn generic(
        &self,
        pool: &mut Pool,
        aspect: Aspect,
        evidence: &mut Evidence,
    ) -> Result<Generic, Undecided> {
        let fields = &self.fields;
        let dimension = |rows: Vec<Vec<Expr>>| Generic {
            value: AspectValue::Dimension(rows.len()),
            matrices: if rows.is_empty() { Vec::new() } else { vec![rows] },
        };
        match aspect {
            Aspect::StrongAccessibility => Ok(dimension(self.brackets(pool, true, evidence)?)),
            Aspect::Accessibility => {
                let all = self.brackets(pool, false, evidence)?;
                // Where the strong dimension is as large, the weak one falls only where that does.
                let strong = self.brackets(pool, true, evidence)?;
                Ok(dimension(if strong.len() == all.len() { strong } else { all }))
            }
            Aspect::Observability => {
                let o = fields.observability(pool, &self.outputs, &[], evidence)?;
                Ok(dimension(o.codistribution))
            }
            Aspect::LinearControllability => {
                let Some(l) = &self.linear else { return Ok(dimension(Vec::new())) };
                Ok(dimension(krylov(pool, &l.a, &l.b, fields, evidence)?))
            }
            Aspect::LinearObservability => {
                let Some(l) = &self.linear else { return Ok(dimension(Vec::new())) };
                let n = l.a.len();
                let transposed: Vec<Vec<Expr>> = (0..n).map(|j| l.a.iter().map(|row| row[j]).collect()).collect();
                Ok(dimension(krylov(pool, &transposed, &l.c, fields, evidence)?))
            }
            Aspect::RelativeDegree => self.relative_degree(pool, evidence),
            Aspect::StaticLinearization => self.linearization(pool, evidence),
        }
    }

    /// Independent brackets that span the accessibility algebra or its strong part.
    fn brackets(&self, pool: &mut Pool, strong: bool, evidence: &mut Evidence) -> Result<Vec<Vec<Expr>>, Undecided> {
        let fields = &self.fields;
        let closure =
            if strong { fields.strong_accessibility(pool, evidence)? } else { fields.accessibility(pool, evidence)? };
        let generators = fields.generators();
        let rows = closure.brackets(pool, &fields.states, &generators, &fields.bindings, evidence)?;
        let rows = independent(pool, &rows, &fields.bindings, evidence)?;
        if rows.len() != closure.dimension() {
            return Err(bracketry_symbolic::Undecided::TooComplex.into());
        }
        Ok(rows)
    }

    fn relative_degree(&self, pool: &mut Pool, evidence: &mut Evidence) -> Result<Generic, Undecided> {
        let found = self.fields.relative_degree(pool, &self.outputs, evidence)?;
        let rows = independent_rows(pool, &found.decoupling, &self.fields.bindings, evidence)?;
        let mut matrices: Vec<Vec<Vec<Expr>>> = found
            .decoupling
            .iter()
            .zip(&found.degrees)
            .filter(|(_, d)| d.is_some())
            .map(|(row, _)| vec![row.clone()])
            .collect();
        if rows.len() > 1 {
            matrices.push(rows.iter().map(|&i| found.decoupling[i].clone()).collect());
        }
        Ok(Generic { value: AspectValue::Degrees { degrees: found.degrees, rank: found.rank }, matrices })
    }

    /// Jakubczyk and Respondek 1980: by the ranks of D_i = span{ad_f^k g_j, k ≤ i} and of D_i with its brackets.
    fn linearization(&self, pool: &mut Pool, evidence: &mut Evidence) -> Result<Generic, Undecided> {
        let fields = &self.fields;
        let (n, first) = (fields.states.len(), pool.len());
        let mut basis = independent(pool, &fields.controls, &fields.bindings, evidence)?;
        let mut newest = basis.clone();
        let mut matrices = Vec::new();
        let mut possible = true;
        loop {
            matrices.push(basis.clone());
            if basis.len() == n {
                break;
            }
            let mut all = basis.clone();
            for (i, a) in basis.iter().enumerate() {
                for b in &basis[..i] {
                    check_growth(pool, first, [a, b], 1)?;
                    all.push(bracket(pool, &fields.states, a, b));
                }
            }
            let closed = independent(pool, &all, &fields.bindings, evidence)?;
            if closed.len() > basis.len() {
                matrices.push(closed);
                possible = false;
                break;
            }
            let mut all = basis.clone();
            for y in &newest {
                check_growth(pool, first, [&fields.drift, y], 1)?;
                all.push(bracket(pool, &fields.states, &fields.drift, y));
            }
            let next = independent_rows(pool, &all, &fields.bindings, evidence)?;
            if next.len() == basis.len() {
                possible = false;
                break;
            }
            newest = next.iter().filter(|&&i| i >= basis.len()).map(|&i| all[i].clone()).collect();
            basis = next.iter().map(|&i| all[i].clone()).collect();
        }
        matrices.retain(|m| !m.is_empty());
        Ok(Generic { value: AspectValue::Possible(possible), matrices })
    }
}

/// Independent vectors among A^k v for the rows v of `start`.
fn krylov(
    pool: &mut Pool,
    a: &[Vec<Expr>],
    start: &[Vec<Expr>],
    fields: &VectorFields,
    evidence: &mut Evidence,
) -> Result<Vec<Vec<Expr>>, Undecided> {
    let first = pool.len();
    let mut basis: Vec<Field> = Vec::new();
    let mut queue: std::collections::VecDeque<Field> = start.iter().cloned().collect();
    while let Some(v) = queue.pop_front() {
        if basis.len() == a.len() {
            break;
        }
        check_growth(pool, first, [&v, &[]], 1)?;
        if is_plain_zero(pool, &v) {
            continue;
        }
        basis.push(v);
        if independent_rows(pool, &basis, &fields.bindings, evidence)?.len() < basis.len() {
            basis.pop();
            continue;
        }
        let v = basis[basis.len() - 1].clone();
        let mut next = Vec::with_capacity(a.len());
        for row in a {
            let terms: Vec<Expr> = row.iter().zip(&v).map(|(&x, &y)| pool.mul(x, y)).collect();
            let sum = pool.sum(terms);
            next.push(tidy(pool, sum));
        }
        queue.push_back(next);
    }
    Ok(basis)
}

/// The linear system at a point, if it rests there whatever the values of `symbols`.
pub(crate) fn linear_at(
    pool: &mut Pool,
    fields: &VectorFields,
    outputs: &[Expr],
    states: &[Expr],
    inputs: &[Expr],
) -> Result<Linear, NotLinear> {
    let closed: Vec<Expr> = (0..fields.states.len())
        .map(|i| {
            let terms: Vec<Expr> = fields.controls.iter().zip(inputs).map(|(g, &u)| pool.mul(g[i], u)).collect();
            let sum = pool.sum(terms);
            pool.add(fields.drift[i], sum)
        })
        .collect();
    let at: Vec<(Symbol, Expr)> = fields.states.iter().copied().zip(states.iter().copied()).collect();
    let put = |pool: &mut Pool, list: &[Expr]| -> Result<Vec<Expr>, NotLinear> {
        let list = pool.at_all(list, &at).map_err(|_| NotLinear::NoValue)?;
        Ok(list.into_iter().map(|e| tidy(pool, e)).collect())
    };
    for e in put(pool, &closed)? {
        match pool.zero_test(e, &fields.bindings) {
            _ if pool.is_zero(e) => {}
            bracketry_symbolic::ZeroTest::Zero(_) => {}
            _ => return Err(NotLinear::NoEquilibrium),
        }
    }
    let a = pool.jacobian(&closed, &fields.states);
    let c = pool.jacobian(outputs, &fields.states);
    let a = a.iter().map(|row| put(pool, row)).collect::<Result<_, _>>()?;
    let b = fields.controls.iter().map(|g| put(pool, g)).collect::<Result<_, _>>()?;
    let c = c.iter().map(|row| put(pool, row)).collect::<Result<_, _>>()?;
    Ok(Linear { a, b, c })
}

/// Why there is no linear system at the point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum NotLinear {
    /// It does not rest at the point for all values of the parameters.
    NoEquilibrium,
    /// Something has no value there.
    NoValue,
}

impl fmt::Display for NotLinear {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            NotLinear::NoEquilibrium => "the point is not an equilibrium for all values of the parameters",
            NotLinear::NoValue => "a derivative has no value at the point",
        })
    }
}
