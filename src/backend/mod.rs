//! Where the kernels run: the processor or a GPU, with the same bits.

pub mod cpu;
pub mod gpu;

use crate::block::Block;
use crate::kernel::gap_fill::Launch;

/// Trials to be tallied: a block of a launch.
#[derive(Debug, Clone, Copy)]
pub struct Job<'a> {
    pub launch: &'a Launch,
    pub block: Block,
}
