//! The last line of the sheet: the next lever, or why there is none.

use crate::analysis::decision::lever::{Also, Lever, Needed};
use crate::analysis::decision::sheet::Sheet;
use crate::analysis::decision::varied::Varied;
use crate::analysis::decision::words::{short, with_interval};
use crate::quantity::list::listed;
use crate::quantity::number::percent;
use crate::quantity::units::{Dimension, Quantity};
use crate::view::report::agreement::capitalised;

/// Why no lever is searched on curves with notches.
const NOTCHED: &str =
    "No single input is tried, because a change may move a notch to where the curve is judged.";

/// A change of an input after its name, such as ` 4 ms instead of 5 ms` or ` = 2 instead of 3`.
fn stepped(from: &Quantity, to: &Quantity) -> String {
    let equals = if to.dimension == Dimension::Count { " =" } else { "" };
    format!("{equals} {} instead of {}", short(*to), short(*from))
}

impl Sheet {
    /// The input whose change gains most, with what else meets the limit or gains more.
    pub(super) fn lever_told(&self) -> String {
        let Some(lever) = &self.lever else {
            return self.no_lever();
        };
        let Lever { key, label, gain, needed, remark, also, .. } = lever;
        let (from, to) = (short(lever.from), short(lever.to));
        let gain = with_interval(*gain, percent);
        let tried = format!("{to} instead of {from} gains {gain}");
        let name = format!("{} ({key})", capitalised(label));
        let told = match needed {
            Some(Needed::Value(value)) if *value == lever.to => {
                format!("{name}: {to} instead of {from} meets the limit and gains {gain}.")
            }
            Some(Needed::Value(value)) => format!("{name}: {} meets the limit; {tried}.", short(*value)),
            Some(Needed::NotEven(value, _)) if *value == lever.to => {
                format!("{name}: {tried}, but alone it does not meet the limit.")
            }
            Some(Needed::NotEven(value, left)) => format!(
                "{name}: {tried}, but alone it does not meet the limit: even {} leaves {}.",
                short(*value),
                self.shown(*left)
            ),
            None => format!("{name}: {tried}."),
        };
        let other = |Also { label, from, to, .. }: &Also| format!("{label}{}", stepped(from, to));
        let others: Vec<String> = also.iter().map(other).collect();
        let also = match &others[..] {
            [] => String::new(),
            [one] => format!("By itself, {one} would meet it too."),
            more => format!("Each by itself, {} would meet it too.", listed(more)),
        };
        let gains_more = |varied: &Varied| varied.gain > lever.gain.value && self.is_met() != Some(true);
        let varied = self.varied.as_ref().filter(|varied| gains_more(varied)).map(Varied::told);
        [told, remark.clone(), also, varied.unwrap_or_default()]
            .into_iter()
            .filter(|text| !text.is_empty())
            .collect::<Vec<_>>()
            .join(" ")
    }

    /// Why there is no lever, with what the study itself varies.
    fn no_lever(&self) -> String {
        if self.is_met() == Some(true) {
            return "None is needed, as the limit is met.".to_owned();
        }
        let [conditions, all] = &self.swept;
        let none = match self.met[1] {
            1 => "Changed by a quarter, no single input gains 1 %".to_owned(),
            all => format!(
                "Changed by a quarter, no single input lowers the largest under all {all} conditions by 1 %"
            ),
        };
        let here = match &self.only_here {
            Some(Lever { label, from, to, gain, .. }) => format!(
                "; {}{} gains {}{}, but then another condition is as bad",
                label,
                stepped(from, to),
                with_interval(*gain, percent),
                self.at()
            ),
            None => String::new(),
        };
        if let Some(told) = self.varied.as_ref().map(Varied::told) {
            return match (self.is_searched, self.is_notched) {
                (true, _) => format!("{none}{here}. {told}"),
                (false, true) => format!("{NOTCHED} {told}"),
                (false, false) => told,
            };
        }
        match (self.is_searched, &conditions[..], &all[..]) {
            (true, [], _) => format!("{none}{here}."),
            (true, conditions, _) => {
                format!("{none}, besides what the study varies ({}){here}.", listed(conditions))
            }
            (false, ..) if self.is_notched => NOTCHED.to_owned(),
            (false, _, []) => "None is searched for this estimate.".to_owned(),
            (false, _, all) => {
                format!("None is searched for this estimate; the study itself varies {}.", listed(all))
            }
        }
    }
}
