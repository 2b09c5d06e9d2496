//! Classes of equations with known equilibria, and with known values of parameters at which they are not defined.

use bracketry_lie::operating::{TrimOptions, TrimStatus};
use bracketry_lie::parameters::{Aspect, ParameterCase, ParameterOptions};
use bracketry_lie::{parameter_cases, trim};
use bracketry_system::System;
use serde_json::{Value, json};

use crate::hide::{Hide, irrational};
use crate::model::{Model, Question};
use crate::random::Random;

/// Functions that increase everywhere.
const INCREASING: [&str; 6] = ["(x)", "(x)^3", "exp(x)", "atan(x)", "(x + sin(x)/2)", "tanh(x)"];

/// Functions that tend to zero far away and have no zero.
const VANISHING: [&str; 7] =
    ["exp(-x)", "exp(x)", "1/(1 + x^2)", "(tanh(x) - 1)", "(atan(x) - pi/2)", "1/cosh(x)", "(sqrt(1 + x^2) - x)"];

/// F(x) = M G(x) with an invertible M, and G_i = g_i(x_i + p_i of those before) − g_i(c_i), so that the equilibrium is known and the
/// only one; or, once in three, a function in place of one G_i that only tends to zero.
pub(crate) fn equilibria(random: &mut Random) -> (Model, Hide) {
    let mut model = Model { question: Question::Equilibrium, ..Model::default() };
    let n = random.between(1, 3);
    let (mut g, mut at): (Vec<String>, Vec<f64>) = (Vec::new(), Vec::new());
    let empty = random.once_in(3).then(|| random.below(n));
    for i in 0..n {
        let state = model.state();
        let mut argument = model.name(state);
        let mut moved = 0.0;
        if i > 0 && random.once_in(2) {
            let (j, c) = (random.below(i), random.coefficient());
            argument = format!("{argument} + ({c})*{}^2/4", model.name(j));
            moved = c as f64 * at[j] * at[j] / 4.0;
        }
        let of = |f: &str, x: &str| f.replace("exp(", "E(").replace('x', &format!("({x})")).replace("E(", "exp(");
        if empty == Some(i) {
            g.push(of(random.of(&VANISHING), &argument));
            at.push(0.0);
            continue;
        }
        let text = random.of(&INCREASING);
        let (numerator, denominator) = (random.between(0, 8) as i64 - 4, random.between(1, 4));
        let c = numerator as f64 / denominator as f64;
        g.push(format!("({} - {})", of(text, &argument), of(text, &format!("{numerator}/{denominator}"))));
        at.push(c - moved);
    }
    for i in 0..n {
        // Unit lower triangular, with a factor of any size for each equation.
        let scale = random.of(&["1", "1", "1000", "1/1000", "sqrt(2)"]);
        let others: Vec<String> = (0..i).map(|j| format!(" + {}*{}", irrational(random), g[j])).collect();
        model.rate(i, format!("{scale}*({}{})", g[i], others.concat()));
    }
    if empty.is_some() {
        model.is("found", false);
    } else {
        for (i, x) in at.iter().enumerate() {
            model.near(&format!("states.{i}"), *x);
        }
    }
    (model, Hide::Coordinates)
}

/// What `trim` says; where it finds nothing, it claims nothing.
pub(crate) fn answer_of_trim(system: &System) -> Result<Value, String> {
    let found = trim(system, &TrimOptions { starts: 24, seed: 1, ..TrimOptions::default() });
    let found = found.map_err(|e| e.to_string())?;
    Ok(match found.status {
        TrimStatus::NotFound => json!({"found": false}),
        _ => json!({"found": true, "states": found.states.iter().map(|s| s.value).collect::<Vec<_>>()}),
    })
}

/// Factors of denominators and arguments of logarithms in a parameter d of their own, and the same as the report writes them.
const FACTORS: [(&str, &str); 5] =
    [("d", "d"), ("(a + d)", "a + d"), ("(d - b)", "b - d"), ("(2*c - d)", "2*c - d"), ("(a*d - 1)", "a*d - 1")];

/// Parallel lags x_i' = u − p_i x_i in other coordinates, uncontrollable just where two rates are equal; the rates are written with
/// factors f/f that cancel and with logarithms, so that the equations have no value where f vanishes.
pub(crate) fn denominators(random: &mut Random) -> (Model, Hide) {
    let mut model = Model { question: Question::Parameters, ..Model::default() };
    let u = model.input();
    model.parameters = [("a", 2), ("b", 3), ("c", 5), ("d", 7)].map(|(n, v)| (n.to_owned(), v)).to_vec();
    let mut undefined: Vec<String> = Vec::new();
    let states: Vec<usize> = (0..3).map(|_| model.state()).collect();
    // x = T z and z = T⁻¹ x with T a product of two elementary matrices.
    let (mut t, mut inverse) = ([[1_i64, 0, 0], [0, 1, 0], [0, 0, 1]], [[1_i64, 0, 0], [0, 1, 0], [0, 0, 1]]);
    for _ in 0..2 {
        let i = random.below(3);
        let (j, c) = ((i + 1 + random.below(2)) % 3, random.coefficient());
        for row in &mut t {
            row[j] += c * row[i];
        }
        let added = inverse[j];
        for (x, y) in inverse[i].iter_mut().zip(added) {
            *x -= c * y;
        }
    }
    let mut rates = Vec::new();
    for p in ["a", "b", "c"] {
        let mut rate = p.to_owned();
        for _ in 0..random.below(3) {
            let (f, shown) = random.of(&FACTORS);
            rate =
                random.of(&["{r}*{f}/{f}", "({r}*{f}^2 + {f})/{f}^2 - 1/{f}"]).replace("{f}", f).replace("{r}", &rate);
            rate = format!("({rate})");
            undefined.push(shown.to_owned());
        }
        let z: Vec<String> = (0..3).map(|k| format!("({})*s{}", inverse[rates.len()][k], k + 1)).collect();
        rates.push(format!("({u} - {rate}*({}))", z.join(" + ")));
    }
    for &i in &states {
        let terms: Vec<String> = (0..3).map(|k| format!("({})*{}", t[i][k], rates[k])).collect();
        model.rate(i, terms.join(" + "));
    }
    undefined.sort();
    undefined.dedup();
    model.set("undefined", undefined);
    model.set("uncontrollable", ["a - b", "a - c", "a - c, b - c", "b - c"].map(str::to_owned).to_vec());
    (model, Hide::Coordinates)
}

/// Where the equations have no value, and where the strong accessibility algebra has a smaller dimension.
pub(crate) fn answer_by_cases(system: &System) -> Result<Value, String> {
    let report = parameter_cases(system, &ParameterOptions::default()).map_err(|e| e.to_string())?;
    let undefined: Vec<String> = report.undefined.iter().map(ToString::to_string).collect();
    let strong = report.aspects.iter().find(|a| a.aspect == Aspect::StrongAccessibility).ok_or("no such aspect")?;
    let conditions = |c: &ParameterCase| c.conditions.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
    let cases: Vec<String> = strong.cases.iter().map(conditions).collect();
    Ok(json!({"undefined": undefined, "uncontrollable": cases}))
}
