use super::*;
use sagnac_theory::allan::{Part, block_covariance};

/// Blocks of 100 samples of 1 s over a line and a sine, with these values.
fn blocks(places: Vec<usize>, value: impl Fn(f64) -> f64) -> Blocks {
    let noises = [Part::angle_random_walk(1.0), Part::bias_instability(1.0, 24), Part::rate_random_walk(1.0)];
    let noises = noises.map(|part| block_covariance(&part, 1.0, 100, places.last().unwrap() + 1));
    let over = |x: &dyn Fn(f64) -> f64| places.iter().map(|&place| x(place as f64)).collect::<Vec<_>>();
    let columns = vec![over(&|_| 1.0), over(&|x| x / 40.0 - 1.0), over(&|x| libm::sin(0.3 * x))];
    Blocks { shares: vec![1.0; places.len()], values: over(&value), columns, places, noises }
}

#[test]
fn a_record_without_noise_gives_its_coefficients_also_across_gaps() {
    let places: Vec<usize> = (0..80).filter(|place| !(30..38).contains(place)).collect();
    let value = |x: f64| 7.0 - 2.0 * (x / 40.0 - 1.0) + 0.25 * libm::sin(0.3 * x);
    let regression = Regression::new(blocks(places, value)).unwrap();
    let means = regression.posterior(&[0, 1, 2]).unwrap().means();
    for (found, expected) in means.iter().zip([7.0, -2.0, 0.25]) {
        assert!((found - expected).abs() < 1e-9, "{means:?}");
    }
}

#[test]
fn a_column_that_is_needed_is_missed_and_one_that_is_not_is_not() {
    // A triangle stands for noise; it is orthogonal to nothing, yet far from the sine.
    let noise = |x: f64| ((x * 7919.0) % 13.0) - 6.0;
    let regression =
        Regression::new(blocks((0..80).collect(), |x| noise(x) + 9.0 * libm::sin(0.3 * x))).unwrap();
    let all = regression.posterior(&[0, 1, 2]).unwrap();
    assert!(regression.lack(&[0, 1, 2], &all).abs() < 1e-12);
    assert!(regression.lack(&[0, 1], &all) > 20.0, "{}", regression.lack(&[0, 1], &all));
    assert!(regression.lack(&[0, 2], &all) < 4.0, "{}", regression.lack(&[0, 2], &all));
}

#[test]
fn columns_that_depend_on_each_other_have_no_coefficients() {
    let mut blocks = blocks((0..40).collect(), |x| x);
    blocks.columns.push(blocks.columns[1].iter().map(|x| 3.0 * x + 1.0).collect());
    let regression = Regression::new(blocks).unwrap();
    assert!(regression.posterior(&[0, 1, 3]).is_none() && regression.posterior(&[0, 3]).is_some());
}

#[test]
fn a_sine_that_is_not_in_the_model_is_told_from_noise() {
    let numbers = std::iter::successors(Some(1_u64), |n| Some(16_807 * n % 2_147_483_647));
    let uniform: Vec<f64> =
        numbers.skip(9).take(160).map(|n| 12.0 * n as f64 / 2_147_483_647.0 - 6.0).collect();
    let noise = |x: f64| uniform[x as usize];
    let of = |size: f64| {
        let regression =
            Regression::new(blocks((0..160).collect(), |x| noise(x) + size * libm::sin(1.1 * x))).unwrap();
        let posterior = regression.posterior(&[0, 1]).unwrap();
        regression.p_value(&[0, 1], &posterior).unwrap()
    };
    assert!(of(0.0) > 1e-3, "{}", of(0.0));
    assert!(of(10.0) < 1e-6, "{}", of(10.0));
}
