//! Which terms a model has.

/// Which terms a model of the plate has. All are on by default; each off leaves its equation without that term.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[expect(clippy::struct_excessive_bools, reason = "terms are independent of each other")]
pub struct Terms {
    /// `y θ'²` in `y''`.
    pub centrifugal: bool,
    /// `y θ''` in the load.
    pub euler: bool,
    /// `2 y' θ'` in the load.
    pub coriolis: bool,
    /// `h θ''` in `y''` and `h θ'²` in the load.
    pub thickness: bool,
    /// Friction against the slip; without, against each component of the slip on its own, by its sign, and against the
    /// spin with the mean second moment.
    pub coupled: bool,
    /// Friction along x follows the load; without, it is that of the load `g`.
    pub load_along_x: bool,
    /// `Sxy θ'²` in the yaw.
    pub gyroscopic: bool,
    /// Torque of the friction along y, `−μ Sxy θ'' e_y`; of the reduced model only.
    pub torque_across: bool,
    /// Friction against the spin; of the reduced model only.
    pub yaw_friction: bool,
}

impl Default for Terms {
    fn default() -> Self {
        Self {
            centrifugal: true,
            euler: true,
            coriolis: true,
            thickness: true,
            coupled: true,
            load_along_x: true,
            gyroscopic: true,
            torque_across: true,
            yaw_friction: true,
        }
    }
}

impl Terms {
    /// The terms of the published model: of these only `y θ''` in the load.
    pub const PUBLISHED: Terms = Terms {
        centrifugal: false,
        euler: true,
        coriolis: false,
        thickness: false,
        coupled: false,
        load_along_x: false,
        gyroscopic: false,
        torque_across: false,
        yaw_friction: false,
    };

    /// The names of the terms in the model files, but for `coupled`, which is no factor.
    pub(super) fn factors(self) -> [(&'static str, bool); 8] {
        [
            ("centrifugal", self.centrifugal),
            ("euler", self.euler),
            ("coriolis", self.coriolis),
            ("thickness", self.thickness),
            ("load_along_x", self.load_along_x),
            ("gyroscopic", self.gyroscopic),
            ("torque_across", self.torque_across),
            ("yaw_friction", self.yaw_friction),
        ]
    }
}
