//! Logs of an object on the plate.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use bracketry_files::{Columns, Document, Entries, FileError};

use super::logged_motion::LoggedMotion;
use crate::PlateKinematics;

/// Columns that every log has.
const OBJECT: [&str; 4] = ["t", "x_plate", "y_plate", "phi_plate"];
/// Columns of the plate's motion.
const PLATE: [&str; 2] = ["plate_X", "plate_theta"];

/// A log of an object on the plate: SI units, radians; yaw without jumps by whole turns.
#[derive(Clone, Debug, PartialEq)]
pub struct PlateLog {
    /// What it is called in messages.
    pub name: String,
    /// Times in seconds, increasing.
    pub t: Vec<f64>,
    /// Position of the object in the plate frame in meters.
    pub x: Vec<f64>,
    /// The same along y.
    pub y: Vec<f64>,
    /// Yaw in radians.
    pub phi: Vec<f64>,
    /// The motion of the plate, if the log has displacement and tilt.
    pub plate: Option<PlateColumns>,
}

/// The motion of the plate in a log.
#[derive(Clone, Debug, PartialEq)]
pub struct PlateColumns {
    /// Displacement `X` in m.
    pub displacement: Vec<f64>,
    /// Tilt `theta` in rad.
    pub tilt: Vec<f64>,
    /// `X''` (m/s²), `theta'` (rad/s) and `theta''` (rad/s²), if they are logged.
    pub derivatives: Option<[Vec<f64>; 3]>,
}

impl PlateColumns {
    /// The columns of a motion at the times of a log.
    pub fn new(motion: &[PlateKinematics], derivatives: bool) -> Self {
        let column = |value: fn(&PlateKinematics) -> f64| motion.iter().map(value).collect::<Vec<f64>>();
        Self {
            displacement: column(|k| k.displacement),
            tilt: column(|k| k.tilt),
            derivatives: derivatives
                .then(|| [column(|k| k.acceleration), column(|k| k.tilt_rate), column(|k| k.tilt_acceleration)]),
        }
    }
}

impl PlateLog {
    /// Reads a table with the columns `t, x_plate, y_plate, phi_plate` and, for the motion of the plate, `plate_X,
    /// plate_theta`; other columns are not looked at.
    ///
    /// # Errors
    /// [`FileError`] with place and remedy.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        let doc = Columns::document(path, "name a CSV file: a table with the columns t, x_plate, y_plate, phi_plate")?;
        Self::from_table(&doc)
    }

    /// [`PlateLog::read`] from the text of the table.
    ///
    /// # Errors
    /// As [`PlateLog::read`].
    pub fn from_table(doc: &Document) -> Result<Self, FileError> {
        let Columns { mut columns, lines, header, .. } = Columns::parse(doc, |_| Entries::Finite)?;
        let known = columns.keys().cloned().collect::<Vec<_>>().join(", ");
        let missing: Vec<&str> = OBJECT.into_iter().filter(|name| !columns.contains_key(*name)).collect();
        let mut take = |name: &str| columns.remove(name);
        let [Some(t), Some(x), Some(y), Some(phi)] = OBJECT.map(&mut take) else {
            let message = format!("the column {} is missing; the table has {known}", missing.join(", "));
            return Err(doc.missing(message, "name the columns t, x_plate, y_plate, phi_plate (SI units, radians)"));
        };
        let plate = match PLATE.map(&mut take) {
            [Some(displacement), Some(tilt)] => Some(PlateColumns { displacement, tilt, derivatives: None }),
            _ => None,
        };
        if let Some(row) = (1..t.len()).find(|row| t[*row] <= t[*row - 1]) {
            let line = lines.get(row).copied().unwrap_or(0);
            let message = format!("line {line}: the time {} does not exceed {} before it", t[row], t[row - 1]);
            let place = Columns::place(doc, &header, line, "t");
            return Err(doc.error(place, message, "sort the rows by time and remove repeated ones"));
        }
        if t.len() < 2 {
            return Err(doc.missing("the table has fewer than two rows", "give at least two samples"));
        }
        Ok(Self { name: doc.file().to_owned(), t, x, y, phi: unwrapped(phi), plate })
    }

    /// The columns, times not among them, by their names in the models of the plate: `x, y, phi`, then `X, theta` and their
    /// derivatives as far as they are logged.
    pub fn columns(&self) -> Vec<(&'static str, &[f64])> {
        let mut columns: Vec<(&'static str, &[f64])> = vec![("x", &self.x), ("y", &self.y), ("phi", &self.phi)];
        if let Some(plate) = &self.plate {
            columns.extend([("X", &*plate.displacement), ("theta", &*plate.tilt)]);
            let names = ["der(X,2)", "der(theta,1)", "der(theta,2)"];
            columns.extend(plate.derivatives.iter().flat_map(|d| names.into_iter().zip(d.iter().map(Vec::as_slice))));
        }
        columns
    }

    /// [`PlateLog::columns`] as a map.
    pub fn by_name(&self) -> BTreeMap<String, Vec<f64>> {
        self.columns().into_iter().map(|(name, values)| (name.to_owned(), values.to_vec())).collect()
    }

    /// A column by its name in the models of the plate.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        self.columns().into_iter().find(|(n, _)| *n == name).map(|(_, values)| values)
    }

    /// The log as a table with the names of [`PlateLog::columns`]: a header, then a row per time.
    pub fn csv(&self) -> String {
        let columns = self.columns();
        // Names with a comma are quoted.
        let quoted = |name: &str| if name.contains(',') { format!("\"{name}\"") } else { name.to_owned() };
        let mut text = String::from("t");
        for (name, _) in &columns {
            let _ = write!(text, ",{}", quoted(name));
        }
        for (row, t) in self.t.iter().enumerate() {
            let _ = write!(text, "\n{t:.6}");
            for (_, values) in &columns {
                let _ = write!(text, ",{:.9}", values[row]);
            }
        }
        text.push('\n');
        text
    }

    /// The motion of the plate, smoothed as much as its own noise asks for and differentiated.
    ///
    /// # Errors
    /// [`FileError`] if the log has no columns for it.
    pub fn motion(&self) -> Result<LoggedMotion, FileError> {
        let Some(PlateColumns { displacement, tilt, .. }) = &self.plate else {
            let doc = Document::new(self.name.clone(), "");
            return Err(doc.missing(
                "there are no columns plate_X and plate_theta to drive the plate",
                "add them (m and rad), or drive the plate by the experiment: --motion formula",
            ));
        };
        Ok(LoggedMotion::new(&self.t, displacement, tilt))
    }

    /// Position and yaw at `t`, by straight lines between the rows.
    pub fn pose(&self, t: f64) -> [f64; 3] {
        let k = self.t.partition_point(|s| *s <= t).clamp(1, self.t.len() - 1);
        let part = ((t - self.t[k - 1]) / (self.t[k] - self.t[k - 1])).clamp(0.0, 1.0);
        [&self.x, &self.y, &self.phi].map(|column| column[k - 1] + part * (column[k] - column[k - 1]))
    }
}

/// Adds whole turns so that neighbors differ by less than half a turn.
fn unwrapped(mut phi: Vec<f64>) -> Vec<f64> {
    use std::f64::consts::TAU;
    for k in 1..phi.len() {
        phi[k] -= ((phi[k] - phi[k - 1]) / TAU).round() * TAU;
    }
    phi
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn log(text: &str) -> Result<PlateLog, FileError> {
        PlateLog::from_table(&Document::new("log.csv", text))
    }

    #[test]
    fn whole_turns_are_undone_and_other_columns_ignored() {
        let log = log("t,x_plate,y_plate,phi_plate,ncon\n0,1,2,3,9\n1,1,2,-3,9\n2,1,2,-2,9\n").unwrap();
        assert!((log.phi[1] - (std::f64::consts::TAU - 3.0)).abs() < 1e-12 && log.phi[2] > log.phi[1]);
        assert!(log.motion().unwrap_err().to_string().contains("--motion formula"));
        assert_eq!(log.pose(0.5)[..2], [1.0, 2.0]);
    }

    #[test]
    fn what_is_wrong_is_said_with_its_place() {
        for (text, part) in [
            ("t,x_plate,phi_plate\n0,1,2\n1,1,2\n", "the column y_plate is missing"),
            ("t,x_plate,y_plate,phi_plate\n0,0,0,0\n1,0,nan,0\n", "line 3, column `y_plate`"),
            ("t,x_plate,y_plate,phi_plate\n0,0,0,0\n1,0,0,0\n0.5,0,0,0\n", "line 4: the time 0.5"),
            ("t,x_plate,y_plate,phi_plate\n0,0,0,0\n", "fewer than two rows"),
            ("t,x_plate,y_plate,phi_plate\n", "no rows"),
        ] {
            let message = log(text).unwrap_err().to_string();
            assert!(message.contains(part), "`{part}` in {message}");
        }
    }
}
