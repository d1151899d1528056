//! Errors of devices.

/// Why a device cannot be used, or no longer.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum GpuError {
    /// The device cannot be opened, with the message of the driver.
    #[error("cannot open the device: {0}")]
    Open(String),
    /// The device is gone, as after a watchdog or an unplugged adapter, with the message of the driver. Earlier tallies
    /// are intact.
    #[error("the device was lost: {0}")]
    Lost(String),
    /// The driver does not return from compiling a shader. The thread that waits for it is left behind.
    #[error("its driver did not compile a shader within 5 minutes")]
    Stuck,
    /// The device has too little memory for the work at hand.
    #[error("the device is out of memory")]
    OutOfMemory,
    /// The device rejects a shader or a buffer, with the message of the validation.
    #[error("the device refused the work: {0}")]
    Refused(String),
    /// The device computes other bits than the CPU on the first work of a shader.
    #[error("it computes other bits than the CPU: update its driver")]
    WrongBits,
    /// A record does not fit into the buffers; the CPU can make it.
    #[error(
        "a record needs {bytes} bytes on the device, of {most}: shorten the longest averaging time, or overlap = \"m/64\""
    )]
    TooLong {
        /// Bytes that its angles need.
        bytes: u64,
        /// Bytes that the device offers for them.
        most: u64,
    },
}
