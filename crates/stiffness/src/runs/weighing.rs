//! What a force sensor carries, from a table of its readings at rest.

use super::compensation::sensor;
use super::error::StiffnessRunError;
use super::log::CoordinatesAndWrenches;
use crate::robot_file::RobotFile;
use crate::sensor::{PayloadError, PayloadEstimate, StaticReading, identify_payload};
use bracketry_files::{Columns, Document};
use std::path::Path;

/// A payload from a table of readings.
#[derive(Clone, Debug, PartialEq)]
pub struct Weighing {
    /// Name of the robot.
    pub robot: String,
    /// Readings.
    pub readings: usize,
    /// The payload with its standard deviations.
    pub estimate: PayloadEstimate,
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
    /// with nothing touching the payload.
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
        let worst_line = found.worst.checked_sub(1).and_then(|i| lines.get(i)).copied().unwrap_or_default();
        Ok(Self { robot: file.robot.name.clone(), readings: readings.len(), estimate: found, worst_line })
    }
}
