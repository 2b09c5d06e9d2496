//! The inverse of a change of coordinates in closed form, by elimination.

use bracketry_symbolic::{Expr, Symbol};
use rustc_hash::FxHashMap;

use crate::algebra::rational::readable::{tidy, vanishing_factors};
use crate::budget::check_size;
use crate::forms::frame::Frame;
use crate::forms::root::{Quality, Root, fold, roots};
use crate::undecided::Undecided;

/// x = S(z).
#[derive(Clone, Debug)]
pub(crate) struct Inverse {
    /// One entry per unknown.
    pub(crate) values: Vec<Expr>,
    /// Whether a branch was chosen.
    pub(crate) branch: bool,
    /// The unknowns at the point that chose it.
    pub(crate) base: Vec<f64>,
}

/// Most nodes of coordinates that are inverted, and most new nodes on the way.
const MAX_COORDINATE_NODES: usize = 1500;
const MAX_NODES: usize = 60_000;
/// Errors of the numbers that tell branches apart.
const TOLERANCE: f64 = 1e-8;

/// Equations to be solved for unknowns, with a point where they hold.
struct Elimination<'a> {
    frame: &'a mut Frame,
    /// Unknowns and new coordinates, with their values at the base point.
    symbols: Vec<Symbol>,
    at: Vec<f64>,
    free: Vec<Symbol>,
    equations: Vec<Expr>,
    solved: Vec<(Symbol, Expr)>,
    branch: bool,
}

impl Frame {
    /// The inverse of z = T(x), with z `new` and x `unknowns`, around a point near the model's; confirmed: T(S(z)) = z exactly,
    /// and S(T(x)) = x at a point, which by the inverse function theorem makes it the inverse on a neighborhood.
    pub(crate) fn invert(
        &mut self,
        unknowns: &[Symbol],
        coordinates: &[Expr],
        new: &[Symbol],
        base: Vec<f64>,
    ) -> Result<Option<Inverse>, Undecided> {
        let Some(images) = self.numbers(coordinates, unknowns, &base) else { return Ok(None) };
        let first = self.system.pool.len();
        if self.system.pool.reachable(coordinates).len() > MAX_COORDINATE_NODES {
            return Ok(None);
        }
        let mut equations = Vec::new();
        for (&t, &z) in coordinates.iter().zip(new) {
            let z = self.system.pool.sym(z);
            equations.push(self.system.pool.sub(t, z));
        }
        let mut elimination = Elimination {
            symbols: unknowns.iter().chain(new).copied().collect(),
            at: base.iter().copied().chain(images).collect(),
            free: unknowns.to_vec(),
            equations: Vec::new(),
            solved: Vec::new(),
            branch: false,
            frame: self,
        };
        for e in equations {
            let e = elimination.normalized(e);
            elimination.equations.push(e);
        }
        while !elimination.equations.is_empty() {
            check_size(&elimination.frame.system.pool, first)?;
            if elimination.frame.system.pool.len() > first + MAX_NODES || !elimination.step() {
                return Ok(None);
            }
        }
        let Elimination { solved, branch, .. } = elimination;
        let value = |s: &Symbol| solved.iter().find(|x| x.0 == *s).map(|x| x.1);
        let Some(values) = unknowns.iter().map(value).collect::<Option<Vec<Expr>>>() else { return Ok(None) };
        let found = Inverse { values, branch, base };
        if !self.returns(unknowns, coordinates, new, &found) {
            return Ok(None);
        }
        Ok(self.confirms(unknowns, coordinates, new, &found)?.then_some(found))
    }

    /// Whether S(T(x)) = x at the base point, and at the model's point unless a value is not finite there.
    fn returns(&self, unknowns: &[Symbol], coordinates: &[Expr], new: &[Symbol], found: &Inverse) -> bool {
        let image = |at: &[f64]| {
            let z = self.numbers(coordinates, unknowns, at)?;
            self.numbers(&found.values, new, &z)
        };
        let same = |at: &[f64]| {
            let back = image(at)?;
            let close = |(x, b): (&f64, &f64)| (x - b).abs() <= 1e-6 * (1.0 + x.abs());
            back.iter().all(|b| b.is_finite()).then(|| at.iter().zip(&back).all(close))
        };
        let at_point = self.system.point_values().map(|p| p.0).filter(|at| at.len() == unknowns.len());
        same(&found.base) == Some(true) && at_point.is_none_or(|at| same(&at) != Some(false))
    }

    /// Whether T(S(z)) = z.
    fn confirms(
        &mut self,
        unknowns: &[Symbol],
        coordinates: &[Expr],
        new: &[Symbol],
        found: &Inverse,
    ) -> Result<bool, Undecided> {
        let pool = &mut self.system.pool;
        if pool.symbols_of(&found.values).iter().any(|s| unknowns.contains(s)) {
            return Ok(false);
        }
        let map: FxHashMap<Expr, Expr> = unknowns.iter().zip(&found.values).map(|(&s, &v)| (pool.sym(s), v)).collect();
        let images = pool.substitute_all(coordinates, &map);
        for (image, &z) in images.into_iter().zip(new) {
            let pool = &mut self.system.pool;
            let z = pool.sym(z);
            let difference = pool.sub(image, z);
            let difference = fold(pool, difference);
            let difference = tidy(pool, difference);
            match self.is_zero(difference) {
                Ok(Some(_)) => {}
                Ok(None) | Err(Undecided::Exact(_)) => return Ok(false),
                Err(why) => return Err(why),
            }
        }
        Ok(true)
    }
}

impl Elimination<'_> {
    /// The factor of an equation that vanishes at the base point.
    fn normalized(&mut self, e: Expr) -> Expr {
        let pool = &mut self.frame.system.pool;
        let e = fold(pool, e);
        let e = tidy(pool, e);
        let Some(factors) = vanishing_factors(pool, e, &self.symbols, &self.frame.fields.bindings) else { return e };
        let Some(values) = self.frame.numbers(&factors, &self.symbols, &self.at) else { return e };
        let mut zeros = factors.iter().zip(&values).filter(|(_, v)| v.abs() <= TOLERANCE).map(|(&f, _)| f);
        match (zeros.next(), zeros.next()) {
            (Some(one), None) => one,
            _ => e,
        }
    }

    /// Solves the equation that is easiest to solve.
    fn step(&mut self) -> bool {
        let mut best: Option<((Quality, u64), usize, Symbol, Root)> = None;
        for k in 0..self.equations.len() {
            for i in (0..self.free.len()).rev() {
                let (e, s) = (self.equations[k], self.free[i]);
                let Some(root) = self.root(e, s) else { continue };
                let size = self.frame.system.pool.text_size(root.value);
                let score = (root.quality, size.length.saturating_add(20 * size.quotients));
                if best.as_ref().is_none_or(|b| score < b.0) {
                    best = Some((score, k, s, root));
                }
            }
        }
        let Some((_, k, s, root)) = best else { return false };
        self.equations.remove(k);
        self.free.retain(|&t| t != s);
        self.branch |= root.quality == Quality::Branch;
        let pool = &mut self.frame.system.pool;
        let map: FxHashMap<Expr, Expr> = std::iter::once((pool.sym(s), root.value)).collect();
        for i in 0..self.solved.len() {
            self.solved[i].1 = replaced(&mut self.frame.system.pool, self.solved[i].1, &map);
        }
        self.solved.push((s, root.value));
        for i in 0..self.equations.len() {
            let e = self.frame.system.pool.substitute(self.equations[i], &map);
            if e != self.equations[i] {
                self.equations[i] = self.normalized(e);
            }
        }
        true
    }

    /// The solution of one equation that holds at the base point.
    fn root(&mut self, e: Expr, s: Symbol) -> Option<Root> {
        let candidates = roots(&mut self.frame.system.pool, e, s, &self.free);
        let at = self.at[self.symbols.iter().position(|&t| t == s)?];
        candidates.into_iter().find_map(|mut root| {
            root.value = fold(&mut self.frame.system.pool, root.value);
            if root.quality == Quality::Branch {
                root.value = tidy(&mut self.frame.system.pool, root.value);
            }
            let value = self.frame.numbers(&[root.value], &self.symbols, &self.at)?[0];
            ((value - at).abs() <= TOLERANCE * (1.0 + at.abs())).then_some(root)
        })
    }
}

/// An expression with what was found put in.
fn replaced(pool: &mut bracketry_symbolic::Pool, e: Expr, map: &FxHashMap<Expr, Expr>) -> Expr {
    let new = pool.substitute(e, map);
    if new == e {
        return e;
    }
    let new = fold(pool, new);
    tidy(pool, new)
}
