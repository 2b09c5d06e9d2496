//! Color maps: numbers as colors whose differences look as large as those of the numbers.
//!
//! A map is a path through the Oklab color space (Ottosson 2020), in which equal distances look about equally
//! different, through a few control points and parametrized by its length. Lightness rises throughout (or toward the
//! middle of a diverging map), so that the order of values survives gray printing and any color vision.

use std::sync::OnceLock;

use crate::color::Color;

/// Entries of the tables that colors are read from.
const ENTRIES: usize = 256;
/// Pieces between two control points when the length is measured.
const PIECES: usize = 64;

/// Which colors stand for which numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ColorMap {
    /// Dark violet through blue and green to light yellow: for quantities that go from less to more.
    #[default]
    Sequential,
    /// Blue through near white to red-brown, white in the middle: for quantities with a sign. Ranges that are not set
    /// are made symmetric about zero.
    Diverging,
    /// Sky blue through near black to orange, dark in the middle: for lines and arrows on white whose color has a
    /// sign. Ranges that are not set are made symmetric about zero.
    DivergingDark,
}

/// Control points of the sequential map: lightness, chroma and hue in degrees.
const SEQUENTIAL: [(f64, f64, f64); 6] = [
    (0.26, 0.115, 305.0),
    (0.40, 0.120, 276.0),
    (0.54, 0.095, 232.0),
    (0.67, 0.110, 175.0),
    (0.80, 0.160, 139.0),
    (0.93, 0.165, 106.0),
];

/// Control points of the diverging map.
const DIVERGING: [(f64, f64, f64); 7] = [
    (0.36, 0.120, 262.0),
    (0.60, 0.120, 250.0),
    (0.80, 0.070, 243.0),
    (0.96, 0.000, 0.0),
    (0.81, 0.080, 58.0),
    (0.62, 0.125, 48.0),
    (0.38, 0.105, 35.0),
];

/// Control points of the diverging map that is dark in the middle.
const DARK: [(f64, f64, f64); 5] =
    [(0.76, 0.110, 235.0), (0.53, 0.110, 245.0), (0.27, 0.000, 0.0), (0.53, 0.120, 45.0), (0.76, 0.140, 60.0)];

impl ColorMap {
    /// The color for fraction `s` of the range, 0 at its lower end and 1 at its upper one.
    pub fn color(self, s: f64) -> Color {
        static TABLES: OnceLock<[Vec<Color>; 3]> = OnceLock::new();
        let build =
            || [&SEQUENTIAL[..], &DIVERGING, &DARK].map(|control| path(control).into_iter().map(srgb).collect());
        let tables = TABLES.get_or_init(build);
        let table = match self {
            Self::Sequential => &tables[0],
            Self::Diverging => &tables[1],
            Self::DivergingDark => &tables[2],
        };
        let at = (s.clamp(0.0, 1.0) * (ENTRIES - 1) as f64).round() as usize;
        table[at.min(ENTRIES - 1)]
    }

    /// Whether ranges are symmetric about zero.
    pub(crate) fn is_diverging(self) -> bool {
        self != Self::Sequential
    }
}

/// A point of Oklab: lightness, green–red, blue–yellow.
type Lab = [f64; 3];

fn lab((lightness, chroma, hue): (f64, f64, f64)) -> Lab {
    let (s, c) = hue.to_radians().sin_cos();
    [lightness, chroma * c, chroma * s]
}

fn distance(p: Lab, q: Lab) -> f64 {
    p.iter().zip(&q).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

/// Points at equal distances along a smooth path through the control points.
fn path(control: &[(f64, f64, f64)]) -> Vec<Lab> {
    let points: Vec<Lab> = control.iter().map(|p| lab(*p)).collect();
    let count = (points.len() - 1) * PIECES;
    let path: Vec<Lab> = (0..=count).map(|k| catmull_rom(&points, k as f64 / PIECES as f64)).collect();
    let mut length = vec![0.0; path.len()];
    for k in 1..path.len() {
        length[k] = length[k - 1] + distance(path[k - 1], path[k]);
    }
    (0..ENTRIES)
        .map(|k| {
            let s = length[count] * k as f64 / (ENTRIES - 1) as f64;
            let after = length.partition_point(|l| *l < s).clamp(1, count);
            let part = (s - length[after - 1]) / (length[after] - length[after - 1]);
            let (p, q) = (path[after - 1], path[after]);
            [0, 1, 2].map(|i| p[i] + part * (q[i] - p[i]))
        })
        .collect()
}

/// The Catmull–Rom spline through `points`, `u` counting them from 0; its ends are straight.
fn catmull_rom(points: &[Lab], u: f64) -> Lab {
    let k = (u.floor() as usize).min(points.len() - 2);
    let (t, p, q) = (u - k as f64, points[k], points[k + 1]);
    let before = if k == 0 { [0, 1, 2].map(|i| 2.0 * p[i] - q[i]) } else { points[k - 1] };
    let after = points.get(k + 2).copied().unwrap_or([0, 1, 2].map(|i| 2.0 * q[i] - p[i]));
    [0, 1, 2].map(|i| {
        let (m, n) = (0.5 * (q[i] - before[i]), 0.5 * (after[i] - p[i]));
        let (t2, t3) = (t * t, t * t * t);
        (2.0 * t3 - 3.0 * t2 + 1.0) * p[i] + (t3 - 2.0 * t2 + t) * m + (3.0 * t2 - 2.0 * t3) * q[i] + (t3 - t2) * n
    })
}

/// Oklab to linear sRGB, before clipping.
fn linear([l, a, b]: Lab) -> [f64; 3] {
    let cube = |v: f64| v * v * v;
    let long = cube(l + 0.396_337_777_4 * a + 0.215_803_757_3 * b);
    let medium = cube(l - 0.105_561_345_8 * a - 0.063_854_172_8 * b);
    let short = cube(l - 0.089_484_177_5 * a - 1.291_485_548_0 * b);
    [
        4.076_741_662_1 * long - 3.307_711_591_3 * medium + 0.230_969_929_2 * short,
        -1.268_438_004_6 * long + 2.609_757_401_1 * medium - 0.341_319_396_5 * short,
        -0.004_196_086_3 * long - 0.703_418_614_7 * medium + 1.707_614_701_0 * short,
    ]
}

fn srgb(color: Lab) -> Color {
    let [r, g, b] = linear(color).map(|v| {
        let v = v.clamp(0.0, 1.0);
        let encoded = if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
        (255.0 * encoded).round() as u8
    });
    Color(r, g, b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_white_and_the_primaries_of_srgb_are_found() {
        assert_eq!(srgb([1.0, 0.0, 0.0]), Color(255, 255, 255));
        assert_eq!(srgb([0.0, 0.0, 0.0]), Color(0, 0, 0));
        // Oklab of the red primary, from the definition's own table.
        assert_eq!(srgb([0.627_955, 0.224_863, 0.125_846]), Color(255, 0, 0));
    }

    #[test]
    fn every_color_can_be_shown() {
        for (map, control) in [&SEQUENTIAL[..], &DIVERGING, &DARK].into_iter().enumerate() {
            for (k, point) in path(control).into_iter().enumerate() {
                let shown = linear(point).iter().all(|v| (-0.002..=1.002).contains(v));
                assert!(shown, "map {map}, entry {k}: {:?}", linear(point));
            }
        }
    }

    /// Relative luminance (Rec. 709), what is left of a color in gray print.
    fn luminance(c: Color) -> f64 {
        let channel = |v: u8| {
            let v = f64::from(v) / 255.0;
            if v <= 0.040_45 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
        };
        0.2126 * channel(c.0) + 0.7152 * channel(c.1) + 0.0722 * channel(c.2)
    }

    #[test]
    fn order_survives_in_gray() {
        let gray = |map: ColorMap, k: usize| luminance(map.color(k as f64 / 32.0));
        for k in 0..32 {
            assert!(gray(ColorMap::Sequential, k + 1) > gray(ColorMap::Sequential, k), "step {k}");
            let toward_white = if k < 16 { 1.0 } else { -1.0 };
            let step = gray(ColorMap::Diverging, k + 1) - gray(ColorMap::Diverging, k);
            assert!(toward_white * step > 0.0, "diverging step {k}");
            let step = gray(ColorMap::DivergingDark, k + 1) - gray(ColorMap::DivergingDark, k);
            assert!(toward_white * step < 0.0, "dark step {k}");
        }
    }

    #[test]
    fn equal_steps_of_the_value_are_equal_steps_of_the_color() {
        let step = |k: usize| {
            let (p, q) =
                (ColorMap::Sequential.color(k as f64 / 16.0), ColorMap::Sequential.color((k + 1) as f64 / 16.0));
            distance(oklab(p), oklab(q))
        };
        let steps: Vec<f64> = (0..16).map(step).collect();
        let (low, high) = steps.iter().fold((f64::INFINITY, 0.0f64), |(l, h), s| (l.min(*s), h.max(*s)));
        assert!(high / low < 1.12, "{steps:?}");
    }

    fn oklab(c: Color) -> Lab {
        let [r, g, b] = [c.0, c.1, c.2].map(|v| {
            let v = f64::from(v) / 255.0;
            if v <= 0.040_45 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
        });
        let l = (0.412_221_470_8 * r + 0.536_332_536_3 * g + 0.051_445_992_9 * b).cbrt();
        let m = (0.211_903_498_2 * r + 0.680_699_545_1 * g + 0.107_396_956_6 * b).cbrt();
        let s = (0.088_302_461_9 * r + 0.281_718_837_6 * g + 0.629_978_700_5 * b).cbrt();
        [
            0.210_454_255_3 * l + 0.793_617_785_0 * m - 0.004_072_046_8 * s,
            1.977_998_495_1 * l - 2.428_592_205_0 * m + 0.450_593_709_9 * s,
            0.025_904_037_1 * l + 0.782_771_766_2 * m - 0.808_675_766_0 * s,
        ]
    }
}
