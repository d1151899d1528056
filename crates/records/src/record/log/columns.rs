//! The choice of the columns of a log: those of its samples and of the times over which they were summed.

use crate::record::RecordError;
use crate::record::column_file::{ColumnFile, MAX_LISTED};
use crate::record::log::Degree;
use crate::record::log::measure::{Data, expected};
use crate::record::log::read::{Request, Timing};
use crate::record::log::timing::{asked, is_timing, parts_of_times};
use crate::record::names::{Name, words};

/// Most columns that are read as samples.
const MAX_CHANNELS: usize = 1000;

/// Refuses more columns of samples than [`MAX_CHANNELS`].
pub(crate) fn few(file: &ColumnFile, columns: Vec<usize>) -> Result<Vec<usize>, RecordError> {
    if columns.len() <= MAX_CHANNELS {
        return Ok(columns);
    }
    let message = format!("{} columns of samples, more than {MAX_CHANNELS}", columns.len());
    Err(file.refuse(None, &message, "too many", "give a part of them, as in `column = 2-100`"))
}

/// The name of a column without its unit, else its number.
pub(crate) fn name_of(file: &ColumnFile, column: usize) -> String {
    file.names().get(column).map_or_else(|| (column + 1).to_string(), |name| name.bare.clone())
}

/// The names of columns in a list.
fn names_of(file: &ColumnFile, columns: &[usize]) -> String {
    let more = if columns.len() > MAX_LISTED { ", …" } else { "" };
    let names = columns.iter().take(MAX_LISTED).map(|&column| name_of(file, column));
    names.collect::<Vec<_>>().join(", ") + more
}

/// Whether a column is called like a temperature.
pub(crate) fn is_temperature(name: &Name) -> bool {
    name.whole.to_lowercase().contains("temp")
        || name.unit.as_deref().is_some_and(|unit| unit.contains(['°', '℃']) && Degree::parse(unit).is_some())
}

/// The columns of samples that are requested, or those `named` by a layout, or the only one besides those `taken` for time and
/// temperature, or those whose units are those of such data, or else those with names of gyros and no
/// unit.
pub(crate) fn wanted(
    file: &ColumnFile,
    request: &Request,
    words: &[String],
    named: &[usize],
    taken: [Option<usize>; 2],
    notes: &mut Vec<String>,
) -> Result<Vec<usize>, RecordError> {
    if !words.is_empty() {
        return words.iter().map(|word| file.find(word, None)).collect();
    }
    if !request.columns.is_empty() {
        return all(file, request, taken, notes);
    }
    if !named.is_empty() {
        return Ok(named.to_vec());
    }
    let parts = parts_of_times(file);
    let is_other = |column: &usize| {
        !taken.contains(&Some(*column)) && file.calendar(*column).is_none() && !parts.contains(column)
    };
    let others: Vec<usize> = (0..file.columns()).filter(is_other).collect();
    let is_gyro =
        |column: &usize| file.names().get(*column).is_some_and(|name| name.is_gyro() && name.unit.is_none());
    let gyros: Vec<usize> = proposed(file, request.data(), taken).into_iter().filter(is_gyro).collect();
    let [measuring, norms] =
        if request.units.is_empty() { measuring(file, request.data()) } else { [vec![], vec![]] };
    match others[..] {
        [_] => Ok(others),
        [] => {
            let help = "add a column of samples, or give `rate = HZ`, the rate of your logger, instead of a time column";
            Err(file.refuse(None, "there is no column besides the time", "the only one", help))
        }
        _ if !measuring.is_empty() => {
            let (data, names) = (request.data().name(), names_of(file, &measuring));
            notes.push(format!("all columns whose units fit `data = {data}` are read: {names}"));
            if !norms.is_empty() {
                let names = names_of(file, &norms);
                notes.push(format!("left out, as the length of a vector: {names}; `column = NAME` reads it"));
            }
            Ok(measuring)
        }
        _ if request.units.len() <= 1 && request.data() == Data::Rate && !gyros.is_empty() => {
            notes.push(format!("all columns with names of gyros are read: {}", names_of(file, &gyros)));
            Ok(gyros)
        }
        _ => {
            let message = format!("the file has {} columns: select some of them", file.columns());
            let name = |&column: &usize| {
                let name = file.names().get(column).filter(|name| !name.bare.contains([',', ' ', '`']));
                name.map_or_else(|| (column + 1).to_string(), |name| name.bare.clone())
            };
            let proposed = proposed(file, request.data(), taken);
            let names: Vec<String> = proposed.iter().take(MAX_LISTED).map(name).collect();
            let is_gyro = |column: &usize| file.names().get(*column).is_some_and(Name::is_gyro);
            let may_differ = proposed.len() > 1 && request.units.is_empty() && !proposed.iter().all(is_gyro);
            let units = if may_differ {
                "; where they measure different things, give one unit for each, as in `unit = rad/s,m/s^2`"
            } else {
                ""
            };
            let help = format!(
                "name one or several of them, as in `column = {}`: {}{units}",
                names.join(","),
                file.listed()
            );
            Err(file.refuse(None, &message, "these are the columns", &help))
        }
    }
}

/// What the columns that are named, else all, measure by their names and units, with a note; `None` where that is rates, or nothing
/// says it.
pub(crate) fn data_of(file: &ColumnFile, words: &[String]) -> Option<(Data, String)> {
    if let Some(data) = file.data() {
        return Some((data, format!("the header states `data = {}`", data.name())));
    }
    let is_wanted = |column: &usize| {
        words.is_empty() || words.iter().any(|word| file.find(word, None).is_ok_and(|found| found == *column))
    };
    let names: Vec<&Name> =
        (0..file.columns()).filter(is_wanted).filter_map(|column| file.names().get(column)).collect();
    // The unit of a gyro is open where it is not stated.
    let may_be_rate = |name: &&Name| name.measures(Data::Rate) || name.is_gyro() && name.unit.is_none();
    if names.iter().any(may_be_rate) {
        return None;
    }
    let is_said = |data: Data| move |name: &&&Name| name.measures(data) && name.says(data);
    let [increment, angle] =
        [Data::Increment, Data::Angle].map(|data| Some((data, *names.iter().find(is_said(data))?)));
    let (data, name) = increment.or(angle)?;
    Some((data, format!("`{}` is read as `data = {}`", name.whole, data.name())))
}

/// All columns that may have samples, but not those with a unit of another quantity.
///
/// # Errors
/// There are none.
fn all(
    file: &ColumnFile,
    request: &Request,
    taken: [Option<usize>; 2],
    notes: &mut Vec<String>,
) -> Result<Vec<usize>, RecordError> {
    let likely = likely(file, taken);
    let fits = |name: &Name| name.unit.is_none() || name.measures(request.data());
    let fitting: Vec<usize> =
        likely.iter().copied().filter(|&column| file.names().get(column).is_none_or(fits)).collect();
    // Where no unit fits, each is refused with what does.
    let columns = if fitting.is_empty() { likely } else { fitting };
    if columns.is_empty() {
        let help = format!("name one, as in `column = 2`: {}", file.listed());
        return Err(file.refuse(None, "no column seems to have samples", "these are the columns", &help));
    }
    let is_left_out = |&column: &usize| {
        let is_timing = file.names().get(column).is_none_or(is_timing);
        !columns.contains(&column) && !taken.contains(&Some(column)) && !is_timing
    };
    let left_out: Vec<usize> = (0..file.columns()).filter(is_left_out).collect();
    if !left_out.is_empty() {
        let names = names_of(file, &left_out);
        notes.push(format!("columns without samples of such data are left out: {names}"));
    }
    Ok(columns)
}

/// The words that name columns: a number for each of a range such as `2-4`, and the gyros of a sensor that is named; none where all
/// columns are meant.
pub(crate) fn expanded(file: &ColumnFile, words: &[String]) -> Vec<String> {
    let is_name = |word: &str| file.find(word, None).is_ok();
    if let [word] = words
        && word == "all"
        && !is_name(word)
    {
        return vec![];
    }
    let range = |word: &String| {
        let ends = word.split_once('-').filter(|_| !is_name(word));
        let ends = ends.and_then(|(a, b)| Some((a.trim().parse().ok()?, b.trim().parse().ok()?)));
        let columns = ends.filter(|(a, b): &(usize, usize)| *a > 0 && a <= b && *b <= file.columns());
        columns
            .map_or_else(|| vec![word.clone()], |(a, b)| (a..=b).map(|number| number.to_string()).collect())
    };
    let of_sensor = |word: String| match is_name(&word) {
        true => vec![word],
        false => Some(gyros_of(file, &word)).filter(|names| !names.is_empty()).unwrap_or(vec![word]),
    };
    words.iter().flat_map(range).flat_map(of_sensor).collect()
}

/// The columns of a sensor in a file of several: its gyros, or all that are no times where none is called a gyro.
fn gyros_of(file: &ColumnFile, sensor: &str) -> Vec<String> {
    let is_of = |name: &&Name| {
        let rest = name.bare.strip_prefix(sensor).and_then(|rest| rest.strip_prefix('.'));
        rest.is_some_and(|rest| rest != "time")
    };
    let all: Vec<&Name> = match file.groups().iter().any(|(group, _)| *group == sensor) {
        true => file.names().iter().filter(is_of).collect(),
        false => vec![],
    };
    let has_gyros = all.iter().any(|name| name.is_gyro());
    all.into_iter().filter(|name| !has_gyros || name.is_gyro()).map(|name| name.bare.clone()).collect()
}

/// The columns that are proposed as samples: those that may have some, without those that hold one number, count or rise from row to row,
/// unless no others remain; only gyros, where their names tell them from others.
fn proposed(file: &ColumnFile, data: Data, taken: [Option<usize>; 2]) -> Vec<usize> {
    let mut columns = likely(file, taken);
    // Angles rise too.
    let is_none = |column: &usize| file.is_steady(*column) || data != Data::Angle && file.rises(*column);
    if !columns.iter().all(is_none) {
        columns.retain(|column| !is_none(column));
    }
    let is_gyro = |column: &usize| file.names().get(*column).is_some_and(Name::is_gyro);
    if data == Data::Rate && columns.iter().any(is_gyro) {
        columns.retain(is_gyro);
    }
    columns
}

/// The numbers of columns from 1 on, as `column` takes them.
fn numbers_of<'c>(columns: impl Iterator<Item = &'c usize>) -> String {
    columns.map(|column| (column + 1).to_string()).collect::<Vec<_>>().join(",")
}

/// The columns that may have samples: all numbers but those of the columns `taken`, times, lengths of time, temperatures, counters,
/// lengths of vectors and what only tells about the samples.
pub(crate) fn likely(file: &ColumnFile, taken: [Option<usize>; 2]) -> Vec<usize> {
    let parts = parts_of_times(file);
    let is_likely = |&column: &usize| {
        let is_none =
            |name: &Name| is_temperature(name) || is_timing(name) || name.is_norm() || name.is_auxiliary();
        let is_other = file.names().get(column).is_some_and(is_none);
        !taken.contains(&Some(column))
            && !parts.contains(&column)
            && !is_other
            && file.calendar(column).is_none()
            && file.sample(column).is_some()
    };
    (0..file.columns()).filter(is_likely).collect()
}

/// The columns whose units are those of such data, and those of them that are left out because they are the lengths of vectors.
fn measuring(file: &ColumnFile, data: Data) -> [Vec<usize>; 2] {
    let names = file.names();
    let (norms, axes): (Vec<usize>, Vec<usize>) = (0..names.len())
        .filter(|&column| names[column].measures(data))
        .partition(|&column| names[column].is_norm());
    if axes.is_empty() { [norms, vec![]] } else { [axes, norms] }
}

/// The column with the time over which the increments of a column were summed: `delta_angle_dt` of `delta_angle[0]`, or `dt` of all.
pub(crate) fn span_of(file: &ColumnFile, column: usize) -> Option<usize> {
    let names = file.names();
    let of_increments = words(&names.get(column)?.bare);
    let stem_length = |span: usize| {
        let words = words(&names[span].bare);
        let is_end = |end: &&[&str]| words.len() >= end.len() && words[words.len() - end.len()..] == **end;
        let end = SPANS.iter().find(|end| is_end(end))?;
        let stem = &words[..words.len() - end.len()];
        let is_plain = stem.is_empty() && !INTERVALS.contains(end);
        (is_plain || !stem.is_empty() && of_increments.starts_with(stem)).then_some(stem.len())
    };
    let spans = (0..names.len()).filter(|&span| file.sample(span).is_some());
    spans.filter_map(|span| Some((stem_length(span)?, span))).max().map(|(_, span)| span)
}

/// Words at the end of names of columns with the times over which increments were summed.
const SPANS: [&[&str]; 5] = [&["dt"], &["delta", "t"], &["d", "t"], INTERVALS[0], INTERVALS[1]];

/// The endings in [`SPANS`] that count only after other words: a name of one of them alone is no such column.
const INTERVALS: [&[&str]; 2] = [&["interval"], &["intervals"]];

/// The error for a file with groups of samples, of which none is selected and which no times or no lengths join.
pub(crate) fn several_groups(file: &ColumnFile, request: &Request) -> Option<RecordError> {
    let groups = file.groups();
    let is_open = matches!(request.timing, Timing::Stamps { step_s: None, column: None, .. });
    let are_even = groups.windows(2).all(|pair| pair[0].1 == pair[1].1);
    if groups.len() < 2 || !request.columns.is_empty() || are_even && !is_open {
        return None;
    }
    let (largest, _) = groups.iter().rev().max_by_key(|(_, rows)| *rows)?;
    let names: Vec<String> = gyros_of(file, largest).into_iter().take(3).collect();
    let listed: Vec<String> =
        groups.iter().take(MAX_LISTED).map(|(name, rows)| format!("{name} with {rows} samples")).collect();
    let more = if groups.len() > MAX_LISTED { ", …" } else { "" };
    let message = format!("{} has samples of {} sensors or topics: select one", file.file, groups.len());
    let help = format!("as in `column = {}`: {}{more}", names.join(","), listed.join(", "));
    Some(file.refuse(None, &message, "", &help))
}

/// The error for a file without a header of which at least two of times, columns and units are open, with the settings for all of
/// them. The columns `taken` are those of the time, as far as it is found, and of a temperature.
pub(crate) fn unnamed(
    file: &ColumnFile,
    request: &Request,
    taken: [Option<usize>; 2],
) -> Option<RecordError> {
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
