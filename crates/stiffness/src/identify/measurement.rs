//! Measured displacements under measured loads, checked before anything is computed from them.

use super::error::{IdentificationError, Place, WRENCH_ENTRIES};
use crate::robot::{Twist, Wrench, halves};
use bracketry_numerics::statistics::median;
use nalgebra::{Matrix6, Vector6};
use std::collections::HashMap;

/// Entries of a displacement.
const TWIST_ENTRIES: [&str; 6] =
    ["translation x", "translation y", "translation z", "rotation x", "rotation y", "rotation z"];

/// Largest displacement taken for elastic: m and rad.
const LARGEST: (f64, f64) = (0.05, 0.1);
/// The same with the largest load on a robot.
const LIMITS: [(&str, f64, &str); 4] =
    [("translation", LARGEST.0, "m"), ("rotation", LARGEST.1, "rad"), ("force", 1e7, "N"), ("moment", 1e7, "N·m")];
/// Range of standard deviations.
const DEVIATIONS: (f64, f64) = (1e-12, 1e6);
/// Force per translation of robots, N/m.
const FORCE_PER_TRANSLATION: (f64, f64) = (1e4, 1e10);
/// Moment per rotation of robots, N·m/rad; forces turn the tool too, hence far down.
const MOMENT_PER_ROTATION: (f64, f64) = (1e3, 1e9);
/// Moment per force, m: a lever.
const LEVER: (f64, f64) = (0.0, 20.0);
/// Moment per translation from which on moments alone explain the translation, N·m/m.
const MOMENT_PER_TRANSLATION: f64 = 1e5;
/// Times its noise that a median is more than noise.
const BEYOND_NOISE: f64 = 3.0;
/// Times its noise that no single number of noise is.
const ALWAYS_BEYOND_NOISE: f64 = 6.0;
/// Standard deviation from which on a displacement counts for nothing: m and rad.
const MEANINGLESS: (f64, f64) = (0.01, 0.01);
/// Translation per rotation of robots, m: of the size of their arms.
const TRANSLATION_PER_ROTATION: (f64, f64) = (0.02, 50.0);

/// A pose, a load and what the tool point did under it.
#[derive(Clone, Debug, PartialEq)]
pub struct Measurement {
    /// Joint coordinates (rad; m where a joint slides).
    pub q: Vec<f64>,
    /// Wrench on the robot at the tool point, in base axes (N, N·m).
    pub wrench: Wrench,
    /// Displacement of the tool point against the unloaded pose, in base axes (m, rotation vector in rad).
    pub displacement: Twist,
}

impl Measurement {
    /// Magnitudes of translation, rotation, force and moment.
    fn sizes(&self) -> [f64; 4] {
        let ((translation, rotation), (force, moment)) = (halves(&self.displacement), halves(&self.wrench));
        [translation, rotation, force, moment].map(|part| part.norm())
    }
}

/// Covariances of what is measured. They also make rotations comparable with translations: everything is weighted by them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasurementNoise {
    /// Covariance of a displacement (m², m·rad, rad²).
    pub displacement: Matrix6<f64>,
    /// Covariance of a wrench (N², N·N·m, N²·m²).
    pub wrench: Matrix6<f64>,
}

impl MeasurementNoise {
    /// Independent noise with standard deviations of each translation (m), rotation (rad), force (N) and moment (N·m).
    pub fn from_std(translation: f64, rotation: f64, force: f64, moment: f64) -> Self {
        let diagonal = |a: f64, b: f64| Matrix6::from_diagonal(&Vector6::new(a, a, a, b, b, b).map(|s| s * s));
        Self { displacement: diagonal(translation, rotation), wrench: diagonal(force, moment) }
    }

    fn check(&self) -> Result<(), IdentificationError> {
        for (what, covariance) in [("displacement", &self.displacement), ("wrench", &self.wrench)] {
            // Compared entry by entry in its own scale, as m² and rad² may differ by orders.
            let symmetric = (0..6).all(|i| {
                (0..i).all(|j| {
                    let scale = (covariance[(i, i)] * covariance[(j, j)]).sqrt();
                    (covariance[(i, j)] - covariance[(j, i)]).abs() <= 1e-9 * scale
                })
            });
            let in_range = covariance.diagonal().iter().all(|v| (DEVIATIONS.0..=DEVIATIONS.1).contains(&v.sqrt()));
            if !in_range || !covariance.iter().all(|v| v.is_finite()) || !symmetric || covariance.cholesky().is_none() {
                return Err(IdentificationError::Noise { what });
            }
        }
        Ok(())
    }
}

/// Checked measurements with their noise.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasurementSet {
    measurements: Vec<Measurement>,
    noise: Vec<MeasurementNoise>,
}

impl MeasurementSet {
    /// Measurements with the same noise.
    ///
    /// Refused are numbers that are not finite, rows of different lengths, exact copies of a row, displacements that were not measured
    /// (exactly 0), displacements and loads beyond any robot's (50 mm, 0.1 rad, 10 MN, 10 MN·m), sizes that no robot has (units mixed up), displacements against their loads (the opposite
    /// sign) and noise that is not positive definite.
    ///
    /// # Errors
    /// [`IdentificationError`] with the row and the column, or with the units that may have been mixed up.
    pub fn new(measurements: Vec<Measurement>, noise: MeasurementNoise) -> Result<Self, IdentificationError> {
        noise.check()?;
        check_rows(&measurements)?;
        check_zeros(&measurements, &noise)?;
        check_units(&measurements, &noise)?;
        check_sign(&measurements, &noise)?;
        let noise = vec![noise; measurements.len()];
        Ok(Self { measurements, noise })
    }

    /// The set with a noise of its own for each measurement.
    ///
    /// # Errors
    /// [`IdentificationError`] for another number of them or one that is not positive definite.
    pub fn with_noise_of_each(mut self, noise: Vec<MeasurementNoise>) -> Result<Self, IdentificationError> {
        let expected = self.measurements.len();
        if noise.len() != expected {
            let found = noise.len();
            let row = Place::Row(found.min(expected) + 1);
            return Err(IdentificationError::Count { row, what: "noises", found, expected });
        }
        noise.iter().try_for_each(MeasurementNoise::check)?;
        self.noise = noise;
        Ok(self)
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.measurements.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.measurements.is_empty()
    }

    /// The measurements.
    pub fn measurements(&self) -> &[Measurement] {
        &self.measurements
    }

    /// The noise of each.
    pub fn noise(&self) -> &[MeasurementNoise] {
        &self.noise
    }

    /// Those of the given indices (from 0), which must exist.
    pub(crate) fn subset(&self, indices: &[usize]) -> Self {
        Self {
            measurements: indices.iter().map(|i| self.measurements[*i].clone()).collect(),
            noise: indices.iter().map(|i| self.noise[*i]).collect(),
        }
    }
}

fn check_rows(measurements: &[Measurement]) -> Result<(), IdentificationError> {
    let joints = measurements.first().map_or(0, |m| m.q.len());
    let mut seen: HashMap<Vec<u64>, Place> = HashMap::new();
    for (i, m) in measurements.iter().enumerate() {
        let row = Place::Row(i + 1);
        if m.q.len() != joints {
            return Err(IdentificationError::Count {
                row,
                what: "joint coordinates",
                found: m.q.len(),
                expected: joints,
            });
        }
        let joint_columns = m.q.iter().enumerate().map(|(j, v)| (format!("joint {}", j + 1), *v));
        let wrench = WRENCH_ENTRIES.iter().zip(&m.wrench).map(|(c, v)| ((*c).to_owned(), *v));
        let twist = TWIST_ENTRIES.iter().zip(&m.displacement).map(|(c, v)| ((*c).to_owned(), *v));
        if let Some((column, value)) = joint_columns.chain(wrench).chain(twist).find(|(_, v)| !v.is_finite()) {
            return Err(IdentificationError::NotFinite { row, column, value });
        }
        let bits = m.q.iter().chain(&m.wrench).chain(&m.displacement).map(|v| v.to_bits()).collect();
        if let Some(first) = seen.insert(bits, row) {
            return Err(IdentificationError::Repeated { row, first });
        }
    }
    Ok(())
}

/// Refuses displacements that nobody measured: all translations or all rotations exactly 0, unless their noise says that they count for
/// nothing, and single ones under a load.
fn check_zeros(measurements: &[Measurement], noise: &MeasurementNoise) -> Result<(), IdentificationError> {
    for (what, part, least) in [("translations", 0, MEANINGLESS.0), ("rotations", 3, MEANINGLESS.1)] {
        let zero = measurements.iter().all(|m| m.displacement.fixed_rows::<3>(part).amax() == 0.0);
        let counts = noise.displacement.diagonal().fixed_rows::<3>(part).min().sqrt() < least;
        if zero && counts && !measurements.is_empty() {
            return Err(IdentificationError::Zero { what, least });
        }
    }
    let loaded =
        |m: &Measurement| (0..6).any(|i| m.wrench[i].abs() > ALWAYS_BEYOND_NOISE * noise.wrench[(i, i)].sqrt());
    let mut unmoved = (0..measurements.len()).filter(|i| {
        let m = &measurements[*i];
        m.displacement.amax() == 0.0 && loaded(m)
    });
    match unmoved.next() {
        None => Ok(()),
        Some(first) => {
            let (row, found) = (Place::Row(first + 1), unmoved.count() + 1);
            Err(IdentificationError::Unmoved { row, found, of: measurements.len() })
        }
    }
}

fn check_units(measurements: &[Measurement], noise: &MeasurementNoise) -> Result<(), IdentificationError> {
    if measurements.is_empty() {
        return Ok(());
    }
    let [translation, rotation, force, moment] =
        std::array::from_fn(|part| median(measurements.iter().map(|m| m.sizes()[part]).collect()).unwrap_or(0.0));
    let shows = |value: f64, row: usize| {
        let variance = noise.wrench.diagonal().fixed_rows::<3>(row).sum();
        value > BEYOND_NOISE * variance.sqrt()
    };
    let (forced, turned) = (shows(force, 0), shows(moment, 3));
    let within = |what, value: f64, (low, high), unit, remedy| {
        if (low..=high).contains(&value) {
            Ok(())
        } else {
            Err(IdentificationError::Units { what, value, low, high, unit, remedy })
        }
    };
    within("the translation", translation, (0.0, LARGEST.0), "m", "units off by 1000: mm for m?")?;
    within("the rotation", rotation, (0.0, LARGEST.1), "rad", "units off by 1000 or by 57: mrad or degrees for rad?")?;
    // Loads of moments alone may well move the tool point, with no more force than noise.
    let moved_by_moments = !forced && moment > MOMENT_PER_TRANSLATION * translation;
    if force > 0.0 && translation > 0.0 && !moved_by_moments {
        let remedy = "units off by 1000: mm or µm for m, kN for N?";
        within("force per translation", force / translation, FORCE_PER_TRANSLATION, "N/m", remedy)?;
    }
    // Loads of forces alone turn the tool, with no more moment than noise; that a moment is missing is told where it matters.
    if turned && rotation > 0.0 {
        let remedy = "are units wrong by 1000 or 57 (mrad or degrees for rad, kN·m or N·mm for N·m)?";
        within("moment per rotation", moment / rotation, MOMENT_PER_ROTATION, "N·m/rad", remedy)?;
    }
    if forced {
        within("moment per force", moment / force, LEVER, "m", "units off by 1000: N·mm for N·m, kN for N?")?;
    }
    if translation > 0.0 && rotation > 0.0 {
        let remedy = "translations and rotations do not match: mm for m, or mrad or degrees for rad?";
        within("translation per rotation", translation / rotation, TRANSLATION_PER_ROTATION, "m", remedy)?;
    }
    for (i, m) in measurements.iter().enumerate() {
        for (value, (what, limit, unit)) in m.sizes().into_iter().zip(LIMITS) {
            if value > limit {
                return Err(IdentificationError::Implausible { row: Place::Row(i + 1), what, value, limit, unit });
            }
        }
    }
    Ok(())
}

/// Refuses loads of the opposite sign. A compliance is positive definite: every load does work on the robot.
fn check_sign(measurements: &[Measurement], noise: &MeasurementNoise) -> Result<(), IdentificationError> {
    let against = measurements.iter().filter(|m| {
        let (w, x) = (&m.wrench, &m.displacement);
        let variance = (noise.displacement * w).dot(w) + (noise.wrench * x).dot(x);
        w.dot(x) < -BEYOND_NOISE * variance.sqrt()
    });
    let (found, of) = (against.count(), measurements.len());
    if 2 * found > of { Err(IdentificationError::Sign { found, of }) } else { Ok(()) }
}
