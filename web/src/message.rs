//! Messages between a page and the library: a JSON value with files.

use sagnac::analysis::decision::DecisionError;
use sagnac::record::RecordError;
use sagnac::run::RunError;
use sagnac::store::StoreError;
use sagnac::use_cases::LogError;
use sagnac::use_cases::Outcome;
use sagnac_base::diagnostics::{StudyError, spelled};
use serde_json::{Map, Value, json};

/// Width of messages, in columns.
const WIDTH: usize = 100;

/// A request of the page: a JSON value with the files that belong to it.
pub(crate) struct Message<'a> {
    pub(crate) json: Value,
    pub(crate) files: Vec<&'a [u8]>,
}

impl Message<'_> {
    /// Reads the length of the JSON, the JSON with the lengths of the files in `blobs`, and the files.
    pub(crate) fn decode(bytes: &[u8]) -> Result<Message<'_>, Refusal> {
        let cut = || Refusal::usage("the message is cut");
        let (length, rest) = bytes.split_first_chunk().ok_or_else(cut)?;
        let (text, mut rest) = rest.split_at_checked(u32::from_le_bytes(*length) as usize).ok_or_else(cut)?;
        let mut json: Value =
            serde_json::from_slice(text).map_err(|error| Refusal::usage(&error.to_string()))?;
        let lengths = json.as_object_mut().and_then(|json| json.remove("blobs"));
        let mut files = vec![];
        for length in lengths.iter().filter_map(Value::as_array).flatten() {
            let length = length.as_u64().and_then(|length| usize::try_from(length).ok()).ok_or_else(cut)?;
            let (file, after) = rest.split_at_checked(length).ok_or_else(cut)?;
            files.push(file);
            rest = after;
        }
        Ok(Message { json, files })
    }
}

/// An answer of the library: a JSON value with files.
pub(crate) struct Reply {
    json: Value,
    files: Vec<Vec<u8>>,
}

impl Reply {
    /// A reply without files.
    pub(crate) fn new(json: Value) -> Reply {
        Reply { json, files: vec![] }
    }

    pub(crate) fn with_file(mut self, bytes: Vec<u8>) -> Reply {
        self.files.push(bytes);
        self
    }

    /// An outcome: its headline and notes, its page, and the names of its tables and further files, which follow the page.
    pub(crate) fn of_outcome(outcome: &Outcome) -> Result<Reply, Refusal> {
        let mut files = vec![outcome.page.html(&in_page).into_bytes()];
        let mut names: Vec<&str> = vec![];
        for (name, table) in outcome.all_tables() {
            let mut csv = vec![];
            table.write_csv(&mut csv).map_err(|error| Refusal::other(&error.to_string()))?;
            names.push(*name);
            files.push(csv);
        }
        for (name, contents) in &outcome.files {
            names.push(name);
            files.push(contents.clone());
        }
        let notes: Vec<String> = outcome.page.all_notes().iter().map(|note| in_page(note)).collect();
        let headline = &outcome.page.answer.headline;
        Ok(Reply { json: json!({ "headline": headline, "notes": notes, "files": names }), files })
    }

    /// Adds a value.
    pub(crate) fn with(mut self, name: &str, value: impl Into<Value>) -> Reply {
        if let Some(json) = self.json.as_object_mut() {
            json.insert(name.to_owned(), value.into());
        }
        self
    }

    pub(crate) fn encode(self) -> Vec<u8> {
        let mut json = match self.json {
            Value::Object(json) => json,
            other => Map::from_iter([("value".to_owned(), other)]),
        };
        json.insert("blobs".to_owned(), self.files.iter().map(Vec::len).collect::<Vec<_>>().into());
        let text = Value::Object(json).to_string();
        let mut bytes = (text.len() as u32).to_le_bytes().to_vec();
        bytes.extend(text.into_bytes());
        self.files.iter().for_each(|file| bytes.extend(file));
        bytes
    }
}

/// A setting in the words of the page.
fn setting(name: &str, value: &str) -> Option<String> {
    Some(format!("{name}: {value}"))
}

/// A message with its settings in the words of the page.
pub(crate) fn in_page(text: &str) -> String {
    spelled(text, &setting)
}

/// Why there is no answer.
pub(crate) struct Refusal {
    kind: &'static str,
    text: String,
}

impl Refusal {
    /// The request is wrong.
    pub(crate) fn usage(text: &str) -> Refusal {
        Refusal { kind: "usage", text: in_page(text) }
    }

    pub(crate) fn other(text: &str) -> Refusal {
        Refusal { kind: "other", text: in_page(text) }
    }

    fn rendered(kind: &'static str, error: StudyError) -> Refusal {
        Refusal { kind, text: error.spelled(&setting).render(false, WIDTH).trim_end().to_owned() }
    }

    pub(crate) fn into_reply(self) -> Reply {
        Reply::new(json!({ "error": { "kind": self.kind, "text": self.text } }))
    }
}

impl From<StudyError> for Refusal {
    fn from(error: StudyError) -> Refusal {
        Refusal::rendered("study", error)
    }
}

impl From<RecordError> for Refusal {
    fn from(error: RecordError) -> Refusal {
        Refusal::rendered("record", error.into())
    }
}

impl From<LogError> for Refusal {
    fn from(error: LogError) -> Refusal {
        match error.is_usage() {
            true => Refusal::usage(&error.to_string()),
            false => Refusal { kind: "record", ..Refusal::usage(&error.to_string()) },
        }
    }
}

impl From<StoreError> for Refusal {
    fn from(error: StoreError) -> Refusal {
        Refusal::other(&error.to_string())
    }
}

impl From<RunError> for Refusal {
    fn from(error: RunError) -> Refusal {
        Refusal::other(&error.to_string())
    }
}

impl From<DecisionError> for Refusal {
    fn from(error: DecisionError) -> Refusal {
        match error {
            DecisionError::Study(error) => error.into(),
            error => Refusal::other(&error.to_string()),
        }
    }
}
