//! Where the rate of a function is looked at.

use std::collections::BTreeSet;

use bracketry_symbolic::{Expr, Pool, Rational, Symbol};
use rustc_hash::FxHashMap;

use crate::linear::matrix::RationalMatrix;
use crate::linear::polynomial::MultivariatePolynomial;

/// Points, by the value of a function there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Region {
    /// Where the function has its value at the point: the half-space beyond is not left (Nagumo 1942).
    Level,
    /// All points: the function never turns back.
    All,
    /// Where it is at least its value at the point: it does not fall back to it from above.
    Above,
    /// Where it is at most its value at the point.
    Below,
}

/// Where the rate of a function is looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Extent {
    pub(crate) region: Region,
    /// At all distances from the point, which takes all modes. Else near the point.
    pub(crate) everywhere: bool,
}

impl Extent {
    /// An invariant half-space, and one near the point.
    pub(crate) const HALF_SPACE: Extent = Extent { region: Region::Level, everywhere: true };
    pub(crate) const LOCAL_HALF_SPACE: Extent = Extent { region: Region::Level, everywhere: false };

    /// Near the point.
    pub(crate) fn near(region: Region) -> Extent {
        Extent { region, everywhere: false }
    }
}

impl Region {
    /// Whether a function that changes like this there does not return to its value at the point, or not from one side.
    pub(crate) fn bars(self, up: bool, down: bool) -> bool {
        match self {
            Region::Level | Region::All => up || down,
            Region::Above => up,
            Region::Below => down,
        }
    }

    /// What to put in place of the variables so that they run through the region of a function that vanishes at their origin: in
    /// place of one of them a combination of the others, with ± the square of the variable itself. `None` where [`solved`] finds
    /// none.
    pub(crate) fn coordinates(
        self,
        pool: &mut Pool,
        function: Expr,
        variables: &[Symbol],
    ) -> Option<FxHashMap<Expr, Expr>> {
        if self == Region::All {
            return Some(FxHashMap::default());
        }
        let target = |pool: &mut Pool, y: Expr| {
            let square = pool.powi(y, 2);
            match self {
                Region::Above => square,
                Region::Below => pool.neg(square),
                Region::Level | Region::All => pool.int(0),
            }
        };
        solved(pool, function, variables, target).map(|(_, map)| map)
    }
}

/// One of the variables, and what to put in place of them all so that the function takes a value that is given as a function of
/// that variable: they move along a constant direction in which the function is affine with a constant slope. `None` where no
/// such direction is found.
pub(crate) fn solved(
    pool: &mut Pool,
    function: Expr,
    variables: &[Symbol],
    value: impl Fn(&mut Pool, Expr) -> Expr,
) -> Option<(Symbol, FxHashMap<Expr, Expr>)> {
    let gradient = pool.gradient(function, variables);
    let (k, direction, slope) = (0..variables.len())
        .rev()
        .find_map(|k| {
            let slope = pool.simplify(gradient[k]);
            let constant = !pool.symbols_of(&[slope]).iter().any(|s| variables.contains(s));
            let unit = (0..variables.len()).map(|i| Rational::from(i64::from(i == k))).collect::<Vec<_>>();
            (constant && !pool.is_zero(slope)).then_some((k, unit, slope))
        })
        .or_else(|| mixed_direction(pool, &gradient, variables))?;
    let (zero, y) = (pool.int(0), pool.sym(variables[k]));
    let target = value(pool, y);
    let rest = pool.substitute(function, &std::iter::once((y, zero)).collect());
    let gap = pool.sub(target, rest);
    let along = pool.div(gap, slope);
    let mut map: FxHashMap<Expr, Expr> = FxHashMap::default();
    for (i, c) in direction.into_iter().enumerate().filter(|(_, c)| *c != Rational::ZERO) {
        let c = pool.rational(c);
        let step = pool.mul(c, along);
        let x = pool.sym(variables[i]);
        let moved = if i == k { step } else { pool.add(x, step) };
        map.insert(x, pool.expand(moved));
    }
    Some((variables[k], map))
}

/// A direction d in which a polynomial with this gradient has the constant slope d·∇φ ≠ 0, the last variable that it moves, and the
/// slope.
fn mixed_direction(pool: &mut Pool, gradient: &[Expr], variables: &[Symbol]) -> Option<(usize, Vec<Rational>, Expr)> {
    let gradient: Vec<MultivariatePolynomial> =
        gradient.iter().map(|&e| MultivariatePolynomial::of(pool, e, variables)).collect::<Option<_>>()?;
    let constant = vec![0; variables.len()];
    let monomials: BTreeSet<&Vec<u32>> =
        gradient.iter().flat_map(MultivariatePolynomial::terms).map(|t| t.0).filter(|m| **m != constant).collect();
    let rows = monomials.into_iter().map(|m| gradient.iter().map(|p| p.coefficient(m)).collect()).collect();
    RationalMatrix::new(rows, variables.len()).null_space().into_iter().find_map(|d| {
        let slope = gradient.iter().zip(&d).fold(Rational::ZERO, |s, (p, c)| s + p.coefficient(&constant) * c);
        let k = d.iter().rposition(|c| *c != Rational::ZERO)?;
        (slope != Rational::ZERO).then(|| (k, d, pool.rational(slope)))
    })
}
