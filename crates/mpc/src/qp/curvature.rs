//! Exact Hessians of the stages' Lagrangians.
//!
//! The block of grid point k is dt ∇²l + ∇²(λ_kᵀF). Its negative eigenvalues, with states and inputs measured in their sizes,
//! are clipped to zero. At grid point 0, whose state is fixed, the block is that of the inputs alone.

use super::assembly::{Assembly, NOWHERE};
use crate::convexify::{clip_to_psd, components};
use crate::ocp::Ocp;
use crate::shooting::Linearisation;
use crate::trajectory::Trajectory;

/// Which states and inputs are coupled in the stages' blocks.
pub(super) struct StageBlocks {
    /// Groups of variables of (x, u) that second derivatives link.
    groups: Vec<Vec<usize>>,
    full: Vec<f64>,
    size: Vec<f64>,
    block: Vec<f64>,
    scratch: Vec<f64>,
}

impl StageBlocks {
    /// Blocks for these places of the flow's second derivatives on top of those of the stage cost.
    pub(super) fn new(ocp: &Ocp, flow: &[(usize, usize)]) -> Self {
        let w = ocp.states() + ocp.inputs();
        let cost = ocp.stage.as_ref().map_or(&[][..], |c| c.hessian_pattern());
        let links: Vec<(usize, usize)> = cost.iter().chain(flow).copied().collect();
        let groups = components(w, &links);
        Self { groups, full: vec![0.0; w * w], size: Vec::new(), block: Vec::new(), scratch: Vec::new() }
    }

    /// Places (i ≤ j) of the blocks.
    pub(super) fn pattern(&self) -> Vec<(usize, usize)> {
        let pairs = |g: &Vec<usize>| -> Vec<(usize, usize)> {
            g.iter().enumerate().flat_map(|(p, &i)| g[p..].iter().map(move |&j| (i, j))).collect()
        };
        self.groups.iter().flat_map(pairs).collect()
    }
}

impl Assembly {
    /// Adds gradient and exact Hessian of stage k.
    pub(super) fn add_exact_stage(
        &mut self,
        blocks: &mut StageBlocks,
        ocp: &mut Ocp,
        k0: usize,
        k: usize,
        trajectory: &Trajectory,
        lin: &Linearisation,
    ) {
        let w = self.program.states + self.program.inputs;
        let full = &mut blocks.full;
        match lin.curvature.get(k * w * w..(k + 1) * w * w) {
            Some(curvature) => full.copy_from_slice(curvature),
            None => full.fill(0.0),
        }
        self.gradient.fill(0.0);
        if let Some(mut cost) = ocp.stage.take() {
            let r = &ocp.reference(k0 + k)[..cost.references()];
            let t = (k0 + k) as f64 * ocp.dt;
            let (x, u) = (trajectory.x(k), trajectory.u(k));
            cost.add_exact_derivatives(x, u, t, r, ocp.dt, &mut self.gradient, full);
            ocp.stage = Some(cost);
        }
        let program = &mut self.program;
        for (v, g) in self.gradient.iter().enumerate() {
            if let Some(variable) = program.variable(k, v) {
                program.gradient[variable] += g;
            }
        }
        let size = &mut blocks.size;
        size.clear();
        size.extend((0..w).map(|v| program.variable(k, v).map_or(1.0, |v| program.scale[v])));
        let mut slots = self.stage_slots[k].iter().filter(|s| **s != NOWHERE);
        for group in &blocks.groups {
            // The state of grid point 0 is fixed.
            let free = &group[if k == 0 { group.partition_point(|&v| v < program.states) } else { 0 }..];
            let block = &mut blocks.block;
            block.clear();
            block.extend(
                free.iter()
                    .flat_map(|&i| free.iter().map(move |&j| (i, j)))
                    .map(|(i, j)| f64::midpoint(full[i * w + j], full[j * w + i]) * size[i] * size[j]),
            );
            if free.is_empty() {
                continue;
            }
            clip_to_psd(block, free.len(), &mut blocks.scratch);
            for (a, &i) in free.iter().enumerate() {
                for (b, &j) in free.iter().enumerate().skip(a) {
                    if let Some(&slot) = slots.next() {
                        program.hessian[slot] += block[a * free.len() + b] / (size[i] * size[j]);
                    }
                }
            }
        }
    }
}
