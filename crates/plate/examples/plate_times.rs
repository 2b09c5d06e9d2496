//! Times of moves: `cargo run --release -p bracketry-plate --example plate_times`
#![allow(clippy::print_stdout)]

use bracketry_plate::{MovePlanner, Object, PlanningBudget, PlateError, PlateLimits, Shape};

fn main() -> Result<(), PlateError> {
    let object = Object { shape: Shape::REFERENCE_ELLIPSE, ..Object::REFERENCE };
    let planner = MovePlanner::new(&object, 0.3, &PlateLimits::default())?;
    let moves: [(&str, [f64; 3], [f64; 3]); 6] = [
        ("60 mm, 30 mm, 90°", [0.0, 0.0, 0.0], [0.06, 0.03, 90.0]),
        ("90° turn", [0.0, 0.0, 0.0], [0.0, 0.0, 90.0]),
        ("100 mm, 80 mm", [0.0, 0.0, 0.0], [0.1, 0.08, 0.0]),
        ("far, −103°", [-0.08, 0.07, 0.0], [0.07, -0.08, -103.0]),
        ("middle, 69°", [0.03, -0.02, 0.0], [-0.02, 0.03, 69.0]),
        ("160°", [0.0, 0.0, 0.0], [0.0, 0.0, 160.0]),
    ];
    for (name, start, target) in moves {
        for programs in [0, 250, 500, 1000] {
            let [x, y, yaw] = target;
            let Some(plan) =
                planner.plan(start, [x, y, yaw.to_radians()], &PlanningBudget { programs, seconds: f64::INFINITY })?
            else {
                continue;
            };
            println!(
                "{name}: {:.2} s, arrives {}, miss {:?}, {} programs, {:.2} s",
                plan.duration, plan.arrives, plan.miss, plan.programs, plan.seconds
            );
        }
    }
    Ok(())
}
