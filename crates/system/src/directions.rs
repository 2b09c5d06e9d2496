//! Symbols for the components of set-valued unit vectors, and which unit vectors of a system are set-valued.

use bracketry_symbolic::{Directed, Expr, Node, Rational};
use rustc_hash::{FxHashMap, FxHashSet};

use crate::quotient_kind::QuotientKind;
use crate::system::System;
use crate::unit_vector::{MAX_COMPONENTS, Rewriter, Root};

/// Expressions in which symbols stand for the components of set-valued unit vectors.
pub(crate) struct Directions {
    /// The expressions.
    pub(crate) rewritten: Vec<Expr>,
    /// The roots |σ| of these unit vectors.
    pub(crate) roots: Vec<Root>,
    /// Roots whose quotients jump where σ = 0, and are smooth elsewhere. These stay as they are written.
    pub(crate) singular: Vec<Root>,
    /// Squares |σ|² of quotients that are continuous where σ = 0: what they are multiplied by vanishes there.
    pub(crate) continuous: Vec<Expr>,
}

impl System {
    /// The expressions with every component of a set-valued unit vector σ/|σ| as a symbol; of which kind a quotient is
    /// decided in the equations of the system.
    ///
    /// A quotient `N/√S` is one where `S` is a sum of squares with positive coefficients that depends on more than the
    /// parameters in each term, and the numerator vanishes with the components: `N = Σ c_i σ_i`.
    pub(crate) fn directions(&mut self, expressions: &[Expr]) -> Directions {
        let (_, candidates) = self.rewrite_unit_vectors(expressions, &[], |_, _| true);
        let kinds = self.kinds(&candidates, |s, square| s.pool.directed(square).is_some());
        let of = |wanted: QuotientKind| {
            let list = candidates.iter().zip(&kinds).filter(move |(_, k)| **k == wanted);
            list.map(|(r, _)| r.clone()).collect::<Vec<Root>>()
        };
        let singular = of(QuotientKind::Singular);
        let continuous: Vec<Expr> = of(QuotientKind::Continuous).into_iter().map(|r| r.square).collect();
        let refused: Vec<Expr> = singular.iter().map(|r| r.square).chain(continuous.iter().copied()).collect();
        let (rewritten, roots) = self.rewrite_unit_vectors(expressions, &refused, |_, _| true);
        Directions { rewritten, roots, singular, continuous }
    }

    /// Marks the unit vectors that are dry friction, so that they stay what they are when the equations are changed, as where a
    /// parameter becomes a state. A model that was read or built has them marked; do it before changing one in another way.
    pub fn mark_dry_friction(&mut self) {
        let rows = self.rows();
        for root in self.directions(&rows).roots {
            self.pool.set_directed(root.square, Directed::Found);
        }
    }

    /// The expressions with the components of those unit vectors as symbols `unit(…)` that were written so and would not be
    /// found to be set-valued as quotients.
    pub(crate) fn with_units_as_written(&mut self, expressions: &[Expr]) -> Vec<Expr> {
        let is_written = |s: &System, e: Expr| s.pool.directed(e) == Some(Directed::Written);
        let (_, candidates) = self.rewrite_unit_vectors(expressions, &[], is_written);
        let kinds = self.kinds(&candidates, |_, _| false);
        let found = candidates.iter().zip(kinds).filter(|(_, k)| *k == QuotientKind::DryFriction);
        let found: Vec<Expr> = found.map(|(r, _)| r.square).collect();
        let (mut rewritten, roots) = self.rewrite_unit_vectors(expressions, &found, is_written);
        for root in roots {
            let components: Vec<Expr> = root.components.iter().map(|c| self.pool.mul(c.scale, c.base)).collect();
            let mut texts: Vec<String> = components.iter().map(|&c| self.pool.text(c)).collect();
            let mut named: FxHashMap<Expr, Expr> = FxHashMap::default();
            for (i, &direction) in root.directions.iter().enumerate() {
                texts.swap(0, i);
                let written = self.pool.symbol(&format!("unit({})", texts.join(", ")));
                texts.swap(0, i);
                let (direction, written) = (self.pool.sym(direction), self.pool.sym(written));
                named.insert(direction, written);
            }
            rewritten = self.pool.substitute_all(&rewritten, &named);
        }
        rewritten
    }

    /// What the quotients of each root are: dry friction where that is `known`, else by the equations.
    fn kinds(&mut self, roots: &[Root], known: impl Fn(&System, Expr) -> bool) -> Vec<QuotientKind> {
        let known: Vec<bool> = roots.iter().map(|r| known(self, r.square)).collect();
        if known.iter().all(|k| *k) {
            return vec![QuotientKind::DryFriction; roots.len()];
        }
        let rows = self.rows();
        let (rows, roots_of_rows) = self.rewrite_unit_vectors(&rows, &[], |_, _| true);
        let mut kinds = Vec::new();
        for (root, known) in roots.iter().zip(known) {
            let at = roots_of_rows.iter().position(|r| r.square == root.square);
            kinds.push(match at {
                _ if known => QuotientKind::DryFriction,
                Some(at) => self.quotient_kind(&rows, &roots_of_rows, at),
                None => QuotientKind::Singular,
            });
        }
        kinds
    }

    /// Squares with odd powers in the expressions, none of them in a denominator: `|v|` and `|v|³`, which have no unit vector
    /// but whose derivatives do.
    pub(crate) fn lengths(&mut self, expressions: &[Expr]) -> Vec<Expr> {
        let pool = &self.pool;
        let nodes = pool.reachable(expressions);
        let power = |e: Expr| match pool.node(e) {
            Node::Pow(base, exponent) => pool.number(exponent).map(|k| (base, k)),
            _ => None,
        };
        let below: Vec<Expr> = nodes
            .iter()
            .filter_map(|&e| power(e))
            .filter(|(_, k)| **k < Rational::ZERO)
            .map(|(base, _)| base)
            .collect();
        let below: FxHashSet<Expr> = pool.reachable(&below).into_iter().collect();
        let mut found: Vec<Expr> = nodes
            .iter()
            .filter(|e| !below.contains(e))
            .filter_map(|&e| power(e))
            .filter(|(_, k)| !k.is_int() && **k > Rational::ZERO && (*k * Rational::from(2u8)).is_int())
            .map(|(base, _)| base)
            .filter(|base| !below.contains(base))
            .collect();
        found.sort_unstable();
        found.dedup();
        let mut rewriter = Rewriter::new(self, &[]);
        found.retain(|&s| rewriter.components(s).is_some_and(|c| (2..=MAX_COMPONENTS).contains(&c.len())));
        found
    }

    /// The expressions with every component of a unit vector as a symbol, and the roots that were met so: those that are
    /// `wanted` and not refused.
    pub(crate) fn rewrite_unit_vectors(
        &mut self,
        expressions: &[Expr],
        refused: &[Expr],
        wanted: impl Fn(&System, Expr) -> bool,
    ) -> (Vec<Expr>, Vec<Root>) {
        let mut rewriter = Rewriter::new(self, refused);
        let rewritten = rewriter.run(expressions, wanted);
        let Rewriter { roots, used, .. } = rewriter;
        if used.is_empty() {
            return (expressions.to_vec(), Vec::new());
        }
        (rewritten, roots.into_iter().enumerate().filter(|(i, _)| used.contains(i)).map(|(_, r)| r).collect())
    }
}
