//! Recorded motions: reading one from the columns `time` and `rate` of a file, and the angles of ticks over it. A motion has no
//! gaps, and its times are evenly spaced.
//!
//! # Angles of ticks
//!
//! The recorded rate has no power above half its sampling rate.
//! Between samples the rate is Σ r_i K(t/h − i), where h is the step and K(x) = sinc(x) · I₀(β√(1 − (x/M)²))/I₀(β) the
//! sinc in a Kaiser window of M = [`HALF`] samples on either side. Angles are integrals of it. With G the integral of K,
//! scaled to rise from 0 to 1, the angle up to the time x, in steps, is h times the sum of the samples up to x, of
//! which those within M of x are corrected by G(x − i) − 1 before x and G(x − i) after it. The samples are rates at
//! their times, so nothing fixes the angle between two of them: the integral of the band-limited rate is the angle.
//!
//! The table of G has [`PHASES`] steps between samples, with straight lines between them. Everything is summed in a
//! fixed order with `libm`, so the angles are the same on every machine.

use std::array::from_fn;
use std::sync::LazyLock;

use crate::record::column_file::{ColumnFile, Rules};
use crate::record::time::grid;
use crate::record::{Record, RecordError};
use sagnac_base::quantity::{Dimension, round_12};

/// Help with an example of a header.
const NAMES: &str = "name one column `time` and one `rate`, with their units, as in\ntime [s], rate [deg/s]";

/// Advice on missing numbers.
const MISSING: &str =
    "every row needs a finite number here: put it in, or cut the record and resample what is left";

/// The rules for at most `most` samples: steps count as equal within 1 %, and a record of a motion has no gaps.
fn rules(most: usize) -> Rules {
    let uneven = "resample it evenly first: every step must be within 1 % of the median step";
    Rules { most, missing: MISSING, jitter: 0.01, has_gaps: false, uneven }
}

/// Reads a record of at most `most` samples.
pub(crate) fn read(mut file: ColumnFile, most: usize) -> Result<Record, RecordError> {
    if file.names().is_empty() {
        return Err(file.refuse(None, "the header is missing", "numbers instead of names", NAMES));
    }
    let (time, time_size) = column(&file, "time", Dimension::Time, "time [s]")?;
    let (rate, rate_size) = column(&file, "rate", Dimension::Rate, "rate [deg/s]")?;
    let rules = rules(most);
    let columns = file.read(&[time, rate], &rules)?;
    let times = finite(&file, time, "time", &columns[0], time_size)?;
    let rates = finite(&file, rate, "rate", &columns[1], rate_size)?;
    if rates.len() < 2 {
        let message = format!("a record needs at least 2 samples, this one has {}", rates.len());
        let help = "the step is the time from one sample to the next: add rows";
        return Err(file.refuse(None, &message, "its columns", help));
    }
    grid(&columns[0], time_size, &rules).map_err(|fault| file.refuse_row(fault.row, time, fault.words))?;
    let steps = rates.len() - 1;
    let step_s = round_12((times[steps] - times[0]) / steps as f64);
    file.check_step(step_s, Some(time))?;
    Ok(Record { step_s, rates })
}

/// The column with this name, and the size of its unit.
fn column(
    file: &ColumnFile,
    name: &str,
    dimension: Dimension,
    example: &str,
) -> Result<(usize, f64), RecordError> {
    let column = file.find(name, Some(dimension)).map_err(|error| error.with_help(NAMES))?;
    let help = format!("accepted: {} in {}, for example `{example}`", dimension.name(), dimension.units());
    Ok((column, file.unit_size(column, None, dimension, &format!("the column `{name}`"), &help)?))
}

/// The numbers of a column in base units.
fn finite(
    file: &ColumnFile,
    column: usize,
    name: &str,
    numbers: &[f64],
    size: f64,
) -> Result<Vec<f64>, RecordError> {
    let values: Vec<f64> = numbers.iter().map(|number| number * size).collect();
    let Some(row) = values.iter().position(|value| value.is_nan()) else { return Ok(values) };
    Err(file.refuse_row(
        row,
        column,
        [format!("the {name} is missing"), "missing".to_owned(), MISSING.to_owned()],
    ))
}

/// Samples on either side of a time that count.
const HALF: usize = 32;
/// Samples that count.
const TAPS: usize = 2 * HALF;
/// Steps of the table between two samples.
const PHASES: usize = 512;
/// Shape β of the window. With M = 32 it leaves 100 dB beyond a transition from 0.9 to 1.1 of half the sampling rate.
const BETA: f64 = 10.0;

/// A row of corrections for each phase of a time between two samples. The sample at place `HALF` is the last one up to
/// the time, and later places are earlier samples.
static TABLE: LazyLock<Vec<[f64; TAPS]>> = LazyLock::new(|| {
    let place = |k: f64| k / PHASES as f64 - HALF as f64;
    let mut sum = 0.0;
    // Simpson's rule, whose factor cancels with the scaling.
    let integrals = (0..TAPS * PHASES).map(|k| {
        let k = k as f64;
        sum += kernel(place(k)) + 4.0 * kernel(place(k + 0.5)) + kernel(place(k + 1.0));
        sum
    });
    let integrals: Vec<f64> = std::iter::once(0.0).chain(integrals).collect();
    let row = |phase: usize| {
        let whole = |tap: usize| if tap < HALF { 0.0 } else { 1.0 };
        let mut row: [f64; TAPS] = from_fn(|tap| integrals[phase + tap * PHASES] / sum - whole(tap));
        // The corrections of a constant rate sum to the phase less ½; the window leaves an excess of 1e-6.
        let excess = row.iter().sum::<f64>() - (phase as f64 / PHASES as f64 - 0.5);
        row[HALF - 1] -= 0.5 * excess;
        row[HALF] -= 0.5 * excess;
        row
    };
    (0..=PHASES).map(row).collect()
});

/// The kernel K(x), |x| ≤ M.
fn kernel(x: f64) -> f64 {
    let turn = core::f64::consts::PI * x;
    let sinc = if x == 0.0 { 1.0 } else { libm::sin(turn) / turn };
    let along = x / HALF as f64;
    sinc * bessel_i0(BETA * libm::sqrt((1.0 - along * along).max(0.0))) / bessel_i0(BETA)
}

/// The modified Bessel function I₀(x) for 0 ≤ x ≤ 10, by its power series.
fn bessel_i0(x: f64) -> f64 {
    let mut term = 1.0;
    let terms = (1..40).map(|k| {
        let factor = 0.5 * x / f64::from(k);
        term *= factor * factor;
        term
    });
    1.0 + terms.sum::<f64>()
}

impl Record {
    /// The angle of each whole tick of `tick_s` > 0, ″, for a rate without power above half the sampling rate.
    ///
    /// The angle of a sine of up to 0.9 of half the sampling rate is accurate to 2e-5 of its rate amplitude times the
    /// tick, and that of a constant rate to rounding. Faster parts fade out up to half the sampling rate, where they
    /// are indistinguishable from their images. A jump of the rate rings over some samples. Within 32 samples of its
    /// ends the record is continued by reflection about its first and last sample. A straight line keeps its angles, to 1e-5
    /// of its rise per step times the step; for other rates the error grows towards the ends to that of straight lines.
    ///
    /// It takes 64 steps for each tick, and 8 bytes per tick; [`Record::whole_ticks`] counts the ticks beforehand.
    pub fn band_limited_tick_angles(&self, tick_s: f64) -> Vec<f64> {
        let boundary = |tick: usize| {
            let at = self.samples_at(tick, tick_s);
            (at as usize, self.correction(at))
        };
        let mut start = None;
        let angle = |k: usize| {
            let (from, before) = start.unwrap_or_else(|| boundary(k));
            let (to, after) = boundary(k + 1);
            start = Some((to, after));
            (self.rates[from + 1..=to].iter().sum::<f64>() + (after - before)) * self.step_s
        };
        (0..self.whole_ticks(tick_s)).map(angle).collect()
    }

    /// The integral of the rate up to a time, less the sum of the samples up to it, both in steps.
    fn correction(&self, at: f64) -> f64 {
        let last = at as usize;
        let along = (at - last as f64) * PHASES as f64;
        let phase = (along as usize).min(PHASES - 1);
        let part = along - phase as f64;
        let rates: [f64; TAPS] = from_fn(|tap| self.continued((last + HALF) as i64 - tap as i64));
        let sum = |row: &[f64; TAPS]| row.iter().zip(&rates).map(|(w, rate)| w * rate).sum::<f64>();
        (1.0 - part) * sum(&TABLE[phase]) + part * sum(&TABLE[phase + 1])
    }

    /// The sample at `i`. Outside, the record is reflected about the point of its first and of its last sample.
    fn continued(&self, i: i64) -> f64 {
        if let Some(rate) = usize::try_from(i).ok().and_then(|i| self.rates.get(i)) {
            return *rate;
        }
        let last = self.rates.len() - 1;
        let [turns, place] = [i.div_euclid(2 * last as i64), i.rem_euclid(2 * last as i64)];
        let (place, end) = (place as usize, self.rates[last]);
        let own = if place <= last { self.rates[place] } else { 2.0 * end - self.rates[2 * last - place] };
        own + turns as f64 * 2.0 * (end - self.rates[0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::format::Origin;
    use crate::record::log::read::Hints;

    fn record(text: &str, most: usize) -> Result<Record, String> {
        let file = ColumnFile::open("r.csv".to_owned(), Origin::Bytes(text.as_bytes()), &Hints::default());
        file.and_then(|file| read(file, most)).map_err(|error| error.render(false, 200))
    }

    #[test]
    fn a_record_is_read_whatever_its_order_units_and_surroundings() {
        let expected: [f64; 3] = [3600.0, -7200.0, 0.36];
        let texts = [
            "time [s],rate [deg/s]\n0,1\n0.002,-2\n0.004,1e-4\n",
            "time [ms], rate (arcsec/s)\n10, 3600\n12, -7200\n14, 0.36",
            "\u{feff}# base, \"x\n\nrate [°/s] ; id,temperature [K],rate_deg_per_s,time_ms\n9,,1,-2\n# half\n9,x,-2,0\n\n9,,+1e-4,2\n",
            "TIME [s],Rate [deg/s],\"a, b\"\r\n0,1,\"x, y\"\r\n0.002,-2,z\r\n0.004,0.0001,\r\n",
            "time [s],rate [deg/s],note\n0,1,a;b\n0.002,-2,\n0.004,1e-4,\n",
            "% base\nrate_s;time [s];rate [deg/s]\n7;0;1\n7;0.002;-2\n7;0.004;1e-4\n",
            "time [s],rate [deg/s]\n5000000000,1\n5000000000.002,-2\n5000000000.004,1e-4\n",
        ];
        for text in texts {
            let found = record(text, 3).unwrap_or_else(|error| panic!("{text}\n{error}"));
            assert!((found.step_s - 0.002).abs() < 1e-6, "{text}\n{}", found.step_s);
            assert_eq!(found.rates.len(), 3, "{text}");
            for (rate, expected) in found.rates.iter().zip(expected) {
                assert!((rate / expected - 1.0).abs() < 1e-15, "{text}\n{rate}, not {expected}");
            }
        }
    }

    #[test]
    fn what_is_no_record_is_shown_with_its_place_and_what_to_do() {
        let rows = |rows: &str| format!("time [s],rate [deg/s]\n{rows}");
        let names = "time [s], rate [deg/s]";
        let table = [
            (String::new(), "r.csv is empty", "", "below a header"),
            ("# only a comment\n".to_owned(), "r.csv has no samples", "", "below a header"),
            ("0,1\n1,2\n".to_owned(), "the header is missing", "r.csv:1:1", names),
            ("time [s],speed\n".to_owned(), "no column is called `rate`", "r.csv:1:1", names),
            ("rate_x [deg/s],time [s]\n".to_owned(), "no column is called `rate`", "r.csv:1:1", names),
            ("#\n\ntime [s],rate\n".to_owned(), "`rate` has no unit", "r.csv:3:10", "arcsec/s, deg/s"),
            ("time [s], rate [volts]\n".to_owned(), "`volts` is not a known unit", "r.csv:1:11", "deg/s"),
            ("time [deg],rate [deg/s]\n".to_owned(), "\"deg\" is an angle", "r.csv:1:1", "s, ms"),
            ("time [s],rate [deg]\n".to_owned(), "\"deg\" is an angle", "r.csv:1:10", "an angular rate in"),
            (
                "time [s],rate [deg/s],rate_deg_per_s\n".to_owned(),
                "columns 2 and 3 are both",
                "r.csv:1:1",
                names,
            ),
            (rows("0,1\n0.1,fast\n"), "\"fast\", which is not a number", "r.csv:3:5", "numbers"),
            (rows("0,1\n0.1,1\n0.2,\n"), "the rate is missing", "r.csv:4:5", "finite number"),
            (rows("0,1\n#\nNaN,1\n"), "the time is missing", "r.csv:4:1", "finite number"),
            (rows("0,1\n0.1,-inf\n"), "`rate [deg/s]` is infinite", "r.csv:3:5", "finite number"),
            (rows("0,1\n0.1, 1e308\n"), "1e308, beyond 1e100, here", "r.csv:3:6", "finite number"),
            (rows("0,1\n0.1\n"), "this row has 1 cell, the header has 2", "r.csv:3:1", "needs 2 cells"),
            (rows("0,1\n0,1,1,5\n"), "this row has 4 cells", "r.csv:3:1", "divided by commas"),
            (rows("0,1\r\n0.1,x\r\n").replace("]\n", "]\r\n"), "\"x\", which is no", "r.csv:3:5", "numbers"),
            (rows("0,1\n0.1,1\n0.1,1\n"), "does not increase: 0.1 after 0.1", "r.csv:4:1", "sort"),
            (rows("0,1\n0.1,1\n0.05,1\n"), "does not increase: 0.05 after 0.1", "r.csv:4:1", "sort"),
            (rows("0,1\n1,1\n2,1\n#\n4,1\n5,1\n"), "a step of 2 s, the median is 1 s", "r.csv:6:1", "evenly"),
            (rows("0,1\n100,1\n200,1\n301.1,1\n"), "a step of 101.1 s", "r.csv:5:1", "within 1 %"),
            (rows("0,1\n1e-300,2\n"), "1e-300 s apart", "r.csv:1:1", "accepted: 1e-9 s to 1e9 s"),
            (rows(""), "at least 2 samples, this one has 0", "r.csv:1:1", "add rows"),
            (rows("0,1\n"), "at least 2 samples, this one has 1", "r.csv:1:1", "add rows"),
            (rows("0,1\n1,1\n2,1\n3,1\n4,1\n5,1\n6,1\n"), "more than 6 rows", "r.csv", "cut it"),
        ];
        for (text, message, place, help) in table {
            let shown = record(&text, 6).unwrap_err();
            for piece in [message, place, help] {
                assert!(shown.contains(piece), "{piece} is missing for\n{text}\nin\n{shown}");
            }
        }
    }

    #[test]
    fn steps_within_one_percent_of_the_median_are_even() {
        let record = record("time [s],rate [deg/s]\n0,1\n100,1\n200.9,1\n300,1\n", 4).unwrap();
        assert_eq!(record.step_s, 100.0);
    }

    const STEP_S: f64 = 0.002;
    /// Ticks shorter and longer than the step, commensurate and not.
    const TICKS: [f64; 6] = [0.0005, 0.000_73, 0.002, 0.003_1, 0.005, 0.031_4];

    fn sampled(rate: impl Fn(f64) -> f64) -> Record {
        Record { step_s: STEP_S, rates: (0..=1000).map(|i| rate(f64::from(i) * STEP_S)).collect() }
    }

    #[test]
    fn a_sine_up_to_nine_tenths_of_half_the_sampling_rate_has_its_true_angles() {
        for part in [0.01, 0.1, 0.3, 0.5, 0.8, 0.9] {
            let omega = core::f64::consts::PI * part / STEP_S;
            let record = sampled(|t| libm::sin(omega * t + 0.3));
            for tick_s in TICKS {
                let angles = record.band_limited_tick_angles(tick_s);
                assert_eq!(angles.len(), record.whole_ticks(tick_s));
                for (k, angle) in angles.iter().enumerate() {
                    let (from, to) = (k as f64 * tick_s, (k + 1) as f64 * tick_s);
                    let inner = from >= 32.0 * STEP_S && to <= 2.0 - 32.0 * STEP_S;
                    let exact = (libm::cos(omega * from + 0.3) - libm::cos(omega * to + 0.3)) / omega;
                    // At the ends nothing better than a line is known.
                    let bound = if inner { 2e-5 } else { 1.0 } * tick_s;
                    assert!(
                        (angle - exact).abs() < bound,
                        "{part}, tick {k} of {tick_s} s: {angle}, not {exact}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_straight_line_keeps_its_angles_up_to_the_ends() {
        let record = sampled(|t| 300.0 - 1000.0 * t);
        let constant = sampled(|_| 7.0);
        for tick_s in TICKS {
            for (k, angle) in record.band_limited_tick_angles(tick_s).iter().enumerate() {
                let exact = (300.0 - 1000.0 * (k as f64 + 0.5) * tick_s) * tick_s;
                // The line rises by 2 from sample to sample, of which the window leaves 1e-5.
                assert!(
                    (angle - exact).abs() < 2.5e-5 * STEP_S,
                    "tick {k} of {tick_s} s: {angle}, not {exact}"
                );
            }
            for angle in constant.band_limited_tick_angles(tick_s) {
                assert!((angle / (7.0 * tick_s) - 1.0).abs() < 1e-11, "{angle} in {tick_s} s");
            }
        }
    }

    #[test]
    fn two_samples_are_a_line_and_fewer_have_no_ticks() {
        let record = |rates: &[f64]| Record { step_s: 1.0, rates: rates.to_vec() };
        let angles = record(&[1.0, 3.0]).band_limited_tick_angles(0.25);
        for (angle, exact) in angles.iter().zip([0.3125, 0.4375, 0.5625, 0.6875]) {
            assert!((angle - exact).abs() < 2.5e-5, "{angles:?}");
        }
        assert_eq!(angles.len(), 4);
        assert_eq!(record(&[1.0]).band_limited_tick_angles(0.25), [0.0; 0]);
        assert_eq!(record(&[]).band_limited_tick_angles(0.25), [0.0; 0]);
    }

    #[test]
    fn the_angles_keep_their_bits() {
        let record = sampled(|t| 1000.0 * libm::sin(700.0 * t) + 100.0 * t * t);
        let angles = record.band_limited_tick_angles(0.000_73);
        let mixed = angles.iter().fold(0_u64, |mixed, x| mixed.rotate_left(7) ^ x.to_bits());
        assert_eq!(mixed, 0x4589_4916_cf1d_a890, "{mixed:#018x}");
    }
}
