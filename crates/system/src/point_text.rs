//! A point of interest given by name, as on a command line.

use crate::constants::Constants;
use crate::{Point, System};
use bracketry_symbolic::{ParseError, Symbol, closest_name};

/// A text that does not give a point.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PointError {
    /// An entry without `=`.
    #[error("`{entry}` has no value: write NAME=VALUE, separated by commas")]
    NoValue {
        /// The entry.
        entry: String,
    },
    /// Neither a state nor an input.
    #[error("`{name}` is neither a state nor an input of the model: {remedy}")]
    UnknownName {
        /// The name as given.
        name: String,
        /// What to write instead.
        remedy: String,
    },
    /// A name that was given before.
    #[error("`{name}` is given twice: remove one of the values")]
    Twice {
        /// The name.
        name: String,
    },
    /// A value that is not a constant.
    #[error("the value of `{name}`")]
    Value {
        /// The state or input.
        name: String,
        /// What is wrong with its value.
        source: ParseError,
    },
    /// A value that is no finite number.
    #[error("the value of `{name}`, `{text}`, is not a finite real number: give one")]
    NotFinite {
        /// The state or input.
        name: String,
        /// The value as written.
        text: String,
    },
}

/// Reads a point such as `x=0.1, th=pi/2`. States and inputs that are not named are 0, as in the `[point]` of a model file.
///
/// ```
/// use bracketry_system::{System, point};
/// let mut s = System::parse("m", "states = ['x', 'th']\ninputs = ['u']\ndynamics = { x = 'cos(th)', th = 'u' }").unwrap();
/// let th = point(&mut s, "th=pi/2").unwrap();
/// s.point = Some(th);
/// assert_eq!(s.point_values().unwrap().0[1], std::f64::consts::FRAC_PI_2);
/// ```
///
/// # Errors
/// [`PointError`] with what to write instead.
pub fn point(system: &mut System, text: &str) -> Result<Point, PointError> {
    let zero = system.pool.int(0);
    let mut point = Point { states: vec![zero; system.states.len()], inputs: vec![zero; system.inputs.len()] };
    let mut given: Vec<&str> = Vec::new();
    for entry in entries(text) {
        let Some((name, value)) = entry.split_once('=') else {
            return Err(PointError::NoValue { entry: entry.trim().to_owned() });
        };
        let name = name.trim();
        if given.contains(&name) {
            return Err(PointError::Twice { name: name.to_owned() });
        }
        given.push(name);
        let at = |list: &[Symbol]| list.iter().position(|&s| system.pool.name(s) == name);
        let place = match (at(&system.states), at(&system.inputs)) {
            (Some(i), _) => &mut point.states[i],
            (None, Some(i)) => &mut point.inputs[i],
            (None, None) => return Err(unknown(system, name)),
        };
        *place = system.pool.parse_with(value, &mut Constants).map_err(|e| {
            let remedy = if e.message.starts_with("unknown name") {
                "a point contains constants such as 0.3, pi/2, or sqrt(2)".to_owned()
            } else {
                e.remedy.clone()
            };
            PointError::Value { name: name.to_owned(), source: ParseError { remedy, ..e } }
        })?;
        let written = *place;
        if !system.value(written).is_some_and(f64::is_finite) {
            return Err(PointError::NotFinite { name: name.to_owned(), text: value.trim().to_owned() });
        }
    }
    Ok(point)
}

fn unknown(system: &System, name: &str) -> PointError {
    let known: Vec<&str> = system.states.iter().chain(&system.inputs).map(|&s| system.symbol_name(s)).collect();
    let remedy = match closest_name(name, known.iter().copied()) {
        Some(near) => format!("did you mean `{near}`?"),
        None => format!("it has {}", known.join(", ")),
    };
    PointError::UnknownName { name: name.to_owned(), remedy }
}

/// The parts between commas that stand in no parentheses.
fn entries(text: &str) -> Vec<&str> {
    let mut parts = Vec::new();
    let (mut depth, mut start) = (0i32, 0);
    for (i, c) in text.char_indices() {
        match c {
            '(' => depth += 1,
            ')' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(&text[start..i]);
                start = i + 1;
            }
            _ => {}
        }
    }
    parts.push(&text[start..]);
    parts
}
