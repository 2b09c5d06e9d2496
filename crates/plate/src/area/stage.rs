//! One implicit stage: velocity, pressure and friction that agree with each other.

use super::pressure::{Footprint, Load, Support};
use super::settings::AreaSettings;
use crate::model::Terms;
use crate::{Friction, Object, PlateError, PlateKinematics};
use bracketry_sim::{ContactStep, FrictionPoints, FrictionSolver, Slip};
use nalgebra::{Matrix3, Vector3};

/// Most rounds of pressure and friction in turn. Each gains a factor of about `μ θ' dt` or `μ h/R`.
const ROUNDS: usize = 50;
/// Agreement of velocities between rounds, in units of gravity times stage length.
const AGREEMENT: f64 = 1e-7;
/// From this round on half steps are made, in case friction falls with speed.
const DAMPED: usize = 10;

/// What moves the object: equations of motion without friction, footprint and friction law.
#[derive(Debug, Clone)]
pub(super) struct Equations {
    object: Object,
    friction: Friction,
    gravity: f64,
    terms: Terms,
    /// Height of the center of mass as far as the terms know of it, in m.
    height: f64,
    inertia: f64,
    footprint: Footprint,
    points: FrictionPoints<3>,
    /// Normal force on each of the points, in N/kg.
    loads: Vec<f64>,
    solver: FrictionSolver<3>,
}

/// Where a stage begins: `q = position + length · v`, `v = velocity + length · acceleration`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Base {
    pub(super) position: [f64; 3],
    pub(super) velocity: [f64; 3],
    pub(super) length: f64,
    /// Whether the object rests when the step begins, which a static level of friction has to be overcome for.
    pub(super) at_rest: bool,
}

/// The result of a stage.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stage {
    pub(super) position: [f64; 3],
    pub(super) velocity: [f64; 3],
    /// Friction per mass: force along x, y (N/kg) and torque (N m/kg).
    pub(super) friction: [f64; 3],
    /// Gravity and inertia per mass, likewise.
    pub(super) drive: [f64; 3],
    /// Normal force in N/kg.
    pub(super) normal: f64,
    /// Center of pressure from the center of mass, plate axes, in m.
    pub(super) center: [f64; 2],
    pub(super) support: Support,
    pub(super) slip: Slip,
}

impl Stage {
    /// A state about whose forces nothing is known.
    pub(super) fn at(position: [f64; 3], velocity: [f64; 3]) -> Self {
        Self {
            position,
            velocity,
            friction: [0.0; 3],
            drive: [0.0; 3],
            normal: 0.0,
            center: [0.0; 2],
            support: Support::Full { least: 1.0 },
            slip: Slip::Sliding,
        }
    }

    /// Second derivatives of `x, y, phi`, for the yaw inertia per mass.
    pub(super) fn acceleration(&self, inertia: f64) -> [f64; 3] {
        let sum: [f64; 3] = std::array::from_fn(|i| self.friction[i] + self.drive[i]);
        [sum[0], sum[1], sum[2] / inertia]
    }

    /// Whether the contact ends here.
    pub(super) fn failed(&self) -> bool {
        matches!(self.support, Support::LiftOff | Support::Tipping { .. })
    }
}

impl Equations {
    pub(super) fn new(object: &Object, friction: &Friction, settings: &AreaSettings) -> Result<Self, PlateError> {
        settings.validate()?;
        friction.validate()?;
        let footprint = Footprint::new(object, settings.points)?;
        Ok(Self {
            inertia: object.shape.yaw_inertia(),
            object: object.clone(),
            friction: *friction,
            gravity: settings.gravity,
            terms: settings.terms,
            height: if settings.terms.thickness { object.height } else { 0.0 },
            footprint,
            points: FrictionPoints::new(),
            loads: Vec::new(),
            solver: FrictionSolver::new(),
        })
    }

    /// Yaw inertia per mass in m².
    pub(super) fn inertia(&self) -> f64 {
        self.inertia
    }

    pub(super) fn object(&self) -> &Object {
        &self.object
    }

    pub(super) fn footprint(&self) -> &Footprint {
        &self.footprint
    }

    /// Force and torque per mass of gravity and the plate's motion, in the plane of the plate.
    fn drive(&self, plate: &PlateKinematics, position: &[f64; 3]) -> [f64; 3] {
        let (_, _, sxy) = self.object.shape.second_moments_at(position[2]);
        let squared = plate.tilt_rate * plate.tilt_rate;
        [
            -plate.acceleration,
            -self.gravity * plate.tilt.sin()
                + part(self.terms.centrifugal, position[1] * squared)
                + self.height * plate.tilt_acceleration,
            part(self.terms.gyroscopic, sxy * squared),
        ]
    }

    /// What the plate has to carry, from the balance of normal force and of the moments about the axes in the plane of the
    /// plate below the center of mass, own axes:
    ///
    /// ```text
    /// N/m       = g cos θ + y θ'' + 2 y' θ' − h θ'²
    /// ∫ x̃ p/m = Sxy θ'' + 2 θ' φ' Sxx − h fx/m
    /// ∫ ỹ p/m = (Syy + h²/3) θ'' + 2 θ' φ' Sxy − h fy/m
    /// ```
    ///
    /// Without thickness this is the pressure `g cos θ + y_r θ'' + 2 θ' y_r'` of every element on its own.
    fn load(&self, plate: &PlateKinematics, position: &[f64; 3], velocity: &[f64; 3], friction: &[f64; 3]) -> Load {
        let (sxx, syy, sxy) = self.object.shape.second_moments_at(position[2]);
        let (h, rate) = (self.height, plate.tilt_rate);
        let turning = part(self.terms.euler, plate.tilt_acceleration);
        let coriolis = part(self.terms.coriolis, 2.0 * rate);
        let normal = self.gravity * plate.tilt.cos() + position[1] * turning + coriolis * velocity[1] - h * rate * rate;
        let spin = coriolis * velocity[2];
        let along = sxy * turning + spin * sxx - h * friction[0];
        let across = (syy + h * h / 3.0) * turning + spin * sxy - h * friction[1];
        let (s, c) = position[2].sin_cos();
        Load { normal, moments: [c * along + s * across, c * across - s * along] }
    }

    /// Solves a stage; the stage before gives a first guess of friction and acceleration.
    ///
    /// Friction follows from the pressure by maximum dissipation ([`FrictionSolver`]); the pressure follows from velocity
    /// and friction. The two are found in turn until they agree.
    ///
    /// # Errors
    /// [`PlateError::NotConverged`] where they do not: where friction falls fast with speed, a long step has several ends.
    pub(super) fn stage(&mut self, plate: &PlateKinematics, base: &Base, before: &Stage) -> Result<Stage, PlateError> {
        let mut friction = before.friction;
        let mut velocity = base.velocity;
        if !base.at_rest {
            velocity = add(&velocity, base.length, &before.acceleration(self.inertia));
        }
        let tolerance = AGREEMENT * self.gravity * base.length;
        let size = self.inertia.sqrt();
        let mut round = 0;
        loop {
            let position = add(&base.position, base.length, &velocity);
            let load = self.load(plate, &position, &velocity, &friction);
            let drive = self.drive(plate, &position);
            let support = self.footprint.carry(&load)?;
            let (s, c) = position[2].sin_cos();
            let stage = |velocity, friction, slip| {
                let [x, y] = load.moments.map(|m| m / load.normal);
                Stage {
                    position,
                    velocity,
                    friction,
                    drive,
                    normal: load.normal,
                    center: [c * x - s * y, s * x + c * y],
                    support,
                    slip,
                }
            };
            if matches!(support, Support::LiftOff | Support::Tipping { .. }) {
                return Ok(stage(velocity, friction, Slip::Sliding));
            }
            let free = [
                base.velocity[0] + base.length * drive[0],
                base.velocity[1] + base.length * drive[1],
                base.velocity[2] + base.length * drive[2] / self.inertia,
            ];
            if free.iter().any(|v| !v.is_finite()) {
                // Nothing is carried then, and no number tells how.
                return Ok(Stage {
                    normal: f64::NAN,
                    support: Support::LiftOff,
                    ..stage(velocity, friction, Slip::Sliding)
                });
            }
            let step = self.friction_step(base, &support, load.normal, [s, c], &velocity, &free)?;
            let new = step.velocity;
            let force = [
                (new[0] - free[0]) / base.length,
                (new[1] - free[1]) / base.length,
                (new[2] - free[2]) * self.inertia / base.length,
            ];
            let moved =
                (new[0] - velocity[0]).abs().max((new[1] - velocity[1]).abs()).max(size * (new[2] - velocity[2]).abs());
            let forced = base.length * (force[0] - friction[0]).hypot(force[1] - friction[1]) * self.height / size;
            round += 1;
            if moved <= tolerance && forced <= tolerance {
                let position = add(&base.position, base.length, &new);
                return Ok(Stage { position, ..stage(new, force, step.slip) });
            }
            if round == ROUNDS {
                let left = moved.max(forced) / (self.gravity * base.length);
                return Err(PlateError::NotConverged { what: "the friction of a step", left });
            }
            let share = if round < DAMPED { 1.0 } else { 0.5 };
            for i in 0..3 {
                velocity[i] += share * (new[i] - velocity[i]);
                friction[i] += share * (force[i] - friction[i]);
            }
        }
    }

    /// The step of friction from the velocity `free` without it: held where the object rests and can, else sliding.
    fn friction_step(
        &mut self,
        base: &Base,
        support: &Support,
        normal: f64,
        orientation: [f64; 2],
        velocity: &[f64; 3],
        free: &[f64; 3],
    ) -> Result<ContactStep<3>, PlateError> {
        if base.at_rest && self.friction.static_coefficient() > self.friction.coefficient(0.0) {
            self.set_points(support, normal, orientation, velocity, base.length, true);
            let step = self.solver.step(&self.mass(0.0), free, &self.points, velocity)?;
            if step.slip == Slip::Held {
                return Ok(step);
            }
        }
        self.set_points(support, normal, orientation, velocity, base.length, false);
        let mass = self.mass(base.length);
        let pulled = if self.friction.viscosity() == 0.0 {
            *free
        } else {
            // Viscous friction is part of the mass matrix but not of the momentum.
            let momentum = Vector3::new(free[0], free[1], free[2] * self.inertia);
            let pulled = Matrix3::from(mass).cholesky().map(|factor| factor.solve(&momentum));
            let what = "the velocity under viscous friction";
            pulled.ok_or(PlateError::NotConverged { what, left: f64::INFINITY })?.into()
        };
        Ok(self.solver.step(&mass, &pulled, &self.points, velocity)?)
    }

    /// Mass matrix per mass, with the viscous part of friction over a time.
    fn mass(&self, time: f64) -> [[f64; 3]; 3] {
        let mut mass = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, self.inertia]];
        let viscosity = time * self.friction.viscosity();
        if viscosity > 0.0 {
            for (index, load) in self.loads.iter().enumerate() {
                for row in self.points.rows(index) {
                    for i in 0..3 {
                        for j in 0..3 {
                            mass[i][j] += viscosity * load * row[i] * row[j];
                        }
                    }
                }
            }
        }
        mass
    }

    /// Contact points in plate axes with the friction impulses that the pressure allows.
    fn set_points(
        &mut self,
        support: &Support,
        normal: f64,
        [s, c]: [f64; 2],
        velocity: &[f64; 3],
        length: f64,
        at_rest: bool,
    ) {
        let [dx, dy] = self.friction.weights();
        let friction = self.friction;
        let viscosity = friction.viscosity();
        let coefficient = |rows: &[[f64; 3]; 2]| {
            if at_rest {
                return friction.static_coefficient();
            }
            let [u, v] = rows.map(|row| row[0] * velocity[0] + row[1] * velocity[1] + row[2] * velocity[2]);
            let speed = u.hypot(v);
            friction.coefficient(speed) - viscosity * speed
        };
        self.points.clear();
        self.loads.clear();
        let (terms, gravity) = (self.terms, self.gravity);
        let mut add = |[x, y]: [f64; 2], load: f64, weight: f64| {
            let (x, y) = (c * x - s * y, s * x + c * y);
            let rows = [[dx, 0.0, -dx * y], [0.0, dy, dy * x]];
            let bound = length * coefficient(&rows);
            if terms.coupled {
                self.points.push(rows, bound * load);
                self.loads.push(load);
            } else {
                // Each component on its own: a point for each, with one row.
                let along = if terms.load_along_x { load } else { gravity * weight };
                self.points.push([rows[0], [0.0; 3]], bound * along);
                self.points.push([[0.0; 3], rows[1]], bound * load);
                self.loads.extend([along, load]);
            }
        };
        if let Support::Edge { at } = *support {
            add(at, normal, 1.0);
        } else {
            let weights = self.footprint.weights().iter();
            for ((point, load), weight) in self.footprint.points().iter().zip(self.footprint.loads()).zip(weights) {
                add(*point, *load, *weight);
            }
        }
    }
}

/// A term, if it takes part.
fn part(on: bool, term: f64) -> f64 {
    if on { term } else { 0.0 }
}

/// `a + factor · b`.
fn add(a: &[f64; 3], factor: f64, b: &[f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] + factor * b[i])
}
