//! Numbers that are written with a unit, which no number of a problem file has.

/// Units and what a number with them is in the unit that a problem file has.
const UNITS: [(&str, f64, &str); 11] = [
    ("s", 1.0, "seconds"),
    ("sec", 1.0, "seconds"),
    ("ms", 1e-3, "seconds"),
    ("us", 1e-6, "seconds"),
    ("µs", 1e-6, "seconds"),
    ("μs", 1e-6, "seconds"),
    ("ns", 1e-9, "seconds"),
    ("min", 60.0, "seconds"),
    ("h", 3600.0, "seconds"),
    ("deg", std::f64::consts::PI / 180.0, "radians"),
    ("°", std::f64::consts::PI / 180.0, "radians"),
];

/// What to write in place of a number with a unit of time or angle; none where the text is something else.
pub(super) fn without_unit(text: &str) -> Option<String> {
    let text = text.trim();
    let end = text.trim_end_matches(|c: char| c.is_alphabetic() || c == '°').len();
    let (number, unit) = (text[..end].trim().parse::<f64>().ok()?, &text[end..]);
    let rate = match unit {
        "Hz" => Some(number),
        "kHz" => Some(1e3 * number),
        _ => None,
    };
    if let Some(rate) = rate.filter(|rate| *rate != 0.0) {
        return Some(format!("give seconds: {}", short(1.0 / rate)));
    }
    let (_, factor, name) = UNITS.iter().find(|u| u.0 == unit)?;
    Some(format!("give {name}: {}", short(number * factor)))
}

/// A number without the rounding of the conversion.
fn short(v: f64) -> f64 {
    format!("{v:.12e}").parse().unwrap_or(v)
}

#[cfg(test)]
mod tests {
    use super::without_unit;

    #[test]
    fn units_of_time_and_angle_are_converted_and_expressions_left_alone() {
        for (text, says) in [
            ("50 ms", "give seconds: 0.05"),
            ("50ms", "give seconds: 0.05"),
            ("7 us", "give seconds: 0.000007"),
            ("2 min", "give seconds: 120"),
            ("100 Hz", "give seconds: 0.01"),
            ("1e-1 s", "give seconds: 0.1"),
            ("180 deg", "give radians: 3.14159265359"),
        ] {
            assert_eq!(without_unit(text).as_deref(), Some(says));
        }
        for text in ["pi/20", "m", "2*m", "0.05", "3 m", "1/h", ""] {
            assert_eq!(without_unit(text), None, "{text}");
        }
    }
}
