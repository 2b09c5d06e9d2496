//! What a file is, so that a file given to the wrong command, or none at all, is answered with the right one.

use std::path::{Path, PathBuf};

use bracketry::symbolic::closest_name;

/// Kinds of files that commands take.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum FileKind {
    Model,
    Problem,
    Scenario,
    /// Signals over time.
    Table,
    /// A table that may be meant as any of these, with columns missing or misnamed.
    OtherTable,
    /// Displacements of a robot under loads, in poses.
    Measurements,
    /// Poses and loads of a robot.
    Loads,
    /// The same over time.
    RobotLog,
    Robot,
    PlateScenario,
}

/// Files larger than this are not looked into.
const MOST_BYTES: u64 = 16 << 20;

impl FileKind {
    /// What a file is by what stands in it, if that is clear.
    fn of(path: &Path) -> Option<Self> {
        let bytes = std::fs::metadata(path).ok().filter(|m| m.is_file() && m.len() <= MOST_BYTES)?;
        if bytes.len() == 0 {
            return None;
        }
        let text = std::fs::read_to_string(path).ok()?;
        let Ok(table) = text.trim_start_matches('\u{feff}').parse::<toml::Table>() else {
            let header = text.lines().find(|l| !l.is_empty() && !l.starts_with('#'))?;
            let numbers = |line: &str| line.split(',').all(|f| f.trim().is_empty() || f.trim().parse::<f64>().is_ok());
            let row = text.lines().skip_while(|l| *l != header).nth(1)?;
            let table = header.contains(',') && !header.contains('=') && numbers(row);
            return table.then(|| Self::of_columns(&header.split(',').map(str::trim).collect::<Vec<_>>()));
        };
        let has = |key: &str| table.contains_key(key);
        Some(if has("states") || has("dynamics") {
            Self::Model
        } else if has("horizon") || has("cost") {
            Self::Problem
        } else if has("joint") || has("urdf") {
            Self::Robot
        } else if has("experiment") {
            Self::PlateScenario
        } else if has("duration") {
            Self::Scenario
        } else {
            return None;
        })
    }

    /// What a table is by the names of its columns.
    fn of_columns(names: &[&str]) -> Self {
        const WRENCH: [&str; 6] = ["Fx", "Fy", "Fz", "Mx", "My", "Mz"];
        let has = |list: &[&str]| list.iter().all(|name| names.contains(name));
        let of_a_robot = |name: &&str| *name == "q1" || WRENCH.iter().any(|w| w.eq_ignore_ascii_case(name));
        if !has(&["q1"]) || !has(&WRENCH) {
            if has(&["t"]) && !names.iter().any(of_a_robot) { Self::Table } else { Self::OtherTable }
        } else if has(&["t"]) {
            Self::RobotLog
        } else if has(&["dx", "dy", "dz"]) {
            Self::Measurements
        } else {
            Self::Loads
        }
    }

    /// Whether a file of this kind is clearly none of the kind that is wanted.
    fn is_no(self, wanted: Self) -> bool {
        match (self, wanted) {
            // Which columns are missing the command says itself; more of them than it takes will do.
            (Self::OtherTable, Self::Table | Self::Measurements | Self::Loads | Self::RobotLog)
            | (Self::Measurements | Self::RobotLog, Self::Loads)
            | (Self::RobotLog, Self::Table) => false,
            (found, wanted) => found != wanted,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Model => "a model file",
            Self::Problem => "a problem file",
            Self::Scenario => "a scenario file",
            Self::Table => "a table of samples",
            Self::OtherTable => "a table",
            Self::Measurements => "a table of a robot's displacements under loads",
            Self::Loads => "a table of a robot's poses and loads",
            Self::RobotLog => "a log of a robot under load",
            Self::Robot => "a robot file",
            Self::PlateScenario => "a scenario of the plate",
        }
    }

    /// What files of this kind are for.
    fn command(self, path: &Path) -> String {
        let file = path.display();
        match self {
            Self::Model => format!("bracketry analyze {file}"),
            Self::Problem => format!("bracketry control {file}"),
            Self::Scenario => format!("bracketry simulate MODEL.toml --scenario {file}"),
            Self::Table | Self::OtherTable => {
                format!("bracketry simulate MODEL.toml --inputs {file}` or `bracketry diagnose MODEL.toml {file}")
            }
            Self::Measurements => format!("bracketry stiffness identify {file} ROBOT.toml"),
            Self::Loads => {
                format!("bracketry stiffness poses {file} ROBOT.toml` or `bracketry stiffness weigh {file} ROBOT.toml")
            }
            Self::RobotLog => format!("bracketry stiffness compensate {file} ROBOT.toml"),
            Self::Robot => {
                format!(
                    "bracketry stiffness identify DATA.csv {file}` or `bracketry stiffness compensate LOG.csv {file}"
                )
            }
            Self::PlateScenario => format!("bracketry plate {file}"),
        }
    }

    /// The command for a file that stands where a command belongs.
    pub(crate) fn command_for(path: &Path) -> Option<String> {
        Self::of(path).map(|kind| kind.command(path))
    }

    fn extension(self) -> &'static str {
        match self {
            Self::Table | Self::OtherTable | Self::Measurements | Self::Loads | Self::RobotLog => "csv",
            _ => "toml",
        }
    }

    /// Whether a file is of this kind.
    fn is(self, path: &Path) -> bool {
        Self::of(path) == Some(self)
    }

    /// A file of this kind in the folder of another whose name begins with that of the other.
    pub(crate) fn beside(self, other: &Path) -> Option<PathBuf> {
        let folder = other.parent().unwrap_or(Path::new(""));
        let stem = other.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let names: Vec<String> = candidates(folder, self).into_iter().filter(|n| self.is(&folder.join(n))).collect();
        let named_after = names.iter().find(|n| n.starts_with(&stem));
        named_after.map(|name| folder.join(name))
    }

    /// How to come by a file of this kind.
    fn how(self) -> &'static str {
        match self {
            Self::Model => "`bracketry new NAME` writes a model file with a scenario and a problem",
            Self::Problem => "a problem file names a model, [horizon], and [cost]; `bracketry new NAME` writes one",
            Self::Scenario => {
                "a scenario file has `duration = 5.0`, [x0], and [inputs]; `bracketry new NAME` writes one"
            }
            Self::Table | Self::OtherTable => {
                "a table has a header with a column t and one column per input or output; `bracketry simulate --out DIR` writes one"
            }
            Self::Measurements => {
                "such a table has columns q1 … qn, Fx, Fy, Fz, Mx, My, Mz, and dx, dy, dz, rx, ry, rz, with one row per measurement"
            }
            Self::Loads => "such a table has columns q1 … qn and Fx, Fy, Fz, Mx, My, Mz, with one row per pose",
            Self::RobotLog => "such a log has columns t, q1 … qn, and Fx, Fy, Fz, Mx, My, Mz",
            Self::Robot => "models/kr125.toml is a robot file",
            Self::PlateScenario => {
                "a scenario of the plate has `experiment = 1` and the options of `bracketry plate` by name"
            }
        }
    }
}

/// A file that a command was given.
pub(crate) struct Given {
    path: PathBuf,
    wanted: FileKind,
    /// The file that names it, if it does not stand on the command line.
    by: Option<PathBuf>,
}

impl Given {
    /// A file on the command line.
    pub(crate) fn new(path: &Path, wanted: FileKind) -> Self {
        Self { path: path.to_owned(), wanted, by: None }
    }

    /// A problem file, and the model and the plant that it names, if it can be read.
    pub(crate) fn problem(path: &Path) -> Vec<Self> {
        let mut given = vec![Self::new(path, FileKind::Problem)];
        let table = std::fs::read_to_string(path).ok().and_then(|text| text.parse::<toml::Table>().ok());
        let folder = path.parent().unwrap_or(Path::new(""));
        let named = ["model", "plant"].iter().filter_map(|key| table.as_ref()?.get(*key)?.as_str());
        given.extend(named.map(|name| Self {
            path: folder.join(name),
            wanted: FileKind::Model,
            by: Some(path.to_owned()),
        }));
        given
    }
}

/// What is wrong with the files that a command that failed was given, if it is the choice of the files.
pub(crate) fn mistaken(files: &[Given]) -> Option<String> {
    files.iter().find_map(|Given { path, wanted, by }| {
        let by = by.as_ref().map_or(String::new(), |by| format!(" (named in {})", by.display()));
        if path.is_dir() {
            return Some(format!("{}{by}: is a directory\n   = {}", path.display(), in_directory(path, *wanted)));
        }
        if !path.exists() {
            return Some(format!(
                "{}{by}: cannot be read: there is no such file\n   = {}",
                path.display(),
                instead(path, *wanted)
            ));
        }
        let found = FileKind::of(path).filter(|found| found.is_no(*wanted))?;
        Some(format!(
            "{}{by}: this is {}, not {}\n   = {}; for this file: `{}`",
            path.display(),
            found.name(),
            wanted.name(),
            wanted.how(),
            found.command(path)
        ))
    })
}

/// Names of the files in a folder that have the extension of a kind, in order.
fn candidates(folder: &Path, kind: FileKind) -> Vec<String> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .into_iter()
        .flatten()
        .flatten()
        .filter(|e| e.path().extension().is_some_and(|x| x == kind.extension()) && e.path().is_file())
        .filter_map(|e| e.file_name().into_string().ok())
        .collect();
    names.sort();
    names
}

/// Names shown of a folder.
const SHOWN: usize = 6;

fn in_directory(path: &Path, wanted: FileKind) -> String {
    let mut names: Vec<String> = candidates(path, wanted).into_iter().filter(|n| wanted.is(&path.join(n))).collect();
    if names.is_empty() {
        return format!("name a file; {}", wanted.how());
    }
    if names.len() > SHOWN {
        names.truncate(SHOWN);
        names.push("…".to_owned());
    }
    format!("name {} in it: {}", wanted.name(), names.join(", "))
}

fn instead(path: &Path, wanted: FileKind) -> String {
    let folder = path.parent().unwrap_or(Path::new(""));
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let with_extension = format!("{name}.{}", wanted.extension());
    for folder in [folder, &folder.join("models")] {
        let names = candidates(folder, wanted);
        let near = names.iter().find(|n| **n == name || **n == with_extension);
        let near = near.map(String::as_str).or_else(|| closest_name(&name, names.iter().map(String::as_str)));
        if let Some(near) = near {
            return format!("did you mean `{}`?", folder.join(near).display());
        }
    }
    format!("check the path; {}", wanted.how())
}
