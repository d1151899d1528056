//! What a run leaves: tables, rows, provenance, and what it told.

use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use rusqlite::types::Value;
use sagnac::device::Device;
use sagnac::progress::Progress;
use sagnac::run::{Plan, RunStats, Tables};
use sagnac::store::Store;
use sagnac::study::Study;
use sagnac::tally::Share;

/// What a run tells as it goes on.
#[derive(Default)]
struct Heard {
    done: AtomicU64,
    total: AtomicU64,
    notes: Mutex<Vec<String>>,
}

impl Progress for Heard {
    fn start(&self, _: &'static str, done: u64, total: u64) {
        self.done.store(done, Ordering::Relaxed);
        self.total.store(total, Ordering::Relaxed);
    }
    fn advance(&self, more: u64) {
        self.done.fetch_add(more, Ordering::Relaxed);
    }
    fn note(&self, sentence: &str) {
        self.notes.lock().unwrap().push(sentence.to_owned());
    }
}

/// All that a run leaves.
pub struct Left {
    pub tables: Tables,
    /// All tallies, by point, estimate and first trial.
    pub rows: Vec<Vec<Value>>,
    pub devices: Vec<String>,
    pub done: RunStats,
}

pub fn run(study: &Study, device: &mut Device) -> Left {
    let folder = tempfile::tempdir().unwrap();
    let plan = Plan::new(study).unwrap_or_else(|error| panic!("{}", error.render(false, 100)));
    let heard = Heard::default();
    let mut store = Store::open(folder.path(), &plan.identity()).unwrap();
    let done = plan.run(&mut store, device, Share::WHOLE, &heard).unwrap();
    let tables = plan.tables(&store, &Heard::default()).unwrap();
    drop(store);
    let told = heard.done.load(Ordering::Relaxed);
    assert_eq!(told, heard.total.load(Ordering::Relaxed), "progress after {:?}", done.degraded);
    let mut notes = heard.notes.into_inner().unwrap();
    notes.sort();
    notes.dedup();
    let mut degraded = done.degraded.clone();
    degraded.sort();
    assert_eq!(notes, degraded, "what is said at once is said at the end, once");
    let rows = selected(folder.path(), "SELECT * FROM tally ORDER BY point, estimate, first, log2");
    let devices = selected(folder.path(), "SELECT device FROM provenance");
    let devices = devices.iter().map(|row| format!("{:?}", row[0])).collect();
    Left { tables, rows, devices, done }
}

fn selected(folder: &Path, sql: &str) -> Vec<Vec<Value>> {
    let database = rusqlite::Connection::open(folder.join(sagnac::store::FILE)).unwrap();
    let mut statement = database.prepare(sql).unwrap();
    let columns = statement.column_count();
    let rows = statement.query_map([], |row| (0..columns).map(|column| row.get(column)).collect()).unwrap();
    rows.map(Result::unwrap).collect()
}
