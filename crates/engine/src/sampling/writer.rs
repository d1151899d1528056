//! Storage of a batch while the device works on the next.

use std::panic::resume_unwind;
use std::sync::mpsc::sync_channel;
use std::thread;

use crate::sampling::plan::RunError;
use crate::store::{Provenance, Row, Store, Tally};

/// Stores the rows of a batch after those of the batch before. Returns whether to go on: not after rows could not be stored.
pub(crate) type Storing<'a, T> = &'a mut dyn FnMut(Vec<Row<T>>, Provenance) -> bool;

/// Runs `sample`, whose rows are stored on a thread of their own, and returns when all are stored.
///
/// # Errors
/// Rows cannot be stored, or `sample` fails; all rows that it handed over before are stored.
pub(crate) fn while_storing<T: Tally + Send, R>(
    store: &mut Store,
    sample: impl FnOnce(Storing<T>) -> Result<R, RunError>,
) -> Result<R, RunError> {
    let mut insert = |(rows, so_far): (Vec<Row<T>>, Provenance)| store.insert(&rows, Some(&so_far));
    if cfg!(target_family = "wasm") {
        // A page has no threads.
        let mut stored = Ok(());
        let sampled = sample(&mut |rows, so_far| {
            stored = insert((rows, so_far));
            stored.is_ok()
        });
        return stored.map_err(RunError::from).and(sampled);
    }
    thread::scope(|scope| {
        // A channel without room: a batch waits while the one before is stored, and no third one is begun.
        let (sender, receiver) = sync_channel(0);
        let stored = scope.spawn(move || receiver.into_iter().try_for_each(insert));
        let sampled = sample(&mut |rows, so_far| sender.send((rows, so_far)).is_ok());
        drop(sender);
        stored.join().unwrap_or_else(|panic| resume_unwind(panic))?;
        sampled
    })
}
