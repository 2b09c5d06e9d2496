//! The physical terms of an equation.

use bracketry_symbolic::Expr;
use bracketry_system::System;

use super::structure::Structure;
use super::terms::{factors, summands};

/// The summands of an expression multiplied out, those put together again that differ by functions of the configuration
/// only, as `(Sa*sin(phi)^2 + Sb*cos(phi)^2)*der(theta, 2)`: one entry of an inertia matrix, one coefficient of a force. What is
/// a function of the configuration altogether stays apart.
pub(crate) fn physical_terms(system: &mut System, structure: &Structure, e: Expr) -> Vec<Expr> {
    let expanded = system.pool.expand(e);
    let still = |e: Expr| {
        system.pool.symbols_of(&[e]).iter().all(|s| {
            system.parameters.iter().any(|p| p.symbol == *s)
                || structure.coordinates.iter().any(|c| c.position.is_some_and(|q| system.states[q] == *s))
        })
    };
    let mut groups: Vec<(Vec<Expr>, Vec<Expr>)> = Vec::new();
    for term in summands(&system.pool, expanded) {
        let mut moving: Vec<Expr> = factors(&system.pool, term).into_iter().filter(|&f| !still(f)).collect();
        moving.sort_unstable_by_key(|f| f.index());
        match groups.iter_mut().find(|g| !moving.is_empty() && g.0 == moving) {
            Some(group) => group.1.push(term),
            None => groups.push((moving, vec![term])),
        }
    }
    let zero = system.pool.int(0);
    groups.into_iter().map(|(_, terms)| terms.into_iter().fold(zero, |sum, t| system.pool.add(sum, t))).collect()
}
