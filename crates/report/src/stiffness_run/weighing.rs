//! What a force sensor carries, from its readings at rest.

use std::fmt;
use std::path::Path;

use bracketry_stiffness::{PayloadError, PayloadEstimate, RobotFile, StaticReading, identify_payload};
use bracketry_system::{Columns, Document};
use serde::Serialize;

use super::StiffnessRunError;
use super::compensation::sensor;
use super::log::CoordinatesAndWrenches;

/// A payload with the standard deviations of its numbers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Weighing {
    /// Name of the robot.
    pub robot: String,
    /// Readings.
    pub readings: usize,
    /// Mass in kg, and its standard deviation.
    pub mass: [f64; 2],
    /// Centre of mass in the sensor's frame (m).
    pub centre: [f64; 3],
    /// Its standard deviations.
    pub centre_deviation: [f64; 3],
    /// Reading without any load, in the sensor's axes (N, N·m).
    pub bias: [f64; 6],
    /// Its standard deviations.
    pub bias_deviation: [f64; 6],
    /// Standard deviation of one reading about the fit: force (N), moment (N·m).
    pub residual: [f64; 2],
    /// Line of the reading that fits worst.
    pub worst_line: u64,
}

impl Weighing {
    /// [`Self::from_table`] of a CSV file.
    ///
    /// # Errors
    /// [`StiffnessRunError`] for a file that cannot be read, and as [`Self::from_table`].
    pub fn new(file: &RobotFile, table: &Path) -> Result<Self, StiffnessRunError> {
        let doc = Columns::document(table, "name a CSV file: a table with the columns q1 …, Fx … Mz")?;
        Self::from_table(file, &doc)
    }

    /// Weighs by a table with the columns `q1 … qn` (rad) and `Fx … Mz` (N, N·m, the sensor's axes): readings at rest in several orientations,
    /// with nothing touching what the sensor carries.
    ///
    /// # Errors
    /// [`StiffnessRunError`] for a table that does not fit, a robot file without a sensor, and readings that do not determine the payload.
    pub fn from_table(file: &RobotFile, doc: &Document) -> Result<Self, StiffnessRunError> {
        let sensor = sensor(file)?;
        let read = CoordinatesAndWrenches::parse(doc, &file.robot)?;
        let lines = &read.columns.lines;
        let place = |why| StiffnessRunError::Weighing { file: doc.file().to_owned(), why };
        let reading = |(i, q): (usize, &Vec<f64>)| {
            let at = |source| place(PayloadError::Reading { reading: i + 1, source });
            let orientation = (file.robot.tool_pose(q).map_err(at)? * sensor.pose).rotation;
            Ok(StaticReading { orientation, wrench: read.wrenches[i] })
        };
        let readings: Vec<StaticReading> =
            read.coordinates.iter().enumerate().map(reading).collect::<Result<_, StiffnessRunError>>()?;
        let found = identify_payload(&readings, &file.compensation.gravity).map_err(place)?;
        let PayloadEstimate { payload, mass_deviation, centre_deviation, bias_deviation, residual, worst } = found;
        Ok(Self {
            robot: file.robot.name.clone(),
            readings: readings.len(),
            mass: [payload.mass, mass_deviation],
            centre: payload.centre.into(),
            centre_deviation: centre_deviation.into(),
            bias: payload.bias.into(),
            bias_deviation: bias_deviation.into(),
            residual,
            worst_line: worst.checked_sub(1).and_then(|i| lines.get(i)).copied().unwrap_or_default(),
        })
    }

    /// The table `[payload]` for the robot file.
    pub fn toml(&self) -> String {
        let list = |values: &[f64]| values.iter().map(|v| format!("{v:.5}")).collect::<Vec<_>>().join(", ");
        format!(
            "[payload]\nmass = {:.5}\ncentre = [{}]\nbias = [{}]\n",
            self.mass[0],
            list(&self.centre),
            list(&self.bias)
        )
    }
}

impl fmt::Display for Weighing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}: what the sensor carries, from {} readings, ± standard deviation", self.robot, self.readings)?;
        writeln!(f, "mass {:.4} ± {:.4} kg", self.mass[0], self.mass[1])?;
        for (i, axis) in ["x", "y", "z"].iter().enumerate() {
            let (centre, deviation) = (1e3 * self.centre[i], 1e3 * self.centre_deviation[i]);
            writeln!(f, "centre {axis} {centre:.2} ± {deviation:.2} mm, in the sensor's frame")?;
        }
        for (i, (value, deviation)) in self.bias.iter().zip(&self.bias_deviation).enumerate() {
            let unit = if i < 3 { "N" } else { "N·m" };
            writeln!(f, "bias {} {value:.4} ± {deviation:.4} {unit}", super::log::WRENCH[i])?;
        }
        let [force, moment] = self.residual;
        writeln!(f, "one reading lies {force:.3} N, {moment:.4} N·m about them; line {} farthest", self.worst_line)?;
        write!(f, "\n{}", self.toml())
    }
}
