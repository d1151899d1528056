//! A record thinned for a chart.

use std::ops::Range;

/// The samples to draw: of each of at most `parts` stretches of equal length the least and the largest, in the order of
/// time. `None` stands for missing samples, where a line is interrupted.
pub(crate) fn extremes(values: &[f64], parts: usize) -> Vec<Option<usize>> {
    let mut drawn = Vec::new();
    let interrupt = |drawn: &mut Vec<Option<usize>>, skipped: Range<usize>| {
        if values[skipped].iter().any(|value| !value.is_finite()) && drawn.last() != Some(&None) {
            drawn.push(None);
        }
    };
    for part in stretches(values.len(), parts) {
        let known = || part.clone().filter(|&i| values[i].is_finite());
        let least = known().min_by(|&a, &b| values[a].total_cmp(&values[b]));
        let largest = known().max_by(|&a, &b| values[a].total_cmp(&values[b]));
        let mut both: Vec<usize> = least.into_iter().chain(largest).collect();
        both.sort_unstable();
        both.dedup();
        let mut from = part.start;
        for place in both {
            interrupt(&mut drawn, from..place);
            drawn.push(Some(place));
            from = place + 1;
        }
        interrupt(&mut drawn, from..part.end);
    }
    drawn
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
    fn few_samples_are_all_drawn() {
        assert_eq!(extremes(&[1.0, GAP, 3.0], 10), [Some(0), None, Some(2)]);
        assert_eq!(extremes(&[], 10), []);
        assert_eq!(means(&[1.0, 3.0, GAP, GAP], 2), [(0..2, Some(2.0)), (2..4, None)]);
    }
}
