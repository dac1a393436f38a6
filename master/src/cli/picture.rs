//! Pictures into files.

use std::fs;
use std::path::Path;

use crate::exit::{Exit, Failure};
use crate::picture::png;

/// Writes a picture as what the file's name ends with: PNG or SVG.
pub(super) fn write(path: &Path, svg: &str) -> Result<(), Failure> {
    let end = path.extension().and_then(|end| end.to_str()).unwrap_or_default().to_ascii_lowercase();
    let fail = |error: &dyn ToString| {
        Failure::new(
            Exit::Unexpected,
            format!("{}: cannot be written: {}", path.display(), error.to_string()),
        )
    };
    match end.as_str() {
        "svg" => fs::write(path, svg).map_err(|error| fail(&error)),
        "png" => {
            let bytes = png(svg).map_err(|error| fail(&error))?;
            fs::write(path, bytes).map_err(|error| fail(&error))
        }
        _ => {
            let message = format!("{}: a picture's name ends with .png or .svg", path.display());
            Err(Failure::new(Exit::Usage, message))
        }
    }
}
