//! The memory that a filler takes in firmware, from what the C header declares and what its use needs.

use sagnac_engine::filler::{Fill, Filler, Method};

/// Bytes of a number of ticks or weights, `int32_t`.
const WORD: u64 = 4;
/// Bytes of a filled tick and of the angle delivered over the gap, `int64_t`.
const LONG: u64 = 8;
/// Bytes of a `sagnac_rule`: four words and two pointers of 4 bytes, as on 32-bit processors.
const RULE: u64 = 24;

/// The memory of a filler, bytes.
///
/// It is that of one filler of the C header on a processor with pointers of 4 bytes. Code and the history of ticks
/// that firmware keeps anyway are not part of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Memory {
    /// Constants: the ticks and weights of both rules, and the `sagnac_filler` that points at them.
    pub constants: u64,
    /// State during a switch: the ticks `p` that each rule reads, the numbers `E` and `I` that it fills, and the sum `e`.
    pub state: u64,
}

impl Memory {
    /// The memory of a filler that reads these ticks, at a gap of `gap_ticks`.
    pub fn of_filler(filler: &Filler, fill: &Fill, gap_ticks: u32) -> Memory {
        let rows = match filler.method {
            Method::Closed(_) | Method::MinimumVariance(_) => u64::from(gap_ticks),
            // Given weights are those of the sum alone.
            Method::Weights { .. } => 1,
        };
        let rules = [Some(&fill.fit_ticks), fill.extrapolation_ticks.as_ref()];
        let counts = rules.into_iter().flatten().map(|ticks| ticks.len() as u64);
        let start = Memory { constants: 2 * RULE, state: LONG };
        counts.fold(start, |memory, ticks| Memory {
            constants: memory.constants + WORD * ticks * (1 + rows),
            state: memory.state + WORD * ticks + LONG * rows,
        })
    }

    /// All of it, bytes.
    pub fn bytes(self) -> u64 {
        self.constants + self.state
    }
}
