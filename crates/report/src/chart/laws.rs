//! Lines of one law that are the same function of x.

use crate::chart::figure::{Figure, LawLine};

/// Largest difference between equal lines of a law: more than rounding, less than can be seen.
const NEAR: f64 = 1e-6;

impl Figure {
    /// Joins the lines of each law that lie on one curve, such as those of several gap lengths over Δt·ν.
    ///
    /// Where they overlap, each must pass through the points of the other. Between points a law is taken as a power of
    /// x, as laws of theory are. Lines without a common stretch stay separate.
    pub fn merge_laws(&mut self) {
        for law in &mut self.laws {
            let mut kept: Vec<LawLine> = vec![];
            for line in law.lines.drain(..).filter(|line| !line.points.is_empty()) {
                match kept.iter_mut().find(|other| same_law(&other.points, &line.points)) {
                    Some(other) => other.join(line),
                    None => kept.push(line),
                }
            }
            law.lines = kept;
        }
        self.laws.retain(|law| !law.lines.is_empty());
    }

    /// Reassigns the lines of laws for the colour `from` to the colour `to`.
    pub fn recolour_laws(&mut self, from: usize, to: usize) {
        let lines = self.laws.iter_mut().flat_map(|law| &mut law.lines);
        for colour in lines.flat_map(|line| &mut line.colours).filter(|colour| **colour == from) {
            *colour = to;
        }
    }
}

impl LawLine {
    fn join(&mut self, other: LawLine) {
        self.points.extend(other.points);
        self.points.sort_by(|a, b| a.0.total_cmp(&b.0));
        self.points.dedup_by(|a, b| a.0 == b.0);
        self.colours.extend(other.colours);
        self.colours.sort_unstable();
        self.colours.dedup();
    }

    /// The style of the single colour to which it applies.
    pub fn colour(&self) -> Option<usize> {
        only(&self.colours)
    }
}

/// The common style of several, if they are equal.
pub fn only(colours: &[usize]) -> Option<usize> {
    let (first, others) = colours.split_first()?;
    others.iter().all(|other| other == first).then_some(*first)
}

/// Whether two lines have a common stretch and agree on it.
fn same_law(a: &[(f64, f64)], b: &[(f64, f64)]) -> bool {
    let deviations = |points: &[(f64, f64)], line: &[(f64, f64)]| -> Vec<f64> {
        let of = |&(x, y): &(f64, f64)| on_line(line, x).map(|law| (y - law).abs() / y.abs().max(law.abs()));
        points.iter().filter_map(of).collect()
    };
    let all: Vec<f64> = deviations(a, b).into_iter().chain(deviations(b, a)).collect();
    !all.is_empty() && all.iter().all(|deviation| *deviation <= NEAR)
}

/// The value at `x` of the power law between the neighbouring points; `None` outside the line, or where it is not
/// positive.
fn on_line(line: &[(f64, f64)], x: f64) -> Option<f64> {
    if let Some((_, y)) = line.iter().find(|point| point.0 == x) {
        return Some(*y);
    }
    let next = line.iter().position(|point| point.0 > x).filter(|next| *next > 0)?;
    let [(x0, y0), (x1, y1)] = [line[next - 1], line[next]];
    let part = libm::log(x / x0) / libm::log(x1 / x0);
    Some(y0 * libm::pow(y1 / y0, part)).filter(|y| y.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chart::figure::Law;

    fn line(colour: usize, xs: &[f64], law: fn(f64) -> f64) -> LawLine {
        LawLine { colours: vec![colour], points: xs.iter().map(|&x| (x, law(x))).collect() }
    }

    fn merged(lines: Vec<LawLine>) -> Vec<(Vec<usize>, usize)> {
        let laws = vec![Law { label: String::new(), lines, is_area: false }];
        let mut figure = Figure { laws, ..Figure::default() };
        figure.merge_laws();
        let lines = figure.laws.into_iter().flat_map(|law| law.lines);
        lines.map(|line| (line.colours, line.points.len())).collect()
    }

    #[test]
    fn lines_on_one_power_law_become_one_whatever_their_points() {
        let cube = |x: f64| 7.0 * x * x * x;
        let lines = vec![line(0, &[1.0, 2.0, 4.0], cube), line(0, &[1.5, 3.0, 4.0, 6.0], cube)];
        assert_eq!(merged(lines), [(vec![0], 6)]);
        let lines = vec![line(1, &[1.0, 2.0], cube), line(2, &[1.0, 2.0], cube)];
        assert_eq!(merged(lines), [(vec![1, 2], 2)]);
    }

    #[test]
    fn lines_that_differ_or_have_no_stretch_in_common_stay_apart() {
        let lines = vec![line(0, &[1.0, 2.0], |x| x * x), line(1, &[1.0, 2.0], |x| x * x * x)];
        assert_eq!(merged(lines).len(), 2);
        let lines = vec![line(0, &[1.0, 2.0], |x| x), line(1, &[3.0, 4.0], |x| x)];
        assert_eq!(merged(lines).len(), 2);
    }

    #[test]
    fn a_law_without_values_is_left_out_and_one_of_zeros_is_not_compared_between_its_points() {
        assert_eq!(merged(vec![line(0, &[], |x| x)]), []);
        let lines = vec![line(0, &[1.0, 3.0], |_| 0.0), line(1, &[2.0], |_| 0.0)];
        assert_eq!(merged(lines).len(), 2);
    }
}
