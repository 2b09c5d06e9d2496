//! Images in time as a GIF: one palette for all, and of each image only what changed.

use std::collections::HashMap;

use gif::{DisposalMethod, Encoder, Frame, Repeat};
use resvg::tiny_skia::Pixmap;

use crate::error::{PlotError, Result};

type Rgb = [u8; 3];

/// Colors of the palette; one more index stands for what does not change.
const COLORS: usize = 255;
const UNCHANGED: u8 = COLORS as u8;
/// Squared distance below which two colors of the sample share an entry of the palette.
const ALIKE: u32 = 48;

/// Writes images of one size, one after the other.
pub(crate) struct GifImages {
    encoder: Encoder<Vec<u8>>,
    palette: Vec<Rgb>,
    /// Palette entries of colors met so far.
    nearest: HashMap<Rgb, u8>,
    /// The image before, in palette entries.
    before: Vec<u8>,
    width: u16,
}

impl GifImages {
    /// An endless loop of images like those of `sample`, from which the palette is taken: the most frequent colors
    /// that are not too much alike.
    pub(crate) fn new(sample: &[Pixmap]) -> Result<Self> {
        let Some(first) = sample.first() else {
            return Err(PlotError::NoContent { missing: "snapshot" });
        };
        let too_large = || PlotError::TooLarge { width: first.width(), height: first.height() };
        let width = u16::try_from(first.width()).map_err(|_| too_large())?;
        let height = u16::try_from(first.height()).map_err(|_| too_large())?;
        let palette = palette(sample);
        let mut table: Vec<u8> = palette.iter().flatten().copied().collect();
        table.resize(3 * (COLORS + 1), 0);
        let mut encoder = Encoder::new(Vec::new(), width, height, &table)?;
        encoder.set_repeat(Repeat::Infinite)?;
        Ok(Self { encoder, palette, nearest: HashMap::new(), before: Vec::new(), width })
    }

    /// Adds the next image, shown for `delay` hundredths of a second.
    pub(crate) fn push(&mut self, image: &Pixmap, delay: u16) -> Result<()> {
        let (nearest, palette) = (&mut self.nearest, &self.palette);
        let mut entries: Vec<u8> = Vec::with_capacity(image.pixels().len());
        for (color, count) in runs(image) {
            let entry = *nearest.entry(color).or_insert_with(|| closest(palette, color));
            entries.extend(std::iter::repeat_n(entry, count));
        }
        let width = usize::from(self.width);
        let changed = |k: usize| self.before.get(k) != Some(&entries[k]);
        // An image without any change still lasts its time: one pixel stands for it.
        let (mut left, mut right, mut top, mut bottom) = (width, 0, entries.len() / width, 0);
        for k in (0..entries.len()).filter(|k| changed(*k)) {
            (left, right) = (left.min(k % width), right.max(k % width));
            (top, bottom) = (top.min(k / width), bottom.max(k / width));
        }
        if left > right {
            (left, right, top, bottom) = (0, 0, 0, 0);
        }
        let mut buffer = Vec::with_capacity((right - left + 1) * (bottom - top + 1));
        for row in top..=bottom {
            let cells = row * width + left..=row * width + right;
            buffer.extend(cells.map(|k| if changed(k) { entries[k] } else { UNCHANGED }));
        }
        self.encoder.write_frame(&Frame {
            delay,
            dispose: DisposalMethod::Keep,
            transparent: Some(UNCHANGED),
            left: left as u16,
            top: top as u16,
            width: (right - left + 1) as u16,
            height: (bottom - top + 1) as u16,
            buffer: buffer.into(),
            ..Frame::default()
        })?;
        self.before = entries;
        Ok(())
    }

    /// The finished file.
    pub(crate) fn finish(self) -> Result<Vec<u8>> {
        Ok(self.encoder.into_inner()?)
    }
}

/// The colors of an opaque image, row by row, each with the number of pixels that follow each other in it.
fn runs(image: &Pixmap) -> impl Iterator<Item = (Rgb, usize)> {
    let same = image.pixels().chunk_by(|a, b| a == b);
    same.filter_map(|run| run.first().map(|p| ([p.red(), p.green(), p.blue()], run.len())))
}

fn squared_distance(a: Rgb, b: Rgb) -> u32 {
    a.iter().zip(b).map(|(p, q)| u32::from(p.abs_diff(q)).pow(2)).sum()
}

fn palette(sample: &[Pixmap]) -> Vec<Rgb> {
    let mut counts: HashMap<Rgb, usize> = HashMap::new();
    for (color, count) in sample.iter().flat_map(runs) {
        *counts.entry(color).or_insert(0) += count;
    }
    let mut ordered: Vec<(usize, Rgb)> = counts.into_iter().map(|(color, n)| (n, color)).collect();
    ordered.sort_unstable_by(|a, b| b.cmp(a));
    let mut palette: Vec<Rgb> = Vec::with_capacity(COLORS);
    for (_, color) in ordered {
        if palette.len() == COLORS {
            break;
        }
        if palette.iter().all(|known| squared_distance(*known, color) > ALIKE) {
            palette.push(color);
        }
    }
    palette
}

fn closest(palette: &[Rgb], color: Rgb) -> u8 {
    let entries = palette.iter().enumerate();
    entries.min_by_key(|(_, known)| squared_distance(**known, color)).map_or(0, |(k, _)| k as u8)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use resvg::tiny_skia::Color;

    fn plain(shade: u8) -> Pixmap {
        let mut image = Pixmap::new(20, 10).unwrap();
        image.fill(Color::from_rgba8(shade, shade, shade, 255));
        image
    }

    #[test]
    fn the_palette_holds_frequent_colors_exactly() {
        let colors = palette(&[plain(10), plain(200), plain(201)]);
        assert_eq!(colors.len(), 2);
        assert!(colors.contains(&[10; 3]) && closest(&colors, [220; 3]) == closest(&colors, [200; 3]));
    }

    #[test]
    fn images_read_back_and_only_changes_are_stored() {
        let mut second = plain(200);
        second.pixels_mut()[3 * 20 + 7] = Color::from_rgba8(0, 0, 0, 255).premultiply().to_color_u8();
        let images = [plain(200), second.clone(), second];
        let mut gif = GifImages::new(&images).unwrap();
        for image in &images {
            gif.push(image, 4).unwrap();
        }
        let bytes = gif.finish().unwrap();
        let mut options = gif::DecodeOptions::new();
        options.set_color_output(gif::ColorOutput::RGBA);
        let mut decoder = options.read_info(bytes.as_slice()).unwrap();
        let mut frames = Vec::new();
        while let Some(frame) = decoder.read_next_frame().unwrap() {
            frames.push((frame.delay, frame.left, frame.top, frame.width, frame.height, frame.buffer.to_vec()));
        }
        assert_eq!(frames.len(), 3);
        assert!(frames.iter().all(|f| f.0 == 4));
        assert!(frames[0].5.chunks(4).all(|p| p == [200, 200, 200, 255]));
        assert_eq!((frames[1].1, frames[1].2, frames[1].3, frames[1].4), (7, 3, 1, 1));
        assert_eq!(frames[1].5, [0, 0, 0, 255]);
        // Nothing changed: one transparent pixel.
        assert_eq!((frames[2].3, frames[2].4, frames[2].5[3]), (1, 1, 0));
    }
}
