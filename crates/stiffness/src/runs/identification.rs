//! Springs and stiffnesses of a robot from a table of measurements.

use super::error::StiffnessRunError;
use super::log::{CoordinatesAndWrenches, TWIST_COLUMNS, rows};
use super::residual::{PredictedTranslation, SpringResidual};
use crate::compliance::{Deformation, Springs};
use crate::identify::{
    Advice, CartesianEstimate, CartesianEstimator, Comparison, Found, IdentificationError, Measurement,
    MeasurementNoise, MeasurementSet, Method, Outliers, SpringFit, SpringFitSettings, SpringParameter, compare,
};
use crate::robot::{JointKind, Twist, halves};
use crate::robot_file::RobotFile;
use bracketry_files::{Columns, Document};
use std::path::Path;

/// Stiffness to start from where the robot file has none: revolute (N·m/rad), prismatic (N/m).
const START: [f64; 2] = [1e6, 1e8];

/// Mean square of the residuals of springs, in units of their noise, from which on they are no springs to work with: twice the noise.
const WRONG: f64 = 4.0;

/// Share of what linear springs leave, squared, from which on lost motion that explains it makes them none to work with.
const LOST: f64 = 0.5;

/// How a method that applies did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MethodFigures {
    /// Error of the prediction of held-out displacements in units of their noise.
    pub held_out: f64,
    /// Ratio of the largest to the smallest: of the loads over all directions in units of their noise (for W on ΔX of the displacements), for
    /// joint springs of the standard deviations of combinations of their logarithms.
    pub condition: f64,
    /// χ² per degree of freedom: mean square of the residuals of displacements in units of their noise.
    pub chi_square: f64,
}

/// Why springs that were found are none to work with; residuals are root mean squares in units of their noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Withheld {
    /// Another method predicts better: something else yields too.
    OtherMethod {
        /// The method.
        method: Method,
        /// Residual of the springs.
        residual: f64,
    },
    /// Lost motion in joints explains most of what they leave.
    LostMotion {
        /// Its share of the squared residual.
        share: f64,
    },
    /// They leave more than noise.
    Misfit {
        /// Their residual.
        residual: f64,
    },
}

/// An identification.
#[derive(Clone, Debug)]
pub struct Identification {
    /// Name of the robot.
    pub robot: String,
    /// Measurements of the table.
    pub measurements: usize,
    /// Lines of the table that were excluded as outliers.
    pub outliers: Vec<u64>,
    /// Why none were left out although that was asked for.
    pub outliers_kept: Option<IdentificationError>,
    /// The method to trust.
    pub trusted: Method,
    /// Why, and what is wrong with the others that work.
    pub advice: Vec<Advice>,
    /// All methods, or why they do not apply.
    pub methods: Vec<(Method, Result<MethodFigures, IdentificationError>)>,
    /// Parameters of the joints' springs.
    pub parameters: Vec<SpringParameter>,
    /// What of the measured translations joint springs do not explain; absent where there are none.
    pub residual: Option<SpringResidual>,
    /// Compliance and stiffness at the tool point where the measurements are of one pose: symmetric positive definite.
    pub cartesian: Option<CartesianEstimate>,
    /// The springs, where the data tell all of them and they explain the data.
    pub springs: Option<Springs>,
    /// Why the springs that were found are none to work with.
    pub withheld: Option<Withheld>,
    /// Measured and predicted translations of the trusted method.
    pub predictions: Vec<PredictedTranslation>,
}

impl Identification {
    /// Identifies from a table with the columns `q1 … qn` (rad), `Fx … Mz` (N, N·m on the robot at the tool point, base axes) and
    /// `dx, dy, dz, rx, ry, rz` (m, rad).
    ///
    /// # Errors
    /// [`StiffnessRunError`] for a table that does not fit, numbers in other units, and data that tell nothing.
    pub fn new(file: &RobotFile, table: &Path, outliers: Outliers) -> Result<Self, StiffnessRunError> {
        let doc = Columns::document(table, "name a CSV file: a table with the columns q1 …, Fx … Mz, dx … rz")?;
        Self::from_table(file, &doc, outliers)
    }

    /// [`Identification::new`] from the text of the table.
    ///
    /// # Errors
    /// As [`Identification::new`].
    pub fn from_table(file: &RobotFile, doc: &Document, outliers: Outliers) -> Result<Self, StiffnessRunError> {
        let robot = &file.robot;
        let read = CoordinatesAndWrenches::parse(doc, robot)?;
        let twists = rows(doc, &read.columns, &TWIST_COLUMNS.map(str::to_owned))?;
        let lines = &read.columns.lines;
        let together = read.coordinates.into_iter().zip(read.wrenches).zip(twists);
        let measurements: Vec<Measurement> = together
            .map(|((q, wrench), twist)| Measurement { q, wrench, displacement: Twist::from_row_slice(&twist) })
            .collect();
        let place = |why: IdentificationError| StiffnessRunError::Identification {
            file: doc.file().to_owned(),
            why: why.in_file(lines),
        };
        let set = MeasurementSet::new(measurements, noise(file)).map_err(place)?;
        let start = start(file);
        let compared = |outliers| compare(&set, Some((robot, &start, &SpringFitSettings::default())), outliers);
        let found = |comparison: &Comparison| Self::of(file, &set, comparison, lines);
        match compared(outliers) {
            Ok(comparison) => Ok(found(&comparison)),
            // Lost motion in a joint contradicts linear springs in most measurements: that is worth more than the refusal.
            Err(why @ IdentificationError::TooManyOutliers { .. }) if outliers == Outliers::Reject => {
                let kept = compared(Outliers::Keep).ok().map(|comparison| found(&comparison));
                let lost = |kept: &Self| kept.residual.as_ref().is_some_and(|rest| !rest.lost_motion.is_empty());
                match kept.filter(lost) {
                    Some(kept) => Ok(Self { outliers_kept: Some(why), ..kept }),
                    None => Err(place(why)),
                }
            }
            Err(why) => Err(place(why)),
        }
    }

    /// What each method of a comparison found.
    fn of(file: &RobotFile, set: &MeasurementSet, comparison: &Comparison, lines: &[u64]) -> Self {
        // Why a method does not apply stands with the method.
        let applies = |advice: &&Advice| !matches!(advice, Advice::DoesNotApply { .. });
        let mut found = Self {
            robot: file.robot.name.clone(),
            measurements: set.len(),
            outliers: comparison.outliers.iter().filter_map(|i| lines.get(*i).copied()).collect(),
            outliers_kept: None,
            trusted: comparison.trusted,
            advice: comparison.advice.iter().filter(applies).cloned().collect(),
            methods: Vec::new(),
            parameters: Vec::new(),
            residual: None,
            cartesian: None,
            springs: None,
            withheld: None,
            predictions: Vec::new(),
        };
        for (method, report) in &comparison.methods {
            let figures = report.as_ref().map(|report| MethodFigures {
                held_out: report.held_out,
                condition: report.found.condition(),
                chi_square: report.found.chi_square(),
            });
            found.methods.push((*method, figures.map_err(|why| why.clone().in_file(lines))));
            match report.as_ref().map(|report| &report.found) {
                Ok(Found::Cartesian(estimate)) => {
                    if *method == comparison.trusted {
                        let predict = |m: &Measurement| Some(estimate.compliance * m.wrench);
                        found.predictions = predictions(set, &comparison.outliers, predict);
                    }
                    if *method == Method::Cartesian(CartesianEstimator::PositiveDefinite) {
                        found.cartesian = Some((**estimate).clone());
                    }
                }
                Ok(Found::Springs(fit)) => found.take_springs(file, set, comparison, fit, lines),
                Err(_) => {}
            }
        }
        found
    }

    fn take_springs(
        &mut self,
        file: &RobotFile,
        set: &MeasurementSet,
        comparison: &Comparison,
        fit: &SpringFit,
        lines: &[u64],
    ) {
        self.parameters.clone_from(&fit.parameters);
        let springs = fit.fitted();
        let predict =
            |m: &Measurement| Some(Deformation::equilibrium(&file.robot, springs, &m.q, &m.wrench).ok()?.tool);
        let predicted = predictions(set, &comparison.outliers, predict);
        self.residual = SpringResidual::new(&file.robot, springs, set, &comparison.outliers, &predicted, lines);
        let lost_motion = self.residual.as_ref().map_or(0.0, SpringResidual::by_lost_motion);
        self.withheld = withheld(fit.chi_square, comparison.trusted, lost_motion);
        self.springs = fit.springs().ok().filter(|_| self.withheld.is_none()).cloned();
        if comparison.trusted == Method::JointSprings {
            self.predictions = predicted;
        }
    }
}

/// Noise of the measurements, as a robot file states it.
pub(super) fn noise(file: &RobotFile) -> MeasurementNoise {
    let noise = &file.noise;
    MeasurementNoise::from_std(noise.translation, noise.rotation, noise.force, noise.moment)
}

/// Springs to start from: those of the robot file, else of a usual size.
pub(super) fn start(file: &RobotFile) -> Springs {
    file.springs.clone().unwrap_or_else(|| {
        let of = |kind| START[usize::from(kind == JointKind::Prismatic)];
        Springs::linear(&file.robot.joints.iter().map(|joint| of(joint.kind)).collect::<Vec<f64>>())
    })
}

/// Why springs with these residuals are none to work with.
fn withheld(chi_square: f64, trusted: Method, lost_motion: f64) -> Option<Withheld> {
    let residual = chi_square.sqrt();
    match trusted {
        Method::Cartesian(_) => Some(Withheld::OtherMethod { method: trusted, residual }),
        Method::JointSprings if lost_motion > LOST => Some(Withheld::LostMotion { share: lost_motion }),
        Method::JointSprings => (chi_square > WRONG).then_some(Withheld::Misfit { residual }),
    }
}

/// All measurements that can be predicted; `outliers` are those (from 0) that were left out.
fn predictions(
    set: &MeasurementSet,
    outliers: &[usize],
    predict: impl Fn(&Measurement) -> Option<Twist>,
) -> Vec<PredictedTranslation> {
    let pair = |(i, m): (usize, &Measurement)| {
        let (predicted, measured) = (halves(&predict(m)?).0, halves(&m.displacement).0);
        Some(PredictedTranslation { measured, predicted, outlier: outliers.contains(&i) })
    };
    set.measurements().iter().enumerate().filter_map(pair).collect()
}
