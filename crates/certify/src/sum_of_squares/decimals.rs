//! Numbers rounded to decimal digits.

use bracketry_symbolic::Rational;

/// A number rounded to a multiple of 10^−digits.
pub(crate) fn decimal(x: f64, digits: i32) -> Rational {
    let whole = Rational::try_from((x * 10f64.powi(digits)).round()).unwrap_or(Rational::ZERO);
    whole * Rational::from(10).pow(-digits as isize)
}

/// Numbers rounded to `digits` digits behind the first one of the largest.
pub(crate) fn rounded(list: &[f64], digits: i32) -> Vec<Rational> {
    let size = list.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    if size == 0.0 || !size.is_finite() {
        return vec![Rational::ZERO; list.len()];
    }
    let place = digits - size.log10().floor() as i32;
    list.iter().map(|&x| decimal(x, place)).collect()
}
