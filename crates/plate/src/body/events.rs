//! What happens to a body on the plate.

/// Something that happened at an instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyEvent {
    /// When, in s.
    pub time: f64,
    /// What.
    pub kind: BodyEventKind,
}

/// What can happen to a body on the plate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BodyEventKind {
    /// The center of pressure of the flat object reached its rim: it starts to tip.
    Tipping,
    /// The last contact opened.
    LiftOff,
    /// The body came down from flight; its [`Impact`](Self::Impact) follows.
    Landing,
    /// Points hit the plate.
    Impact {
        /// Speed of approach of the fastest of them in m/s.
        speed: f64,
        /// Sum of the normal impulses in N s.
        impulse: f64,
        /// Kinetic energy relative to the plate that was lost, in J.
        loss: f64,
    },
    /// The body came to lie flat.
    Settled {
        /// Whether it lies on the face that was the upper one at first.
        overturned: bool,
    },
}
