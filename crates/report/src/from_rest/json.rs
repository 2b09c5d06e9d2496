//! JSON of motion from rest to rest.

use bracketry_steer::from_rest::{FromRest, Stroke};
use serde_json::{Map, Value, json};

use super::text::{cone_text, stroke_name};

/// Answer, coordinates, bounds, friction forces, and loops with their displacements.
pub fn from_rest_json(found: &FromRest) -> Value {
    let cones: Vec<Value> = found
        .cones
        .iter()
        .map(|c| {
            let mut out = json!(c);
            out["text"] = json!(cone_text(c));
            out
        })
        .collect();
    let mut out = json!({
        "model": found.model,
        "coordinates": found.coordinates,
        "bounds": found.bounds,
        "friction": cones,
        "loops": found.strokes.iter().map(|s| stroke(found, s)).collect::<Vec<_>>(),
        "moving": found.moving.iter().map(|&c| &found.coordinates[c].name).collect::<Vec<_>>(),
        "sizes": found.sizes,
        "directions": found.directions,
        "margin": found.margin,
        "return": found.back,
        "grid": found.grid.as_ref().map(|grid| json!({
            "loops": grid.loops,
            "points": grid.points,
            "half_cell": grid.half_cell,
            "covered": grid.is_covered(),
        })),
    });
    if let (Some(object), Value::Object(answer)) = (out.as_object_mut(), json!(found.answer)) {
        object.extend(answer);
        if let Some(reason) = &found.reason {
            object.insert("reason".into(), json!(reason));
            object.insert("reason_text".into(), json!(reason.to_string()));
        }
    }
    out
}

fn stroke(found: &FromRest, s: &Stroke) -> Value {
    let named = |change: &[f64]| -> Map<String, Value> {
        found.coordinates.iter().zip(change).map(|(c, d)| (c.name.clone(), json!(d))).collect()
    };
    let displacements: Vec<Value> =
        s.displacements.iter().map(|d| json!({"scale": d.scale, "change": named(&d.change)})).collect();
    json!({
        "inputs": s.inputs,
        "form": s.shape,
        "text": stroke_name(s),
        "duration": s.duration,
        "displacements": displacements,
        "proven": s.proven.map(|(c, sign)| json!({"coordinate": found.coordinates[c].name, "sign": sign})),
        "signals": {"t": s.signals.times, "values": s.signals.values},
    })
}
