//! The vibrating hyper-plate: published model, experiments, objects and scenarios.
//!
//! A plate translates along its x axis, `X(t)`, and rotates about the same axis, `theta(t)`. An object lies on it without
//! being grasped; its position `(x, y)` and yaw `phi` in the plate frame are moved by dry friction alone.
//!
//! ```
//! use bracketry_plate::{Harmonic, ModelObject, PeriodicMotion, Shape, published};
//! use bracketry_plate::experiment::{Establishing, mean_velocity};
//! use bracketry_sim::SimulationSettings;
//! let model = published(&Shape::REFERENCE_ELLIPSE, 0.3).unwrap();
//! let mut object = ModelObject::new(&model, [0.0; 6], &SimulationSettings::default()).unwrap();
//! // The plate shakes with two harmonics, 3 Hz, and does not tilt: where the object lies, it creeps along x.
//! let harmonic = |amplitude, phase| Harmonic { amplitude, phase };
//! let displacement = vec![harmonic(0.04, 0.0), harmonic(0.02, 0.5)];
//! let motion = PeriodicMotion { frequency: 3.0, displacement, tilt: vec![], mean_tilt: 0.0 };
//! let mean = mean_velocity(&mut object, &motion, [0.0; 3], Establishing::default()).unwrap();
//! assert!(mean.mean[0].abs() > 1e-3 && mean.mean[1].abs() < 1e-9);
//! ```

pub mod area;
pub mod body;
pub mod control;
pub mod driven;
mod error;
pub mod experiment;
mod friction;
pub mod log;
pub mod model;
pub mod motion;
pub mod object;
pub mod recording;
pub mod run;

pub use control::plate_move;
pub use driven::{AreaObject, DrivenObject, ModelObject, STATES};
pub use error::PlateError;
pub use friction::Friction;
pub use log::PlateLog;
pub use model::{GRAVITY, first_principles, published, reduced};
pub use motion::{Harmonic, PeriodicMotion, PlateKinematics, PlateMotion};
pub use object::{Object, Shape};
pub use run::PlateExperiment;
