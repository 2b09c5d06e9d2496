//! JSON of a motion from one state to another.

use bracketry_sim::Hold;
use bracketry_steer::{Attempt, Plan, SteerNote, Steering};
use serde_json::{Map, Value, json};

use super::text::{method, note, reason};

fn named(names: &[String], values: &[f64]) -> Map<String, Value> {
    names.iter().zip(values).map(|(n, v)| (n.clone(), json!(v))).collect()
}

/// A motion from one state to another: status, end error, method with its data, inputs as columns, attempts.
pub fn steering_json(s: &Steering) -> Value {
    let (states, inputs) = (s.system.state_names(), s.system.input_names());
    let mut out = json!({
        "model": s.system.name,
        "status": s.status,
        "from": named(&states, &s.from),
        "to": named(&states, &s.to),
        "end_error": s.end_error.is_finite().then_some(s.end_error),
        "corrections": s.corrections,
        "notes": s.notes.iter().map(noted).collect::<Vec<_>>(),
        "attempts": s.attempts.iter().map(attempted).collect::<Vec<_>>(),
    });
    let Some(object) = out.as_object_mut() else { return out };
    if let Some(plan) = &s.plan {
        object.insert("method".into(), json!(plan.method()));
        object.insert("source".into(), json!(method(plan.method())));
        object.insert("plan".into(), planned(plan, &states));
    }
    if let Some(signals) = &s.signals {
        let column = |j: usize| signals.values.iter().map(|row| row[j]).collect::<Vec<f64>>();
        let columns: Map<String, Value> =
            inputs.iter().enumerate().map(|(j, name)| (name.clone(), json!(column(j)))).collect();
        object.insert("duration".into(), json!(signals.duration()));
        let hold = match signals.hold {
            Hold::Previous => "previous",
            Hold::Linear => "linear",
        };
        object.insert("inputs".into(), json!({"t": signals.times, "hold": hold, "columns": columns}));
    }
    if let Some(run) = &s.motion {
        object.insert("end".into(), Value::Object(named(&states, run.trajectory.final_state())));
    }
    out
}

fn planned(plan: &Plan, states: &[String]) -> Value {
    match plan {
        Plan::Chained { coordinates, way_points } => {
            let points: Vec<_> = way_points.iter().map(|x| named(states, x)).collect();
            json!({"coordinates": coordinates, "way_points": points})
        }
        Plan::Nilpotent { degree, is_nilpotent, rounds, pieces } => {
            json!({"degree": degree, "nilpotent": is_nilpotent, "rounds": rounds, "pieces": pieces})
        }
        Plan::Flat { outputs, integrators, degrees } => {
            json!({"flat_outputs": outputs, "integrators": integrators, "degrees": degrees})
        }
        Plan::Loops { loops, shapes } => json!({"loops": loops, "shapes": shapes}),
        Plan::Shooting { harmonics, starts } => json!({"harmonics": harmonics, "starts": starts}),
    }
}

/// The note as data, with its text.
fn noted(n: &SteerNote) -> Value {
    let mut value = json!(n);
    if let Some(entry) = value.as_object_mut() {
        entry.insert("text".into(), Value::String(note(n)));
    }
    value
}

fn attempted(a: &Attempt) -> Value {
    json!({"method": a.method, "reason": reason(&a.reason)})
}
