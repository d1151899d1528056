//! What goes wrong with a device: what is heard of it, and what a test lets happen.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::device::error::GpuError;
use crate::device::gpu::Gpu;

/// What wgpu has told of a device.
#[derive(Clone, Default)]
pub(crate) struct Heard(Arc<Mutex<Told>>);

#[derive(Default)]
struct Told {
    /// The first complaint since it was last asked: those after it mostly follow from it.
    complaint: Option<GpuError>,
    /// A lost device stays lost.
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

    /// A loss, or what was complained of since this was last asked.
    pub(crate) fn failure(&self) -> Result<(), GpuError> {
        let mut told = self.told();
        let complaint = told.complaint.take();
        match &told.lost {
            Some(message) => Err(GpuError::Lost(message.clone())),
            None => complaint.map_or(Ok(()), Err),
        }
    }
}

/// When a test may let a device fail.
#[doc(hidden)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Moment {
    /// It is about to be opened again.
    Opening,
    /// So much is about to be handed to it: steps of trials, chunks of records, or items.
    Tile(u64),
}

/// How it fails then. Any of them keeps it from being opened again.
#[doc(hidden)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    OutOfMemory,
    /// Before it gets the tile.
    LostBefore,
    /// While it has the tile.
    LostAfter,
    /// One bit of the results is another.
    WrongBits,
}

/// Which fault happens when.
#[doc(hidden)]
pub type Faults = Arc<dyn Fn(Moment) -> Option<Fault> + Send + Sync>;

/// Work that a device has.
pub(crate) struct Submission {
    index: wgpu::SubmissionIndex,
    /// Whether a test wants a bit of its results changed.
    pub(crate) wrong: bool,
}

impl Gpu {
    /// Lets the device fail when `faults` says so, also after it was opened again.
    #[doc(hidden)]
    pub fn inject(&mut self, faults: Faults) {
        self.faults = Some(faults);
    }

    pub(crate) fn fault(&self, moment: Moment) -> Option<Fault> {
        self.faults.as_ref().and_then(|faults| faults(moment))
    }

    /// Hands commands to the device, so much work, unless something of them failed.
    pub(crate) fn submit(&self, encoder: wgpu::CommandEncoder, work: u64) -> Result<Submission, GpuError> {
        let commands = encoder.finish();
        let fault = self.fault(Moment::Tile(work));
        match fault {
            Some(Fault::OutOfMemory) => {
                self.heard.complain(&wgpu::Error::OutOfMemory { source: "as a test wants it".into() });
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

    /// Waits until the device has done some work.
    pub(crate) fn wait(&self, submission: &Submission) -> Result<(), GpuError> {
        self.poll(Some(submission.index.clone()))
    }

    /// Waits for one submission, or for all.
    fn poll(&self, submission_index: Option<wgpu::SubmissionIndex>) -> Result<(), GpuError> {
        let wait = wgpu::PollType::Wait { submission_index, timeout: None };
        // wgpu tells of a loss first and then panics where the driver finds it out in here.
        let polled = catch_unwind(AssertUnwindSafe(|| self.device.poll(wait)));
        self.heard.failure()?;
        match polled {
            Ok(Ok(_)) => Ok(()),
            Ok(Err(error)) => Err(GpuError::Refused(error.to_string())),
            Err(_) => Err(GpuError::Lost("its driver failed".to_owned())),
        }
    }

    /// Ends what a failure has left behind, so that nothing of it reaches the next work, and says what it was: wgpu tells of
    /// some losses only when all is done, and before that complains of what follows from them.
    pub(crate) fn settled(&self, error: GpuError) -> GpuError {
        if matches!(error, GpuError::Lost(_)) {
            return error;
        }
        let end = self.poll(None);
        // What came of the failure besides is no failure of the next work.
        let rest = self.heard.failure();
        match end.and(rest) {
            Err(lost @ GpuError::Lost(_)) => lost,
            _ => error,
        }
    }
}
