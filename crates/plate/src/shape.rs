//! Shapes of the object on the plate.

use serde::{Deserialize, Serialize};

/// A uniform flat object.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Shape {
    /// An ellipse with semi-axis `a` along its own x and `b` along its own y, in metres.
    Ellipse {
        /// Semi-axis along x.
        a: f64,
        /// Semi-axis along y.
        b: f64,
    },
    /// A disk, radius in metres.
    Disk {
        /// Radius.
        radius: f64,
    },
}

impl Shape {
    /// The ellipse of the reference results, 0.15 m × 0.10 m.
    pub const REFERENCE_ELLIPSE: Shape = Shape::Ellipse { a: 0.15, b: 0.10 };
    /// The disk of the reference results, radius 0.12 m.
    pub const REFERENCE_DISK: Shape = Shape::Disk { radius: 0.12 };

    /// Principal second moments per mass `(Sa, Sb)` in m², along the object's own axes: `a²/4`, `b²/4`.
    ///
    /// ```
    /// use bracketry_plate::Shape;
    /// assert_eq!(Shape::Ellipse { a: 2.0, b: 1.0 }.second_moments(), (1.0, 0.25));
    /// ```
    pub fn second_moments(self) -> (f64, f64) {
        let (a, b) = match self {
            Shape::Ellipse { a, b } => (a, b),
            Shape::Disk { radius } => (radius, radius),
        };
        (a * a / 4.0, b * b / 4.0)
    }

    /// Second moments per mass in plate axes at yaw `phi`, `(Sxx, Syy, Sxy)`: `Sxx = c²Sa + s²Sb`, `Syy = s²Sa + c²Sb`,
    /// `Sxy = c s (Sa − Sb)`.
    pub fn second_moments_at(self, phi: f64) -> (f64, f64, f64) {
        let (sa, sb) = self.second_moments();
        let (s, c) = phi.sin_cos();
        (c * c * sa + s * s * sb, s * s * sa + c * c * sb, c * s * (sa - sb))
    }

    /// Yaw inertia per mass `Sa + Sb` in m².
    pub fn yaw_inertia(self) -> f64 {
        let (sa, sb) = self.second_moments();
        sa + sb
    }
}
