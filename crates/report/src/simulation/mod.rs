//! A simulation as text, JSON, tables and a figure.

mod breakdown;
mod columns;
mod figure;
mod friction;
mod json;
mod page;
mod table;
mod text;

pub use breakdown::{breakdown, stop};
pub use figure::figure;
pub use friction::{friction_bands, friction_colors};
pub use json::json;
pub use page::page;
pub use table::{Event, events, table};
pub use text::text;
