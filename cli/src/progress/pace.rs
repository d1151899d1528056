//! How long the rest takes.

use std::time::{Duration, Instant};

/// The pace of some work since it was begun, which may have phases with units of their own.
///
/// The rest is taken to go on as the last half of the time did: by cost, where that is told, as units may differ in what they take;
/// between two such tellings by the time that has passed since, and without any by units. A cost may count what later phases take.
#[derive(Debug, Clone)]
pub struct Pace {
    started: Instant,
    /// What comes when all is done takes so long.
    behind: Duration,
    phase: Phase,
    /// Units that earlier runs had done, and all.
    before: u64,
    total: u64,
    /// The last that was told of the cost, and after what time.
    told: Option<(Cost, Duration)>,
    /// What was done after some times, of those that were told.
    history: Vec<(Duration, f64)>,
}

/// What is done of some work, and all of it, in any unit.
#[derive(Debug, Clone, Copy)]
struct Cost {
    done: f64,
    total: f64,
}

/// Units that count from some time on.
#[derive(Debug, Clone, Copy, Default)]
struct Phase {
    since: Duration,
    /// The cost of the phases before it, and what those told of it and what follows; none of the first.
    cost: Option<Cost>,
}

impl Phase {
    /// The cost of all, of that of the phase alone.
    fn of_all(&self, cost: Cost) -> Cost {
        self.cost.map_or(cost, |Cost { done, total }| Cost {
            done: done + (total - done) * cost.done / cost.total,
            total,
        })
    }
}

/// Most of what is remembered.
const HISTORY: usize = 256;

/// The part of a phase that tells how long the rest of it takes.
const KNOWN: f64 = 0.1;

impl Pace {
    /// From now on, with so many units done before.
    pub fn new(before: u64, total: u64) -> Pace {
        let (started, behind, phase) = (Instant::now(), Duration::ZERO, Phase::default());
        Pace { started, behind, phase, before, total, told: None, history: vec![(Duration::ZERO, 0.0)] }
    }

    /// The pace of work that has so much behind it when all units are done.
    pub fn then(self, behind: Duration) -> Pace {
        Pace { behind, ..self }
    }

    /// The next phase of the same work begins, or other work with the same behind it.
    pub fn enter(&mut self, before: u64, total: u64) {
        match self.is_open() {
            true => self.go_on(before, total),
            false => *self = Pace::new(before, total).then(self.behind),
        }
    }

    /// Whether more was told to follow than was done.
    fn is_open(&self) -> bool {
        self.told.is_some_and(|(cost, _)| cost.done < cost.total)
    }

    fn go_on(&mut self, before: u64, total: u64) {
        let elapsed = self.elapsed();
        self.go_on_after(elapsed, before, total);
    }

    fn go_on_after(&mut self, elapsed: Duration, before: u64, total: u64) {
        let cost = self.told.map(|(cost, _)| cost).or(self.phase.cost);
        (self.phase, self.told) = (Phase { since: elapsed, cost }, None);
        (self.before, self.total) = (before, total);
    }

    /// So much is done by its cost.
    pub fn cost(&mut self, done: f64, total: f64) {
        let elapsed = self.elapsed();
        self.cost_after(elapsed, done, total);
    }

    fn cost_after(&mut self, elapsed: Duration, done: f64, total: f64) {
        // Where no end is known no time is told either.
        let is_cost = total >= done && (done > 0.0 || total.is_infinite());
        self.told = is_cost.then(|| (self.phase.of_all(Cost { done, total }), elapsed));
        let Some((cost, _)) = self.told else { return };
        self.history.push((elapsed, cost.done));
        if self.history.len() > HISTORY {
            let mut place = 0;
            // The first stays, as the start.
            self.history.retain(|_| {
                place += 1;
                place % 2 == 1
            });
        }
    }

    pub fn elapsed(&self) -> Duration {
        self.started.elapsed()
    }

    /// Units a second.
    pub fn rate(&self, done: u64) -> f64 {
        let seconds = self.elapsed().saturating_sub(self.phase.since).as_secs_f64();
        done.saturating_sub(self.before) as f64 / seconds.max(1e-9)
    }

    /// The time that is left, where anything is known of it.
    pub fn left(&self, done: u64) -> Option<Duration> {
        self.left_after(self.elapsed(), done)
    }

    /// From when on, and with what done by then, the time before `at` tells the pace: the last half, or the phase at hand as soon as a
    /// tenth of it is done, as what it costs was foreseen from few tries.
    fn window(&self, at: Duration, done: f64, total: f64) -> Option<(Duration, f64)> {
        let Phase { since, cost } = self.phase;
        let begun = cost.map(|begun| begun.done).filter(|begun| done - begun >= KNOWN * (total - begun));
        match begun {
            Some(begun) if since > at / 2 => Some((since, begun)),
            _ => self.history.iter().rev().find(|(time, _)| *time <= at / 2).copied(),
        }
    }

    fn left_after(&self, elapsed: Duration, done: u64) -> Option<Duration> {
        let by_units = || {
            let [done, total] = [done, self.total].map(|units| units.saturating_sub(self.before) as f64);
            (total > 0.0).then(|| (self.phase.of_all(Cost { done, total }), elapsed))
        };
        let (Cost { done, total }, at) = self.told.or_else(by_units)?;
        let (from, before) = self.window(at, done, total)?;
        let rate = (done - before) / at.saturating_sub(from).as_secs_f64();
        let rest = (rate > 0.0).then(|| (total - done) / rate)?;
        let rest = rest + self.behind.as_secs_f64() - elapsed.saturating_sub(at).as_secs_f64();
        Duration::try_from_secs_f64(rest.max(0.0)).ok()
    }
}

/// A time to within a few percent: `74 s`, `2 min 10 s`, `3 h 20 min`, `2 d 5 h`.
pub fn words(time: Duration) -> String {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_told_in_the_units_that_suit_them() {
        let said = [0.4, 74.4, 130.0, 180.0, 12_000.0, 7200.0, 190_800.0];
        let said = said.map(|seconds| words(Duration::from_secs_f64(seconds)));
        assert_eq!(said, ["0 s", "74 s", "2 min 10 s", "3 min", "3 h 20 min", "2 h", "2 d 5 h"]);
    }

    /// Batches of some work: units, cost as it is told, seconds that they took.
    type Timeline = Vec<(u64, f64, f64)>;

    /// How far the time left is off at worst, as a part of it, from the first tenth of the time to the last.
    fn worst(timeline: &Timeline, is_told: bool) -> f64 {
        let [units, cost] = [
            timeline.iter().map(|batch| batch.0 as f64).sum::<f64>(),
            timeline.iter().map(|batch| batch.1).sum(),
        ];
        let whole: f64 = timeline.iter().map(|batch| batch.2).sum();
        let mut pace = Pace::new(7, 7 + units as u64);
        let (mut done, mut paid, mut elapsed, mut worst) = (7, 0.0, 0.0, 0.0_f64);
        for (more, price, seconds) in timeline {
            (done, paid, elapsed) = (done + more, paid + price, elapsed + seconds);
            if is_told {
                pace.cost_after(Duration::from_secs_f64(elapsed), paid, cost);
            }
            if (0.1 * whole..0.9 * whole).contains(&elapsed) {
                let left = pace.left_after(Duration::from_secs_f64(elapsed), done).unwrap().as_secs_f64();
                worst = worst.max((left / (whole - elapsed) - 1.0).abs());
            }
        }
        worst
    }

    /// A sweep of the switching interval: the first points have thirty times the switches of the last ones, and a slow first batch.
    fn sweep() -> Timeline {
        let points = [360_u64, 240, 160, 107, 71, 47, 32, 21, 14, 12];
        let batch = |(at, switches): (usize, &u64)| {
            let slow = if at == 0 { 1.3 } else { 1.0 };
            (20_000, (20_000 * switches) as f64, 1e-3 * slow * *switches as f64)
        };
        points.iter().flat_map(|switches| [switches; 40]).enumerate().map(batch).collect()
    }

    #[test]
    fn the_time_left_is_right_within_a_fifth_after_a_tenth_where_points_differ_in_cost() {
        assert!(worst(&sweep(), true) < 0.2, "off by {}", worst(&sweep(), true));
        assert!(worst(&sweep(), false) > 0.5, "trials alone would do, and the test shows nothing");
    }

    #[test]
    fn points_that_go_forward_together_need_no_cost() {
        let mut together: Timeline = Vec::new();
        for _ in 0..40 {
            together.extend([360_u64, 160, 71, 32, 12].map(|ms| (20_000, 0.0, 1e-3 * ms as f64)));
        }
        assert!(worst(&together, false) < 0.2, "off by {}", worst(&together, false));
    }

    #[test]
    fn what_earlier_runs_did_took_no_time_and_nothing_is_said_before_anything_is_done() {
        let pace = Pace::new(900, 1000);
        assert_eq!(pace.left_after(Duration::from_secs(10), 900), None);
        assert_eq!(pace.left_after(Duration::from_secs(10), 950), Some(Duration::from_secs(10)));
        assert_eq!(Pace::new(5, 5).left_after(Duration::from_secs(1), 5), None);
    }

    #[test]
    fn a_machine_that_has_less_time_is_noticed() {
        let batch = |at: u64| (20_000, 1.0, if at < 400 { 1e-3 } else { 3e-3 });
        let mut pace = Pace::new(0, 1);
        let (mut elapsed, whole) = (0.0, (0..1000).map(|at| batch(at).2).sum::<f64>());
        for at in 0..800 {
            elapsed += batch(at).2;
            pace.cost_after(Duration::from_secs_f64(elapsed), at as f64 + 1.0, 1000.0);
        }
        let left = pace.left_after(Duration::from_secs_f64(elapsed), 0).unwrap().as_secs_f64();
        assert!((left / (whole - elapsed) - 1.0).abs() < 0.1, "{left} of {}", whole - elapsed);
        assert!(pace.history.len() <= HISTORY);
    }

    #[test]
    fn phases_of_the_same_work_go_on() {
        let seconds = Duration::from_secs;
        let mut pace = Pace::new(0, 100);
        // A quarter of all is sampling, and fits follow.
        pace.cost_after(seconds(10), 10.0, 40.0);
        assert!(pace.is_open());
        pace.go_on_after(seconds(10), 0, 1000);
        assert_eq!(pace.left_after(seconds(10), 0), Some(seconds(30)));
        assert_eq!(pace.left_after(seconds(20), 500), Some(seconds(10)));
        assert!(!pace.is_open());
        pace.cost_after(seconds(25), 2.0, 3.0);
        assert_eq!(pace.left_after(seconds(25), 0), Some(Duration::from_secs_f64(7.5)));
        // What ended is no part of what comes then.
        pace.cost_after(seconds(40), 3.0, 3.0);
        assert!(!pace.is_open());
    }

    #[test]
    fn a_phase_that_goes_faster_than_foreseen_is_told_by_itself() {
        let seconds = Duration::from_secs;
        let mut pace = Pace::new(0, 100);
        pace.cost_after(seconds(40), 40.0, 60.0);
        pace.go_on_after(seconds(40), 0, 1000);
        assert_eq!(pace.left_after(seconds(40), 0), Some(seconds(20)));
        assert_eq!(pace.left_after(seconds(41), 100), Some(seconds(9)));
        assert_eq!(pace.left_after(seconds(45), 500), Some(seconds(5)));
    }

    #[test]
    fn work_that_turns_out_to_be_more_is_told_by_what_was_done_so_far() {
        let seconds = Duration::from_secs;
        let mut pace = Pace::new(0, 1);
        for at in 1..=10 {
            // As it seems first it ends soon; then there is ten times as much.
            pace.cost_after(seconds(at), at as f64, if at < 8 { 10.0 } else { 100.0 });
        }
        assert_eq!(pace.left_after(seconds(10), 0), Some(seconds(90)));
    }

    #[test]
    fn where_the_cost_of_what_follows_is_not_known_no_time_is_told() {
        let mut pace = Pace::new(0, 100);
        pace.cost_after(Duration::from_secs(1), 0.0, f64::INFINITY);
        assert_eq!(pace.left_after(Duration::from_secs(2), 10), None);
        pace.cost_after(Duration::from_secs(10), 10.0, f64::INFINITY);
        assert_eq!(pace.left_after(Duration::from_secs(10), 50), None);
    }

    #[test]
    fn what_comes_behind_is_waited_for_as_well() {
        let seconds = Duration::from_secs;
        let mut pace = Pace::new(0, 100).then(seconds(3));
        pace.cost_after(seconds(10), 1.0, 4.0);
        assert_eq!(pace.left_after(seconds(10), 25), Some(seconds(33)));
        pace.cost_after(seconds(40), 4.0, 4.0);
        assert_eq!(pace.left_after(seconds(40), 100), Some(seconds(3)));
        assert_eq!(pace.left_after(seconds(42), 100), Some(seconds(1)));
        pace.enter(0, 10);
        assert_eq!(pace.left_after(seconds(5), 5), Some(seconds(8)));
    }

    #[test]
    fn time_goes_on_between_two_batches() {
        let mut pace = Pace::new(0, 100);
        pace.cost_after(Duration::from_secs(10), 1.0, 4.0);
        assert_eq!(pace.left_after(Duration::from_secs(10), 3), Some(Duration::from_secs(30)));
        assert_eq!(pace.left_after(Duration::from_secs(15), 3), Some(Duration::from_secs(25)));
        assert_eq!(pace.left_after(Duration::from_secs(50), 3), Some(Duration::ZERO));
    }
}
