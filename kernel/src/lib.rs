//! The kernels: integer arithmetic only, each with a twin of the same stem in `shaders/`.

pub mod allan;
pub mod gap_fill;
pub mod launch;
pub mod map;
pub mod moments;
pub mod motion;
pub mod noise;
pub mod normal;
pub mod normal_table;
pub mod parameters;
pub mod philox;
#[cfg(test)]
pub mod polynomial;
pub mod power;
pub mod recipe;
pub mod relock;
pub mod relock_ticks;
pub mod rows;
pub mod sine;
pub mod switched_run;
pub mod width;
pub mod word;

use crate::map::Map;

/// A kernel by the form of what it computes.
#[derive(Debug, Clone, Copy)]
pub enum Form {
    /// A building block: words to words.
    Map(Map),
    /// Trials of a point to moments of its estimates.
    Moments,
    /// Synthetic records to the sums of their squared differences.
    Records,
}

/// A kernel as the registry has it.
#[derive(Debug, Clone, Copy)]
pub struct Kernel {
    /// The stem of its file here and in `shaders/`.
    pub name: &'static str,
    /// How it is called and what it gives.
    pub form: Form,
}

/// Every kernel: what `verify`, the self-test of devices and the identity tests go through.
pub const KERNELS: [Kernel; 8] = [
    Kernel { name: "philox", form: Form::Map(crate::map::PHILOX) },
    Kernel { name: "normal", form: Form::Map(crate::map::NORMAL) },
    Kernel { name: "sine", form: Form::Map(crate::map::SINE) },
    Kernel { name: "power", form: Form::Map(crate::map::POWER) },
    Kernel { name: "gap_fill", form: Form::Moments },
    Kernel { name: "switched_run", form: Form::Moments },
    Kernel { name: "relock", form: Form::Moments },
    Kernel { name: "allan", form: Form::Records },
];
