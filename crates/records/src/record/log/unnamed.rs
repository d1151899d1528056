//! The one question about a file without a header, in place of one for each thing that it leaves open.

use crate::record::error::RecordError;
use crate::record::log::measure::expected;
use crate::record::log::read::{Request, likely, numbers_of, proposed};
use crate::record::log::timing::{asked, parts_of_times};
use crate::record::recording::{MAX_LISTED, Recording};

/// The error for a file without a header of which at least two of times, columns and units are open, with the settings for all of
/// them. The columns `taken` are those of the time, as far as it is found, and of a temperature.
pub(super) fn unnamed(file: &Recording, request: &Request, taken: [Option<usize>; 2]) -> Option<RecordError> {
    let is_known = |column| !file.rows(column).is_empty();
    if !file.names().is_empty() || file.columns() < 2 || !(0..file.columns()).any(is_known) {
        return None;
    }
    let time = asked(file, &request.timing);
    let taken = [time.as_ref().map_or(taken[0], |(column, _)| *column), taken[1]];
    let lacks_columns = request.columns.is_empty() && likely(file, taken).len() > 1;
    let lacks_units = request.units.is_empty();
    if [time.is_some(), lacks_columns, lacks_units].iter().filter(|is_open| **is_open).count() < 2 {
        return None;
    }
    let mut settings: Vec<String> = time.into_iter().map(|(_, setting)| setting).collect();
    if lacks_columns {
        let columns = proposed(file, request.data(), taken);
        settings.push(format!("`column = {}`", numbers_of(columns.iter().take(MAX_LISTED))));
    }
    if lacks_units {
        settings.push("`unit = UNIT`, one for all or one for each".to_owned());
    }
    let parts = match parts_of_times(file)[..] {
        [seconds, rests, ..] if taken[0] == Some(seconds) => {
            format!("; the times are taken from columns {} and {}", seconds + 1, rests + 1)
        }
        _ => String::new(),
    };
    let units = if lacks_units { format!("; {}", expected(request.data())) } else { String::new() };
    let message = format!("the file has no header: say what its {} columns are", file.columns());
    let help = format!("give {}{parts}{units}", settings.join(", "));
    Some(file.refuse(None, &message, "these are the columns", &help))
}
