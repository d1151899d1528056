//! Tables of a study as written: lookup of values by the rows of keys, and the check of everything in them.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::key::given::Given;
use crate::key::holds::Holds;
use crate::key::row::{Key, joined};
use sagnac_base::source::diagnose::{Fault, choices};

/// A table as written.
#[derive(Clone)]
pub(crate) struct Table<'a> {
    /// Its path from the root; empty for the root.
    pub(crate) name: &'static str,
    pub(crate) entries: &'a DeTable<'a>,
    pub(crate) span: Range<usize>,
}

impl<'a> Table<'a> {
    /// The root table `name` of a text.
    pub(crate) fn root(name: &'static str, text: &'a Spanned<DeTable<'a>>) -> Table<'a> {
        Table { name, entries: text.get_ref(), span: text.span() }
    }

    /// The value of a key of this table, or of a table within it.
    pub(crate) fn get(&self, key: &'static Key) -> Option<Given<'a>> {
        let (path, mut entries) = (key.name.strip_prefix(self.name)?.trim_start_matches('.'), self.entries);
        let (tables, last) = path.rsplit_once('.').unwrap_or(("", path));
        for table in tables.split('.').filter(|table| !table.is_empty()) {
            entries = entries.get(table)?.get_ref().as_table()?;
        }
        Some(Given { key, value: entries.get(last)? })
    }

    /// The place of a key.
    pub(crate) fn span_of(&self, key: &'static Key) -> Option<Range<usize>> {
        self.get(key).map(|given| given.span())
    }

    /// The value of a required key.
    pub(crate) fn needed(&self, key: &'static Key) -> Result<Given<'a>, Fault> {
        self.get(key).ok_or_else(|| Fault::missing_key(key.name, key.example, self.innermost(key)))
    }

    /// The place of the innermost existing table of a key.
    fn innermost(&self, key: &Key) -> Range<usize> {
        let path = key.table().strip_prefix(self.name).unwrap_or_default();
        let (mut entries, mut span) = (self.entries, self.span.clone());
        for table in path.split('.').filter(|table| !table.is_empty()) {
            let Some(value) = entries.get(table) else { break };
            let DeValue::Table(inner) = value.get_ref() else { break };
            (entries, span) = (inner, value.span());
        }
        span
    }
}

/// Gives the fault of an unexpected key where more can be said than that it is unknown.
pub(crate) type Stray<'s> = &'s dyn Fn(&str, Range<usize>) -> Option<Fault>;

/// Refuses keys other than `keys`, values of the wrong shape, and tables that lack a required key.
pub(crate) fn check(table: &Table, keys: &[&'static Key], stray: Stray) -> Result<(), Fault> {
    // In the order written, so that the first fault is reported first.
    let mut entries: Vec<_> = table.entries.iter().collect();
    entries.sort_by_key(|(name, _)| name.span().start);
    let own = || keys.iter().copied().filter(|key| key.table() == table.name);
    for (name, value) in entries {
        let written = name.get_ref();
        let Some(key) = own().find(|key| key.last() == written) else {
            let known: Vec<&str> = own().map(Key::last).collect();
            let unknown = || {
                let message = format!("unknown key `{written}`");
                Fault::new(name.span(), message, "not a key of this table", choices(written, &known))
            };
            return Err(stray(&joined(table.name, written), value.span()).unwrap_or_else(unknown));
        };
        check_value(Given { key, value }, &key.holds, false, keys, stray)?;
    }
    match own().find(|key| key.required && table.get(key).is_none()) {
        Some(key) => Err(Fault::missing_key(key.name, key.example, table.span.clone())),
        None => Ok(()),
    }
}

fn check_value(
    given: Given,
    holds: &Holds,
    item: bool,
    keys: &[&'static Key],
    stray: Stray,
) -> Result<(), Fault> {
    let shape = match holds {
        Holds::Either(shapes) => shapes.iter().find(|shape| has_shape(given, shape)),
        shape => Some(shape).filter(|shape| has_shape(given, shape)),
    };
    match (shape, given.table()) {
        (None, _) => Err(wrong_shape(given, item)),
        (Some(Holds::Pair(_)), _) if given.items().len() != 2 => {
            let message = format!("{} needs two values, not {}", given.key.name, given.items().len());
            Err(given.fault(message, "not two values", format!("write it as in\n{}", given.key.example)))
        }
        (Some(Holds::List(inner) | Holds::Pair(inner)), _) => {
            given.items().into_iter().try_for_each(|part| check_value(part, inner, true, keys, stray))
        }
        (Some(Holds::Word(words)), _) if !words.iter().any(|known| known.word == given.text()) => {
            let known: Vec<&str> = words.iter().map(|known| known.word).collect();
            let help = choices(given.text(), &known);
            Err(given.fault(format!("unknown value {given}"), "not one of the choices", help))
        }
        (Some(Holds::OneOf), Some(table)) if table.entries.len() != 1 => {
            check(&table, keys, stray)?;
            let forms = keys.iter().filter(|key| key.table() == table.name);
            let forms: Vec<&Key> = forms.copied().collect();
            let names: Vec<&str> = forms.iter().map(|key| key.last()).collect();
            let message = format!("{} needs exactly one of {}", table.name, names.join(", "));
            let examples: Vec<String> = forms.iter().map(|key| format!("{{ {} }}", key.example)).collect();
            Err(given.fault(message, "not exactly one", format!("accepted: {}", examples.join(", or "))))
        }
        (Some(Holds::Table | Holds::OneOf), Some(table)) => check(&table, keys, stray),
        (Some(Holds::Free), Some(table)) => {
            let mut parts = table.entries.iter().map(|(_, value)| Given { value, ..given });
            parts.try_for_each(|part| check_value(part, &Holds::Any, true, keys, stray))
        }
        _ => Ok(()),
    }
}

/// Whether a value has the required shape (text, number, list, …), regardless of its content.
fn has_shape(given: Given, holds: &Holds) -> bool {
    let value = given.value.get_ref();
    match holds {
        Holds::Text | Holds::Word(_) | Holds::Name(_) | Holds::File => value.is_str(),
        Holds::Flag => value.is_bool(),
        Holds::Whole(..) | Holds::Measure(_) | Holds::Percent | Holds::Any => {
            !value.is_array() && !value.is_table() && !value.is_datetime()
        }
        Holds::List(_) | Holds::Pair(_) => value.is_array(),
        Holds::Either(shapes) => shapes.iter().any(|shape| has_shape(given, shape)),
        Holds::Table | Holds::OneOf | Holds::Free => value.is_table(),
    }
}

/// The fault of a value whose shape (text, number, list, …) is wrong.
pub(crate) fn wrong_shape(given: Given, item: bool) -> Fault {
    let (name, what) = (given.key.name, given.described());
    let message = match item {
        true => format!("`{name}` cannot hold {what}"),
        false => format!("`{name}` is {what}, but must be {}", given.key.holds.described()),
    };
    given.fault(message, what, format!("write it as in\n{}", given.key.example))
}
