//! JSON of transformations.

use bracketry_lie::forms::{FormNote, FormOutcome, NormalForm, Obstacle, Transformation};
use bracketry_lie::{Function, Named};
use serde_json::{Map, Value, json};

use super::text::{next_step, note};

/// Functions by name, however long.
fn functions(list: &Named<Function>) -> Value {
    list.0.iter().map(|(name, e)| (name.clone(), Value::String(e.text()))).collect::<Map<String, Value>>().into()
}

fn noted(n: &FormNote) -> Value {
    let mut value = json!(n);
    if let Some(entry) = value.as_object_mut() {
        entry.insert("text".into(), Value::String(note(n)));
    }
    value
}

/// A transformation: `outcome` with its `reason`, or the change, its inverse, the feedback, and the new model.
pub fn transformation_json(t: &Transformation) -> Value {
    let mut out = json!({
        "model": t.model,
        "form": t.form,
        "found": t.found().is_some(),
        "outcome": match &t.outcome {
            FormOutcome::Found(_) => "found",
            FormOutcome::Impossible(_) => "impossible",
            FormOutcome::NotFound(_) => "not_found",
        },
    });
    let Some(entries) = out.as_object_mut() else { return out };
    match &t.outcome {
        FormOutcome::Found(form) => entries.extend(found(form)),
        FormOutcome::Impossible(why) | FormOutcome::NotFound(why) => {
            entries.insert("reason".into(), json!(why));
            if let Obstacle::NoInverse { coordinates } = why {
                entries.insert("coordinates_without_inverse".into(), json!(coordinates));
            }
            entries.extend(next_step(why).map(|step| ("next".to_owned(), json!(step))));
        }
    }
    entries.insert("certificate".into(), json!(t.certificate));
    entries.insert("seconds".into(), json!(t.seconds));
    out
}

fn found(form: &NormalForm) -> Map<String, Value> {
    let mut m = Map::new();
    m.insert("coordinates".into(), functions(&form.coordinates));
    m.insert("inverse".into(), form.inverse.as_ref().map_or(Value::Null, functions));
    for (key, list) in [
        ("feedback", &form.feedback),
        ("new_inputs", &form.new_inputs),
        ("linearizing_feedback", &form.linearizing_feedback),
    ] {
        if !list.is_empty() {
            m.insert(key.into(), functions(list));
        }
    }
    m.insert("singular_set".into(), json!(form.singular_set));
    m.insert("inverse_valid".into(), json!(form.inverse_valid));
    m.insert("regular_at_point".into(), json!(form.regular_at_point));
    m.insert("blocks".into(), json!(form.blocks));
    m.insert("notes".into(), form.notes.iter().map(noted).collect());
    m.insert("transformed".into(), json!(form.system));
    let parts: Map<String, Value> = form.parts.iter().map(|p| (p.kind.name().to_owned(), json!(p.system))).collect();
    m.insert("parts".into(), parts.into());
    m
}
