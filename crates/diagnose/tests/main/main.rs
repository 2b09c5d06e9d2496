//! The tests of this crate: one program, a module for each topic.
#![allow(clippy::unwrap_used)]

#[path = "../../../../tests/main/common/tier.rs"]
mod tier;

mod actuators;
mod apply;
mod archives;
mod audits;
mod base_parameters;
mod caveats;
mod changes;
mod effort;
mod extend;
mod fewest_causes;
mod force_error;
mod headings;
mod hidden;
mod hysteresis;
mod integrate;
mod library;
mod library_dynamics;
mod noise;
mod outliers;
mod places;
mod records;
mod refused;
mod repairs;
mod selection;
mod spin_in_slip;
mod stop_flag;
mod study;
mod temperatures;
mod verdict_rules;
