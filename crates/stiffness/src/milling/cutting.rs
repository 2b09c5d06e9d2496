//! The force of a milling cutter.

use crate::compensate::{CompensationError, positive};
use crate::robot::{Wrench, stacked};
use nalgebra::{Matrix6, Vector3};

/// A cutting force in proportion to the depth of cut (mechanistic model, Altintas 2012), on the circle that the
/// tool goes round inside the material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cutting {
    /// Radial depth of cut where the tool is on its path (m).
    pub depth: f64,
    /// Force away from the material per depth (N/m).
    pub radial: f64,
    /// Force against the feed per depth (N/m).
    pub tangential: f64,
    /// Force back along the tool per depth (N/m).
    pub axial: f64,
    /// Amplitude of the teeth's ripple, as a share of the force.
    pub ripple: f64,
    /// Frequency of the teeth (Hz).
    pub ripple_frequency: f64,
}

/// Directions at a point of the circle: outwards, with the feed, along the tool into the work.
#[derive(Clone, Copy, Debug)]
pub(super) struct Directions {
    pub(super) outwards: Vector3<f64>,
    pub(super) feed: Vector3<f64>,
    pub(super) tool: Vector3<f64>,
}

impl Cutting {
    pub(super) fn check(&self) -> Result<(), CompensationError> {
        positive("the depth of cut", self.depth)?;
        positive("the radial cutting stiffness", self.radial)
    }

    /// Force on the tool per depth (N/m).
    fn per_depth(&self, at: &Directions) -> Vector3<f64> {
        -(self.radial * at.outwards + self.tangential * at.feed + self.axial * at.tool)
    }

    /// Wrench on the robot at the tool point, for a depth of cut at a time; none where the tool is out of the material.
    pub(super) fn wrench(&self, at: &Directions, depth: f64, time: f64) -> Wrench {
        let ripple = 1.0 + self.ripple * (std::f64::consts::TAU * self.ripple_frequency * time).sin();
        stacked(&(self.per_depth(at) * (depth.max(0.0) * ripple)), &Vector3::zeros())
    }

    /// `K_p`: the wrench changes by `−K_p ΔX`, as the tool goes deeper outwards.
    pub(super) fn stiffness(&self, at: &Directions) -> Matrix6<f64> {
        let mut stiffness = Matrix6::zeros();
        let along = -self.per_depth(at) * at.outwards.transpose();
        stiffness.fixed_view_mut::<3, 3>(0, 0).copy_from(&along);
        stiffness
    }
}
