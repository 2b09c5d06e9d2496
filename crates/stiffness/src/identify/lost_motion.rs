//! Why a compensation gains less than it might: what no linear spring explains.

use crate::compensate::CompensationError;
use crate::compliance::{Deformation, JointSpring, Springs};
use crate::error::check_finite;
use crate::robot::{Kinematics, Robot, Wrench};
use nalgebra::{DMatrix, DVector, Vector3};

/// Samples for each number that is fitted.
const SAMPLES_PER_NUMBER: usize = 4;
/// Torques of engagement that are tried for a joint, from its largest torque down to a hundredth of it.
const TRIED_TORQUES: usize = 25;
const SMALLEST_TORQUE: f64 = 0.01;
/// Share of what is left (squares) that lost motion in one more joint has to explain, and of what linear springs leave.
const LEAST_GAIN: f64 = 0.15;
const LEAST_SHARE: f64 = 0.02;
/// Standard deviation of the relative error of a stiffness, for those that the samples do not determine.
const PRIOR_DEVIATION: f64 = 0.3;

/// What a tool point did under a load.
#[derive(Clone, Debug, PartialEq)]
pub struct ResidualSample {
    /// Measured coordinates of the joints (rad).
    pub coordinates: Vec<f64>,
    /// Wrench on the robot at the tool point, in base axes.
    pub wrench: Wrench,
    /// Measured displacement of the tool point (m, base axes).
    pub displacement: Vector3<f64>,
}

/// Lost motion found in a joint.
#[derive(Clone, Debug, PartialEq)]
pub struct LostMotion {
    /// Number of the joint, from 1.
    pub joint: usize,
    /// Lost motion from flank to flank (rad).
    pub gap: f64,
    /// Torque from which on the flanks are engaged (N·m).
    pub engaged: f64,
    /// How often the torque changes its sign along the samples.
    pub reversals: usize,
    /// Share of the unexplained squared residual that it explains.
    pub share: f64,
}

/// What is left of measured displacements, and why.
#[derive(Clone, Debug, PartialEq)]
pub struct LostMotionReport {
    /// Root mean square of measured less modeled displacement (m).
    pub residual: f64,
    /// The same after the best change of all joint stiffnesses.
    pub linear: f64,
    /// The same after lost motion has been fitted too.
    pub nonlinear: f64,
    /// Lost motion by joint, the most important first; empty where linear springs are enough.
    pub lost_motion: Vec<LostMotion>,
    /// The springs that were fitted.
    pub springs: Springs,
}

impl LostMotionReport {
    /// Share of the residual (root mean square) that no joint stiffness explains.
    pub fn unexplained(&self) -> f64 {
        if self.residual > 0.0 { self.linear / self.residual } else { 0.0 }
    }
}

/// Explains displacements that a model gets wrong, first by other joint stiffnesses, then by lost motion in joints whose torque changes
/// its sign, one joint after the other as long as each explains a good part of the rest (forward selection by least squares).
///
/// # Errors
/// [`CompensationError`] for samples that do not fit the robot, or too few of them.
pub fn explain_residual(
    robot: &Robot,
    springs: &Springs,
    samples: &[ResidualSample],
) -> Result<LostMotionReport, CompensationError> {
    let joints = robot.joints.len();
    springs.check(joints)?;
    let needed = SAMPLES_PER_NUMBER * 3 * joints;
    if samples.len() < needed {
        return Err(CompensationError::TooFew { found: samples.len(), needed });
    }
    let data = Regression::new(robot, springs, samples)?;
    let linear = data.solve(&[]);
    let mut chosen: Vec<Term> = Vec::new();
    let mut best = linear.clone();
    let mut shares = Vec::new();
    while let Some((term, solution)) = data.next_term(&chosen) {
        let gained = (best.squares - solution.squares) / linear.squares;
        if solution.squares > (1.0 - LEAST_GAIN) * best.squares || gained < LEAST_SHARE {
            break;
        }
        chosen.push(term);
        shares.push(gained);
        best = solution;
        best = data.refine(&mut chosen, best);
    }
    let regular = data.regularized(&chosen, best.squares);
    let rms = |squares: f64| (squares / samples.len() as f64).sqrt();
    // A compliance that all but vanishes in the fit is not believed.
    let factors: Vec<f64> = (0..joints).map(|i| 1.0 / (1.0 + regular[i]).max(0.1)).collect();
    let mut fitted = springs.scaled(&factors);
    let mut lost_motion = Vec::new();
    for (j, (term, share)) in chosen.iter().zip(shares).enumerate() {
        let gap = regular[joints + j];
        if let JointSpring::Linear { stiffness } = fitted.joints[term.joint] {
            fitted.joints[term.joint] = JointSpring::Backlash { stiffness, gap, engaged: term.engaged };
        }
        lost_motion.push(LostMotion {
            joint: term.joint + 1,
            gap,
            engaged: term.engaged,
            reversals: data.reversals(term.joint),
            share,
        });
    }
    Ok(LostMotionReport {
        residual: rms(data.residual.norm_squared()),
        linear: rms(linear.squares),
        nonlinear: rms(best.squares),
        lost_motion,
        springs: fitted,
    })
}

/// Lost motion in a joint that engages at a torque.
#[derive(Clone, Copy, Debug)]
struct Term {
    joint: usize,
    engaged: f64,
}

#[derive(Clone, Debug)]
struct Solution {
    x: DVector<f64>,
    squares: f64,
}

/// Residual displacements and what they depend on, three rows for each sample.
struct Regression {
    residual: DVector<f64>,
    /// Displacement per relative change of each joint's compliance.
    linear: DMatrix<f64>,
    /// Displacement per rad of each joint.
    columns: DMatrix<f64>,
    /// Torque of each joint (columns) at each sample (rows).
    torques: DMatrix<f64>,
    /// Joints that may get lost motion.
    candidates: Vec<usize>,
}

impl Regression {
    fn new(robot: &Robot, springs: &Springs, samples: &[ResidualSample]) -> Result<Self, CompensationError> {
        let joints = robot.joints.len();
        let mut data = Self {
            residual: DVector::zeros(3 * samples.len()),
            linear: DMatrix::zeros(3 * samples.len(), joints),
            columns: DMatrix::zeros(3 * samples.len(), joints),
            torques: DMatrix::zeros(samples.len(), joints),
            candidates: Vec::new(),
        };
        for (k, sample) in samples.iter().enumerate() {
            let bent = Deformation::equilibrium(robot, springs, &sample.coordinates, &sample.wrench)?;
            let loaded: Vec<f64> = sample.coordinates.iter().zip(&bent.deflections).map(|(q, d)| q + d).collect();
            let kinematics = Kinematics::new(robot, &loaded)?;
            let residual = sample.displacement - bent.tool.fixed_rows::<3>(0);
            data.residual.fixed_rows_mut::<3>(3 * k).copy_from(&residual);
            for i in 0..joints {
                let torque = kinematics.torque(i, &sample.wrench);
                let column = kinematics.jacobian().fixed_view::<3, 1>(0, i);
                data.torques[(k, i)] = torque;
                data.columns.fixed_view_mut::<3, 1>(3 * k, i).copy_from(&column);
                let yielded = column * (torque / springs.joints[i].stiffness());
                data.linear.fixed_view_mut::<3, 1>(3 * k, i).copy_from(&yielded);
            }
        }
        check_finite("a measured displacement", &data.residual)?;
        let changes_sign = |i: usize| data.reversals(i) > 0;
        let is_linear = |i: usize| matches!(springs.joints[i], JointSpring::Linear { .. });
        data.candidates = (0..joints).filter(|i| changes_sign(*i) && is_linear(*i)).collect();
        Ok(data)
    }

    /// How often the torque of a joint changes its sign.
    fn reversals(&self, joint: usize) -> usize {
        let torques = self.torques.column(joint);
        torques.as_slice().windows(2).filter(|pair| pair[0] * pair[1] < 0.0).count()
    }

    fn design(&self, terms: &[Term]) -> DMatrix<f64> {
        let joints = self.linear.ncols();
        let mut design = self.linear.clone().resize_horizontally(joints + terms.len(), 0.0);
        for (j, term) in terms.iter().enumerate() {
            for row in 0..design.nrows() {
                let torque = self.torques[(row / 3, term.joint)];
                design[(row, joints + j)] =
                    0.5 * self.columns[(row, term.joint)] * (torque / term.engaged).clamp(-1.0, 1.0);
            }
        }
        design
    }

    /// Normal equations with a penalty on each number.
    fn penalized(&self, design: &DMatrix<f64>, penalty: impl Fn(usize) -> f64) -> DVector<f64> {
        let mut gram = design.transpose() * design;
        let size = gram.trace().max(f64::MIN_POSITIVE);
        for i in 0..gram.nrows() {
            gram[(i, i)] += penalty(i) + 1e-14 * size;
        }
        let right = design.transpose() * &self.residual;
        gram.cholesky().map_or_else(|| DVector::zeros(right.len()), |factor| factor.solve(&right))
    }

    fn solve(&self, terms: &[Term]) -> Solution {
        let design = self.design(terms);
        let x = self.penalized(&design, |_| 0.0);
        let squares = (&self.residual - design * &x).norm_squared();
        Solution { x, squares }
    }

    /// The numbers where stiffnesses that the samples do not determine stay near what they were.
    fn regularized(&self, terms: &[Term], squares: f64) -> DVector<f64> {
        let joints = self.linear.ncols();
        let variance = squares / self.residual.len() as f64;
        let penalty = |i: usize| if i < joints { variance / (PRIOR_DEVIATION * PRIOR_DEVIATION) } else { 0.0 };
        self.penalized(&self.design(terms), penalty)
    }

    fn tried(&self, joint: usize) -> impl Iterator<Item = f64> {
        let largest = self.torques.column(joint).amax();
        (0..TRIED_TORQUES)
            .map(move |k| largest * SMALLEST_TORQUE.powf(k as f64 / (TRIED_TORQUES - 1) as f64))
            .filter(|t| *t > 0.0)
    }

    /// The joint whose lost motion explains most of the rest.
    fn next_term(&self, chosen: &[Term]) -> Option<(Term, Solution)> {
        let mut best: Option<(Term, Solution)> = None;
        for joint in self.candidates.iter().copied().filter(|i| chosen.iter().all(|t| t.joint != *i)) {
            for engaged in self.tried(joint) {
                let term = Term { joint, engaged };
                let terms: Vec<Term> = chosen.iter().copied().chain([term]).collect();
                let solution = self.solve(&terms);
                let positive = solution.x.rows(self.linear.ncols(), terms.len()).iter().all(|gap| *gap > 0.0);
                if positive && best.as_ref().is_none_or(|(_, b)| solution.squares < b.squares) {
                    best = Some((term, solution));
                }
            }
        }
        best
    }

    /// Moves each torque of engagement to where the residual is least, the others held.
    fn refine(&self, terms: &mut [Term], mut best: Solution) -> Solution {
        let mut width = SMALLEST_TORQUE.powf(-1.0 / (TRIED_TORQUES - 1) as f64);
        for _ in 0..5 {
            for i in 0..terms.len() {
                for factor in [1.0 / width, width] {
                    let held = terms[i].engaged;
                    terms[i].engaged = held * factor;
                    let solution = self.solve(terms);
                    let positive = solution.x.rows(self.linear.ncols(), terms.len()).iter().all(|gap| *gap > 0.0);
                    if positive && solution.squares < best.squares {
                        best = solution;
                    } else {
                        terms[i].engaged = held;
                    }
                }
            }
            width = width.sqrt();
        }
        best
    }
}
