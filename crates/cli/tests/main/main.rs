//! The tests of this crate: one program, a module for each topic.
#![allow(clippy::unwrap_used)]

mod affinize;
mod axes;
mod cases;
mod certify;
mod command;
mod common;
mod compensate;
mod control;
mod demo;
mod diagnose;
mod diagnose_real;
mod documents;
mod experiment;
mod export;
mod from_rest;
mod front_door;
mod getting_started;
mod implicit_models;
mod limits;
mod live;
mod mistakes;
mod operating_point;
mod pages;
mod parameters;
mod plate_bearing;
mod plate_command;
mod plate_comparison;
mod report;
mod simulate;
mod steer;
mod stiffness;
mod stored_output;
mod story;
mod transform;
mod tutorial;
