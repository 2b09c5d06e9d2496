//! Replacing expressions, and components of unit vectors however the products around them are written.

use bracketry_symbolic::{Expr, Node, Pool};
use rustc_hash::FxHashMap;

use super::terms::factors;

/// A component `a/√S` of a unit vector and what stands for it.
struct Direction {
    factors: Vec<Expr>,
    image: Expr,
}

/// The expressions with the first of each of the `pairs` replaced by the second. A key `a/√S` is also found within products in which
/// its two factors stand apart, as in `m*a*g/√S`; where several keys fit, as `a/√S` and `b/√S` in `a*b/√S`, the earliest is taken.
pub(crate) fn replace_all(pool: &mut Pool, roots: &[Expr], pairs: &[(Expr, Expr)]) -> Vec<Expr> {
    let map: FxHashMap<Expr, Expr> = pairs.iter().copied().collect();
    let mut directions = Vec::new();
    for &(from, image) in pairs {
        let factors = factors(pool, from);
        if factors.len() == 2 && factors.iter().any(|&f| under_inverse_root(pool, f).is_some()) {
            directions.push(Direction { factors, image });
        }
    }
    if directions.is_empty() {
        return pool.substitute_all(roots, &map);
    }
    let roots = with_roots_as_written(pool, roots, &directions);
    let mut new: FxHashMap<Expr, Expr> = FxHashMap::default();
    for e in pool.reachable(&roots) {
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

/// The expressions with what stands under their inverse roots written as under those of the directions, where it is the same.
fn with_roots_as_written(pool: &mut Pool, roots: &[Expr], directions: &[Direction]) -> Vec<Expr> {
    let bases = |pool: &Pool, of: &[Expr]| -> Vec<Expr> {
        pool.reachable(of).into_iter().filter_map(|e| under_inverse_root(pool, e)).collect()
    };
    let wanted: Vec<Expr> =
        directions.iter().flat_map(|d| &d.factors).filter_map(|&f| under_inverse_root(pool, f)).collect();
    let mut map = FxHashMap::default();
    for base in bases(pool, roots) {
        let same = wanted.iter().find(|&&w| {
            let difference = pool.sub(base, w);
            let difference = pool.expand(difference);
            w != base && pool.is_zero(difference)
        });
        if let Some(&w) = same {
            map.insert(base, w);
        }
    }
    if map.is_empty() { roots.to_vec() } else { pool.substitute_all(roots, &map) }
}

/// `S` of `1/√S`.
pub(super) fn under_inverse_root(pool: &Pool, e: Expr) -> Option<Expr> {
    match pool.node(e) {
        Node::Pow(base, k) => pool.number(k).is_some_and(|k| k.to_f64().value() == -0.5).then_some(base),
        _ => None,
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
