//! Recordings of ROS 2 in SQLite databases (.db3).

use std::collections::HashMap;
use std::io;

use crate::record::format::messages::{Messages, Reader};
use crate::record::format::sqlite::{Database, MAGIC, Table, Value};
use crate::record::format::{Columns, Format, Origin, Source};
use crate::record::{RecordError, malformed, told};

pub(crate) const FORMAT: Format = Format { begins: |head| head.starts_with(MAGIC), open };

fn open(source: Source<'_>) -> Result<Box<dyn Columns + '_>, RecordError> {
    let (file, mut messages) = (source.file.clone(), Messages::default());
    take(source, &mut messages)?;
    messages.columns(&file)
}

/// Adds all messages of the file to those of the files before.
pub(crate) fn take(source: Source<'_>, found: &mut Messages) -> Result<(), RecordError> {
    let file = source.file.clone();
    let refused = |why: &str| {
        let help = "if the recording was cut short, `sqlite3 BAG.db3 .recover` saves what is intact; else convert it with `ros2 bag convert`";
        RecordError::new(format!("{file} cannot be taken as a ROS 2 bag: {why}"), "", help, None)
    };
    // Rows that SQLite has not yet moved into the file are in another one beside it.
    if let Origin::Path(path) = source.origin {
        for (ending, what) in [("-wal", "committed"), ("-journal", "unfinished")] {
            let mut beside = path.as_os_str().to_owned();
            beside.push(ending);
            if std::fs::metadata(&beside).is_ok_and(|about| about.len() > 0) {
                let message = format!("{file} has {what} changes in {}", beside.display());
                let help = format!(
                    "let SQLite finish them, as by `sqlite3 {file} \"PRAGMA wal_checkpoint(TRUNCATE)\"`"
                );
                return Err(RecordError::new(message, "", help, None));
            }
        }
    }
    let (bytes, length) = (source.seekable()?, source.size()?);
    let read = Database::open(bytes, length).and_then(|mut database| {
        let tables = [database.table("topics"), database.table("messages")];
        let [Some(topics), Some(messages)] = tables else { return Ok(Err(database.names())) };
        read(&mut database, &topics, &messages, found).map(Ok)
    });
    match read {
        Ok(Ok(())) => Ok(()),
        Ok(Err(names)) => {
            let held = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
            let message =
                format!("{file} is a database, but no ROS 2 bag: it lacks the tables topics and messages");
            let help =
                format!("its tables are {held}: save the samples as CSV, as by `sqlite3 -csv -header`");
            Err(RecordError::new(message, "", help, None))
        }
        Err(error) => Err(refused(&told(&error))),
    }
}

/// The places of columns in a table.
fn places<const N: usize>(table: &Table, names: [&str; N]) -> io::Result<[usize; N]> {
    let mut places = [0; N];
    for (place, name) in places.iter_mut().zip(names) {
        match table.column(name) {
            Some(column) => *place = column,
            None => return malformed(&format!("its table {} has no column {name}", table.name)),
        }
    }
    Ok(places)
}

/// The text of a row in a column.
fn text<'v>(values: &[Value<'v>], column: usize) -> &'v str {
    match values.get(column) {
        Some(Value::Text(text)) => text,
        _ => "",
    }
}

/// Reads all messages with samples.
fn read(database: &mut Database, topics: &Table, messages: &Table, found: &mut Messages) -> io::Result<()> {
    let mut definitions = HashMap::new();
    if let Some(table) = database.table("message_definitions") {
        let [kind, encoding, text_of] =
            places(&table, ["topic_type", "encoding", "encoded_message_definition"])?;
        database.rows(&table, &mut |_, values| {
            if text(values, encoding) == "ros2msg" {
                definitions.insert(text(values, kind).to_owned(), text(values, text_of).to_owned());
            }
            Ok(())
        })?;
    }
    let mut readers: HashMap<i64, Option<(String, Reader)>> = HashMap::new();
    let [id, name, kind, format] = places(topics, ["id", "name", "type", "serialization_format"])?;
    database.rows(topics, &mut |row, values| {
        let kind = text(values, kind);
        let reader = found.reader(kind, definitions.get(kind).map(String::as_str), text(values, format));
        // The key of a table is the number of the row where it is not among the values.
        let id = if let Some(Value::Integer(id)) = values.get(id) { *id } else { row };
        readers.insert(id, reader.map(|reader| (text(values, name).to_owned(), reader)));
        Ok(())
    })?;
    let [topic, data] = places(messages, ["topic_id", "data"])?;
    let time = messages.column("timestamp");
    database.rows(messages, &mut |_, values| {
        let (Some(Value::Integer(topic)), Some(Value::Blob(message))) = (values.get(topic), values.get(data))
        else {
            return malformed("a message is damaged");
        };
        let arrival = match time.and_then(|time| values.get(time)) {
            Some(Value::Integer(time)) => u64::try_from(*time).ok(),
            _ => None,
        };
        match readers.get(topic) {
            None => malformed("a message belongs to no topic"),
            Some(None) => Ok(()),
            Some(Some((name, reader))) => found.take(name, message, arrival, reader),
        }
    })
}

#[cfg(test)]
mod tests {
    use crate::record::format::tests::{channel, refusal};
    use crate::record::log::Log;
    use crate::record::log::read::Request;

    const BAG: &[u8] = include_bytes!("../../../../../tests/data/formats/imu.db3");

    /// The bag with other texts of the same lengths in place of some.
    fn with(texts: &[(&str, &str)]) -> Vec<u8> {
        let mut bag = BAG.to_vec();
        for (old, new) in texts {
            let places: Vec<usize> =
                (0..bag.len() - old.len()).filter(|at| bag[*at..].starts_with(old.as_bytes())).collect();
            assert!(!places.is_empty() && old.len() == new.len(), "{old}");
            places.into_iter().for_each(|at| bag[at..at + new.len()].copy_from_slice(new.as_bytes()));
        }
        bag
    }

    #[test]
    fn topics_are_groups_and_others_are_named() {
        assert_eq!(channel(BAG, "/imu/data.az").samples.len(), 43);
        let said = refusal(BAG, "");
        assert!(said.contains("as in `column = /imu/data.gx,/imu/data.gy,/imu/data.gz`"), "{said}");
        let none = with(&[("sensor_msgs/msg/Imu", "sensor_msgs/msg/Joy"), ("TwistStamped", "PoseStampeds")]);
        let said = refusal(&none, "gx");
        assert!(
            said.contains("geometry_msgs/msg/PoseStampeds, sensor_msgs/msg/Joy, std_msgs/msg/String"),
            "{said}"
        );
        let px4 = with(&[("TwistStamped", "PoseStampeds"), ("sensor_msgs/msg/Imu", "px4_msgs/SensorGyro")]);
        let said = refusal(&px4, "gx");
        assert!(said.contains("is no px4_msgs/SensorGyro of PX4 1.12 to 1.18"), "{said}");
    }

    #[test]
    fn what_is_no_bag_or_not_in_the_file_is_refused() {
        let said = refusal(&with(&[("topicstopics", "tables-table")]), "gx");
        assert!(said.contains("no ROS 2 bag") && said.contains("schema, tables, messages"), "{said}");
        let said = refusal(&with(&[(",topic_id ", ",tropicid ")]), "gx");
        assert!(said.contains("its table messages has no column topic_id"), "{said}");
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("imu.db3");
        std::fs::write(&path, BAG).unwrap();
        let request = Request { columns: vec!["/imu/data.gx".to_owned()], ..Request::default() };
        assert!(Log::read(&path, &request).is_ok());
        std::fs::write(folder.path().join("imu.db3-wal"), [0; 32]).unwrap();
        let said = Log::read(&path, &request).unwrap_err().to_string();
        assert!(said.contains("has committed changes in") && said.contains("imu.db3-wal"), "{said}");
    }
}
