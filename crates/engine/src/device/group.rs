//! Devices that share work by their measured speed.

use std::ops::Range;
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::thread::{self, ScopedJoinHandle};

use crate::device::{Advance, Device, GpuError, Job, RetryProgress, Tallies};
use crate::tally::cover;
use sagnac_base::progress::Stopwatch;

/// Devices that share work. Each works on a thread of its own and takes parts of the work that are as large as its measured
/// speed, so that all end at about the same time.
///
/// A member that fails leaves the group, and the others do its part.
pub struct Group {
    /// At least one.
    members: Vec<Member>,
    /// One sentence for each member that has left.
    left: Vec<String>,
}

struct Member {
    device: Device,
    /// Steps of trials, or samples of records, per second.
    rate: f64,
    /// Whether the rate is a guess, which its first work replaces.
    is_guess: bool,
    /// Why it leaves.
    failure: Option<GpuError>,
}

/// Weight of the last work in the rate of a member.
const NEWEST: f64 = 0.5;

/// Part of the rest that is dealt out at its measured rates. What is left of it corrects for rates that have changed.
const DEALT: f64 = 0.75;

/// Least part of all work that is dealt out at its rates, so that a member takes few parts.
const MIN_DEALT: f64 = 1.0 / 16.0;

/// A part of some work, the attempts at it and its results.
struct Part<'a, T> {
    units: Range<u64>,
    attempts: RetryProgress<'a>,
    result: Result<T, GpuError>,
}

impl Group {
    pub(crate) fn new(devices: Vec<Device>) -> Group {
        let member = |device: Device| {
            let rate = device.first_batch() as f64;
            Member { device, rate, is_guess: true, failure: None }
        };
        Group { members: devices.into_iter().map(member).collect(), left: vec![] }
    }

    /// The devices that have not left.
    pub fn devices(&self) -> impl Iterator<Item = &Device> {
        self.members.iter().map(|member| &member.device)
    }

    pub(crate) fn first(&mut self) -> &mut Device {
        &mut self.members[0].device
    }

    pub(crate) fn into_devices(self) -> Vec<Device> {
        self.members.into_iter().map(|member| member.device).collect()
    }

    /// One sentence for each member that has left since the last query.
    pub(crate) fn take_left(&mut self) -> Vec<String> {
        std::mem::take(&mut self.left)
    }

    /// Tallies of each job, in order, by calls of `by` with jobs for a device.
    ///
    /// # Errors
    /// The last member fails; no results of the jobs are kept.
    pub(crate) fn tally(
        &mut self,
        jobs: &[Job],
        progress: Advance,
        by: &(impl Fn(&mut Device, &[Job], Advance) -> Result<Tallies, GpuError> + Sync),
    ) -> Result<Tallies, GpuError> {
        let total = jobs.iter().map(steps).sum();
        // A part contains some trials, wherever it starts.
        let piece = jobs.iter().map(|job| piece(job) * job.launch.steps()).max().unwrap_or(1);
        let parts = self.shared(
            total,
            |_| piece,
            progress,
            |device, units, progress| by(device, &within(jobs, &units).1, progress),
        )?;
        let mut results: Tallies = vec![vec![]; jobs.len()];
        for Part { units, attempts, result } in parts {
            let (places, jobs) = within(jobs, &units);
            let tallied = result.or_else(|_| self.tally(&jobs, &attempts.next(), by))?;
            for (place, tallies) in places.into_iter().zip(tallied) {
                let result = &mut results[place];
                match result.is_empty() {
                    true => *result = tallies,
                    false => result.iter_mut().zip(&tallies).for_each(|(result, tally)| result.merge(tally)),
                }
            }
        }
        Ok(results)
    }

    /// Sums of some records of `samples` samples each, in order, by calls of `by` with records for a device.
    ///
    /// # Errors
    /// The last member fails, or a record is too long for a GPU and no member is the processor; no results are kept.
    pub(crate) fn sums(
        &mut self,
        samples: u64,
        records: Range<u64>,
        progress: Advance,
        by: &(impl Fn(&mut Device, Range<u64>, Advance) -> Result<Vec<u128>, GpuError> + Sync),
    ) -> Result<Vec<u128>, GpuError> {
        let numbers =
            |units: &Range<u64>| records.start + units.start / samples..records.start + units.end / samples;
        let total = (records.end - records.start) * samples;
        let lanes = |device: &Device| device.records_at_once() * samples;
        let mut parts = self.shared(total, lanes, progress, |device, units, progress| {
            by(device, numbers(&units), progress)
        })?;
        parts.sort_by_key(|part| part.units.start);
        let mut all = Vec::new();
        for Part { units, attempts, result } in parts {
            all.extend(match result {
                Ok(sums) => sums,
                Err(error @ GpuError::TooLong { .. }) => {
                    let is_cpu = |member: &&mut Member| matches!(member.device, Device::Cpu(_));
                    let cpu = self.members.iter_mut().find(is_cpu).ok_or(error)?;
                    by(&mut cpu.device, numbers(&units), &attempts.next())?
                }
                Err(_) => self.sums(samples, numbers(&units), &attempts.next(), by)?,
            });
        }
        Ok(all)
    }

    /// Has all members take parts of `total` units of work, in multiples of what `multiple` says of the device, until all
    /// are taken. A part is as large as the speed of the member, and smaller towards the end; a member whose least part would
    /// last longer than the rest of the work takes none. Members that fail leave.
    ///
    /// # Errors
    /// All of them fail; the last stays.
    fn shared<'a, T: Send>(
        &mut self,
        total: u64,
        multiple: impl Fn(&Device) -> u64 + Sync,
        progress: Advance<'a>,
        by: impl Fn(&mut Device, Range<u64>, Advance) -> Result<T, GpuError> + Sync,
    ) -> Result<Vec<Part<'a, T>>, GpuError> {
        let (mut parts, taken) = (vec![], AtomicU64::new(0));
        while taken.load(Relaxed) < total {
            let rates = self.members.iter().map(|member| member.rate);
            let (rates, fastest) = (rates.clone().sum::<f64>(), rates.fold(0.0, f64::max));
            let take = |member: &Member| {
                let end = |start: u64| {
                    let rest = total - start;
                    let dealt = (DEALT * rest as f64).max(MIN_DEALT * total as f64);
                    let part = ((dealt * member.rate / rates) as u64).max(1);
                    start + part.next_multiple_of(multiple(&member.device)).min(rest)
                };
                // The others are done with the rest before this one is with its least part.
                let is_too_slow = |rest: u64| {
                    let least = multiple(&member.device).min(rest) as f64;
                    member.rate < fastest && least / member.rate > rest as f64 / (rates - member.rate)
                };
                let takes = |start: u64| start < total && !is_too_slow(total - start);
                let took = taken.fetch_update(Relaxed, Relaxed, |start| takes(start).then(|| end(start)));
                took.ok().map(|start| start..end(start))
            };
            let work = |member: &mut Member| {
                let (mut parts, mut done, started) = (vec![], 0, Stopwatch::start());
                while let Some(units) = take(member) {
                    let attempts = RetryProgress::new(progress);
                    let result = by(&mut member.device, units.clone(), &attempts.next());
                    let failure = result.as_ref().err().cloned();
                    done += units.end - units.start;
                    parts.push(Part { units, attempts, result });
                    if let Some(failure) = failure {
                        let stays = matches!(failure, GpuError::TooLong { .. });
                        member.failure = Some(failure).filter(|_| !stays);
                        return parts;
                    }
                }
                if done > 0 {
                    let rate = done as f64 / started.seconds().max(1e-6);
                    let weight = if member.is_guess { 1.0 } else { NEWEST };
                    member.rate += weight * (rate - member.rate);
                    member.is_guess = false;
                }
                parts
            };
            parts.extend(thread::scope(|scope| {
                let mut members = self.members.iter_mut();
                let own = members.next();
                let others: Vec<_> = members.map(|member| scope.spawn(|| work(member))).collect();
                let own = own.into_iter().flat_map(work);
                let joined =
                    |other: ScopedJoinHandle<_>| other.join().unwrap_or_else(|panic| resume_unwind(panic));
                own.chain(others.into_iter().flat_map(joined)).collect::<Vec<_>>()
            }));
            self.bury()?;
        }
        Ok(parts)
    }

    /// Removes the members that have failed, but not the last.
    fn bury(&mut self) -> Result<(), GpuError> {
        for at in (0..self.members.len()).rev() {
            let Some(failure) = self.members[at].failure.take() else { continue };
            if self.members.len() == 1 {
                return Err(failure);
            }
            let name = self.members.remove(at).device.name();
            self.left.push(format!("{name}: {failure}; the other devices continue without it"));
        }
        Ok(())
    }
}

fn steps(job: &Job) -> u64 {
    job.block.trials() * job.launch.steps()
}

/// log2 of the number of places at which a block may be divided: enough for any speed, and few blocks make up a part.
const PLACES_LOG2: u32 = 10;

/// The trials of which a part of a job contains a multiple.
fn piece(job: &Job) -> u64 {
    (job.block.trials() >> PLACES_LOG2).max(1)
}

/// What lies within a range of the steps of all jobs: the jobs, and their places in the list. A block that contains a
/// bound of the range is divided.
fn within<'a>(jobs: &[Job<'a>], range: &Range<u64>) -> (Vec<usize>, Vec<Job<'a>>) {
    let mut before = 0;
    let mut found = (vec![], vec![]);
    for (place, job) in jobs.iter().enumerate() {
        let Job { launch, block } = *job;
        let piece = piece(job);
        let trial = |bound: u64| {
            let trials = bound.saturating_sub(before) / launch.steps();
            block.first + (trials / piece * piece).min(block.trials())
        };
        for block in cover(trial(range.start)..trial(range.end), block.log2) {
            found.0.push(place);
            found.1.push(Job { launch, block });
        }
        before += steps(job);
    }
    found
}

#[cfg(test)]
mod tests {
    use std::sync::Barrier;
    use std::time::Duration;

    use super::*;
    use crate::device::Cpu;
    use sagnac_kernel::width::Width;

    /// Processors of one, two and so on threads.
    fn group(rates: &[f64]) -> Group {
        let cpu = |threads| Device::Cpu(Cpu::new(Width::PORTABLE, threads).unwrap());
        let mut group = Group::new((1..=rates.len()).map(cpu).collect());
        for (member, &rate) in group.members.iter_mut().zip(rates) {
            member.rate = rate;
        }
        group
    }

    fn threads(device: &Device) -> u64 {
        device.records_at_once() / Width::PORTABLE.lanes() as u64
    }

    #[test]
    fn others_do_the_part_of_a_member_that_fails_and_each_record_is_counted_once() {
        for failing in [vec![1], vec![3], vec![1, 2]] {
            let (mut group, told) = (group(&[1.0, 1.0, 2.0]), AtomicU64::new(0));
            // No member does all parts before another has begun.
            let (calls, all_begun) = (AtomicU64::new(0), Barrier::new(3));
            let by = |device: &mut Device, records: Range<u64>, progress: Advance| {
                if calls.fetch_add(1, Relaxed) < 3 {
                    all_begun.wait();
                }
                progress((records.end - records.start) / 2);
                if failing.contains(&threads(device)) {
                    return Err(GpuError::Lost("unplugged".to_owned()));
                }
                progress((records.end - records.start).div_ceil(2));
                Ok(records.map(u128::from).collect())
            };
            let advance = |more| {
                told.fetch_add(more, Relaxed);
            };
            for round in 0..2 {
                let records = 1000 * round..1000 * round + 777;
                let sums = group.sums(10, records.clone(), &advance, &by).unwrap();
                assert!(sums.into_iter().eq(records.map(u128::from)), "{failing:?} fail");
            }
            assert_eq!(told.into_inner(), 2 * 777, "{failing:?} fail");
            assert_eq!(group.devices().count(), 3 - failing.len());
            let left = group.take_left();
            assert_eq!(left.len(), failing.len());
            for sentence in left {
                assert!(sentence.ends_with(
                    "threads): the device was lost: unplugged; the other devices continue without it"
                ));
            }
        }
    }

    #[test]
    fn a_group_fails_with_its_last_member() {
        let mut group = group(&[1.0, 1.0]);
        let by = |_: &mut Device, _: Range<u64>, _: Advance| Err(GpuError::OutOfMemory);
        assert_eq!(group.sums(10, 0..100, &|_| {}, &by), Err(GpuError::OutOfMemory));
        assert_eq!(group.devices().count(), 1);
    }

    #[test]
    fn members_take_parts_by_their_speed_and_a_slow_one_takes_none_that_the_others_wait_for() {
        // Records per second of processors of one, two and three threads. The first two seem equal at first.
        let speeds = [2000.0, 6000.0, 0.5];
        let (mut group, taken) = (group(&[1e4, 1e4, 5.0]), [const { AtomicU64::new(0) }; 3]);
        let by = |device: &mut Device, records: Range<u64>, _: Advance| {
            let (member, count) = (threads(device) as usize - 1, records.end - records.start);
            taken[member].fetch_add(count, Relaxed);
            thread::sleep(Duration::from_secs_f64(count as f64 / speeds[member]));
            Ok(records.map(u128::from).collect())
        };
        for _ in 0..2 {
            taken.iter().for_each(|taken| taken.store(0, Relaxed));
            let sums = group.sums(10, 0..1000, &|_| {}, &by).unwrap();
            assert!(sums.into_iter().eq(0..1000));
        }
        let [slow, fast, slowest] = taken.each_ref().map(|taken| taken.load(Relaxed));
        assert!((1.8..5.0).contains(&(fast as f64 / slow as f64)), "{fast} beside {slow}");
        assert_eq!(slowest, 0, "a record of two seconds");
    }

    #[test]
    fn the_processor_makes_records_that_are_too_long_for_another_member() {
        let mut group = group(&[1.0, 1.0]);
        let by = |device: &mut Device, records: Range<u64>, _: Advance| match threads(device) {
            2 => Err(GpuError::TooLong { bytes: 2, most: 1 }),
            _ => Ok(records.map(u128::from).collect()),
        };
        let sums = group.sums(10, 0..100, &|_| {}, &by).unwrap();
        assert!(sums.into_iter().eq(0..100));
        assert_eq!(group.devices().count(), 2, "shorter records are not too long");
    }
}
