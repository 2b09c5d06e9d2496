//! Lie brackets, distributions, accessibility and the functions that no input influences.
