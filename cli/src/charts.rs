//! The charts of a study as files of its results folder.

use std::ffi::OsStr;
use std::path::Path;

use rayon::prelude::*;
use sagnac::view::chart::figure::Figure;
use sagnac::view::chart::picture::Picture;
use sagnac::view::picture::{Drawn, chart_stem};

use crate::failure::Failure;
use crate::look;
use crate::output::{remove, unwritten, write};

/// Writes the charts as SVG and PNG, and removes those of earlier runs that no longer exist.
///
/// # Errors
/// A chart cannot be drawn or written.
pub fn draw(pictures: &[Drawn], folder: &Path) -> Result<(), Failure> {
    // In parallel: a chart of 10,000 points takes half a second.
    pictures.par_iter().try_for_each(|drawn| write_pictures(folder, &drawn.stem, &drawn.picture))?;
    let drawn: Vec<String> = (0..pictures.len()).map(|index| chart_stem(index, pictures.len())).collect();
    remove_undrawn(folder, &drawn, is_chart_stem)
}

/// Writes figures by their stems, and removes those of earlier runs that no longer exist.
///
/// # Errors
/// A figure cannot be drawn, written or removed.
pub fn write_figures(folder: &Path, figures: &[(String, Option<Figure>)]) -> Result<(), Failure> {
    for (stem, figure) in figures {
        match figure {
            Some(figure) => write_pictures(folder, stem, &Picture::Curves(figure.clone()))?,
            None => ["svg", "png"]
                .into_iter()
                .try_for_each(|ending| remove(&folder.join(format!("{stem}.{ending}"))).map(drop))?,
        }
    }
    Ok(())
}

/// The figures as text for the terminal.
pub fn plotted(figures: Vec<(String, Option<Figure>)>) -> String {
    let drawn = figures.into_iter().filter_map(|(_, figure)| figure);
    drawn.map(|figure| format!("{}\n", Picture::Curves(figure).text(look::of_output()))).collect()
}

/// Writes a chart as `<stem>.svg` and `<stem>.png`.
///
/// # Errors
/// It cannot be drawn or written.
pub fn write_pictures(folder: &Path, stem: &str, picture: &Picture) -> Result<(), Failure> {
    let png =
        picture.png(2.0).map_err(|error| Failure::Picture(format!("cannot draw {stem}.png: {error}")))?;
    write(&folder.join(format!("{stem}.svg")), picture.svg().as_bytes())?;
    write(&folder.join(format!("{stem}.png")), &png)
}

/// Removes pictures whose stem is one of ours and not among those that are `drawn`. Other files are kept.
///
/// # Errors
/// The folder cannot be read, or a file not removed.
pub fn remove_undrawn(
    folder: &Path,
    drawn: &[String],
    is_ours: impl Fn(&str) -> bool,
) -> Result<(), Failure> {
    for entry in std::fs::read_dir(folder).map_err(unwritten(folder))? {
        let path = entry.map_err(unwritten(folder))?.path();
        let stem = path.file_stem().and_then(OsStr::to_str).unwrap_or_default();
        let ending = path.extension().and_then(OsStr::to_str).unwrap_or_default();
        let is_picture = ["svg", "png"].contains(&ending) && is_ours(stem);
        if is_picture && !drawn.iter().any(|drawn| drawn == stem) {
            remove(&path)?;
        }
    }
    Ok(())
}

/// Whether [`chart_stem`] gives this name to a chart.
pub fn is_chart_stem(stem: &str) -> bool {
    let number = stem.strip_prefix("chart-").and_then(|number| number.parse().ok());
    stem == "chart" || number.is_some_and(|number: usize| number >= 1 && stem == format!("chart-{number}"))
}
