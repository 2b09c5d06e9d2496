//! Figures: time series, plan views, friction bands; SVG and PNG.
