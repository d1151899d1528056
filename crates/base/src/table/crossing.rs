//! Where a curve crosses a limit between two rows.

use crate::table::{Cell, Column, Role, Table};

/// A stretch of a curve within a limit; an end is absent where the curve ends within it.
pub type Window = [Option<f64>; 2];

/// The stretches of a curve through `rows`, in the order of `x`, within which the magnitude of a value is at most `limit`.
/// Their ends lie between rows, or at rows where a count leads from one to the next.
pub fn windows(
    table: &Table,
    x: &Column,
    rows: &[usize],
    limit: f64,
    value: impl Fn(usize) -> f64,
) -> Vec<Window> {
    let is_above = |row: usize| value(row).abs() > limit;
    let stretches: Vec<&[usize]> = rows.chunk_by(|&a, &b| is_above(a) == is_above(b)).collect();
    let crossing = |before: usize, after: usize, inner: usize| match counts_between(table, before, after) {
        true => x.value(inner),
        false => {
            let part = fraction(value(before), value(after), limit);
            between(x.value(before), x.value(after), part)
        }
    };
    let window = |at: usize| {
        let rows = stretches[at];
        let (first, last) = (rows[0], rows[rows.len() - 1]);
        let before =
            at.checked_sub(1).map(|at| crossing(stretches[at][stretches[at].len() - 1], first, first));
        let after = stretches.get(at + 1).map(|next| crossing(last, next[0], last));
        [before, after]
    };
    (0..stretches.len()).filter(|&at| !is_above(stretches[at][0])).map(window).collect()
}

/// Whether a count leads from one row to the other, so that nothing lies between them.
fn counts_between(table: &Table, a: usize, b: usize) -> bool {
    table.columns.iter().filter(|column| !matches!(column.role, Role::Trials | Role::Count)).any(|column| {
        let (a, b) = (&column.cells[a], &column.cells[b]);
        matches!((a, b), (Cell::Integer(_), Cell::Integer(_))) && a != b
    })
}

/// The fraction of the way from a to b at which the limit lies, one of the two being beyond it; on a logarithmic scale
/// where possible.
pub fn fraction(a: f64, b: f64, limit: f64) -> f64 {
    let beyond = if a.abs() > b.abs() { a } else { b };
    let limit = limit * beyond.signum();
    match a == b {
        true => 0.0,
        false if a * b > 0.0 => libm::log(limit / a) / libm::log(b / a),
        false => (limit - a) / (b - a),
    }
}

/// The number that fraction of the way from a to b, on a logarithmic scale where possible.
pub fn between(a: f64, b: f64, part: f64) -> f64 {
    if a > 0.0 && b > 0.0 { a * libm::pow(b / a, part) } else { a + (b - a) * part }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(x: &[Cell], y: &[f64], limit: f64) -> Vec<Window> {
        let column = |name: &str, cells: Vec<Cell>| Column {
            name: name.to_owned(),
            label: name.to_owned(),
            cells: cells.into(),
            ..Column::default()
        };
        let table = Table { columns: vec![column("x", x.to_vec())] };
        let rows: Vec<usize> = (0..x.len()).collect();
        windows(&table, &table.columns[0], &rows, limit, |row| y[row])
    }

    /// Windows at 1, 2, 4, 8, …
    fn doubling(y: &[f64], limit: f64) -> Vec<Window> {
        let x: Vec<Cell> = (0..y.len()).map(|at| Cell::Number((1_u32 << at).into())).collect();
        of(&x, y, limit)
    }

    #[test]
    fn crossings_are_found_on_logarithmic_scales() {
        // 5·(x/2)² is 10 at 2√2.
        let [[None, Some(end)]] = doubling(&[1.0, 5.0, 20.0], 10.0)[..] else { panic!("no single window") };
        assert!((end - 8_f64.sqrt()).abs() < 1e-12, "{end}");
        let [[Some(from), None]] = doubling(&[20.0, 5.0, 1.0], 10.0)[..] else { panic!("no single window") };
        assert!((from - 2_f64.sqrt()).abs() < 1e-12, "{from}");
    }

    #[test]
    fn magnitudes_count_and_signs_are_crossed_on_a_linear_scale() {
        let [[Some(from), Some(to)]] = doubling(&[-40.0, -5.0, 20.0], 10.0)[..] else {
            panic!("no single window")
        };
        assert!((from - libm::pow(2.0, 2.0 / 3.0)).abs() < 1e-12, "{from}");
        assert!((to - libm::pow(2.0, 1.0 + 15.0 / 25.0)).abs() < 1e-12, "{to}");
    }

    #[test]
    fn a_curve_may_be_within_the_limit_several_times_always_or_never() {
        let found = doubling(&[1.0, 20.0, 1.0, 20.0, 1.0], 10.0);
        assert!(matches!(found[..], [[None, Some(_)], [Some(_), Some(_)], [Some(_), None]]), "{found:?}");
        assert_eq!(doubling(&[1.0, 10.0], 10.0), [[None, None]]);
        assert!(doubling(&[11.0, 20.0], 10.0).is_empty());
    }

    #[test]
    fn nothing_lies_between_counts() {
        let counts = [1, 2, 3].map(Cell::Integer);
        assert_eq!(of(&counts, &[1.0, 5.0, 20.0], 10.0), [[None, Some(2.0)]]);
        assert_eq!(of(&counts, &[20.0, 5.0, 1.0], 10.0), [[Some(2.0), None]]);
    }
}
