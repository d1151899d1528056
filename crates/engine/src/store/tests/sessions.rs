//! Sessions and their provenance.

use super::*;

#[test]
fn a_session_that_went_on_counts_once() {
    let folder = folder_of(&[row(0, 2)]);
    let out = tempfile::tempdir().unwrap();
    let mut store = Store::open(out.path(), &identity()).unwrap();
    for trials in [8, 4] {
        let source = Source::open(folder.path()).unwrap();
        // As versions without checksums leave it.
        source.database.execute_batch("DELETE FROM study WHERE key LIKE 'session %'").unwrap();
        source.database.connection.execute("UPDATE provenance SET trials = ?1", [trials]).unwrap();
        store.merge(&source, false).unwrap();
    }
    let noted = connection(&store).query_row("SELECT COUNT(*), SUM(trials) FROM provenance", [], |row| {
        Ok((row.get::<_, i64>(0)?, row.get::<_, i64>(1)?))
    });
    assert_eq!(noted.unwrap(), (1, 8));
}

#[test]
fn a_salvage_keeps_the_sessions_before_one_that_cannot_be_read() {
    let folder = folder_of(&[row(0, 2)]);
    let source = Source::open(folder.path()).unwrap();
    // Its key is above every other, so it is read last.
    let sql = "INSERT INTO provenance VALUES (?1, 0, '', '', 'many', 0)";
    source.database.connection.execute(sql, [[0xff_u8; 17]]).unwrap();
    let out = tempfile::tempdir().unwrap();
    let mut store = Store::open(out.path(), &identity()).unwrap();
    assert!(matches!(store.merge(&source, false), Err(StoreError::Damaged { .. })));
    let out = tempfile::tempdir().unwrap();
    let mut store = Store::open(out.path(), &identity()).unwrap();
    assert_eq!(store.merge(&source, true).unwrap(), Merged { added: 1, held: 0, damaged: 0 });
    assert_eq!(store.provenance().unwrap(), [so_far(1)]);
}

#[test]
fn each_session_has_one_row_of_provenance_from_its_first_batch_on() {
    let folder = tempfile::tempdir().unwrap();
    for _ in 0..2 {
        let mut store = Store::open(folder.path(), &identity()).unwrap();
        store.insert(&[row(0, 2)], Some(&so_far(4))).unwrap();
        store.insert(&[row(4, 2)], Some(&so_far(8))).unwrap();
    }
    let connection = Connection::open(folder.path().join(FILE)).unwrap();
    let mut statement = connection.prepare("SELECT device, trials FROM provenance").unwrap();
    let rows = statement.query_map([], |row| Ok((row.get(0)?, row.get(1)?))).unwrap();
    let rows: Vec<(String, i64)> = rows.map(Result::unwrap).collect();
    assert_eq!(rows, [("abacus".to_owned(), 8), ("abacus".to_owned(), 8)]);
}

#[test]
fn an_altered_session_is_found_by_its_checksum_and_left_out_by_salvage() {
    let changes = [
        "UPDATE provenance SET trials = trials + 1",
        "UPDATE provenance SET device = 'GPU'",
        "UPDATE provenance SET session = x'00'",
        "DELETE FROM provenance",
    ];
    for sql in changes {
        let folder = folder_of(&[row(0, 2)]);
        Connection::open(folder.path().join(FILE)).unwrap().execute_batch(sql).unwrap();
        let is_damaged =
            |error: StoreError| assert!(matches!(error, StoreError::Damaged { .. }), "{sql}: {error}");
        is_damaged(Store::open(folder.path(), &identity()).unwrap_err());
        is_damaged(Source::open(folder.path()).unwrap().into_store(&identity()).unwrap_err());
        let out = tempfile::tempdir().unwrap();
        let mut merged = Store::open(out.path(), &identity()).unwrap();
        is_damaged(merged.merge(&Source::open(folder.path()).unwrap(), false).unwrap_err());
        assert_eq!(merged.keep.keys().unwrap(), [], "{sql}: rows were taken over before all was checked");
        let taken = merged.merge(&Source::open(folder.path()).unwrap(), true).unwrap();
        // A session under another key looks like one of an earlier version.
        let left = if sql.contains("SET session") { vec![so_far(1)] } else { vec![] };
        assert_eq!((taken.added, merged.provenance().unwrap()), (1, left), "{sql}");
        drop(merged);
        Store::open(out.path(), &identity()).unwrap();
    }
}

#[test]
fn sessions_without_checksums_are_believed_and_their_sums_do_not_overflow() {
    let folder = folder_of(&[row(0, 2)]);
    let connection = Connection::open(folder.path().join(FILE)).unwrap();
    let most = i64::MAX;
    let sessions = format!(
        "INSERT INTO provenance VALUES (x'01', 0, 'sagnac 0.1.0', 'CPU', {most}, 1.0), (x'02', 0, 'sagnac 0.1.0', 'CPU', {most}, 1.0),
         (x'03', 0, 'sagnac 0.1.0', 'CPU', {most}, 1.0)"
    );
    connection.execute_batch(&sessions).unwrap();
    drop(connection);
    let out = tempfile::tempdir().unwrap();
    let mut merged = Store::open(out.path(), &identity()).unwrap();
    merged.merge(&Source::open(folder.path()).unwrap(), false).unwrap();
    drop(merged);
    let merged = Store::open(out.path(), &identity()).unwrap();
    assert_eq!(Provenance::trials_of(&merged.provenance().unwrap()), u64::MAX);
}
