//! A run on the vibrating plate as text, JSON, table and figures.

mod comparison;
mod figures;
mod json;
mod page;
mod table;
mod text;

pub use figures::{animation, comparison_figure, figures, motion_figure, outline, plan_view_figure};
pub use json::json;
pub use page::page;
pub use table::{csv_columns, csv_rows};
pub use text::text;
