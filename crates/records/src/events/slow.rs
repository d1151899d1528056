//! Steps, bursts, slow sines, warm-ups and temperature among the slow noise of a record.
//!
//! The record is averaged over blocks. Slow noise imitates slow events, so an event counts only by what it adds to the likelihood
//! of the blocks over that of the best noise without it. The noise is white noise with any proportions of flicker and of a random
//! walk out of a grid; its size is integrated out by profiling. Events enter one after the other, the likeliest first, and leave
//! again if later ones make them superfluous.

use core::f64::consts::TAU;

use rayon::prelude::*;

use crate::allan::Angles;
use crate::fit::PENALTY;
use crate::fit::search::{dot, golden};
use sagnac_theory::allan::{self, Part, flicker};
use sagnac_theory::cholesky;

/// Most and fewest blocks, and the least share of the samples of a block that must be known.
const MAX_BLOCKS: usize = 128;
const MIN_BLOCKS: usize = 20;
const MIN_SHARE: f64 = 0.25;

/// Variances of flicker and of a random walk about their means over the record, relative to the white noise of the blocks.
const FLICKER: [f64; 6] = [0.0, 0.25, 2.0, 16.0, 128.0, 1024.0];
const WALK: [f64; 8] = [0.0, 0.03, 0.25, 2.0, 16.0, 128.0, 1024.0, 8192.0];

/// Fewest samples of a burst within one block: the mean of fewer has the tails of the noise.
const MIN_BURST: usize = 16;
/// Most events.
const MAX_EVENTS: usize = 40;
/// Fewest steps that are telegraph noise.
const TELEGRAPH: usize = 4;
/// Cycles of a sine over the record, in quarters: from a half to three eighths of the number of blocks.
const MIN_QUARTERS: usize = 2;
/// Times of a warm-up.
const TIMES: usize = 12;
/// Increase of minus twice the logarithm of the likelihood by a straight line instead of a temperature up to which they are consistent.
const OF_LINE: f64 = 6.0;
/// Decrease of minus twice the logarithm of the likelihood by two events instead of a random walk, less the price of the walk, from which
/// on they are as good.
const OF_TWO: f64 = 36.0;

/// The course of an event over time, in samples from the start of the record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Course {
    /// A step.
    Step { at: f64 },
    /// A change that ends again.
    Burst { from: f64, to: f64 },
    /// A sine with so many cycles over the record.
    Sine { cycles: f64 },
    /// An exponential with this time.
    WarmUp { time: f64 },
    /// A straight line.
    Line,
    /// The temperature with this number.
    Temperature(usize),
}

impl Course {
    /// Increase of twice the logarithm of the likelihood that is needed. The false alarms of records of the models of
    /// docs/dev/numerics.md were counted.
    fn penalty(self) -> f64 {
        match self {
            Course::Step { .. } | Course::Burst { .. } => 22.0,
            Course::Sine { cycles } => 17.5 + 2.0 * libm::log(4.0 * cycles),
            Course::WarmUp { .. } => 17.0,
            Course::Temperature(_) | Course::Line => 12.0,
        }
    }
}

/// An event with the sizes of its columns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Found {
    pub course: Course,
    /// In ″/s; of a sine those of sine and cosine, of a temperature per K.
    pub sizes: [f64; 2],
}

/// The means of blocks, with the noise that they may have.
pub(crate) struct Slow<'a> {
    angles: &'a Angles,
    temperatures: &'a [Vec<f64>],
    /// Samples of a block.
    m: usize,
    places: Vec<usize>,
    values: Vec<f64>,
    nodes: Vec<Node>,
}

/// A noise.
struct Node {
    has_flicker: bool,
    has_walk: bool,
    /// Inverse of the covariance without its part along a constant, row by row.
    precision: Vec<f64>,
    /// Logarithms of the determinants of the covariance and of its part along a constant.
    constant: f64,
    square: f64,
    towards: Vec<f64>,
}

/// A column with its products with the precision of each noise.
#[derive(Clone)]
struct Column {
    x: Vec<f64>,
    products: Vec<Vec<f64>>,
}

/// A course with its columns.
#[derive(Clone)]
struct Candidate {
    course: Course,
    columns: Vec<Column>,
}

impl<'a> Slow<'a> {
    /// `temperatures` are °C at each increment, NaN where unknown. `None` for short records.
    pub(crate) fn new(angles: &'a Angles, temperatures: &'a [Vec<f64>]) -> Option<Slow<'a>> {
        let samples = angles.len().saturating_sub(1);
        let m = samples.div_ceil(MAX_BLOCKS).max(1);
        let known: Vec<(usize, f64, f64)> = (0..samples / m)
            .filter_map(|place| {
                let (mean, share) = angles.mean_rate(place * m..(place + 1) * m)?;
                (share >= MIN_SHARE).then_some((place, mean, share))
            })
            .collect();
        if known.len() < MIN_BLOCKS {
            return None;
        }
        let places: Vec<usize> = known.iter().map(|block| block.0).collect();
        let values: Vec<f64> = known.iter().map(|block| block.1).collect();
        let shares: Vec<f64> = known.iter().map(|block| block.2).collect();
        let reach = places[places.len() - 1] + 1;
        let noises = [
            Part::angle_random_walk(1.0),
            Part::bias_instability(1.0, flicker::OCTAVES),
            Part::rate_random_walk(1.0),
        ];
        let noises = noises.map(|part| {
            let covariance = allan::block_covariance(&part, angles.step_s, m as u64, reach);
            let scale = about_mean(&covariance, &places);
            covariance.iter().map(|cell| cell / scale).collect::<Vec<f64>>()
        });
        let factors: Vec<[f64; 2]> =
            FLICKER.iter().flat_map(|flicker| WALK.map(|walk| [*flicker, walk])).collect();
        let node = |factors: &[f64; 2]| Node::new(*factors, &noises, &places, &shares, &values);
        let nodes: Option<Vec<Node>> = factors.par_iter().map(node).collect();
        Some(Slow { angles, temperatures, m, places, values, nodes: nodes? })
    }

    /// The events, by the time that they entered; the effect of a temperature first, because a warm-up is one, too. A temperature
    /// that a straight line replaces is none of them, and comes second.
    pub(crate) fn events(&self) -> (Vec<Found>, Option<Found>) {
        let mut found = self.search(vec![], |course| matches!(course, Course::Temperature(_)));
        let line = self.candidate(Course::Line);
        let lack = |found: &[Candidate]| self.least(found, |_| true);
        let is_line = |at: usize| {
            let mut others = found.clone();
            others[at] = line.clone();
            lack(&others) < lack(&found) + OF_LINE
        };
        let as_line = (0..found.len()).find(|&at| is_line(at)).map(|at| found.remove(at));
        let is_other = |course| as_line.as_ref().is_none_or(|line| line.course != course);
        let as_line = as_line.as_ref().and_then(|line| self.sized(std::slice::from_ref(line)).pop());
        (self.sized(&self.search(found, is_other)), as_line)
    }

    /// Events that enter one after the other beside others while the best noise needs them.
    fn search(&self, mut found: Vec<Candidate>, is_meant: impl Fn(Course) -> bool) -> Vec<Candidate> {
        let gain = |found: &[Candidate], one: &Candidate| self.gain(found, one) - one.course.penalty();
        let next = |found: &[Candidate]| {
            let candidates = self.candidates(found, |_| true).into_iter().filter(|one| is_meant(one.course));
            let best = candidates.map(|one| (gain(found, &one), one)).max_by(|a, b| a.0.total_cmp(&b.0));
            best.map(|(gain, one)| (gain, self.refined(found, one)))
        };
        while found.len() < MAX_EVENTS {
            let Some((gain, one)) = next(&found) else { break };
            let mut with = [&found[..], &[one]].concat();
            if gain <= 0.0 {
                // Slow noise explains one of two steps, but not both.
                let Some((_, other)) = next(&with).filter(|(more, _)| gain + more > 0.0) else { break };
                with.push(other);
            }
            found = with;
        }
        let mut at = 0;
        while at < found.len() {
            let mut others = found.clone();
            let one = others.remove(at);
            if gain(&others, &one) < 0.0 {
                found = others;
                at = 0;
            } else {
                at += 1;
            }
        }
        found
    }

    /// Increase of twice the logarithm of the likelihood by a straight line beside some events.
    pub(crate) fn gain_of_line(&self, events: &[Found]) -> f64 {
        let found: Vec<Candidate> = events.iter().map(|event| self.candidate(event.course)).collect();
        if found.iter().any(|other| other.course == Course::Line) {
            return f64::INFINITY;
        }
        self.gain(&found, &self.candidate(Course::Line))
    }

    /// One more event that explains the record, alone or with another one, as well as a random walk, if any does.
    pub(crate) fn instead_of_walk(&self, events: &[Found]) -> Option<Found> {
        let mut found: Vec<Candidate> = events.iter().map(|event| self.candidate(event.course)).collect();
        // A random walk has the price that terms have in fits.
        let with = self.least(&found, |node| node.has_walk) + PENALTY;
        let (lack, one) = self.likeliest_more(&found, |node| !node.has_walk)?;
        found.push(one);
        let is_one = lack < with;
        let of_both = || {
            self.likeliest_more(&found, |node| !node.has_walk)
                .map(|(lack, other)| lack - other.course.penalty())
        };
        (is_one || of_both().is_some_and(|lack| lack + OF_TWO < with))
            .then(|| self.sized(&found).pop())
            .flatten()
    }

    /// One more event that explains a record whose straight line adds nothing to it.
    pub(crate) fn instead_of_line(&self, events: &[Found]) -> Option<Found> {
        let found: Vec<Candidate> = events.iter().map(|event| self.candidate(event.course)).collect();
        let (_, one) = self.likeliest_more(&found, |_| true)?;
        self.sized(&[&found[..], &[one]].concat()).pop()
    }

    /// The event besides a straight line that explains most in addition, with minus twice the logarithm of the likelihood and its penalty.
    fn likeliest_more(
        &self,
        found: &[Candidate],
        are: impl Fn(&Node) -> bool + Copy,
    ) -> Option<(f64, Candidate)> {
        let candidates = self.candidates(found, are).into_iter().filter(|one| one.course != Course::Line);
        let lack = |one: Candidate| {
            let with = [found, std::slice::from_ref(&one)].concat();
            (self.least(&with, are) + one.course.penalty(), one)
        };
        candidates.map(lack).min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Minus twice the logarithm of the likelihood with some events, for the best of the noises that `are` meant.
    fn least(&self, found: &[Candidate], are: impl Fn(&Node) -> bool) -> f64 {
        let places = (0..self.nodes.len()).filter(|&at| are(&self.nodes[at]));
        places.map(|at| self.lack(found, at)).fold(f64::INFINITY, f64::min)
    }

    fn lack(&self, found: &[Candidate], at: usize) -> f64 {
        let node = &self.nodes[at];
        let left = self.solved(found, at).map_or(f64::INFINITY, |(_, left)| left);
        node.constant + (self.values.len() - 1) as f64 * libm::log(left.max(f64::MIN_POSITIVE))
    }

    /// The sizes of the columns of some events, and the weighted square of what they leave.
    fn solved(&self, found: &[Candidate], at: usize) -> Option<(Vec<f64>, f64)> {
        let node = &self.nodes[at];
        let columns: Vec<&Column> = found.iter().flat_map(|candidate| &candidate.columns).collect();
        let lengths: Vec<f64> =
            columns.iter().map(|column| libm::sqrt(dot(&column.x, &column.products[at]))).collect();
        let cosine =
            |i: usize, j: usize| dot(&columns[i].x, &columns[j].products[at]) / (lengths[i] * lengths[j]);
        let factor = cholesky::definite(columns.len(), cosine)?;
        if factor.iter().enumerate().any(|(i, row)| row[i] * row[i] < 1e-8) {
            return None;
        }
        let towards: Vec<f64> = columns
            .iter()
            .zip(&lengths)
            .map(|(column, length)| dot(&column.x, &node.towards) / length)
            .collect();
        let sizes = cholesky::solve(&factor, towards.clone());
        let left = (node.square - dot(&sizes, &towards)).max(1e-24 * node.square);
        Some((sizes.iter().zip(&lengths).map(|(size, length)| size / length).collect(), left))
    }

    fn gain(&self, found: &[Candidate], candidate: &Candidate) -> f64 {
        let with = [found, std::slice::from_ref(candidate)].concat();
        self.least(found, |_| true) - self.least(&with, |_| true)
    }

    fn sized(&self, found: &[Candidate]) -> Vec<Found> {
        let places = 0..self.nodes.len();
        let best = places.min_by(|a, b| self.lack(found, *a).total_cmp(&self.lack(found, *b)));
        let Some((sizes, _)) = best.and_then(|at| self.solved(found, at)) else { return vec![] };
        let mut sizes = sizes.into_iter();
        let mut of = |candidate: &Candidate| {
            let mut taken = [0.0; 2];
            taken
                .iter_mut()
                .zip(&candidate.columns)
                .for_each(|(size, _)| *size = sizes.next().unwrap_or(0.0));
            Found { course: candidate.course, sizes: taken }
        };
        found.iter().map(&mut of).collect()
    }

    /// The likeliest candidate of each kind beside those that were found, under several of the noises that are allowed.
    fn candidates(&self, found: &[Candidate], are: impl Fn(&Node) -> bool) -> Vec<Candidate> {
        let allowed = || (0..self.nodes.len()).filter(|&at| are(&self.nodes[at]));
        let best = |places: &mut dyn Iterator<Item = usize>| {
            places.min_by(|a, b| self.lack(found, *a).total_cmp(&self.lack(found, *b)))
        };
        let mut noises = vec![
            best(&mut allowed()),
            best(&mut allowed().filter(|&at| !self.nodes[at].has_walk)),
            best(&mut allowed().filter(|&at| !self.nodes[at].has_walk && !self.nodes[at].has_flicker)),
        ];
        noises.dedup();
        let mut courses: Vec<Course> = Vec::new();
        for at in noises.into_iter().flatten() {
            for course in self.likeliest(found, at) {
                if !courses.contains(&course) && found.iter().all(|other| other.course != course) {
                    courses.push(course);
                }
            }
        }
        courses.into_par_iter().map(|course| self.candidate(course)).collect()
    }

    /// The course of each kind with the largest decrease of the weighted square under one noise.
    fn likeliest(&self, found: &[Candidate], at: usize) -> Vec<Course> {
        let count = self.values.len();
        let Some(matrix) = self.beside(found, at) else { return vec![] };
        let residual = product(&matrix, &self.values);
        let times = |x: &[f64]| product(&matrix, x);
        // Steps, from the last block on.
        let (mut sum, mut square) = (0.0, 0.0);
        let (mut step, mut burst) = ((0.0, 0), (0.0, 0));
        for j in (1..count).rev() {
            let row = &matrix[j * count..(j + 1) * count];
            sum += residual[j];
            square += row[j] + 2.0 * row[j + 1..].iter().sum::<f64>();
            let of_step = sum * sum / square;
            if of_step > step.0 && square > 0.0 {
                step = (of_step, j);
            }
            let of_burst = residual[j] * residual[j] / row[j];
            if of_burst > burst.0 && row[j] > 0.0 {
                burst = (of_burst, j);
            }
        }
        let start = |j: usize| (self.places[j] * self.m) as f64;
        let mut courses = vec![Course::Step { at: start(step.1.max(1)) }, Course::Line];
        if self.m >= MIN_BURST {
            courses.push(Course::Burst { from: start(burst.1), to: start(burst.1) + self.m as f64 });
        }
        let cycles = (MIN_QUARTERS..3 * count / 2).map(|quarters| 0.25 * quarters as f64);
        let of_sine = |cycles: f64| {
            let [s, c] = self.sine(cycles);
            let [ms, mc] = [times(&s), times(&c)];
            let (ss, sc, cc) = (dot(&s, &ms), dot(&s, &mc), dot(&c, &mc));
            let (rs, rc) = (dot(&s, &residual), dot(&c, &residual));
            let determinant = ss * cc - sc * sc;
            let gain = (cc * rs * rs - 2.0 * sc * rs * rc + ss * rc * rc) / determinant;
            (if determinant > 1e-6 * ss * cc { gain } else { 0.0 }, cycles)
        };
        let all: Vec<f64> = cycles.collect();
        let sines: Vec<(f64, f64)> = all.into_par_iter().map(of_sine).collect();
        let best = sines.into_iter().max_by(|a, b| a.0.total_cmp(&b.0));
        courses.extend(best.map(|(_, cycles)| Course::Sine { cycles }));
        let one = |course: Course| {
            let x = self.columns(course).swap_remove(0);
            let (product, square) = (dot(&x, &residual), dot(&x, &times(&x)));
            (if square > 0.0 { product * product / square } else { 0.0 }, course)
        };
        let length = (count * self.m) as f64;
        let time =
            |i: usize| self.m as f64 * libm::pow(0.5 * length / self.m as f64, i as f64 / (TIMES - 1) as f64);
        let warm_up =
            (0..TIMES).map(|i| one(Course::WarmUp { time: time(i) })).max_by(|a, b| a.0.total_cmp(&b.0));
        courses.extend(warm_up.map(|(_, course)| course));
        courses.extend((0..self.temperatures.len()).map(Course::Temperature));
        courses
    }

    /// The precision under one noise without its part along some events.
    fn beside(&self, found: &[Candidate], at: usize) -> Option<Vec<f64>> {
        let count = self.values.len();
        let mut matrix = self.nodes[at].precision.clone();
        for column in found.iter().flat_map(|candidate| &candidate.columns) {
            let product = product(&matrix, &column.x);
            let square = dot(&product, &column.x);
            if square <= 0.0 {
                return None;
            }
            for (row, a) in matrix.chunks_mut(count).zip(&product) {
                row.iter_mut().zip(&product).for_each(|(cell, b)| *cell -= a * b / square);
            }
        }
        Some(matrix)
    }

    fn candidate(&self, course: Course) -> Candidate {
        let of = |x: Vec<f64>| {
            let products = self.nodes.iter().map(|node| product(&node.precision, &x)).collect();
            Column { x, products }
        };
        Candidate { course, columns: self.columns(course).into_iter().map(of).collect() }
    }

    /// The means of a course over the blocks.
    fn columns(&self, course: Course) -> Vec<Vec<f64>> {
        let m = self.m as f64;
        let over =
            |at: &dyn Fn(f64) -> f64| vec![self.places.iter().map(|&place| at(place as f64 * m)).collect()];
        let behind = |at: f64, start: f64| ((start + m - at) / m).clamp(0.0, 1.0);
        match course {
            Course::Step { at } => over(&|start| behind(at, start)),
            Course::Burst { from, to } => over(&|start| behind(from, start) - behind(to, start)),
            Course::Sine { cycles } => self.sine(cycles).to_vec(),
            Course::WarmUp { time } => {
                over(&|start| time / m * (libm::exp(-start / time) - libm::exp(-(start + m) / time)))
            }
            Course::Line => over(&|start| (start + 0.5 * m) / self.angles.len() as f64),
            Course::Temperature(which) => {
                let mean =
                    |&place: &usize| mean_of(&self.temperatures[which][place * self.m..(place + 1) * self.m]);
                let means: Vec<f64> = self.places.iter().map(mean).collect();
                let known = mean_of(&means);
                vec![means.iter().map(|x| if x.is_nan() { 0.0 } else { x - known }).collect()]
            }
        }
    }

    fn sine(&self, cycles: f64) -> [Vec<f64>; 2] {
        let per_sample = TAU * cycles / (self.angles.len() - 1) as f64;
        let half = 0.5 * per_sample * self.m as f64;
        let attenuation = if half > 0.0 { libm::sin(half) / half } else { 1.0 };
        let phase = |place: &usize| per_sample * (*place as f64 + 0.5) * self.m as f64;
        let over =
            |of: fn(f64) -> f64| self.places.iter().map(|place| attenuation * of(phase(place))).collect();
        [over(libm::sin), over(libm::cos)]
    }

    /// A candidate with its time or frequency between those of the grid.
    fn refined(&self, found: &[Candidate], candidate: Candidate) -> Candidate {
        let course = match candidate.course {
            Course::Step { at } => Course::Step { at: self.edge(at) },
            Course::Burst { from, to } => {
                let (first, last) = (self.edge(from), self.edge(to));
                Course::Burst { from: first, to: last.max(first + 1.0) }
            }
            Course::Sine { cycles } => {
                let lack = |cycles: f64| {
                    let one = self.candidate(Course::Sine { cycles });
                    self.least(&[found, &[one]].concat(), |_| true)
                };
                Course::Sine { cycles: golden((cycles - 0.25).max(0.4), cycles + 0.25, 12, lack) }
            }
            Course::WarmUp { time } => {
                let lack = |logarithm: f64| {
                    let one = self.candidate(Course::WarmUp { time: libm::exp(logarithm) });
                    self.least(&[found, &[one]].concat(), |_| true)
                };
                let middle = libm::log(time);
                Course::WarmUp { time: libm::exp(golden(middle - 0.5, middle + 0.5, 12, lack)) }
            }
            other => other,
        };
        let refined = self.candidate(course);
        let of =
            |candidate: &Candidate| self.least(&[found, std::slice::from_ref(candidate)].concat(), |_| true);
        // Samples tell the place of a step better than the means of blocks.
        let is_better = matches!(course, Course::Step { .. }) || of(&refined) < of(&candidate);
        if is_better { refined } else { candidate }
    }

    /// The sample within a block of `at` before and behind which the means differ most.
    fn edge(&self, at: f64) -> f64 {
        let last = self.angles.len() - 1;
        let start = (at as usize).saturating_sub(self.m + self.m / 2);
        let end = (at as usize + self.m + self.m / 2).min(last);
        let rates = self.angles.rates(start..end);
        let (count, sum) =
            rates.iter().filter(|x| x.is_finite()).fold((0.0, 0.0), |(n, s), x| (n + 1.0, s + x));
        let (mut before, mut partial, mut best) = (0.0, 0.0, (0.0, at));
        for (i, rate) in rates.iter().enumerate() {
            if before > 0.0 && before < count {
                let difference = partial / before - (sum - partial) / (count - before);
                let square = before * (count - before) / count * difference * difference;
                if square > best.0 {
                    best = (square, (start + i) as f64);
                }
            }
            if rate.is_finite() {
                before += 1.0;
                partial += rate;
            }
        }
        best.1
    }

    /// The rate of some events at each sample, ″/s.
    pub(crate) fn rates(&self, events: &[Found]) -> Vec<f64> {
        let mut rates = vec![0.0; self.angles.len() - 1];
        for event in events {
            let mean = match event.course {
                Course::Temperature(which) => event.sizes[0] * mean_of(&self.temperatures[which]),
                _ => 0.0,
            };
            let rate = |i: usize| Some(self.rate(event, i) - mean).filter(|x| x.is_finite()).unwrap_or(0.0);
            rates.par_iter_mut().enumerate().for_each(|(i, sum)| *sum += rate(i));
        }
        rates
    }

    /// The rate of an event at a sample, ″/s, that of a temperature up to a constant.
    fn rate(&self, &Found { course, sizes }: &Found, i: usize) -> f64 {
        let t = i as f64 + 0.5;
        match course {
            Course::Step { at } => sizes[0] * f64::from(t > at),
            Course::Burst { from, to } => sizes[0] * f64::from(t > from && t < to),
            Course::Sine { cycles } => {
                let (sin, cos) = libm::sincos(TAU * cycles * t / (self.angles.len() - 1) as f64);
                sizes[0] * sin + sizes[1] * cos
            }
            Course::WarmUp { time } => sizes[0] * libm::exp(-t / time),
            Course::Line => 0.0,
            Course::Temperature(which) => sizes[0] * self.temperatures[which][i],
        }
    }

    /// Whether steps are so many that they are telegraph noise.
    pub(crate) fn is_telegraph(events: &[Found]) -> bool {
        events.iter().filter(|event| matches!(event.course, Course::Step { .. })).count() >= TELEGRAPH
    }
}

impl Node {
    fn new(
        [flicker, walk]: [f64; 2],
        [white, others @ ..]: &[Vec<f64>; 3],
        places: &[usize],
        shares: &[f64],
        values: &[f64],
    ) -> Option<Node> {
        let count = places.len();
        let slow = |lag: usize| flicker * others[0][lag] + walk * others[1][lag];
        let reach = places[count - 1] - places[0];
        // A constant in all cells, which contrasts do not see.
        let level = (0..=reach).map(|lag| libm::fabs(slow(lag))).fold(white[0], f64::max);
        let cell = |i: usize, j: usize| {
            let lag = places[i].abs_diff(places[j]);
            let own = if i == j { white[0] / shares[i] } else { white[lag] };
            own + slow(lag) + 2.0 * level
        };
        let factor = cholesky::definite(count, cell)?;
        let determinant: f64 = factor.iter().enumerate().map(|(i, row)| 2.0 * libm::log(row[i])).sum();
        let mut precision = cholesky::inverse(&factor);
        let sums: Vec<f64> = precision.chunks(count).map(|row| row.iter().sum()).collect();
        let whole: f64 = sums.iter().sum();
        for (row, a) in precision.chunks_mut(count).zip(&sums) {
            row.iter_mut().zip(&sums).for_each(|(cell, b)| *cell -= a * b / whole);
        }
        let towards = product(&precision, values);
        Some(Node {
            has_flicker: flicker > 0.0,
            has_walk: walk > 0.0,
            constant: determinant + libm::log(whole),
            square: dot(&towards, values),
            towards,
            precision,
        })
    }
}

/// A symmetric matrix times a column.
fn product(matrix: &[f64], x: &[f64]) -> Vec<f64> {
    let mut sums = vec![0.0; x.len()];
    for (row, x) in matrix.chunks(x.len()).zip(x) {
        sums.iter_mut().zip(row).for_each(|(sum, cell)| *sum += cell * x);
    }
    sums
}

/// The mean of those that are known.
fn mean_of(x: &[f64]) -> f64 {
    let (count, sum) = x.iter().filter(|x| x.is_finite()).fold((0.0, 0.0), |(n, s), x| (n + 1.0, s + x));
    sum / count
}

/// The variance of a noise about its mean over the blocks.
fn about_mean(noise: &[f64], places: &[usize]) -> f64 {
    let sum: f64 = places.iter().flat_map(|a| places.iter().map(|b| noise[a.abs_diff(*b)])).sum();
    noise[0] - sum / (places.len() * places.len()) as f64
}
