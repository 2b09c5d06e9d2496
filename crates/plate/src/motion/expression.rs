//! Plate motions given by expressions.

use super::kinematics::{PlateKinematics, PlateMotion};
use crate::PlateError;
use bracketry_system::symbolic::{Expr, Pool, Symbol, Tape};

/// A plate motion given by expressions of `t` and of named numbers that may change between calls.
///
/// ```
/// use bracketry_plate::PlateMotion;
/// use bracketry_plate::motion::ExpressionMotion;
/// let mut motion = ExpressionMotion::new("A*sin(2*t)", "0", &[("A", 0.5)]).unwrap();
/// assert_eq!(motion.at(0.0).velocity, 1.0);
/// assert!(motion.set("A", 2.0));
/// assert_eq!(motion.at(0.0).velocity, 4.0);
/// ```
#[derive(Debug, Clone)]
pub struct ExpressionMotion {
    /// `X, X', X'', θ, θ', θ''` of `t` and the numbers.
    tape: Tape,
    names: Vec<String>,
    arguments: Vec<f64>,
    work: Vec<f64>,
    results: [f64; 6],
}

impl ExpressionMotion {
    /// Compiles `X(t)` in meters and `θ(t)` in radians, expressions of `t` and of the numbers `(name, value)`, with
    /// their derivatives.
    ///
    /// # Errors
    /// [`PlateError::Motion`] if an expression cannot be read or uses another name; [`PlateError::BadMotionNumber`] for a
    /// number that is not finite.
    pub fn new(displacement: &str, tilt: &str, numbers: &[(&str, f64)]) -> Result<Self, PlateError> {
        let mut pool = Pool::new();
        let t = pool.symbol("t");
        let mut symbols = vec![t];
        for (name, value) in numbers {
            if !value.is_finite() {
                return Err(PlateError::BadMotionNumber { name: (*name).to_owned(), value: *value });
            }
            symbols.push(pool.symbol(name));
        }
        let mut all = Vec::with_capacity(6);
        for text in [displacement, tilt] {
            let bad = |reason: String| PlateError::Motion { text: text.to_owned(), reason };
            let expression = pool.parse(text).map_err(|e| bad(e.to_string()))?;
            unknown(&pool, expression, &symbols)
                .map_or(Ok(()), |name| Err(bad(format!("`{name}` is neither `t` nor one of the motion's numbers"))))?;
            let rate = pool.diff(expression, t);
            let acceleration = pool.diff(rate, t);
            all.extend([expression, rate, acceleration]);
        }
        let tape = Tape::compile(&pool, &symbols, &all)
            .map_err(|e| PlateError::Motion { text: format!("{displacement}; {tilt}"), reason: e.to_string() })?;
        let mut arguments = vec![0.0];
        arguments.extend(numbers.iter().map(|(_, value)| *value));
        Ok(Self {
            tape,
            names: numbers.iter().map(|(name, _)| (*name).to_owned()).collect(),
            arguments,
            work: Vec::new(),
            results: [0.0; 6],
        })
    }

    /// Sets one of the numbers; false if there is none of that name.
    pub fn set(&mut self, name: &str, value: f64) -> bool {
        let Some(index) = self.names.iter().position(|n| n == name) else {
            return false;
        };
        self.arguments[index + 1] = value;
        true
    }
}

impl PlateMotion for ExpressionMotion {
    fn at(&mut self, t: f64) -> PlateKinematics {
        self.arguments[0] = t;
        self.tape.eval(&self.arguments, &mut self.work, &mut self.results);
        let [displacement, velocity, acceleration, tilt, tilt_rate, tilt_acceleration] = self.results;
        PlateKinematics { displacement, velocity, acceleration, tilt, tilt_rate, tilt_acceleration }
    }
}

/// A name in the expression that is none of `known`.
fn unknown(pool: &Pool, expression: Expr, known: &[Symbol]) -> Option<String> {
    let stranger = pool.symbols_of(&[expression]).into_iter().find(|symbol| !known.contains(symbol))?;
    Some(pool.name(stranger).to_owned())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn derivatives_agree_with_central_differences() {
        let mut motion = ExpressionMotion::new("A*sin(3*t)*(1 - exp(-t))", "A*cos(t)^2", &[("A", 0.7)]).unwrap();
        let h = 1e-4;
        for t in [0.1, 0.9, 2.3] {
            let (before, now, after) = (motion.at(t - h), motion.at(t), motion.at(t + h));
            let slope = |f: fn(&PlateKinematics) -> f64| (f(&after) - f(&before)) / (2.0 * h);
            assert!((now.velocity - slope(|k| k.displacement)).abs() < 1e-6);
            assert!((now.acceleration - slope(|k| k.velocity)).abs() < 1e-6);
            assert!((now.tilt_rate - slope(|k| k.tilt)).abs() < 1e-6);
            assert!((now.tilt_acceleration - slope(|k| k.tilt_rate)).abs() < 1e-6);
        }
    }

    #[test]
    fn unknown_names_and_bad_syntax_are_told_with_the_text() {
        let error = ExpressionMotion::new("B*sin(t)", "0", &[("A", 1.0)]).unwrap_err().to_string();
        assert!(error.contains("`B`") && error.contains("B*sin(t)"), "{error}");
        assert!(ExpressionMotion::new("sin(", "0", &[]).is_err());
        assert!(ExpressionMotion::new("0", "A", &[("A", f64::NAN)]).is_err());
    }
}
