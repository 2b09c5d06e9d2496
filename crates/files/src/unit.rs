//! Units of measurement, as far as tables and models state them: products of powers of common units with prefixes.

/// Base dimensions: length, mass, time, current, temperature, amount, angle.
type Dimensions = [i32; 7];

/// A unit that is understood: `value · factor + offset` in coherent SI units (m, kg, s, A, K, mol, rad).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    dimensions: Dimensions,
    factor: f64,
    offset: f64,
}

const TURN: f64 = std::f64::consts::TAU;
const FAHRENHEIT: f64 = 5.0 / 9.0;

/// Units without prefixes: name, dimensions, factor, offset.
const PLAIN: [(&str, Dimensions, f64, f64); 26] = [
    ("1", [0; 7], 1.0, 0.0),
    ("%", [0; 7], 0.01, 0.0),
    ("min", TIME, 60.0, 0.0),
    ("h", TIME, 3600.0, 0.0),
    ("hr", TIME, 3600.0, 0.0),
    ("d", TIME, 86_400.0, 0.0),
    ("sec", TIME, 1.0, 0.0),
    ("seconds", TIME, 1.0, 0.0),
    ("deg", ANGLE, TURN / 360.0, 0.0),
    ("degrees", ANGLE, TURN / 360.0, 0.0),
    ("°", ANGLE, TURN / 360.0, 0.0),
    ("turn", ANGLE, TURN, 0.0),
    ("rev", ANGLE, TURN, 0.0),
    ("rpm", [0, 0, -1, 0, 0, 0, 1], TURN / 60.0, 0.0),
    ("degC", TEMPERATURE, 1.0, 273.15),
    ("°C", TEMPERATURE, 1.0, 273.15),
    ("℃", TEMPERATURE, 1.0, 273.15),
    ("degF", TEMPERATURE, FAHRENHEIT, 273.15 - 32.0 * FAHRENHEIT),
    ("°F", TEMPERATURE, FAHRENHEIT, 273.15 - 32.0 * FAHRENHEIT),
    ("in", LENGTH, 0.0254, 0.0),
    ("inch", LENGTH, 0.0254, 0.0),
    ("ft", LENGTH, 0.3048, 0.0),
    ("t", MASS, 1000.0, 0.0),
    ("lb", MASS, 0.453_592_37, 0.0),
    ("lbf", FORCE, 4.448_221_615_260_5, 0.0),
    ("a", TIME, 365.25 * 86_400.0, 0.0),
];
const LENGTH: Dimensions = [1, 0, 0, 0, 0, 0, 0];
const MASS: Dimensions = [0, 1, 0, 0, 0, 0, 0];
const TIME: Dimensions = [0, 0, 1, 0, 0, 0, 0];
const TEMPERATURE: Dimensions = [0, 0, 0, 0, 1, 0, 0];
const ANGLE: Dimensions = [0, 0, 0, 0, 0, 0, 1];
const FORCE: Dimensions = [1, 1, -2, 0, 0, 0, 0];

/// Units that may have a prefix.
const PREFIXED: [(&str, Dimensions, f64); 18] = [
    ("m", LENGTH, 1.0),
    ("g", MASS, 1e-3),
    ("s", TIME, 1.0),
    ("A", [0, 0, 0, 1, 0, 0, 0], 1.0),
    ("K", TEMPERATURE, 1.0),
    ("mol", [0, 0, 0, 0, 0, 1, 0], 1.0),
    ("rad", ANGLE, 1.0),
    ("N", FORCE, 1.0),
    ("Pa", [-1, 1, -2, 0, 0, 0, 0], 1.0),
    ("bar", [-1, 1, -2, 0, 0, 0, 0], 1e5),
    ("J", [2, 1, -2, 0, 0, 0, 0], 1.0),
    ("W", [2, 1, -3, 0, 0, 0, 0], 1.0),
    ("V", [2, 1, -3, -1, 0, 0, 0], 1.0),
    ("Ohm", [2, 1, -3, -2, 0, 0, 0], 1.0),
    ("Hz", [0, 0, -1, 0, 0, 0, 0], 1.0),
    ("L", [3, 0, 0, 0, 0, 0, 0], 1e-3),
    ("l", [3, 0, 0, 0, 0, 0, 0], 1e-3),
    ("M", [-3, 0, 0, 0, 0, 1, 0], 1e3),
];
const PREFIXES: [(&str, f64); 10] = [
    ("n", 1e-9),
    ("u", 1e-6),
    ("µ", 1e-6),
    ("μ", 1e-6),
    ("m", 1e-3),
    ("c", 1e-2),
    ("d", 1e-1),
    ("k", 1e3),
    ("M", 1e6),
    ("G", 1e9),
];

impl Unit {
    /// Reads a unit such as `mm`, `rad/s`, `m/s²`, `N m`, `kg*m^2`, or `L/(mol h)`; none for text that is no unit or may mean two, such as
    /// `J/kg K`.
    pub fn parse(text: &str) -> Option<Unit> {
        let text = text.trim();
        let mut parts = text.split('/');
        let mut unit = product(parts.next()?)?;
        for part in parts {
            let part = part.trim();
            let inner = part.strip_prefix('(').and_then(|p| p.strip_suffix(')'));
            let divisor = product(inner.unwrap_or(part))?;
            if inner.is_none() && factors(part).count() > 1 {
                return None;
            }
            unit = unit.times(divisor, -1)?;
        }
        Some(unit)
    }

    /// Whether it is a product of m, kg, s, A, K, mol, and rad without a factor.
    pub fn is_coherent(&self) -> bool {
        self.factor == 1.0 && self.offset == 0.0
    }

    /// Factor and offset that take values in this unit to values in another one of the same dimensions; none for others.
    pub fn to(&self, other: &Unit) -> Option<(f64, f64)> {
        (self.dimensions == other.dimensions)
            .then(|| (self.factor / other.factor, (self.offset - other.offset) / other.factor))
    }

    /// The product with a power of another unit; none where a scale with an offset is multiplied.
    fn times(self, other: Unit, power: i32) -> Option<Unit> {
        if self.offset != 0.0 || other.offset != 0.0 {
            return None;
        }
        let mut dimensions = self.dimensions;
        dimensions.iter_mut().zip(other.dimensions).for_each(|(d, o)| *d += power * o);
        Some(Unit { dimensions, factor: self.factor * other.factor.powi(power), offset: 0.0 })
    }
}

fn factors(text: &str) -> impl Iterator<Item = &str> {
    text.split(['*', '·', '⋅', ' ', '\u{a0}']).filter(|f| !f.is_empty())
}

fn product(text: &str) -> Option<Unit> {
    let mut parts = factors(text).map(power);
    let first = parts.next()??;
    parts.try_fold(first, |unit, next| unit.times(next?, 1))
}

/// A unit with its exponent: `s`, `s2`, `s^2`, `s²`, `s^-1`, `s⁻¹`.
fn power(text: &str) -> Option<Unit> {
    const RAISED: &str = "⁰¹²³⁴⁵⁶⁷⁸⁹";
    let plain: String = text
        .chars()
        .map(|c| match RAISED.chars().position(|r| r == c) {
            Some(digit) => char::from(b'0' + digit as u8),
            None if c == '⁻' || c == '−' => '-',
            None => c,
        })
        .collect();
    if let Some(unit) = named(&plain) {
        return Some(unit);
    }
    let end = plain.trim_end_matches(|c: char| c.is_ascii_digit()).len();
    let (name, exponent) = plain.split_at(end);
    let (name, sign) = name.strip_suffix('-').map_or((name, 1), |name| (name, -1));
    let exponent: i32 = exponent.parse().ok().filter(|e| (1..10).contains(e))?;
    let one = Unit { dimensions: [0; 7], factor: 1.0, offset: 0.0 };
    one.times(named(name.strip_suffix('^').unwrap_or(name))?, sign * exponent)
}

fn named(name: &str) -> Option<Unit> {
    if let Some(&(_, dimensions, factor, offset)) = PLAIN.iter().find(|p| p.0 == name) {
        return Some(Unit { dimensions, factor, offset });
    }
    let of = |name: &str, by: f64| {
        let &(_, dimensions, factor) = PREFIXED.iter().find(|p| p.0 == name)?;
        Some(Unit { dimensions, factor: by * factor, offset: 0.0 })
    };
    of(name, 1.0).or_else(|| PREFIXES.iter().find_map(|&(prefix, by)| of(name.strip_prefix(prefix)?, by)))
}
