//! Pictures: an SVG as a PNG.

use std::error::Error;

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree};

/// Pixels of the PNG for each of the SVG.
const ZOOM: f32 = 2.0;

/// An SVG as a PNG. Its words are set in a font of the program's own, so that it looks the same everywhere.
///
/// # Errors
/// When it is no SVG, or too large.
pub fn png(svg: &str) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut options = Options { font_family: "Ubuntu".to_owned(), ..Options::default() };
    let fonts = options.fontdb_mut();
    fonts.load_font_data(epaint_default_fonts::UBUNTU_LIGHT.to_vec());
    fonts.set_sans_serif_family("Ubuntu");
    let tree = Tree::from_str(svg, &options)?;
    let size = tree.size().to_int_size().scale_by(ZOOM).ok_or("the picture has no size")?;
    let mut pixels = Pixmap::new(size.width(), size.height()).ok_or("the picture is too large")?;
    resvg::render(&tree, Transform::from_scale(ZOOM, ZOOM), &mut pixels.as_mut());
    Ok(pixels.encode_png()?)
}

/// Words as they stand in an SVG.
#[must_use]
pub fn escaped(words: &str) -> String {
    words.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
