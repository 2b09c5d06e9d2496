//! Mean velocities of an object over cycles of the plate and its displacements in single bursts, tabulated over cycle and place.

use super::cycle::{CYCLE, Cycle};
use crate::TrialError;
use bracketry_plate::area::{AreaContact, AreaSettings};
use bracketry_plate::experiment::{Establishing, mean_velocity, sweep};
use bracketry_plate::{AreaObject, Friction, Object, PlateError, PlateKinematics, Shape};
use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;

/// Levels of the shares of a cycle in the table.
const LEVELS: [f64; 3] = [-1.0, 0.0, 1.0];
/// Number of drifting cycles in the table.
const CYCLES: usize = 27;
/// Time after a burst in which what slides comes to rest, in s.
const SETTLING: f64 = 0.1;

/// Where and how finely the map is computed.
#[derive(Debug, Clone, PartialEq)]
pub struct CycleGrid {
    /// Places `y` in m, in increasing order.
    pub y: Vec<f64>,
    /// Number of yaws over the angle after which the shape repeats; 1 for a disk, whatever is given.
    pub yaws: usize,
    /// Settings of the plant that the map is computed on.
    pub area: AreaSettings,
}

impl Default for CycleGrid {
    /// `y` = −0.1, 0, 0.1 m, six yaws, 24 contact points in steps of 2 ms.
    fn default() -> Self {
        Self { y: vec![-0.1, 0.0, 0.1], yaws: 6, area: AreaSettings::default().with_step(2e-3).with_points(24) }
    }
}

/// What full shaking with a drift does to an object: its mean velocity while it goes on ([`mean_velocity`]), and its displacement in a
/// burst, which begins and ends with plate and object at rest: one cycle of swelling and one of ebbing.
#[derive(Debug, Clone, PartialEq)]
pub struct CycleMap {
    y: Vec<f64>,
    /// Angle after which the shape repeats.
    symmetry_angle: f64,
    yaws: usize,
    /// Mean velocity and displacement of a burst for each cycle, yaw and y, y varying fastest.
    nodes: Vec<[[f64; 3]; 2]>,
}

/// The rows of the map at a place, one for each cycle.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Drifts(Vec<[f64; 3]>);

/// What is looked up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Quantity {
    Velocity = 0,
    Burst = 1,
}

impl CycleMap {
    /// Computes the map for an object with the friction coefficient `mu` in parallel; see [`sweep`] for `progress`, which
    /// counts the nodes of the grid ([`CycleMap::count`]).
    ///
    /// # Errors
    /// [`TrialError`] if object, coefficient or grid have no meaning, [`TrialError::Canceled`] if `progress` broke off.
    pub fn new(
        object: &Object,
        mu: f64,
        grid: &CycleGrid,
        progress: impl Fn(usize) -> ControlFlow<()> + Sync,
    ) -> Result<Self, TrialError> {
        if grid.y.is_empty() || grid.y.windows(2).any(|w| w[0] >= w[1]) || grid.yaws == 0 {
            return Err(TrialError::NoGrid);
        }
        let contact = AreaContact::new(object, &Friction::Coulomb { mu }, &grid.area)?;
        let plant = AreaObject::new(contact.clone())?;
        let symmetry_angle = match object.shape {
            Shape::Polygon { .. } => TAU,
            _ => PI,
        };
        let yaws = Self::yaws(object, grid);
        let mut cases = Vec::new();
        for cycle in 0..CYCLES {
            for yaw in 0..yaws {
                cases.extend(
                    grid.y.iter().map(|&y| (cycle_of(cycle), [0.0, y, symmetry_angle * yaw as f64 / yaws as f64])),
                );
            }
        }
        let run = |&(cycle, place): &(Cycle, [f64; 3])| {
            let establishing = Establishing { periods: 8, tolerance: 1e-3 };
            let cruise = mean_velocity(&mut plant.clone(), &cycle.motion(), place, establishing)?;
            Ok([cruise.mean, burst(&contact, &cycle, place)?])
        };
        let results: Option<Vec<_>> = sweep(&cases, run, progress).into_iter().collect();
        let nodes = results.ok_or(TrialError::Canceled)?.into_iter().collect::<Result<_, PlateError>>()?;
        Ok(Self { y: grid.y.clone(), symmetry_angle, yaws, nodes })
    }

    /// Number of nodes that a map has.
    pub fn count(object: &Object, grid: &CycleGrid) -> usize {
        CYCLES * Self::yaws(object, grid) * grid.y.len()
    }

    fn yaws(object: &Object, grid: &CycleGrid) -> usize {
        if matches!(object.shape, Shape::Disk { .. }) { 1 } else { grid.yaws }
    }

    /// Mean velocity `x', y'` (m/s), `phi'` (rad/s) under full shaking with the shares `asymmetry, slope, swing` of [`Cycle`]
    /// at a place: linear between the nodes of the grid, periodic in the yaw; outside the grid that at its rim.
    pub fn velocity(&self, drift: [f64; 3], y: f64, phi: f64) -> [f64; 3] {
        self.drifts(Quantity::Velocity, y, phi).at(drift)
    }

    /// Displacement in x, y (m) and phi (rad) of a burst; see [`CycleMap::velocity`].
    pub fn burst(&self, drift: [f64; 3], y: f64, phi: f64) -> [f64; 3] {
        self.drifts(Quantity::Burst, y, phi).at(drift)
    }

    /// All drifts at a place.
    pub(super) fn drifts(&self, quantity: Quantity, y: f64, phi: f64) -> Drifts {
        let (row, up) = between(&self.y, y);
        let place = (phi / self.symmetry_angle).rem_euclid(1.0) * self.yaws as f64;
        let (column, along) = ((place as usize) % self.yaws, place.fract());
        let rows = self.y.len();
        let node = |cycle: usize, column: usize, row: usize| {
            let row = row.min(rows - 1);
            self.nodes[(cycle * self.yaws + column % self.yaws) * rows + row][quantity as usize]
        };
        let mix = |a: [f64; 3], b: [f64; 3], s: f64| std::array::from_fn(|i| a[i] + s * (b[i] - a[i]));
        Drifts(
            (0..CYCLES)
                .map(|cycle| {
                    let at = |column: usize| mix(node(cycle, column, row), node(cycle, column, row + 1), up);
                    mix(at(column), at(column + 1), along)
                })
                .collect(),
        )
    }
}

impl Drifts {
    /// The drifts with something added to each.
    pub(super) fn shifted(mut self, by: [f64; 3]) -> Self {
        self.0.iter_mut().for_each(|drift| (0..3).for_each(|i| drift[i] += by[i]));
        self
    }

    /// The drift of a cycle: linear between the levels.
    pub(super) fn at(&self, shares: [f64; 3]) -> [f64; 3] {
        let cells = shares.map(|share| between(&LEVELS, share));
        let mut sum = [0.0; 3];
        for corner in 0..8usize {
            let (mut weight, mut index) = (1.0, 0);
            for (axis, (cell, part)) in cells.iter().enumerate() {
                let upper = (corner >> axis) & 1;
                weight *= if upper == 1 { *part } else { 1.0 - part };
                index = 3 * index + cell + upper;
            }
            (0..3).for_each(|i| sum[i] += weight * self.0[index][i]);
        }
        sum
    }
}

/// The interval of increasing values, not the last value, in which a value lies, and its place in there; of a single value, 0.
fn between(values: &[f64], value: f64) -> (usize, f64) {
    let last = values.len().saturating_sub(2);
    let below = values.partition_point(|v| *v <= value).saturating_sub(1).min(last);
    match values.get(below + 1) {
        Some(next) => (below, ((value - values[below]) / (next - values[below])).clamp(0.0, 1.0)),
        None => (0, 0.0),
    }
}

/// Cycle number `index` of the table.
fn cycle_of(index: usize) -> Cycle {
    Cycle::drifting([LEVELS[index / 9], LEVELS[index / 3 % 3], LEVELS[index % 3]])
}

/// Displacement of a burst from rest at a place.
fn burst(contact: &AreaContact, cycle: &Cycle, place: [f64; 3]) -> Result<[f64; 3], PlateError> {
    let mut contact = contact.clone();
    let [x, y, phi] = place;
    contact.set_state([x, y, phi, 0.0, 0.0, 0.0])?;
    let still = Cycle::default();
    let mut motion = |t: f64| {
        if t < CYCLE {
            cycle.after(&still, t)
        } else if t < 2.0 * CYCLE {
            still.after(cycle, t - CYCLE)
        } else {
            PlateKinematics::default()
        }
    };
    contact.advance(&mut motion, 2.0 * CYCLE + SETTLING)?;
    let end = contact.state();
    Ok(std::array::from_fn(|i| end[i] - place[i]))
}
