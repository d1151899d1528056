//! A record thinned for a chart.

use std::ops::Range;

/// The samples to draw: of each of at most `parts` stretches of equal length the least and the largest, in the order of
/// time. `None` stands for as many missing samples as a stretch has, where a line is interrupted.
pub(crate) fn extremes(values: &[f64], parts: usize) -> Vec<Option<usize>> {
    let of_part = |part: Range<usize>| {
        let known = || part.clone().filter(|&i| values[i].is_finite());
        let least = known().min_by(|&a, &b| values[a].total_cmp(&values[b]));
        let largest = known().max_by(|&a, &b| values[a].total_cmp(&values[b]));
        let mut both: Vec<usize> = least.into_iter().chain(largest).collect();
        both.sort_unstable();
        both.dedup();
        both
    };
    let length = (values.len() / parts).max(1);
    let has_gaps = values.iter().fold(false, |has, value| has | !value.is_finite());
    let is_gap = |run: &[f64]| run.len() >= length && !run[0].is_finite();
    let mut drawn: Vec<Option<usize>> = Vec::new();
    let mut from = 0;
    for place in stretches(values.len(), parts).flat_map(of_part) {
        if has_gaps && values[from..place].chunk_by(|a, b| a.is_finite() == b.is_finite()).any(is_gap) {
            drawn.push(None);
        }
        drawn.push(Some(place));
        from = place + 1;
    }
    drawn
}

/// The shares of lost samples in at most `parts` stretches of equal length, each with its samples.
pub(crate) fn shares(
    count: usize,
    parts: usize,
    is_lost: impl Fn(usize) -> bool,
) -> Vec<(Range<usize>, f64)> {
    let share = |part: Range<usize>| {
        let lost = part.clone().filter(|&i| is_lost(i)).count();
        (part.clone(), lost as f64 / part.len() as f64)
    };
    stretches(count, parts).map(share).collect()
}

/// The means of at most `parts` stretches of equal length, each with its samples; `None` where all are missing.
pub(crate) fn means(values: &[f64], parts: usize) -> Vec<(Range<usize>, Option<f64>)> {
    let mean = |part: Range<usize>| {
        let known = values[part.clone()].iter().filter(|value| value.is_finite());
        let (count, sum) = known.fold((0.0, 0.0), |(count, sum), value| (count + 1.0, sum + value));
        (part, (count > 0.0).then(|| sum / count))
    };
    stretches(values.len(), parts).map(mean).collect()
}

fn stretches(count: usize, parts: usize) -> impl Iterator<Item = Range<usize>> {
    let parts = parts.min(count);
    (0..parts).map(move |part| part * count / parts..(part + 1) * count / parts)
}

#[cfg(test)]
mod tests {
    use super::*;

    const GAP: f64 = f64::NAN;

    #[test]
    fn spikes_survive_and_gaps_stay_open() {
        let mut values = vec![0.0; 1000];
        (values[333], values[334]) = (7.0, -7.0);
        values[550..650].fill(GAP);
        let drawn = extremes(&values, 10);
        assert!(drawn.contains(&Some(333)) && drawn.contains(&Some(334)), "{drawn:?}");
        assert_eq!(drawn.iter().filter(|place| place.is_none()).count(), 1, "{drawn:?}");
        let known: Vec<usize> = drawn.iter().flatten().copied().collect();
        assert!(known.is_sorted() && known.iter().all(|i| !(550..650).contains(i)), "{known:?}");
    }

    #[test]
    fn a_stretch_without_some_of_its_samples_is_no_gap() {
        let values: Vec<f64> = (0..1000).map(|i| if i % 25 == 7 { GAP } else { i as f64 }).collect();
        assert!(extremes(&values, 10).iter().all(Option::is_some), "{:?}", extremes(&values, 10));
    }

    #[test]
    fn shares_are_the_lost_parts_of_stretches() {
        let shares = shares(1000, 10, |i| i % 25 == 7 || (600..750).contains(&i));
        let expected = [0.04, 0.04, 0.04, 0.04, 0.04, 0.04, 1.0, 0.52, 0.04, 0.04];
        assert_eq!(shares.iter().map(|(_, share)| *share).collect::<Vec<f64>>(), expected);
        assert_eq!(shares[6].0, 600..700);
    }

    #[test]
    fn few_samples_are_all_drawn() {
        assert_eq!(extremes(&[1.0, GAP, 3.0], 10), [Some(0), None, Some(2)]);
        assert_eq!(extremes(&[], 10), []);
        assert_eq!(means(&[1.0, 3.0, GAP, GAP], 2), [(0..2, Some(2.0)), (2..4, None)]);
    }
}
