//! Logs of an object on the plate, and the plate motion in them.

use std::path::Path;

use bracketry_plate::{PlateKinematics, PlateMotion};
use bracketry_system::{Columns, Document, Entries, FileError};

use super::spline::Spline;

/// Columns that every log has.
const OBJECT: [&str; 4] = ["t", "x_plate", "y_plate", "phi_plate"];
/// Columns of the plate's motion.
const PLATE: [&str; 2] = ["plate_X", "plate_theta"];
/// Neighbours on either side that a jump is compared with, and how far it must stand out.
const NEIGHBOURS: usize = 8;
const STANDS_OUT: f64 = 12.0;
/// Jumps of the displacement (m) or tilt (rad) below this are rounding.
const SMALLEST_JUMP: f64 = 1e-7;

/// A log of an object on the plate: SI units, radians; yaw without jumps by whole turns.
#[derive(Clone, Debug)]
pub struct PlateLog {
    /// What it is called in messages.
    pub name: String,
    /// Times in seconds, increasing.
    pub t: Vec<f64>,
    /// Position of the object in the plate frame in metres.
    pub x: Vec<f64>,
    /// The same along y.
    pub y: Vec<f64>,
    /// Yaw in radians.
    pub phi: Vec<f64>,
    /// Displacement and tilt of the plate, if the log has both.
    pub plate: Option<(Vec<f64>, Vec<f64>)>,
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
        let Columns { mut columns, lines, header } = Columns::parse(doc, |_| Entries::Finite)?;
        let known = columns.keys().cloned().collect::<Vec<_>>().join(", ");
        let missing: Vec<&str> = OBJECT.into_iter().filter(|name| !columns.contains_key(*name)).collect();
        if !missing.is_empty() {
            let message = format!("the column {} is missing; the table has {known}", missing.join(", "));
            return Err(doc.missing(message, "name the columns t, x_plate, y_plate, phi_plate (SI units, radians)"));
        }
        let mut take = |name: &str| columns.remove(name);
        let [Some(t), Some(x), Some(y), Some(phi)] = OBJECT.map(&mut take) else {
            return Err(doc.missing("a column is missing", "name the columns t, x_plate, y_plate, phi_plate"));
        };
        let plate = match PLATE.map(&mut take) {
            [Some(displacement), Some(tilt)] => Some((displacement, tilt)),
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

    /// The motion of the plate, smoothed as much as its own noise asks for and differentiated.
    ///
    /// # Errors
    /// [`FileError`] if the log has no columns for it.
    pub fn motion(&self) -> Result<LoggedMotion, FileError> {
        let Some((displacement, tilt)) = &self.plate else {
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

/// Adds whole turns so that neighbours differ by less than half a turn.
fn unwrapped(mut phi: Vec<f64>) -> Vec<f64> {
    use std::f64::consts::TAU;
    for k in 1..phi.len() {
        phi[k] -= ((phi[k] - phi[k - 1]) / TAU).round() * TAU;
    }
    phi
}

/// A sampled motion of the plate: smooth pieces between jumps.
#[derive(Clone, Debug)]
pub struct LoggedMotion {
    /// Start of each piece with its splines of displacement and tilt.
    pieces: Vec<(f64, Spline, Spline)>,
    end: f64,
}

/// What jumps where one smooth piece of a motion follows another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jump {
    /// When, in seconds.
    pub t: f64,
    /// Change of the displacement, in metres.
    pub displacement: f64,
    /// Change of its rate, in m/s.
    pub velocity: f64,
}

impl LoggedMotion {
    fn new(t: &[f64], displacement: &[f64], tilt: &[f64]) -> Self {
        let mut starts = vec![0];
        starts.extend((1..t.len()).filter(|k| jumps(displacement, *k) || jumps(tilt, *k)));
        let ends = starts.iter().skip(1).copied().chain([t.len()]);
        let piece = |(from, to): (&usize, usize)| {
            let part = *from..to;
            let fit = |column: &[f64]| Spline::fit(&t[part.clone()], &column[part.clone()]);
            (t[*from], fit(displacement), fit(tilt))
        };
        Self { pieces: starts.iter().zip(ends).map(piece).collect(), end: t[t.len() - 1] }
    }

    /// First and last time, in seconds.
    pub fn span(&self) -> (f64, f64) {
        (self.pieces[0].0, self.end)
    }

    /// The jumps between smooth pieces.
    pub fn jumps(&self) -> Vec<Jump> {
        let jump = |w: &[(f64, Spline, Spline)]| {
            let (before, after) = (w[0].1.at(w[1].0), w[1].1.at(w[1].0));
            Jump { t: w[1].0, displacement: after[0] - before[0], velocity: after[1] - before[1] }
        };
        self.pieces.windows(2).map(jump).collect()
    }

    /// The sampled times of the piece that holds at `at`, from `t` on, up to the start of the next one.
    pub(crate) fn knots(&self, at: f64, t: f64) -> Vec<f64> {
        let index = self.pieces.partition_point(|p| p.0 <= at).max(1) - 1;
        let end = self.pieces.get(index + 1).map_or(self.end, |p| p.0);
        let inner = self.pieces[index].1.knots().iter().copied().filter(|s| *s > t && *s < end);
        std::iter::once(t).chain(inner).chain((end > t).then_some(end)).collect()
    }

    /// The motion at `t` within the piece that holds at `at`.
    pub fn within(&self, at: f64, t: f64) -> PlateKinematics {
        let index = self.pieces.partition_point(|p| p.0 <= at).max(1) - 1;
        let (_, displacement, tilt) = &self.pieces[index];
        let ([displacement, velocity, acceleration], [tilt, tilt_rate, tilt_acceleration]) =
            (displacement.at(t), tilt.at(t));
        PlateKinematics { displacement, velocity, acceleration, tilt, tilt_rate, tilt_acceleration }
    }
}

impl PlateMotion for LoggedMotion {
    fn at(&mut self, t: f64) -> PlateKinematics {
        self.within(t, t)
    }
}

/// Whether a column jumps from row `k − 1` to row `k`: the third difference there stands out from those around it, which
/// a smooth motion changes slowly.
fn jumps(column: &[f64], k: usize) -> bool {
    let third = |k: usize| (column[k] - 3.0 * column[k - 1] + 3.0 * column[k - 2] - column[k - 3]).abs();
    // A jump at row k shows in the third differences that end at k, k + 1 and k + 2 as 1, −2, 1 times itself.
    if k < 3 || k + 2 >= column.len() {
        return false;
    }
    let here = third(k).min(third(k + 2)).min(0.5 * third(k + 1));
    let around = (k.saturating_sub(NEIGHBOURS).max(3)..k)
        .chain(k + 3..(k + 3 + NEIGHBOURS).min(column.len()))
        .map(third)
        .fold(0.0, f64::max);
    here > SMALLEST_JUMP && here > STANDS_OUT * around
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

    #[test]
    fn a_jump_is_found_where_it_is_and_nowhere_else() {
        let t: Vec<f64> = (0..1000).map(|k| f64::from(k) * 2e-3).collect();
        let wave = |t: f64, size: f64| size * (0.51 - 0.5 * (18.8 * t).cos() - 0.1 * (37.7 * t).cos());
        let x: Vec<f64> = t.iter().map(|t| wave(*t, if *t < 0.9999 { 0.03 } else { 0.025 })).collect();
        let mut motion = LoggedMotion::new(&t, &x, &vec![0.0; 1000]);
        let jumps = motion.jumps();
        assert_eq!(jumps.len(), 1);
        assert!((jumps[0].t - 1.0).abs() < 1e-12);
        assert!((jumps[0].displacement - (wave(1.0, 0.025) - wave(1.0, 0.03))).abs() < 1e-6);
        // The acceleration is that of the wave on both sides, with no impulse between.
        let exact =
            |t: f64, size: f64| size * (0.5 * 18.8 * 18.8 * (18.8 * t).cos() + 0.1 * 37.7 * 37.7 * (37.7 * t).cos());
        for at in [0.5, 0.98, 1.02, 1.5] {
            let size = if at < 1.0 { 0.03 } else { 0.025 };
            assert!((motion.at(at).acceleration - exact(at, size)).abs() < 0.02, "{at}");
        }
        assert!(motion.at(1.0).acceleration.abs() < 20.0);
    }
}
