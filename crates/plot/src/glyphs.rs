//! Texts of raster images: outlines of the embedded font, placed one after the other.
//!
//! A vector image leaves its texts to its viewer. A raster image needs neither shaping nor the choice of a font: letters,
//! digits, and signs follow each other by their advance widths, and a mark that combines stands over the letter before it.

use std::sync::OnceLock;

use ab_glyph::{Font, FontRef, GlyphId, OutlineCurve, Point};
use resvg::tiny_skia::{FillRule, Paint, Path, PathBuilder, Pixmap, Transform};

use crate::color::Color;

static REGULAR: &[u8] = include_bytes!("../assets/DejaVuSans-subset.ttf");
static BOLD: &[u8] = include_bytes!("../assets/DejaVuSans-Bold-subset.ttf");

/// Height of the letter x, for which the font's combining marks are made, in parts of an em.
const X_HEIGHT: f32 = 0.547;

/// Which point of a text its position means.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Align {
    Left,
    Center,
    Right,
}

/// Size, weight and direction of a text.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Look {
    pub(crate) size: f64,
    pub(crate) bold: bool,
    /// Read from bottom to top.
    pub(crate) upright: bool,
}

/// One line of text where it stands, in figure pixels.
#[derive(Debug, Clone)]
pub(crate) struct PlacedText {
    pub(crate) text: String,
    /// A point of its base line.
    pub(crate) at: (f64, f64),
    pub(crate) align: Align,
    pub(crate) look: Look,
}

/// The embedded font; none where its file is broken.
fn font(bold: bool) -> Option<&'static FontRef<'static>> {
    static FONTS: OnceLock<[Option<FontRef<'static>>; 2]> = OnceLock::new();
    let fonts = FONTS.get_or_init(|| [REGULAR, BOLD].map(|data| FontRef::try_from_slice(data).ok()));
    fonts[usize::from(bold)].as_ref()
}

/// The glyphs of a line with their distances from its start and from the base line, in parts of an em, and its width.
fn line(text: &str, font: &FontRef<'_>) -> (Vec<(GlyphId, Point)>, f32) {
    let em = font.units_per_em().unwrap_or(1.0);
    let bounds = |id: GlyphId| font.outline(id).map(|outline| outline.bounds);
    let (mut glyphs, mut x) = (Vec::new(), 0.0);
    let mut letter: Option<(GlyphId, f32)> = None;
    for c in text.chars() {
        let id = font.glyph_id(c);
        let mut at = Point { x, y: 0.0 };
        if ('\u{300}'..='\u{36f}').contains(&c)
            && let Some((below, start)) = letter
            && let (Some(base), Some(mark)) = (bounds(below), bounds(id))
        {
            at.x = start + (base.min.x + base.max.x - mark.min.x - mark.max.x) / (2.0 * em);
            // Upwards is positive in the font, whose bounds name the upper corner first.
            at.y = (base.min.y.max(base.max.y) / em - X_HEIGHT).max(0.0);
        } else {
            letter = Some((id, x));
            x += font.h_advance_unscaled(id) / em;
        }
        glyphs.push((id, at));
    }
    (glyphs, x)
}

/// Width of one line of text in pixels at font size `size`; none without the font.
pub(crate) fn width(text: &str, size: f64, bold: bool) -> Option<f64> {
    Some(f64::from(line(text, font(bold)?).1) * size)
}

/// The outlines of a line in parts of an em, y upwards.
fn outlines(glyphs: &[(GlyphId, Point)], font: &FontRef<'_>) -> Option<Path> {
    let em = font.units_per_em().unwrap_or(1.0);
    let mut path = PathBuilder::new();
    for &(id, at) in glyphs {
        let place = |p: Point| (at.x + p.x / em, at.y + p.y / em);
        let mut pen: Option<Point> = None;
        for curve in font.outline(id).map(|outline| outline.curves).unwrap_or_default() {
            let (start, end) = match &curve {
                OutlineCurve::Line(a, b) | OutlineCurve::Quad(a, _, b) | OutlineCurve::Cubic(a, _, _, b) => (*a, *b),
            };
            if pen != Some(start) {
                path.close();
                let (x, y) = place(start);
                path.move_to(x, y);
            }
            let (x, y) = place(end);
            match curve {
                OutlineCurve::Line(..) => path.line_to(x, y),
                OutlineCurve::Quad(_, c, _) => path.quad_to(place(c).0, place(c).1, x, y),
                OutlineCurve::Cubic(_, c, d, _) => {
                    path.cubic_to(place(c).0, place(c).1, place(d).0, place(d).1, x, y);
                }
            }
            pen = Some(end);
        }
        path.close();
    }
    path.finish()
}

/// Draws texts into an image with `scale` pixels per figure pixel.
pub(crate) fn draw(texts: &[PlacedText], pixmap: &mut Pixmap, scale: u32) {
    let ink = Color::INK;
    let mut paint = Paint::default();
    paint.set_color_rgba8(ink.0, ink.1, ink.2, 255);
    for PlacedText { text, at, align, look } in texts {
        let Some(font) = font(look.bold) else { return };
        let (glyphs, width) = line(text, font);
        let Some(path) = outlines(&glyphs, font) else { continue };
        let before = match align {
            Align::Left => 0.0,
            Align::Center => -0.5 * width,
            Align::Right => -width,
        };
        let (scale, size) = (scale as f32, look.size as f32);
        let transform = Transform::from_scale(scale, scale)
            .pre_translate(at.0 as f32, at.1 as f32)
            .pre_rotate(if look.upright { -90.0 } else { 0.0 })
            .pre_scale(size, -size)
            .pre_translate(before, 0.0);
        pixmap.fill_path(&path, &paint, FillRule::Winding, transform, None);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mark_stands_over_the_middle_of_its_letter_and_above_it() {
        let font = font(false).expect("the font");
        let em = font.units_per_em().expect("units");
        for letter in ['x', 'X', 'θ', 'y'] {
            let (glyphs, width) = line(&format!("m{letter}\u{307}a"), font);
            let [base, mark] = [1, 2].map(|k| {
                let (id, at) = glyphs[k];
                let bounds = font.outline(id).expect("an outline").bounds;
                let (low, high) = (bounds.min.y.min(bounds.max.y), bounds.min.y.max(bounds.max.y));
                (at.x + (bounds.min.x + bounds.max.x) / (2.0 * em), at.y + low / em, at.y + high / em)
            });
            assert!((base.0 - mark.0).abs() < 1e-3, "{letter}: {base:?} {mark:?}");
            assert!(mark.1 > base.2, "{letter}: {base:?} {mark:?}");
            assert_eq!(width, line(&format!("m{letter}a"), font).1);
        }
    }
}
