//! Which of some measurements that could be made tell the most about a robot's springs.

use std::fmt;
use std::path::Path;

use bracketry_stiffness::{IdentificationError, PoseChoice, PoseInformation, RobotFile, Springs};
use bracketry_system::{Columns, Document};
use serde::Serialize;

use super::StiffnessRunError;
use super::identification::{noise, start};
use super::log::CoordinatesAndWrenches;

/// Standard deviation of a logarithm from which on a parameter will not be identified.
const NOT_IDENTIFIED: f64 = 0.5;

/// What a selection of measurements is expected to tell.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Expectation {
    /// Relative standard deviation of each parameter of the joints' springs, joint by joint; absent where it would not be identified.
    pub errors: Vec<Option<f64>>,
    /// Ratio of the largest to the smallest standard deviation of a combination of logarithms; absent where one is not told at all.
    pub condition: Option<f64>,
}

/// A choice of measurements.
#[derive(Clone, Debug, Serialize)]
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
    /// Joint and name of each parameter.
    pub parameters: Vec<String>,
    /// The rows that were chosen: coordinates of the joints, then the wrench.
    #[serde(skip)]
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
        let row = |i: &usize| candidates[*i].0.iter().chain(candidates[*i].1.iter()).copied().collect();
        Ok(Self {
            robot: file.robot.name.clone(),
            candidates: candidates.len(),
            lines: chosen.chosen.iter().map(|i| lines[*i]).collect(),
            all: expectation(&information.of(&all)),
            springs_known: file.springs.is_some(),
            parameters: names(&springs),
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

/// The parameters of springs in the order of their errors.
fn names(springs: &Springs) -> Vec<String> {
    use bracketry_stiffness::JointSpring::{Backlash, Linear, Stiffening};
    let of = |(i, spring): (usize, &bracketry_stiffness::JointSpring)| {
        let names: &[&str] = match spring {
            Linear { .. } => &["stiffness"],
            Stiffening { .. } => &["stiffness", "cubic"],
            Backlash { .. } => &["stiffness", "gap", "engaged"],
        };
        names.iter().map(|name| format!("joint {} {name}", i + 1)).collect::<Vec<_>>()
    };
    springs.joints.iter().enumerate().flat_map(of).collect()
}

impl fmt::Display for ChosenPoses {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let lines: Vec<String> = self.lines.iter().map(ToString::to_string).collect();
        writeln!(f, "{}: {} of {} measurements tell the most", self.robot, self.lines.len(), self.candidates)?;
        writeln!(f, "lines {}", lines.join(", "))?;
        writeln!(f, "\n{:20} {:>16} {:>16}", "expected error", "of these", "of all")?;
        let percent = |value: &Option<f64>| {
            value.map_or_else(|| "not identified".to_owned(), |value| format!("{:.1} %", 100.0 * value))
        };
        for ((name, chosen), all) in self.parameters.iter().zip(&self.chosen.errors).zip(&self.all.errors) {
            writeln!(f, "{name:20} {:>16} {:>16}", percent(chosen), percent(all))?;
        }
        let number = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), |value| format!("{value:.1}"));
        writeln!(f, "{:20} {:>16} {:>16}", "condition", number(self.chosen.condition), number(self.all.condition))?;
        if !self.springs_known {
            writeln!(f, "\nthe robot file has no springs: 1 MN·m/rad was taken for each joint")?;
        }
        Ok(())
    }
}
