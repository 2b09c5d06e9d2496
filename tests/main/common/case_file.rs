//! Systems of the case format as model files.
//!
//! A case is a JSON object: `states`, `inputs` and `params` are lists of names (`params` may also be a table of
//! values), `f` has one expression per state, `g` one such list per input (none where `f` has the inputs in it),
//! `h` lists the outputs, and `x0` is the point of local statements, null for none.

use std::fmt::Write as _;

use serde_json::Value;

/// What of a case cannot be made a model file.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct BadCase(pub(crate) String);

impl std::fmt::Display for BadCase {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for BadCase {}

/// Values of parameters by name, in place of those made up.
pub(crate) type Values = [(String, String)];

/// The affine system `x' = f + Σ u_i g_i` of a case as a model file, with the point `at`: an object of expressions,
/// or anything else for no point.
///
/// # Errors
/// [`BadCase`] if an entry is missing or lists do not fit each other.
pub(crate) fn model_file(case: &Value, at: &Value, values: &Values) -> Result<String, BadCase> {
    let inputs = texts(case, "inputs")?;
    let f = texts(case, "f")?;
    let g = match &case["g"] {
        Value::Null => Vec::new(),
        Value::Array(list) => list.iter().map(|g| items(g, "g")).collect::<Result<Vec<_>, _>>()?,
        _ => return Err(BadCase("`g` must be a list of lists".to_owned())),
    };
    if !g.is_empty() && g.len() != inputs.len() {
        return Err(BadCase(format!("{} input fields for {} inputs", g.len(), inputs.len())));
    }
    if let Some(field) = g.iter().find(|field| field.len() != f.len()) {
        return Err(BadCase(format!("an input field with {} components for {} states", field.len(), f.len())));
    }
    let rates: Vec<String> = f
        .iter()
        .enumerate()
        .map(|(i, drift)| {
            let drift = (drift != "0").then(|| drift.clone());
            let terms = g.iter().zip(&inputs).filter(|(g, _)| g[i] != "0").map(|(g, u)| match g[i].as_str() {
                "1" => u.clone(),
                factor => format!("({factor})*{u}"),
            });
            let terms: Vec<String> = drift.into_iter().chain(terms).collect();
            if terms.is_empty() { "0".to_owned() } else { terms.join(" + ") }
        })
        .collect();
    written(case, &texts(case, "states")?, &inputs, &rates, &texts(case, "h")?, at, values)
}

/// The system that a case was made affine from, `expected.original`, as a model file; its input is `u`.
///
/// # Errors
/// [`BadCase`] as for [`model_file`], and if the case has no such system.
pub(crate) fn original_model_file(case: &Value, values: &Values) -> Result<String, BadCase> {
    let original = &case["expected"]["original"];
    let states = texts(original, "states")?;
    written(case, &states, &["u".to_owned()], &texts(original, "rhs")?, &[], &Value::Null, values)
}

/// A value for parameter number `i` at which nothing special happens: distinct quotients of primes.
pub(crate) fn generic_value(i: usize) -> String {
    const PRIMES: [u32; 12] = [13, 29, 17, 43, 37, 19, 53, 31, 61, 23, 47, 41];
    let (k, turn) = (i % PRIMES.len(), i / PRIMES.len());
    format!("{}.{}", 1 + turn, PRIMES[k])
}

fn written(
    case: &Value,
    states: &[String],
    inputs: &[String],
    rates: &[String],
    outputs: &[String],
    at: &Value,
    values: &Values,
) -> Result<String, BadCase> {
    if states.len() != rates.len() {
        return Err(BadCase(format!("{} equations for {} states", rates.len(), states.len())));
    }
    let name = case["name"].as_str().unwrap_or("model");
    let mut text = format!("name = {}\nstates = {}\ninputs = {}\n", quoted(name), list(states), list(inputs));
    let parameters = parameters(case, values)?;
    if !parameters.is_empty() {
        text += "\n[parameters]\n";
        for (name, value) in &parameters {
            let _ = writeln!(text, "{name} = {value}");
        }
    }
    text += "\n[dynamics]\n";
    for (state, rate) in states.iter().zip(rates) {
        let _ = writeln!(text, "{state} = {}", quoted(rate));
    }
    if !outputs.is_empty() {
        text += "\n[outputs]\n";
        let taken = |n: &String| states.contains(n) || inputs.contains(n) || parameters.iter().any(|p| p.0 == *n);
        for (k, output) in outputs.iter().enumerate() {
            let mut name = format!("h{}", k + 1);
            while taken(&name) {
                name.push('_');
            }
            let _ = writeln!(text, "{name} = {}", quoted(output));
        }
    }
    if let Value::Object(at) = at {
        text += "\n[point]\n";
        for (name, value) in at {
            let value =
                value.as_str().map_or_else(|| value.to_string(), |v| if plain(v) { v.to_owned() } else { quoted(v) });
            let _ = writeln!(text, "{name} = {value}");
        }
    }
    Ok(text)
}

/// Names and values of the parameters: those given, else those of the case, else made up.
fn parameters(case: &Value, values: &Values) -> Result<Vec<(String, String)>, BadCase> {
    let own: Vec<(String, Option<String>)> = match &case["params"] {
        Value::Null => Vec::new(),
        Value::Object(table) => table
            .iter()
            .map(|(name, value)| (name.clone(), (!value.is_null()).then(|| value.to_string().replace('"', ""))))
            .collect(),
        names => items(names, "params")?.into_iter().map(|name| (name, None)).collect(),
    };
    let given = |name: &str| values.iter().find(|v| v.0 == name).map(|v| v.1.clone());
    Ok(own
        .into_iter()
        .enumerate()
        .map(|(i, (name, value))| {
            let value = given(&name).or(value).unwrap_or_else(|| generic_value(i));
            (name, value)
        })
        .collect())
}

/// The list of texts under `key`.
fn texts(object: &Value, key: &str) -> Result<Vec<String>, BadCase> {
    match &object[key] {
        Value::Null if key != "states" => Ok(Vec::new()),
        list => items(list, key),
    }
}

fn items(list: &Value, key: &str) -> Result<Vec<String>, BadCase> {
    let bad = || BadCase(format!("`{key}` must be a list of texts"));
    let list = list.as_array().ok_or_else(bad)?;
    list.iter().map(|v| v.as_str().map(str::to_owned).ok_or_else(bad)).collect()
}

/// Whether a text is a number that TOML writes alike.
fn plain(text: &str) -> bool {
    text.parse::<i32>().is_ok_and(|v| v.to_string() == text)
}

fn quoted(text: &str) -> String {
    Value::from(text).to_string()
}

fn list(names: &[String]) -> String {
    Value::from(names.to_vec()).to_string()
}
