mod sessions;

use rusqlite::Connection;

use super::*;
use crate::store::row::COLUMNS;

fn connection(store: &Store) -> &Connection {
    &store.keep.database().unwrap().connection
}

fn identity() -> Identity {
    Identity {
        kind: "gap-fill".to_owned(),
        seed: 1,
        streams: "independent".to_owned(),
        kernels: "gap_fill 2".to_owned(),
    }
}

fn address() -> Address {
    Address {
        point: Id::from_text("point"),
        estimate: Id::from_text("estimate"),
        digest: Id::from_text("digest"),
    }
}

fn row(first: u64, log2: u32) -> Row<Moments> {
    let mut tally = Moments::empty(true);
    tally.count = 1 << log2;
    tally.sum = i128::from(first);
    tally.bins[7] = tally.count;
    (tally.least, tally.greatest) = (-1, 1);
    Row { address: address(), block: Block { first, log2 }, tally }
}

fn so_far(trials: u64) -> Provenance {
    Provenance { device: "abacus".to_owned(), trials, seconds: 2.0 }
}

#[test]
fn rows_written_are_there_after_reopening_and_written_twice_count_once() {
    let folder = tempfile::tempdir().unwrap();
    for _ in 0..2 {
        let mut store = Store::open(folder.path(), &identity()).unwrap();
        store.insert(&[row(0, 2), row(4, 2)], Some(&so_far(8))).unwrap();
        let total = store.total(&address()).unwrap();
        assert_eq!((total.count, total.sum), (8, 4));
    }
    let store = Store::open(folder.path(), &identity()).unwrap();
    assert_eq!(store.index().unwrap().blocks(&address()).unwrap().len(), 2);
    assert_eq!(store.index().unwrap().points(), [address().point].into());
}

#[test]
fn totals_of_many_come_in_the_order_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path(), &identity()).unwrap();
    // Twice as many as are read at once.
    let addresses: Vec<Address> = (0..2500)
        .map(|i| Address { estimate: Id::from_text(&format!("estimate {i}")), ..address() })
        .collect();
    let of = |(i, address): (usize, &Address)| Row { address: *address, ..row(0, 1 + (i % 3) as u32) };
    let rows: Vec<_> = addresses.iter().enumerate().filter(|(i, _)| i % 7 != 0).map(of).collect();
    store.insert(&rows, None).unwrap();
    let found = store.of_totals(&addresses, |at, tally| (at, tally.count)).unwrap();
    let expected = |i: usize| if i.is_multiple_of(7) { 0 } else { 2 << (i % 3) };
    assert_eq!(found, (0..2500).map(|i| (i, expected(i))).collect::<Vec<_>>());
    let mut wrong = addresses.clone();
    wrong[1801].digest = Id::from_text("another kernel");
    assert!(matches!(store.of_totals(&wrong, |_, _| ()), Err(StoreError::Disagrees { .. })));
    assert_eq!(store.of_totals(&[], |_, _| ()).unwrap().len(), 0);
}

#[test]
fn tallies_of_a_point_are_found_whichever_of_them_are_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path(), &identity()).unwrap();
    let of = |point: &str, i: u32| {
        let (point, estimate) = (Id::from_text(point), Id::from_text(&format!("estimate {i}")));
        Address { point, estimate, ..address() }
    };
    let rows: Vec<_> = ["a", "b"]
        .into_iter()
        .flat_map(|point| (0..20).map(move |i| Row { address: of(point, i), ..row(0, i) }))
        .collect();
    store.insert(&rows, None).unwrap();
    // Twice the same, some left out, one that is not held, and a point twice.
    let asked = [("a", 3), ("a", 17), ("a", 3), ("a", 5), ("b", 9), ("b", 30), ("b", 2), ("a", 4), ("c", 1)];
    let addresses: Vec<Address> = asked.iter().map(|&(point, i)| of(point, i)).collect();
    let found = store.of_totals(&addresses, |_, tally| tally.count).unwrap();
    assert_eq!(found, [1 << 3, 1 << 17, 1 << 3, 1 << 5, 1 << 9, 0, 1 << 2, 1 << 4, 0]);
}

#[test]
fn a_larger_block_counts_in_place_of_its_parts() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path(), &identity()).unwrap();
    store.insert(&[row(0, 2), row(0, 3)], Some(&so_far(8))).unwrap();
    assert_eq!(store.total(&address()).unwrap().count, 8);
}

#[test]
fn a_disagreeing_row_is_refused_and_nothing_of_its_batch_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path(), &identity()).unwrap();
    store.insert(&[row(0, 2)], Some(&so_far(8))).unwrap();
    let mut other = row(0, 2);
    other.tally.sum += 1;
    assert!(matches!(
        store.insert(&[row(4, 2), other], Some(&so_far(8))),
        Err(StoreError::Disagrees { first: 0, .. })
    ));
    assert_eq!(store.total(&address()).unwrap().count, 4);
}

#[test]
fn rows_from_other_parameters_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path(), &identity()).unwrap();
    store.insert(&[row(0, 2)], Some(&so_far(8))).unwrap();
    let changed = Address { digest: Id::from_text("another kernel"), ..address() };
    assert!(matches!(store.index().unwrap().blocks(&changed), Err(StoreError::Disagrees { .. })));
    assert!(matches!(store.total(&changed), Err(StoreError::Disagrees { .. })));
}

#[test]
fn a_folder_of_another_study_and_a_folder_in_use_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let held = Store::open(folder.path(), &identity()).unwrap();
    assert!(matches!(Store::open(folder.path(), &identity()), Err(StoreError::Busy { .. })));
    drop(held);
    let other = Identity { seed: 2, ..identity() };
    let error = Store::open(folder.path(), &other).unwrap_err().to_string();
    assert!(error.contains("another study (seed 1"), "{error}");
}

#[test]
fn an_altered_row_is_found_by_its_checksum() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path(), &identity()).unwrap();
    store.insert(&[row(0, 2)], Some(&so_far(8))).unwrap();
    connection(&store).execute("UPDATE tally SET sums = x'0408000201070a'", []).unwrap();
    assert!(matches!(store.total(&address()), Err(StoreError::DamagedRow { .. })));
}

/// A database as another program may leave it.
fn prepared(sql: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let connection = Connection::open(folder.path().join(FILE)).unwrap();
    connection.execute_batch(sql).unwrap();
    folder
}

#[test]
fn databases_of_earlier_versions_and_of_other_programs_are_refused_and_left_alone() {
    let earlier = "CREATE TABLE study (key TEXT PRIMARY KEY, value TEXT NOT NULL);
                   INSERT INTO study VALUES ('schema', '2')";
    let folder = prepared(earlier);
    let error = Store::open(folder.path(), &identity()).unwrap_err();
    assert!(matches!(&error, StoreError::Schema { found, .. } if found == "2"), "{error}");
    let folder = prepared("CREATE TABLE accounts (name TEXT)");
    assert!(matches!(Store::open(folder.path(), &identity()), Err(StoreError::Foreign { .. })));
    assert!(matches!(Source::open(folder.path()).unwrap().identity(), Err(StoreError::Foreign { .. })));
    let connection = Connection::open(folder.path().join(FILE)).unwrap();
    let tables = connection.query_row("SELECT COUNT(*) FROM sqlite_schema", [], |row| row.get::<_, i64>(0));
    assert_eq!(tables.unwrap(), 1);
}

#[test]
fn a_folder_of_another_kernel_version_is_refused_and_told_which() {
    let folder = tempfile::tempdir().unwrap();
    drop(Store::open(folder.path(), &identity()).unwrap());
    let newer = Identity { kernels: "gap_fill 3".to_owned(), ..identity() };
    let error = Store::open(folder.path(), &newer).unwrap_err().to_string();
    for piece in ["by sagnac 0", "kernels gap_fill 2", "this program, gap_fill 3", "`out = DIR`"] {
        assert!(error.contains(piece), "{error}");
    }
}

#[test]
fn a_claim_that_was_altered_is_damage() {
    for (key, value) in [("seed", "2"), ("seed", "one"), ("id", "0"), ("kind", "allan")] {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::open(folder.path(), &identity()).unwrap();
        connection(&store).execute("UPDATE study SET value = ?1 WHERE key = ?2", [value, key]).unwrap();
        drop(store);
        assert!(matches!(Store::open(folder.path(), &identity()), Err(StoreError::Damaged { .. })), "{key}");
    }
}

/// A folder with these rows.
fn folder_of(rows: &[Row<Moments>]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path(), &identity()).unwrap();
    store.insert(rows, Some(&so_far(rows.len() as u64))).unwrap();
    folder
}

#[test]
fn stores_merge_in_any_order_and_any_number_of_times() {
    let parts = [folder_of(&[row(0, 2)]), folder_of(&[row(4, 2), row(8, 1)]), folder_of(&[row(4, 2)])];
    let mut all = Vec::new();
    for order in [[0, 1, 2], [2, 1, 0], [1, 1, 0]] {
        let folder = tempfile::tempdir().unwrap();
        let mut store = Store::open(folder.path(), &identity()).unwrap();
        for part in order {
            store.merge(&Source::open(parts[part].path()).unwrap(), false).unwrap();
        }
        assert_eq!(store.total(&address()).unwrap().count, 10);
        all.push(dumped(&store));
    }
    assert_eq!(all[0], all[1]);
    assert_eq!(all[0], all[2]);
    let again = folder_of(&[]);
    let mut store = Store::open(again.path(), &identity()).unwrap();
    let source = Source::open(parts[1].path()).unwrap();
    assert_eq!(store.merge(&source, false).unwrap(), Merged { added: 2, held: 0, damaged: 0 });
    assert_eq!(store.merge(&source, false).unwrap(), Merged { added: 0, held: 2, damaged: 0 });
}

#[test]
fn rows_go_to_another_process_as_bytes_any_number_of_times_and_damaged_ones_are_refused() {
    let bytes = |rows: &[Row<Moments>]| {
        let mut store = Store::in_memory(&identity());
        store.insert(rows, None).unwrap();
        store.to_bytes().unwrap()
    };
    let parts = [bytes(&[row(0, 2)]), bytes(&[row(4, 2), row(8, 1)]), bytes(&[])];
    let mut whole = Store::in_memory(&identity());
    for part in [0, 1, 2, 0] {
        whole.add_bytes(&parts[part]).unwrap();
    }
    assert_eq!(whole.total(&address()).unwrap().count, 10);
    let other = Identity { kernels: "gap_fill 3".to_owned(), ..identity() };
    let refused = |bytes: &[u8], identity: &Identity| Store::in_memory(identity).add_bytes(bytes).is_err();
    assert!(refused(&parts[0], &other) && !refused(&parts[0], &identity()));
    let of_one_row = &parts[0];
    for length in (0..of_one_row.len()).filter(|length| *length != parts[2].len()) {
        assert!(refused(&of_one_row[..length], &identity()), "cut to {length}");
    }
    for place in 0..of_one_row.len() {
        let mut damaged = of_one_row.clone();
        damaged[place] ^= 1;
        assert!(refused(&damaged, &identity()), "byte {place}");
    }
}

/// All rows, as text.
fn dumped(store: &Store) -> Vec<String> {
    let mut statement = connection(store).prepare(&format!("SELECT {COLUMNS} FROM tally")).unwrap();
    let rows = statement.query_map([], Raw::read).unwrap();
    rows.map(|row| format!("{:?}", row.unwrap())).collect()
}

#[test]
fn damaged_rows_are_refused_by_a_merge_and_left_out_by_a_salvage() {
    let folder = folder_of(&[row(0, 2), row(4, 2), row(8, 2)]);
    let source = Source::open(folder.path()).unwrap();
    source
        .database
        .connection
        .execute("UPDATE tally SET checksum = checksum + 1 WHERE first = 4", [])
        .unwrap();
    let out = tempfile::tempdir().unwrap();
    let mut store = Store::open(out.path(), &identity()).unwrap();
    assert!(matches!(store.merge(&source, false), Err(StoreError::DamagedRow { first: 4, .. })));
    assert_eq!(store.merge(&source, true).unwrap(), Merged { added: 2, held: 0, damaged: 1 });
    assert_eq!(store.total(&address()).unwrap().count, 8);
    let report = source.check().unwrap();
    assert_eq!((report.sound, report.points, report.faults.len()), (2, 1, 1));
}

#[test]
fn a_check_finds_rows_that_are_not_the_sum_of_those_they_cover() {
    let mut whole = row(0, 3);
    whole.tally.sum = 4;
    let parts = [row(0, 2), row(4, 1), row(6, 1)];
    // Sums are the first trials: 0 + 4 + 6.
    for (sum, faults) in [(10, 0), (4, 1)] {
        whole.tally.sum = sum;
        let folder = folder_of(&[parts.to_vec(), vec![whole.clone()]].concat());
        let report = Source::open(folder.path()).unwrap().check().unwrap();
        assert_eq!((report.sound, report.faults.len()), (4, faults));
    }
    // Only a part is covered.
    let folder = folder_of(&[parts[0].clone(), whole]);
    assert_eq!(Source::open(folder.path()).unwrap().check().unwrap().faults.len(), 0);
}

#[test]
fn a_store_in_memory_holds_the_same_as_one_on_disk() {
    let folder = tempfile::tempdir().unwrap();
    let mut stores = [Store::open(folder.path(), &identity()).unwrap(), Store::in_memory(&identity())];
    let rows = [row(0, 2), row(4, 2)];
    for store in &mut stores {
        store.insert(&rows, None).unwrap();
        store.insert(&rows[..1], None).unwrap();
        assert!(store.insert(&[Row { tally: rows[1].tally.clone(), ..rows[0].clone() }], None).is_err());
    }
    let [disk, memory] = stores;
    assert_eq!(memory.total(&rows[0].address).unwrap(), disk.total(&rows[0].address).unwrap());
    let trials = |store: &Store| store.index().unwrap().trials(&rows[0].address).unwrap();
    assert_eq!(trials(&memory), trials(&disk));
}

#[test]
fn a_database_with_a_trigger_or_a_view_is_refused_and_nothing_is_read_from_it() {
    let trigger = "CREATE TRIGGER dropped BEFORE INSERT ON tally BEGIN SELECT RAISE(IGNORE); END";
    let endless = "DROP TABLE study; CREATE VIEW study AS WITH RECURSIVE n(key, value) AS
                   (SELECT 'a', 1 UNION ALL SELECT key, value + 1 FROM n) SELECT key, value FROM n";
    for sql in [trigger, endless, "CREATE INDEX i ON tally (first)"] {
        let folder = folder_of(&[row(0, 2)]);
        Connection::open(folder.path().join(FILE)).unwrap().execute_batch(sql).unwrap();
        let is_foreign = |error: StoreError| assert!(matches!(error, StoreError::Foreign { .. }), "{error}");
        is_foreign(Store::open(folder.path(), &identity()).unwrap_err());
        is_foreign(Source::open(folder.path()).unwrap().into_store(&identity()).unwrap_err());
        let mut merged = Store::in_memory(&identity());
        for salvage in [false, true] {
            is_foreign(merged.merge(&Source::open(folder.path()).unwrap(), salvage).unwrap_err());
        }
        assert_eq!(merged.keep.keys().unwrap(), []);
    }
}

#[cfg(unix)]
#[test]
fn links_in_a_folder_are_not_written_through() {
    use std::os::unix::fs::symlink;
    let folder = folder_of(&[row(0, 2)]);
    let outside = tempfile::tempdir().unwrap();
    let victim = outside.path().join("victim");
    let path = |name: &str| folder.path().join(name);
    std::fs::write(&victim, "mine").unwrap();
    std::fs::remove_file(path(LOCK)).unwrap();
    symlink(&victim, path(LOCK)).unwrap();
    for error in [
        Source::open(folder.path()).map(drop).unwrap_err(),
        Store::open(folder.path(), &identity()).map(drop).unwrap_err(),
    ] {
        assert!(error.to_string().contains("tallies.lock is a link"), "{error}");
    }
    std::fs::remove_file(path(LOCK)).unwrap();
    std::fs::rename(path(FILE), outside.path().join(FILE)).unwrap();
    symlink(outside.path().join(FILE), path(FILE)).unwrap();
    assert!(Store::open(folder.path(), &identity()).unwrap_err().to_string().contains("is a link"));
    assert_eq!(std::fs::read_to_string(victim).unwrap(), "mine");
}
