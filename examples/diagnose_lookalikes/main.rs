//! Writes runs of plants that look like those of published measurements, with effects that the model files lack.
//!
//! `cargo run --release --example diagnose_lookalikes -- SEED DIR`: `bracketry diagnose` reads the CSV files with the model that is named.
#![allow(clippy::print_stdout, clippy::unwrap_used)]

mod plants;

use plants::Plant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let seed: u64 = arguments.next().map_or(Ok(1), |s| s.parse())?;
    let dir = std::path::PathBuf::from(arguments.next().unwrap_or_else(|| "out/lookalikes".to_owned()));
    std::fs::create_dir_all(&dir)?;
    for plant in Plant::ALL {
        let drawn = plant.draw(seed);
        let name = format!("{plant:?}-{seed}").to_lowercase();
        std::fs::write(dir.join(format!("{name}.csv")), &drawn.data)?;
        std::fs::write(dir.join(format!("{name}-validate.csv")), &drawn.validate)?;
        std::fs::write(dir.join(format!("{name}.toml")), &drawn.true_model)?;
        println!("{name}: {}, hidden {:?}", plant.model(), drawn.truth);
    }
    Ok(())
}
