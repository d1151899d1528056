//! Progress on the standard error stream: a bar on a terminal, else a line at intervals.

use std::io::IsTerminal;
use std::sync::{Mutex, OnceLock};
use std::time::{Duration, Instant};

use crate::look;
use crate::run::Stop;
use clap::{Args, ValueEnum};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use sagnac::progress::Progress;
use sagnac_base::quantity::number::short;

/// Interval between lines where there is no terminal.
pub const LINE: Duration = Duration::from_secs(10);

// As a group it would have the name of the options around it, which debug builds refuse.
#[derive(Debug, Args)]
#[group(skip)]
pub struct Options {
    /// Progress on standard error: auto (a bar on a terminal, else lines), bar, plain (a line every 10 s) or none
    #[arg(
        help_heading = "Output",
        long,
        value_enum,
        value_name = "HOW",
        default_value = "auto",
        hide_possible_values = true
    )]
    progress: How,
}

impl Options {
    /// The kind of progress for someone who wants only errors, or more.
    pub fn how(&self, quiet: bool) -> How {
        match self.progress {
            How::Auto if quiet => How::None,
            asked => asked,
        }
    }
}

/// The requested kind of progress.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum How {
    Auto,
    Bar,
    Plain,
    None,
}

impl How {
    /// The kind that is shown where there may be no terminal.
    pub fn suited(self) -> How {
        let bare =
            !std::io::stderr().is_terminal() || std::env::var_os("TERM").is_some_and(|term| term == "dumb");
        match self {
            How::Auto | How::Bar if bare => How::Plain,
            How::Auto => How::Bar,
            asked => asked,
        }
    }
}

/// The bar on the terminal.
static ON_TERMINAL: Mutex<Option<ProgressBar>> = Mutex::new(None);

/// Prints something while the bar is hidden.
pub fn aside(print: impl FnOnce()) {
    let bar = ON_TERMINAL.lock().ok().and_then(|bar| bar.clone());
    match bar {
        Some(bar) => bar.suspend(print),
        None => print(),
    }
}

/// Removes the bar from the terminal for good.
pub fn leave() {
    let bar = ON_TERMINAL.lock().ok().and_then(|mut bar| bar.take());
    if let Some(bar) = bar {
        bar.finish_and_clear();
    }
}

/// From this number of columns on, a bar of 30 leaves room for all information; else the bar takes the rest, without a
/// rate.
const ROOMY: usize = 108;

/// Displays progress. A bar stays until it is cleared or dropped, because tables and charts follow the sampling.
pub struct Shown {
    how: How,
    /// Counts, and measures the rate, even if it is not drawn.
    bar: ProgressBar,
    /// The unit of the first phase.
    unit: OnceLock<&'static str>,
    /// Set as soon as the amount done at the beginning was said.
    begins: OnceLock<()>,
    /// Time of the next line.
    next: Mutex<Instant>,
    stop: Option<Stop>,
    /// Whether no line says at the start how much there is to do.
    is_terse: bool,
}

impl Shown {
    /// Progress of the requested kind. Without a terminal, lines replace the bar, because control characters are not
    /// text.
    pub fn new(how: How) -> Shown {
        let how = how.suited();
        let bar = match how {
            How::Bar => drawn(),
            _ => ProgressBar::hidden(),
        };
        Shown {
            how,
            bar,
            unit: OnceLock::new(),
            begins: OnceLock::new(),
            next: Mutex::new(Instant::now() + LINE),
            stop: None,
            is_terse: false,
        }
    }

    /// Progress without a line at the start, for work that is mostly done at once.
    pub fn terse(mut self) -> Shown {
        self.is_terse = true;
        self
    }

    /// Progress that also asks the run to stop as soon as there is a cause.
    pub fn until(mut self, stop: &Stop) -> Shown {
        self.stop = Some(stop.clone());
        self
    }

    /// Progress of the first phase: the amount done, the total and their unit.
    pub fn reached(&self) -> (u64, u64, &'static str) {
        (self.bar.position(), self.bar.length().unwrap_or(0), self.unit.get().unwrap_or(&"trials"))
    }

    /// Makes room for other output.
    pub fn clear(&self) {
        if self.how == How::Bar {
            leave();
        }
    }
}

impl Drop for Shown {
    fn drop(&mut self) {
        self.clear();
    }
}

/// A bar on the terminal.
fn drawn() -> ProgressBar {
    type Out<'a> = &'a mut dyn std::fmt::Write;
    let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr_with_hz(10));
    let template = match look::error_columns() >= ROOMY {
        true => "{bar:30} {percent:>3} %  {done} {msg}  {rate}  {left}",
        false => "{wide_bar} {percent:>3} %  {done} {msg}  {left}",
    };
    if let Ok(style) = ProgressStyle::with_template(template) {
        let done = |state: &ProgressState, to: Out| {
            let [done, all] = [state.pos(), state.len().unwrap_or(0)].map(|units| short(units as f64));
            let _ = write!(to, "{done} of {all}");
        };
        // When all is done, the rate would only fall.
        let goes_on = |state: &ProgressState| state.len().is_some_and(|len| state.pos() < len);
        let rate = move |state: &ProgressState, to: Out| {
            let _ = if goes_on(state) { write!(to, "{}/s", short(state.per_sec())) } else { Ok(()) };
        };
        let left = |state: &ProgressState, to: Out| {
            let _ = left(state.eta()).map_or(Ok(()), |left| write!(to, "{left}"));
        };
        bar.set_style(style.with_key("done", done).with_key("rate", rate).with_key("left", left));
    }
    show(&bar);
    bar
}

/// Makes this bar the one that steps aside for other output.
pub fn show(bar: &ProgressBar) {
    if let Ok(mut shown) = ON_TERMINAL.lock() {
        *shown = Some(bar.clone());
    }
}

/// The time left in words; `None` as long as there is no rate.
pub fn left(time: Duration) -> Option<String> {
    (!time.is_zero()).then(|| format!("{} left", words(time)))
}

impl Progress for Shown {
    fn start(&self, unit: &'static str, done: u64, total: u64) {
        let first = *self.unit.get_or_init(|| unit);
        let bar = &self.bar;
        let say_done = || {
            // A single piece of work has nothing to count.
            if self.how == How::Plain && unit == first && done < total && total > 1 && !self.is_terse {
                self.begins.get_or_init(|| ());
                say!("{} of {} {unit} done", short(done as f64), short(total as f64));
            }
        };
        // More work of the same kind keeps the rate.
        if bar.message() == unit && bar.position() == done {
            bar.set_length(total);
            // All work before may have been done by an earlier run.
            if self.begins.get().is_none() {
                say_done();
            }
            return;
        }
        bar.reset();
        bar.set_message(unit);
        bar.set_length(total);
        bar.set_position(done);
        // The estimator of the rate needs this position before it is reset.
        bar.tick();
        bar.reset_eta();
        if self.how == How::Bar {
            bar.enable_steady_tick(Duration::from_millis(100));
        }
        say_done();
    }

    fn advance(&self, more: u64) {
        self.bar.inc(more);
        // If another thread is printing, there is nothing to add.
        let Some(mut next) = self.next.try_lock().ok().filter(|_| self.how == How::Plain) else { return };
        if Instant::now() >= *next {
            *next = Instant::now() + LINE;
            let bar = &self.bar;
            let percent = 100.0 * bar.position() as f64 / bar.length().unwrap_or(0).max(1) as f64;
            let left = left(bar.eta()).map_or_else(String::new, |left| format!(", {left}"));
            say!("{percent:.0} %, {} {}/s{left}", short(bar.per_sec()), bar.message());
        }
    }

    fn note(&self, sentence: &str) {
        if self.how != How::None {
            note!("{sentence}");
        }
    }

    fn stops(&self) -> bool {
        self.stop.as_ref().is_some_and(|stop| stop.cause().is_some())
    }
}

/// A time to within a few percent: `74 s`, `2 min 10 s`, `3 h 20 min`, `2 d 5 h`.
fn words(time: Duration) -> String {
    let seconds = time.as_secs_f64().round() as u64;
    let two = |large: u64, small: u64, names: [&str; 2]| match (seconds / large, seconds % large / small) {
        (whole, 0) => format!("{whole} {}", names[0]),
        (whole, rest) => format!("{whole} {} {rest} {}", names[0], names[1]),
    };
    match seconds {
        0..100 => format!("{seconds} s"),
        100..3600 => two(60, 1, ["min", "s"]),
        3600..172_800 => two(3600, 60, ["h", "min"]),
        _ => two(86_400, 3600, ["d", "h"]),
    }
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_told_in_the_units_that_suit_them() {
        let said = [0.4, 74.4, 130.0, 180.0, 12_000.0, 7200.0, 190_800.0];
        let said = said.map(|seconds| words(Duration::from_secs_f64(seconds)));
        assert_eq!(said, ["0 s", "74 s", "2 min 10 s", "3 min", "3 h 20 min", "2 h", "2 d 5 h"]);
    }

    #[test]
    fn what_earlier_runs_did_is_no_part_of_the_rate() {
        let shown = Shown::new(How::None);
        shown.start("trials", 900_000_000, 1_000_000_000);
        assert_eq!(left(shown.bar.eta()), None);
        for _ in 0..20 {
            std::thread::sleep(Duration::from_millis(2));
            shown.advance(10);
        }
        assert!(shown.bar.per_sec() < 1e6, "{}", shown.bar.per_sec());
        assert_eq!(shown.reached(), (900_000_200, 1_000_000_000, "trials"));
    }

    #[test]
    fn more_work_of_a_phase_keeps_its_count() {
        let shown = Shown::new(How::None);
        shown.start("trials", 0, 10);
        shown.advance(10);
        shown.start("trials", 10, 30);
        shown.advance(5);
        assert_eq!(shown.reached(), (15, 30, "trials"));
    }
}
