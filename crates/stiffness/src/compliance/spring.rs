//! Springs: of joints, and of what lies between them.

use crate::error::{StiffnessError, check_finite};
use nalgebra::Matrix6;

/// How a joint yields to a torque.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum JointSpring {
    /// `τ = k δ`.
    Linear {
        /// k in N·m/rad (N/m for a prismatic joint).
        stiffness: f64,
    },
    /// `τ = k δ + c δ³`: a gear that grows stiffer under load.
    Stiffening {
        /// k in N·m/rad.
        stiffness: f64,
        /// c in N·m/rad³, not negative.
        cubic: f64,
    },
    /// `δ = τ/k + gap/2 · sat(τ/engaged)`: lost motion. Below the torque at which the flanks are engaged the joint is soft, and
    /// it moves by `gap` more when the torque changes its sign.
    Backlash {
        /// k in N·m/rad once the flanks are engaged.
        stiffness: f64,
        /// Lost motion from flank to flank in rad, not negative.
        gap: f64,
        /// Torque in N·m from which on the flanks are engaged.
        engaged: f64,
    },
}

impl JointSpring {
    /// A linear spring, k in N·m/rad.
    pub fn linear(stiffness: f64) -> Self {
        Self::Linear { stiffness }
    }

    /// The deflection (rad) under a torque (N·m).
    pub fn deflection(&self, torque: f64) -> f64 {
        match *self {
            Self::Linear { stiffness } => torque / stiffness,
            Self::Stiffening { stiffness, cubic } => cubic_root(stiffness, cubic, torque),
            Self::Backlash { stiffness, gap, engaged } => {
                torque / stiffness + 0.5 * gap * (torque / engaged).clamp(-1.0, 1.0)
            }
        }
    }

    /// The tangent compliance dδ/dτ (rad/(N·m)) under a torque.
    pub fn compliance(&self, torque: f64) -> f64 {
        match *self {
            Self::Linear { stiffness } => 1.0 / stiffness,
            Self::Stiffening { stiffness, cubic } => {
                let deflection = cubic_root(stiffness, cubic, torque);
                1.0 / (stiffness + 3.0 * cubic * deflection * deflection)
            }
            Self::Backlash { stiffness, gap, engaged } => {
                1.0 / stiffness + if torque.abs() < engaged { 0.5 * gap / engaged } else { 0.0 }
            }
        }
    }

    /// k in N·m/rad (N/m for a prismatic joint).
    pub fn stiffness(&self) -> f64 {
        let (Self::Linear { stiffness } | Self::Stiffening { stiffness, .. } | Self::Backlash { stiffness, .. }) = self;
        *stiffness
    }

    pub(crate) fn stiffness_mut(&mut self) -> &mut f64 {
        let (Self::Linear { stiffness } | Self::Stiffening { stiffness, .. } | Self::Backlash { stiffness, .. }) = self;
        stiffness
    }

    /// Its parameters by the names of the robot file, the stiffness first: `stiffness`, `cubic`, `gap`, `engaged`.
    pub fn parameters(&self) -> Vec<(&'static str, f64)> {
        let mut spring = *self;
        spring.parameters_mut().into_iter().map(|(name, value)| (name, *value)).collect()
    }

    pub(crate) fn parameters_mut(&mut self) -> Vec<(&'static str, &mut f64)> {
        match self {
            Self::Linear { stiffness } => vec![("stiffness", stiffness)],
            Self::Stiffening { stiffness, cubic } => vec![("stiffness", stiffness), ("cubic", cubic)],
            Self::Backlash { stiffness, gap, engaged } => {
                vec![("stiffness", stiffness), ("gap", gap), ("engaged", engaged)]
            }
        }
    }

    /// Refuses springs that are none.
    fn check(&self, joint: usize) -> Result<(), StiffnessError> {
        let positive = |what, value: f64| {
            let holds = value.is_finite() && value > 0.0;
            holds.then_some(()).ok_or(StiffnessError::NotPositive { joint, what, value })
        };
        let not_negative = |what, value: f64| if value == 0.0 { Ok(()) } else { positive(what, value) };
        positive("the stiffness", self.stiffness())?;
        match *self {
            Self::Linear { .. } => Ok(()),
            Self::Stiffening { cubic, .. } => not_negative("the cubic stiffness", cubic),
            Self::Backlash { gap, engaged, .. } => {
                not_negative("the gap", gap)?;
                positive("the engagement torque", engaged)
            }
        }
    }
}

/// The real solution of k δ + c δ³ = τ, k > 0, c ≥ 0, by Newton's method: the function is convex where it is positive, and the
/// start lies beyond the solution, from where the steps come down to it without overshooting.
fn cubic_root(k: f64, c: f64, torque: f64) -> f64 {
    let load = torque.abs();
    let mut x = load / k;
    if c > 0.0 {
        x = x.min((load / c).cbrt());
        for _ in 0..60 {
            let step = (k * x + c * x * x * x - load) / (k + 3.0 * c * x * x);
            x -= step;
            if step.abs() <= f64::EPSILON * x {
                break;
            }
        }
    }
    x.copysign(torque)
}

/// All springs of a robot.
#[derive(Clone, Debug, PartialEq)]
pub struct Springs {
    /// One for each joint.
    pub joints: Vec<JointSpring>,
    /// Compliance of the link behind each joint (and of the bearings of the joint across its axis), at the joint's frame, in its
    /// axes: twist per wrench. Empty where all links are rigid.
    pub links: Vec<Matrix6<f64>>,
}

impl Springs {
    /// Springs in the joints, rigid links.
    pub fn of_joints(joints: Vec<JointSpring>) -> Self {
        Self { joints, links: Vec::new() }
    }

    /// Linear springs in the joints (N·m/rad), rigid links.
    pub fn linear(stiffnesses: &[f64]) -> Self {
        Self::of_joints(stiffnesses.iter().map(|k| JointSpring::linear(*k)).collect())
    }

    /// The springs with compliant links, one 6 × 6 compliance for each joint.
    #[must_use]
    pub fn with_links(mut self, links: Vec<Matrix6<f64>>) -> Self {
        self.links = links;
        self
    }

    /// The springs with the stiffness of each joint multiplied by its factor; joints without one keep theirs.
    #[must_use]
    pub fn scaled(&self, factors: &[f64]) -> Self {
        let mut scaled = self.clone();
        for (spring, factor) in scaled.joints.iter_mut().zip(factors) {
            *spring.stiffness_mut() *= factor;
        }
        scaled
    }

    pub(crate) fn check(&self, joints: usize) -> Result<(), StiffnessError> {
        if self.joints.len() != joints {
            return Err(StiffnessError::Count { what: "springs", found: self.joints.len(), joints });
        }
        if !self.links.is_empty() && self.links.len() != joints {
            return Err(StiffnessError::Count { what: "compliances of links", found: self.links.len(), joints });
        }
        for (i, spring) in self.joints.iter().enumerate() {
            spring.check(i + 1)?;
        }
        for (i, link) in self.links.iter().enumerate() {
            check_finite(format_args!("compliance of link {}", i + 1), link)?;
        }
        Ok(())
    }
}
