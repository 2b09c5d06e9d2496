//! Units that tables state: products, powers, prefixes, and scales with an offset.

use bracketry_system::Unit;

fn factor(from: &str, to: &str) -> Option<(f64, f64)> {
    Unit::parse(from)?.to(&Unit::parse(to)?)
}

#[test]
fn units_are_converted_by_their_definition() {
    for (from, to, expected) in [
        ("mm", "m", 1e-3),
        ("kN", "N", 1e3),
        ("km/h", "m/s", 1.0 / 3.6),
        ("deg/s", "rad/s", std::f64::consts::PI / 180.0),
        ("rpm", "rad/s", std::f64::consts::PI / 30.0),
        ("N mm", "N m", 1e-3),
        ("m/s²", "m/s^2", 1.0),
        ("m/s2", "m s^-2", 1.0),
        ("kg*m/s^2", "N", 1.0),
        ("V A", "W", 1.0),
        ("L/min", "m^3/s", 1e-3 / 60.0),
        ("mol/L", "mol/m³", 1e3),
        ("L/(mol h)", "m^3/mol/s", 1e-3 / 3600.0),
        ("µm", "um", 1.0),
        ("%", "1", 0.01),
        ("Hz", "1/min", 60.0),
    ] {
        let (found, offset) = factor(from, to).unwrap_or_else(|| panic!("{from} to {to}"));
        assert!((found / expected - 1.0).abs() < 1e-12 && offset == 0.0, "{from} to {to}: {found}");
        let (back, _) = factor(to, from).unwrap();
        assert!((back * found - 1.0).abs() < 1e-12, "{to} to {from}");
    }
}

#[test]
fn temperatures_have_offsets() {
    for (from, to, at, expected) in [
        ("degC", "K", 20.0, 293.15),
        ("°F", "°C", 212.0, 100.0),
        ("K", "degF", 273.15, 32.0),
        ("degC", "degC", 7.0, 7.0),
    ] {
        let (factor, offset) = factor(from, to).unwrap();
        assert!((at * factor + offset - expected).abs() < 1e-9, "{from} to {to}");
    }
}

#[test]
fn what_is_no_unit_or_may_mean_two_is_none() {
    for text in ["", "left", "raw", "m/", "J/kg K", "s^", "degC/s", "x", "12", "m^0", "n/a", "nan"] {
        assert!(Unit::parse(text).is_none(), "{text}");
    }
    assert_eq!(factor("m", "s"), None);
    assert_eq!(factor("rad/s", "Hz"), None);
}
