//! `bracketry stiffness`: springs of a robot from measurements, and the compensation of its deformation.

use std::path::{Path, PathBuf};

use anyhow::Context;
use bracketry::stiffness::{Outliers, RobotFile, with_springs};
use bracketry::{CompensatedLog, Identification, RobotLog};
use clap::Subcommand;

use super::output::{csv, figure, folder, json, line, print, spinner, write};
use super::{Outcome, OutputArgs};

/// Commands of `stiffness`.
#[derive(Subcommand)]
pub(crate) enum StiffnessCommand {
    /// Springs of the joints and stiffness at the tool point from measured displacements under measured loads
    #[command(after_help = "Example:\n  bracketry stiffness identify data.csv models/kr125.toml --out out\n\n\
        The table has the columns q1 … qn (rad), Fx, Fy, Fz, Mx, My, Mz (N, N·m on the robot at the tool point, base axes) and \
        dx, dy, dz, rx, ry, rz (m, rad, base axes).")]
    Identify {
        /// Measurements (CSV)
        data: PathBuf,
        /// Robot file (TOML)
        robot: PathBuf,
        /// Use all measurements as they are
        #[arg(long)]
        keep_outliers: bool,
    },
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
        StiffnessCommand::Identify { data, robot, keep_outliers } => {
            let outliers = if *keep_outliers { Outliers::Keep } else { Outliers::Reject };
            identify(data, robot, outliers, output)
        }
        StiffnessCommand::Compensate { robot, log } => compensate(robot, log, output),
    }
}

fn identify(data: &Path, robot: &Path, outliers: Outliers, output: &OutputArgs) -> anyhow::Result<Outcome> {
    let file = RobotFile::read(robot)?;
    let progress = spinner("identifying");
    let found = Identification::new(&file, data, outliers)?;
    if let Some(dir) = &output.out {
        folder(dir)?;
        write(&dir.join("identification.json"), &json(&found)?)?;
        write(&dir.join("identification.txt"), &found.to_string())?;
        if let Some(why) = &found.withheld {
            eprintln!("warning: no identified.toml: {why}");
        }
        if let Some(springs) = &found.springs {
            let text = std::fs::read_to_string(robot).with_context(|| format!("cannot read {}", robot.display()))?;
            // The springs are in the report, whether they go into the file or not.
            match with_springs(&robot.display().to_string(), &text, springs) {
                Ok(changed) => write(&dir.join("identified.toml"), &changed)?,
                Err(e) => eprintln!("warning: no identified.toml: {e}"),
            }
        }
        for (drawing, name) in [(found.stiffness_figure(), "stiffness"), (found.residual_figure(), "residuals")] {
            if let Some(drawing) = drawing {
                figure(drawing, &dir.join(name));
            }
        }
    }
    progress.finish_and_clear();
    if output.json {
        print(&json(&found)?)?;
    } else {
        print(&found.to_string())?;
        match &output.out {
            Some(dir) => line(&format!("written to {}", dir.display()))?,
            None => line("(--out DIR writes the robot file with these springs, and figures)")?,
        }
    }
    // Joint springs that the data do not tell, and no stiffness of one pose instead.
    Ok(if found.springs.is_none() && found.compliance.is_none() { Outcome::Negative } else { Outcome::Done })
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
