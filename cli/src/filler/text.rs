//! The weights as text for people.

use sagnac::analysis::firmware::design::{Closed, Design, Firmware};
use sagnac::analysis::firmware::rule::Rule;
use sagnac::analysis::firmware::search::Trade;
use sagnac::filler::keys::Error;
use sagnac::kinds::gap_fill::judged::deviation;
use sagnac::quantity::number::significant;
use sagnac::theory::gap::Weights;

use crate::terminal::aligned;

/// Denominators up to this are shown as fractions.
const MOST_DENOMINATOR: i64 = 999;

/// Most ticks side by side; more continue below.
const ACROSS: usize = 10;

/// The gap and the point of the study.
pub fn heading(firmware: &Firmware) -> String {
    let n = firmware.gap_ticks;
    let plural = if n == 1 { "" } else { "s" };
    let of = firmware.tick_s.map_or_else(String::new, |t| format!(" of {} ms", significant(1e3 * t, 6)));
    let place = firmware.place();
    let at = if place.is_empty() { String::new() } else { format!(" · {place}") };
    format!("{} · n = {n} lost tick{plural}{of}{at}", firmware.title)
}

/// All fillers with their weights, gains and errors.
pub fn of(firmware: &Firmware) -> String {
    let mut text = firmware.trade.as_ref().map_or_else(String::new, searched);
    for design in &firmware.designs {
        text += &format!("\n{}: {}\n", design.name, design.method);
        for (error, rule, closed) in design.rules() {
            text += &part(firmware, error, rule, closed);
        }
        text += &format!("  {}\n", firmware.expected(design));
        text += &missing(design, firmware.gap_ticks);
    }
    text.trim_start_matches('\n').to_owned()
}

/// The search of the ticks as a table, with the choice.
fn searched(trade: &Trade) -> String {
    let mut grid = vec![
        ["ticks after", "latency, ms", "ticks before", "rms, ″", "99.73 %, ″"].map(str::to_owned).to_vec(),
    ];
    for row in trade.rows() {
        let latency_ms = significant(1e3 * trade.latency_s(row), 4);
        let [rms, level] = [row.rms, row.level].map(|error| significant(error, 4));
        grid.push(vec![row.after.to_string(), latency_ms, row.before.to_string(), rms, level]);
    }
    let limit = trade.asked.limit_arcsec.map(|limit| significant(limit, 6));
    let which = match &limit {
        Some(limit) => {
            format!("the fewest ticks before the gap within {limit}″, else those of the least error")
        }
        None => "the ticks before the gap of the least error".to_owned(),
    };
    let chosen = trade.chosen;
    format!(
        "\nsearch: {which}; residuals with noise, at worst with {}\n{}\
         chosen: {} ticks before and {} after; at the frequencies as given {}″ rms and {}″ at 99.73 %\n",
        deviation(trade.shift),
        aligned(&grid),
        chosen.before,
        chosen.after,
        significant(chosen.own_rms, 4),
        significant(chosen.own_level, 4)
    )
}

/// The table of a rule, with its gains and closed-form errors.
fn part(firmware: &Firmware, error: Error, rule: &Rule, closed: Closed) -> String {
    let whole = rule.whole();
    let (letter, heading) = match error {
        Error::Residual => ('I', "interpolation I and its residual"),
        Error::Extrapolation | Error::InGap => ('E', "extrapolation E and its error"),
    };
    let row = |numerators: Vec<i64>| Weights { numerators, ..whole.clone() };
    let mut rows = Vec::new();
    if rule.rows.len() == firmware.gap_ticks as usize {
        let by_tick = (1..).zip(&rule.rows);
        rows.extend(by_tick.map(|(j, numerators): (u32, _)| {
            (format!("{letter}{j}"), row(numerators.iter().map(|w| i64::from(*w)).collect()))
        }));
    }
    rows.push(("sum".to_owned(), whole.clone()));
    let small = rows.iter().all(|(_, weights)| fractions(weights).is_some());
    let mut text = format!("  {heading}\n");
    for from in (0..rule.ticks.len()).step_by(ACROSS) {
        let span = from..(from + ACROSS).min(rule.ticks.len());
        let mut grid =
            vec![line("tick", rule.ticks[span.clone()].iter().map(|tick| minus(&tick.to_string())))];
        for (name, weights) in &rows {
            match fractions(weights).filter(|_| small) {
                Some(fractions) => grid.push(line(name, fractions[span.clone()].iter().cloned())),
                None => {
                    let values: Vec<f64> = weights.values().collect();
                    grid.push(line(name, values[span.clone()].iter().map(|w| minus(&significant(*w, 6)))));
                    let over = format!("× {}", denominator(rule.denominator));
                    let numerators = weights.numerators[span.clone()].iter();
                    grid.push(line(&over, numerators.map(|w| minus(&w.to_string()))));
                }
            }
        }
        text += &aligned(&grid).lines().map(|line| format!("  {line}\n")).collect::<String>();
    }
    let number = |x: f64| significant(x, 5);
    let how = if rule.exact { "exact, " } else { "rounded to the nearest with Σw kept, " };
    text += &format!(
        "    {how}over {}   Σw = {}   √Σw² = {}   Σ|w| = {}\n",
        denominator(rule.denominator),
        firmware.gap_ticks,
        number(whole.noise_gain()),
        number(whole.largest_gain()),
    );
    if let (Some(amplitude), Some((rate, nu))) = (closed.amplitude, firmware.tone) {
        let (amplitude, rate, nu) = (number(amplitude), number(rate), number(nu));
        text += &format!("    amplitude {amplitude}″ at {nu} Hz and {rate} arcsec/s");
        text +=
            &closed.rms.map_or_else(String::new, |rms| format!(", rms with noise {} arcsec", number(rms)));
        text += "\n";
    } else if let Some(rms) = closed.rms.filter(|rms| *rms > 0.0) {
        let of = if firmware.shift.is_none() { " on the specification as given" } else { "" };
        text += &format!("    rms with noise{of} {} arcsec\n", number(rms));
    }
    text
}

/// What the header leaves on whole pulses, and what the filler does not provide.
fn missing(design: &Design, n: u32) -> String {
    let mut text = String::new();
    if let Some(rms) = design.exported_rms {
        text += &format!(
            "  the C header, given whole pulses, leaves {}″ rms, because it rounds its result to whole pulses too; given pulses \
             times 16 it leaves nearly what the study says\n",
            significant(rms, 5)
        );
    }
    if design.rules().any(|(_, rule, _)| rule.rows.len() != n as usize) {
        text += "  it gives the sum over the gap alone, not single ticks\n";
    }
    if design.extrapolation.is_none() {
        text += "  it has no extrapolation, so it has no value while the gap is open\n";
    }
    text
}

fn line(name: &str, cells: impl Iterator<Item = String>) -> Vec<String> {
    std::iter::once(name.to_owned()).chain(cells).collect()
}

/// The weights as reduced fractions, if all of them have small denominators.
fn fractions(weights: &Weights) -> Option<Vec<String>> {
    let fraction = |w: &i64| {
        let divisor = greatest_common_divisor(*w, weights.denominator);
        let (above, below) = (w / divisor, weights.denominator / divisor);
        match below {
            1 => Some(minus(&above.to_string())),
            below if below <= MOST_DENOMINATOR => Some(minus(&format!("{above}/{below}"))),
            _ => None,
        }
    };
    weights.numerators.iter().map(fraction).collect()
}

fn greatest_common_divisor(a: i64, b: i64) -> i64 {
    if b == 0 { a.abs() } else { greatest_common_divisor(b, a % b) }
}

/// The denominator as `2^24` if it is a power of two, else as a number.
fn denominator(denominator: i32) -> String {
    if denominator > 1 << 10 && denominator & (denominator - 1) == 0 {
        format!("2^{}", denominator.trailing_zeros())
    } else {
        denominator.to_string()
    }
}

fn minus(number: &str) -> String {
    number.replace('-', "−")
}
