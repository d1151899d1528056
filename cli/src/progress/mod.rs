//! Progress on the standard error stream: a bar on a terminal, now and then a line elsewhere.

pub mod pace;

use std::io::IsTerminal;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use crate::progress::pace::{Pace, words};
use clap::{Args, ValueEnum};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
pub use sagnac::quantity::number::short;
use sagnac::run::Progress;

use crate::look;

/// Between lines where there is no terminal.
const LINE: Duration = Duration::from_secs(10);

// As a group it would be called as the options are that it stands among, which debug builds refuse.
#[derive(Debug, Args)]
#[group(skip)]
pub struct Options {
    /// Progress on the standard error stream: a bar on a terminal, else lines; bar, plain (a line every 10 s), none
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
    /// How it is shown to someone who wants to hear of errors only, or of more.
    pub fn how(&self, quiet: bool) -> How {
        match self.progress {
            How::Auto if quiet => How::None,
            asked => asked,
        }
    }
}

/// What is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum How {
    Auto,
    Bar,
    Plain,
    None,
}

/// The bar that is on the terminal.
static ON_TERMINAL: Mutex<Option<ProgressBar>> = Mutex::new(None);

/// Prints something beside the bar, which makes room for it meanwhile.
pub fn aside(print: impl FnOnce()) {
    let bar = ON_TERMINAL.lock().ok().and_then(|bar| bar.clone());
    match bar {
        Some(bar) => bar.suspend(print),
        None => print(),
    }
}

/// Takes the bar from the terminal, for good.
pub fn leave() {
    let bar = ON_TERMINAL.lock().ok().and_then(|mut bar| bar.take());
    if let Some(bar) = bar {
        bar.finish_and_clear();
    }
}

/// From so many columns on a bar of 30 leaves room for all there is to say; else it is as wide as the rest leaves it, without the rate.
const ROOMY: usize = 108;

/// How progress is shown. A bar stays until it is cleared or dropped: there is something to wait for when all is sampled.
pub enum Shown {
    Nothing,
    Bar(ProgressBar, Arc<Mutex<Pace>>),
    Lines(Lines),
}

impl Shown {
    /// As it is asked for, of work that has so much `behind` it. There is no bar without a terminal: control characters are no
    /// text.
    pub fn new(how: How, behind: Duration) -> Shown {
        let bare =
            !std::io::stderr().is_terminal() || std::env::var_os("TERM").is_some_and(|term| term == "dumb");
        match how {
            How::None => return Shown::Nothing,
            How::Plain => return Shown::Lines(Lines::new(behind)),
            How::Auto | How::Bar if bare => return Shown::Lines(Lines::new(behind)),
            How::Auto | How::Bar => {}
        }
        let pace = Arc::new(Mutex::new(Pace::new(0, 0).then(behind)));
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr_with_hz(10));
        let is_roomy = look::error_columns() >= ROOMY;
        let template = match is_roomy {
            true => "{bar:30} {percent:>3} %  {done} {msg}  {rate}  {left}",
            false => "{wide_bar} {percent:>3} %  {done} {msg}  {left}",
        };
        if let Ok(style) = ProgressStyle::with_template(template) {
            let read = pace.clone();
            bar.set_style(
                style
                    .with_key("done", |state: &ProgressState, to: &mut dyn std::fmt::Write| {
                        let _ = write!(
                            to,
                            "{} of {}",
                            short(state.pos() as f64),
                            short(state.len().unwrap_or(0) as f64)
                        );
                    })
                    .with_key("rate", |state: &ProgressState, to: &mut dyn std::fmt::Write| {
                        // When all is done it would only fall.
                        let goes_on = state.len().is_some_and(|len| state.pos() < len);
                        let _ = if goes_on { write!(to, "{}/s", short(state.per_sec())) } else { Ok(()) };
                    })
                    .with_key("left", move |state: &ProgressState, to: &mut dyn std::fmt::Write| {
                        let left = read.lock().ok().and_then(|pace| pace.left(state.pos()));
                        let _ = left.map_or(Ok(()), |left| write!(to, "{} left", words(left)));
                    }),
            );
        }
        if let Ok(mut shown) = ON_TERMINAL.lock() {
            *shown = Some(bar.clone());
        }
        Shown::Bar(bar, pace)
    }

    /// Makes room for other output.
    pub fn clear(&self) {
        if let Shown::Bar(..) = self {
            leave();
        }
    }
}

impl Drop for Shown {
    fn drop(&mut self) {
        self.clear();
    }
}

impl Progress for Shown {
    fn start(&self, unit: &'static str, done: u64, total: u64) {
        match self {
            Shown::Nothing => {}
            Shown::Bar(bar, pace) => {
                if let Ok(mut pace) = pace.lock() {
                    pace.enter(done, total);
                }
                // It may have come to an end with another unit.
                bar.reset();
                bar.set_message(unit);
                bar.set_length(total);
                bar.set_position(done);
                bar.reset_eta();
                bar.tick();
                bar.enable_steady_tick(Duration::from_millis(100));
            }
            Shown::Lines(lines) => lines.start(unit, done, total),
        }
    }

    fn expect(&self, total: u64) {
        match self {
            Shown::Nothing => {}
            Shown::Bar(bar, _) => bar.set_length(total),
            Shown::Lines(lines) => lines.expect(total),
        }
    }

    fn advance(&self, more: u64) {
        match self {
            Shown::Nothing => {}
            Shown::Bar(bar, _) => bar.inc(more),
            Shown::Lines(lines) => lines.advance(more),
        }
    }

    fn cost(&self, done: f64, total: f64) {
        match self {
            Shown::Nothing => {}
            Shown::Bar(_, pace) => {
                if let Ok(mut pace) = pace.lock() {
                    pace.cost(done, total);
                }
            }
            Shown::Lines(lines) => lines.cost(done, total),
        }
    }

    fn note(&self, sentence: &str) {
        match self {
            Shown::Nothing => {}
            Shown::Bar(..) | Shown::Lines(_) => say!("note: {sentence}"),
        }
    }

    fn finish(&self) {}
}

/// Plain lines, without control characters.
pub struct Lines {
    done: AtomicU64,
    state: Mutex<State>,
}

struct State {
    unit: &'static str,
    total: u64,
    pace: Pace,
    next: Instant,
}

impl Lines {
    fn new(behind: Duration) -> Lines {
        let next = Instant::now() + LINE;
        let state = State { unit: "", total: 0, pace: Pace::new(0, 0).then(behind), next };
        Lines { done: AtomicU64::new(0), state: Mutex::new(state) }
    }

    fn start(&self, unit: &'static str, before: u64, total: u64) {
        self.done.store(before, Ordering::Relaxed);
        // What records are then used for begins where they have been made.
        if before < total && !["fits", "records"].contains(&unit) {
            say!("{} of {} {unit} done", short(before as f64), short(total as f64));
        }
        if let Ok(mut state) = self.state.lock() {
            (state.unit, state.total) = (unit, total);
            state.pace.enter(before, total);
        }
    }

    fn expect(&self, total: u64) {
        if let Ok(mut state) = self.state.lock() {
            state.total = total;
        }
    }

    fn advance(&self, more: u64) {
        let done = self.done.fetch_add(more, Ordering::Relaxed) + more;
        // A thread that finds another one printing has nothing to add.
        let Ok(mut state) = self.state.try_lock() else { return };
        let State { unit, total, pace, next } = &mut *state;
        if Instant::now() >= *next {
            *next = Instant::now() + LINE;
            let percent = 100.0 * done as f64 / (*total).max(1) as f64;
            let left = pace.left(done).map_or_else(String::new, |left| format!(", {} left", words(left)));
            say!("{percent:.0} %, {} {unit}/s{left}", short(pace.rate(done)));
        }
    }

    fn cost(&self, done: f64, total: f64) {
        if let Ok(mut state) = self.state.lock() {
            state.pace.cost(done, total);
        }
    }
}
