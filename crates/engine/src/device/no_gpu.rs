//! Replaces the GPU where the feature `gpu` is off, by types without values.

use core::convert::Infallible;

use crate::device::gpu::adapter::Adapter;
use crate::device::select::SelfTest;
use crate::device::{Advance, GpuError, Job, Tallies};
use sagnac_kernel::curve::Recorded;
use sagnac_kernel::map::Map;
use sagnac_kernel::shader::Variant;

pub mod adapter {
    //! No adapters.

    use core::convert::Infallible;

    use crate::device::Device;
    use crate::device::select::{SelectError, SelfTest};
    use sagnac_kernel::shader::Variant;

    /// An uninhabited type: there are no adapters.
    pub struct Adapter(Infallible);

    impl Adapter {
        /// Returns an empty list.
        pub(crate) fn all() -> Vec<Adapter> {
            vec![]
        }

        pub(crate) fn none<T>(&self) -> T {
            match self.0 {}
        }

        pub(crate) fn name(&self) -> String {
            match self.0 {}
        }

        pub(crate) fn pci_address(&self) -> String {
            match self.0 {}
        }

        pub(crate) fn is_device_of(&self, _: &Adapter) -> bool {
            match self.0 {}
        }

        pub(crate) fn is_software(&self) -> bool {
            match self.0 {}
        }

        pub(crate) fn is_discrete(&self) -> bool {
            match self.0 {}
        }

        pub(crate) fn variant(&self) -> Variant {
            match self.0 {}
        }
    }

    pub(crate) fn open(adapter: &Adapter, _: usize, _: SelfTest) -> Result<Device, SelectError> {
        adapter.none()
    }

    /// Returns nothing: no card could be used.
    pub fn unused_card(_: &[Adapter]) -> Option<String> {
        None
    }
}

/// An uninhabited type: there is no GPU.
pub struct Gpu {
    pub(crate) threads: usize,
    pub(crate) losses: u32,
    pub(crate) self_test: Option<SelfTest>,
    never: Infallible,
}

impl Gpu {
    pub(crate) fn open(adapter: &Adapter, _: Variant) -> Result<Gpu, GpuError> {
        adapter.none()
    }

    pub(crate) fn opened_again(&self) -> Result<Gpu, GpuError> {
        match self.never {}
    }

    pub(crate) fn with_self_test(self, _: SelfTest) -> Gpu {
        self
    }

    pub(crate) fn begin(&mut self) {
        match self.never {}
    }

    pub(crate) fn distrust(&self) {
        match self.never {}
    }

    pub(crate) fn name(&self) -> &str {
        match self.never {}
    }

    pub(crate) fn records_at_once(&self) -> u64 {
        match self.never {}
    }

    pub(crate) fn first_batch(&self) -> u64 {
        match self.never {}
    }

    pub(crate) fn halve_tiles(&mut self) -> bool {
        match self.never {}
    }

    pub(crate) fn halve_batches(&mut self) -> bool {
        match self.never {}
    }

    pub(crate) fn tally(&mut self, _: &[Job], _: bool, _: Advance) -> Result<Tallies, GpuError> {
        match self.never {}
    }

    pub(crate) fn sums(
        &mut self,
        _: &dyn Recorded,
        _: u64,
        _: usize,
        _: Advance,
    ) -> Result<Vec<u128>, GpuError> {
        match self.never {}
    }

    pub(crate) fn map(&mut self, _: &Map, _: &[u32]) -> Result<Vec<u32>, GpuError> {
        match self.never {}
    }
}
