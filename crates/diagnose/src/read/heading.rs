//! What the name of a column says beside the name of the quantity: `x [mm]`, `Time (ms)`, `t_us`.

use std::collections::BTreeMap;

use bracketry_system::{FileError, System, Unit};

use super::origin::Origin;
use super::roles::{Role, role};
use super::settings::RecordSettings;
use super::warning::Warning;

/// Units of time that stand behind an underscore.
const TIMES: [&str; 6] = ["ns", "us", "ms", "s", "min", "h"];

/// A column that means something to a model.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Heading {
    /// Its name in the model.
    pub(super) name: String,
    /// The unit that the column states.
    pub(super) unit: Option<String>,
    /// Whether it is called as the model calls it, or as the user said.
    exact: bool,
}

/// A name and the unit in brackets or parentheses behind it.
fn with_unit(column: &str) -> Option<(&str, &str)> {
    let (name, rest) = column.rsplit_once(['[', '('])?;
    let unit = rest.strip_suffix([']', ')'])?;
    Unit::parse(unit).map(|_| (name.trim(), unit.trim()))
}

/// Whether a column is called as the time is.
fn is_time(name: &str) -> bool {
    name == "t" || name.eq_ignore_ascii_case("time")
}

/// A name of the time and the unit behind an underscore.
fn time_with_unit(column: &str) -> Option<(&str, &str)> {
    column.rsplit_once('_').filter(|(name, unit)| is_time(name) && TIMES.contains(unit))
}

/// What a column means to a model, by the user's word, by its name, or by its name without the unit; none where it means nothing.
pub(super) fn heading(column: &str, system: &System, settings: &RecordSettings) -> Option<Heading> {
    let (base, unit) = with_unit(column).map_or((column, None), |(name, unit)| (name, Some(unit)));
    let stated = unit.map(str::to_owned);
    let renamed = settings.renamed(column);
    if renamed != column {
        return role(renamed, system).map(|_| Heading { name: renamed.to_owned(), unit: stated, exact: true });
    }
    // What stands in parentheses may belong to the name, as in der(X).
    if role(column, system).is_some() {
        return Some(Heading { name: column.to_owned(), unit: None, exact: true });
    }
    if unit.is_some() && role(base, system).is_some() {
        return Some(Heading { name: base.to_owned(), unit: stated, exact: false });
    }
    let unit = match time_with_unit(base) {
        Some((_, unit)) => Some(unit.to_owned()),
        None if is_time(base) => stated,
        None => return None,
    };
    Some(Heading { name: "t".to_owned(), unit, exact: false })
}

/// Columns as the model has them.
pub(super) struct Understood {
    /// By their names in the model, in its units.
    pub(super) columns: BTreeMap<String, Vec<f64>>,
    /// Names of columns that mean nothing, or that another one with exactly this name replaces.
    pub(super) ignored: Vec<String>,
    /// What was assumed.
    pub(super) said: Vec<Warning>,
}

/// A change of units: the new one, factor, and offset.
struct Conversion {
    to: String,
    factor: f64,
    offset: f64,
}

/// The columns by their names in the model and in its units. `row` has the units of a line below the header.
///
/// # Errors
/// [`FileError`] for two columns of one name, and for units that are not those of the model and cannot be converted.
pub(super) fn in_the_model(
    origin: &Origin<'_>,
    columns: BTreeMap<String, Vec<f64>>,
    row: &BTreeMap<String, String>,
    system: &System,
    settings: &RecordSettings,
) -> Result<Understood, FileError> {
    let mut chosen: BTreeMap<String, (String, Heading, Vec<f64>)> = BTreeMap::new();
    let mut left = Vec::new();
    for (column, values) in columns {
        let Some(mut heading) = heading(&column, system, settings) else {
            left.push(column);
            continue;
        };
        heading.unit = heading.unit.or_else(|| row.get(&column).cloned());
        let name = heading.name.clone();
        match chosen.get(&name).map(|(other, known, _)| (other.clone(), known.exact)) {
            Some((other, is_exact)) if is_exact == heading.exact => {
                let message =
                    format!("`{other}` and `{column}` are both called `{name}`: two columns with the same name");
                return Err(origin.whole(message, format!("give one of them another name: --rename {name}=other")));
            }
            Some((_, true)) => left.push(column),
            Some((other, false)) => {
                left.push(other);
                chosen.insert(name, (column, heading, values));
            }
            None => {
                chosen.insert(name, (column, heading, values));
            }
        }
    }
    let mut out = BTreeMap::new();
    let mut said = Vec::new();
    for (name, (column, heading, mut values)) in chosen {
        let conversion = conversion(origin, &column, &heading, system)?;
        if let Some(Conversion { factor, offset, .. }) = &conversion {
            for v in &mut values {
                *v = *v * factor + offset;
            }
        }
        let units = conversion.map(|c| (heading.unit.clone().unwrap_or_default(), c.to));
        if units.is_some() || (!heading.exact && with_unit(&column).is_none_or(|(base, _)| base != name)) {
            said.push(Warning::ReadAs { column, name: name.clone(), units });
        }
        out.insert(name, values);
    }
    Ok(Understood { columns: out, ignored: left, said })
}

/// From the unit of a column to that of the model; none where they are the same.
fn conversion(
    origin: &Origin<'_>,
    column: &str,
    heading: &Heading,
    system: &System,
) -> Result<Option<Conversion>, FileError> {
    let Some(from) = &heading.unit else { return Ok(None) };
    let quantities = &system.quantities;
    let to = match role(&heading.name, system) {
        Some(Role::Time) => Some(quantities.time_unit.symbol().to_owned()),
        Some(Role::Derivative(input, order)) => {
            quantities.unit_of_derivative(system.symbol_name(system.inputs[input]), order)
        }
        _ => quantities.unit(&heading.name).map(str::to_owned),
    };
    let name = &heading.name;
    let Some(to) = to else {
        // Without a unit in the model, it may be in any consistent units: only coherent ones are taken for them.
        if Unit::parse(from).is_some_and(|unit| unit.is_coherent()) {
            return Ok(None);
        }
        let message = format!("the column `{column}` is in {from}, and the model does not state the unit of `{name}`");
        let remedy = format!(
            "state it in the model file: [units] {name} = \"{from}\", or another unit to which the column is converted"
        );
        return Err(origin.whole(message, remedy));
    };
    if *from == to {
        return Ok(None);
    }
    match Unit::parse(from).zip(Unit::parse(&to)).and_then(|(from, to)| from.to(&to)) {
        Some((1.0, 0.0)) => Ok(None),
        Some((factor, offset)) => Ok(Some(Conversion { to, factor, offset })),
        None => {
            let message = format!("the column `{column}` is in {from}, and `{name}` of the model in {to}");
            Err(origin.whole(
                message,
                "give the column in the unit of the model, or correct the unit that one of them states",
            ))
        }
    }
}
