//! The limits of a case: memory, by the allocator of this program, and time, by a thread that looks on.
//!
//! Neither can be recovered from, so whoever goes beyond ends the program, after its input has been kept and told.

use std::alloc::{GlobalAlloc, Layout, System};
use std::io::Write;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};
use std::sync::{Mutex, Once, PoisonError};
use std::time::{Duration, Instant};

/// Most bytes that a case may hold at a time, over what was held before it.
const MAX_BYTES: usize = 1 << 30;

/// Longest time of a case, on the processor and in all: another program may have the processor meanwhile.
const MAX_TIME: Duration = Duration::from_secs(10);
const STUCK: Duration = Duration::from_secs(120);

/// The system's allocator, which counts what is held and grants no case more than [`MAX_BYTES`].
struct Limited;

#[global_allocator]
static ALLOCATOR: Limited = Limited;

/// Bytes held by the program, before the case, and at most since then.
static HELD: AtomicUsize = AtomicUsize::new(0);
static BEFORE: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

/// Set where the program ends: telling so needs memory too.
static ENDING: AtomicBool = AtomicBool::new(false);

/// Cases take turns: memory and time are those of the whole program.
static TURN: Mutex<()> = Mutex::new(());

/// The case that is running.
static RUNNING: Mutex<Option<Running>> = Mutex::new(None);

struct Running {
    started: Clock,
    input: Vec<u8>,
    /// Where the input is kept if the program ends.
    file: PathBuf,
}

/// What a case took.
#[derive(Debug, Clone, Copy)]
pub struct Taken {
    /// On the processor.
    pub time: Duration,
    /// At most at a time, by all threads.
    pub bytes: usize,
}

/// Runs `case` within the limits; `file` is where its `input` is kept if it goes beyond them.
pub fn within<T>(input: &[u8], file: PathBuf, case: impl FnOnce() -> T) -> (T, Taken) {
    static WATCH: Once = Once::new();
    WATCH.call_once(|| drop(std::thread::spawn(watch)));
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let started = Clock::start();
    set(Some(Running { started, input: input.to_owned(), file }));
    // A case that panics leaves no clock running.
    let stop = Stop;
    let before = HELD.load(Relaxed);
    BEFORE.store(before, Relaxed);
    PEAK.store(before, Relaxed);
    let result = case();
    drop(stop);
    (result, Taken { time: started.spent(), bytes: PEAK.load(Relaxed).saturating_sub(before) })
}

/// When a case began.
#[derive(Clone, Copy)]
struct Clock {
    passed: Instant,
    spent: Option<Duration>,
}

impl Clock {
    fn start() -> Clock {
        Clock { passed: Instant::now(), spent: on_processor() }
    }

    /// Time since then of the processor, of all threads; what has passed where that is not known.
    fn spent(&self) -> Duration {
        match (self.spent, on_processor()) {
            (Some(before), Some(now)) => now.saturating_sub(before),
            _ => self.passed.elapsed(),
        }
    }
}

/// What the program has spent on the processor, as Linux tells it, in 1/100 s: proc_pid_stat(5).
fn on_processor() -> Option<Duration> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    let (_, after_name) = stat.rsplit_once(')')?;
    let mut hundredths = after_name.split_whitespace().skip(11).take(2).map(str::parse::<u64>);
    Some(Duration::from_millis(10 * (hundredths.next()?.ok()? + hundredths.next()?.ok()?)))
}

struct Stop;

impl Drop for Stop {
    fn drop(&mut self) {
        set(None);
    }
}

fn set(running: Option<Running>) {
    *RUNNING.lock().unwrap_or_else(PoisonError::into_inner) = running;
}

/// Looks at the clock for ever.
fn watch() {
    loop {
        std::thread::sleep(Duration::from_millis(100));
        let running = RUNNING.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(Running { started, .. }) = running.as_ref() else { continue };
        if started.spent() > MAX_TIME || started.passed.elapsed() > STUCK {
            end(running.as_ref(), &format!("a case takes longer than {} s", MAX_TIME.as_secs()));
        }
    }
}

/// Tells why and of which input, keeps that, and ends the program.
fn end(running: Option<&Running>, why: &str) -> ! {
    ENDING.store(true, Relaxed);
    let mut report = format!("\n{why}\n");
    if let Some(Running { input, file, .. }) = running {
        report += &format!("{}\n", kept(input, file));
    }
    // Past the test harness, which would keep it to itself.
    let _ = std::io::stderr().write_all(report.as_bytes());
    std::process::exit(1)
}

/// Keeps a failing input in `file`, and says so.
pub fn kept(input: &[u8], file: &std::path::Path) -> String {
    let shown = String::from_utf8_lossy(input);
    match std::fs::write(file, input) {
        Ok(()) => format!("its input is kept in {}:\n{shown}", file.display()),
        Err(error) => format!("its input cannot be kept in {} ({error}):\n{shown}", file.display()),
    }
}

/// Counts `bytes` more, and ends the program where they are too many.
fn take(bytes: usize) {
    let held = HELD.fetch_add(bytes, Relaxed) + bytes;
    PEAK.fetch_max(held, Relaxed);
    if held.saturating_sub(BEFORE.load(Relaxed)) > MAX_BYTES && !ENDING.load(Relaxed) {
        // Held only by code that asks for little.
        if let Ok(running) = RUNNING.try_lock()
            && running.is_some()
        {
            end(running.as_ref(), &format!("a case asks for more than {} MiB", MAX_BYTES >> 20));
        }
    }
}

fn give(bytes: usize) {
    HELD.fetch_sub(bytes, Relaxed);
}

// SAFETY: every call goes to the system's allocator as it is.
unsafe impl GlobalAlloc for Limited {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        take(layout.size());
        // SAFETY: the caller keeps the same contract.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        take(layout.size());
        // SAFETY: the caller keeps the same contract.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, old: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        take(size);
        give(layout.size());
        // SAFETY: the caller keeps the same contract.
        unsafe { System.realloc(old, layout, size) }
    }

    unsafe fn dealloc(&self, old: *mut u8, layout: Layout) {
        give(layout.size());
        // SAFETY: the caller keeps the same contract.
        unsafe { System.dealloc(old, layout) }
    }
}
