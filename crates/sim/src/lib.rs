//! Piecewise-smooth simulation: events, sliding and sticking, dense output.
