//! A model as polynomials in the deviations from an equilibrium.

use bracketry_lie::linear::MultivariatePolynomial;
use bracketry_symbolic::{Expr, Function, Limit, Names, ParseError, Pool, Rational, Symbol, closest_name};
use bracketry_system::System;
use rustc_hash::FxHashMap;

use crate::reason::CertificateReason;

/// x' = f(x) + Σ u_j g_j(x), y = h(x), in deviations from an equilibrium, with rational coefficients.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PolynomialModel {
    /// Names of the states.
    pub(crate) states: Vec<String>,
    /// Names of the inputs that no feedback sets.
    pub(crate) inputs: Vec<String>,
    /// Names of the outputs.
    pub(crate) output_names: Vec<String>,
    /// The equilibrium: states, then those inputs.
    pub(crate) point: Vec<Rational>,
    /// f.
    pub(crate) drift: Vec<MultivariatePolynomial>,
    /// g_j by input; `None` where the equations are not affine in the inputs.
    pub(crate) input_fields: Option<Vec<Vec<MultivariatePolynomial>>>,
    /// h − h(0) of each output; `None` where an output is no polynomial of the states.
    pub(crate) outputs: Option<Vec<MultivariatePolynomial>>,
}

/// A feedback that cannot be read.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FeedbackError {
    /// No input of that name.
    #[error("the model has no input `{name}`: {remedy}")]
    UnknownInput {
        /// The name as given.
        name: String,
        /// What to write instead.
        remedy: String,
    },
    /// An input that was set before.
    #[error("the input `{name}` is set twice: remove one of its expressions")]
    Twice {
        /// The input.
        name: String,
    },
    /// Not `INPUT=EXPRESSION`.
    #[error("`{entry}` has no expression: write INPUT=EXPRESSION, such as u=-x")]
    NoExpression {
        /// As given.
        entry: String,
    },
    /// An expression that cannot be read.
    #[error("the feedback of `{name}`")]
    Expression {
        /// The input.
        name: String,
        /// What is wrong.
        source: ParseError,
    },
}

/// States, parameters, and definitions.
struct Known(FxHashMap<String, Expr>);

impl Names for Known {
    fn lookup(&mut self, _pool: &mut Pool, name: &str) -> Option<Expr> {
        self.0.get(name).copied()
    }

    fn known(&self) -> Vec<String> {
        self.0.keys().cloned().collect()
    }
}

/// Closes the loop: sets inputs to expressions of the states, given as `u=-x-2*v`.
///
/// ```
/// use bracketry_certify::with_feedback;
/// use bracketry_system::System;
/// let text = "states = ['x']\ninputs = ['u']\ndynamics = { x = 'x^3 + u' }";
/// let closed = with_feedback(&System::parse("m", text).unwrap(), &["u=-2*x".to_owned()]).unwrap();
/// assert!(closed.inputs.is_empty());
/// assert!(with_feedback(&closed, &["u=0".to_owned()]).is_err());
/// ```
///
/// # Errors
/// [`FeedbackError`] with what to write instead.
pub fn with_feedback(system: &System, feedback: &[String]) -> Result<System, FeedbackError> {
    let mut closed = system.clone();
    let mut known: FxHashMap<String, Expr> = system.definitions.iter().cloned().collect();
    let symbols: Vec<Symbol> =
        system.states.iter().copied().chain(system.parameters.iter().map(|p| p.symbol)).collect();
    for s in symbols {
        let e = closed.pool.sym(s);
        known.insert(system.symbol_name(s).to_owned(), e);
    }
    let mut values: FxHashMap<Expr, Expr> = FxHashMap::default();
    let mut set = Vec::new();
    for entry in feedback {
        let Some((name, text)) = entry.split_once('=') else {
            return Err(FeedbackError::NoExpression { entry: entry.trim().to_owned() });
        };
        let name = name.trim();
        let Some(k) = system.input_index(name) else {
            let inputs = system.input_names();
            let remedy = match closest_name(name, inputs.iter().map(String::as_str)) {
                Some(near) => format!("did you mean `{near}`?"),
                None if inputs.is_empty() => "it has none".to_owned(),
                None => format!("it has {}", inputs.join(", ")),
            };
            return Err(FeedbackError::UnknownInput { name: name.to_owned(), remedy });
        };
        if set.contains(&k) {
            return Err(FeedbackError::Twice { name: name.to_owned() });
        }
        set.push(k);
        let value = closed
            .pool
            .parse_with(text, &mut Known(known.clone()))
            .map_err(|source| FeedbackError::Expression { name: name.to_owned(), source })?;
        let input = closed.pool.sym(system.inputs[k]);
        values.insert(input, value);
    }
    closed.dynamics = closed.pool.substitute_all(&system.dynamics, &values);
    let outputs: Vec<Expr> = system.outputs.iter().map(|o| o.1).collect();
    let outputs = closed.pool.substitute_all(&outputs, &values);
    for (output, e) in closed.outputs.iter_mut().zip(outputs) {
        output.1 = e;
    }
    let open = |k: &usize| !set.contains(k);
    let is_open = |s: &Symbol| (0..system.inputs.len()).filter(open).any(|k| system.inputs[k] == *s);
    closed.inputs.retain(is_open);
    // Delays and ranges stay: a delayed feedback is refused, and an ignored range is noted.
    if let Some(point) = &mut closed.point {
        let kept = (0..system.inputs.len()).filter(open);
        point.inputs = kept.map(|k| point.inputs[k]).collect();
    }
    Ok(closed)
}

impl PolynomialModel {
    /// The model at its point; the reason where it is not polynomial, or the point no equilibrium.
    pub(crate) fn new(original: &System, limit: &Limit) -> Result<Self, CertificateReason> {
        let mut system = original.clone();
        system.pool.set_limit(limit.clone());
        if let Some(d) = system.input_derivatives.first() {
            let input = system.symbol_name(system.inputs[d.input]).to_owned();
            return Err(CertificateReason::InputDerivative { input });
        }
        if let Some(d) = system.input_delays.first() {
            return Err(CertificateReason::InputDelay { input: system.symbol_name(d.input).to_owned() });
        }
        let variables: Vec<Symbol> = system.states.iter().chain(&system.inputs).copied().collect();
        let point = exact_point(&mut system, &variables)?;
        let mut shift: FxHashMap<Expr, Expr> = FxHashMap::default();
        for (&s, value) in variables.iter().zip(&point) {
            let (x, value) = (system.pool.sym(s), system.pool.rational(value.clone()));
            let sum = system.pool.add(x, value);
            shift.insert(x, sum);
        }
        let (names, inputs) = (system.state_names(), system.input_names());
        let n = names.len();
        let dynamics = system.with_values(&original.dynamics);
        let shifted = system.pool.substitute_all(&dynamics, &shift);
        let mut drift = Vec::with_capacity(n);
        let mut fields = Some(vec![Vec::with_capacity(n); inputs.len()]);
        for (name, e) in names.iter().zip(shifted) {
            let p = MultivariatePolynomial::of(&mut system.pool, e, &variables);
            // Beyond the limit, products are not multiplied out.
            if system.pool.reached_limit().is_some() {
                return Err(CertificateReason::OutOfTime);
            }
            let p = p.ok_or_else(|| CertificateReason::NotPolynomial { of: name.clone() })?;
            let rest = p.coefficient(&vec![0; variables.len()]);
            if rest != Rational::ZERO {
                return Err(CertificateReason::NotEquilibrium {
                    state: name.clone(),
                    derivative: rest.to_f64().value(),
                });
            }
            let (free, by_input) = split(&p, n, inputs.len());
            drift.push(free);
            match by_input {
                Some(list) => fields.iter_mut().flatten().zip(list).for_each(|(field, g)| field.push(g)),
                None => fields = None,
            }
        }
        let expressions: Vec<Expr> = original.outputs.iter().map(|o| o.1).collect();
        let expressions = system.with_values(&expressions);
        let expressions = system.pool.substitute_all(&expressions, &shift);
        let outputs = expressions
            .into_iter()
            .map(|e| {
                let p = MultivariatePolynomial::of(&mut system.pool, e, &system.states)?;
                let constant = p.coefficient(&vec![0; n]);
                Some(p.plus(&MultivariatePolynomial::term(constant, vec![0; n]), &Rational::from(-1)))
            })
            .collect();
        let output_names = original.outputs.iter().map(|o| o.0.clone()).collect();
        Ok(PolynomialModel { states: names, inputs, output_names, point, drift, input_fields: fields, outputs })
    }

    /// Number of states.
    pub(crate) fn dimension(&self) -> usize {
        self.states.len()
    }

    /// ∇V · f.
    pub(crate) fn rate(&self, v: &MultivariatePolynomial) -> MultivariatePolynomial {
        rate(v, &self.drift)
    }

    /// Largest degree of f.
    pub(crate) fn degree(&self) -> u32 {
        self.drift.iter().map(MultivariatePolynomial::degree).max().unwrap_or(0)
    }
}

/// ∇V · f.
pub(crate) fn rate(v: &MultivariatePolynomial, f: &[MultivariatePolynomial]) -> MultivariatePolynomial {
    f.iter()
        .enumerate()
        .fold(MultivariatePolynomial::default(), |sum, (i, f)| sum.plus(&v.derivative(i).product(f), &Rational::ONE))
}

/// The part without inputs, and the factors of the inputs where there are no others.
fn split(
    p: &MultivariatePolynomial,
    n: usize,
    inputs: usize,
) -> (MultivariatePolynomial, Option<Vec<MultivariatePolynomial>>) {
    let mut free = MultivariatePolynomial::default();
    let mut fields = Some(vec![MultivariatePolynomial::default(); inputs]);
    for (m, c) in p.terms() {
        let (state, input) = m.split_at(n);
        match input.iter().sum::<u32>() {
            0 => free.add_term(state.to_vec(), c.clone()),
            1 => {
                let of = input.iter().position(|&k| k == 1).unwrap_or(0);
                if let Some(list) = &mut fields {
                    list[of].add_term(state.to_vec(), c.clone());
                }
            }
            _ => fields = None,
        }
    }
    (free, fields)
}

/// Longest denominator of a coordinate, in digits: longer ones are results of rounding.
const MAX_DIGITS: usize = 30;

fn exact_point(system: &mut System, variables: &[Symbol]) -> Result<Vec<Rational>, CertificateReason> {
    let Some(point) = system.point.clone() else { return Ok(vec![Rational::ZERO; variables.len()]) };
    let values: Vec<Expr> = point.states.iter().chain(&point.inputs).copied().collect();
    let values = system.with_values(&values);
    variables
        .iter()
        .zip(values)
        .map(|(&s, e)| {
            let e = system.pool.simplify(e);
            let value = system.pool.number(e).filter(|q| q.denominator().to_string().len() <= MAX_DIGITS).cloned();
            value.ok_or_else(|| CertificateReason::IrrationalPoint { name: system.symbol_name(s).to_owned() })
        })
        .collect()
}

/// A polynomial of deviations as an expression of the model's own names.
pub(crate) fn function(p: &MultivariatePolynomial, names: &[String], point: &[Rational]) -> Function {
    let mut pool = Pool::new();
    let deviations: Vec<Expr> = names
        .iter()
        .zip(point)
        .map(|(name, value)| {
            let (x, value) = (pool.var(name), pool.rational(value.clone()));
            pool.sub(x, value)
        })
        .collect();
    let mut terms: Vec<(&Vec<u32>, &Rational)> = p.terms().collect();
    terms.sort_by_key(|(m, _)| std::cmp::Reverse(((m.iter().sum::<u32>()), (*m).clone())));
    terms.reverse();
    let list: Vec<Expr> = terms
        .into_iter()
        .map(|(m, c)| {
            let mut e = pool.rational(c.clone());
            for (&x, &k) in deviations.iter().zip(m) {
                let power = pool.powi(x, i64::from(k));
                e = pool.mul(e, power);
            }
            e
        })
        .collect();
    let sum = pool.sum(list);
    Function::new(&pool, sum)
}
