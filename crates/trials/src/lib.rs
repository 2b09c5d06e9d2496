//! Systems, effects and logs drawn at random: what tests, examples and the demonstration are tried on.
