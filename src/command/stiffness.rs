//! `bracketry stiffness`: springs of a robot from measurements, and the compensation of its deformation.

use std::path::{Path, PathBuf};

use bracketry::stiffness::RobotFile;
use bracketry::{CompensatedLog, RobotLog};
use clap::Subcommand;

use super::output::{csv, figure, folder, json, line, print, spinner, write};
use super::{Outcome, OutputArgs};

/// Commands of `stiffness`.
#[derive(Subcommand)]
pub(crate) enum StiffnessCommand {
    /// What the compensation does along a log: corrected references, predicted deformation
    #[command(after_help = "Example:\n  bracketry stiffness compensate models/kr125.toml log.csv --out out\n\n\
        The log has the columns t, q1 … qn (rad) and Fx, Fy, Fz, Mx, My, Mz (N, N·m, axes of the sensor), and r1 … rn \
        where references differ from what was measured.")]
    Compensate {
        /// Robot file (TOML)
        robot: PathBuf,
        /// Log (CSV)
        log: PathBuf,
    },
}

/// Runs a command of `stiffness`.
pub(crate) fn run(command: &StiffnessCommand, output: &OutputArgs) -> anyhow::Result<Outcome> {
    match command {
        StiffnessCommand::Compensate { robot, log } => compensate(robot, log, output),
    }
}

fn compensate(robot: &Path, log: &Path, output: &OutputArgs) -> anyhow::Result<Outcome> {
    let file = RobotFile::read(robot)?;
    let progress = spinner("compensating");
    let run = CompensatedLog::new(&file, &RobotLog::read(log, &file.robot)?)?;
    if let Some(dir) = &output.out {
        folder(dir)?;
        write(&dir.join("compensation.json"), &json(&run)?)?;
        write(&dir.join("compensation.txt"), &run.to_string())?;
        write_rows(&dir.join("compensation.csv"), &run)?;
        figure(run.figure(), &dir.join("compensation"));
    }
    progress.finish_and_clear();
    if output.json {
        print(&json(&run)?)?;
    } else {
        print(&run.to_string())?;
        match &output.out {
            Some(dir) => line(&format!("written to {}", dir.display()))?,
            None => line("(--out DIR writes the corrected references and a figure)")?,
        }
    }
    // A log of which nothing could be used answers nothing.
    Ok(if run.held() == run.samples { Outcome::Negative } else { Outcome::Done })
}

fn write_rows(path: &Path, run: &CompensatedLog) -> anyhow::Result<()> {
    let joints = run.correction_max.len();
    let mut header = vec!["t".to_owned()];
    header.extend((1..=joints).map(|i| format!("c{i}")));
    header.extend(
        ["Fx", "Fy", "Fz", "Mx", "My", "Mz", "dx", "dy", "dz", "rx", "ry", "rz", "held", "limited"].map(String::from),
    );
    let rows: Vec<Vec<f64>> = run
        .rows
        .iter()
        .map(|row| {
            let mut values = vec![row.t];
            values.extend(&row.corrected);
            values.extend(row.wrench);
            values.extend(row.displacement);
            values.extend([f64::from(u8::from(row.held)), f64::from(u8::from(row.limited))]);
            values
        })
        .collect();
    csv(path, &header, rows.iter().map(Vec::as_slice))
}
