//! When a device fails, and how.

use std::sync::{Arc, Mutex};

use sagnac::device::gpu::adapter::{Fault, Faults, Moment};

/// What a device is about to do, and what it has met before.
#[derive(Debug, Clone, Copy, Default)]
pub struct Seen {
    /// Of how much work; `None` where it is about to be opened again.
    pub tile: Option<u64>,
    /// Work of all tiles before.
    pub before: u64,
    /// How often it was opened again.
    pub opened: usize,
    /// Faults that have happened.
    pub taken: usize,
}

/// Whether a fault happens, and which.
pub type Script = Box<dyn FnMut(Seen) -> Option<Fault> + Send>;

pub fn scripted(script: Script) -> (Faults, Arc<Mutex<Seen>>) {
    let seen = Arc::new(Mutex::new(Seen::default()));
    let (kept, script) = (Arc::clone(&seen), Mutex::new(script));
    let faults = move |moment: Moment| {
        let tile = match moment {
            Moment::Tile(work) => Some(work),
            Moment::Opening => None,
            Moment::Pipeline | Moment::Answer => return None,
        };
        let (mut seen, mut script) = (kept.lock().unwrap(), script.lock().unwrap());
        seen.tile = tile;
        let fault = script(*seen);
        seen.taken += usize::from(fault.is_some());
        match seen.tile {
            Some(work) => seen.before += work,
            None => seen.opened += 1,
        }
        fault
    };
    (Arc::new(faults), seen)
}

/// A tile of a run.
#[derive(Debug, Clone, Copy)]
pub enum Place {
    First,
    Middle,
    Last,
}

pub const PLACES: [Place; 3] = [Place::First, Place::Middle, Place::Last];

impl Place {
    /// Whether it is the next tile of a run of so much work, before anything has failed.
    pub fn is_next(self, seen: Seen, work: u64) -> bool {
        let end = seen.before + seen.tile.unwrap_or(0);
        match self {
            Place::First => true,
            Place::Middle => end > work / 2,
            Place::Last => end >= work,
        }
    }
}
