//! What curves, bars and paths stand for.

use crate::canvas::Dash;
use crate::color::Color;

/// What a curve, a bar or a path stands for. It has one color and one kind of line in all figures, so that nobody takes one model for
/// another between two of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// The model that was given, such as a published one.
    Given,
    /// The given model with its parameters fitted anew.
    Refitted,
    /// The given model with terms added.
    Extended,
    /// What was measured.
    Measured,
    /// What a model promises, before anything moves.
    Promised,
}

impl Role {
    /// Its color.
    pub fn color(self) -> Color {
        match self {
            Self::Given => Color::VERMILLION,
            Self::Refitted => Color::PURPLE,
            Self::Extended => Color::BLUE,
            Self::Measured => Color::INK,
            Self::Promised => Color::GRAY,
        }
    }

    /// Its kind of line, for prints in gray.
    pub fn dash(self) -> Dash {
        match self {
            Self::Given => Dash::Dashed,
            Self::Refitted => Dash::DashDot,
            Self::Extended | Self::Measured | Self::Promised => Dash::Solid,
        }
    }
}
