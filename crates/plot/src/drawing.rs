//! A finished figure: the SVG, and the PNG rendered from that very SVG, with its texts in the embedded font.

use std::path::{Path, PathBuf};

use resvg::{tiny_skia, usvg};

use crate::error::{PlotError, Result};
use crate::glyphs::{self, PlacedText};

/// A finished figure.
#[derive(Debug, Clone)]
pub struct Drawing {
    svg: String,
    texts: Vec<PlacedText>,
    width: u32,
    height: u32,
}

/// The files that [`Drawing::save`] wrote.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Saved {
    /// The vector image.
    pub svg: PathBuf,
    /// The raster image.
    pub png: PathBuf,
}

impl Drawing {
    /// PNG pixels per figure pixel.
    pub const PNG_SCALE: u32 = 2;

    pub(crate) fn new(svg: String, texts: Vec<PlacedText>, width: u32, height: u32) -> Self {
        Self { svg, texts, width, height }
    }

    /// The SVG document.
    pub fn svg(&self) -> &str {
        &self.svg
    }

    /// Width and height in figure pixels (96 per inch); the PNG has [`Self::PNG_SCALE`] times as many.
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// The PNG image, rendered from the SVG with the embedded fonts only.
    ///
    /// # Errors
    /// [`PlotError::TooLarge`] when the image does not fit in memory, or [`PlotError::Rasterize`].
    pub fn png(&self) -> Result<Vec<u8>> {
        self.png_of_scale(Self::PNG_SCALE)
    }

    /// The PNG image with `scale` pixels per figure pixel.
    pub(crate) fn png_of_scale(&self, scale: u32) -> Result<Vec<u8>> {
        let pixmap = self.pixmap(scale)?;
        let (width, height) = (pixmap.width(), pixmap.height());
        pixmap.encode_png().map_err(|_| PlotError::TooLarge { width, height })
    }

    /// The image with `scale` pixels per figure pixel.
    pub(crate) fn pixmap(&self, scale: u32) -> Result<tiny_skia::Pixmap> {
        // Texts are left out here, and drawn on top.
        let tree = usvg::Tree::from_str(&self.svg, &usvg::Options::default())?;
        let (width, height) = (self.width * scale, self.height * scale);
        let mut pixmap = tiny_skia::Pixmap::new(width, height).ok_or(PlotError::TooLarge { width, height })?;
        let transform = tiny_skia::Transform::from_scale(scale as f32, scale as f32);
        resvg::render(&tree, transform, &mut pixmap.as_mut());
        glyphs::draw(&self.texts, &mut pixmap, scale);
        Ok(pixmap)
    }

    /// Writes `<stem>.svg` and `<stem>.png`, creating the folder if it is missing. Both endings are added to
    /// the stem as it is, so `run.1` gives `run.1.svg`.
    ///
    /// # Errors
    /// [`PlotError::Write`] with the path that could not be written, or an error of [`Self::png`].
    pub fn save(&self, stem: impl AsRef<Path>) -> Result<Saved> {
        let stem = stem.as_ref();
        let named = |ending: &str| {
            let mut name = stem.as_os_str().to_owned();
            name.push(ending);
            PathBuf::from(name)
        };
        let saved = Saved { svg: named(".svg"), png: named(".png") };
        let png = self.png()?;
        write(&saved.svg, self.svg.as_bytes())?;
        write(&saved.png, &png)?;
        Ok(saved)
    }
}

/// Writes a file, creating its folder if it is missing.
pub(crate) fn write(path: &Path, content: &[u8]) -> Result<()> {
    let failed = |path: &Path| {
        let path = path.to_owned();
        move |source| PlotError::Write { path, source }
    };
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(failed(folder))?;
    }
    std::fs::write(path, content).map_err(failed(path))
}
