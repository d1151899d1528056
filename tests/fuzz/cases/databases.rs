//! Results folders: whatever a database holds as bytes or as a schema, and wherever links in the folder lead, it is refused in
//! words, or its study ends with the tables of an undisturbed run; nothing outside the folder changes.

use std::fs;
use std::path::Path;
use std::sync::LazyLock;

use rusqlite::Connection;
use sagnac::device::{Cpu, Device};
use sagnac::progress::Silent;
use sagnac::run::Plan;
use sagnac::store::source::Source;
use sagnac::store::{FILE, Store};
use sagnac::study::Study;
use sagnac::tally::Share;
use sagnac_kernel::width::Width;
use tempfile::TempDir;

use super::Outcome;

const STUDY: &str = r#"title = "Tallies"
kind = "gap-fill"
trials = 300
[gyro]
tick = "5 ms"
tick_noise = { std = "1 arcsec" }
[motion]
amplitude = "12000 arcsec/s"
frequency = "20 Hz"
[switching]
gap_ticks = 3
fillers = ["const", "quadratic"]
"#;

/// The header of a database; inputs without it are instructions, one a line.
const MAGIC: &[u8] = b"SQLite format 3\0";

/// A line that begins so makes the first name a link to the second.
pub const LINK: &str = "link ";

/// What lies outside the folder, where links lead.
const OUTSIDE: &str = "outside";
const KEPT: &str = "of another program";

/// The study, its table and the database of a whole run.
struct Sound {
    study: Study,
    table: Vec<u8>,
    database: Vec<u8>,
}

static SOUND: LazyLock<Sound> = LazyLock::new(|| {
    let study = Study::parse("study.toml", STUDY).expect("a study");
    let folder = TempDir::new().unwrap();
    let table = finished(&study, folder.path()).expect("a whole run");
    let database = fs::read(folder.path().join(FILE)).unwrap();
    Sound { study, table, database }
});

/// The database of a whole run.
pub fn database() -> &'static [u8] {
    &SOUND.database
}

/// Opens, checks, finishes and merges the folder that the input describes.
///
/// # Panics
/// The folder shows a fault of the library.
pub fn run(input: &[u8]) -> Vec<Outcome> {
    let around = TempDir::new().unwrap();
    let folder = around.path().join("folder");
    fs::create_dir(&folder).unwrap();
    fs::write(around.path().join(OUTSIDE), KEPT).unwrap();
    let file = folder.join(FILE);
    if input.starts_with(MAGIC) {
        fs::write(&file, input).unwrap();
    } else {
        fs::write(&file, &SOUND.database).unwrap();
        let text = String::from_utf8_lossy(input);
        for line in text.lines() {
            follow(&folder, line);
        }
    }
    let outcomes = vec![merged(&folder), resumed(&folder)];
    let outside = fs::read(around.path().join(OUTSIDE)).unwrap();
    assert_eq!(String::from_utf8_lossy(&outside), KEPT, "a file outside the folder was written");
    outcomes
}

/// Makes a link, or changes the database by a statement; what SQLite does not accept changes nothing.
fn follow(folder: &Path, line: &str) {
    if let Some((name, target)) = line.strip_prefix(LINK).and_then(|words| words.split_once(' ')) {
        let plain = |name: &str| {
            !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || "._-".contains(c))
        };
        if plain(name) && name != ".." && name != "." {
            let _ = fs::remove_file(folder.join(name));
            #[cfg(unix)]
            let _ = std::os::unix::fs::symlink(target, folder.join(name));
        }
    } else if let Ok(connection) = Connection::open(folder.join(FILE)) {
        let _ = connection.execute_batch(line);
    }
}

/// Runs what is left of the study, whose table must be that of an undisturbed run.
fn resumed(folder: &Path) -> Outcome {
    match finished(&SOUND.study, folder) {
        Ok(table) => {
            assert_eq!(
                String::from_utf8_lossy(&table),
                String::from_utf8_lossy(&SOUND.table),
                "another table"
            );
            Outcome::Accepted("run".to_owned())
        }
        Err(refusal) => Outcome::Refused(refusal),
    }
}

/// Merges the folder into an empty one, where the study then ends as it should.
fn merged(folder: &Path) -> Outcome {
    let target = TempDir::new().unwrap();
    let plan = Plan::new(&SOUND.study).expect("a plan");
    let merge = || -> Result<(), String> {
        let source = Source::open(folder).map_err(|error| error.to_string())?;
        let mut store = Store::open(target.path(), &plan.identity()).map_err(|error| error.to_string())?;
        store.merge(&source, false).map(drop).map_err(|error| error.to_string())
    };
    let outcome = merge();
    // Whether it was taken over or refused, what the target holds is sound.
    let table = finished(&SOUND.study, target.path()).expect("a target that stays sound");
    assert_eq!(
        String::from_utf8_lossy(&table),
        String::from_utf8_lossy(&SOUND.table),
        "another table after a merge"
    );
    match outcome {
        Ok(()) => Outcome::Accepted("merge".to_owned()),
        Err(refusal) => Outcome::Refused(refusal),
    }
}

fn finished(study: &Study, folder: &Path) -> Result<Vec<u8>, String> {
    let plan = Plan::new(study).expect("a plan");
    let mut device = Device::Cpu(Cpu::new(Width::widest(), 1).expect("a thread"));
    let mut store = Store::open(folder, &plan.identity()).map_err(|error| error.to_string())?;
    plan.run(&mut store, &mut device, Share::WHOLE, &Silent).map_err(|error| error.to_string())?;
    let tables = plan.tables(&store, &Silent).map_err(|error| error.to_string())?;
    let mut bytes = Vec::new();
    tables.points.write_csv(&mut bytes).unwrap();
    Ok(bytes)
}
