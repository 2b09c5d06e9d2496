//! What can the inputs of the plate reach? Prints the report and walks through its figures.
//!
//! `cargo run --release --example rank_report [MODEL.toml]`
#![allow(clippy::print_stdout)]

use bracketry::lie::AnalysisOptions;
use bracketry::system::System;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let default = concat!(env!("CARGO_MANIFEST_DIR"), "/models/plate_published.toml").to_owned();
    let path = std::env::args().nth(1).unwrap_or(default);
    let system = System::read(&path)?;
    let analysis = bracketry::analyze(&system, &AnalysisOptions::default())?;
    print!("{}", bracketry::report::analysis::text(&analysis));

    println!("\nfrom the same result, as data:");
    for mode in &analysis.report.modes {
        println!("  signs {:?}: growth {:?}", mode.signs.0, mode.dimensions.growth);
    }
    if let Some(switched) = &analysis.report.switched {
        println!("  all modes together: growth {:?}", switched.dimensions.growth);
    }
    Ok(())
}
