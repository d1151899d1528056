//! Recordings of ROS 2 as folders: one file or several (.db3, .mcap), with their names in `metadata.yaml`.

use std::path::{Path, PathBuf};

use sagnac_base::text_file::{MAX_TOML, read_text};
use sagnac_records::record::RecordError;
use sagnac_records::record::log::Log;
use sagnac_records::record::log::read::Request;

/// The file with the names of the others, and the key of their list.
const METADATA: &str = "metadata.yaml";
const NAMES: &str = "relative_file_paths:";

/// Endings of the names of recordings.
const ENDINGS: [&str; 4] = [".db3", ".mcap", ".db3.zstd", ".mcap.zstd"];

/// Reads the columns that `request` selects of the recording in a folder.
///
/// # Errors
/// The folder has no recording of ROS 2, or several, or the recording is refused.
pub(crate) fn read(folder: &Path, request: &Request) -> Result<Log, RecordError> {
    Log::read_parts(&folder.display().to_string(), &files(folder)?, request)
}

/// The files of the recording in a folder, in their order.
fn files(folder: &Path) -> Result<Vec<PathBuf>, RecordError> {
    let shown = folder.display().to_string();
    let unreadable = |error: std::io::Error| {
        RecordError::new(format!("cannot read {shown}: {error}"), "", "give the path of a log", None)
    };
    let metadata = folder.join(METADATA);
    let text =
        if metadata.is_file() { read_text(&metadata, MAX_TOML).map_err(unreadable)? } else { String::new() };
    let mut names = listed(&text);
    if names.is_empty() {
        let entries = std::fs::read_dir(folder).and_then(Iterator::collect::<Result<Vec<_>, _>>);
        let entries = entries.map_err(unreadable)?.into_iter();
        names = entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
        names.retain(|name| recording(name).is_some());
        // Longer numbers are behind shorter ones.
        names.sort_by_key(|name| (name.len(), name.clone()));
        if names.iter().any(|name| recording(name) != recording(&names[0])) {
            let message = format!("{shown} has several recordings of ROS 2");
            let help = format!("give one of them: {}", names.join(", "));
            return Err(RecordError::new(message, "", help, None));
        }
    }
    if names.is_empty() {
        let message = format!("{shown} is a folder without a recording of ROS 2 (.db3, .mcap)");
        return Err(RecordError::new(message, "", "give the path of a log", None));
    }
    Ok(names.iter().map(|name| folder.join(name)).collect())
}

/// The names of the files in the text of `metadata.yaml`, which are all in the folder.
fn listed(text: &str) -> Vec<String> {
    let lines = text.lines().map(str::trim).skip_while(|line| !line.starts_with(NAMES)).skip(1);
    let items = lines.map_while(|line| line.strip_prefix("- "));
    let names = items.map(|item| item.trim().trim_matches(['"', '\'']));
    // Early versions wrote the folder before the name.
    names.filter_map(|name| Some(Path::new(name).file_name()?.to_string_lossy().into_owned())).collect()
}

/// The name that the files of one recording share: without their ending, and without their number, as in `drive_0.db3`.
fn recording(name: &str) -> Option<&str> {
    let stem = ENDINGS.iter().find_map(|ending| name.strip_suffix(ending))?;
    let numbered = stem.rsplit_once('_').filter(|(_, number)| number.bytes().all(|b| b.is_ascii_digit()));
    Some(numbered.map_or(stem, |(name, _)| name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn metadata_has_the_order_of_files() {
        let text = "rosbag2_bagfile_information:\n  version: 5\n  relative_file_paths:\n    - drive_1.mcap\n    - \"old/drive_0.mcap\"\n  \
                    duration:\n    nanoseconds: 5\n";
        assert_eq!(listed(text), ["drive_1.mcap", "drive_0.mcap"]);
        assert!(listed("version: 5\n").is_empty());
    }

    #[test]
    fn without_metadata_numbers_have_the_order_of_files_and_several_recordings_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let add = |name: &str| std::fs::write(folder.path().join(name), "").unwrap();
        assert!(files(folder.path()).unwrap_err().to_string().contains("without a recording"));
        ["drive_10.db3", "drive_9.db3", "notes.txt"].into_iter().for_each(add);
        let [first, last] = ["drive_9.db3", "drive_10.db3"].map(|name| folder.path().join(name));
        assert_eq!(files(folder.path()).unwrap(), [first, last]);
        add("other.mcap");
        let said = files(folder.path()).unwrap_err().render(false, 200);
        assert!(said.contains("give one of them: other.mcap, drive_9.db3, drive_10.db3"), "{said}");
    }

    #[test]
    fn files_of_one_recording_share_a_name() {
        for (name, shared) in [
            ("drive_0.db3", Some("drive")),
            ("a_b_12.mcap.zstd", Some("a_b")),
            ("drive_x.db3", Some("drive_x")),
            ("metadata.yaml", None),
        ] {
            assert_eq!(recording(name), shared, "{name}");
        }
    }
}
