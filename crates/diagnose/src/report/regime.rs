//! When a model is wrong: the regimes by which errors are told apart.

/// A regime of motion or of another quantity; `name` is that of the quantity.
#[derive(Clone, Debug, PartialEq)]
pub enum Regime {
    /// A velocity of one sign.
    Motion {
        /// Its name.
        name: String,
        /// Whether it has dry friction, so that it slides.
        sliding: bool,
        /// Whether it is positive.
        positive: bool,
    },
    /// A velocity near zero for longer than a reversal takes.
    Rest {
        /// Its name.
        name: String,
        /// Largest velocity that counts as near zero, in its unit.
        limit: f64,
    },
    /// A velocity that passes zero.
    Reversal {
        /// Its name.
        name: String,
        /// Largest velocity that counts as near zero, in its unit.
        limit: f64,
    },
    /// The size of the rate of a state against its root mean square.
    Rate {
        /// Name of the state.
        name: String,
        /// Whether it is larger.
        above: bool,
        /// The root mean square, in the unit of the state per second.
        typical: f64,
    },
    /// A third of the range of a quantity.
    Third {
        /// Its name.
        name: String,
        /// Where the third starts; `None` for the lowest.
        from: Option<f64>,
        /// Where it ends; `None` for the highest.
        to: Option<f64>,
    },
    /// The sign of an angle.
    Tilt {
        /// Its name.
        name: String,
        /// Whether it is positive.
        positive: bool,
    },
}
