//! Values that take long to compute and are needed again with the same arguments, as at the points of a sweep.

use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The last few values of a function, with the arguments that give them. Those not used for longest are dropped first.
///
/// Threads that need the same value at the same time may each compute it. Values are never changed, so a value from
/// here has the bits that the function would return.
#[derive(Debug)]
pub struct Memo<K, V> {
    most: usize,
    known: Mutex<VecDeque<(K, V)>>,
}

impl<K: PartialEq, V: Clone> Memo<K, V> {
    /// Keeps at most `most` values.
    pub const fn new(most: usize) -> Memo<K, V> {
        Memo { most, known: Mutex::new(VecDeque::new()) }
    }

    /// The value at `key`, which is computed if it is not known. It takes time in proportion to the number of values.
    pub fn get(&self, key: K, compute: impl FnOnce() -> V) -> V {
        if let Some(value) = find(&mut self.known(), &key) {
            return value;
        }
        let value = compute();
        let mut known = self.known();
        if find(&mut known, &key).is_none() {
            if known.len() >= self.most {
                known.pop_front();
            }
            known.push_back((key, value.clone()));
        }
        value
    }

    fn known(&self) -> MutexGuard<'_, VecDeque<(K, V)>> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The value at `key`, which becomes the last one used.
fn find<K: PartialEq, V: Clone>(known: &mut VecDeque<(K, V)>, key: &K) -> Option<V> {
    let place = known.iter().rposition(|(own, _)| own == key)?;
    let found = known.remove(place)?;
    let value = found.1.clone();
    known.push_back(found);
    Some(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_is_computed_once_until_others_displace_it() {
        let memo = Memo::new(2);
        let mut computed = Vec::new();
        for key in [1, 2, 1, 3, 1, 2] {
            let value = memo.get(key, || {
                computed.push(key);
                10 * key
            });
            assert_eq!(value, 10 * key);
        }
        // 2 was used least recently when 3 came.
        assert_eq!(computed, [1, 2, 3, 2]);
    }
}
