//! The relation of the curves to their limit, in one sentence for all.

use crate::chart::Limit;
use crate::quantity::list::listed;
use crate::quantity::number::{Side, digits_within, percent, rounded_to, significant};
use crate::table::{Column, grouped};
use crate::view::report::agreement::capitalised;
use crate::view::verdict::{Answer as Judged, Outcome, Window, places};

/// The verb for one curve and for several.
const STAY: [&str; 2] = ["stays", "stay"];

/// Most curves whose places are grouped.
const MOST_GROUPED: usize = 12;

/// Most curves without a common order of which each has a sentence.
const MOST_EACH: usize = 4;

/// The relation of the curves to their limit as a sentence: how many stay within it everywhere and how many nowhere,
/// and of those that exceed it which one does so last and which first. `None` without curves.
pub(crate) fn of_verdict(answers: &[Judged], limit: Limit) -> Option<String> {
    let value = limit.value;
    let (limit, most) = (&*limit.text(), |value: f64| Limit { value: rounded(value), ..limit }.text());
    let is_within = |one: &&Judged| one.outcome == Outcome::WithinUpTo && one.first.is_empty();
    let (within, others): (Vec<&Judged>, Vec<&Judged>) = answers.iter().partition(is_within);
    // The rest of open ones is unknown, as in an incomplete run, so they cannot be ordered.
    let (mut open, mut always): (Vec<&Judged>, Vec<&Judged>) = within.into_iter().partition(|one| one.open);
    let (never, partly): (Vec<&Judged>, Vec<&Judged>) =
        others.into_iter().partition(|one| one.outcome == Outcome::AboveFrom);
    // The one with the largest margin first.
    for curves in [&mut always, &mut open] {
        curves.sort_by(|a, b| a.most.total_cmp(&b.most));
    }
    let all = answers.len();
    let counted = |curves: &[&Judged], verbs: [&str; 2], how: &str, named: String| {
        let (count, verb) = (curves.len(), verbs[usize::from(curves.len() != 1)]);
        (count > 0).then(|| format!("{count} of {all} curves {verb} {how} ({named})"))
    };
    let with_most = |curves: &[&Judged]| {
        let named = curves.iter().map(|one| format!("{}, at most {}", one.name(), most(one.most)));
        first_of(curves.len(), named, "; ")
    };
    let with_least = |curves: &[&Judged]| {
        let named = curves.iter().map(|one| format!("{}, at least {}", one.name(), most(one.least)));
        first_of(curves.len(), named, "; ")
    };
    let parts = match all {
        0 => return None,
        1 if answers[0].at.is_empty() => {
            let one = &answers[0];
            let side = if one.outcome == Outcome::AboveFrom { "above" } else { "within" };
            return Some(format!("{}: {}, {side} {limit}.", capitalised(&one.name()), most(one.most)));
        }
        1 if always.len() == all => {
            let one = &answers[0];
            let name = if one.series.is_empty() { String::new() } else { one.name() + ": " };
            let told = format!("{name}within {limit} up to the last point, {}", place(one));
            return Some(format!("{}: at most {}.", capitalised(&told), most(one.most)));
        }
        1 => return Some(capitalised(&told(&answers[0], limit)) + "."),
        _ if always.len() == all => {
            // The one with the least margin is the last.
            let left = |one: &Judged| percent(1.0 - one.most / value);
            let worst = always.last().map(|one| {
                let upper = one.most_upper.filter(|upper| *upper > value);
                let open = upper.map(|upper| format!(", but its 95 % interval reaches {}", most(upper)));
                format!(
                    "; the largest is {} ({}), which leaves {} of the limit{}",
                    most(one.most),
                    one.name(),
                    left(one),
                    open.unwrap_or_default()
                )
            });
            let whole = if all == 2 { "Both".to_owned() } else { format!("All {all}") };
            return Some(format!("{whole} curves stay within {limit}{}.", worst.unwrap_or_default()));
        }
        _ if never.len() == all => {
            let nearest = never.iter().min_by(|a, b| a.least.total_cmp(&b.least));
            let nearest = nearest.map(|one| format!("; nearest is {} with {}", one.name(), most(one.least)));
            let whole = if all == 2 {
                "Neither of both curves".to_owned()
            } else {
                format!("None of the {all} curves")
            };
            return Some(format!("{whole} is within {limit}{}.", nearest.unwrap_or_default()));
        }
        _ => [
            counted(&always, STAY, &format!("within {limit}"), with_most(&always)),
            counted(&open, STAY, &format!("within {limit} as far as there are values"), with_most(&open)),
            order(&partly, limit, partly.len() + never.len() < all),
            counted(&never, ["is", "are"], &format!("nowhere within {limit}"), with_least(&never)),
        ],
    };
    let said: Vec<String> = parts.into_iter().flatten().collect();
    Some(capitalised(&said.join("; ")) + ".")
}

/// The outcomes of curves that leave the range within the limit.
const LEAVE: [Outcome; 3] = [Outcome::Passes, Outcome::LastWithin, Outcome::WithinUpTo];

/// Of the curves that are partly within the limit, the one that is so longest or first, and the one shortest or last.
/// Curves that leave the range and curves that enter it have no common order and are counted. `are_others` says that
/// some never exceed the limit, so that none of these is the longest of all.
fn order(curves: &[&Judged], limit: &str, are_others: bool) -> Option<String> {
    let at = |answer: &Judged| answer.at.first().map_or(0.0, |at| at.1);
    // A curve without values at first, or within the limit once more, cannot be ordered.
    let is_plain = |answer: &Judged| answer.again.is_empty() && answer.first.is_empty();
    let all_are = |outcomes: &[Outcome]| {
        curves.iter().all(|answer| is_plain(answer) && outcomes.contains(&answer.outcome))
    };
    let greatest = curves.iter().max_by(|a, b| at(a).total_cmp(&at(b)))?;
    let least = curves.iter().min_by(|a, b| at(a).total_cmp(&at(b)))?;
    // All curves with the same value as one, to the digits shown.
    let alike = |one: &Judged| {
        let there = place(one);
        curves.iter().copied().filter(|answer| place(answer) == there).collect::<Vec<_>>()
    };
    let there = |one: &Judged| names(&alike(one));
    let (verbs, first, other, how, best, worst) = if all_are(&LEAVE) {
        (STAY, "longest", "shortest", "up to", greatest, least)
    } else if all_are(&[Outcome::WithinFrom]) {
        (["is", "are"], "first", "last", "from", least, greatest)
    } else {
        if let Some(between) = between(curves) {
            return Some(format!("within {limit}: {between}"));
        }
        return Some(match curves[..] {
            [one] => told(one, limit),
            _ if curves.len() <= MOST_EACH => {
                let each: Vec<String> = curves.iter().map(|one| told(one, limit)).collect();
                each.join("; ")
            }
            _ => format!("{} are within {limit} in part ({})", curves.len(), names(curves)),
        });
    };
    let is_same = place(best) == place(worst);
    if let Some(each) = by_first(curves, how).filter(|_| !is_same) {
        return Some(format!("within {limit}: {each}"));
    }
    let others = if are_others { "of the others, " } else { "" };
    let side = |one: &Judged| format!("{}, {how} {}", there(one), place(one));
    if is_same {
        return Some(format!("{others}within {limit}: {}", side(best)));
    }
    let mut sides = vec![
        format!(
            "{others}{} {} within {limit} {first}, {how} {}",
            there(best),
            verbs[usize::from(alike(best).len() != 1)],
            place(best)
        ),
        format!("{} {other}, {how} {}", there(worst), place(worst)),
    ];
    if curves.len() <= MOST_EACH {
        let is_between = |one: &&&Judged| ![place(best), place(worst)].contains(&place(one));
        let mut between: Vec<&Judged> = curves.iter().filter(is_between).copied().collect();
        between.sort_by(|a, b| (at(a) - at(best)).abs().total_cmp(&(at(b) - at(best)).abs()));
        let mut between: Vec<String> = between.into_iter().map(side).collect();
        between.dedup();
        sides.splice(1..1, between);
    }
    Some(sides.join("; "))
}

/// The place of an outcome on the axis alone, without what varies with it.
fn place(one: &Judged) -> String {
    places(one.at.get(..1).unwrap_or_default(), one.outcome.side())
}

/// A curve as a sentence that names places on the axis alone.
fn told<'t>(one: &Judged<'t>, limit: &str) -> String {
    fn axis<'c>(at: &[(&'c Column, f64)]) -> Vec<(&'c Column, f64)> {
        at.iter().take(1).copied().collect()
    }
    let [at, until, first] = [&one.at, &one.until, &one.first].map(|at| axis(at));
    let window = |one: &Window<'t>| Window { from: axis(&one.from), until: axis(&one.until) };
    let again = one.again.iter().map(window).collect();
    let sentence = Judged { at, until, first, again, ..one.clone() }.sentence(limit);
    match (one.series.is_empty(), sentence.split_once(": ")) {
        (true, Some((_, outcome))) => outcome.to_owned(),
        _ => sentence,
    }
}

/// Curves that are each within the limit between two places, the widest first: `mv from frequency 382 to 418 Hz; const from
/// 394 to 406 Hz`. `None` for others.
fn between(curves: &[&Judged]) -> Option<String> {
    fn range<'t>(one: &Judged<'t>) -> Option<(&'t Column, f64, f64)> {
        let (column, from) = *one.at.first()?;
        Some((column, from, one.until.first()?.1))
    }
    let is_plain = |one: &&Judged| {
        one.outcome == Outcome::WithinBetween
            && one.again.is_empty()
            && one.first.is_empty()
            && range(one).is_some()
    };
    ((2..=MOST_EACH).contains(&curves.len()) && curves.iter().all(is_plain)).then_some(())?;
    let mut curves = curves.to_vec();
    let width = |one: &Judged| range(one).map_or(0.0, |(_, from, to)| to - from);
    curves.sort_by(|a, b| width(b).total_cmp(&width(a)));
    let told = curves.iter().enumerate().map(|(number, one)| {
        let (column, from, to) = range(one)?;
        let label = if number == 0 { format!("{} ", column.label) } else { String::new() };
        let digits = digits_within(from, to, 3);
        let [from, to] = [rounded_to(Side::Up, from, digits), rounded_to(Side::Down, to, digits)];
        let ends = format!("{from} to {to} {}", column.unit.symbol);
        Some(format!("{} from {label}{}", one.name(), ends.trim_end()))
    });
    Some(told.collect::<Option<Vec<String>>>()?.join("; "))
}

/// The places of curves that differ in two columns, of which the second has numbers: one part for each value of the first,
/// such as `const up to frequency 9, 6 and 4 Hz (Δt·ν = 0.045,
/// 0.03 and 0.02; n = 1, 2 and 3)`. `None` for other curves, or too many.
fn by_first(curves: &[&Judged], how: &str) -> Option<String> {
    let is_numbered = |one: &&Judged| one.series.len() == 2 && second(one).is_some() && !one.at.is_empty();
    ((2..=MOST_GROUPED).contains(&curves.len()) && curves.iter().all(is_numbered)).then_some(())?;
    let groups = grouped(0..curves.len(), |at| curves[at].series[0].1.text());
    let and = |values: &[(Side, f64)]| {
        let texts: Vec<String> = values.iter().map(|&(side, value)| rounded_to(side, value, 3)).collect();
        listed(&texts)
    };
    let told = groups.iter().map(|(name, places)| {
        let group: Vec<&Judged> = places.iter().map(|&at| curves[at]).collect();
        let (number, _) = second(group[0])?;
        let (place, _) = group[0].at[0];
        let of_axis = |axis: usize| -> Vec<(Side, f64)> {
            group.iter().filter_map(|one| Some((one.outcome.side(), one.at.get(axis)?.1))).collect()
        };
        let places = place.valued(&and(&of_axis(0)));
        let numbers: Vec<_> = group.iter().filter_map(|one| Some((Side::Nearest, second(one)?.1))).collect();
        let numbers = number.valued(&and(&numbers));
        // The same place on the other axis, as Δt·ν beside the frequency.
        let others = of_axis(1);
        let beside = match group[0].at.get(1) {
            Some((other, _)) if others.len() == group.len() => format!("{}; ", other.valued(&and(&others))),
            _ => String::new(),
        };
        Some(format!("{name} {how} {places} ({beside}{numbers})"))
    });
    Some(told.collect::<Option<Vec<String>>>()?.join("; "))
}

/// The second column that distinguishes a curve, with its number.
fn second<'t>(one: &Judged<'t>) -> Option<(&'t Column, f64)> {
    let (column, cell) = one.series.get(1)?;
    Some((column, cell.number()?))
}

/// The names of curves.
fn names(curves: &[&Judged]) -> String {
    // Names contain commas.
    let between = if curves.len() > 2 { "; " } else { " and " };
    first_of(curves.len(), curves.iter().map(|answer| answer.name()), between)
}

/// A value to three digits.
fn rounded(value: f64) -> f64 {
    significant(value, 3).parse().unwrap_or(value)
}

/// Some texts; of more than four the first three.
fn first_of(count: usize, texts: impl Iterator<Item = String>, between: &str) -> String {
    let shown: Vec<String> = texts.take(if count == 4 { 4 } else { 3 }).collect();
    let more = if count > shown.len() { " and others" } else { "" };
    format!("{}{more}", shown.join(between))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::Unit;
    use crate::view::report::tests::table;
    use crate::view::verdict::{Question, verdict};

    fn judged(curves: &[(&str, [f64; 3])]) -> String {
        let table = table("rms", curves);
        let question =
            Question { x: "frequency", y: "rms", series: vec!["filler"], filter: vec![], limit: 10.0 };
        of_verdict(&verdict(&table, &question).unwrap(), Limit { value: 10.0, unit: Unit::ARCSEC }).unwrap()
    }

    #[test]
    fn curves_that_leave_the_limit_are_told_by_how_far_they_stay_and_equal_ones_together() {
        let late = ("late", [1.0, 5.0, 20.0]);
        let early = [("a", [5.0, 20.0, 40.0]), ("b", [5.0, 20.0, 40.0])];
        assert_eq!(
            judged(&[early[0], late, early[1]]),
            "Late stays within 10 arcsec longest, up to frequency 2.82 Hz; a and b shortest, up to frequency 1.41 Hz."
        );
        assert_eq!(judged(&early), "Within 10 arcsec: a and b, up to frequency 1.41 Hz.");
        // Where there are few, those between are told in their order.
        let between = ("between", [1.0, 10.0, 40.0]);
        assert_eq!(
            judged(&[early[0], between, late]),
            "Late stays within 10 arcsec longest, up to frequency 2.82 Hz; between, up to frequency 2 Hz; a shortest, up to \
             frequency 1.41 Hz."
        );
    }

    #[test]
    fn curves_that_are_within_everywhere_and_nowhere_are_counted() {
        let (good, bad) = (("good", [1.0, 2.0, 3.0]), ("bad", [20.0, 30.0, 40.0]));
        assert_eq!(
            judged(&[good, ("fine", [1.0; 3])]),
            "Both curves stay within 10 arcsec; the largest is 3 arcsec (good), which leaves 70 % of the limit."
        );
        assert_eq!(
            judged(&[good]),
            "Good: within 10 arcsec up to the last point, frequency 4 Hz: at most 3 arcsec."
        );
        assert_eq!(
            judged(&[good, bad]),
            "1 of 2 curves stays within 10 arcsec (good, at most 3 arcsec); 1 of 2 curves is nowhere within 10 arcsec (bad, at least 20 arcsec)."
        );
        assert_eq!(
            judged(&[bad, ("worse", [30.0; 3])]),
            "Neither of both curves is within 10 arcsec; nearest is bad with 20 arcsec."
        );
    }

    #[test]
    fn curves_that_come_to_the_limit_and_that_leave_it_have_no_order() {
        let (comes, leaves, between) =
            (("comes", [20.0, 5.0, 2.0]), ("leaves", [2.0, 5.0, 20.0]), ("between", [20.0, 5.0, 20.0]));
        assert_eq!(
            judged(&[comes, leaves]),
            "Comes: within 10 arcsec from frequency 1.42 Hz on; leaves: rises above 10 arcsec at frequency 2.82 Hz."
        );
        assert_eq!(
            judged(&[comes, ("soon", [11.0, 5.0, 2.0])]),
            "Soon is within 10 arcsec first, from frequency 1.09 Hz; comes last, from frequency 1.42 Hz."
        );
        assert_eq!(
            judged(&[between, ("bad", [20.0; 3])]),
            "Between: within 10 arcsec from frequency 1.42 Hz to frequency 2.82 Hz; 1 of 2 curves is nowhere within 10 arcsec (bad, at least 20 arcsec)."
        );
    }

    #[test]
    fn curves_within_the_limit_between_two_places_are_told_the_widest_first_on_the_axis_alone() {
        let curves = [("narrow", [20.0, 5.0, 20.0]), ("wide", [11.0, 5.0, 11.0])];
        assert_eq!(
            judged(&curves),
            "Within 10 arcsec: wide from frequency 1.09 to 3.67 Hz; narrow from 1.42 to 2.82 Hz."
        );
    }

    #[test]
    fn values_that_are_missing_at_the_end_are_not_taken_for_within() {
        let open = ("open", [1.0, 2.0, f64::NAN]);
        let said = judged(&[open, ("good", [1.0, 2.0, 3.0])]);
        assert!(said.starts_with("1 of 2 curves stays within 10 arcsec (good, at most 3 arcsec)"), "{said}");
        assert!(
            said.contains(
                "1 of 2 curves stays within 10 arcsec as far as there are values (open, at most 2 arcsec)"
            ),
            "{said}"
        );
        // It has not exceeded the limit where its values end, and cannot be ordered among those that do.
        let early = judged(&[
            open,
            ("good", [1.0, 2.0, 3.0]),
            ("early", [1.0, 20.0, 20.0]),
            ("late", [1.0, 2.0, 20.0]),
        ]);
        assert!(early.contains("of the others, late stays within 10 arcsec longest, up to "), "{early}");
        assert!(early.contains("; early shortest, up to "), "{early}");
    }
}
