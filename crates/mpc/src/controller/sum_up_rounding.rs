//! Sum-up rounding: inputs of a finite set from inputs between its ends.

use crate::error::{MpcError, check_value};

/// Rounds an input to values of a finite set so that the integral of what was cut off stays small:
///
/// ```text
/// e_k = e_{k−1} + h_k (u_k − v_k)        v_k: the value closest to u_k + e_{k−1}/h_k
/// ```
///
/// With two values this is the sum-up rounding of Sager (2005) and of Sager, Bock, and Diehl (2012). Inputs between the smallest and the
/// largest value, over intervals of the same length h, give |e_k| ≤ h·g/2 with the largest gap g between neighboring values.
///
/// ```
/// use bracketry_mpc::controller::SumUpRounding;
/// let mut rounding = SumUpRounding::new(&[0.0, 1.0]).unwrap();
/// let rounded: Vec<f64> = (0..5).map(|_| rounding.round(0.4, 0.1)).collect();
/// assert_eq!(rounded, [0.0, 1.0, 0.0, 1.0, 0.0]);
/// assert!(rounding.error().abs() <= 0.05 + 1e-12);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SumUpRounding {
    values: Vec<f64>,
    error: f64,
}

impl SumUpRounding {
    /// Rounding to some values, without an error so far.
    ///
    /// # Errors
    /// [`MpcError::Value`] if there are no values, or one of them is not finite.
    pub fn new(values: &[f64]) -> Result<Self, MpcError> {
        check_value(!values.is_empty(), "the number of values", 0.0, "give one or more values")?;
        for &value in values {
            check_value(value.is_finite(), "a value of an input", value, "give finite numbers")?;
        }
        let mut values = values.to_vec();
        values.sort_by(f64::total_cmp);
        Ok(Self { values, error: 0.0 })
    }

    /// The value in place of `relaxed` over an interval of `h` seconds; the error is carried on.
    pub fn round(&mut self, relaxed: f64, h: f64) -> f64 {
        self.round_within(relaxed, h, (f64::NEG_INFINITY, f64::INFINITY))
    }

    /// As [`SumUpRounding::round`], with the values within `bounds` alone, where there are any.
    pub(crate) fn round_within(&mut self, relaxed: f64, h: f64, bounds: (f64, f64)) -> f64 {
        let wanted = relaxed + self.error / h;
        let closer = |a: f64, b: f64| if (b - wanted).abs() < (a - wanted).abs() { b } else { a };
        let allowed = self.values.iter().copied().filter(|v| bounds.0 <= *v && *v <= bounds.1).reduce(closer);
        let value = allowed.or(self.values.iter().copied().reduce(closer)).unwrap_or(relaxed);
        self.error += h * (relaxed - value);
        value
    }

    /// ∫ (relaxed − rounded) dt so far, in the unit of the input times seconds.
    pub fn error(&self) -> f64 {
        self.error
    }

    /// The values, in order.
    pub fn values(&self) -> &[f64] {
        &self.values
    }
}
