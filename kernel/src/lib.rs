//! Integer Monte Carlo kernels. Each file that has a twin in `shaders/` is a row of [`PARTS`], each kernel one of [`KERNELS`].

pub mod launch;
pub mod normal_table;
pub mod parameters;
#[cfg(test)]
mod polynomial;
pub mod recipe;
pub mod rows;
pub mod shader;
pub mod width;

use crate::map::Map;
use crate::shader::Part;

/// How a kernel is called and what it gives.
#[derive(Debug, Clone, Copy)]
pub enum Form {
    /// A building block: words to words.
    Map(Map),
    /// Trials of a point to moments of its estimates: see [`launch::Trial`].
    Moments,
    /// Synthetic records to the sums of their squared differences: see [`recipe::Recipe`].
    Records,
}

/// A row of the registry.
#[derive(Debug, Clone, Copy)]
pub struct Kernel {
    /// The stem of its file here and in `shaders/`.
    pub name: &'static str,
    /// How it is called and what it gives.
    pub form: Form,
}

/// Declares the modules that have a twin in `shaders/` and registers them; those under `kernels` have a `FORM`.
macro_rules! twins {
    (parts { $($part:ident,)* } kernels { $($kernel:ident,)* }) => {
        $(pub mod $part;)*
        $(pub mod $kernel;)*

        /// The shader files by their stems.
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
            wgsl: include_str!(concat!("../../shaders/", stringify!($stem), ".wgsl")),
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
    }
}
