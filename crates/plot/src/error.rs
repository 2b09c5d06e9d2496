//! What can go wrong when drawing.

use std::path::PathBuf;

use plotters::drawing::DrawingAreaErrorKind;
use resvg::usvg;

/// The result of this crate's fallible functions.
pub type Result<T> = std::result::Result<T, PlotError>;

/// Why a figure could not be drawn or written.
#[derive(Debug, thiserror::Error)]
pub enum PlotError {
    /// A value is NaN, infinite or beyond ±1e300, where scales overflow.
    #[error(
        "`{series}`: value {value} at index {index} cannot be drawn; every value must be finite (and within ±1e300)"
    )]
    NotFinite {
        /// The series, bound or interval that holds the value.
        series: String,
        /// The position of the value in it, from 0.
        index: usize,
        /// The value itself.
        value: f64,
    },
    /// The columns of one series differ in length.
    #[error("`{series}`: {expected} abscissas but {found} values; both must have the same length")]
    LengthMismatch {
        /// The series.
        series: String,
        /// Length of the first column (abscissas, times, category names).
        expected: usize,
        /// Length of the other column.
        found: usize,
    },
    /// An interval ends before it starts.
    #[error("`{name}`: the interval from {start} to {end} is reversed")]
    ReversedInterval {
        /// The interval's category, or the axis whose limits they are.
        name: String,
        /// Given start.
        start: f64,
        /// Given end.
        end: f64,
    },
    /// The figure has no panel, scene or group to draw.
    #[error("the figure has nothing to draw: add at least one {missing}")]
    NoContent {
        /// What is missing.
        missing: &'static str,
    },
    /// A tile lies outside its grid.
    #[error("a tile in column {column} and row {row} lies outside its grid; both count from 0")]
    OutsideGrid {
        /// Its column.
        column: usize,
        /// Its row.
        row: usize,
    },
    /// The places of a map are not in increasing order.
    #[error("`{axis}`: value {value} at index {index} does not exceed the one before; sort the axis and its values")]
    Unordered {
        /// The axis.
        axis: String,
        /// The position of the value in it, from 0.
        index: usize,
        /// The value itself.
        value: f64,
    },
    /// A cell or an image has a category that the figure does not know.
    #[error("category {category} is not among the {known} of the figure; add it with `category`")]
    UnknownCategory {
        /// Its number, from 0.
        category: usize,
        /// How many the map has.
        known: usize,
    },
    /// A file could not be written.
    #[error("cannot write {}: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The operating system's reason.
        source: std::io::Error,
    },
    /// The images of an animation could not be encoded.
    #[error("cannot encode the animation: {0}")]
    Encode(#[from] gif::EncodingError),
    /// The drawing back end failed.
    #[error("cannot draw: {0}")]
    Backend(#[from] DrawingAreaErrorKind<std::io::Error>),
    /// The SVG could not be read back for rasterizing.
    #[error("cannot rasterize: {0}")]
    Rasterize(#[from] usvg::Error),
    /// The image is too large to be drawn or held in memory.
    #[error("an image of {width} × {height} pixels is too large")]
    TooLarge {
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
    },
}

/// Largest magnitude that is drawn: sums and differences of two such values stay finite.
const LARGEST: f64 = 1e300;

/// Checks that all `values` can be drawn.
pub(crate) fn check_finite(series: &str, values: &[f64]) -> Result<()> {
    match values.iter().position(|v| v.is_nan() || v.abs() > LARGEST) {
        None => Ok(()),
        Some(index) => Err(PlotError::NotFinite { series: series.to_owned(), index, value: values[index] }),
    }
}

/// Checks that two columns of a series have the same length.
pub(crate) fn check_lengths(series: &str, expected: usize, found: usize) -> Result<()> {
    if expected == found {
        return Ok(());
    }
    Err(PlotError::LengthMismatch { series: series.to_owned(), expected, found })
}

/// Checks that the places of an axis are finite and increase.
pub(crate) fn check_increasing(axis: &str, values: &[f64]) -> Result<()> {
    check_finite(axis, values)?;
    match values.windows(2).position(|w| w[1] <= w[0]) {
        None => Ok(()),
        Some(before) => {
            Err(PlotError::Unordered { axis: axis.to_owned(), index: before + 1, value: values[before + 1] })
        }
    }
}

/// Checks that an interval is finite and not reversed.
pub(crate) fn check_interval(name: &str, start: f64, end: f64) -> Result<()> {
    check_finite(name, &[start, end])?;
    if start <= end {
        return Ok(());
    }
    Err(PlotError::ReversedInterval { name: name.to_owned(), start, end })
}
