//! Round tick positions and their labels.

/// One axis: its range, tick positions and labels.
#[derive(Debug, Clone)]
pub(crate) struct Scale {
    /// Lower end of the axis.
    pub(crate) low: f64,
    /// Upper end of the axis.
    pub(crate) high: f64,
    /// Tick positions in data coordinates with their labels.
    pub(crate) ticks: Vec<(f64, String)>,
    /// A factor that the labels leave out, such as `10⁻³`; empty for 1. [`Self::label`] says it.
    pub(crate) factor: String,
}

impl Scale {
    /// The axis from `low` to `high` with about `count` ticks; whole numbers only if `integer`.
    pub(crate) fn new(low: f64, high: f64, count: f64, integer: bool) -> Self {
        let mut step = round_step((high - low) / count.max(1.0));
        if integer {
            step = step.max(1.0).round();
        }
        let largest = low.abs().max(high.abs());
        let power = largest.log10().floor() as i32;
        let exponent = if (-3..=4).contains(&power) { 0 } else { 3 * power.div_euclid(3) };
        let unit = 10f64.powi(exponent);
        let decimals = (-(step / unit).log10() - 1e-9).ceil().clamp(0.0, 15.0) as usize;
        let first = (low / step - 1e-6).ceil();
        let ticks = (0..100)
            .map(|k| (first + f64::from(k)) * step)
            .take_while(|v| *v <= high + 1e-6 * step)
            .map(|v| (v, format_number(v / unit, decimals)))
            .collect();
        let factor = if exponent == 0 { String::new() } else { format!("10{}", superscript(exponent)) };
        Self { low, high, ticks, factor }
    }

    /// The axis' label with the factor before its unit: `x [10⁻³ m]`.
    pub(crate) fn label(&self, label: &str) -> String {
        match (self.factor.as_str(), label.rfind('[').filter(|_| label.ends_with(']'))) {
            ("", _) => label.to_owned(),
            (factor, None) => format!("{label} [{factor}]").trim_start().to_owned(),
            (factor, Some(at)) => {
                let (name, unit) = (&label[..at], &label[at + 1..label.len() - 1]);
                let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
                format!("{name}[{factor}{unit}]")
            }
        }
    }

    /// Position of `value` as a fraction of the axis.
    pub(crate) fn fraction(&self, value: f64) -> f64 {
        (value - self.low) / (self.high - self.low)
    }
}

/// The next of 1, 2, 5 × 10ⁿ that is not much below `raw`.
fn round_step(raw: f64) -> f64 {
    let power = 10f64.powf(raw.log10().floor());
    [1.0, 2.0, 5.0].into_iter().map(|m| m * power).find(|s| *s >= 0.7 * raw).unwrap_or(10.0 * power)
}

/// `value` with a true minus sign, and never a negative zero.
pub(crate) fn format_number(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(digits) if digits.chars().all(|c| matches!(c, '0' | '.')) => digits.to_owned(),
        Some(digits) => format!("\u{2212}{digits}"),
        None => text,
    }
}

/// `value` with up to three significant digits, whole numbers as they are.
pub(crate) fn three_digits(value: f64) -> String {
    let size = value.abs();
    if size != 0.0 && !(1e-3..1e5).contains(&size) {
        return format!("{value:.1e}").replace('-', "\u{2212}");
    }
    let decimals = if value == value.round() { 0 } else { (2 - size.log10().floor() as i32).max(0) as usize };
    let text = format_number(value, decimals);
    if decimals == 0 {
        return text;
    }
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// `value` with up to three decimals, without trailing zeros.
pub(crate) fn short(value: f64) -> String {
    let text = format_number(value, 3);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn superscript(exponent: i32) -> String {
    exponent
        .to_string()
        .chars()
        .map(|c| match c {
            '-' => '⁻',
            '1' => '¹',
            '2' => '²',
            '3' => '³',
            '4' => '⁴',
            '5' => '⁵',
            '6' => '⁶',
            '7' => '⁷',
            '8' => '⁸',
            '9' => '⁹',
            _ => '⁰',
        })
        .collect()
}

/// The range of `values`, widened by `margin` of its width on both sides; a constant gets room around it, and
/// no values at all give 0 to 1.
pub(crate) fn padded_range(values: impl IntoIterator<Item = f64>, margin: f64) -> (f64, f64) {
    let (low, high) = values.into_iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    if low > high {
        return (0.0, 1.0);
    }
    let size = low.abs().max(high.abs());
    // Below this a difference is rounding noise, and an axis over it would have no distinct labels.
    if high - low <= (1e-12 * size).max(1e-280) {
        let room = if size > 1e-270 { 0.5 * size } else { 1.0 };
        return (low - room, high + room);
    }
    let room = margin * (high - low);
    (low - room, high + room)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(low: f64, high: f64) -> Vec<String> {
        let scale = Scale::new(low, high, 5.0, false);
        scale.ticks.into_iter().map(|t| t.1).collect()
    }

    #[test]
    fn ticks_are_round_and_inside() {
        assert_eq!(labels(-0.034, 0.011), ["−0.03", "−0.02", "−0.01", "0.00", "0.01"]);
        assert_eq!(labels(0.0, 5.0), ["0", "1", "2", "3", "4", "5"]);
        assert_eq!(labels(-95.0, 10.0), ["−80", "−60", "−40", "−20", "0"]);
    }

    #[test]
    fn extreme_magnitudes_get_a_factor() {
        let small = Scale::new(0.0, 2e-7, 4.0, false);
        assert_eq!(small.factor, "10⁻⁹");
        assert_eq!(small.label("missing in v′ [m/s²]"), "missing in v′ [10⁻⁹ m/s²]");
        assert_eq!(small.label("share [1]"), "share [10⁻⁹]");
        assert_eq!(small.label("phi"), "phi [10⁻⁹]");
        assert_eq!(small.ticks[1].1, "50");
        let large = Scale::new(-1e300, 1e300, 4.0, false);
        assert_eq!(large.factor, "10³⁰⁰");
        assert_eq!(Scale::new(0.0, 1.0, 4.0, false).label("x [m]"), "x [m]");
        assert!(large.ticks.iter().all(|t| t.0.is_finite()));
    }

    #[test]
    fn integer_axes_have_whole_ticks() {
        let scale = Scale::new(1.0, 3.0, 9.0, true);
        let labels: Vec<_> = scale.ticks.iter().map(|t| t.1.as_str()).collect();
        assert_eq!(labels, ["1", "2", "3"]);
    }

    #[test]
    fn constants_and_nothing_still_give_a_range() {
        assert_eq!(padded_range([], 0.1), (0.0, 1.0));
        assert_eq!(padded_range([0.0, 0.0], 0.1), (-1.0, 1.0));
        assert_eq!(padded_range([4.0], 0.1), (2.0, 6.0));
        assert_eq!(padded_range([0.0, 10.0], 0.1), (-1.0, 11.0));
    }
}
