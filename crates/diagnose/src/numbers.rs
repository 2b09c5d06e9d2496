//! Numbers for a reader.

/// `value` with so many significant digits.
pub fn significant(value: f64, digits: i32) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    if !value.is_finite() {
        return value.to_string();
    }
    let exponent = value.abs().log10().floor() as i32;
    if (-4..6).contains(&exponent) {
        let decimals = (digits - 1 - exponent).max(0) as usize;
        format!("{value:.decimals$}")
    } else {
        let decimals = (digits - 1).max(0) as usize;
        format!("{value:.decimals$e}")
    }
}

/// `value` with as many digits as its standard deviation `std` makes worthwhile: two of `std`.
pub fn measured(value: f64, std: f64) -> String {
    if !(std > 0.0 && std.is_finite()) || value == 0.0 {
        return significant(value, 4);
    }
    let digits = (value.abs().log10().floor() - std.log10().floor()) as i32 + 2;
    significant(value, digits.clamp(2, 9))
}

/// Below this the number of a probability means nothing any more.
const LEAST_PROBABILITY: f64 = 1e-12;

/// `= p`, or a bound where the number means nothing any more.
pub fn probability(p: f64) -> String {
    if p < LEAST_PROBABILITY { p_value(p) } else { format!("= {}", p_value(p)) }
}

/// `p`, or a bound where the number means nothing any more.
pub fn p_value(p: f64) -> String {
    if p < LEAST_PROBABILITY { format!("< {LEAST_PROBABILITY:e}") } else { significant(p, 2) }
}
