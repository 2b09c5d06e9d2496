//! Figures: time series with friction modes, views from above, line, marker and bar charts.
//!
//! A figure is plain data with builder methods. Its `draw` checks the data and gives a [`Drawing`], which holds the
//! SVG and renders the PNG from that very SVG with an embedded font, so that a figure looks the same on every
//! machine. All figures are 800 pixels wide (1600 in the PNG) with 11-point text.
//!
//! | figure | shows |
//! |---|---|
//! | [`TimeSeries`] | stacked [`Panel`]s over one time axis, with targets, bounds and shaded [`Interval`]s |
//! | [`PlanView`] | an object's path and [`Outline`] seen from above, pale to dark with time |
//! | [`XyChart`] | one panel over any quantity, also of whole numbers |
//! | [`BarChart`] | groups of bars |
//! | [`IntervalChart`] | estimates with their intervals, one row for each |
//! | [`HeatMap`], [`RegimeMap`] | a number or a category over two quantities, with contours and [`Mark`]s |
//! | [`VectorField`] | [`Arrow`]s over two quantities, colored by a third |
//! | [`Animation`] | an object on a shaken and tilted plate, from above and from the side, as a GIF |
//! | [`TileChart`] | [`TileGrid`]s of colored, labeled tiles in named rows and columns |
//!
//! What is the same thing in several figures, such as a model before and after, looks the same: [`Role`]. Lines with more points than the image has pixels are thinned so that no extreme is lost. The SVG also says the scales of its axes, the names
//! of its curves, and the values of its bars, so that a page can show the value under the pointer.

mod animation;
mod axes;
mod bar_chart;
mod canvas;
mod color;
mod color_map;
mod contour;
mod decimate;
mod drawing;
mod error;
mod field;
mod gif_images;
mod glyphs;
mod heat_map;
mod interval_chart;
mod legend;
mod motion;
mod panel;
mod plan_view;
mod reading;
mod role;
mod setters;
mod stack;
mod text;
mod ticks;
mod tile_chart;
mod vector_field;

pub use animation::{Animation, Snapshot};
pub use bar_chart::BarChart;
pub use canvas::Dash;
pub use color::Color;
pub use color_map::ColorMap;
pub use drawing::{Drawing, Saved};
pub use error::{PlotError, Result};
pub use field::Mark;
pub use heat_map::{HeatMap, RegimeMap};
pub use interval_chart::{Estimated, IntervalChart};
pub use motion::{Outline, Pose, RecordedMotion};
pub use panel::{Interval, Level, Markers, Panel, Series};
pub use plan_view::{PlanView, Scene};
pub use role::Role;
pub use stack::{TimeSeries, XyChart};
pub use tile_chart::{Tile, TileChart, TileGrid};
pub use vector_field::{Arrow, VectorField};
