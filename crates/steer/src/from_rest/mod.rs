//! Motion from rest to rest under dry friction: which coordinates inputs within bounds can change if everything rests before and
//! after.
//!
//! At rest, dry friction balances all small forces, so that small-time local controllability says nothing about it. Here, *no* is
//! proven by the friction cone: for all inputs within their bounds, friction balances the other forces. *Yes* comes from loops of
//! the inputs that displace the coordinates, simulated with exact stick and slip.
//!
//! ```
//! use bracketry_steer::from_rest::{Answer, Bound, FromRestOptions, Proof, from_rest};
//! use bracketry_system::System;
//! let text = "states = ['x', 'v']\ninputs = ['X']\ndynamics = { x = 'v', v = '-der(X,2) - 3*sign(v)' }";
//! let table = System::parse("table.toml", text).unwrap();
//! let within = |bounds| FromRestOptions { bounds: Bound::list(bounds).unwrap(), ..FromRestOptions::default() };
//! assert_eq!(from_rest(&table, &within("der(X,2)=-3..3")).unwrap().answer, Answer::No);
//! assert_eq!(from_rest(&table, &within("der(X,2)=-4..4")).unwrap().answer, Answer::Yes { proof: Proof::Proven });
//! ```

mod bounds;
pub(crate) mod decide;
pub(crate) mod displacement;
mod driven;
mod error;
mod grid;
mod held;
mod map;
mod margin;
pub(crate) mod meeting;
pub(crate) mod model;
mod reason;
mod result;
mod sign;
pub(crate) mod span;
mod speed;
pub(crate) mod strokes;

pub use bounds::Bound;
pub use decide::from_rest;
pub use error::FromRestError;
pub use grid::{Grid, GridPoint};
pub use held::{Cone, Motion};
pub use map::{CellAnswers, FromRestMap, Threshold, from_rest_map};
pub use margin::margin;
pub use meeting::Return;
pub use reason::FromRestReason;
pub use result::{Answer, CoordinateAnswer, Displacement, FromRest, FromRestOptions, Proof, Stroke};
pub use sign::Holds;
pub use strokes::Shape;
