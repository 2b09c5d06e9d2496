//! Least values of functions on boxes, for other crates.

use bracketry_symbolic::{Expr, Pool, Symbol};

use crate::enclosure::{Enclosed, Enclosure};
use crate::extrema::least;

/// The least value of a function on a box.
#[derive(Clone, Debug, PartialEq)]
pub struct LeastValue {
    /// A number that no value on the box is below, computed with outward rounding; some value comes near to it.
    pub value: f64,
    /// The corner at which it is taken, for each variable whether its upper end; `None` where it is not known to be a corner.
    pub corner: Option<Vec<bool>>,
}

impl LeastValue {
    /// The least value of `e` where every variable lies between its two numbers, by branch and bound with enclosures. `None`
    /// for a function without enclosure, for names that are no variables, and where the search was given up.
    ///
    /// ```
    /// use bracketry_system::{LeastValue, symbolic::Pool};
    /// let mut pool = Pool::new();
    /// let x = pool.symbol("x");
    /// let e = pool.parse("x^2 - x").unwrap();
    /// let least = LeastValue::on_box(&mut pool, e, &[x], &[[0.0, 2.0]]).unwrap();
    /// assert!((least.value + 0.25).abs() < 1e-9);
    /// ```
    pub fn on_box(pool: &mut Pool, e: Expr, variables: &[Symbol], region: &[[f64; 2]]) -> Option<Self> {
        let mut all = vec![e];
        all.extend(pool.gradient(e, variables));
        let mut enclosed = Enclosed::new(pool, variables, &all)?;
        let region: Vec<Enclosure> = region.iter().map(|&[lower, upper]| Enclosure { lower, upper }).collect();
        let found = least(&mut enclosed, 1.0, &region)?;
        Some(LeastValue { value: found.value, corner: found.corner })
    }
}
