//! Integer Monte Carlo kernels. [`PARTS`] lists each file that has a twin in `shaders/`, [`KERNELS`] each kernel.

pub mod launch;
pub mod normal_table;
pub mod parameters;
#[cfg(test)]
mod polynomial;
pub mod recipe;
pub mod rows;
pub mod shader;
pub mod width;

/// Keeps traits to the implementations of this package, on which the absence of checks relies.
mod sealed {
    /// Implemented here only.
    pub trait Sealed {}
}

use crate::map::Map;
use crate::shader::Part;

/// The signature of a kernel: its inputs and results.
#[derive(Debug, Clone, Copy)]
pub enum Form {
    /// A building block, from words to words.
    Map(Map),
    /// From trials of a point to moments of its estimates; see [`launch::Trial`].
    Moments,
    /// From synthetic records to the exact sums of each; see [`curve::Recorded`].
    Records,
}

/// An entry of the registry.
#[derive(Debug, Clone, Copy)]
pub struct Kernel {
    /// The stem of its files here and in `shaders/`.
    pub name: &'static str,
    /// Its inputs and results.
    pub form: Form,
}

/// Declares and registers the modules that have a twin in `shaders/`; those under `kernels` have a `FORM`.
macro_rules! twins {
    (parts { $($part:ident,)* } kernels { $($kernel:ident,)* }) => {
        $(pub mod $part;)*
        $(pub mod $kernel;)*

        /// The shader files, named by their stems.
        #[allow(non_upper_case_globals)]
        pub mod part {
            $(pub static $part: crate::shader::Part = twins!(of $part);)*
            $(pub static $kernel: crate::shader::Part = twins!(of $kernel);)*
        }

        /// Every file of `shaders/`.
        pub static PARTS: &[&Part] = &[$(&part::$part,)* $(&part::$kernel,)*];

        /// Every kernel: `verify`, the self-test of devices and the identity tests iterate over this list.
        pub static KERNELS: &[Kernel] =
            &[$(Kernel { name: stringify!($kernel), form: crate::$kernel::FORM },)*];
    };
    (of $stem:ident) => {
        crate::shader::Part {
            stem: stringify!($stem),
            wgsl: include_str!(concat!("../../../shaders/", stringify!($stem), ".wgsl")),
            constants: crate::$stem::constants,
        }
    };
}

twins! {
    parts {
        word,
        map,
        moments,
        motion,
        relock_ticks,
        noise,
        record,
        curve,
    }
    kernels {
        philox,
        normal,
        sine,
        power,
        gap_fill,
        switched_run,
        relock,
        allan,
        samples,
        lock_in,
        navigation,
    }
}
