//! Impulses at unilateral contact points with dry friction.

use bracketry_sim::{ContactError, FrictionPoints, FrictionSolver};
use nalgebra::{Matrix6, Vector3, Vector6};

use super::normal::normal_impulses;

/// Iterations between normal impulses and friction.
const ROUNDS: usize = 150;
/// Change of the friction impulse at which the iteration ends, relative to the velocities at work.
const TOLERANCE: f64 = 1e-11;
/// Change that is accepted where rounding does not let it become less for [`STALLED`] rounds.
const ACCEPTED: f64 = 1e-8;
/// Rounds without a new least change.
const STALLED: usize = 8;

/// A point that touches.
#[derive(Debug, Clone, Copy)]
pub(super) struct Contact {
    /// From the center of mass, axes of the plate, in lengths of the body.
    pub(super) arm: Vector3<f64>,
    /// The normal velocity it shall at least have afterwards.
    pub(super) target: f64,
    /// Friction coefficient.
    pub(super) coefficient: f64,
    /// Share in an impulse whose distribution over the points is not unique.
    pub(super) weight: f64,
}

/// What the impulses did.
#[derive(Debug, Clone, Copy)]
pub(super) struct Impulses {
    /// Velocity afterwards.
    pub(super) velocity: Vector6<f64>,
    /// Sum of the normal impulses.
    pub(super) normal: f64,
    /// Whether normal impulses and friction agree to the tolerance.
    pub(super) converged: bool,
}

/// Signorini's condition and Coulomb's law at once, as the fixed point of two convex problems: normal impulses for given
/// friction, and friction of maximum dissipation for given normal impulses (Panagiotopoulos 1975; Kaufman, Sueda, James,
/// and Pai 2008).
///
/// The iteration contracts wherever `μ |W_nt| < W_nn` (the body cannot jam, Painlevé 1895); elsewhere it is relaxed by
/// Aitken's rule, and a friction impulse that stays bounded guarantees that there is a fixed point.
/// Velocities are `(v, ℓ ω)` with a length `ℓ` of the body, masses are divided by that of the body.
#[derive(Debug, Clone, Default)]
pub(super) struct ContactSolver {
    solver: FrictionSolver<6>,
    points: FrictionPoints<6>,
    normals: Vec<Vector6<f64>>,
    targets: Vec<f64>,
    weights: Vec<f64>,
    /// Normal impulses of the last call.
    pub(super) impulses: Vec<f64>,
    friction: Vector6<f64>,
}

/// The row that gives the normal velocity of a point.
pub(super) fn normal_row(arm: &Vector3<f64>) -> Vector6<f64> {
    Vector6::new(0.0, 0.0, 1.0, arm.y, -arm.x, 0.0)
}

impl ContactSolver {
    /// The velocity after impulses at `contacts` on a body with the velocity `free` without them. `axes` is the diagonal
    /// that makes the friction norm isotropic.
    pub(super) fn solve(
        &mut self,
        mass: &Matrix6<f64>,
        inverse: &Matrix6<f64>,
        free: &Vector6<f64>,
        contacts: &[Contact],
        axes: [f64; 2],
    ) -> Result<Impulses, ContactError> {
        self.normals.clear();
        self.targets.clear();
        self.weights.clear();
        self.points.clear();
        for contact in contacts {
            let arm = &contact.arm;
            self.normals.push(normal_row(arm));
            self.targets.push(contact.target);
            self.weights.push(contact.weight);
            let [dx, dy] = axes;
            let along = [dx, 0.0, 0.0, 0.0, dx * arm.z, -dx * arm.y];
            let across = [0.0, dy, 0.0, -dy * arm.z, 0.0, dy * arm.x];
            self.points.push([along, across], 0.0);
        }
        let matrix: [[f64; 6]; 6] = std::array::from_fn(|i| std::array::from_fn(|j| mass[(i, j)]));
        let scale = free.amax().max(f64::MIN_POSITIVE);
        let mut relaxation = 1.0;
        let (mut least, mut since) = (f64::INFINITY, 0);
        let mut last: Option<Vector6<f64>> = None;
        let mut guess = *free;
        for _ in 0..ROUNDS {
            let pushed = free + inverse * self.friction;
            let (held, left) =
                normal_impulses(mass, &pushed, &self.normals, &self.targets, &self.weights, &mut self.impulses);
            for (k, contact) in contacts.iter().enumerate() {
                self.points.set_bound(k, contact.coefficient * self.impulses[k]);
            }
            let without = held - inverse * self.friction;
            let step = self.solver.step(&matrix, &without.into(), &self.points, &guess.into())?;
            let velocity = Vector6::from(step.velocity);
            guess = velocity;
            let residual = mass * (velocity - without) - self.friction;
            let change = residual.amax();
            if change < 0.9 * least {
                (least, since) = (change, 0);
            } else {
                since += 1;
            }
            if change <= TOLERANCE * scale || (since >= STALLED && change <= ACCEPTED * scale) {
                return Ok(Impulses { velocity, normal: self.impulses.iter().sum(), converged: left <= ACCEPTED });
            }
            if let Some(before) = last {
                let change = residual - before;
                let squared = change.norm_squared();
                if squared > 0.0 {
                    relaxation = (-relaxation * before.dot(&change) / squared).clamp(0.05, 1.5);
                }
            }
            self.friction += residual * relaxation;
            last = Some(residual);
        }
        let (velocity, _) = normal_impulses(
            mass,
            &(free + inverse * self.friction),
            &self.normals,
            &self.targets,
            &self.weights,
            &mut self.impulses,
        );
        Ok(Impulses { velocity, normal: self.impulses.iter().sum(), converged: false })
    }

    /// Forgets the friction impulse from which the next iteration starts.
    pub(super) fn forget(&mut self) {
        self.friction = Vector6::zeros();
    }
}
