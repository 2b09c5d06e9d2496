//! Where an expression in time jumps, so that its derivative has impulses that symbolic differentiation leaves out.

use bracketry_symbolic::{Expr, Func, Func2, Node, Pool, Symbol};
use rustc_hash::FxHashMap;

/// Whether `e` jumps where a `sign`, `abs`, `min` or `max` of something that moves with `time` switches.
///
/// On the surface `σ = 0` of each of these, `σ` and `|σ|` are zero and `min`, `max` are either argument; what then still
/// depends on `sign(σ)` jumps. So `abs(u)` and `u*sign(u)` do not, `sign(u)` does; a factor that vanishes there but
/// contains σ in another form is not recognized, and the expression is said to jump.
pub(crate) fn jumps(pool: &mut Pool, e: Expr, time: Symbol) -> bool {
    let mut switching: Vec<(Expr, Expr)> = Vec::new();
    for node in pool.reachable(&[e]) {
        let surface = match pool.node(node) {
            Node::Call(Func::Sign | Func::Abs, a) => a,
            Node::Call2(Func2::Min | Func2::Max, a, b) => pool.sub(a, b),
            _ => continue,
        };
        if pool.depends_on(surface, time) {
            switching.push((node, surface));
        }
    }
    let zero = pool.int(0);
    switching.iter().any(|&(_, surface)| {
        let opposite = pool.neg(surface);
        let mut side = |sign: i64| {
            let mut map: FxHashMap<Expr, Expr> = [(surface, zero), (opposite, zero)].into_iter().collect();
            for &(node, other) in &switching {
                let sign = match other {
                    same if same == surface => sign,
                    flipped if flipped == opposite => -sign,
                    _ => continue,
                };
                let value = match pool.node(node) {
                    Node::Call(Func::Sign, _) => pool.int(sign),
                    // The simpler of two arguments that are equal here.
                    Node::Call2(_, a, b) => {
                        if pool.number(b).is_some() {
                            b
                        } else {
                            a
                        }
                    }
                    _ => zero,
                };
                map.insert(node, value);
            }
            pool.substitute(e, &map)
        };
        let (above, below) = (side(1), side(-1));
        above != below
    })
}
