//! Models of the object on the plate as differential equations, and where they come from.

mod derivation;
mod energy;
mod first_principles;
mod load;
mod parameters;
mod published;
mod reduced;
mod terms;

pub use derivation::{FlatContact, flat_contact};
pub use energy::{Energy, energy};
pub use first_principles::first_principles;
pub use load::{GRAVITY, normal_load};
pub use published::published;
pub use reduced::reduced;
pub use terms::Terms;
