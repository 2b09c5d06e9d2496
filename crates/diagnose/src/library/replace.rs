//! Replacing expressions, and components of unit vectors however the products around them are written.

use bracketry_symbolic::{Expr, Node, Pool};
use rustc_hash::FxHashMap;

use super::terms::factors;

/// A component `a/√S` of a unit vector and what stands for it.
struct Direction {
    factors: Vec<Expr>,
    image: Expr,
}

/// The expressions with every key of the map replaced by its value. A key `a/√S` is also found within products in which
/// its two factors stand apart, as in `m*a*g/√S`.
pub(crate) fn replace_all(pool: &mut Pool, roots: &[Expr], map: &FxHashMap<Expr, Expr>) -> Vec<Expr> {
    let mut directions = Vec::new();
    for (&from, &image) in map {
        let factors = factors(pool, from);
        if factors.len() == 2 && factors.iter().any(|&f| is_inverse_root(pool, f)) {
            directions.push(Direction { factors, image });
        }
    }
    if directions.is_empty() {
        return pool.substitute_all(roots, map);
    }
    let mut new: FxHashMap<Expr, Expr> = FxHashMap::default();
    for e in pool.reachable(roots) {
        let image = match (map.get(&e), pool.node(e)) {
            (Some(&image), _) => image,
            (None, Node::Mul(..)) => match without(pool, e, &directions) {
                Some((rest, images)) => {
                    let one = pool.int(1);
                    let rest = rest.into_iter().map(|f| new.get(&f).copied().unwrap_or(f));
                    rest.chain(images).fold(one, |product, f| pool.mul(product, f))
                }
                None => pool.rebuild(e, |o| new[&o]),
            },
            _ => pool.rebuild(e, |o| new[&o]),
        };
        new.insert(e, image);
    }
    roots.iter().map(|e| new[e]).collect()
}

fn is_inverse_root(pool: &Pool, e: Expr) -> bool {
    match pool.node(e) {
        Node::Pow(_, k) => pool.number(k).is_some_and(|k| k.to_f64().value() == -0.5),
        _ => false,
    }
}

/// The other factors of a product that contains directions, and the images of those.
fn without(pool: &Pool, e: Expr, directions: &[Direction]) -> Option<(Vec<Expr>, Vec<Expr>)> {
    let (mut rest, mut images) = (factors(pool, e), Vec::new());
    while let Some((fewer, image)) = directions.iter().find_map(|d| {
        let mut fewer = rest.clone();
        for f in &d.factors {
            fewer.remove(fewer.iter().position(|r| r == f)?);
        }
        Some((fewer, d.image))
    }) {
        rest = fewer;
        images.push(image);
    }
    (!images.is_empty()).then_some((rest, images))
}
