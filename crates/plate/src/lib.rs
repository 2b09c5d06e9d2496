//! The vibrating hyper-plate: published model, experiments, objects and scenarios.
//!
//! A plate translates along its x axis, `X(t)`, and rotates about the same axis, `theta(t)`. An object lies on it without
//! being grasped; its position `(x, y)` and yaw `phi` in the plate frame are moved by dry friction alone.
//!
//! ```
//! use bracketry_plate::{Establishing, Harmonic, ModelObject, PeriodicMotion, Shape, mean_velocity, published};
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

mod area;
mod body;
mod control;
mod driven;
mod error;
mod experiment;
mod friction;
mod log;
mod model;
mod motion;
mod object;
mod recording;
mod run;

pub use area::{
    AreaContact, AreaEvent, AreaOutcome, AreaRecord, AreaSample, AreaSettings, EnergyBalance, Footprint, Load, Scheme,
    Support,
};
pub use body::{
    BodyEvent, BodyEventKind, BodyOnPlate, BodySettings, BodyStop, ObjectMode, ObjectOnPlate, ObjectStop, PlateFrame,
    RigidState,
};
pub use control::{
    AreaLoopPlant, Arrival, Command, Estimate, Learned, Measurement, MoveError, MovePlanner, MoveReport, PlannedMove,
    PlanningBudget, PlateController, PlateLimits, PoseController, PoseReport, PoseSettings, PoseStatus, RESOLUTION,
    RoundedContact, Uncertainty, move_with, plate_move, target_of, with_duration,
};
pub use driven::{AreaObject, Course, DrivenObject, ModelObject, STATES};
pub use error::PlateError;
pub use experiment::{
    AmplitudeLaw, AmplitudeStep, Coordinate, Establishing, Experiment, Limits, Map, MeanVelocity, Run, Stage, Summary,
    TwoStep, linspace, mean_velocity, summarize, sweep, two_step, two_step_on, velocity_field,
};
pub use friction::Friction;
pub use log::{Jump, LoggedMotion, PlateColumns, PlateLog};
pub use model::{
    Energy, FlatContact, GRAVITY, Terms, energy, first_principles, flat_contact, normal_load, published, reduced,
};
pub use motion::{Drive, ExpressionMotion, Harmonic, PeriodicMotion, PlateKinematics, PlateMotion};
pub use object::{Bearing, Object, Quadrature, Shape, ShapeError, Vertices};
pub use recording::{
    PlateMismatch, Random, RecordingError, RecordingSettings, SyntheticLog, multisine, seed_of, synthetic_log,
};
pub use run::{
    Assumption, Comparison, Dependence, Deviation, ErrorsAtStart, ExperimentKind, FrictionLaw, GivenOption,
    NumberOption, OppositeSigns, PeriodStart, PlateExperiment, PlateModel, PlateOptions, PlateOutcome, PlateRow,
    PlateRun, PlateRunError, PlateSetup, PlateStop, PoseDeviations, ScaledInput, SetupError, SignComparison,
    SignSource, SignStatus, TextOption,
};
