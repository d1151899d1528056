//! A limit on the time in which a driver has to compile a shader.

use std::sync::OnceLock;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use crate::device::error::GpuError;

/// How long a shader may take before the user is told, and how much longer before the device is given up. Together
/// they are the time that [`GpuError::Stuck`] names.
const PATIENCE: [Duration; 2] = [Duration::from_secs(20), Duration::from_secs(280)];

static LISTENER: OnceLock<fn(&str)> = OnceLock::new();

/// Sets what receives a sentence for the user while a driver takes long. A self-test compiles shaders before any run
/// has begun, so this is not told as [`Progress`](sagnac_base::progress::Progress). Only the first call has an effect.
pub fn on_wait(listener: fn(&str)) {
    // A second listener is ignored, as documented.
    let _ = LISTENER.set(listener);
}

/// The result of a call into the driver of `name`, if it returns within the limit. `is_stuck` is for tests: the call
/// never returns, and the limit is a thousandth.
///
/// A call into a driver cannot be cancelled. A thread of its own makes it, and if the driver does not return, that thread stays
/// behind.
pub(crate) fn within_limit<T: Send + 'static>(
    name: &str,
    is_stuck: bool,
    call: impl FnOnce() -> T + Send + 'static,
) -> Result<T, GpuError> {
    let [until_told, rest] = if is_stuck { PATIENCE.map(|time| time / 1000) } else { PATIENCE };
    let (sender, receiver) = channel();
    let calling = thread::Builder::new().name("driver".to_owned()).spawn(move || {
        if is_stuck {
            loop {
                thread::park();
            }
        }
        // Nobody receives a result that comes too late.
        let _ = sender.send(call());
    });
    calling.map_err(|error| GpuError::Refused(format!("cannot start a thread: {error}")))?;
    let mut result = receiver.recv_timeout(until_told);
    if matches!(result, Err(RecvTimeoutError::Timeout)) {
        if let Some(tell) = LISTENER.get() {
            tell(&format!(
                "{name}: its driver still compiles a shader; after 5 minutes the device is given up"
            ));
        }
        result = receiver.recv_timeout(rest);
    }
    result.map_err(|error| match error {
        RecvTimeoutError::Timeout => GpuError::Stuck,
        RecvTimeoutError::Disconnected => GpuError::Refused("its driver failed".to_owned()),
    })
}
