//! From a table of samples to a [`Record`]: which column is what, what is wrong with it, how noisy it is.

mod audit;
mod clock;
mod consistency;
mod decimate;
mod driving;
mod heading;
mod noise;
mod npy;
mod npz;
mod origin;
mod outliers;
mod record;
mod repair;
mod roles;
mod settings;
mod warning;

pub use audit::{Audit, ColumnAudit};
pub use noise::{Noise, estimate_noise};
pub use record::read_record;
pub use settings::RecordSettings;
pub use warning::Warning;
