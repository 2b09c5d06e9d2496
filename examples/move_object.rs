//! Moves another object on another plate: change shape and friction, plan, close the loop, see whether it arrives.
//!
//! `cargo run --release --example move_object [MU]`
#![allow(clippy::print_stdout)]

use bracketry::control;
use bracketry::plate::Shape;
use bracketry::plate::control::Arrival;
use bracketry::plate::plate_move;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mu: f64 = std::env::args().nth(1).map_or(Ok(0.25), |s| s.parse())?;
    let mut problem = plate_move(&Shape::Ellipse { a: 0.12, b: 0.08 }, mu)?;
    problem.samples += 30; // see that it stays
    let controlled = control(&problem)?;
    print!("{}", bracketry::report::control::text(&controlled.run.report));
    let arrival = Arrival::of(&problem, &controlled.recording.trajectory);
    println!("{arrival:#?}");
    Ok(())
}
