//! Contact over the whole footprint of a flat object.

mod contact;
mod outcome;
mod pressure;
mod record;
mod settings;
mod stage;

pub use contact::AreaContact;
pub use outcome::AreaOutcome;
pub use pressure::{Footprint, Load, Support};
pub use record::{AreaEvent, AreaRecord, AreaSample, EnergyBalance};
pub use settings::{AreaSettings, Scheme};
