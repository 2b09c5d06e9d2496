//! Tables of joint coordinates with what a force sensor reads.

use bracketry_numerics::statistics::{median, steps};
use std::path::Path;

use crate::robot::{JointKind, Robot, Wrench};
use bracketry_files::{Columns, Document, Entries, FileError};

/// Columns of a displacement in a table.
pub const TWIST_COLUMNS: [&str; 6] = ["dx", "dy", "dz", "rx", "ry", "rz"];
/// Columns of a wrench in a table.
pub const WRENCH_COLUMNS: [&str; 6] = ["Fx", "Fy", "Fz", "Mx", "My", "Mz"];
/// Two turns: joint coordinates beyond are in degrees (rad).
const LARGEST_ANGLE: f64 = 4.0 * std::f64::consts::PI;
/// Longest arm of a joint that slides (m).
const LARGEST_STROKE: f64 = 50.0;
/// Deviation of a period from the middle one, relative, up to which a log counts as evenly sampled.
const UNEVEN: f64 = 0.2;

/// A log of a robot at work: SI units, radians.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotLog {
    /// Times in seconds, increasing.
    pub t: Vec<f64>,
    /// Time between two samples in seconds.
    pub period: f64,
    /// Measured coordinates of the joints, one list for each sample; what was lost is NaN.
    pub measured: Vec<Vec<f64>>,
    /// Readings of the sensor in its axes; what was lost is NaN.
    pub readings: Vec<Wrench>,
    /// References of the joints; the measured coordinates where the log has none.
    pub references: Vec<Vec<f64>>,
}

impl RobotLog {
    /// Reads a table with the columns `t, q1 … qn, Fx … Mz` (the sensor's axes) and, where the references are known, `r1 … rn`.
    /// Entries may be lost (empty, nan) but for `t`.
    ///
    /// # Errors
    /// [`FileError`] with place and remedy; also for coordinates in degrees and uneven sampling.
    pub fn read(path: &Path, robot: &Robot) -> Result<Self, FileError> {
        let doc = Columns::document(path, "name a CSV file: a table with the columns t, q1 …, Fx, Fy, Fz, Mx, My, Mz")?;
        Self::from_table(&doc, robot)
    }

    /// [`RobotLog::read`] from the text of the table.
    ///
    /// # Errors
    /// As [`RobotLog::read`].
    pub fn from_table(doc: &Document, robot: &Robot) -> Result<Self, FileError> {
        let entries = |name: &str| if name == "t" { Entries::Finite } else { Entries::MayBeLost };
        let table = Columns::parse(doc, entries)?;
        let q = joint_names("q", robot);
        let t = column(doc, &table, "t")?.clone();
        check_joints(doc, &table, robot, "q")?;
        let measured = rows(doc, &table, &q)?;
        check_coordinates(doc, &table, robot, &q)?;
        let readings = rows(doc, &table, &WRENCH_COLUMNS.map(str::to_owned))?;
        let r = joint_names("r", robot);
        check_joints(doc, &table, robot, "r")?;
        let references = if r.iter().any(|name| table.columns.contains_key(name)) {
            check_coordinates(doc, &table, robot, &r)?;
            rows(doc, &table, &r)?
        } else {
            measured.clone()
        };
        let period = period(doc, &table, &t)?;
        let readings = readings.iter().map(|row| Wrench::from_row_slice(row)).collect();
        Ok(Self { t, period, measured, readings, references })
    }
}

/// A table with coordinates of the joints and a wrench in each row.
pub(super) struct CoordinatesAndWrenches {
    /// The table.
    pub(super) columns: Columns,
    /// `q1 … qn` (rad).
    pub(super) coordinates: Vec<Vec<f64>>,
    /// `Fx … Mz` (N, N·m).
    pub(super) wrenches: Vec<Wrench>,
}

impl CoordinatesAndWrenches {
    /// Reads a table in which nothing is lost.
    pub(super) fn parse(doc: &Document, robot: &Robot) -> Result<Self, FileError> {
        let columns = Columns::parse(doc, |_| Entries::Finite)?;
        let q = joint_names("q", robot);
        check_joints(doc, &columns, robot, "q")?;
        let coordinates = rows(doc, &columns, &q)?;
        check_coordinates(doc, &columns, robot, &q)?;
        let wrenches = rows(doc, &columns, &WRENCH_COLUMNS.map(str::to_owned))?;
        let wrenches = wrenches.iter().map(|row| Wrench::from_row_slice(row)).collect();
        Ok(Self { columns, coordinates, wrenches })
    }
}

/// `q1 … qn`.
fn joint_names(letter: &str, robot: &Robot) -> Vec<String> {
    (1..=robot.joints.len()).map(|i| format!("{letter}{i}")).collect()
}

/// Refuses a column of a joint that the robot does not have.
fn check_joints(doc: &Document, table: &Columns, robot: &Robot, letter: &str) -> Result<(), FileError> {
    let joints = robot.joints.len();
    let number = |name: &str| name.strip_prefix(letter)?.parse::<usize>().ok();
    match table.header.iter().find(|name| number(name).is_some_and(|i| i == 0 || i > joints)) {
        None => Ok(()),
        Some(name) => {
            let message = format!("the column {name} belongs to no joint: the robot has {joints}");
            Err(doc.missing(message, "remove the column, or name the file of the robot that was measured"))
        }
    }
}

fn column<'a>(doc: &Document, table: &'a Columns, name: &str) -> Result<&'a Vec<f64>, FileError> {
    table.columns.get(name).ok_or_else(|| {
        let message = format!("the column {name} is missing; the table has {}", table.header.join(", "));
        doc.missing(message, "`bracketry stiffness COMMAND --help` lists the columns; units are m, rad, N, N·m")
    })
}

/// Columns side by side.
pub(super) fn rows(doc: &Document, table: &Columns, names: &[String]) -> Result<Vec<Vec<f64>>, FileError> {
    let columns: Vec<&Vec<f64>> = names.iter().map(|name| column(doc, table, name)).collect::<Result<_, _>>()?;
    Ok((0..table.lines.len()).map(|k| columns.iter().map(|column| column[k]).collect()).collect())
}

/// Refuses coordinates that no joint has.
fn check_coordinates(doc: &Document, table: &Columns, robot: &Robot, names: &[String]) -> Result<(), FileError> {
    for (name, joint) in names.iter().zip(&robot.joints) {
        let (limit, unit, remedy) = match joint.kind {
            JointKind::Revolute => (LARGEST_ANGLE, "rad", "looks like degrees: multiply the joint columns by π/180"),
            JointKind::Prismatic => (LARGEST_STROKE, "m", "looks like mm: divide the column by 1000"),
        };
        let values = column(doc, table, name)?;
        if let Some(k) = values.iter().position(|v| v.abs() > limit) {
            let message = format!("line {}, column `{name}`: {} {unit}", table.lines[k], values[k]);
            return Err(doc.missing(message, remedy));
        }
    }
    Ok(())
}

/// The mean period of evenly spaced times.
fn period(doc: &Document, table: &Columns, t: &[f64]) -> Result<f64, FileError> {
    let Some(middle) = median(steps(t)) else {
        return Err(doc.missing("the log has fewer than two rows", "give at least two samples"));
    };
    let uneven = |pair: &[f64]| (pair[1] - pair[0] - middle).abs() > UNEVEN * middle;
    if middle <= 0.0 {
        return Err(doc.missing("the times do not increase", "sort the rows by t, in seconds"));
    }
    if let Some(k) = t.windows(2).position(uneven) {
        let message =
            format!("line {}: {} s after the previous row, elsewhere {middle} s", table.lines[k + 1], t[k + 1] - t[k]);
        return Err(doc.missing(message, "give samples at a fixed period; leave missing entries empty"));
    }
    Ok((t[t.len() - 1] - t[0]) / (t.len() - 1) as f64)
}
