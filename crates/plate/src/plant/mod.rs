//! Plants: whatever moves an object on an imposed plate motion.

mod area_plant;
mod interface;
mod model_plant;
mod search;

pub use area_plant::AreaPlant;
pub use interface::{Course, Plant, STATES};
pub use model_plant::ModelPlant;
pub(crate) use search::{crossing, least_load};
