//! The charts of a study as files of its results folder.

use rayon::prelude::*;
use sagnac::store::folder::Folder;
use sagnac::view::chart::picture::Picture;
use sagnac::view::picture::{Drawn, chart_stem};

use crate::failure::Failure;

/// Writes the charts as SVG and PNG, and removes those of earlier runs that no longer exist.
///
/// # Errors
/// A chart cannot be drawn or written.
pub fn draw(pictures: &[Drawn], folder: &Folder) -> Result<(), Failure> {
    // In parallel: a chart of 10,000 points takes half a second.
    pictures.par_iter().try_for_each(|drawn| write_pictures(folder, &drawn.stem, &drawn.picture))?;
    let drawn: Vec<String> = (0..pictures.len()).map(|index| chart_stem(index, pictures.len())).collect();
    for name in folder.listed() {
        let stem = name.strip_suffix(".svg").or(name.strip_suffix(".png"));
        if stem.is_some_and(|stem| is_chart_stem(stem) && !drawn.iter().any(|drawn| drawn == stem)) {
            folder.remove(&name)?;
        }
    }
    Ok(())
}

/// Writes a chart as `<stem>.svg` and `<stem>.png`.
///
/// # Errors
/// It cannot be drawn or written.
pub fn write_pictures(folder: &Folder, stem: &str, picture: &Picture) -> Result<(), Failure> {
    let png =
        picture.png(2.0).map_err(|error| Failure::Picture(format!("cannot draw {stem}.png: {error}")))?;
    folder.write(&format!("{stem}.svg"), picture.svg().as_bytes())?;
    folder.write(&format!("{stem}.png"), &png)?;
    Ok(())
}

/// Whether [`chart_stem`] gives this name to a chart.
pub fn is_chart_stem(stem: &str) -> bool {
    let number = stem.strip_prefix("chart-").and_then(|number| number.parse().ok());
    stem == "chart" || number.is_some_and(|number: usize| number >= 1 && stem == format!("chart-{number}"))
}
