//! The options that are not dominated in drift, latency and memory.

use crate::analysis::design::constraints::Cost;
use crate::analysis::design::{Design, Filler, Found, Variant};

/// A filler at its best interval, with the values of swept keys.
#[derive(Debug, Clone, Copy)]
pub struct Choice<'a> {
    /// The variant with these values.
    pub variant: &'a Variant,
    /// The filler.
    pub filler: &'a Filler,
    /// Its latency and memory.
    pub cost: Cost,
}

impl Choice<'_> {
    /// Its drift, ″/s.
    pub fn drift(&self) -> Found {
        self.filler.best().drift
    }
}

impl Design {
    /// All fillers of all variants, each at its best interval; none where the study has no fillers.
    pub fn choices(&self) -> Vec<Choice<'_>> {
        let mut all = Vec::new();
        for variant in &self.variants {
            all.extend(
                variant
                    .fillers
                    .iter()
                    .filter_map(|filler| Some(Choice { variant, filler, cost: filler.cost? })),
            );
        }
        all
    }

    /// The choices that no other one beats: none has at most the same drift, latency and memory and less of one of them.
    /// They are in the order of latency, memory and drift.
    pub fn pareto(&self) -> Vec<Choice<'_>> {
        let all = self.choices();
        let merits: Vec<[f64; 3]> = all.iter().map(|choice| self.merits(choice)).collect();
        let mut front: Vec<([f64; 3], Choice)> =
            undominated(&merits).into_iter().map(|place| (merits[place], all[place])).collect();
        front.sort_by(|(a, _), (b, _)| {
            a[1].total_cmp(&b[1]).then(a[2].total_cmp(&b[2])).then(a[0].total_cmp(&b[0]))
        });
        front.into_iter().map(|(_, choice)| choice).collect()
    }

    /// The drift by which it is compared, the latency and the memory.
    fn merits(&self, choice: &Choice) -> [f64; 3] {
        let Cost { latency_s, memory } = choice.cost;
        [self.deciding(choice.filler.best()), latency_s, memory.bytes() as f64]
    }
}

/// The places of the items of which no other one is at least as small in everything and smaller in something.
fn undominated(items: &[[f64; 3]]) -> Vec<usize> {
    let beats = |a: &[f64; 3], b: &[f64; 3]| a != b && a.iter().zip(b).all(|(a, b)| a <= b);
    (0..items.len()).filter(|&place| !items.iter().any(|other| beats(other, &items[place]))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers from 0 to 5 in a fixed order without a pattern.
    fn numbers() -> impl Iterator<Item = f64> {
        let mut state = 1_u64;
        std::iter::from_fn(move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            Some(((state >> 33) % 6) as f64)
        })
    }

    #[test]
    fn the_front_is_what_sorting_out_one_by_one_leaves() {
        let mut numbers = numbers();
        for count in 1..60 {
            let items: Vec<[f64; 3]> =
                (0..count).map(|_| [(); 3].map(|()| numbers.next().unwrap())).collect();
            // Strikes out, item by item, all that it beats.
            let mut left = vec![true; count];
            for a in &items {
                for (place, b) in items.iter().enumerate() {
                    let worse = (0..3).any(|k| b[k] > a[k]);
                    let better = (0..3).any(|k| b[k] < a[k]);
                    if worse && !better {
                        left[place] = false;
                    }
                }
            }
            let expected: Vec<usize> = (0..count).filter(|place| left[*place]).collect();
            assert_eq!(undominated(&items), expected, "{items:?}");
        }
    }
}
