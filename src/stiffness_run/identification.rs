//! Springs and stiffnesses of a robot from a table of measurements.

use std::fmt;
use std::path::Path;

use bracketry_stiffness::{
    Comparison, Deformation, Found, Identified, JointKind, Measurement, MeasurementNoise, MeasurementSet, Method,
    Outliers, RobotFile, SpringFitSettings, Springs, Twist, Wrench, compare,
};
use bracketry_system::{Columns, Entries};
use nalgebra::Matrix6;
use serde::Serialize;

use super::StiffnessRunError;
use super::log::{WRENCH, check_coordinates, check_joints, joint_names, rows};

/// Columns of a displacement.
const TWIST: [&str; 6] = ["dx", "dy", "dz", "rx", "ry", "rz"];
/// Stiffness to start from where the robot file has none: revolute (N·m/rad), prismatic (N/m).
const START: [f64; 2] = [1e6, 1e8];

/// Mean square of the residuals of springs, in units of their noise, from which on they are no springs to work with: twice the noise.
const WRONG: f64 = 4.0;

/// How a method did.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MethodSummary {
    /// Its name.
    pub method: String,
    /// Error of the prediction of held-out displacements in units of their noise; absent where it does not apply.
    pub held_out: Option<f64>,
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

/// An identification.
#[derive(Clone, Debug, Serialize)]
pub struct Identification {
    /// Name of the robot.
    pub robot: String,
    /// Measurements of the table.
    pub measurements: usize,
    /// Lines of the table that were left out as outliers.
    pub outliers: Vec<u64>,
    /// The method to trust.
    pub trusted: String,
    /// Why, and what is wrong with the others that work.
    pub reasons: Vec<String>,
    /// All methods.
    pub methods: Vec<MethodSummary>,
    /// Numbers of the joints' springs.
    pub parameters: Vec<ParameterSummary>,
    /// Compliance at the tool point in base axes (m/N, rad/(N·m)) where the measurements are of one pose: symmetric positive definite.
    pub compliance: Option<[[f64; 6]; 6]>,
    /// The springs, where the data tell all of them and they explain the data.
    #[serde(skip)]
    pub springs: Option<Springs>,
    /// Why the springs that were found are none to work with.
    pub withheld: Option<String>,
    /// Measured and predicted translations (m) of the trusted method, x, y and z in turn.
    #[serde(skip)]
    pub predictions: Vec<[f64; 2]>,
}

impl Identification {
    /// Identifies from a table with the columns `q1 … qn` (rad), `Fx … Mz` (N, N·m on the robot at the tool point, base axes) and
    /// `dx, dy, dz, rx, ry, rz` (m, rad).
    ///
    /// # Errors
    /// [`StiffnessRunError`] for a table that does not fit, numbers in other units, and data that tell nothing.
    pub fn new(file: &RobotFile, table: &Path, outliers: Outliers) -> Result<Self, StiffnessRunError> {
        let robot = &file.robot;
        let doc = Columns::document(table, "name a CSV file: a table with the columns q1 …, Fx … Mz, dx … rz")?;
        let columns = Columns::parse(&doc, |_| Entries::Finite)?;
        let q = joint_names("q", robot);
        check_joints(&doc, &columns, robot, "q")?;
        let coordinates = rows(&doc, &columns, &q)?;
        check_coordinates(&doc, &columns, robot, &q)?;
        let wrenches = rows(&doc, &columns, &WRENCH.map(str::to_owned))?;
        let twists = rows(&doc, &columns, &TWIST.map(str::to_owned))?;
        let together = coordinates.into_iter().zip(wrenches).zip(twists);
        let measurements: Vec<Measurement> = together
            .map(|((q, wrench), twist)| Measurement {
                q,
                wrench: Wrench::from_row_slice(&wrench),
                displacement: Twist::from_row_slice(&twist),
            })
            .collect();
        let noise = &file.noise;
        let noise = MeasurementNoise::from_std(noise.translation, noise.rotation, noise.force, noise.moment);
        let place = |why| StiffnessRunError::Identification { file: table.display().to_string(), why };
        let set = MeasurementSet::new(measurements, noise).map_err(place)?;
        let start = file.springs.clone().unwrap_or_else(|| {
            let of = |kind| START[usize::from(kind == JointKind::Prismatic)];
            Springs::linear(&robot.joints.iter().map(|joint| of(joint.kind)).collect::<Vec<f64>>())
        });
        let comparison =
            compare(&set, Some((robot, &start, &SpringFitSettings::default())), outliers).map_err(place)?;
        let mut identification = Self {
            robot: robot.name.clone(),
            measurements: set.len(),
            outliers: comparison.outliers.iter().filter_map(|i| columns.lines.get(*i).copied()).collect(),
            trusted: comparison.trusted.to_string(),
            reasons: Vec::new(),
            methods: Vec::new(),
            parameters: Vec::new(),
            compliance: None,
            springs: None,
            withheld: None,
            predictions: Vec::new(),
        };
        identification.take(file, &set, &comparison);
        Ok(identification)
    }

    /// Takes over what each method found.
    fn take(&mut self, file: &RobotFile, set: &MeasurementSet, comparison: &Comparison) {
        // Why a method does not apply stands with the method.
        let failed = |reason: &String| {
            let mut methods = comparison.methods.iter().filter(|(_, report)| report.is_err());
            methods.any(|(method, _)| reason.starts_with(&format!("{method}: ")))
        };
        self.reasons = comparison.reasons.iter().filter(|reason| !failed(reason)).cloned().collect();
        for (method, report) in &comparison.methods {
            self.methods.push(MethodSummary {
                method: method.to_string(),
                held_out: report.as_ref().ok().map(|r| r.held_out),
                failed: report.as_ref().err().map(ToString::to_string),
            });
            let Ok(report) = report else { continue };
            match &report.found {
                Found::Cartesian(estimate) => {
                    if *method == comparison.trusted {
                        let predict = |m: &Measurement| Some(estimate.compliance * m.wrench);
                        self.predictions = predictions(set, predict);
                    }
                    let positive = bracketry_stiffness::CartesianEstimator::PositiveDefinite;
                    if *method == Method::Cartesian(positive) {
                        self.compliance = Some(entries(&estimate.compliance));
                    }
                }
                Found::Springs(fit) => {
                    self.parameters = fit.parameters.iter().map(summary).collect();
                    let trusted = *method == comparison.trusted;
                    let found = fit.springs().ok();
                    self.withheld = found.and_then(|_| withheld(fit.chi_square, trusted, &self.trusted));
                    if self.withheld.is_none() {
                        self.springs = found.cloned();
                    }
                    if let (true, Some(springs)) = (trusted, found) {
                        let predict = |m: &Measurement| {
                            Some(Deformation::equilibrium(&file.robot, springs, &m.q, &m.wrench).ok()?.tool)
                        };
                        self.predictions = predictions(set, predict);
                    }
                }
            }
        }
    }
}

/// Why springs with these residuals are not written.
fn withheld(chi_square: f64, trusted: bool, other: &str) -> Option<String> {
    let off = chi_square.sqrt();
    if !trusted {
        return Some(format!(
            "{other} predicts better than the springs of the joints, which leave {off:.1} σ: something else yields too"
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

fn predictions(set: &MeasurementSet, predict: impl Fn(&Measurement) -> Option<Twist>) -> Vec<[f64; 2]> {
    let pairs = |m: &Measurement| {
        let predicted = predict(m)?;
        Some([0, 1, 2].map(|i| [m.displacement[i], predicted[i]]))
    };
    set.measurements().iter().filter_map(pairs).flatten().collect()
}

fn entries(matrix: &Matrix6<f64>) -> [[f64; 6]; 6] {
    std::array::from_fn(|i| std::array::from_fn(|j| matrix[(i, j)]))
}

impl fmt::Display for Identification {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}: {} measurements", self.robot, self.measurements)?;
        if !self.outliers.is_empty() {
            let lines: Vec<String> = self.outliers.iter().map(ToString::to_string).collect();
            writeln!(f, "left out as outliers: lines {}", lines.join(", "))?;
        }
        writeln!(f, "\n{:24} error of prediction [σ]", "method")?;
        for method in &self.methods {
            match method.held_out {
                Some(error) => writeln!(f, "{:24} {error:.3}", method.method)?,
                None => writeln!(f, "{:24} –", method.method)?,
            }
        }
        writeln!(f)?;
        self.reasons.iter().try_for_each(|reason| writeln!(f, "{reason}"))?;
        let mut told: Vec<&str> = Vec::new();
        for why in self.methods.iter().filter_map(|method| method.failed.as_deref()) {
            if !told.contains(&why) {
                told.push(why);
                let alike = self.methods.iter().filter(|method| method.failed.as_deref() == Some(why));
                let alike: Vec<&str> = alike.map(|method| method.method.as_str()).collect();
                writeln!(f, "{}: does not apply, {why}", alike.join("; "))?;
            }
        }
        if !self.parameters.is_empty() {
            writeln!(f, "\nsprings of the joints (N·m/rad, N·m/rad³, rad, N·m), 95 % interval")?;
        }
        for p in &self.parameters {
            match (p.value, &p.why) {
                (Some([value, low, high]), _) => {
                    writeln!(f, "joint {} {:10} {value:.4e}  ({low:.4e} … {high:.4e})", p.joint, p.name)?;
                }
                (None, why) => {
                    let why = why.as_deref().unwrap_or("unknown");
                    writeln!(f, "joint {} {:10} not identified: {why}", p.joint, p.name)?;
                }
            }
        }
        if let Some(why) = &self.withheld {
            writeln!(f, "these springs are not written, and their intervals do not hold: {why}")?;
        } else if !self.parameters.is_empty() {
            writeln!(f, "the intervals hold as far as the model does")?;
        }
        if let Some(compliance) = &self.compliance {
            writeln!(f, "\ncompliance at the tool point, base axes [µm, µrad per N, N·m]")?;
            for row in compliance {
                let row: Vec<String> = row.iter().map(|c| format!("{:9.4}", 1e6 * c)).collect();
                writeln!(f, "{}", row.join(" "))?;
            }
        }
        Ok(())
    }
}
