//! Levels c of a function V below which it falls.

use bracketry_lie::linear::MultivariatePolynomial;
use bracketry_symbolic::{Limit, Rational};

use crate::certificate::{Certificate, Claim, on_sublevel_set};
use crate::gram::Gram;
use crate::linearization::{Evaluated, negative};
use crate::lyapunov::{sum_of_squares, unknown};
use crate::model::PolynomialModel;
use crate::monomials::monomials;
use crate::sum_of_squares::decimals::rounded;
use crate::sum_of_squares::program::{AffinePolynomial, Program, Unsolved};

/// Halvings of the interval of levels.
const HALVINGS: usize = 10;
/// Margin of a numerical solution below which a level is not used.
const MARGIN: f64 = 1e-6;
/// The search over levels of one function.
pub(crate) struct Levels<'a> {
    pub(crate) model: &'a PolynomialModel,
    pub(crate) v: &'a MultivariatePolynomial,
    pub(crate) limit: &'a Limit,
    pub(crate) powers: Vec<i32>,
}

impl Levels<'_> {
    /// The program of s: −V' − (c − V) s and s are sums of squares.
    fn program(&self, level: &Rational) -> Result<(Program, AffinePolynomial), Unsolved> {
        let n = self.model.dimension();
        let fall = negative(&self.model.rate(self.v));
        let half = fall.degree().saturating_sub(self.v.degree()).div_ceil(2).max(1);
        // A multiplier of the least degree that lets V s bound V' far away cannot be small nearby as well.
        let half = if self.v.degree() > 2 { half + 1 } else { half };
        let s = unknown(&monomials(n, 2..=2 * half).ok_or(Unsolved::TooLarge)?);
        let linear = s.linear.iter().map(|s| on_sublevel_set(&MultivariatePolynomial::default(), self.v, level, s));
        let inside = AffinePolynomial { constant: fall, linear: linear.collect() };
        let constraints = vec![sum_of_squares(n, s.clone())?, sum_of_squares(n, inside)?];
        Ok((Program { unknowns: s.linear.len(), constraints, zero: Vec::new() }, s))
    }

    /// The multiplier s of a level, in floating point; none where the level is too large.
    pub(crate) fn multiplier(&self, level: f64) -> Result<Option<MultivariatePolynomial>, Unsolved> {
        let level = Rational::try_from(level).map_err(|_| Unsolved::NotFeasible)?;
        let (program, s) = self.program(&level)?;
        match numerical(program, &self.powers, self.limit)? {
            Some(unknowns) => Ok(Some(s.at(&unknowns))),
            None => Ok(None),
        }
    }

    /// The certificate of one level.
    pub(crate) fn certified(&self, level: &Rational) -> Result<Certificate, Unsolved> {
        let (program, _) = self.program(level)?;
        let exact = program.certified(&self.powers, self.limit)?;
        let n = self.model.dimension();
        let alone = AffinePolynomial { constant: self.v.clone(), linear: Vec::new() };
        let of_v = Program { unknowns: 0, constraints: vec![sum_of_squares(n, alone)?], zero: Vec::new() };
        let positive = of_v.certified(&self.powers, self.limit)?.grams.into_iter().next();
        let [multiplier, decrease]: [Gram; 2] = exact.grams.try_into().map_err(|_| Unsolved::NotRounded)?;
        let claim = Claim::Region {
            function: self.v.clone(),
            level: level.clone(),
            positive: positive.ok_or(Unsolved::NotRounded)?,
            multiplier,
            decrease,
        };
        let certificate = Certificate { states: self.model.states.clone(), field: self.model.drift.clone(), claim };
        certificate.verify().map(|_| certificate).map_err(|_| Unsolved::NotRounded)
    }

    /// The largest feasible level below `above` up to the accuracy of the search, with its multiplier.
    pub(crate) fn feasible(&self, above: f64) -> Result<(f64, MultivariatePolynomial), Unsolved> {
        let (mut low, mut high) = (None, above);
        let mut trial = 0.98 * above;
        for _ in 0..HALVINGS {
            match self.multiplier(trial)? {
                Some(s) => low = Some((trial, s)),
                None => high = trial,
            }
            // While nothing is feasible, levels fall fast.
            trial = low.as_ref().map_or(0.2 * high, |(low, _)| 0.5 * (low + high));
        }
        low.ok_or(Unsolved::NotFeasible)
    }

    /// The largest certified level below `above`.
    pub(crate) fn largest(&self, above: f64) -> Result<Certificate, Unsolved> {
        let (low, _) = self.feasible(above)?;
        let mut last = Unsolved::NotRounded;
        for part in [1.0, 0.999, 0.99, 0.95, 0.8, 0.5] {
            let [level] = &rounded(&[part * low], 4)[..] else { continue };
            match self.certified(level) {
                Ok(certificate) => return Ok(certificate),
                Err(Unsolved::OutOfTime) => return Err(Unsolved::OutOfTime),
                Err(why) => last = why,
            }
        }
        Err(last)
    }
}

/// A numerical solution with a margin, as rational numbers of 8 digits; none where there is none.
pub(crate) fn numerical(program: Program, powers: &[i32], limit: &Limit) -> Result<Option<Vec<Rational>>, Unsolved> {
    let reduced = match program.scaled(powers).reduced() {
        Ok(reduced) => reduced,
        Err(Unsolved::Contradiction) => return Ok(None),
        Err(why) => return Err(why),
    };
    match reduced.program.solve(limit) {
        Ok(numeric) if numeric.margin > MARGIN => Ok(Some(reduced.original(&rounded(&numeric.unknowns, 8)))),
        Ok(_) | Err(Unsolved::NotFeasible) => Ok(None),
        Err(why) => Err(why),
    }
}

/// Directions along which V' is examined: angles in the plane, else points spread by the additive recurrence of the golden ratio's
/// generalization (Roberts 2018).
fn directions(n: usize) -> Vec<Vec<f64>> {
    if n == 1 {
        return vec![vec![1.0], vec![-1.0]];
    }
    if n == 2 {
        let angle = |k: usize| std::f64::consts::TAU * k as f64 / 720.0;
        return (0..720).map(|k| vec![angle(k).cos(), angle(k).sin()]).collect();
    }
    let mut root: f64 = 2.0;
    for _ in 0..50 {
        root = (1.0 + root).powf(1.0 / (n as f64 + 1.0));
    }
    (0..4000)
        .map(|k| {
            let x: Vec<f64> =
                (0..n).map(|i| 2.0 * (0.5 + k as f64 * root.powi(-(i as i32) - 1)).fract() - 1.0).collect();
            let size = x.iter().map(|x| x * x).sum::<f64>().sqrt().max(1e-9);
            x.into_iter().map(|x| x / size).collect()
        })
        .collect()
}

/// The least value of V found where V' ≥ 0: an upper bound of every level, up to the directions.
pub(crate) fn first_rise(model: &PolynomialModel, v: &MultivariatePolynomial) -> Option<f64> {
    let (value, rate) = (Evaluated::new(v), Evaluated::new(&model.rate(v)));
    let mut least: Option<f64> = None;
    for d in directions(model.dimension()) {
        let at = |r: f64| -> Vec<f64> { d.iter().map(|x| r * x).collect() };
        let (mut below, mut r) = (0.0, 1e-4);
        while r < 1e4 {
            if rate.at(&at(r)) >= 0.0 {
                for _ in 0..40 {
                    let middle = 0.5 * (below + r);
                    if rate.at(&at(middle)) >= 0.0 { r = middle } else { below = middle }
                }
                let level = value.at(&at(r));
                least = Some(least.map_or(level, |l| l.min(level)));
                break;
            }
            below = r;
            r *= 1.05;
        }
    }
    least
}

/// The volume of {V ≤ c} of a region's certificate up to a factor that depends on the dimension only: the mean of r^n over directions, with
/// the first r at which V reaches c.
pub(crate) fn size(certificate: &Certificate) -> f64 {
    let Claim::Region { function, level, .. } = &certificate.claim else { return 0.0 };
    let (value, c) = (Evaluated::new(function), level.to_f64().value());
    let n = certificate.states.len();
    let radius = |d: &Vec<f64>| {
        let at = |r: f64| value.at(&d.iter().map(|x| r * x).collect::<Vec<_>>());
        let (mut inside, mut r) = (0.0, 1e-4);
        while at(r) < c && r < 1e6 {
            inside = r;
            r *= 1.1;
        }
        for _ in 0..20 {
            let middle = 0.5 * (inside + r);
            if at(middle) < c { inside = middle } else { r = middle }
        }
        r
    };
    let list = directions(n);
    list.iter().map(|d| radius(d).powi(n as i32)).sum::<f64>() / list.len() as f64
}
