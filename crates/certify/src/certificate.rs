//! Certificates, and their check in exact arithmetic.

use bracketry_lie::linear::MultivariatePolynomial;
use bracketry_symbolic::Rational;
use serde::{Deserialize, Serialize};

use crate::gram::{Gram, MAX_EXPONENT};
use crate::model::rate;
use crate::rest::only_the_origin;

/// What is claimed of x' = f(x) + Σ u_j g_j(x), y = h(x) with an equilibrium at x = 0, and everything that shows it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Certificate {
    /// Names of the states, whose deviations from the equilibrium are the variables.
    pub states: Vec<String>,
    /// f.
    pub field: Vec<MultivariatePolynomial>,
    /// The claim.
    pub claim: Claim,
}

/// A claim with its functions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Claim {
    /// φ is constant along all motions: ∇φ·f = 0.
    Conserved {
        /// φ.
        function: MultivariatePolynomial,
    },
    /// V is positive definite and radially unbounded, and −∇V·f is a sum of squares. Where no motion but rest stays in the set on which
    /// it vanishes, V proves attraction, too (Barbashin and Krasovskii 1952, LaSalle 1960).
    Lyapunov {
        /// V.
        function: MultivariatePolynomial,
        /// Of V.
        positive: Gram,
        /// Of −∇V·f.
        decrease: Gram,
    },
    /// V as before, and −∇V·f − (c − V) s is a positive definite sum of squares with a sum of squares s, so that V falls on
    /// {0 < V ≤ c}.
    Region {
        /// V.
        function: MultivariatePolynomial,
        /// c > 0.
        #[serde(with = "text")]
        level: Rational,
        /// Of V.
        positive: Gram,
        /// Of s.
        multiplier: Gram,
        /// Of −∇V·f − (c − V) s.
        decrease: Gram,
    },
    /// S ≥ 0 with S(0) = 0, ∇S·f ≤ 0, and ∇S·g_j = h_j: S' ≤ uᵀy.
    Passive {
        /// g_j by input.
        input_fields: Vec<Vec<MultivariatePolynomial>>,
        /// h.
        outputs: Vec<MultivariatePolynomial>,
        /// S.
        storage: MultivariatePolynomial,
        /// Of S.
        positive: Gram,
        /// Of −∇S·f.
        dissipation: Gram,
    },
}

mod text {
    use bracketry_symbolic::Rational;
    use serde::{Deserialize, Deserializer, Serializer};

    pub(super) fn serialize<S: Serializer>(q: &Rational, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(q)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Rational, D::Error> {
        let text = String::deserialize(deserializer)?;
        text.parse().map_err(|_| serde::de::Error::custom(format!("`{text}` is not a rational number")))
    }
}

/// What a valid certificate proves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Conclusion {
    /// The function is constant along all motions.
    Conserved,
    /// Every motion tends to the equilibrium, which is stable.
    GloballyAsymptoticallyStable,
    /// The equilibrium is stable, and all motions are bounded.
    Stable,
    /// The equilibrium is asymptotically stable, and every motion from the set {V ≤ c} tends to it.
    RegionOfAttraction,
    /// The system is passive: stored energy grows at most by what is supplied, S' ≤ uᵀy.
    Passive,
    /// Passive with S' = uᵀy.
    Lossless,
}

/// Why a certificate proves nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, thiserror::Error)]
#[serde(rename_all = "snake_case")]
pub enum Flaw {
    /// Lists whose lengths do not fit, or a matrix that is not symmetric.
    #[error("the sizes of its parts do not match, or a Gram matrix is not symmetric")]
    Malformed,
    /// A nonzero derivative at the origin.
    #[error("the origin is not an equilibrium")]
    NotEquilibrium,
    /// ∇φ·f ≠ 0.
    #[error("the function is not constant along motions")]
    NotConserved,
    /// A constant is conserved by any system.
    #[error("the function is constant")]
    Constant,
    /// The Gram matrix of V is another polynomial's.
    #[error("the Gram matrix does not give the function")]
    NotTheFunction,
    /// The Gram matrix of the rate is another polynomial's.
    #[error("the Gram matrix does not give the rate")]
    NotTheRate,
    /// V is not shown to be positive definite.
    #[error("the function is not shown to be positive definite")]
    NotPositive,
    /// The rate is not shown to be negative.
    #[error("the rate is not shown to be negative")]
    NotDecreasing,
    /// The multiplier is not shown to be nowhere negative.
    #[error("the multiplier is not shown to be nonnegative")]
    Multiplier,
    /// c ≤ 0.
    #[error("the level is not positive")]
    Level,
    /// ∇S·g ≠ h.
    #[error("the storage function does not give the outputs")]
    NotTheOutput,
}

impl Certificate {
    /// Checks every identity and inequality in rational arithmetic, from this certificate alone: Gram matrices are multiplied
    /// out, and their semidefiniteness is decided by symmetric elimination.
    ///
    /// # Errors
    /// [`Flaw`]: what fails.
    pub fn verify(&self) -> Result<Conclusion, Flaw> {
        let n = self.states.len();
        if n == 0 || self.field.len() != n || !self.field.iter().all(|p| fits(p, n)) {
            return Err(Flaw::Malformed);
        }
        if !matches!(self.claim, Claim::Conserved { .. }) && self.field.iter().any(|p| constant(p) != Rational::ZERO) {
            return Err(Flaw::NotEquilibrium);
        }
        match &self.claim {
            Claim::Conserved { function } => self.conserved(function),
            Claim::Lyapunov { function, positive, decrease } => {
                self.positive(function, positive)?;
                same(decrease, &self.fall(function)?, n, Flaw::NotTheRate)?;
                match (decrease.is_definite(), decrease.is_semidefinite()) {
                    (true, _) => Ok(Conclusion::GloballyAsymptoticallyStable),
                    (_, true) if only_the_origin(&self.field, decrease) => Ok(Conclusion::GloballyAsymptoticallyStable),
                    (_, true) => Ok(Conclusion::Stable),
                    _ => Err(Flaw::NotDecreasing),
                }
            }
            Claim::Region { function, level, positive, multiplier, decrease } => {
                self.positive(function, positive)?;
                if *level <= Rational::ZERO {
                    return Err(Flaw::Level);
                }
                if !multiplier.is_well_formed(n) || !multiplier.is_semidefinite() {
                    return Err(Flaw::Multiplier);
                }
                let p = on_sublevel_set(&self.fall(function)?, function, level, &multiplier.polynomial());
                same(decrease, &p, n, Flaw::NotTheRate)?;
                if decrease.is_definite() { Ok(Conclusion::RegionOfAttraction) } else { Err(Flaw::NotDecreasing) }
            }
            Claim::Passive { input_fields, outputs, storage, positive, dissipation } => {
                let sizes = input_fields.len() == outputs.len()
                    && !outputs.is_empty()
                    && input_fields.iter().all(|g| g.len() == n && g.iter().all(|p| fits(p, n)))
                    && outputs.iter().all(|h| fits(h, n))
                    && fits(storage, n);
                if !sizes {
                    return Err(Flaw::Malformed);
                }
                same(positive, storage, n, Flaw::NotTheFunction)?;
                if !positive.is_semidefinite() || constant(storage) != Rational::ZERO {
                    return Err(Flaw::NotPositive);
                }
                if input_fields.iter().zip(outputs).any(|(g, h)| rate(storage, g) != *h) {
                    return Err(Flaw::NotTheOutput);
                }
                let fall = self.fall(storage)?;
                same(dissipation, &fall, n, Flaw::NotTheRate)?;
                match (fall.is_zero(), dissipation.is_semidefinite()) {
                    (true, true) => Ok(Conclusion::Lossless),
                    (false, true) => Ok(Conclusion::Passive),
                    _ => Err(Flaw::NotDecreasing),
                }
            }
        }
    }

    fn conserved(&self, function: &MultivariatePolynomial) -> Result<Conclusion, Flaw> {
        if !fits(function, self.states.len()) {
            return Err(Flaw::Malformed);
        }
        if function.degree() == 0 {
            return Err(Flaw::Constant);
        }
        if rate(function, &self.field).is_zero() { Ok(Conclusion::Conserved) } else { Err(Flaw::NotConserved) }
    }

    /// −∇V·f.
    fn fall(&self, v: &MultivariatePolynomial) -> Result<MultivariatePolynomial, Flaw> {
        if !fits(v, self.states.len()) {
            return Err(Flaw::Malformed);
        }
        Ok(MultivariatePolynomial::default().plus(&rate(v, &self.field), &Rational::from(-1)))
    }

    fn positive(&self, v: &MultivariatePolynomial, gram: &Gram) -> Result<(), Flaw> {
        same(gram, v, self.states.len(), Flaw::NotTheFunction)?;
        if gram.is_definite() { Ok(()) } else { Err(Flaw::NotPositive) }
    }
}

/// `fall` − (c − V) s.
pub(crate) fn on_sublevel_set(
    fall: &MultivariatePolynomial,
    v: &MultivariatePolynomial,
    level: &Rational,
    multiplier: &MultivariatePolynomial,
) -> MultivariatePolynomial {
    fall.plus(multiplier, &-level.clone()).plus(&v.product(multiplier), &Rational::ONE)
}

fn fits(p: &MultivariatePolynomial, n: usize) -> bool {
    p.terms().all(|(m, _)| m.len() == n && m.iter().all(|k| *k <= MAX_EXPONENT))
}

fn constant(p: &MultivariatePolynomial) -> Rational {
    p.terms().filter(|(m, _)| m.iter().all(|k| *k == 0)).map(|(_, c)| c.clone()).next().unwrap_or(Rational::ZERO)
}

fn same(gram: &Gram, p: &MultivariatePolynomial, n: usize, flaw: Flaw) -> Result<(), Flaw> {
    if !gram.is_well_formed(n) {
        return Err(Flaw::Malformed);
    }
    if gram.polynomial() == *p { Ok(()) } else { Err(flaw) }
}
