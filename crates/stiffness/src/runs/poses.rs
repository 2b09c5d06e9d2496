//! Which of some measurements that could be made tell the most about a robot's springs.

use super::error::StiffnessRunError;
use super::identification::{noise, start};
use super::log::CoordinatesAndWrenches;
use crate::identify::{IdentificationError, NOT_IDENTIFIED, PoseChoice, PoseInformation};
use crate::robot_file::RobotFile;
use bracketry_files::{Columns, Document};
use std::path::Path;

/// What a selection of measurements is expected to tell.
#[derive(Clone, Debug, PartialEq)]
pub struct Expectation {
    /// Relative standard deviation of each parameter of the joints' springs, joint by joint; absent where it would not be identified.
    pub errors: Vec<Option<f64>>,
    /// Ratio of the largest to the smallest standard deviation of a combination of logarithms; absent where one is not told at all.
    pub condition: Option<f64>,
}

/// A choice of measurements.
#[derive(Clone, Debug)]
pub struct ChosenPoses {
    /// Name of the robot.
    pub robot: String,
    /// Rows of the table of candidates.
    pub candidates: usize,
    /// Lines of the table that were chosen.
    pub lines: Vec<u64>,
    /// What they are expected to tell.
    pub chosen: Expectation,
    /// What all candidates together would.
    pub all: Expectation,
    /// Whether the springs are those of the robot file, or of a usual size.
    pub springs_known: bool,
    /// Joint (from 1) and name of each parameter.
    pub parameters: Vec<(usize, &'static str)>,
    /// The rows that were chosen: coordinates of the joints, then the wrench.
    pub rows: Vec<Vec<f64>>,
}

impl ChosenPoses {
    /// [`Self::from_table`] of a CSV file.
    ///
    /// # Errors
    /// [`StiffnessRunError`] for a file that cannot be read, and as [`Self::from_table`].
    pub fn new(file: &RobotFile, table: &Path, count: usize) -> Result<Self, StiffnessRunError> {
        let doc = Columns::document(table, "name a CSV file: a table of candidates with the columns q1 …, Fx … Mz")?;
        Self::from_table(file, &doc, count)
    }

    /// Chooses `count` rows of a table of candidates, which has the columns `q1 … qn` (rad) and `Fx … Mz` (N, N·m on the robot at the tool
    /// point, base axes): those with the largest determinant of information about the springs.
    ///
    /// # Errors
    /// [`StiffnessRunError`] for a table that does not fit, or fewer candidates than are to be chosen.
    pub fn from_table(file: &RobotFile, doc: &Document, count: usize) -> Result<Self, StiffnessRunError> {
        let read = CoordinatesAndWrenches::parse(doc, &file.robot)?;
        let lines = &read.columns.lines;
        let place = |why: IdentificationError| StiffnessRunError::Identification {
            file: doc.file().to_owned(),
            why: why.in_file(lines),
        };
        let springs = start(file);
        let candidates: Vec<_> = read.coordinates.into_iter().zip(read.wrenches).collect();
        let information = PoseInformation::new(&file.robot, &springs, &candidates, &noise(file)).map_err(place)?;
        let chosen = information.choose(count).map_err(place)?;
        let all: Vec<usize> = (0..candidates.len()).collect();
        let joints = springs.joints.iter().enumerate();
        let parameters = joints
            .flat_map(|(i, spring)| spring.parameters().into_iter().map(move |(name, _)| (i + 1, name)))
            .collect();
        let row = |i: &usize| candidates[*i].0.iter().chain(candidates[*i].1.iter()).copied().collect();
        Ok(Self {
            robot: file.robot.name.clone(),
            candidates: candidates.len(),
            lines: chosen.chosen.iter().map(|i| lines[*i]).collect(),
            all: expectation(&information.of(&all)),
            springs_known: file.springs.is_some(),
            parameters,
            rows: chosen.chosen.iter().map(row).collect(),
            chosen: expectation(&chosen),
        })
    }

    /// Whether the chosen measurements are expected to tell all parameters.
    pub fn identifies_all(&self) -> bool {
        self.chosen.errors.iter().all(Option::is_some)
    }
}

fn expectation(choice: &PoseChoice) -> Expectation {
    let error = |std: &f64| (*std <= NOT_IDENTIFIED).then_some(*std);
    Expectation {
        errors: choice.log_std.iter().map(error).collect(),
        condition: choice.condition.is_finite().then_some(choice.condition),
    }
}
