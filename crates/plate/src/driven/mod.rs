//! Objects on a plate with imposed motion.

mod area_object;
mod interface;
mod model_object;
mod search;

pub use area_object::AreaObject;
pub use interface::{Course, DrivenObject, STATES};
pub use model_object::ModelObject;
pub(crate) use search::{crossing, least_load};
