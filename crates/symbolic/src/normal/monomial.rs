//! Common factors taken out of sums, and sums ordered by the powers of chosen symbols.

use std::collections::BTreeMap;

use dashu_ratio::RBig;
use rustc_hash::FxHashMap;

use crate::node::{Expr, Node, Symbol};
use crate::pool::Pool;
use crate::text::terms;

impl Pool {
    /// `e` with the monomial that all terms of a sum share in front of it, for all sums in `e`.
    ///
    /// ```
    /// # use bracketry_symbolic::Pool;
    /// let mut p = Pool::new();
    /// let e = p.parse("2*m*x^2*sin(q) - 4*m*x*sin(q)^2").unwrap();
    /// let f = p.factor_common(e);
    /// assert_eq!(p.text(f), "2*m*x*sin(q)*(x - 2*sin(q))");
    /// ```
    pub fn factor_common(&mut self, e: Expr) -> Expr {
        let e = self.collected(e);
        let mut image: FxHashMap<Expr, Expr> = FxHashMap::default();
        for n in self.reachable(&[e]) {
            let made = self.rebuild(n, |o| image[&o]);
            // A sum within a sum is part of the outer one.
            let r = if let Node::Add(..) = self.node(made) { self.common_out(made) } else { made };
            image.insert(n, r);
        }
        image[&e]
    }

    /// The sum as its greatest common monomial times the rest.
    fn common_out(&mut self, sum: Expr) -> Expr {
        let all = terms(self, sum);
        let mut common: Option<Vec<(Expr, RBig)>> = None;
        for &t in &all {
            let powers = self.factored(t).1;
            let shared = match common {
                None => powers,
                Some(mut known) => {
                    known.retain_mut(|(base, k)| {
                        let here = powers.iter().find(|(b, _)| b == base).map(|(_, k)| k);
                        let same_sign = here.is_some_and(|h| (*h > RBig::ZERO) == (*k > RBig::ZERO));
                        if let Some(h) = here.filter(|_| same_sign) {
                            if (h < k) == (*k > RBig::ZERO) {
                                k.clone_from(h);
                            }
                            return true;
                        }
                        false
                    });
                    known
                }
            };
            if shared.is_empty() {
                return sum;
            }
            common = Some(shared);
        }
        let mut monomial = self.int(1);
        for (base, k) in common.unwrap_or_default() {
            let k = self.rational(k);
            let f = self.pow(base, k);
            monomial = self.mul(monomial, f);
        }
        let mut rest = Vec::with_capacity(all.len());
        for t in all {
            let q = self.div(t, monomial);
            rest.push(self.collected(q));
        }
        let rest = self.sum(rest);
        let (content, powers) = self.factored(rest);
        let [(primitive, _)] = powers.as_slice() else { return sum };
        // Interned as it is, so that the monomial is read first.
        let monomial = self.collected(monomial);
        let product = self.intern(Node::Mul(monomial, *primitive));
        let content = self.rational(content);
        self.mul(content, product)
    }

    /// `e` multiplied out and written as Σ coefficient · monomial in the given symbols, highest degree first; each
    /// coefficient is simplified. Symbols that stand inside functions, denominators or roots count as part of the
    /// coefficient.
    ///
    /// ```
    /// # use bracketry_symbolic::Pool;
    /// let mut p = Pool::new();
    /// let e = p.parse("(x + a)*(x + b) + x*y").unwrap();
    /// let (x, y) = (p.symbol("x"), p.symbol("y"));
    /// let all = p.coefficients(e, &[x, y]);
    /// let read: Vec<_> = all.iter().map(|(k, c)| (k.clone(), p.text(*c))).collect();
    /// assert_eq!(read, [(vec![2, 0], "1".into()), (vec![1, 1], "1".into()), (vec![1, 0], "a + b".into()), (vec![0, 0], "a*b".into())]);
    /// ```
    pub fn coefficients(&mut self, e: Expr, symbols: &[Symbol]) -> Vec<(Vec<u32>, Expr)> {
        let mut sums: BTreeMap<Vec<u32>, Vec<Expr>> = BTreeMap::new();
        for t in self.expanded_terms(e) {
            let (coefficient, powers) = self.factored(t);
            let mut exponents = vec![0; symbols.len()];
            let mut rest = self.rational(coefficient);
            for (base, k) in powers {
                let place = match self.node(base) {
                    Node::Sym(s) => symbols.iter().position(|&v| v == s),
                    _ => None,
                };
                let natural = u32::try_from(k.numerator()).ok().filter(|_| k.is_int());
                if let (Some(i), Some(n)) = (place, natural) {
                    exponents[i] = n;
                } else {
                    let k = self.rational(k);
                    let f = self.pow(base, k);
                    rest = self.mul(rest, f);
                }
            }
            sums.entry(exponents).or_default().push(rest);
        }
        let mut out = Vec::with_capacity(sums.len());
        for (exponents, coefficients) in sums {
            let c = self.sum(coefficients);
            let c = self.simplify(c);
            if !self.is_zero(c) {
                out.push((exponents, c));
            }
        }
        out.sort_by(|(a, _), (b, _)| b.iter().sum::<u32>().cmp(&a.iter().sum::<u32>()).then_with(|| b.cmp(a)));
        out
    }

    /// [`Pool::coefficients`] as one expression: `e` ordered by the powers of the given symbols.
    ///
    /// ```
    /// # use bracketry_symbolic::Pool;
    /// let mut p = Pool::new();
    /// let e = p.parse("(x + a)*(x + b)").unwrap();
    /// let x = p.symbol("x");
    /// let f = p.collect_terms(e, &[x]);
    /// assert_eq!(p.text(f), "x^2 + x*(a + b) + a*b");
    /// ```
    pub fn collect_terms(&mut self, e: Expr, symbols: &[Symbol]) -> Expr {
        let (mut sum, mut constant) = (None, self.int(0));
        for (exponents, c) in self.coefficients(e, symbols) {
            let mut monomial = self.int(1);
            for (&s, &k) in symbols.iter().zip(&exponents) {
                let x = self.sym(s);
                let f = self.powi(x, i64::from(k));
                monomial = self.mul(monomial, f);
            }
            if self.is_one(monomial) && self.number(c).is_some() {
                constant = c;
                continue;
            }
            let term = self.mul(monomial, c);
            let term = self.collected(term);
            // Interned as it is, so that the order stays.
            sum = Some(sum.map_or(term, |s| self.intern(Node::Add(s, term))));
        }
        match sum {
            Some(s) => self.add(constant, s),
            None => constant,
        }
    }
}
