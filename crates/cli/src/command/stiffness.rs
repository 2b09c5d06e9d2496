//! `bracketry stiffness`: springs of a robot from measurements, and the compensation of its deformation.

use std::path::{Path, PathBuf};

use anyhow::Context;
use bracketry::report::stiffness::{json as object, markdown, page, text};
use bracketry::stiffness::{
    ChosenPoses, CompensatedLog, Identification, Outliers, PayloadError, RobotFile, RobotLog, StiffnessRunError,
    TWIST_COLUMNS, WRENCH_COLUMNS, Weighing, with_springs,
};
use clap::{Args, Subcommand};
use serde::Serialize;

use super::file_kind::{FileKind, Given};
use super::help::guide;
use super::output::{PageArgs, csv, folder, json, line, listed, print, save_figures, write};
use super::progress::spinner;
use super::style::{error, warning};
use super::{CommonArgs, Outcome};

/// Shown by the help.
pub(crate) const EXAMPLES: [(&str, &str); 2] = [
    ("Identify joint springs from measurements", "bracketry stiffness identify data.csv models/kr125.toml --out out"),
    ("Corrected references along a log", "bracketry stiffness compensate log.csv models/kr125.toml --out out"),
];

const IDENTIFY_CODES: (&str, &str) =
    ("Exit codes", "0  identified\n1  the data determine neither joint springs nor a compliance\n2  bad input");
const POSES_CODES: (&str, &str) = (
    "Exit codes",
    "0  chosen\n1  chosen, but the measurements would not identify all stiffnesses\n2  bad input, or fewer rows than --count",
);
const WEIGH_CODES: (&str, &str) = (
    "Exit codes",
    "0  identified\n1  the readings do not separate the quantities, or show no payload; the message gives the reason\n2  bad input",
);
const COMPENSATE_CODES: (&str, &str) = (
    "Exit codes",
    "0  compensated\n1  no sample could be used, or the loop with --process-stiffness is not shown to be stable\n2  bad input",
);

/// Commands of `stiffness`. All take a table and the robot file, in either order.
#[derive(Subcommand)]
pub(crate) enum StiffnessCommand {
    /// Identify joint springs and tool-point stiffness from measured displacements under measured loads
    #[command(after_help = guide(
        &[("Write the completed robot file and figures to a folder", "bracketry stiffness identify data.csv models/kr125.toml --out out")],
        &[("Table", "Columns q1 … qn (rad), Fx, Fy, Fz, Mx, My, Mz (N, N·m on the robot at the tool point, base axes), and \
            dx, dy, dz, rx, ry, rz (m, rad, base axes)."), IDENTIFY_CODES],
    ))]
    Identify {
        #[command(flatten)]
        files: TableAndRobot,
        /// Keep outliers
        #[arg(long)]
        keep_outliers: bool,
    },
    /// From candidates, choose the measurements that are most informative about the springs
    #[command(after_help = guide(
        &[("Choose twenty", "bracketry stiffness poses candidates.csv models/kr125.toml --count 20 --out out")],
        &[("Table", "Columns q1 … qn (rad) and Fx, Fy, Fz, Mx, My, Mz (N, N·m on the robot at the tool point, base axes): \
            poses that the robot can reach, with loads that can be applied there."), POSES_CODES],
    ))]
    Poses {
        #[command(flatten)]
        files: TableAndRobot,
        /// Number of measurements to choose
        #[arg(long, allow_negative_numbers = true, default_value_t = 20)]
        count: usize,
    },
    /// Identify the payload on the force sensor and the bias of the sensor from readings at rest
    #[command(after_help = guide(
        &[("From readings", "bracketry stiffness weigh readings.csv models/kr125.toml")],
        &[("Table", "Columns q1 … qn (rad) and Fx, Fy, Fz, Mx, My, Mz (N, N·m, axes of the sensor). The payload touches nothing. Three or more orientations are needed, tilted about two axes."), WEIGH_CODES],
    ))]
    Weigh {
        #[command(flatten)]
        files: TableAndRobot,
    },
    /// Apply the compensation to a log: corrected references, predicted deformation
    #[command(after_help = guide(
        &[
            ("Along a log", "bracketry stiffness compensate log.csv models/kr125.toml --out out"),
            ("With a process stiffness of 50 N/mm", "bracketry stiffness compensate log.csv models/kr125.toml --process-stiffness 5e4"),
        ],
        &[("Log", "Columns t, q1 … qn (rad), Fx, Fy, Fz, Mx, My, Mz (N, N·m, axes of the sensor), and r1 … rn \
            where references differ from what was measured."), COMPENSATE_CODES],
    ))]
    Compensate {
        #[command(flatten)]
        files: TableAndRobot,
        /// Process stiffness in N/m, in all directions or along x,y,z of the base; checks the stability of the loop
        #[arg(long, value_name = "N/m", allow_hyphen_values = true, value_delimiter = ',', value_parser = process_stiffness)]
        process_stiffness: Option<Vec<f64>>,
    },
}

impl StiffnessCommand {
    /// The files that are read, with what they are to be.
    pub(crate) fn files(&self) -> Vec<Given> {
        let (Self::Identify { files, .. }
        | Self::Poses { files, .. }
        | Self::Weigh { files }
        | Self::Compensate { files, .. }) = self;
        let sorted = files.sorted().ok();
        let wanted = match self {
            Self::Identify { .. } => FileKind::Measurements,
            Self::Poses { .. } | Self::Weigh { .. } => FileKind::Loads,
            Self::Compensate { .. } => FileKind::RobotLog,
        };
        let given = sorted.map(|(table, robot)| [Given::new(table, wanted), Given::new(robot, FileKind::Robot)]);
        given.into_iter().flatten().collect()
    }
}

/// A table and a robot file.
#[derive(Args)]
pub(crate) struct TableAndRobot {
    /// Table (CSV)
    #[arg(value_name = "DATA", value_hint = clap::ValueHint::FilePath)]
    first: PathBuf,
    /// Robot file (TOML)
    #[arg(value_name = "ROBOT", value_hint = clap::ValueHint::FilePath)]
    second: PathBuf,
    #[command(flatten)]
    page: PageArgs,
}

impl TableAndRobot {
    /// The table and the robot file, which is the one that ends in .toml.
    fn sorted(&self) -> anyhow::Result<(&Path, &Path)> {
        let robot = |path: &Path| path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"));
        let (first, second) = (self.first.as_path(), self.second.as_path());
        match (robot(first), robot(second)) {
            (false, true) => Ok((first, second)),
            (true, false) => Ok((second, first)),
            (both, _) => {
                let (which, and, end) = if both { ("both", "and", "end") } else { ("neither", "nor", "ends") };
                let (first, second) = (first.display(), second.display());
                anyhow::bail!(
                    "{which} {first} {and} {second} {end} in .toml\n   = give a table and a robot file: DATA.csv ROBOT.toml"
                )
            }
        }
    }
}

/// A stiffness of a process in N/m.
fn process_stiffness(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if (0.0..=1e9).contains(&value) => Ok(value),
        _ => Err("give a stiffness from 0 to 1e9 N/m; 50 N/mm is 5e4".to_owned()),
    }
}

/// Runs a command of `stiffness`.
pub(crate) fn run(command: &StiffnessCommand, output: &CommonArgs) -> anyhow::Result<Outcome> {
    let (StiffnessCommand::Identify { files, .. }
    | StiffnessCommand::Poses { files, .. }
    | StiffnessCommand::Weigh { files }
    | StiffnessCommand::Compensate { files, .. }) = command;
    files.page.check(output)?;
    let (outcome, page) = match command {
        StiffnessCommand::Identify { files, keep_outliers } => {
            let (data, robot) = files.sorted()?;
            let outliers = if *keep_outliers { Outliers::Keep } else { Outliers::Reject };
            (identify(data, robot, outliers, output)?, "identification.html")
        }
        StiffnessCommand::Poses { files, count } => {
            let (candidates, robot) = files.sorted()?;
            (poses(candidates, robot, *count, output)?, "poses.html")
        }
        StiffnessCommand::Weigh { files } => {
            let (readings, robot) = files.sorted()?;
            (weigh(readings, robot, output)?, "weighing.html")
        }
        StiffnessCommand::Compensate { files, process_stiffness } => {
            let (log, robot) = files.sorted()?;
            let process = match process_stiffness.as_deref() {
                None => None,
                Some([all]) => Some([*all; 3]),
                Some([x, y, z]) => Some([*x, *y, *z]),
                Some(other) => {
                    anyhow::bail!("{} numbers for --process-stiffness; give one, or three as 5e4,5e4,1e4", other.len())
                }
            };
            (compensate(log, robot, process, output)?, "compensation.html")
        }
    };
    // Readings that do not determine a payload have no page.
    let is_written = outcome == Outcome::Done || !matches!(command, StiffnessCommand::Weigh { .. });
    if let Some(dir) = output.out.as_ref().filter(|_| is_written) {
        files.page.open(&dir.join(page));
    }
    Ok(outcome)
}

fn identify(data: &Path, robot: &Path, outliers: Outliers, output: &CommonArgs) -> anyhow::Result<Outcome> {
    let file = RobotFile::read(robot)?;
    let progress = spinner("identifying");
    let found = Identification::new(&file, data, outliers)?;
    if let Some(dir) = &output.out {
        folder(dir)?;
        write(&dir.join("identification.json"), &json(&object::identification(&found))?)?;
        write(&dir.join("identification.txt"), &text::identification(&found))?;
        write(&dir.join("identification.md"), &markdown::identification(&found))?;
        let mut files = listed(&[
            ("identification.txt", "the report as text"),
            ("identification.md", "the same as Markdown"),
            ("identification.json", "all results, for programs"),
        ]);
        if let Some(why) = &found.withheld {
            warning(&format!("no identified.toml: {}", text::withheld(why)));
        }
        if let Some(springs) = &found.springs {
            let old = std::fs::read_to_string(robot).with_context(|| format!("cannot read {}", robot.display()))?;
            // The springs are in the report, whether they go into the file or not.
            match with_springs(&robot.display().to_string(), &old, springs) {
                Ok(changed) => {
                    write(&dir.join("identified.toml"), &changed)?;
                    files.extend(listed(&[("identified.toml", "the robot file with these springs")]));
                }
                Err(e) => warning(&format!("no identified.toml: {e}")),
            }
        }
        let figures = page::identification_figures(&found);
        files.extend(save_figures(&figures, dir));
        write(&dir.join("identification.html"), &page::identification_page(&found, &figures, &files))?;
    }
    progress.finish_and_clear();
    let files = if found.springs.is_some() {
        "the robot file with these springs, and figures"
    } else {
        "the report and figures"
    };
    report(&text::identification(&found), &object::identification(&found), output, files)?;
    // Joint springs that the data do not tell, and no stiffness of one pose instead.
    Ok(if found.springs.is_none() && found.cartesian.is_none() { Outcome::Negative } else { Outcome::Done })
}

fn poses(candidates: &Path, robot: &Path, count: usize, output: &CommonArgs) -> anyhow::Result<Outcome> {
    let file = RobotFile::read(robot)?;
    let progress = spinner("choosing");
    let found = ChosenPoses::new(&file, candidates, count)?;
    if let Some(dir) = &output.out {
        folder(dir)?;
        write(&dir.join("poses.json"), &json(&object::chosen_poses(&found))?)?;
        write(&dir.join("poses.txt"), &text::chosen_poses(&found))?;
        let q = (1..=file.robot.joints.len()).map(|i| format!("q{i}"));
        let header: Vec<String> = q.chain(WRENCH_COLUMNS.map(String::from)).collect();
        csv(&dir.join("poses.csv"), &header, found.rows.iter().map(Vec::as_slice))?;
        let files = listed(&[
            ("poses.csv", "the chosen rows"),
            ("poses.txt", "the report as text"),
            ("poses.json", "all results, for programs"),
        ]);
        write(&dir.join("poses.html"), &page::poses_page(&found, &files))?;
    }
    progress.finish_and_clear();
    report(&text::chosen_poses(&found), &object::chosen_poses(&found), output, "the chosen rows as a table")?;
    // Measurements that will not tell all springs.
    Ok(if found.identifies_all() { Outcome::Done } else { Outcome::Negative })
}

fn weigh(readings: &Path, robot: &Path, output: &CommonArgs) -> anyhow::Result<Outcome> {
    let found = match Weighing::new(&RobotFile::read(robot)?, readings) {
        Err(StiffnessRunError::Weighing { file, why }) if undetermined(&why) => {
            error(&format!("{file}: {why}"));
            return Ok(Outcome::Negative);
        }
        found => found?,
    };
    if let Some(dir) = &output.out {
        folder(dir)?;
        write(&dir.join("weighing.json"), &json(&object::weighing(&found))?)?;
        write(&dir.join("weighing.txt"), &text::weighing(&found))?;
        write(&dir.join("payload.toml"), &text::payload_table(&found.estimate.payload))?;
        let files = listed(&[
            ("payload.toml", "the payload for the robot file"),
            ("weighing.txt", "the report as text"),
            ("weighing.json", "all results, for programs"),
        ]);
        write(&dir.join("weighing.html"), &page::weighing_page(&found, &files))?;
    }
    report(&text::weighing(&found), &object::weighing(&found), output, "the table [payload]")?;
    Ok(Outcome::Done)
}

/// Whether readings that make sense do not determine the payload.
fn undetermined(why: &PayloadError) -> bool {
    matches!(
        why,
        PayloadError::OneOrientation { .. } | PayloadError::OneDirection { .. } | PayloadError::NoWeight { .. }
    )
}

/// Prints a report, and what `--out` has written or would write.
fn report(text: &str, object: &impl Serialize, output: &CommonArgs, files: &str) -> anyhow::Result<()> {
    if output.json {
        return print(&json(object)?);
    }
    print(text)?;
    match &output.out {
        Some(dir) => line(&format!("written to {}", dir.display())),
        None => line(&format!("(--out DIR writes {files})")),
    }
}

fn compensate(log: &Path, robot: &Path, process: Option<[f64; 3]>, output: &CommonArgs) -> anyhow::Result<Outcome> {
    let file = RobotFile::read(robot)?;
    let progress = spinner("compensating");
    let run = CompensatedLog::new(&file, &RobotLog::read(log, &file.robot)?, process)?;
    if let Some(dir) = &output.out {
        folder(dir)?;
        write(&dir.join("compensation.json"), &json(&object::compensated_log(&run))?)?;
        write(&dir.join("compensation.txt"), &text::compensated_log(&run))?;
        write_rows(&dir.join("compensation.csv"), &run)?;
        let mut files = listed(&[
            ("compensation.csv", "the corrected references over time"),
            ("compensation.txt", "the report as text"),
            ("compensation.json", "all results, for programs"),
        ]);
        let figures = page::compensation_figures(&run);
        files.extend(save_figures(&figures, dir));
        write(&dir.join("compensation.html"), &page::compensation_page(&run, &figures, &files))?;
    }
    progress.finish_and_clear();
    let files = "the corrected references and a figure";
    report(&text::compensated_log(&run), &object::compensated_log(&run), output, files)?;
    // A log of which nothing could be used answers nothing; a loop that may be unstable is none to run.
    let unstable = run.loop_gain.is_some_and(|gain| !gain.holds());
    Ok(if run.held() == run.samples || unstable { Outcome::Negative } else { Outcome::Done })
}

fn write_rows(path: &Path, run: &CompensatedLog) -> anyhow::Result<()> {
    let joints = run.correction_max.len();
    let mut header = vec!["t".to_owned()];
    header.extend((1..=joints).map(|i| format!("c{i}")));
    header.extend(WRENCH_COLUMNS.into_iter().chain(TWIST_COLUMNS).chain(["held", "limited"]).map(String::from));
    let rows: Vec<Vec<f64>> = run
        .rows
        .iter()
        .map(|row| {
            let mut values = vec![row.t];
            values.extend(&row.corrected);
            values.extend(row.wrench.iter());
            values.extend(row.displacement.iter());
            values.extend([f64::from(u8::from(row.held)), f64::from(u8::from(row.limited))]);
            values
        })
        .collect();
    csv(path, &header, rows.iter().map(Vec::as_slice))
}
