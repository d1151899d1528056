//! Progress of a run: reports to its caller while it proceeds, a way for the caller to stop it, and the time that it takes.

/// Receives progress; may ask the run to stop.
///
/// All methods have a default that does nothing, so a listener implements only what it needs. Several threads may call
/// them at the same time.
pub trait Progress: Sync {
    /// A phase of work starts, or its total becomes known more precisely: `done` of its `total` units are finished.
    /// Units of one phase take about the same time each, or are mixed evenly over the phase, so that the time left
    /// follows from their rate.
    ///
    /// `unit` is `points` while a study is planned, else `trials`, `samples`, `switches`, `records`, `fits` or `evaluations`. With a precision, the total is that of the current
    /// round, and each further round raises it.
    fn start(&self, _unit: &'static str, _done: u64, _total: u64) {}

    /// `more` units are finished.
    fn advance(&self, _more: u64) {}

    /// A sentence for the user to read at once; the results repeat it in their notes.
    fn note(&self, _sentence: &str) {}

    /// Whether to stop early. A run asks after every batch, a few times a second, and keeps what it sampled.
    fn stops(&self) -> bool {
        false
    }
}

/// Ignores all progress and never stops a run.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Progress for Silent {}

/// Measures the time since its start. WebAssembly has no clock, so there no time passes.
#[derive(Debug, Clone, Copy)]
pub struct Stopwatch {
    #[cfg(not(target_family = "wasm"))]
    started: std::time::Instant,
}

impl Stopwatch {
    /// Starts it.
    pub fn start() -> Stopwatch {
        Stopwatch {
            #[cfg(not(target_family = "wasm"))]
            started: std::time::Instant::now(),
        }
    }

    /// Seconds since the start.
    pub fn seconds(&self) -> f64 {
        #[cfg(not(target_family = "wasm"))]
        return self.started.elapsed().as_secs_f64();
        #[cfg(target_family = "wasm")]
        return 0.0;
    }
}
