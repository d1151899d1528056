//! Progress of planning on the standard error stream, which is shown where it takes more than two seconds.

use std::sync::Mutex;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use sagnac::progress::Progress;
use sagnac::quantity::number::short;

use crate::progress::{How, LINE, leave, left, show};
use crate::run::stop::Stop;

/// Time without a word.
const SHORT: Duration = Duration::from_secs(2);

/// Displays how many points of a study are planned: a line that is updated on a terminal, else a line at intervals.
pub struct Planning {
    how: How,
    /// Counts, and measures the rate, even if it is not drawn.
    bar: ProgressBar,
    /// Time of the next line.
    next: Mutex<Instant>,
    stop: Option<Stop>,
}

impl Planning {
    /// Progress of the kind that suits the standard error stream.
    pub fn new(how: How, stop: Option<&Stop>) -> Planning {
        Planning {
            how: how.suited(),
            bar: ProgressBar::hidden(),
            next: Mutex::new(Instant::now() + SHORT),
            stop: stop.cloned(),
        }
    }

    /// The number of planned points, and that of all.
    pub fn reached(&self) -> (u64, u64) {
        (self.bar.position(), self.bar.length().unwrap_or(0))
    }

    fn line(&self) -> String {
        let [done, all] = [self.reached().0, self.reached().1].map(|points| short(points as f64));
        let left = left(self.bar.eta()).map_or_else(String::new, |left| format!(", {left}"));
        format!("planning {done} of {all} points{left}")
    }
}

impl Drop for Planning {
    fn drop(&mut self) {
        if self.how == How::Bar {
            leave();
        }
    }
}

impl Progress for Planning {
    fn start(&self, _: &'static str, done: u64, total: u64) {
        self.bar.reset();
        self.bar.set_length(total);
        self.bar.set_position(done);
    }

    fn advance(&self, more: u64) {
        self.bar.inc(more);
        // If another thread is printing, there is nothing to add.
        let Some(mut next) = self.next.try_lock().ok() else { return };
        if Instant::now() < *next {
            return;
        }
        match self.how {
            How::Bar => {
                *next = Instant::now() + Duration::from_millis(100);
                if self.bar.is_hidden()
                    && let Ok(style) = ProgressStyle::with_template("{msg}")
                {
                    self.bar.set_style(style);
                    self.bar.set_draw_target(ProgressDrawTarget::stderr_with_hz(10));
                    show(&self.bar);
                }
                self.bar.set_message(self.line());
            }
            How::Plain => {
                *next = Instant::now() + LINE;
                say!("{}", self.line());
            }
            How::Auto | How::None => *next = Instant::now() + LINE,
        }
    }

    fn stops(&self) -> bool {
        self.stop.as_ref().is_some_and(|stop| stop.cause().is_some())
    }
}
