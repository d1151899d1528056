//! Published values, and properties of whole curves.

use super::*;

macro_rules! data {
    ($name:literal) => {
        include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/allan/", $name))
    };
}

/// The frequency record of NIST SP 1065, table 30: n(i + 1) = 16807 n(i) mod 2^31 − 1, over 2^31 − 1.
fn nbs_set(count: usize) -> Vec<f64> {
    let numbers = std::iter::successors(Some(1_234_567_890_u64), |n| Some(16807 * n % 2_147_483_647));
    numbers.map(|n| n as f64 / 2_147_483_647.0).take(count).collect()
}

fn value(angles: &Angles, deviation: Deviation, m: usize) -> f64 {
    curve(angles, deviation, &[m], 0.95)[0].value.unwrap()
}

#[test]
fn the_nbs_set_of_1000_points_has_the_published_deviations_to_all_digits() {
    let angles = Angles::from_increments(&nbs_set(1000), 1.0, 1.0, Trend::None);
    let mut rows = 0;
    for line in data!("nbs14_1000.csv").lines().skip(1) {
        let [name, m, expected] = line.split(',').collect::<Vec<_>>()[..] else { panic!("{line}") };
        let found = value(&angles, name.parse().unwrap(), m.parse().unwrap());
        // Printed numbers are cut or rounded at the seventh digit: hdev at 100 is 3.91086056e-2 in exact arithmetic and
        // printed as 3.910860e-2.
        let (expected, unit) = (expected.parse::<f64>().unwrap(), format!("1e{}", &expected[9..]));
        let unit = 1e-6 * unit.parse::<f64>().unwrap();
        assert!((found - expected).abs() < 0.62 * unit, "{name}, m = {m}: {found}, not {expected}");
        rows += 1;
    }
    assert_eq!(rows, 18);
}

/// A row of Stable32's output.
struct Row {
    m: usize,
    tau_s: f64,
    terms: u64,
    alpha: i32,
    lower: f64,
    value: f64,
    upper: f64,
}

fn rows(text: &str) -> Vec<Row> {
    let numbers = |line: &str| line.split_whitespace().map(|x| x.parse().unwrap()).collect::<Vec<f64>>();
    text.lines()
        .filter(|line| !line.starts_with('#') && !line.trim().is_empty())
        .map(|line| match numbers(line)[..] {
            [m, tau_s, terms, alpha, lower, value, upper] => {
                Row { m: m as usize, tau_s, terms: terms as u64, alpha: alpha as i32, lower, value, upper }
            }
            _ => panic!("{line}"),
        })
        .collect()
}

#[test]
fn phase_dat_has_stable32s_deviations_bounds_terms_and_noise() {
    let phase: Vec<f64> = data!("PHASE.DAT")
        .lines()
        .filter(|line| !line.starts_with('#'))
        .map(|line| line.trim().parse().unwrap())
        .collect();
    assert_eq!(phase.len(), 1001);
    let angles = Angles::from_angles(&phase, 1.0, 1.0, Trend::None);
    let outputs = [
        (Deviation::Adev, data!("stable32_phase_dat_adev_octave.txt")),
        (Deviation::Oadev, data!("stable32_phase_dat_oadev_octave.txt")),
        (Deviation::Mdev, data!("stable32_phase_dat_mdev_octave.txt")),
        (Deviation::Tdev, data!("stable32_phase_dat_tdev_octave.txt")),
        (Deviation::Hdev, data!("stable32_phase_dat_hdev_octave.txt")),
        (Deviation::Ohdev, data!("stable32_phase_dat_ohdev_octave.txt")),
    ];
    for (deviation, text) in outputs {
        let rows = rows(text);
        assert_eq!(rows.len(), 8);
        let factors: Vec<usize> = rows.iter().map(|row| row.m).collect();
        for (row, point) in rows.iter().zip(curve(&angles, deviation, &factors, 0.683)) {
            let place = format!("{deviation}, m = {}", row.m);
            let (lower, upper) = point.interval.unwrap();
            assert_eq!((point.tau_s, point.terms), (row.tau_s, row.terms), "{place}");
            let noise = point.noise.unwrap();
            // From 64 on, there are fewer than 30 groups.
            assert_eq!((noise.alpha, noise.carried), (row.alpha, row.m >= 64), "{place}");
            for (found, expected, bound) in
                [(point.value.unwrap(), row.value, 5e-5), (lower, row.lower, 1e-3), (upper, row.upper, 1e-3)]
            {
                assert!((found / expected - 1.0).abs() < bound, "{place}: {found}, not {expected}");
            }
        }
    }
}

#[test]
fn a_mean_of_a_million_times_the_noise_changes_no_curve() {
    let noise: Vec<f64> = nbs_set(100_000).iter().map(|y| (y - 0.5) * libm::sqrt(12.0)).collect();
    let offset: Vec<f64> = noise.iter().map(|y| 1e6 + y).collect();
    let [plain, offset] =
        [noise, offset].map(|rates| Angles::from_increments(&rates, 0.01, 0.01, Trend::None));
    for deviation in Deviation::ALL {
        let factors = Taus::Octave.factors(plain.len(), 0.01, deviation).unwrap();
        let curves = [&plain, &offset].map(|angles| curve(angles, deviation, &factors, 0.95));
        for (a, b) in curves[0].iter().zip(&curves[1]) {
            let error = b.value.unwrap() / a.value.unwrap() - 1.0;
            assert!(error.abs() < 1e-9, "{deviation}, m = {}: {error:e}", a.m);
        }
    }
}

#[test]
fn gaps_leave_out_terms_and_keep_values_and_intervals() {
    let rates = nbs_set(20_000);
    let gapped: Vec<f64> =
        rates.iter().enumerate().map(|(i, y)| if i % 1000 < 7 { f64::NAN } else { *y }).collect();
    let [whole, gapped] = [rates, gapped].map(|y| Angles::from_increments(&y, 1.0, 1.0, Trend::None));
    assert_eq!(gapped.missing(), 140);
    for deviation in Deviation::ALL {
        let curves = [&whole, &gapped].map(|angles| curve(angles, deviation, &[1, 10, 100], 0.95));
        for (a, b) in curves[0].iter().zip(&curves[1]) {
            assert!(b.terms < a.terms && b.terms > a.terms / 2, "{deviation}: {} of {}", b.terms, a.terms);
            let ratio = b.value.unwrap() / a.value.unwrap();
            assert!((0.8..1.25).contains(&ratio), "{deviation}, m = {}: {ratio}", a.m);
            let width =
                |point: &Point| point.interval.map(|(lower, upper)| libm::log(upper / lower)).unwrap();
            assert!(width(b) > width(a), "{deviation}, m = {}: gaps narrow the interval", a.m);
            assert_eq!(b.noise.unwrap().alpha, 0, "{deviation}, m = {}", a.m);
        }
    }
    // Longer than any stretch between gaps.
    for deviation in Deviation::ALL {
        let [a, b] = [&whole, &gapped].map(|angles| curve(angles, deviation, &[600], 0.95)[0]);
        let ratio = b.value.unwrap() / a.value.unwrap();
        assert!((0.95..1.05).contains(&ratio) && b.terms > a.terms / 2, "{deviation}: {ratio}");
        assert!((0.97..1.0).contains(&b.left), "{deviation}: {}", b.left);
    }
}

/// A mean over half of the samples of white noise has twice the variance, which must not show in the curve.
#[test]
fn many_single_losses_neither_end_a_curve_nor_change_it() {
    let mut numbers = nbs_set(40_000).into_iter();
    let losses: Vec<bool> = numbers.by_ref().take(20_000).map(|y| y < 0.2).collect();
    let rates: Vec<f64> = numbers.collect();
    for alpha in [0, -2] {
        let mut sum = 0.0;
        let noise: Vec<f64> = rates
            .iter()
            .map(|y| {
                sum += y - 0.5;
                if alpha == 0 { *y } else { y + 0.03 * sum }
            })
            .collect();
        let lossy: Vec<f64> =
            noise.iter().zip(&losses).map(|(y, is_lost)| if *is_lost { f64::NAN } else { *y }).collect();
        let [whole, lossy] = [noise, lossy].map(|y| Angles::from_increments(&y, 1.0, 1.0, Trend::None));
        for deviation in Deviation::ALL {
            for m in [1, 4, 32, 512] {
                let [a, b] = [&whole, &lossy].map(|angles| curve(angles, deviation, &[m], 0.999)[0]);
                let ratio = b.value.unwrap() / a.value.unwrap();
                let (low, high) = b.interval.unwrap();
                let value = a.value.unwrap();
                assert!(low < value && value < high, "α = {alpha}, {deviation}, m = {m}: {ratio}");
                assert!((0.12..1.01).contains(&b.left), "α = {alpha}, {deviation}, m = {m}: {}", b.left);
            }
        }
    }
}

/// Records of one power law: white noise summed or differenced.
fn power_law(alpha: i32, count: usize) -> Vec<f64> {
    let mut rates: Vec<f64> = nbs_set(count + 2).iter().map(|y| y - 0.5).collect();
    match alpha {
        2 => rates = rates.windows(2).map(|pair| pair[1] - pair[0]).collect(),
        -2 => {
            let mut sum = 0.0;
            rates.iter_mut().for_each(|y| {
                sum += *y;
                *y = sum;
            });
        }
        _ => {}
    }
    rates.truncate(count);
    rates
}

#[test]
fn the_noise_of_each_power_law_is_identified_with_gaps_and_without() {
    for alpha in [2, 0, -2] {
        let mut rates = power_law(alpha, 50_000);
        for gapped in [false, true] {
            if gapped {
                (0..50_000).step_by(5000).for_each(|i| rates[i] = f64::NAN);
            }
            let angles = Angles::from_increments(&rates, 1.0, 1.0, Trend::None);
            for point in curve(&angles, Deviation::Oadev, &[1, 4, 16, 64], 0.95) {
                let found = point.noise.unwrap();
                assert_eq!((found.alpha, found.carried), (alpha, false), "gaps: {gapped}, m = {}", point.m);
            }
        }
    }
}

#[test]
fn noise_is_carried_from_the_last_octave_with_30_groups_whatever_taus_are_asked_for() {
    let angles = Angles::from_increments(&power_law(2, 1000), 1.0, 1.0, Trend::None);
    let noise = curve(&angles, Deviation::Oadev, &[100], 0.95)[0].noise.unwrap();
    assert_eq!((noise.alpha, noise.carried), (2, true));
    let short = Angles::from_increments(&nbs_set(20), 1.0, 1.0, Trend::None);
    let point = curve(&short, Deviation::Oadev, &[1], 0.95)[0];
    assert!(point.value.is_some() && point.noise.is_none() && point.interval.is_none(), "{point:?}");
}

#[test]
fn a_line_removed_takes_the_ramp_and_leaves_the_white_noise() {
    let ramp: Vec<f64> = nbs_set(10_000).iter().enumerate().map(|(i, y)| y + 1e-3 * i as f64).collect();
    let [with, without] =
        [Trend::None, Trend::Linear].map(|trend| Angles::from_increments(&ramp, 1.0, 1.0, trend));
    // The ramp alone: R τ / √2.
    assert!((value(&with, Deviation::Oadev, 2048) / (2.048 / libm::sqrt(2.0)) - 1.0).abs() < 1e-2);
    assert!(value(&without, Deviation::Oadev, 2048) < 0.02);
    let ratio = value(&with, Deviation::Oadev, 1) / value(&without, Deviation::Oadev, 1);
    assert!((ratio - 1.0).abs() < 1e-4, "{ratio}");
}

#[test]
fn the_minimum_is_that_of_the_curve_and_its_end_is_told() {
    let white = Angles::from_increments(&nbs_set(1000), 1.0, 1.0, Trend::None);
    let points = curve(&white, Deviation::Oadev, &[1, 4, 16, 64], 0.95);
    let least = minimum(&points).unwrap();
    assert!(least.point.m == 64 && least.at_end, "{least:?}");
    let inner = minimum(&points[..2].iter().chain(&points[..1]).copied().collect::<Vec<_>>()).unwrap();
    assert!(inner.point.m == 4 && !inner.at_end, "{inner:?}");
    assert_eq!(minimum(&[]), None);
}

#[test]
fn a_constant_rate_has_deviations_of_zero_and_no_interval() {
    let angles = Angles::from_increments(&[7.0; 100], 1.0, 1.0, Trend::None);
    let points = curve(&angles, Deviation::Oadev, &[1, 2], 0.95);
    assert!(points.iter().all(|point| point.value == Some(0.0) && point.interval.is_none()), "{points:?}");
    assert_eq!(minimum(&points), None);
}
