//! The noise of the points of a study that sweeps over noise files.

use crate::key::reading::Reading;
use crate::key::setting::{Setting, Swept};
use crate::key::sweep::Sweep;
use crate::noise::Noise;
use crate::noise::keys::FILE;
use crate::noise::read::read_file;
use crate::quantity::units::Quantity;
use crate::source::diagnose::Wrong;

/// The noise of each file of a sweep over files, combined with the keys `written` in the study, which take precedence.
///
/// # Errors
/// A file cannot be read, or is no noise.
pub(crate) fn swept_files(
    reading: &Reading,
    written: &[(&'static Setting<Noise>, Quantity)],
) -> Result<Vec<Noise>, Wrong> {
    let mut files = Vec::new();
    for file in reading.sweep(&FILE).into_iter().flat_map(|sweep| &sweep.files) {
        let mut noise = read_file(file.get_ref(), file.span(), reading.files)?;
        written.iter().for_each(|(setting, quantity)| (setting.set)(&mut noise, *quantity));
        files.push(noise);
    }
    Ok(files)
}

/// The noise of the file that a sweep selects, from those of all its `files`; `None` without such a sweep.
pub(crate) fn selected<'n>(
    files: &'n [Noise],
    sweeps: &[Sweep],
    swept: &[(&'static str, Swept)],
) -> Option<&'n Noise> {
    let (sweep, (_, name)) = sweeps.iter().zip(swept).find(|(sweep, _)| sweep.key.is_file())?;
    let place = sweep.values.iter().position(|value| value == name)?;
    files.get(place)
}
