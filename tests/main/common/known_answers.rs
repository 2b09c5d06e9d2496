//! Answers known from the literature against what an analysis says in JSON, one comparison per key.

use bracketry_symbolic::{Bindings, Expr, Pool};
use serde_json::Value;

use super::case_file::{model_file, original_model_file};

/// Analyses a model file: its text, brackets asked for by name, functions of which it is asked whether the outputs
/// determine them. Gives the report as JSON.
pub(crate) type Analyze<'a> = dyn FnMut(&str, &[String], &[String]) -> Value + 'a;

/// The cases of the shared folder; none, with a line that says so, where it is absent. `root` is the workspace.
#[allow(clippy::print_stderr)]
pub(crate) fn cases(root: &str) -> Vec<Value> {
    let shared = std::env::var("BRACKETRY_SHARED").unwrap_or_else(|_| "../shared".into());
    let path = std::path::Path::new(root).join(shared).join("cases/systems.json");
    let Ok(text) = std::fs::read_to_string(&path) else {
        eprintln!("ignored: {} is absent", path.display());
        return Vec::new();
    };
    let all: Value = serde_json::from_str(&text).unwrap();
    all["cases"].as_array().unwrap().clone()
}

/// Everything in which the analysis of a case differs from what is known, a line each.
///
/// Where small-time local controllability is known although Sussmann's condition is obstructed, the tests are not
/// expected to find it: "inconclusive" is then right as well, "no" is not.
pub(crate) fn differences(case: &Value, analyze: &mut Analyze<'_>) -> Vec<String> {
    let expected = case["expected"].as_object().unwrap();
    let (brackets, determined) = (keys(&case["expected"]["bracket"]), keys(&case["expected"]["locally_identifiable"]));
    let found = analyze(&model_file(case, &case["x0"], &[]).unwrap(), &brackets, &determined);
    let mut differences = Vec::new();
    for (key, value) in expected {
        let (is, should) = compare(case, key, value, &found, analyze);
        if is != should {
            differences.push(format!("{}: {key}: {is} instead of {should}", case["name"]));
        }
    }
    differences
}

/// What was found and what is known, equal if they agree.
fn compare(case: &Value, key: &str, value: &Value, found: &Value, analyze: &mut Analyze<'_>) -> (Value, Value) {
    let mode = &found["modes"][0];
    let point = &found["at_point"];
    let should = value.clone();
    let is = match key {
        "growth" => mode["growth"].clone(),
        "accessibility_rank" => mode["accessible_dimension"].clone(),
        "strong_accessibility_rank" => mode["strongly_accessible_dimension"].clone(),
        "accessibility_rank_at_x0" => point["accessible_dimension"].clone(),
        "strong_accessibility_rank_at_x0" => point["strongly_accessible_dimension"].clone(),
        "growth_singular" => at_singular_point(case, analyze)["growth"].clone(),
        // The point that other keys speak of.
        "singular_point" => should.clone(),
        "degree_singular" => degree(&at_singular_point(case, analyze), count(case, "states")),
        "degree_of_nonholonomy" => degree(point, count(case, "states")),
        "nilpotent_length" => found["lie_algebra"]["nilpotent_length"].clone(),
        "bracket" => return brackets(value, &found["brackets"]),
        "involutive" | "static_feedback_linearizable" | "relative_degree" | "decoupling_rank" => found[key].clone(),
        "decoupling_det" => return functions(value, &found["decoupling_determinant"]),
        "singular_set" => return zero_sets(case, value, &found["singular_set"]),
        "Lg_Lf2_h" => return functions(value, &found["decoupling_matrix"][0][0]),
        "relative_degree_defined_at_origin" => point["relative_degree_defined"].clone(),
        "zero_dynamics" => return zero_dynamics(value, &found["zero_dynamics"]),
        "fl_dims" => found["feedback_linearization"]["dims"].clone(),
        "flat_outputs" => return flat(case, &found["flatness"]["flat_outputs"], analyze),
        "linearization_controllable" => {
            (point["linear_controllability_rank"].as_u64() == Some(count(case, "states"))).into()
        }
        "brockett_condition" => point["brockett_condition"].clone(),
        "stlc" => {
            let verdict = point["stlc"]["verdict"].clone();
            let beyond_the_tests = case["expected"]["gsc"] == "obstructed" && value == "yes";
            if beyond_the_tests && verdict == "inconclusive" { should.clone() } else { verdict }
        }
        "gsc" => {
            let should = if value == "STLC" { "holds".into() } else { should };
            return (point["stlc"]["general_condition"].clone(), should);
        }
        "gsc_weights" => point["stlc"]["weights"].clone(),
        "obstruction_degree" => {
            let degrees = &point["stlc"]["obstruction"]["degrees"];
            Value::from(vec![degrees["f"].clone(), degrees["g1"].clone()])
        }
        "observability_rank" => found["observability"]["rank"].clone(),
        "unobservable" => return unobservable(value, &found["observability"]["unobservable_directions"]),
        "locally_identifiable" => found["observability"]["determined"].clone(),
        "oic_rank" => found["observability"]["rank_with_parameters"].clone(),
        "dim" => (count(case, "states") + count(case, "params")).into(),
        "original" => return original(case, value, found, analyze),
        _ => return ("no comparison is written for this key".into(), should),
    };
    (is, should)
}

fn keys(table: &Value) -> Vec<String> {
    table.as_object().map(|t| t.keys().cloned().collect()).unwrap_or_default()
}

fn count(case: &Value, key: &str) -> u64 {
    case[key].as_array().unwrap().len() as u64
}

fn at_singular_point(case: &Value, analyze: &mut Analyze<'_>) -> Value {
    let text = model_file(case, &case["expected"]["singular_point"], &[]).unwrap();
    analyze(&text, &[], &[])["at_point"].clone()
}

/// Length of brackets at which the dimension at the point is full.
fn degree(point: &Value, states: u64) -> Value {
    let growth = point["growth"].as_array().unwrap();
    growth.iter().position(|d| d.as_u64() == Some(states)).map(|k| k + 1).into()
}

fn parsed(pool: &mut Pool, text: &Value) -> Option<Expr> {
    pool.parse(text.as_str()?).ok()
}

fn is_zero(pool: &mut Pool, e: Expr) -> bool {
    pool.zero_test(e, &Bindings::new()).is_zero()
}

fn equal(pool: &mut Pool, a: Expr, b: Expr) -> bool {
    let difference = pool.sub(a, b);
    is_zero(pool, difference)
}

/// Equal as functions, with every parameter a free symbol.
fn same(a: &Value, b: &Value) -> bool {
    let mut pool = Pool::new();
    match (parsed(&mut pool, a), parsed(&mut pool, b)) {
        (Some(a), Some(b)) => equal(&mut pool, a, b),
        _ => false,
    }
}

fn functions(known: &Value, found: &Value) -> (Value, Value) {
    (if same(known, found) { known } else { found }.clone(), known.clone())
}

fn brackets(known: &Value, found: &Value) -> (Value, Value) {
    let agrees = |word: &String| {
        let (a, b) = (known[word].as_array(), found[word].as_array());
        let (Some(a), Some(b)) = (a, b) else { return false };
        a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same(a, b))
    };
    (if keys(known).iter().all(agrees) { known } else { found }.clone(), known.clone())
}

/// `e = 0` against `e = 0`: the quotient of both sides is constant in the states.
fn zero_sets(case: &Value, known: &Value, found: &Value) -> (Value, Value) {
    let mut pool = Pool::new();
    let mut left = |v: &Value| {
        let (left, right) = v.as_str()?.split_once('=')?;
        (right.trim() == "0").then(|| pool.parse(left).ok())?
    };
    let (Some(a), Some(b)) = (left(known), left(found)) else { return (found.clone(), known.clone()) };
    let quotient = pool.div(a, b);
    let constant = case["states"].as_array().unwrap().iter().all(|s| {
        let s = pool.symbol(s.as_str().unwrap());
        let slope = pool.diff(quotient, s);
        is_zero(&mut pool, slope)
    });
    (if constant { known } else { found }.clone(), known.clone())
}

/// `q''=e (non-minimum phase)`: q and its rate are the coordinates, q'' = e, and the phase is as said.
fn zero_dynamics(known: &Value, found: &Value) -> (Value, Value) {
    let agrees = || -> Option<bool> {
        let text = known.as_str()?;
        let (equation, phase) = text.split_once(" (")?;
        let (name, second) = equation.split_once("''=")?;
        let mut pool = Pool::new();
        let rate_of = |state: &str| -> Option<String> {
            let k = found["states"].as_array()?.iter().position(|s| s == state)?;
            Some(
                found["equations"][k]
                    .as_str()?
                    .split_once('=')
                    .map_or(found["equations"][k].as_str()?, |e| e.1)
                    .to_owned(),
            )
        };
        let rate = pool.parse(&rate_of(name)?).ok()?;
        let mut acceleration = pool.int(0);
        for s in pool.symbols_of(&[rate]) {
            let state = pool.name(s).to_owned();
            if let Some(rate_of_s) = rate_of(&state) {
                let slope = pool.diff(rate, s);
                let rate_of_s = pool.parse(&rate_of_s).ok()?;
                let term = pool.mul(slope, rate_of_s);
                acceleration = pool.add(acceleration, term);
            }
        }
        let second = pool.parse(second).ok()?;
        let phase = phase.starts_with("minimum");
        Some(equal(&mut pool, acceleration, second) && found["minimum_phase"].as_bool() == Some(phase))
    };
    (if agrees() == Some(true) { known } else { found }.clone(), known.clone())
}

/// Any flat outputs will do. With them as outputs of the model their relative degrees add up to the dimension, that of
/// the model or that with the integrators that make the outputs decouple (d'Andréa-Novel, Bastin and Campion 1992).
fn flat(case: &Value, outputs: &Value, analyze: &mut Analyze<'_>) -> (Value, Value) {
    let disagree = (outputs.clone(), Value::from("flat outputs"));
    let mut with_outputs = case.clone();
    with_outputs["h"] = outputs.clone();
    let Ok(text) = model_file(&with_outputs, &Value::Null, &[]) else { return disagree };
    let found = analyze(&text, &[], &[]);
    let extension = &found["dynamic_extension"];
    let (degrees, dimension) = if extension.is_object() {
        (&extension["relative_degree"], extension["dimension"].as_u64())
    } else if found["decoupling_rank"].as_u64() == Some(count(case, "inputs")) {
        (&found["relative_degree"], Some(count(case, "states")))
    } else {
        return disagree;
    };
    let sum = degrees.as_array().and_then(|list| list.iter().map(Value::as_u64).sum::<Option<u64>>());
    if sum.is_some() && sum == dimension { (true.into(), true.into()) } else { disagree }
}

/// Directions that the outputs do not see, by the words of the case.
fn unobservable(known: &Value, found: &Value) -> (Value, Value) {
    let fields: &[[&str; 3]] = match known.as_str().unwrap() {
        "rotation about the beacon" => &[["-y", "x", "1"]],
        other => return (format!("`{other}` stands for no direction here").into(), known.clone()),
    };
    let mut pool = Pool::new();
    let agrees = found.as_array().is_some_and(|list| {
        list.len() == fields.len()
            && list.iter().zip(fields).all(|(found, field)| {
                components(&mut pool, found["field"].as_str().unwrap_or_default(), &["x", "y", "th"])
                    .is_some_and(|direction| parallel(&mut pool, direction, field))
            })
    });
    (if agrees { known } else { found }.clone(), known.clone())
}

/// The components of a field written like `-y ∂x + x ∂y`.
fn components(pool: &mut Pool, text: &str, states: &[&str]) -> Option<Vec<Expr>> {
    let mut product = String::new();
    for c in text.chars() {
        if c == '∂' {
            let coefficient = product.trim_end().ends_with(|c: char| c.is_alphanumeric() || c == ')');
            product.push_str(if coefficient { "*D_" } else { "D_" });
        } else {
            product.push(c);
        }
    }
    let sum = pool.parse(&product).ok()?;
    let component = |s: &&str| {
        let direction = pool.symbol(&format!("D_{s}"));
        pool.diff(sum, direction)
    };
    Some(states.iter().map(component).collect())
}

/// Not zero, and a multiple of `field` by a function.
fn parallel(pool: &mut Pool, direction: Vec<Expr>, field: &[&str]) -> bool {
    let field: Vec<Expr> = field.iter().map(|c| pool.parse(c).unwrap()).collect();
    let mut rank = |rows: &[Vec<Expr>]| pool.rank(rows, &Bindings::new()).unwrap().rank;
    rank(std::slice::from_ref(&direction)) == 1 && rank(&[direction, field]) == 1
}

/// The system before it was made affine: the way that is found and what its inputs reach.
fn original(case: &Value, known: &Value, affine: &Value, analyze: &mut Analyze<'_>) -> (Value, Value) {
    let found = analyze(&original_model_file(case, &[]).unwrap(), &[], &[]);
    let way = &found["affinization"];
    let text = known["method"].as_str().unwrap();
    let named = if text.starts_with("augment") {
        way["method"] == "input_augmentation" && way["integrators"]["u"] == text.matches('\'').count() as u64
    } else if let Some((function, range)) =
        text.strip_prefix("input change v=").and_then(|t| t.split_once(" (static, range v"))
    {
        let new = &way["input_change"][0];
        let limit = range.trim_end_matches(')').replace(">=", "≥ ");
        way["method"] == "input_change"
            && same(&function.into(), &new["function"])
            && new["range"].as_str().is_some_and(|r| r.ends_with(&limit))
    } else {
        false
    };
    let reached = ["growth", "accessible_dimension", "strongly_accessible_dimension"]
        .iter()
        .all(|key| found["modes"][0][key] == affine["modes"][0][key]);
    (if named && reached { known } else { way }.clone(), known.clone())
}
