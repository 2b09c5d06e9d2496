//! JSON of an experiment.

use bracketry_experiment::{Design, Discrimination, IDENTIFIED, Identification, RESOLVED};
use bracketry_sim::Hold;
use serde_json::{Map, Value, json};

use super::files::{discrimination_table, identification_table};

/// The columns of a table by name.
fn columns((header, rows): (Vec<String>, Vec<Vec<f64>>)) -> Map<String, Value> {
    let column = |(k, name): (usize, String)| (name, json!(rows.iter().map(|r| r[k]).collect::<Vec<f64>>()));
    header.into_iter().enumerate().map(column).collect()
}

fn common(design: &Design) -> Map<String, Value> {
    let hold = match design.signals.hold {
        Hold::Previous => "previous",
        Hold::Linear => "linear",
    };
    let limits: Map<String, Value> = design.limits.iter().map(|l| (l.name.clone(), json!([l.low, l.high]))).collect();
    let mut out = Map::new();
    out.insert("duration".into(), json!(design.duration()));
    out.insert("sample".into(), json!(design.sample));
    out.insert("inputs".into(), json!(design.signals.names));
    out.insert("hold".into(), json!(hold));
    out.insert("limits".into(), Value::Object(limits));
    out.insert("noise".into(), json!(design.noise));
    out.insert("starts".into(), json!(design.starts));
    out.insert("time_limit_reached".into(), json!(design.is_cut));
    out
}

/// An experiment that tells two explanations apart.
pub fn discrimination_json(d: &Discrimination) -> Value {
    let mut out = common(&d.design);
    let separations: Vec<Value> = d
        .separations
        .iter()
        .map(|s| {
            let named = |list: &[(String, f64)]| list.iter().map(|(n, v)| (n.clone(), json!(v))).collect::<Map<_, _>>();
            json!({"truth": s.truth, "refitted": s.refitted, "chi_square": s.chi_square, "deviations": s.deviations,
                "chi_square_as_given": s.as_given, "parameters": named(&s.parameters), "start": named(&s.start)})
        })
        .collect();
    out.insert("kind".into(), json!("tell"));
    out.insert("explanations".into(), json!(d.names));
    out.insert("resolved".into(), json!(d.resolves()));
    out.insert("deviations".into(), json!(d.weaker().deviations));
    out.insert("threshold".into(), json!(RESOLVED));
    out.insert("clear".into(), json!(d.is_clear()));
    out.insert("deviations_before".into(), json!(d.before));
    out.insert("separations".into(), json!(separations));
    out.insert("rounds".into(), json!(d.rounds));
    out.insert("fixed".into(), json!(d.fixed));
    out.insert("columns".into(), Value::Object(columns(discrimination_table(d))));
    Value::Object(out)
}

/// An experiment that identifies parameters.
pub fn identification_json(d: &Identification) -> Value {
    let mut out = common(&d.design);
    out.insert("kind".into(), json!("parameters"));
    out.insert("model".into(), json!(d.model.name));
    out.insert("identified".into(), json!(d.is_identified()));
    out.insert("threshold".into(), json!(IDENTIFIED));
    out.insert("parameters".into(), json!(d.parameters));
    out.insert("correlation".into(), json!(d.correlation));
    out.insert("shorter".into(), json!(d.shorter));
    out.insert("fixed".into(), json!(d.fixed));
    out.insert("columns".into(), Value::Object(columns(identification_table(d))));
    Value::Object(out)
}
