use super::*;

fn identity() -> Identity {
    Identity { kind: "gap-fill".to_owned(), seed: 1, streams: "independent".to_owned() }
}

fn address() -> Address {
    Address { point: Id::of("point"), estimate: Id::of("estimate"), digest: Id::of("digest") }
}

fn row(first: u64, log2: u32) -> Row {
    let mut tally = Moments::empty(true);
    tally.count = 1 << log2;
    tally.sum = i128::from(first);
    tally.bins[7] = tally.count;
    (tally.least, tally.greatest) = (-1, 1);
    Row { address: address(), block: Block { first, log2 }, tally }
}

#[test]
fn rows_written_are_there_after_reopening_and_written_twice_count_once() {
    let folder = tempfile::tempdir().unwrap();
    for _ in 0..2 {
        let mut store = Store::open(folder.path(), &identity()).unwrap();
        store.insert(&[row(0, 2), row(4, 2)]).unwrap();
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
    store.insert(&[row(0, 2), row(0, 3)]).unwrap();
    assert_eq!(store.total(&address()).unwrap().count, 8);
}

#[test]
fn a_disagreeing_row_is_refused_and_nothing_of_its_batch_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path(), &identity()).unwrap();
    store.insert(&[row(0, 2)]).unwrap();
    let mut other = row(0, 2);
    other.tally.sum += 1;
    assert!(matches!(store.insert(&[row(4, 2), other]), Err(StoreError::Disagrees { first: 0, .. })));
    assert_eq!(store.total(&address()).unwrap().count, 4);
}

#[test]
fn rows_from_other_parameters_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path(), &identity()).unwrap();
    store.insert(&[row(0, 2)]).unwrap();
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
    store.insert(&[row(0, 2)]).unwrap();
    store.connection.execute("UPDATE tally SET moments = x'0408000201070a'", []).unwrap();
    assert!(matches!(store.total(&address()), Err(StoreError::Damaged { .. })));
}
