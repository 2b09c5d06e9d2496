//! The embedded font: widths of texts and their breaking into lines.

use crate::glyphs;

/// The font family as written into the SVG: the embedded font first, for viewers without it any sans serif.
pub(crate) const FAMILY: &str = "DejaVu Sans, sans-serif";

/// Font size of labels, legends and ticks in figure pixels (96 per inch, so 11.25 points).
pub(crate) const SIZE: f64 = 15.0;
/// Font size of figure titles.
pub(crate) const TITLE_SIZE: f64 = 17.0;
/// Distance between the lines of a text, as a multiple of its size.
pub(crate) const LEADING: f64 = 1.3;

/// Characters of a text beyond which the rest is ignored.
const LONGEST: usize = 1000;

/// Width of one line of text in pixels at font size `size`.
pub(crate) fn width(text: &str, size: f64, bold: bool) -> f64 {
    glyphs::width(text, size, bold).unwrap_or_else(|| 0.65 * size * text.chars().count() as f64)
}

/// Breaks `text` into at most `max_lines` lines no wider than `available`, at spaces where possible; what does
/// not fit ends in `…`. An empty text has no lines.
pub(crate) fn wrap(text: &str, available: f64, size: f64, bold: bool, max_lines: usize) -> Vec<String> {
    let fits = |s: &str| width(s, size, bold) <= available;
    // No figure has room for more, and a hostile name may be megabytes long.
    let text: String = text.chars().take(LONGEST).collect();
    // Lines break at spaces, unless they are no-break spaces, and after underscores.
    let gap = |c: char| c.is_whitespace() && c != '\u{a0}';
    let words = text.split(gap).filter(|w| !w.is_empty()).flat_map(|w| w.split_inclusive('_').enumerate());
    let mut lines: Vec<String> = Vec::new();
    let mut line = String::new();
    for (part, word) in words {
        let space = if part > 0 || line.is_empty() { "" } else { " " };
        let joined = format!("{line}{space}{word}");
        if fits(&joined) {
            line = joined;
            continue;
        }
        if !line.is_empty() {
            lines.push(std::mem::take(&mut line));
        }
        // A word wider than a line is cut.
        for c in word.chars() {
            line.push(c);
            if !fits(&line) && line.chars().count() > 1 {
                line.pop();
                lines.push(std::mem::replace(&mut line, c.to_string()));
            }
        }
    }
    if !line.is_empty() {
        lines.push(line);
    }
    if lines.len() > max_lines {
        lines.truncate(max_lines);
        if let Some(last) = lines.last_mut() {
            while !fits(&format!("{last}…")) && last.pop().is_some() {}
            last.push('…');
        }
    }
    lines
}

/// Breaks an axis label into at most three lines; if it has to be cut, the unit in brackets at its end stays.
pub(crate) fn wrap_label(text: &str, available: f64) -> Vec<String> {
    // A unit such as N m stays in one line.
    let unit = text.rfind('[').filter(|_| text.ends_with(']')).unwrap_or(text.len());
    let text = &format!("{}{}", &text[..unit], text[unit..].replace(' ', "\u{a0}"));
    let lines = wrap(text, available, SIZE, false, 3);
    let cut = lines.last().is_some_and(|l| l.ends_with('…'));
    match text.rfind('[') {
        Some(at) if cut && text.ends_with(']') => {
            let mut lines = wrap(&text[..at], available, SIZE, false, 2);
            lines.extend(wrap(&text[at..], available, SIZE, false, 1));
            lines
        }
        _ => lines,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn widths_are_those_of_the_font() {
        // Advance widths of DejaVu Sans in 1/2048 em: m 1995, i 569.
        assert!((width("m", 2048.0, false) - 1995.0).abs() < 3.0);
        assert!((width("i", 2048.0, false) - 569.0).abs() < 3.0);
        assert!(width("m", 15.0, true) > width("m", 15.0, false));
        // A combining dot takes no room.
        assert_eq!(width("θ\u{307}", 15.0, false), width("θ", 15.0, false));
    }

    #[test]
    fn lines_fit_and_lose_nothing_until_the_limit() {
        let text = "position of the center of mass in the plate frame";
        let lines = wrap(text, 120.0, 15.0, false, 9);
        assert!(lines.len() > 1);
        assert!(lines.iter().all(|l| width(l, 15.0, false) <= 120.0));
        assert_eq!(lines.join(" "), text);
        let cut = wrap(&"x".repeat(100_000), 120.0, 15.0, false, 2);
        assert_eq!(cut.len(), 2);
        assert!(cut[1].ends_with('…'));
        assert!(wrap("", 120.0, 15.0, false, 2).is_empty());
        assert_eq!(wrap("viscous_friction", 100.0, 15.0, false, 2), ["viscous_", "friction"]);
    }

    #[test]
    fn a_label_that_is_cut_keeps_its_unit() {
        let lines = wrap_label("position of the center of mass along the rotation axis of the plate [m]", 120.0);
        assert_eq!(lines.len(), 3);
        assert!(lines[1].ends_with('…'));
        assert_eq!(lines[2], "[m]");
        assert_eq!(wrap_label("x [m]", 120.0), ["x [m]"]);
    }
}
