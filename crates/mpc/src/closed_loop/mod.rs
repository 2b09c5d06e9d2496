//! Controller and plant together, with delay, noise, faults and counted outcomes.

mod counts;
mod delay_compensation;
mod faults;
mod plant;
mod sampled_loop;
mod smooth_plant;

pub use counts::{Counts, LateSamples, PhaseTimes, ReasonCounts, SolveTimes, SourceCounts};
pub use delay_compensation::DelayCompensated;
pub use faults::Fault;
pub use plant::{Plant, PlantEquations, PlantStopped, RungeKuttaPlant};
pub use sampled_loop::{
    ClosedLoop, FaultFunction, LoopSettings, MeasurementFunction, NoiseFunction, Sample, SampledLoop, run_closed_loop,
};
pub use smooth_plant::{Refined, SmoothPlant};
