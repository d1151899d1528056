//! Published values, and properties of whole curves.

use super::*;
use crate::allan::angles::Solid;

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

/// PHASE.DAT of Stable32.
fn phase_dat() -> Vec<f64> {
    let lines = data!("PHASE.DAT").lines().filter(|line| !line.starts_with('#'));
    lines.map(|line| line.trim().parse().unwrap()).collect()
}

/// The deviation at `m` without a correction of its bias.
fn raw(angles: &Angles, deviation: Deviation, m: usize) -> f64 {
    let sum = sums(angles, deviation, &[m])[0];
    libm::sqrt(sum.squares / deviation.divisor(sum.terms, deviation.tau(m) * angles.step_s))
}

/// NIST SP 1065, tables 29 and 31: the 10 points of NBS monograph 140, and the set of 1000 points. Mtotdev is corrected for white noise
/// there.
#[test]
fn the_nbs_sets_have_the_published_total_deviations() {
    let small = [892.0, 809.0, 823.0, 798.0, 671.0, 644.0, 883.0, 903.0, 677.0];
    let sets = [
        (small.to_vec(), Deviation::Totdev, 1, 91.22945),
        (small.to_vec(), Deviation::Totdev, 2, 93.90379),
        (small.to_vec(), Deviation::Mtotdev, 1, 75.50203),
        (small.to_vec(), Deviation::Mtotdev, 2, 75.83606),
        (nbs_set(1000), Deviation::Totdev, 1, 2.922319e-1),
        (nbs_set(1000), Deviation::Totdev, 10, 9.134743e-2),
        (nbs_set(1000), Deviation::Totdev, 100, 3.406530e-2),
        (nbs_set(1000), Deviation::Mtotdev, 1, 2.418528e-1),
        (nbs_set(1000), Deviation::Mtotdev, 10, 6.499161e-2),
        (nbs_set(1000), Deviation::Mtotdev, 100, 2.287774e-2),
    ];
    for (rates, deviation, m, expected) in sets {
        let found = value(&Angles::from_increments(&rates, 1.0, 1.0, Trend::None), deviation, m);
        assert!((found / expected - 1.0).abs() < 2e-7, "{deviation}, m = {m}: {found}, not {expected}");
    }
}

/// Theo1 at τ = 7.5 and 75 s of Stable32; pdev of SigmaTheta 3.0.
#[test]
fn the_nbs_set_of_1000_points_has_the_theo1_and_pdev_of_other_programs() {
    let angles = Angles::from_increments(&nbs_set(1000), 1.0, 1.0, Trend::None);
    for (m, expected) in [(10, 1.0757e-1), (100, 3.1789e-2)] {
        let found = value(&angles, Deviation::Theo1, m);
        assert!((found / expected - 1.0).abs() < 5e-5, "m = {m}: {found}, not {expected}");
    }
    let pdevs = [
        2.922_318_781_07e-1,
        2.144_523_356_43e-1,
        1.561_811_215_86e-1,
        1.170_974_574_54e-1,
        6.902_958_518_98e-2,
        4.974_970_773_04e-2,
        3.894_741_733_07e-2,
        3.086_239_274_14e-2,
        1.244_741_434_13e-2,
    ];
    for (octave, expected) in pdevs.into_iter().enumerate() {
        let found = value(&angles, Deviation::Pdev, 1 << octave);
        assert!((found / expected - 1.0).abs() < 1e-9, "m = 2^{octave}: {found}, not {expected}");
    }
}

/// Outputs of Stable32 1.60 at a confidence of 0.683, with the noise α = 0: factor, number of terms, lower bound, deviation, upper bound;
/// for Theo1 without bounds. They are in the tests of allantools.
#[test]
fn phase_dat_has_stable32s_total_deviations_theo1_and_mtie() {
    let angles = Angles::from_angles(&phase_dat(), 1.0, 1.0, Trend::None);
    let near = |found: f64, expected: f64, bound: f64| (found / expected - 1.0).abs() < bound;
    let total = [
        (1, 999, 2.8707e-1, 2.9223e-1, 2.9768e-1),
        (2, 999, 1.9592e-1, 2.0089e-1, 2.0625e-1),
        (4, 999, 1.3947e-1, 1.4444e-1, 1.4998e-1),
        (8, 999, 1.0039e-1, 1.0540e-1, 1.1126e-1),
        (16, 999, 5.7732e-2, 6.1788e-2, 6.6839e-2),
        (32, 999, 4.4255e-2, 4.8580e-2, 5.4484e-2),
        (64, 999, 3.1639e-2, 3.5905e-2, 4.2546e-2),
        (128, 999, 2.6406e-2, 3.1259e-2, 4.0383e-2),
        (256, 999, 1.0734e-2, 1.3369e-2, 1.9924e-2),
    ];
    let modified = [
        (1, 999, 2.0163e-1, 2.0664e-1, 2.1204e-1),
        (2, 996, 1.3898e-1, 1.4337e-1, 1.4821e-1),
        (4, 990, 9.0598e-2, 9.4613e-2, 9.9218e-2),
        (8, 978, 6.1866e-2, 6.5721e-2, 7.0406e-2),
        (16, 954, 3.4536e-2, 3.7135e-2, 4.0425e-2),
        (32, 906, 2.6331e-2, 2.9114e-2, 3.3017e-2),
        (64, 810, 2.0550e-2, 2.3606e-2, 2.8612e-2),
        (128, 618, 1.3766e-2, 1.6668e-2, 2.2794e-2),
        (256, 234, 4.5699e-3, 5.9607e-3, 1.0806e-2),
    ];
    for (deviation, rows) in [(Deviation::Totdev, total), (Deviation::Mtotdev, modified)] {
        for (m, terms, lower, expected, upper) in rows {
            let point = curve(&angles, deviation, &[m], 0.683)[0];
            let found = raw(&angles, deviation, m);
            let place = format!("{deviation}, m = {m}");
            assert_eq!((point.terms, point.noise.unwrap().alpha), (terms, 0), "{place}");
            assert!(near(found, expected, 5e-5), "{place}: {found}, not {expected}");
            // Bounds of the corrected value scale as it.
            let (low, high) = point.interval.unwrap();
            let scale = found / point.value.unwrap();
            // Beyond, Stable32 has 1.33 T/τ − 1.90 degrees of freedom for modified total deviations, which simulated records do not have.
            if deviation == Deviation::Totdev || m <= total::MAX_OF_ALLAN {
                assert!(near(low * scale, lower, 1e-3), "{place}: {}, not {lower}", low * scale);
                assert!(near(high * scale, upper, 1e-3), "{place}: {}, not {upper}", high * scale);
            }
        }
    }
    for (m, terms, expected) in [
        (10, 4955, 1.0757e-1),
        (20, 9810, 7.2762e-2),
        (40, 19_220, 4.8652e-2),
        (100, 45_050, 3.1789e-2),
        (202, 80_699, 2.4120e-2),
        (400, 120_200, 1.4321e-2),
        (998, 1497, 5.0234e-3),
    ] {
        let point = curve(&angles, Deviation::Theo1, &[m], 0.683)[0];
        assert_eq!((point.tau_s, point.terms), (0.75 * m as f64, terms), "m = {m}");
        assert!(near(point.value.unwrap(), expected, 1e-4), "m = {m}: {:?}, not {expected}", point.value);
    }
    // Stable32 leaves the mean rate in the record.
    let recorded = Solid { values: &phase_dat(), runs: std::slice::from_ref(&(0..1001)), share: 1.0 };
    for (m, terms, expected) in [
        (1, 1000, 5.0597e-1),
        (3, 998, 1.2984),
        (7, 994, 2.2922),
        (15, 986, 2.9949),
        (31, 970, 4.4550),
        (63, 938, 6.5989),
        (127, 874, 6.8061),
        (255, 746, 7.8205),
        (511, 490, 7.8205),
    ] {
        let sum = sums::mtie(recorded, &[m])[0];
        assert_eq!(sum.terms, terms);
        assert!(near(libm::sqrt(sum.squares), expected, 1e-4), "m = {m}: {}", libm::sqrt(sum.squares));
    }
}

/// Rates that no model of the fit describes: noise with a resonance and an outlier, a random walk, and three first-order lags.
fn series(name: &str) -> Vec<f64> {
    let noise = nbs_set(400).into_iter().map(|y| y - 0.5);
    match name {
        "band" => {
            let (mut a, mut b) = (0.0, 0.0);
            let of = |x: f64| {
                let value = x + 1.6 * a - 0.81 * b;
                (b, a) = (a, value);
                value
            };
            let mut rates: Vec<f64> = noise.map(of).collect();
            rates[200] += 50.0;
            rates
        }
        "walk" => power_law(-2, 400),
        _ => {
            let mut lags = [0.0; 3];
            noise
                .map(|x| {
                    lags.iter_mut().zip([0.5, 0.9375, 0.9921875]).for_each(|(s, p)| *s = p * *s + x);
                    lags[0] + 0.25 * lags[1] + 0.0625 * lags[2]
                })
                .collect()
        }
    }
}

#[test]
fn records_that_no_model_describes_have_the_deviations_of_an_independent_program() {
    let mut rows = 0;
    for line in data!("extended.csv").lines().skip(2) {
        let [name, deviation, m, expected] = line.split(',').collect::<Vec<_>>()[..] else {
            panic!("{line}")
        };
        let angles = Angles::from_increments(&series(name), 1.0, 1.0, Trend::None);
        let (deviation, m) = (deviation.parse().unwrap(), m.parse().unwrap());
        // ThêoH is free of bias by its definition.
        let of = if deviation == Deviation::Theoh { value } else { raw };
        let found = of(&angles, deviation, m);
        let expected: f64 = expected.parse().unwrap();
        assert!((found / expected - 1.0).abs() < 1e-9, "{line}: {found}");
        rows += 1;
    }
    assert_eq!(rows, 75);
}

#[test]
fn phase_dat_has_stable32s_deviations_bounds_terms_and_noise() {
    let phase = phase_dat();
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
        let mut factors = Taus::Octave.factors(plain.len(), 0.01, deviation).unwrap();
        if matches!(deviation, Deviation::Mtotdev | Deviation::Theo1 | Deviation::Theoh) {
            // Their work grows with m.
            factors.truncate(8);
        }
        let curves = [&plain, &offset].map(|angles| curve(angles, deviation, &factors, 0.95));
        for (a, b) in curves[0].iter().zip(&curves[1]) {
            let error = b.value.unwrap() / a.value.unwrap() - 1.0;
            // MTIE depends on the mean rate, whose rounding it has over the whole of τ.
            let bound = if deviation == Deviation::Mtie { 1e-6 } else { 1e-9 };
            assert!(error.abs() < bound, "{deviation}, m = {}: {error:e}", a.m);
        }
    }
}

/// The deviations with intervals that suppose a power law.
fn with_intervals() -> impl Iterator<Item = Deviation> {
    Deviation::ALL.into_iter().filter(|deviation| *deviation != Deviation::Mtie)
}

#[test]
fn gaps_leave_out_terms_and_keep_values_and_intervals() {
    let rates = nbs_set(20_000);
    let gapped: Vec<f64> =
        rates.iter().enumerate().map(|(i, y)| if i % 1000 < 7 { f64::NAN } else { *y }).collect();
    let [whole, gapped] = [rates, gapped].map(|y| Angles::from_increments(&y, 1.0, 1.0, Trend::None));
    assert_eq!(gapped.missing(), 140);
    for deviation in with_intervals() {
        let factors = if deviation == Deviation::Theo1 { [10, 100, 200] } else { [1, 10, 100] };
        let curves = [&whole, &gapped].map(|angles| curve(angles, deviation, &factors, 0.95));
        for (a, b) in curves[0].iter().zip(&curves[1]) {
            // Others bridge gaps.
            let bridges = !deviation.is_of_differences() && deviation != Deviation::Theoh;
            let fewest = if bridges { a.terms * 99 / 100 } else { a.terms / 2 };
            assert!(b.terms <= a.terms && b.terms > fewest, "{deviation}: {} of {}", b.terms, a.terms);
            let ratio = b.value.unwrap() / a.value.unwrap();
            assert!((0.8..1.25).contains(&ratio), "{deviation}, m = {}: {ratio}", a.m);
            let width =
                |point: &Point| point.interval.map(|(lower, upper)| libm::log(upper / lower)).unwrap();
            assert!(width(b) > width(a), "{deviation}, m = {}: gaps narrow the interval", a.m);
            assert_eq!(b.noise.unwrap().alpha, 0, "{deviation}, m = {}", a.m);
        }
    }
    // Longer than any stretch between gaps.
    for deviation in with_intervals() {
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
        for deviation in with_intervals() {
            for m in [1, 4, 32, 512] {
                if deviation == Deviation::Theo1 && m < theo::SHORTEST {
                    continue;
                }
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
    let least = Minimum::from_points(&points).unwrap();
    assert!(least.point.m == 64 && least.at_end, "{least:?}");
    let inner = [&points[..2], &points[..1]].concat();
    let inner = Minimum::from_points(&inner).unwrap();
    assert!(inner.point.m == 4 && !inner.at_end, "{inner:?}");
    assert_eq!(Minimum::from_points(&[]), None);
}

#[test]
fn the_minimum_of_a_record_is_that_up_to_an_eighth_of_it() {
    let white = Angles::from_increments(&nbs_set(1000), 1.0, 1.0, Trend::None);
    let points = curve(&white, Deviation::Oadev, &[1, 4, 16, 64, 125, 126, 400], 0.95);
    let least = Minimum::from_record(&points, 1000).unwrap();
    assert!(least.point.m <= 125, "{least:?}");
    assert_eq!(Some(least), Minimum::from_points(&points[..5]));
    assert!(Minimum::from_points(&points).unwrap().point.m > 125, "{points:?}");
}

#[test]
fn a_constant_rate_has_deviations_of_zero_and_no_interval() {
    let angles = Angles::from_increments(&[7.0; 100], 1.0, 1.0, Trend::None);
    let points = curve(&angles, Deviation::Oadev, &[1, 2], 0.95);
    assert!(points.iter().all(|point| point.value == Some(0.0) && point.interval.is_none()), "{points:?}");
    assert_eq!(Minimum::from_points(&points), None);
}
