//! Springs and stiffnesses of a robot from a table of measurements.

use std::path::Path;

use bracketry_stiffness::{
    CartesianEstimate, CartesianEstimator, Comparison, Deformation, Found, IdentificationError, Identified, JointKind,
    Measurement, MeasurementNoise, MeasurementSet, Method, Outliers, RobotFile, SpringFit, SpringFitSettings, Springs,
    Twist, compare,
};
use bracketry_system::{Columns, Document};
use nalgebra::Matrix6;
use serde::Serialize;

use super::StiffnessRunError;
use super::log::{CoordinatesAndWrenches, rows};
use super::unexplained::Unexplained;

/// Columns of a displacement.
pub(super) const TWIST: [&str; 6] = ["dx", "dy", "dz", "rx", "ry", "rz"];
/// Stiffness to start from where the robot file has none: revolute (N·m/rad), prismatic (N/m).
const START: [f64; 2] = [1e6, 1e8];

/// Mean square of the residuals of springs, in units of their noise, from which on they are no springs to work with: twice the noise.
const WRONG: f64 = 4.0;

/// Share of what linear springs leave, squared, from which on lost motion that explains it makes them none to work with.
const LOST: f64 = 0.5;

/// How a method did.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MethodSummary {
    /// Its name.
    pub method: String,
    /// Error of the prediction of held-out displacements in units of their noise; absent where it does not apply, as all that follows.
    pub held_out: Option<f64>,
    /// Ratio of the largest to the smallest: of the loads over all directions in units of their noise (for W on ΔX of the displacements), for
    /// joint springs of the standard deviations of combinations of their logarithms.
    pub condition: Option<f64>,
    /// χ² per degree of freedom: mean square of the residuals of displacements in units of their noise.
    pub chi_square: Option<f64>,
    /// Why it does not apply.
    pub failed: Option<String>,
}

/// What is known of a number of a joint's spring.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ParameterSummary {
    /// Joint, from 1.
    pub joint: usize,
    /// `stiffness`, `cubic`, `gap` or `engaged`.
    pub name: String,
    /// Its value (N·m/rad, N·m/rad³, rad, N·m) with the ends of its 95 % interval; absent where the data do not tell it.
    pub value: Option<[f64; 3]>,
    /// Why the data do not tell it.
    pub why: Option<String>,
}

/// The measured translation of the tool point and its prediction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PredictedTranslation {
    /// Measured (m, base axes).
    pub measured: [f64; 3],
    /// Predicted.
    pub predicted: [f64; 3],
    /// Whether the measurement was left out as an outlier.
    pub outlier: bool,
}

/// An identification.
#[derive(Clone, Debug, Serialize)]
pub struct Identification {
    /// Name of the robot.
    pub robot: String,
    /// Measurements of the table.
    pub measurements: usize,
    /// Lines of the table that were left out as outliers.
    pub outliers: Vec<u64>,
    /// Why none were left out although that was asked for.
    pub outliers_kept: Option<String>,
    /// The method to trust.
    pub trusted: String,
    /// Why, and what is wrong with the others that work.
    pub reasons: Vec<String>,
    /// All methods.
    pub methods: Vec<MethodSummary>,
    /// Numbers of the joints' springs.
    pub parameters: Vec<ParameterSummary>,
    /// What of the measured translations joint springs do not explain; absent where there are none.
    pub unexplained: Option<Unexplained>,
    /// Compliance at the tool point in base axes (m/N, m/(N·m); rad/N, rad/(N·m)) where the measurements are of one pose: symmetric positive definite.
    pub compliance: Option<[[f64; 6]; 6]>,
    /// Ends of the 95 % intervals of its entries.
    pub compliance_interval: Option<[[[f64; 2]; 6]; 6]>,
    /// Its inverse, the stiffness (N/m, N/rad; N·m/m, N·m/rad).
    pub stiffness: Option<[[f64; 6]; 6]>,
    /// Ends of the 95 % intervals of its entries.
    pub stiffness_interval: Option<[[[f64; 2]; 6]; 6]>,
    /// The springs, where the data tell all of them and they explain the data.
    #[serde(skip)]
    pub springs: Option<Springs>,
    /// Why the springs that were found are none to work with.
    pub withheld: Option<String>,
    /// Measured and predicted translations of the trusted method.
    #[serde(skip)]
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
        let twists = rows(doc, &read.columns, &TWIST.map(str::to_owned))?;
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
        let told = |comparison: &Comparison| {
            let mut identification = Self::empty(file, &set, comparison, lines);
            identification.take(file, &set, comparison, lines);
            identification
        };
        match compared(outliers) {
            Ok(comparison) => Ok(told(&comparison)),
            // Lost motion in a joint contradicts linear springs in most measurements: that is worth more than the refusal.
            Err(why @ IdentificationError::TooManyOutliers { .. }) if outliers == Outliers::Reject => {
                let kept = compared(Outliers::Keep).ok().map(|comparison| told(&comparison));
                let named = |found: &Self| found.unexplained.as_ref().is_some_and(|rest| !rest.lost_motion.is_empty());
                match kept.filter(named) {
                    Some(found) => Ok(Self { outliers_kept: Some(why.to_string()), ..found }),
                    None => Err(place(why)),
                }
            }
            Err(why) => Err(place(why)),
        }
    }

    /// A report without results.
    fn empty(file: &RobotFile, set: &MeasurementSet, comparison: &Comparison, lines: &[u64]) -> Self {
        Self {
            robot: file.robot.name.clone(),
            measurements: set.len(),
            outliers: comparison.outliers.iter().filter_map(|i| lines.get(*i).copied()).collect(),
            outliers_kept: None,
            trusted: comparison.trusted.to_string(),
            reasons: Vec::new(),
            methods: Vec::new(),
            parameters: Vec::new(),
            unexplained: None,
            compliance: None,
            compliance_interval: None,
            stiffness: None,
            stiffness_interval: None,
            springs: None,
            withheld: None,
            predictions: Vec::new(),
        }
    }

    /// Takes over what each method found.
    fn take(&mut self, file: &RobotFile, set: &MeasurementSet, comparison: &Comparison, lines: &[u64]) {
        // Why a method does not apply stands with the method.
        let failed = |reason: &String| {
            let mut methods = comparison.methods.iter().filter(|(_, report)| report.is_err());
            methods.any(|(method, _)| reason.starts_with(&format!("{method}: ")))
        };
        self.reasons = comparison.reasons.iter().filter(|reason| !failed(reason)).cloned().collect();
        for (method, report) in &comparison.methods {
            let working = report.as_ref().ok();
            self.methods.push(MethodSummary {
                method: method.to_string(),
                held_out: working.map(|r| r.held_out),
                condition: working.map(|r| r.found.condition()),
                chi_square: working.map(|r| r.found.chi_square()),
                failed: report.as_ref().err().map(|why| why.clone().in_file(lines).to_string()),
            });
            let Some(report) = working else { continue };
            let trusted = *method == comparison.trusted;
            match &report.found {
                Found::Cartesian(estimate) => {
                    if trusted {
                        let predict = |m: &Measurement| Some(estimate.compliance * m.wrench);
                        self.predictions = predictions(set, &comparison.outliers, predict);
                    }
                    if *method == Method::Cartesian(CartesianEstimator::PositiveDefinite) {
                        self.take_cartesian(estimate);
                    }
                }
                Found::Springs(fit) => self.take_springs(file, set, comparison, fit, lines),
            }
        }
    }

    fn take_cartesian(&mut self, estimate: &CartesianEstimate) {
        let intervals = |of: &dyn Fn(usize, usize) -> (f64, f64)| {
            std::array::from_fn(|i| std::array::from_fn(|j| <[f64; 2]>::from(of(i, j))))
        };
        self.compliance = Some(entries(&estimate.compliance));
        self.compliance_interval = Some(intervals(&|i, j| estimate.compliance_interval(i, j)));
        self.stiffness = Some(entries(&estimate.stiffness));
        self.stiffness_interval = Some(intervals(&|i, j| estimate.stiffness_interval(i, j)));
    }

    fn take_springs(
        &mut self,
        file: &RobotFile,
        set: &MeasurementSet,
        comparison: &Comparison,
        fit: &SpringFit,
        lines: &[u64],
    ) {
        self.parameters = fit.parameters.iter().map(summary).collect();
        let trusted = comparison.trusted == Method::JointSprings;
        let springs = fit.fitted();
        let predict =
            |m: &Measurement| Some(Deformation::equilibrium(&file.robot, springs, &m.q, &m.wrench).ok()?.tool);
        let predicted = predictions(set, &comparison.outliers, predict);
        self.unexplained = Unexplained::new(&file.robot, springs, set, &comparison.outliers, &predicted, lines);
        let lost_motion = self.unexplained.as_ref().map_or(0.0, Unexplained::by_lost_motion);
        self.withheld = withheld(fit.chi_square, trusted, &self.trusted, lost_motion);
        self.springs = fit.springs().ok().filter(|_| self.withheld.is_none()).cloned();
        if trusted {
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

/// Why springs with these residuals are not written.
fn withheld(chi_square: f64, trusted: bool, other: &str, lost_motion: f64) -> Option<String> {
    let off = chi_square.sqrt();
    if !trusted {
        return Some(format!(
            "{other} predicts better than the springs of the joints, which leave {off:.1} σ: something else yields too"
        ));
    }
    if lost_motion > LOST {
        let share = 100.0 * lost_motion;
        return Some(format!(
            "lost motion in joints explains {share:.0} % of what they leave: start from it, as told below"
        ));
    }
    (chi_square > WRONG).then(|| {
        format!(
            "they leave {off:.1} σ of noise: give a joint `gap` and `engaged` or `cubic` to start from, or raise [noise] if the \
             measurements are that noisy"
        )
    })
}

fn summary(parameter: &bracketry_stiffness::SpringParameter) -> ParameterSummary {
    let (value, why) = match &parameter.identified {
        Identified::Yes { value, low, high } => (Some([*value, *low, *high]), None),
        Identified::No { why, .. } => (None, Some(why.clone())),
    };
    ParameterSummary { joint: parameter.joint, name: parameter.name.to_owned(), value, why }
}

/// All measurements that can be predicted; `outliers` are those (from 0) that were left out.
fn predictions(
    set: &MeasurementSet,
    outliers: &[usize],
    predict: impl Fn(&Measurement) -> Option<Twist>,
) -> Vec<PredictedTranslation> {
    let translation = |twist: &Twist| [twist[0], twist[1], twist[2]];
    let pair = |(i, m): (usize, &Measurement)| {
        let predicted = translation(&predict(m)?);
        let measured = translation(&m.displacement);
        Some(PredictedTranslation { measured, predicted, outlier: outliers.contains(&i) })
    };
    set.measurements().iter().enumerate().filter_map(pair).collect()
}

fn entries(matrix: &Matrix6<f64>) -> [[f64; 6]; 6] {
    std::array::from_fn(|i| std::array::from_fn(|j| matrix[(i, j)]))
}
