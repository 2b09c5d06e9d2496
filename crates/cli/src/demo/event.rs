//! What is heard of the story while it is told.

use bracketry::diagnose::Report;
use bracketry::lie::Analysis;
use bracketry::plate::recording::SyntheticLog;

use super::on_equations::MoveOnEquations;
use super::on_plant::MoveOnPlant;

/// What is going on while the story is told.
#[derive(Clone, Copy)]
pub enum StoryEvent<'a> {
    /// Work that takes its time begins: chapter, from 1 on, and what is done.
    Working(usize, &'a str),
    /// A chapter, or a part of one, is done: its text.
    Told(&'a str),
    /// Data are complete.
    Found(Finding<'a>),
}

/// What a chapter has found.
#[derive(Clone, Copy)]
pub enum Finding<'a> {
    /// Chapter 1: what the inputs reach.
    Analysis(&'a Analysis),
    /// Chapter 2: the move on the published equations.
    OnEquations(&'a MoveOnEquations),
    /// Chapter 3: the move on the plant with the published model.
    AsPublished(&'a MoveOnPlant),
    /// Chapter 4: what was recorded.
    Logs(&'a [SyntheticLog]),
    /// Chapter 4: what is wrong.
    Diagnosis(&'a Report),
    /// Chapter 6: the move on the plant with the extended model.
    Extended(&'a MoveOnPlant),
}
