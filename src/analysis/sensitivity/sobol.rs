//! Sobol' indices of a function of independent inputs, with intervals.
//!
//! The function is evaluated at points A and B of a scrambled Sobol' sequence and, for each input, at A with that input
//! taken from B. The first-order index of an input is the part of the variance that the input explains alone, the total
//! index the part that it explains alone and together with others. The first is estimated by (b) and the second by (f)
//! of table 2 in Saltelli et al., Computer Physics Communications 181 (2010) 259, on answers less their mean. Of the
//! [`PARTS`] parts of the samples, each has a scramble of its own, so that leaving out each in turn gives intervals.

use crate::analysis::design::Found;
use crate::analysis::design::optimum::{PARTS, T_95, jackknife};

/// Most samples of a part, which the sequence has.
pub(crate) const MAX_OF_PART: u64 = 1 << 16;

/// The indices of one input.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Index {
    /// Part of the variance that the input explains alone.
    pub first: Found,
    /// Part of the variance that the input explains alone and together with others.
    pub total: Found,
}

/// The indices of all inputs, with the distribution of the answer.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Indices {
    /// Indices in the order of the inputs.
    pub inputs: Vec<Index>,
    /// Mean of the answer.
    pub mean: Found,
    /// Standard deviation of the answer.
    pub sd: Found,
    /// The answers at the points A and B, by part.
    pub answers: Vec<Vec<f64>>,
}

/// The number of samples, at least `asked`, for which all parts have the same power of two.
pub(crate) fn samples(asked: u64) -> u64 {
    asked.div_ceil(PARTS).next_power_of_two().min(MAX_OF_PART) * PARTS
}

/// The indices of a function of `inputs` numbers from 0 to 1, from its values at the [`points`] of each part. `None` where the
/// answer is the same everywhere.
pub(crate) fn indices(inputs: usize, parts: &[Vec<f64>]) -> Option<Indices> {
    let width = inputs + 2;
    let answers: Vec<Vec<f64>> = parts
        .iter()
        .map(|part| part.chunks_exact(width).flat_map(|sample| [sample[0], sample[1]]).collect())
        .collect();
    let all: Vec<f64> = answers.concat();
    if all.iter().all(|y| *y == all[0]) {
        return None;
    }
    let middle = all.iter().sum::<f64>() / all.len() as f64;
    let sums: Vec<Sums> = parts.iter().map(|part| Sums::new(part, width, middle)).collect();
    let found = |quantity: &dyn Fn(&Sums) -> f64| with_interval(&sums, width, quantity);
    let index = |input: usize| Index {
        first: found(&|sums| sums.first[input] / sums.samples / sums.variance()),
        total: found(&|sums| 0.5 * sums.total[input] / sums.samples / sums.variance()),
    };
    Some(Indices {
        inputs: (0..inputs).map(index).collect(),
        mean: found(&|sums| middle + sums.mean()),
        sd: found(&|sums| libm::sqrt(sums.variance())),
        answers,
    })
}

/// The part of some answers for which a statement holds, with its interval from the parts.
pub(crate) fn share(answers: &[Vec<f64>], holds: impl Fn(f64) -> bool) -> Found {
    let counted = answers.iter().map(|part| (part.iter().filter(|y| holds(**y)).count(), part.len()));
    let counted: Vec<(usize, usize)> = counted.collect();
    let of = |left_out: Option<usize>| {
        let rest = counted.iter().enumerate().filter(|(place, _)| Some(*place) != left_out);
        let (held, all) = rest.fold((0, 0), |(held, all), (_, part)| (held + part.0, all + part.1));
        held as f64 / all as f64
    };
    around(of(None), &(0..counted.len()).map(|place| of(Some(place))).collect::<Vec<f64>>())
}

/// The points of a part of `samples`: for each sample A, B, and A with each input in turn taken from B.
pub(crate) fn points(inputs: usize, samples: u64, part: u64, seed: u64) -> Vec<Vec<f64>> {
    // Every part of every seed has a scramble of its own; of larger seeds both halves count.
    let scramble = (seed.wrapping_mul(PARTS) + part) as u32 ^ (seed >> 32) as u32;
    let at = |sample: u64, dimension: usize| {
        // In the middle of its 2^−24, so never 0, at which a normal input would be infinite.
        f64::from(sobol_burley::sample(sample as u32, dimension as u32, scramble)) + libm::exp2(-25.0)
    };
    let of_sample = |sample: u64| {
        let row = |from: usize| (0..inputs).map(|input| at(sample, from + input)).collect::<Vec<f64>>();
        let (a, b) = (row(0), row(inputs));
        let mixed = |input: usize| {
            let mut point = a.clone();
            point[input] = b[input];
            point
        };
        let mixed: Vec<Vec<f64>> = (0..inputs).map(mixed).collect();
        [a, b].into_iter().chain(mixed).collect::<Vec<Vec<f64>>>()
    };
    (0..samples / PARTS).flat_map(of_sample).collect()
}

/// Sums over samples, of answers y less one common number.
#[derive(Debug, Clone)]
struct Sums {
    samples: f64,
    /// Σ y and Σ y² over A and B.
    y: f64,
    square: f64,
    /// Σ y_B (y_AB − y_A) for each input.
    first: Vec<f64>,
    /// Σ (y_A − y_AB)² for each input.
    total: Vec<f64>,
}

impl Sums {
    fn none(width: usize) -> Sums {
        let of_inputs = vec![0.0; width - 2];
        Sums { samples: 0.0, y: 0.0, square: 0.0, first: of_inputs.clone(), total: of_inputs }
    }

    fn new(part: &[f64], width: usize, middle: f64) -> Sums {
        let mut sums = Sums::none(width);
        for sample in part.chunks_exact(width) {
            let [a, b] = [sample[0] - middle, sample[1] - middle];
            sums.samples += 1.0;
            sums.y += a + b;
            sums.square += a * a + b * b;
            for (input, mixed) in sample[2..].iter().enumerate() {
                let apart = mixed - middle - a;
                sums.first[input] += b * apart;
                sums.total[input] += apart * apart;
            }
        }
        sums
    }

    fn add(mut self, other: &Sums) -> Sums {
        let add = |own: &mut Vec<f64>, other: &[f64]| own.iter_mut().zip(other).for_each(|(a, b)| *a += b);
        self.samples += other.samples;
        self.y += other.y;
        self.square += other.square;
        add(&mut self.first, &other.first);
        add(&mut self.total, &other.total);
        self
    }

    fn mean(&self) -> f64 {
        self.y / (2.0 * self.samples)
    }

    fn variance(&self) -> f64 {
        self.square / (2.0 * self.samples) - self.mean() * self.mean()
    }
}

/// A quantity of all parts together, with its interval from leaving out each part in turn.
fn with_interval(parts: &[Sums], width: usize, quantity: &dyn Fn(&Sums) -> f64) -> Found {
    let without = |left_out: Option<usize>| {
        let rest = parts.iter().enumerate().filter(|(place, _)| Some(*place) != left_out);
        quantity(&rest.fold(Sums::none(width), |sum, (_, part)| sum.add(part)))
    };
    around(without(None), &(0..parts.len()).map(|place| without(Some(place))).collect::<Vec<f64>>())
}

fn around(value: f64, replicates: &[f64]) -> Found {
    let half = T_95 * jackknife(replicates);
    Found { value, interval: Some((value - half, value + half)) }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::PI;

    use super::*;

    /// Ishigami's function sin x + 7 sin² y + z⁴/10 sin x of numbers from −π to π.
    fn ishigami(point: &[f64]) -> f64 {
        let [x, y, z] = [0, 1, 2].map(|input| PI * (2.0 * point[input] - 1.0));
        let sine = libm::sin(y);
        libm::sin(x) * (1.0 + 0.1 * libm::pow(z, 4.0)) + 7.0 * sine * sine
    }

    fn of(samples: u64, seed: u64) -> Indices {
        let part = |part| points(3, samples, part, seed).iter().map(|point| ishigami(point)).collect();
        indices(3, &(0..PARTS).map(part).collect::<Vec<Vec<f64>>>()).unwrap()
    }

    /// First-order and total indices, mean and standard deviation in closed form.
    fn exact() -> ([f64; 3], [f64; 3], [f64; 2]) {
        let (a, b, fourth) = (7.0, 0.1, libm::pow(PI, 4.0));
        let alone = [0.5 * (1.0 + 0.2 * b * fourth).powi(2), a * a / 8.0, 0.0];
        let both = b * b * fourth * fourth * (1.0 / 18.0 - 1.0 / 50.0);
        let variance = alone.iter().sum::<f64>() + both;
        let totals = [alone[0] + both, alone[1], both];
        (alone.map(|part| part / variance), totals.map(|part| part / variance), [0.5 * a, variance.sqrt()])
    }

    fn contains(found: Found, exact: f64) -> bool {
        found.interval.is_some_and(|(low, high)| low <= exact && exact <= high)
    }

    #[test]
    fn indices_of_ishigamis_function_are_those_of_the_closed_form() {
        let (found, (first, total, [mean, sd])) = (of(8192, 1), exact());
        for (input, index) in found.inputs.iter().enumerate() {
            for (found, exact) in [(index.first, first[input]), (index.total, total[input])] {
                println!("{input}: {found:?}, exactly {exact}");
                assert!(contains(found, exact), "{input}: {found:?}, not {exact}");
                assert!((found.value - exact).abs() < 0.02, "{input}: {found:?}, not {exact}");
            }
        }
        assert!((found.mean.value - mean).abs() < 0.01 && (found.sd.value - sd).abs() < 0.01, "{found:?}");
    }

    /// Of 200 seeds, 95 % within 1.3 standard deviations of their number.
    #[test]
    fn intervals_contain_the_closed_form_in_95_of_100_seeds() {
        let (first, total, [mean, sd]) = exact();
        let mut counts = [0; 8];
        for seed in 1..=200 {
            let found = of(1024, seed);
            let inputs = || found.inputs.iter().enumerate();
            let firsts = inputs().map(|(input, index)| contains(index.first, first[input]));
            let totals = inputs().map(|(input, index)| contains(index.total, total[input]));
            let ends = [contains(found.mean, mean), contains(found.sd, sd)];
            let all = firsts.chain(totals).chain(ends);
            counts.iter_mut().zip(all).for_each(|(count, is_within)| *count += usize::from(is_within));
        }
        println!("of 200: {counts:?}");
        assert!(counts.iter().all(|count| (186..=194).contains(count)), "of 200: {counts:?}");
    }

    #[test]
    fn an_answer_that_depends_on_nothing_has_no_indices() {
        let part = |part| vec![5.0; points(2, 64, part, 1).len()];
        assert_eq!(indices(2, &(0..PARTS).map(part).collect::<Vec<Vec<f64>>>()), None);
    }
}
