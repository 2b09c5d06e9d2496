//! A region of attraction beside the motions of the model, over two of its states.

use std::time::{Duration, Instant};

use bracketry_sim::{ExactPlant, PlantError, SimulationSettings};
use bracketry_system::System;

use crate::certificate::Claim;
use crate::linearization::Evaluated;
use crate::model::rate;
use crate::report::Proof;

/// What is drawn of a region {V ≤ c}, where all other states have their values at the equilibrium.
#[derive(Clone, Debug, PartialEq)]
pub struct Portrait {
    /// Names of the two states.
    pub axes: [String; 2],
    /// The equilibrium.
    pub center: [f64; 2],
    /// The closed curve V = c.
    pub level: Vec<[f64; 2]>,
    /// Points, along rays from the equilibrium, beyond which simulated motions do not reach the region: the boundary of the region of
    /// attraction as far as simulation shows it. Rays without such a point have none.
    pub boundary: Vec<[f64; 2]>,
    /// Simulated motions from points of the curve, projected.
    pub motions: Vec<Vec<[f64; 2]>>,
}

/// Why there is no picture.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PortraitError {
    /// The proof is none of a region, or the indices are none of two different states.
    #[error("a figure needs a region of attraction and two different states")]
    NoRegion,
    /// The model cannot be simulated.
    #[error(transparent)]
    Plant(#[from] PlantError),
}

/// Points of the curve, and rays of the simulated boundary.
const CURVE: usize = 360;
const RAYS: usize = 90;
/// Motions that are drawn.
const MOTIONS: usize = 12;
/// Pieces of a motion, and the time of all in units of the slowest decay of V.
const PIECES: usize = 200;
const TIME: f64 = 40.0;
/// Time after which no more rays are simulated: the picture then shows a part of the boundary.
const SEARCH: Duration = Duration::from_secs(20);
/// The boundary is sought up to this multiple of the curve.
const BEYOND: f64 = 4.0;

struct Plane<'a> {
    axes: [usize; 2],
    at: &'a [f64],
    value: Evaluated,
    rate: Evaluated,
    level: f64,
}

impl Plane<'_> {
    fn deviation(&self, angle: f64, r: f64) -> Vec<f64> {
        let mut x = vec![0.0; self.at.len()];
        x[self.axes[0]] = r * angle.cos();
        x[self.axes[1]] = r * angle.sin();
        x
    }

    fn on_page(&self, deviation: &[f64]) -> [f64; 2] {
        self.axes.map(|k| self.at[k] + deviation[k])
    }

    /// The radius at which V reaches c first.
    fn radius(&self, angle: f64) -> f64 {
        let (mut inside, mut r) = (0.0, 1e-6);
        while self.value.at(&self.deviation(angle, r)) < self.level && r < 1e9 {
            inside = r;
            r *= 1.2;
        }
        for _ in 0..50 {
            let middle = 0.5 * (inside + r);
            if self.value.at(&self.deviation(angle, middle)) < self.level { inside = middle } else { r = middle }
        }
        r
    }
}

/// The picture of a region of attraction over the states with the given indices. Inputs are held at the point.
///
/// # Errors
/// [`PortraitError`] for a proof of something else, and for a model that cannot be simulated.
pub fn portrait(system: &System, proof: &Proof, axes: [usize; 2]) -> Result<Portrait, PortraitError> {
    let names = system.state_names();
    let Claim::Region { function, level, .. } = &proof.certificate.claim else { return Err(PortraitError::NoRegion) };
    if axes[0] == axes[1] || axes.iter().any(|k| *k >= names.len()) {
        return Err(PortraitError::NoRegion);
    }
    let (at, inputs) =
        system.point_values().unwrap_or_else(|| (vec![0.0; names.len()], vec![0.0; system.inputs.len()]));
    let plane = Plane {
        axes,
        at: &at,
        value: Evaluated::new(function),
        rate: Evaluated::new(&rate(function, &proof.certificate.field)),
        level: level.to_f64().value(),
    };
    let angles = |count: usize| (0..count).map(move |k| std::f64::consts::TAU * k as f64 / count as f64);
    let radii: Vec<(f64, f64)> = angles(CURVE).map(|a| (a, plane.radius(a))).collect();
    let decay = radii.iter().map(|&(a, r)| {
        let x = plane.deviation(a, 0.3 * r);
        -plane.rate.at(&x) / plane.value.at(&x)
    });
    let slowest = decay.fold(f64::INFINITY, f64::min).max(1e-6);
    let plant = ExactPlant::new(system, &at, &SimulationSettings::default())?;
    let mut run = Run { plant, inputs, piece: TIME / slowest / PIECES as f64, plane: &plane };
    let mut boundary = Vec::new();
    let end = Instant::now() + SEARCH;
    for angle in angles(RAYS).take_while(|_| Instant::now() < end) {
        if let Some(r) = run.boundary(angle, plane.radius(angle))? {
            boundary.push(plane.on_page(&plane.deviation(angle, r)));
        }
    }
    let mut motions = Vec::new();
    let end = Instant::now() + SEARCH;
    for (angle, r) in radii.iter().step_by(CURVE / MOTIONS).take_while(|_| Instant::now() < end) {
        motions.push(run.motion(&plane.deviation(*angle, *r))?);
    }
    let mut curve: Vec<[f64; 2]> = radii.iter().map(|&(a, r)| plane.on_page(&plane.deviation(a, r))).collect();
    curve.push(curve[0]);
    Ok(Portrait { axes: axes.map(|k| names[k].clone()), center: axes.map(|k| at[k]), level: curve, boundary, motions })
}

struct Run<'a> {
    plant: ExactPlant,
    inputs: Vec<f64>,
    /// Seconds.
    piece: f64,
    plane: &'a Plane<'a>,
}

impl Run<'_> {
    fn start(&mut self, deviation: &[f64]) -> Result<(), PlantError> {
        let x: Vec<f64> = self.plane.at.iter().zip(deviation).map(|(a, d)| a + d).collect();
        self.plant.set_state(&x)
    }

    /// The deviation after one more piece; none where the solution ends.
    fn next(&mut self) -> Result<Option<Vec<f64>>, PlantError> {
        let outcome = self.plant.hold(&self.inputs, self.piece)?;
        let x: Vec<f64> = self.plant.state().iter().zip(self.plane.at).map(|(x, a)| x - a).collect();
        Ok((outcome.is_finished() && x.iter().all(|x| x.is_finite())).then_some(x))
    }

    /// Whether the motion enters the region, from which it provably does not return.
    fn is_attracted(&mut self, deviation: &[f64], far: f64) -> Result<bool, PlantError> {
        self.start(deviation)?;
        for _ in 0..PIECES {
            match self.next()? {
                Some(x) if self.plane.value.at(&x) <= self.plane.level => return Ok(true),
                Some(x) if x.iter().any(|x| x.abs() > far) => return Ok(false),
                Some(_) => {}
                None => return Ok(false),
            }
        }
        Ok(false)
    }

    fn boundary(&mut self, angle: f64, radius: f64) -> Result<Option<f64>, PlantError> {
        let far = 100.0 * BEYOND * radius;
        let (mut inside, mut r) = (radius, radius);
        loop {
            r *= 1.15;
            if r > BEYOND * radius {
                return Ok(None);
            }
            if !self.is_attracted(&self.plane.deviation(angle, r), far)? {
                break;
            }
            inside = r;
        }
        for _ in 0..10 {
            let middle = 0.5 * (inside + r);
            if self.is_attracted(&self.plane.deviation(angle, middle), far)? { inside = middle } else { r = middle }
        }
        Ok(Some(inside))
    }

    fn motion(&mut self, deviation: &[f64]) -> Result<Vec<[f64; 2]>, PlantError> {
        // Finer than for the boundary, so that the line is smooth.
        let piece = self.piece;
        self.piece = piece / 8.0;
        self.start(deviation)?;
        let mut points = vec![self.plane.on_page(deviation)];
        for _ in 0..4 * PIECES {
            let Some(x) = self.next()? else { break };
            points.push(self.plane.on_page(&x));
            if self.plane.value.at(&x) < 1e-4 * self.plane.level {
                break;
            }
        }
        self.piece = piece;
        Ok(points)
    }
}
