//! The central interval of a binomial distribution.

use std::cell::Cell;

use crate::tally::stats::NORMAL_95;

/// The least and the greatest number of successes in 95 % of all cases, of `n` trials with success probability `p`; at
/// most 2.5 % of the cases lie outside on either side.
///
/// The last result is cached, because it takes as long as thousands of trials, and most rows of a table have as many
/// trials as the one before.
pub(crate) fn central_interval(n: u64, p: f64) -> (u64, u64) {
    thread_local! {
        static LAST: Cell<((u64, f64), (u64, u64))> = const { Cell::new(((0, 0.0), (0, 0))) };
    }
    let (known, interval) = LAST.get();
    if known == (n, p) {
        return interval;
    }
    let interval = computed(n, p);
    LAST.set(((n, p), interval));
    interval
}

/// The 95 % interval of a probability after `successes` in `n` trials (Wilson).
pub(crate) fn proportion_interval(successes: u64, n: u64) -> (f64, f64) {
    let (part, n) = (successes as f64 / n as f64, n as f64);
    let square = NORMAL_95 * NORMAL_95 / n;
    let middle = part + 0.5 * square;
    let half = libm::sqrt(square * (part * (1.0 - part) + 0.25 * square));
    (((middle - half) / (1.0 + square)).max(0.0), ((middle + half) / (1.0 + square)).min(1.0))
}

fn computed(n: u64, p: f64) -> (u64, u64) {
    let mean = n as f64 * p;
    let sd = libm::sqrt(mean * (1.0 - p));
    if mean > 10_000.0 {
        let half = 1.959_963_985 * sd + 0.5;
        return (libm::floor(mean - half) as u64, (libm::ceil(mean + half) as u64).min(n));
    }
    let log_factorial = |k: u64| libm::lgamma(k as f64 + 1.0);
    let probability = |k: u64| {
        let choose = log_factorial(n) - log_factorial(k) - log_factorial(n - k);
        libm::exp(choose + k as f64 * libm::log(p) + (n - k) as f64 * libm::log1p(-p))
    };
    let (mut below, mut fewest) = (0.0, None);
    for k in 0..=n {
        below += probability(k);
        if fewest.is_none() && below > 0.025 {
            fewest = Some(k);
        }
        if below >= 0.975 {
            return (fewest.unwrap_or(0), k);
        }
    }
    (fewest.unwrap_or(0), n)
}
