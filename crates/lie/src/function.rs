//! Functions as text.

use bracketry_symbolic::{Expr, Pool};

/// Longer expressions are not written into a report.
const MAX_TEXT: usize = 4000;

/// The text of an expression, or its size if it is long.
pub(crate) fn shown(pool: &Pool, e: Expr) -> String {
    let text = if pool.tree_size(e) < MAX_TEXT as f64 { pool.text(e) } else { String::new() };
    if text.is_empty() || text.len() > MAX_TEXT {
        format!("<{} nodes, not shown>", pool.reachable(&[e]).len())
    } else {
        text
    }
}
