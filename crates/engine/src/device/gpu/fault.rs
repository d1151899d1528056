//! Faults of a device: those reported by wgpu, and those injected by tests.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::device::error::GpuError;
use crate::device::gpu::Gpu;

/// Errors that wgpu has reported of a device.
#[derive(Clone, Default)]
pub(crate) struct Heard(Arc<Mutex<Told>>);

#[derive(Default)]
struct Told {
    /// First error since the last query; later ones mostly follow from it.
    complaint: Option<GpuError>,
    /// Message of a loss; a lost device stays lost.
    lost: Option<String>,
}

impl Heard {
    /// Listens to a device from now on.
    pub(crate) fn of(device: &wgpu::Device) -> Heard {
        let heard = Heard::default();
        let complaints = heard.clone();
        device.on_uncaptured_error(Arc::new(move |error| complaints.complain(&error)));
        let losses = heard.clone();
        device.set_device_lost_callback(move |reason, message| {
            let message = if message.is_empty() { format!("{reason:?}") } else { message };
            losses.told().lost.get_or_insert(message);
        });
        heard
    }

    fn told(&self) -> MutexGuard<'_, Told> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn complain(&self, error: &wgpu::Error) {
        let complaint = match error {
            wgpu::Error::OutOfMemory { .. } => GpuError::OutOfMemory,
            other => GpuError::Refused(other.to_string()),
        };
        self.told().complaint.get_or_insert(complaint);
    }

    /// A loss, or the first error since the last query.
    pub(crate) fn failure(&self) -> Result<(), GpuError> {
        let mut told = self.told();
        let complaint = told.complaint.take();
        match &told.lost {
            Some(message) => Err(GpuError::Lost(message.clone())),
            None => complaint.map_or(Ok(()), Err),
        }
    }
}

/// Moments at which a test may make a device fail.
#[doc(hidden)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Moment {
    /// Just before it is opened again.
    Opening,
    /// After a new pipeline has computed what the processor knows; any fault makes it wrong.
    Answer,
    /// Just before its driver compiles a shader.
    Pipeline,
    /// Just before it receives work of this size: steps of trials, chunks of records, or items.
    Tile(u64),
}

/// How it fails. Every fault also keeps it from being opened again.
#[doc(hidden)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    OutOfMemory,
    /// Loss before it receives the tile.
    LostBefore,
    /// Loss while it works on the tile.
    LostAfter,
    /// One wrong bit in the results.
    WrongBits,
    /// Its driver never finishes compiling a shader.
    Stuck,
}

/// The faults of a test, by moment.
#[doc(hidden)]
pub type Faults = Arc<dyn Fn(Moment) -> Option<Fault> + Send + Sync>;

/// Work submitted to a device.
pub(crate) struct Submission {
    index: wgpu::SubmissionIndex,
    /// Whether a test requests a wrong bit in its results.
    pub(crate) wrong: bool,
}

impl Gpu {
    /// Makes the device fail when `faults` says so, even after it was opened again.
    #[doc(hidden)]
    pub fn inject(&mut self, faults: Faults) {
        self.faults = Some(faults);
    }

    pub(crate) fn fault(&self, moment: Moment) -> Option<Fault> {
        self.faults.as_ref().and_then(|faults| faults(moment))
    }

    /// Submits commands of size `work` to the device, unless there is an error.
    pub(crate) fn submit(&self, encoder: wgpu::CommandEncoder, work: u64) -> Result<Submission, GpuError> {
        let commands = encoder.finish();
        let fault = self.fault(Moment::Tile(work));
        match fault {
            Some(Fault::OutOfMemory) => {
                self.heard.complain(&wgpu::Error::OutOfMemory { source: "requested by a test".into() });
            }
            Some(Fault::LostBefore) => self.device.destroy(),
            _ => {}
        }
        self.heard.failure()?;
        let index = self.queue.submit([commands]);
        if fault == Some(Fault::LostAfter) {
            self.device.destroy();
        }
        Ok(Submission { index, wrong: fault == Some(Fault::WrongBits) })
    }

    /// Waits until the device has completed a submission.
    pub(crate) fn wait(&self, submission: &Submission) -> Result<(), GpuError> {
        self.poll(Some(submission.index.clone()))
    }

    /// Waits for one submission, or for all.
    fn poll(&self, submission_index: Option<wgpu::SubmissionIndex>) -> Result<(), GpuError> {
        let wait = wgpu::PollType::Wait { submission_index, timeout: None };
        // If the driver finds a loss during this call, wgpu reports it first and then panics.
        let polled = catch_unwind(AssertUnwindSafe(|| self.device.poll(wait)));
        self.heard.failure()?;
        match polled {
            Ok(Ok(_)) => Ok(()),
            Ok(Err(error)) => Err(GpuError::Refused(error.to_string())),
            Err(_) => Err(GpuError::Lost("its driver failed".to_owned())),
        }
    }

    /// Waits for all work after a failure, so that nothing of it affects later work, and returns the cause: wgpu
    /// reports some losses only when all work is done, and before that the errors that follow from them.
    pub(crate) fn settled(&self, error: GpuError) -> GpuError {
        // A driver that is stuck may not end this wait either.
        if matches!(error, GpuError::Lost(_) | GpuError::Stuck) {
            return error;
        }
        let end = self.poll(None);
        // Other errors that follow from the failure are not errors of later work.
        let rest = self.heard.failure();
        match end.and(rest) {
            Err(lost @ GpuError::Lost(_)) => lost,
            _ => error,
        }
    }
}
