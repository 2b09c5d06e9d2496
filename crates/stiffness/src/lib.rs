//! The stiffness of a serial robot: how it bends under a load, how this is measured, and how it is compensated.
//!
//! One convention throughout. A **wrench** is `[force; moment]` (N, N·m) that the process exerts **on the robot**; a **twist**
//! is a small displacement `[translation; rotation vector]` (m, rad); both belong to a frame: its origin and its axes.
//! Stiffness maps twists to wrenches, `W = K ΔX`, compliance the other way, `ΔX = C W`; a positive definite compliance lets the
//! robot yield to the load. Base axes at the tool point unless something else is said.
//!
//! ```
//! use bracketry_stiffness::{Deformation, DhParameters, JointSpring, Robot, Springs, Wrench};
//! // An arm of 1 m on one joint, 1000 N·m/rad, 10 N across its end.
//! let robot = Robot::from_modified_dh("arm", &[DhParameters { alpha: 0.0, a: 0.0, d: 0.0, offset: 0.0 }])
//!     .with_tool(nalgebra::Isometry3::translation(1.0, 0.0, 0.0));
//! let springs = Springs::of_joints(vec![JointSpring::linear(1000.0)]);
//! let load = Wrench::new(0.0, 10.0, 0.0, 0.0, 0.0, 0.0);
//! let bent = Deformation::linear(&robot, &springs, &[0.0], &load).unwrap();
//! assert!((bent.tool[1] - 0.01).abs() < 1e-12);
//! ```

mod compensate;
mod compliance;
mod error;
mod identify;
mod milling;
mod robot;
mod robot_file;
mod runs;
mod sensor;

pub use compensate::{
    CompensationError, CompensationSettings, Compensator, Correction, Fault, FilterOrder, Stability, Status,
    WrenchFilter, stability,
};
pub use compliance::{Deformation, DeformationModel, JointSpring, Springs, geometric_stiffness, loaded_compliance};
pub use error::StiffnessError;
pub use identify::{
    Advice, Attenuation, CartesianEstimate, CartesianEstimator, Comparison, Found, IdentificationError, Identified,
    LostMotion, LostMotionReport, Measurement, MeasurementNoise, MeasurementSet, Method, MethodReport, Outliers, Place,
    PoseChoice, PoseInformation, ResidualSample, SpringFit, SpringFitSettings, SpringParameter, Unidentified, Unloaded,
    compare, explain_residual, fit_springs, identify_cartesian,
};
pub use milling::{CircleRun, CircleSample, Cutting, MillingCircle, PathError};
pub use robot::{
    DhParameters, Joint, JointKind, Kinematics, Robot, Twist, UrdfError, Wrench, displaced, displacement_between,
    twist_adjoint, wrench_adjoint,
};
pub use robot_file::{NoiseLevels, RobotFile, with_springs};
pub use runs::{
    ChosenPoses, CompensatedLog, CompensatedRow, Expectation, FaultCount, Identification, LoopGain, MethodFigures,
    PredictedTranslation, RobotLog, SpringResidual, StiffnessRunError, TWIST_COLUMNS, WRENCH_COLUMNS, Weighing,
    Withheld,
};
pub use sensor::{ForceSensor, Payload, PayloadError, PayloadEstimate, StaticReading, identify_payload};
