//! Angles of records that a device makes block by block, while those of earlier blocks are read.

use std::fmt;
use std::sync::mpsc::sync_channel;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::thread;

use crate::device::{Device, GpuError};
use sagnac_kernel::recipe::{CHUNK, Recipe};
use sagnac_kernel::samples::{ANGLE, MARKOV, Markov, RESIDUALS, Segments, Sums, WALK};

/// Chunks of a segment, which an invocation makes: enough that its start costs little.
const CHUNKS: u32 = 4;

/// Segments of a block, of 2^20 samples.
const SEGMENTS: u32 = 1 << 12;

/// A device that the readers of several records share.
#[derive(Clone)]
pub struct SharedDevice {
    device: Arc<Mutex<Device>>,
    failure: Arc<OnceLock<GpuError>>,
    /// Chunks of a segment, and segments of a block.
    sizes: [u32; 2],
}

impl fmt::Debug for SharedDevice {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.debug_struct("SharedDevice").finish_non_exhaustive()
    }
}

impl SharedDevice {
    /// Shares a device.
    pub fn new(device: Device) -> SharedDevice {
        SharedDevice {
            device: Arc::new(Mutex::new(device)),
            failure: Arc::default(),
            sizes: [CHUNKS, SEGMENTS],
        }
    }

    /// Makes blocks of so many segments with so many chunks of 64 samples, which changes no angle.
    #[must_use]
    pub fn in_blocks(self, chunks: u32, segments: u32) -> SharedDevice {
        SharedDevice { sizes: [chunks, segments], ..self }
    }

    /// Why the device has failed, if it has.
    pub fn failure(&self) -> Option<&GpuError> {
        self.failure.get()
    }

    /// The angles of the record `number` at its N + 1 samples, LSB modulo 2^32, before drift is added and whole pulses are
    /// read: those of `recipe.unread().angles(number)`. They end early where the device [fails](SharedDevice::failure).
    pub fn angles(&self, recipe: &Recipe, number: u64) -> impl Iterator<Item = u32> + use<> {
        let (send, blocks) = sync_channel(1);
        let shared = self.clone();
        let mut made = Made::new(recipe, number);
        let make = move || {
            while made.chunk < made.chunks {
                match made.block(&shared).map(|block| send.send(block)) {
                    Ok(Ok(())) => {}
                    // The reader has enough.
                    Ok(Err(_)) => return,
                    Err(error) => return drop(shared.failure.set(error)),
                }
            }
        };
        if let Err(error) = thread::Builder::new().spawn(make) {
            let _ = self.failure.set(GpuError::Open(error.to_string()));
        }
        blocks.into_iter().flatten().take(recipe.samples as usize + 1)
    }
}

/// A record that is made up to some chunk.
struct Made {
    recipe: Recipe,
    number: u64,
    /// The next chunk, and the number of all.
    chunk: u32,
    chunks: u32,
    /// The sums before it, except Markov noise.
    sums: Sums,
    markov: Option<Markov>,
}

impl Made {
    fn new(recipe: &Recipe, number: u64) -> Made {
        let recipe = recipe.unread();
        let chunks = recipe.samples / CHUNK as u32 + 1;
        Made { markov: Markov::new(&recipe, number), recipe, number, chunk: 0, chunks, sums: [0; 4] }
    }

    /// The angles of the next block, which may go on beyond the record.
    fn block(&mut self, shared: &SharedDevice) -> Result<Vec<u32>, GpuError> {
        let [chunks, segments] = shared.sizes;
        let count = (self.chunks - self.chunk).div_ceil(chunks).min(segments);
        let mut starts = vec![[0; 4]; count as usize];
        if let Some(markov) = &mut self.markov {
            starts.iter_mut().for_each(|start| start[MARKOV] = markov.next(chunks));
        }
        let make = |starts: &[Sums], has_angles| {
            let segments = Segments::new(&self.recipe, self.number, self.chunk, chunks, starts, has_angles);
            let mut device = shared.device.lock().unwrap_or_else(PoisonError::into_inner);
            let values = device.sums(&segments, 0, starts.len(), &|_| ())?;
            Ok::<_, GpuError>((segments, values))
        };
        let has_others = self.recipe.walk > 0 || self.recipe.switching.is_some();
        let passes: &[&[usize]] = if has_others { &[&[WALK, RESIDUALS], &[ANGLE]] } else { &[&[ANGLE]] };
        for &parts in passes {
            let (segments, values) = make(&starts, false)?;
            for (start, end) in starts.iter_mut().zip(segments.ends(&values)) {
                for &part in parts {
                    start[part] = self.sums[part];
                    self.sums[part] = self.sums[part].wrapping_add(end[part]);
                }
            }
        }
        let (segments, values) = make(&starts, true)?;
        self.chunk += count * chunks;
        Ok(segments.words(&values).collect())
    }
}
