//! Logs, models and truths as files.

use bracketry_trials::SliderTrial;
use serde_json::json;
use std::error::Error;
use std::fs;
use std::path::Path;

/// Writes `SEED.csv`, `SEED.toml` and, apart from them, `truth/SEED.json` per trial.
pub(crate) fn export(trials: &[SliderTrial], directory: &Path) -> Result<(), Box<dyn Error>> {
    let truths = directory.join("truth");
    fs::create_dir_all(&truths)?;
    for trial in trials {
        let log = trial.log()?;
        fs::write(directory.join(format!("{}.csv", trial.seed)), log.csv())?;
        fs::write(directory.join(format!("{}.toml", trial.seed)), &log.model)?;
        let hidden: Vec<_> = log
            .truth
            .hidden
            .iter()
            .map(|h| json!({"effect": h.effect.name(), "strength": h.strength, "shape": h.shape, "size": h.size}))
            .collect();
        let truth =
            json!({"seed": trial.seed, "mass": log.truth.mass, "friction": log.truth.friction, "hidden": hidden});
        fs::write(truths.join(format!("{}.json", trial.seed)), serde_json::to_string_pretty(&truth)? + "\n")?;
    }
    Ok(())
}
