//! The object as a rigid body with thickness, free to tip, to lift off, to fly and to land.

mod body_on_plate;
mod contact;
mod contact_step;
mod events;
mod flight;
mod flight_step;
mod frame;
mod locate;
mod normal;
mod object_on_plate;
mod settings;
mod solid;

pub use body_on_plate::{BodyOnPlate, BodyStop};
pub use events::{BodyEvent, BodyEventKind};
pub use frame::{PlateFrame, RigidState};
pub use object_on_plate::{ObjectMode, ObjectOnPlate, ObjectStop};
pub use settings::BodySettings;
