//! The noise of the points of a study that sweeps over noise files.

use crate::key::reading::Reading;
use crate::key::setting::Setting;
use crate::noise::Noise;
use crate::noise::keys::FILE;
use crate::noise::read::read_file;
use sagnac_base::quantity::units::Quantity;
use sagnac_base::source::diagnose::Wrong;

/// The noise of each file of a sweep over files, combined with the keys `written` in the study, which take precedence.
///
/// # Errors
/// A file cannot be read, or is no noise.
pub(crate) fn swept_files(
    reading: &mut Reading,
    written: &[(&'static Setting<Noise>, Quantity)],
) -> Result<Vec<Noise>, Wrong> {
    let mut files = Vec::new();
    for file in reading.sweep(&FILE).into_iter().flat_map(|sweep| &sweep.files) {
        let (mut noise, notes) = read_file(file.get_ref(), file.span(), reading.files)?;
        reading.notes.extend(notes);
        written.iter().for_each(|(setting, quantity)| (setting.set)(&mut noise, *quantity));
        files.push(noise);
    }
    Ok(files)
}
