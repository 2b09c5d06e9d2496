//! A run on the plate as JSON.

use bracketry_plate::object::Bearing;
use bracketry_plate::run::{Comparison, PlateOutcome};
use bracketry_plate::{Friction, PlateExperiment, Shape};
use serde_json::{Value, json};

use super::text::{assumption, stopped};

/// A run as the JSON object of `bracketry plate --json`: SI units, radians.
pub fn json(ran: &PlateExperiment) -> Value {
    let (setup, run) = (&ran.setup, &ran.run);
    let (first, last) = (&run.rows[0], &run.rows[run.rows.len() - 1]);
    let [x, y, phi, vx, vy, w] = last.state;
    let drift: [f64; 3] = std::array::from_fn(|k| last.state[k] - setup.start[k]);
    json!({
        "experiment": setup.experiment.name,
        "model": setup.model,
        "motion": if ran.driven_by_log { "log" } else { "formula" },
        "shape": shape(&setup.object.shape),
        "thickness": 2.0 * setup.object.height,
        "mass": setup.object.mass,
        "bearing": bearing(&setup.object.bearing),
        "center_of_mass": setup.object.center_of_mass,
        "friction": friction(&setup.friction),
        "start": pose(setup.start),
        "seconds": setup.seconds,
        "points": setup.points,
        "dt": setup.dt,
        "restitution": setup.restitution,
        "sample": setup.sample,
        "assumptions": ran.assumptions().into_iter().map(assumption).collect::<Vec<_>>(),
        "coordinate": setup.experiment.coordinate.name(),
        "target": setup.experiment.target,
        "reached": run.reached,
        "stopped": run.stopped.as_ref().map(stopped),
        "outcome": match ran.outcome() {
            PlateOutcome::Reached => "reached",
            PlateOutcome::NotReached => "not reached",
            PlateOutcome::Stopped => "stopped",
            PlateOutcome::NotFlat => "not flat",
        },
        "t_final": last.t,
        "final": pose([x, y, phi]),
        "velocity_final": [vx, vy, w],
        "drift": pose(drift),
        "events": run.events,
        "plate_jumps": run.jumps.len(),
        "stick_share": run.stick_share(),
        "least_normal_force": run.least_normal_force(),
        "largest_gap": run.largest_gap(),
        "energy_closure": run.energy_closure,
        "wall_seconds": run.wall_seconds,
        "times_real_time": (last.t - first.t) / run.wall_seconds.max(1e-9),
        "comparison": ran.comparison.as_ref().map(comparison),
    })
}

fn comparison(comparison: &Comparison) -> Value {
    let mut value = json!(comparison);
    value["status"] = json!(if comparison.is_undecided() { "undecided" } else { "compared" });
    if let Some(signs) = &comparison.signs {
        value["signs"]["status"] = json!(signs.status());
    }
    value
}

fn pose([x, y, phi]: [f64; 3]) -> Value {
    json!({"x": x, "y": y, "phi": phi})
}

fn shape(shape: &Shape) -> Value {
    match shape {
        Shape::Disk { radius } => json!({"kind": "disk", "radius": radius}),
        Shape::Ellipse { a, b } => json!({"kind": "ellipse", "semi_axes": [a, b]}),
        Shape::Rectangle { a, b } => json!({"kind": "rectangle", "sides": [2.0 * a, 2.0 * b]}),
        Shape::Polygon { .. } => json!({"kind": "polygon", "vertices": shape.rim(0), "area": shape.area()}),
    }
}

fn bearing(bearing: &Bearing) -> Value {
    match bearing {
        Bearing::Footprint => json!({"kind": "footprint"}),
        Bearing::Scaled(scale) => json!({"kind": "scaled", "scale": scale}),
        Bearing::Ring(scale) => json!({"kind": "ring", "scale": scale}),
        Bearing::Feet(points) => json!({"kind": "feet", "points": points}),
        Bearing::Map(points) => json!({"kind": "map", "points": points}),
    }
}

fn friction(law: &Friction) -> Value {
    match law {
        Friction::Coulomb { mu } => json!({"law": "coulomb", "mu": mu}),
        Friction::StaticLevel { mu, mu_static } => json!({"law": "static", "mu": mu, "mu_static": mu_static}),
        Friction::Stribeck { mu, mu_static, velocity } => {
            json!({"law": "stribeck", "mu": mu, "mu_static": mu_static, "velocity": velocity})
        }
        Friction::Anisotropic { mu_along, mu_across } => {
            json!({"law": "anisotropic", "mu_along": mu_along, "mu_across": mu_across})
        }
        Friction::Viscous { mu, coefficient } => json!({"law": "viscous", "mu": mu, "coefficient": coefficient}),
    }
}
