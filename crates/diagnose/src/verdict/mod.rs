//! From records to the verdict: alarm, screening, selection, rivals, names.

mod alarm;
mod attempt;
mod base_parameters;
mod columns;
mod curves;
mod diagnose;
mod explanation;
mod fewer;
mod findings;
mod held_out;
mod hidden;
mod hold;
mod jumps;
mod motion;
mod moved_parameters;
mod noise;
mod periods;
mod places;
mod precedence;
mod proven;
mod ranking;
mod refused;
mod repeats;
mod rivals;
mod scale;
mod score;
mod search;
mod select;
mod sign_flip;
mod stage;
mod unnamed;
mod validation;
mod write;

#[cfg(test)]
mod tests;

pub use diagnose::diagnose;
pub use stage::Stage;
