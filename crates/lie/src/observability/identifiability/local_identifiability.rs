//! What the outputs determine locally, with known initial values and unknown inputs.
//!
//! For known inputs, the differentials of an output's derivatives are independent up to an order and never again after
//! it; the span E of all of them is closed under differentiation (Sedoglavic 2002). Knowing an initial value adds its
//! differential to the span at time zero. For unknown inputs w, the differentials of w, w', … are variables of their own.
//! The dimension of what the span shares with the differentials of states and parameters grows by fewer and fewer
//! dimensions with each order, so that it stays once it stayed (ranks of Di Benedetto, Grizzle, and Moog 1989).

use bracketry_symbolic::{Bindings, Echelon, Pool, Residue, SECOND_OFFSET, Symbol, THIRD_OFFSET};

use crate::evidence::Evidence;
use crate::observability::expansion::Expansion;
use crate::observability::series::SeriesProgram;
use crate::residues::unit_row;
use crate::undecided::Undecided;

/// Most field operations for one point.
const MAX_PRODUCTS: f64 = 1e9;
/// Orders without growth, with unknown inputs, after which there is none.
const IDLE: usize = 2;
/// Seed of points and inputs.
pub(crate) const SEED: u64 = 0x6272_6163_6b65_7409;

/// What is asked, in compiled form.
pub(crate) struct Question {
    pub(crate) program: SeriesProgram,
    /// States, then parameters.
    pub(crate) variables: Vec<Symbol>,
    /// How many of them are states.
    pub(crate) states: usize,
    /// Numbers of the states whose initial value is known.
    pub(crate) known: Vec<usize>,
    /// Initial values that are given as numbers.
    pub(crate) special: Bindings,
    /// Whether there are any.
    pub(crate) is_special: bool,
    /// Whether inputs are unknown.
    pub(crate) unknown_inputs: bool,
}

/// The span of the differentials at one point.
pub(crate) struct Point<'a, const C: u64> {
    pub(crate) series: Expansion<'a, C>,
    /// Rows by variables, then coefficients of unknown inputs.
    pub(crate) span: Echelon<Residue<C>>,
    /// Highest derivative of each output that is needed: the first that depends on those before.
    pub(crate) heights: Vec<usize>,
    /// Values of the variables.
    pub(crate) values: Vec<Residue<C>>,
    pub(crate) degree: f64,
}

/// What one prime says.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Local {
    /// By variable.
    pub(crate) determined: Vec<bool>,
    /// By further function.
    pub(crate) functions: Vec<bool>,
    /// Whether "not determined" is certain.
    pub(crate) closed: bool,
}

/// The point that follows from a seed, some symbols bound.
pub(crate) fn point<'a, const C: u64>(
    pool: &mut Pool,
    question: &'a Question,
    bindings: &Bindings,
    seed: u64,
) -> Result<Point<'a, C>, Undecided> {
    let program = &question.program;
    let samples = pool.sample_in::<C>(&program.sampled, bindings, 1, seed)?;
    if samples.ambiguous_signs > 0 {
        return Err(bracketry_symbolic::Undecided::Sign.into());
    }
    let values = samples.values.first().map(Vec::as_slice).unwrap_or_default();
    let mut series = Expansion::<C>::start(program, values, seed)?;
    let columns = program.directions();
    let own = question.variables.len();
    let mut span = Echelon::empty(columns);
    let outputs = program.outputs.len();
    let mut heights: Vec<Option<usize>> = vec![None; outputs];
    let (mut idle, mut shared) = (0, usize::MAX);
    for order in 0.. {
        if let Some(limit) = pool.reached_limit() {
            return Err(limit.into());
        }
        let rows: Vec<Vec<Residue<C>>> = series.rows().collect();
        for (row, height) in rows.into_iter().zip(&mut heights) {
            if height.is_none() && !span.insert(row) && !question.unknown_inputs {
                *height = Some(order);
            }
        }
        if question.unknown_inputs {
            let now = shared_dimension(&span, own);
            idle = if now == shared { idle + 1 } else { 0 };
            shared = now;
            if idle == IDLE || now == own {
                heights.fill(Some(order));
            }
        }
        if heights.iter().all(Option::is_some) {
            break;
        }
        if !series.extend() || series.products > MAX_PRODUCTS {
            return Err(Undecided::TooMany { products: MAX_PRODUCTS });
        }
    }
    let heights = heights.into_iter().flatten().collect();
    let values = values.iter().copied().take(own).collect();
    Ok(Point { series, span, heights, values, degree: samples.degree })
}

/// Dimension of what a span shares with the differentials of the first `own` variables.
fn shared_dimension<const C: u64>(span: &Echelon<Residue<C>>, own: usize) -> usize {
    let tails: Vec<Vec<Residue<C>>> = span.rows.iter().map(|r| r[own..].to_vec()).collect();
    let columns = tails.first().map_or(0, Vec::len);
    span.rank() - Echelon::new(&tails, columns).rank()
}

impl Question {
    /// The span with what is known from the start.
    pub(crate) fn with_known<const C: u64>(&self, span: &Echelon<Residue<C>>) -> Echelon<Residue<C>> {
        let mut span = span.clone();
        for &i in &self.known {
            span.insert(unit_row(i, self.program.directions()));
        }
        span
    }

    fn local_in<const C: u64>(&self, pool: &mut Pool, evidence: &mut Evidence) -> Result<Local, Undecided> {
        let mut here = point::<C>(pool, self, &self.special, SEED)?;
        evidence.add_series(here.degree, here.span.rank(), here.series.orders())?;
        let mut closed = true;
        if self.is_special {
            // Where the rank is that of other points, the differentials span what they do elsewhere.
            let generic = point::<C>(pool, self, &Bindings::new(), SEED ^ 1)?;
            closed = generic.span.rank() == here.span.rank();
            for _ in 0..if closed { 0 } else { self.variables.len() } {
                if !here.series.extend() || here.series.products > MAX_PRODUCTS {
                    break;
                }
                let rows: Vec<Vec<Residue<C>>> = here.series.rows().collect();
                for row in rows {
                    here.span.insert(row);
                }
            }
        }
        let span = self.with_known(&here.span);
        let columns = self.program.directions();
        let determined = (0..self.variables.len()).map(|i| span.contains(&unit_row(i, columns))).collect();
        let functions = here.series.gradients().map(|g| span.contains(g)).collect();
        Ok(Local { determined, functions, closed })
    }

    /// The local answers. A rank modulo a prime is never too large, so that "determined" is certain but for chance;
    /// where something is not, a second prime has to agree.
    ///
    /// # Errors
    /// [`Undecided`] if a function has no series, or there is too much to compute.
    pub(crate) fn local(&self, pool: &mut Pool, evidence: &mut Evidence) -> Result<Local, Undecided> {
        let moduli = [Self::local_in::<1>, Self::local_in::<SECOND_OFFSET>, Self::local_in::<THIRD_OFFSET>];
        let mut found: Vec<Local> = Vec::new();
        let mut refused = None;
        for modulo in moduli {
            match modulo(self, pool, evidence) {
                Ok(v) => {
                    if v.determined.iter().chain(&v.functions).all(|d| *d) || found.contains(&v) {
                        return Ok(v);
                    }
                    found.push(v);
                }
                Err(Undecided::Exact(why)) if why.needs_other_prime() => refused = Some(why),
                Err(why) => return Err(why),
            }
        }
        match refused {
            Some(why) => Err(why.into()),
            None => Err(bracketry_symbolic::Undecided::NoPoint.into()),
        }
    }
}
