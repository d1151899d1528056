//! The pages of designs, fillers and sensitivities.

use crate::analysis::decision::Sheet;
use crate::analysis::design::{Design, report};
use crate::analysis::firmware::design::Closed;
use crate::analysis::firmware::export::HEADER;
use crate::analysis::firmware::fixed_point_filter::common_divisor;
use crate::analysis::firmware::{Candidate, Firmware, Rule, Trade};
use crate::analysis::page::{chart, grid, study_file};
use crate::analysis::sensitivity::Sensitivity;
use crate::analysis::{firmware, sensitivity};
use sagnac_base::quantity::number::significant;
use sagnac_engine::filler::read::Error;
use sagnac_engine::study::Study;
use sagnac_report::chart::Picture;
use sagnac_report::page::{Block, Cell, Grid, Page, Section};
use sagnac_theory::gap::Weights;

/// The page of a design from its chart.
pub fn of_design(found: &Design, sheet: Option<&Sheet>, picture: Picture) -> Page {
    let study = &found.study;
    let duration = report::duration(found.variant().duration_s);
    let runs = format!("{} of {duration}", significant(found.trials as f64, 9));
    let made = Block::Facts(vec![
        ("Runs at each interval", vec![runs]),
        ("Seed", vec![study.seed.to_string()]),
        ("Chosen by", vec![format!("the {} without the non-magnetic drift", found.measure.label())]),
    ]);
    let trade = report::pareto_figure(found).map(|figure| chart("pareto", Picture::Curves(figure)));
    let (pareto, fillers) = (report::pareto_table(found), report::filler_table(found));
    let front = pareto.as_ref().map(|table| Block::Grid(grid(table, &["constants"])));
    let trade = trade.into_iter().chain(front);
    let at_best = Block::Grid(grid(&fillers, &["constants", "duration", "residual_max", "rule_bound"]));
    Page {
        title: study.title.clone(),
        scope: String::new(),
        subtitle: "How often should the gyro switch, and with which filler?".to_owned(),
        answer: found.answer(sheet),
        notes: found.notes.clone(),
        sections: vec![
            Section::new("drift", "Drift over the switching interval", [chart("design", picture)]),
            Section::new("trade", "What latency and memory cost", trade),
            Section::new("fillers", "Fillers at their best intervals", [at_best]),
            Section::new("source", "How it was made", [made, study_file(study, found.trials)]),
        ],
        tables: [("design.csv", report::table(found)), ("fillers.csv", fillers)]
            .into_iter()
            .chain(pareto.map(|table| ("pareto.csv", table)))
            .collect(),
    }
}

/// Denominators up to this are shown as fractions.
const MAX_DENOMINATOR: i64 = 999;

/// The page of fillers at a point of a study.
pub fn of_filler(study: &Study, firmware: &Firmware) -> Page {
    let place = firmware.place();
    let place = if place.is_empty() { place } else { format!(", at {place}") };
    let search = firmware.trade.as_ref().map_or(vec![], |trade| {
        vec![chart("trade", Picture::Curves(trade.figure())), Block::Grid(of_trade(trade))]
    });
    let fillers = firmware.fillers();
    let of_fillers = std::iter::once(Block::Grid(grid(&fillers, &["largest_input", "method"])));
    let weights = firmware.designs.iter().flat_map(|design| rules(firmware, design));
    let header = vec![Block::File(HEADER.to_owned(), firmware.header()), study_file(study, study.trials)];
    let trade = firmware.trade.as_ref().map(|trade| ("trade.csv", trade.table()));
    Page {
        title: firmware.title.clone(),
        scope: String::new(),
        subtitle: format!(
            "Which filler belongs in the firmware? Weights for a gap of {}{place}",
            firmware.lost()
        ),
        answer: firmware.answer(),
        notes: vec![],
        sections: vec![
            Section::new("search", "Ticks before and after the gap", search),
            Section::new("fillers", "Fillers", of_fillers.chain(weights)),
            Section::new(
                "response",
                "Response to vibration",
                [chart("response", Picture::Curves(firmware.response()))],
            ),
            Section::new("source", "For the firmware", header),
        ],
        tables: trade
            .into_iter()
            .chain([("fillers.csv", fillers), ("weights.csv", firmware.weights())])
            .collect(),
    }
}

/// The best numbers of ticks before the gap for each number after it.
fn of_trade(trade: &Trade) -> Grid {
    let head = ["ticks after", "latency, ms", "ticks before", "rms, ″", "99.73 %, ″"];
    let row = |one: Candidate| {
        let Candidate { before, after, rms, level, .. } = one;
        let [latency, rms, level] =
            [1e3 * trade.latency_s(one), rms, level].map(|value| significant(value, 4));
        [after.to_string(), latency, before.to_string(), rms, level]
    };
    Grid::new(head, trade.rows().into_iter().map(row))
}

/// The rules of a filler with their gains and errors.
fn rules(firmware: &Firmware, design: &firmware::Design) -> Vec<Block> {
    let rules = design.rules().flat_map(|(error, rule, closed)| {
        let (letter, name) = match error {
            Error::Residual => ('I', "interpolation"),
            Error::Extrapolation | Error::InGap => ('E', "extrapolation while the gap is open"),
        };
        let title = format!("{}: {name} {letter}", design.name);
        [Block::More(title, weights(firmware, rule, letter)), Block::Facts(facts(firmware, rule, closed))]
    });
    let exported = design.exported_rms.map(|rms| {
        let rms = significant(rms, 5);
        Block::Note(format!("{}: the C header, given whole pulses, leaves {rms}″ rms.", design.name))
    });
    let single = design.rules().any(|(_, rule, _)| rule.rows.len() != firmware.gap_ticks as usize);
    let single = single.then(|| Block::Note(format!("{}: only the sum over the gap.", design.name)));
    let open = design.extrapolation.is_none();
    let open = open.then(|| Block::Note(format!("{}: no value while the gap is open.", design.name)));
    rules.chain(exported).chain(single).chain(open).collect()
}

/// A row for each tick, with a cell for each lost tick and their sum.
fn weights(firmware: &Firmware, rule: &Rule, letter: char) -> Grid {
    let whole = rule.whole();
    let single = rule.rows.iter().filter(|_| rule.rows.len() == firmware.gap_ticks as usize);
    let single = single.map(|row| Weights {
        numerators: row.iter().map(|weight| i64::from(*weight)).collect(),
        ..whole.clone()
    });
    let single: Vec<Weights> = single.collect();
    let names = (1..=single.len()).map(|j| format!("{letter}{j}"));
    let head = std::iter::once("tick".to_owned()).chain(names).chain(["sum".to_owned()]);
    let columns: Vec<Weights> = single.into_iter().chain([whole]).collect();
    let fractions: Option<Vec<Vec<String>>> = columns.iter().map(fractions).collect();
    let cells: Vec<Vec<Cell>> = match fractions {
        Some(fractions) => {
            fractions.into_iter().map(|all| all.into_iter().map(Cell::from).collect()).collect()
        }
        None => columns.iter().map(decimals).collect(),
    };
    let row = |(place, tick): (usize, &i32)| {
        let cells = cells.iter().map(|column| column[place].clone());
        std::iter::once(minus(&tick.to_string()).into()).chain(cells).collect::<Vec<_>>()
    };
    Grid::new(head, rule.ticks.iter().enumerate().map(row))
}

fn facts(firmware: &Firmware, rule: &Rule, closed: Closed) -> Vec<(&'static str, Vec<String>)> {
    let (whole, number) = (rule.whole(), |x: f64| significant(x, 5));
    let how = if rule.exact { "exact" } else { "rounded to the nearest with Σw kept" };
    let gains = format!(
        "Σw = {}   √Σw² = {}   Σ|w| = {}",
        firmware.gap_ticks,
        number(whole.noise_gain()),
        number(whole.largest_gain())
    );
    let amplitude = closed.amplitude.zip(firmware.tone).map(|(amplitude, (rate, nu))| {
        format!("{}″ at {} Hz and {} ″/s", number(amplitude), number(nu), number(rate))
    });
    let rms = closed.rms.filter(|rms| *rms > 0.0).map(|rms| format!("{}″", number(rms)));
    let optional = [("Amplitude of the error", amplitude), ("rms error with noise", rms)];
    let optional = optional.into_iter().filter_map(|(name, text)| Some((name, vec![text?])));
    let weights = format!("{how}, over {}", denominator(rule.denominator));
    [("Weights", vec![weights]), ("Gains", vec![gains])].into_iter().chain(optional).collect()
}

/// Weights as reduced fractions, if all of them have small denominators.
fn fractions(weights: &Weights) -> Option<Vec<String>> {
    let fraction = |w: &i64| {
        let divisor = common_divisor(*w, weights.denominator);
        let (above, below) = (w / divisor, weights.denominator / divisor);
        match below {
            1 => Some(minus(&above.to_string())),
            below if below <= MAX_DENOMINATOR => Some(minus(&format!("{above}/{below}"))),
            _ => None,
        }
    };
    weights.numerators.iter().map(fraction).collect()
}

/// Weights as decimal numbers over their numerators.
fn decimals(weights: &Weights) -> Vec<Cell> {
    let cell = |(value, numerator): (f64, &i64)| Cell {
        text: minus(&significant(value, 6)),
        below: minus(&numerator.to_string()),
    };
    weights.values().zip(&weights.numerators).map(cell).collect()
}

/// A denominator as `2^24` if it is a power of two, else as a number.
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

/// The page of a sensitivity.
pub fn of_sensitivity(study: &Study, found: &Sensitivity) -> Page {
    let picture = Picture::Curves(sensitivity::report::figure(study, found));
    let table = sensitivity::report::table(found);
    let rows = found.rows.iter().map(|(column, value)| format!(" --where \"{column}={value}\""));
    let trials = found.trials.map(|trials| format!(" --trials {trials}")).unwrap_or_default();
    let command = format!(
        "sagnac sensitivity study.toml --by {}{} --samples {}{trials}",
        found.answer.name,
        rows.collect::<String>(),
        found.samples
    );
    let made = vec![
        Block::Facts(vec![
            ("Evaluations", vec![sensitivity::report::effort(found)]),
            ("Seed", vec![study.seed.to_string()]),
        ]),
        Block::Text("To repeat it, save the study as `study.toml` and run".to_owned()),
        Block::Command(command),
        study_file(study, study.trials),
    ];
    Page {
        title: study.title.clone(),
        scope: String::new(),
        subtitle: format!("Which uncertain input drives the {}?", found.answer.label),
        answer: found.answer(),
        notes: found.notes.clone(),
        sections: vec![
            Section::new("tornado", "The answer as one input varies", [chart("sensitivity", picture)]),
            Section::new("inputs", "Uncertain inputs", [Block::Grid(grid(&table, &["at_from", "at_to"]))]),
            Section::new("source", "How it was made", made),
        ],
        tables: vec![
            ("sensitivity.csv", table),
            ("distribution.csv", sensitivity::report::distribution(found)),
        ],
    }
}
