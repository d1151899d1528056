//! Damaged databases: whatever is cut, altered, missing or foreign, a run gives the right tables or says what is wrong, and never a
//! wrong number.

use std::collections::BTreeMap;
use std::path::Path;

use crate::stores::{MOMENTS, ROWS, cpu, csv, finished, folder, sample, study};
use crate::studies::Silent;
use rand::rngs::SmallRng;
use rand::{RngExt, SeedableRng};
use sagnac::device::Device;
use sagnac::run::{Plan, RunError};
use sagnac::store::source::Source;
use sagnac::store::{FILE, Store};
use sagnac::study::Study;
use sagnac::tally::Share;

const ATTEMPTS: usize = 500;

/// A database and its journal as a program that is killed leaves them: some rows in each.
#[derive(Clone)]
struct Left {
    database: Vec<u8>,
    journal: Vec<u8>,
}

impl Left {
    fn by(study: &Study, device: &mut Device) -> Left {
        let folder = crate::stores::folder();
        let plan = Plan::new(study).unwrap();
        sample(&plan, folder.path(), device, Share::new(1, 2).unwrap()).unwrap();
        let mut store = Store::open(folder.path(), &plan.identity()).unwrap();
        plan.run(&mut store, device, Share::new(3, 4).unwrap(), &Silent).unwrap();
        let left = Left::read(folder.path());
        assert!(left.database.len() > 10_000 && left.journal.len() > 10_000, "both have rows");
        left
    }

    /// A folder with one share alone: its first half is in the database, the other in the journal.
    fn of_share(study: &Study, share: Share, device: &mut Device) -> Left {
        let folder = crate::stores::folder();
        let half = crate::stores::study(MOMENTS, study.trials / 2, study.seed);
        sample(&Plan::new(&half).unwrap(), folder.path(), device, share).unwrap();
        let plan = Plan::new(study).unwrap();
        let mut store = Store::open(folder.path(), &plan.identity()).unwrap();
        plan.run(&mut store, device, share, &Silent).unwrap();
        Left::read(folder.path())
    }

    fn read(folder: &Path) -> Left {
        let read = |end: &str| std::fs::read(folder.join(format!("{FILE}{end}"))).unwrap();
        Left { database: read(""), journal: read("-wal") }
    }

    fn write(&self, folder: &Path) {
        std::fs::write(folder.join(FILE), &self.database).unwrap();
        std::fs::write(folder.join(format!("{FILE}-wal")), &self.journal).unwrap();
    }
}

/// A study, what it should give, and what was left of a run of it.
struct Case<'a> {
    plan: Plan<'a>,
    tables: Vec<u8>,
    left: Left,
}

impl Case<'_> {
    fn new<'a>(study: &'a Study, device: &mut Device) -> Case<'a> {
        let plan = Plan::new(study).unwrap();
        let tables = finished(&plan, folder().path(), device).unwrap();
        Case { plan, tables, left: Left::by(study, device) }
    }

    /// Runs the study in a folder where this was left. `None` where it gives the right tables, else why it is refused.
    fn refused(&self, left: &Left, device: &mut Device, what: &str) -> Option<String> {
        let folder = crate::stores::folder();
        left.write(folder.path());
        let error = match finished(&self.plan, folder.path(), device) {
            Ok(tables) => {
                if tables != self.tables {
                    let [found, wanted] =
                        [&tables, &self.tables].map(|bytes| String::from_utf8_lossy(bytes).into_owned());
                    let differ = found.lines().zip(wanted.lines()).find(|(found, wanted)| found != wanted);
                    panic!("{what}: a wrong number: {differ:?}");
                }
                return None;
            }
            Err(RunError::Store(error)) => error.to_string(),
            Err(error) => panic!("{what}: {error}"),
        };
        assert!(error.contains(FILE) && error.contains('\n'), "{what}: where, and what to do: {error}");
        // What is sound of it can be taken over, and the rest sampled again.
        let out = crate::stores::folder();
        let mut store = Store::open(out.path(), &self.plan.identity()).unwrap();
        let salvaged = Source::open(folder.path()).and_then(|source| store.merge(&source, true));
        if salvaged.is_ok() {
            self.plan.run(&mut store, device, Share::WHOLE, &Silent).unwrap();
            assert!(
                csv(&self.plan.tables(&store, &Silent).unwrap()) == self.tables,
                "{what}: a wrong number saved"
            );
        }
        // The first words that are always the same.
        let kinds = [
            "not a results database",
            "is damaged",
            "has schema",
            "another study",
            "differ from those stored",
            "kernels",
        ];
        let kind =
            kinds.iter().find(|kind| error.contains(**kind)).unwrap_or_else(|| panic!("{what}: {error}"));
        Some(format!("{kind}, {}", if salvaged.is_ok() { "saved in part" } else { "lost" }))
    }
}

/// Changes bytes at up to three places, or a whole sector.
fn altered(bytes: &[u8], random: &mut SmallRng) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    if random.random_range(0..4) == 0 {
        let sector = random.random_range(0..bytes.len() / 512);
        let fill: u8 = if random.random() { 0 } else { random.random() };
        bytes[512 * sector..512 * (sector + 1)].fill(fill);
    } else {
        for _ in 0..random.random_range(1..=3) {
            let at = random.random_range(0..bytes.len());
            bytes[at] ^= random.random_range(1..=255_u8);
        }
    }
    bytes
}

fn cut(bytes: &[u8], random: &mut SmallRng) -> Vec<u8> {
    bytes[..random.random_range(0..bytes.len())].to_vec()
}

type Change = fn(&Left, &mut SmallRng) -> Left;

const CHANGES: [(&str, Change); 4] = [
    ("database cut", |left, random| Left { database: cut(&left.database, random), ..left.clone() }),
    ("database altered", |left, random| Left { database: altered(&left.database, random), ..left.clone() }),
    ("journal cut", |left, random| Left { journal: cut(&left.journal, random), ..left.clone() }),
    ("journal altered", |left, random| Left { journal: altered(&left.journal, random), ..left.clone() }),
];

#[test]
fn cut_and_altered_files_are_recovered_or_refused_and_never_give_a_wrong_number() {
    let mut device = cpu(1);
    for (text, trials) in [(MOMENTS, 1000), (ROWS, 60)] {
        let study = study(text, trials, 1);
        let case = Case::new(&study, &mut device);
        assert_eq!(case.refused(&case.left, &mut device, "as it was left"), None);
        for (what, change) in CHANGES {
            let mut random = SmallRng::seed_from_u64(trials);
            let mut outcomes: BTreeMap<String, usize> = BTreeMap::new();
            for attempt in 0..ATTEMPTS {
                let left = change(&case.left, &mut random);
                let name = format!("{what}, {}, attempt {attempt}", study.title);
                let outcome = case.refused(&left, &mut device, &name).unwrap_or("recovered".to_owned());
                *outcomes.entry(outcome).or_default() += 1;
            }
            println!("{}: {what} at {ATTEMPTS} places: {outcomes:?}", study.title);
            let recovered = outcomes.get("recovered").copied().unwrap_or(0);
            if what.starts_with("database") {
                assert!(recovered < ATTEMPTS, "{outcomes:?}");
            } else {
                // What follows a broken frame is as if it had never been written.
                assert_eq!(recovered, ATTEMPTS, "{outcomes:?}");
            }
        }
    }
}

#[test]
fn empty_missing_and_foreign_files_are_recovered_or_refused() {
    let mut device = cpu(1);
    let (study, other) = (study(MOMENTS, 1000, 1), study(MOMENTS, 1000, 2));
    let (case, other) = (Case::new(&study, &mut device), Case::new(&other, &mut device));
    let Left { database, journal } = case.left.clone();
    let rows = Case::new(&crate::stores::study(ROWS, 60, 1), &mut device).left;
    let shares = [(1, 2), (2, 2)]
        .map(|(number, of)| Left::of_share(&study, Share::new(number, of).unwrap(), &mut device));
    let mut refused = |database: &[u8], journal: &[u8], what: &str| {
        case.refused(&Left { database: database.to_vec(), journal: journal.to_vec() }, &mut device, what)
    };
    let of_another_program = {
        let folder = crate::stores::folder();
        let connection = rusqlite::Connection::open(folder.path().join(FILE)).unwrap();
        connection.execute_batch("CREATE TABLE tally (x); INSERT INTO tally VALUES (1)").unwrap();
        drop(connection);
        std::fs::read(folder.path().join(FILE)).unwrap()
    };
    for (database, journal, what) in [
        (&[][..], &[][..], "both empty"),
        (&[], &journal[..], "database empty"),
        (&database, &[], "journal missing"),
        (&database, &[0; 4096], "journal of zeros"),
        (&database, b"not a journal, only some text that is longer than its header", "journal of text"),
    ] {
        assert_eq!(refused(database, journal, what), None, "{what}");
    }
    let foreign = Some("not a results database, lost".to_owned());
    for (database, what) in [
        (&b"not a database, only some text\n"[..], "text"),
        (&[0x89, b'P', b'N', b'G', 0xd, 0xa, 0x1a, 0xa, 0, 0, 0, 0xd, b'I', b'H', b'D', b'R'], "a picture"),
        (&of_another_program, "of another program"),
    ] {
        assert_eq!(refused(database, &[], what), foreign, "{what}");
    }
    let another = refused(&other.left.database, &other.left.journal, "of another study");
    assert!(another.is_some_and(|why| why.starts_with("another study")));
    // A journal of another database is played back: its pages stand among those of this one. It is found out, or they are all
    // the pages that there are, and the tables are right.
    for (database, journal, what) in [
        (&database, &other.left.journal, "journal of another seed"),
        (&other.left.database, &journal, "database of another seed"),
        (&database, &rows.journal, "journal of another kind"),
        (&rows.database, &journal, "database of another kind"),
    ] {
        let outcome = refused(database, journal, what);
        println!("{what}: {}", outcome.unwrap_or("recovered".to_owned()));
    }
    // Of another share of the same study, so that every row is a right one: found out, or the tables are right.
    for (one, other) in [(0, 1), (1, 0)] {
        let (database, journal) = (&shares[one].database, &shares[other].journal);
        let outcome = refused(database, journal, "journal of another share");
        println!("journal of another share: {}", outcome.unwrap_or("recovered".to_owned()));
    }
    // A journal that some rows of this one have been taken over from already.
    let later = {
        let folder = crate::stores::folder();
        case.left.write(folder.path());
        drop(Store::open(folder.path(), &case.plan.identity()).unwrap());
        std::fs::read(folder.path().join(FILE)).unwrap()
    };
    assert_eq!(refused(&later, &journal, "a journal again"), None);
}

#[test]
fn a_database_that_is_cut_short_is_saved_up_to_the_cut() {
    let mut device = cpu(1);
    let study = study(MOMENTS, 1000, 1);
    let case = Case::new(&study, &mut device);
    let folder = folder();
    assert!(finished(&case.plan, folder.path(), &mut device).unwrap() == case.tables);
    let whole = std::fs::read(folder.path().join(FILE)).unwrap();
    for eighths in 1..8 {
        std::fs::write(folder.path().join(FILE), &whole[..whole.len() * eighths / 8]).unwrap();
        let out = crate::stores::folder();
        let mut store = Store::open(out.path(), &case.plan.identity()).unwrap();
        let saved = store.merge(&Source::open(folder.path()).unwrap(), true).unwrap();
        println!("{eighths}/8 of the file: {saved:?}");
        // What can be reached from the first row on and from the last one back.
        assert!(saved.damaged > 0 && (saved.added > 0 || eighths < 4), "{eighths}/8: {saved:?}");
        case.plan.run(&mut store, &mut device, Share::WHOLE, &Silent).unwrap();
        assert!(
            csv(&case.plan.tables(&store, &Silent).unwrap()) == case.tables,
            "{eighths}/8: a wrong number"
        );
    }
}
