//! Polynomials that are constant along all motions.

use bracketry_lie::Evidence;
use bracketry_lie::algebra::integrals;
use bracketry_lie::linear::{MultivariatePolynomial, RationalMatrix};
use bracketry_symbolic::{Bindings, Echelon, Expr, Function, Limit, Rational};
use bracketry_system::System;
use rustc_hash::FxHashMap;

use crate::certificate::{Certificate, Claim};
use crate::model::{PolynomialModel, rate};
use crate::monomials::{Monomial, degree, monomials};

/// Most unknown coefficients.
const MAX_UNKNOWNS: usize = 300;

/// The conserved polynomials of a model, up to a degree.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ConservedPolynomials {
    /// Polynomials of which all others of the degree are polynomials, each with its certificate.
    pub(crate) generators: Vec<Certificate>,
    /// The degree up to which the list is complete; 0 where even degree 1 has too many unknowns.
    pub(crate) degree: u32,
}

/// All polynomials φ of degree at most `largest` with ∇φ·f = 0: the null space of a rational matrix. Only those are kept that are
/// no polynomials of others.
pub(crate) fn conserved(model: &PolynomialModel, largest: u32, limit: &Limit) -> ConservedPolynomials {
    let n = model.dimension();
    let mut generators: Vec<MultivariatePolynomial> = Vec::new();
    let mut complete = 0;
    for d in 1..=largest {
        let listed = monomials(n, 1..=d).filter(|list| list.len() < MAX_UNKNOWNS && !limit.is_reached());
        let Some(list) = listed else { break };
        let known = products(&generators, d);
        let mut span = Echelon::empty(list.len());
        for p in &known {
            span.insert(list.iter().map(|m| p.coefficient(m)).collect());
        }
        for v in null_space(model, &list) {
            if span.insert(v.clone()) {
                generators.push(combination(&list, &v));
            }
        }
        complete = d;
    }
    let certificate = |function| Certificate {
        states: model.states.clone(),
        field: model.drift.clone(),
        claim: Claim::Conserved { function },
    };
    let valid = generators.into_iter().map(certificate).filter(|c| c.verify().is_ok());
    ConservedPolynomials { generators: valid.collect(), degree: complete }
}

fn null_space(model: &PolynomialModel, list: &[Monomial]) -> Vec<Vec<Rational>> {
    let rates: Vec<MultivariatePolynomial> =
        list.iter().map(|m| rate(&MultivariatePolynomial::term(Rational::ONE, m.clone()), &model.drift)).collect();
    let mut support: Vec<&Monomial> = rates.iter().flat_map(|p| p.terms().map(|(m, _)| m)).collect();
    support.sort_unstable();
    support.dedup();
    let rows = support.into_iter().map(|m| rates.iter().map(|p| p.coefficient(m)).collect()).collect();
    RationalMatrix::new(rows, list.len()).null_space()
}

fn combination(list: &[Monomial], v: &[Rational]) -> MultivariatePolynomial {
    let mut p = MultivariatePolynomial::default();
    for (m, c) in list.iter().zip(v) {
        p.add_term(m.clone(), c.clone());
    }
    p
}

/// Products of the generators up to a degree, without the empty one.
fn products(generators: &[MultivariatePolynomial], largest: u32) -> Vec<MultivariatePolynomial> {
    let mut list: Vec<MultivariatePolynomial> = Vec::new();
    for g in generators {
        let mut powers = vec![g.clone()];
        while let Some(last) = powers.last()
            && last.degree() + g.degree() <= largest
        {
            powers.push(last.product(g));
        }
        let mut more = powers.clone();
        for p in &list {
            for q in powers.iter().filter(|q| p.degree() + q.degree() <= largest) {
                more.push(p.product(q));
            }
        }
        list.extend(more);
    }
    list.retain(|p| p.terms().all(|(m, _)| degree(m) > 0));
    list
}

/// Functions that are constant along all motions of any smooth model, inputs at their values at the point, by the search for first
/// integrals of the analysis.
pub(crate) fn first_integrals(original: &System, limit: &Limit) -> Vec<Function> {
    let mut system = original.clone();
    let zero = system.pool.int(0);
    let held: Vec<Expr> = match &system.point {
        Some(p) => p.inputs.clone(),
        None => vec![zero; system.inputs.len()],
    };
    let values: FxHashMap<Expr, Expr> =
        system.inputs.clone().into_iter().zip(held).map(|(u, value)| (system.pool.sym(u), value)).collect();
    let drift = system.pool.substitute_all(&original.dynamics, &values);
    let switches = system.switched_form();
    if !system.input_derivatives.is_empty() || !switches.switches.is_empty() {
        return Vec::new();
    }
    system.pool.set_limit(limit.clone());
    let mut bindings = Bindings::new();
    for p in &system.parameters {
        bindings.bind(p.symbol, p.value.clone());
    }
    let states = system.states.clone();
    match integrals(&mut system.pool, &states, &[drift], &[], &bindings, &mut Evidence::default()) {
        Ok(found) => Function::list(&system.pool, &found.functions),
        Err(_) => Vec::new(),
    }
}
