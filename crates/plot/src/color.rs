//! Colors that readers with any color vision tell apart.

/// An sRGB color.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Color(
    /// Red, 0 to 255.
    pub u8,
    /// Green, 0 to 255.
    pub u8,
    /// Blue, 0 to 255.
    pub u8,
);

impl Color {
    /// Blue.
    pub const BLUE: Self = Self(0, 114, 178);
    /// Vermillion.
    pub const VERMILLION: Self = Self(213, 94, 0);
    /// Bluish green.
    pub const GREEN: Self = Self(0, 138, 100);
    /// Reddish purple.
    pub const PURPLE: Self = Self(184, 94, 150);
    /// Orange.
    pub const ORANGE: Self = Self(222, 148, 0);
    /// Sky blue.
    pub const SKY: Self = Self(70, 165, 220);
    /// Near black, for text and targets.
    pub const INK: Self = Self(38, 38, 38);
    /// Mid gray.
    pub const GRAY: Self = Self(110, 110, 110);

    /// Number of different colors of series.
    pub(crate) const SERIES: usize = 7;

    /// The color of series number `index`, after Okabe and Ito (2008), slightly darkened for thin lines; from
    /// the eighth series on the colors repeat.
    pub fn series(index: usize) -> Self {
        const COLORS: [Color; Color::SERIES] =
            [Color::BLUE, Color::VERMILLION, Color::GREEN, Color::PURPLE, Color::ORANGE, Color::SKY, Color::INK];
        COLORS[index % COLORS.len()]
    }

    /// The pale background of category number `index`; the first three differ in lightness too, for prints in gray.
    pub fn band(index: usize) -> Self {
        const COLORS: [Color; 6] = [
            Color(226, 240, 250),
            Color(251, 221, 193),
            Color(206, 206, 206),
            Color(219, 240, 224),
            Color(241, 225, 237),
            Color(249, 243, 204),
        ];
        COLORS[index % COLORS.len()]
    }

    /// The mixture `(1 − s)·self + s·other`, s from 0 to 1.
    #[must_use]
    pub fn mix(self, other: Self, s: f64) -> Self {
        let channel = |a: u8, b: u8| (f64::from(a) + s.clamp(0.0, 1.0) * (f64::from(b) - f64::from(a))).round() as u8;
        Self(channel(self.0, other.0), channel(self.1, other.1), channel(self.2, other.2))
    }

    /// The shade of this color for time fraction `s`: pale at 0, dark at 1.
    #[must_use]
    pub fn shade(self, s: f64) -> Self {
        let pale = self.mix(Self(255, 255, 255), 0.68);
        let dark = self.mix(Self(0, 0, 0), 0.38);
        pale.mix(dark, s)
    }
}
