//! Why a device cannot be used.

/// Why a device cannot be used, or can no longer.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum GpuError {
    /// It cannot be opened: what the driver says.
    #[error("cannot open the device: {0}")]
    Open(String),
    /// It is gone, as after a watchdog or an unplugged adapter: what the driver says. What was tallied before is whole.
    #[error("the device was lost: {0}")]
    Lost(String),
    /// It has not the memory for the work at hand.
    #[error("the device is out of memory")]
    OutOfMemory,
    /// It does not take a shader or a buffer: what its validation says.
    #[error("the device refused the work: {0}")]
    Refused(String),
    /// A record does not fit into the buffers; the CPU takes such.
    #[error(
        "a record needs {bytes} bytes on the device, of {most}: shorten the longest averaging time, or overlap = \"m/64\""
    )]
    TooLong {
        /// What its angles need.
        bytes: u64,
        /// What a device gives them.
        most: u64,
    },
}
