use super::*;

fn identity() -> Identity {
    Identity { kind: "gap-fill".to_owned(), seed: 1, streams: "independent".to_owned() }
}

fn address() -> Address {
    Address { point: Id::of("point"), estimate: Id::of("estimate"), digest: Id::of("digest") }
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
        store.insert(&[row(0, 2), row(4, 2)], &so_far(8)).unwrap();
        let total = store.total(&address()).unwrap();
        assert_eq!((total.count, total.sum), (8, 4));
    }
    let store = Store::open(folder.path(), &identity()).unwrap();
    assert_eq!(store.blocks(&address()).unwrap().len(), 2);
    assert_eq!(store.points().unwrap(), [address().point]);
}

#[test]
fn a_larger_block_counts_in_place_of_its_parts() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path(), &identity()).unwrap();
    store.insert(&[row(0, 2), row(0, 3)], &so_far(8)).unwrap();
    assert_eq!(store.total(&address()).unwrap().count, 8);
}

#[test]
fn a_disagreeing_row_is_refused_and_nothing_of_its_batch_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path(), &identity()).unwrap();
    store.insert(&[row(0, 2)], &so_far(8)).unwrap();
    let mut other = row(0, 2);
    other.tally.sum += 1;
    assert!(matches!(
        store.insert(&[row(4, 2), other], &so_far(8)),
        Err(StoreError::Disagrees { first: 0, .. })
    ));
    assert_eq!(store.total(&address()).unwrap().count, 4);
}

#[test]
fn rows_from_other_parameters_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path(), &identity()).unwrap();
    store.insert(&[row(0, 2)], &so_far(8)).unwrap();
    let changed = Address { digest: Id::of("another kernel"), ..address() };
    assert!(matches!(store.blocks(&changed), Err(StoreError::Disagrees { .. })));
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
    store.insert(&[row(0, 2)], &so_far(8)).unwrap();
    store.connection.execute("UPDATE tally SET sums = x'0408000201070a'", []).unwrap();
    assert!(matches!(store.total(&address()), Err(StoreError::Damaged { .. })));
}

/// A database as a program may leave it, before this one opens it.
fn prepared(sql: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let connection = Connection::open(folder.path().join(FILE)).unwrap();
    connection.execute_batch("CREATE TABLE study (key TEXT PRIMARY KEY, value TEXT NOT NULL)").unwrap();
    connection.execute_batch(sql).unwrap();
    folder
}

#[test]
fn a_claim_that_fails_half_way_leaves_nothing_behind() {
    let failing = "CREATE TRIGGER failing BEFORE INSERT ON study WHEN NEW.key = 'streams'
                   BEGIN SELECT RAISE(ABORT, 'full'); END";
    let folder = prepared(failing);
    assert!(matches!(Store::open(folder.path(), &identity()), Err(StoreError::Storage { .. })));
    let connection = Connection::open(folder.path().join(FILE)).unwrap();
    let count = |sql| connection.query_row(sql, [], |row| row.get::<_, i64>(0)).unwrap();
    assert_eq!(count("SELECT COUNT(*) FROM study"), 0);
    assert_eq!(count("SELECT COUNT(*) FROM sqlite_master WHERE name = 'tally'"), 0);
    connection.execute_batch("DROP TRIGGER failing").unwrap();
    drop(connection);
    Store::open(folder.path(), &identity()).unwrap();
}

#[test]
fn a_folder_whose_claim_was_interrupted_is_claimed_anew() {
    for sql in ["", "INSERT INTO study VALUES ('schema', '2')"] {
        let folder = prepared(sql);
        for _ in 0..2 {
            Store::open(folder.path(), &identity()).unwrap_or_else(|error| panic!("{sql}: {error}"));
        }
        let other = Identity { seed: 2, ..identity() };
        assert!(matches!(Store::open(folder.path(), &other), Err(StoreError::OtherStudy { .. })), "{sql}");
    }
}

#[test]
fn each_session_has_one_row_of_provenance_from_its_first_batch_on() {
    let folder = tempfile::tempdir().unwrap();
    for _ in 0..2 {
        let mut store = Store::open(folder.path(), &identity()).unwrap();
        store.insert(&[row(0, 2)], &so_far(4)).unwrap();
        store.insert(&[row(4, 2)], &so_far(8)).unwrap();
    }
    let connection = Connection::open(folder.path().join(FILE)).unwrap();
    let mut statement = connection.prepare("SELECT device, trials FROM provenance").unwrap();
    let rows = statement.query_map([], |row| Ok((row.get(0)?, row.get(1)?))).unwrap();
    let rows: Vec<(String, i64)> = rows.map(Result::unwrap).collect();
    assert_eq!(rows, [("abacus".to_owned(), 8), ("abacus".to_owned(), 8)]);
}
