//! The columns that can select rows and span axes, and the rows selected by a chart's `where`.

use crate::chart::Named;
use crate::chart::ground::Ground;
use crate::key::given::Given;
use crate::key::holds::{Holds, unlimited};
use crate::key::scale::Scale;
use crate::key::setting::Swept;
use crate::key::sweep::Sweep;
use sagnac_base::quantity::units::Dimension;
use sagnac_base::source::diagnose::{Fault, choices};
use sagnac_base::table::{self, About, Cell, Cells, Column, ColumnError, Unit};

/// Values of τ.
const TIMES: Holds = unlimited(&[Dimension::Time]);

/// Most values of a sweep that a message lists.
const MAX_LISTED: usize = 12;

/// The columns of a table that are known before anything is sampled: the swept keys, and those of its ground.
#[derive(Clone, Copy)]
pub(crate) struct Known<'a> {
    pub(crate) sweeps: &'a [Sweep],
    pub(crate) ground: &'a Ground,
}

impl Known<'_> {
    /// Finds the column that `named` means among those that distinguish rows: a swept key, a text column, or τ.
    ///
    /// # Errors
    /// No column or several columns match; `cannot` begins the message, such as "`where` cannot choose rows by".
    pub(crate) fn chooser(self, named: &Named, cannot: &str) -> Result<String, Fault> {
        let texts = self.ground.texts.iter().map(|text| About::named(text.name));
        self.find(texts.chain(self.ground.along().copied()).collect(), named, cannot)
    }

    /// Finds the column that `named` means among the numeric ones: a swept key, or one that follows from it.
    ///
    /// # Errors
    /// It fails where [`Known::chooser`] does.
    pub(crate) fn coordinate(self, named: &Named, cannot: &str) -> Result<String, Fault> {
        self.find(self.ground.coordinates().copied().collect(), named, cannot)
    }

    /// Finds the column that `named` means among the swept keys and some `more`.
    fn find(self, more: Vec<About>, named: &Named, cannot: &str) -> Result<String, Fault> {
        let unit = |sweep: &Sweep| sweep.values.first().map_or(Unit::NONE, Swept::unit);
        let swept =
            self.sweeps.iter().map(|sweep| About { unit: unit(sweep), ..About::named(sweep.key.name) });
        let columns: Vec<Column> =
            swept.chain(more.iter().copied()).map(|about| about.with(Cells::default())).collect();
        let (name, span) = (&named.name, named.span.clone());
        let found = table::find(&columns, name).map_err(|error| match error {
            ColumnError::Ambiguous { .. } => {
                Fault::new(span, error.to_string(), "more than one", "write the whole name")
            }
            _ => {
                let known: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
                let more: Vec<&str> = more.iter().map(|about| about.name).collect();
                let label = match &more[..] {
                    [] => "not swept".to_owned(),
                    more => format!("neither swept nor {}", more.join(" nor ")),
                };
                Fault::new(span, format!("{cannot} `{name}`"), label, choices(name, &known))
            }
        })?;
        Ok(found.name.clone())
    }

    /// The default scale of an axis over this column: that of its sweep, or of the sweep on which it depends, else its own.
    pub(crate) fn scale_over(self, name: &str) -> Scale {
        if self.ground.columns.iter().any(|known| known.is_linear && known.is_called(name)) {
            return Scale::Linear;
        }
        let Ok(column) = self.coordinate(&name.into(), "no axis over") else { return Scale::default() };
        let followed = self.ground.coordinates().find(|known| known.name == column).map(|known| known.of);
        let key = followed.filter(|of| !of.is_empty()).unwrap_or(&column);
        self.sweeps.iter().find(|sweep| sweep.key.name == key).map_or(Scale::default(), |sweep| sweep.scale)
    }

    /// The column that one entry of `where` names, with its value there.
    pub(crate) fn row(self, named: &Named, given: Given) -> Result<(String, Cell), Fault> {
        let column = self.chooser(named, "`where` cannot choose rows by")?;
        let cell = if let Some(sweep) = self.sweeps.iter().find(|sweep| sweep.key.name == column) {
            swept_value(sweep, given)?.cell()
        } else if let Some(text) = self.ground.texts.iter().find(|text| text.name == column) {
            let known: Vec<&str> = text.values.iter().map(String::as_str).collect();
            if !given.is_text() || !known.contains(&given.text()) {
                let message = format!("no row has {column} = {given}");
                return Err(given.fault(message, "not in this study", choices(given.text(), &known)));
            }
            given.text().into()
        } else {
            // Whether the table has that τ is found out when the chart is drawn without estimates.
            given.read(&TIMES)?.into()
        };
        Ok((column, cell))
    }
}

/// The value of a sweep that tables show like the given one.
fn swept_value<'s>(sweep: &'s Sweep, given: Given) -> Result<&'s Swept, Fault> {
    let wanted = match sweep.key.is_name() {
        true => Swept::Name(given.text().to_owned()),
        false => Swept::Quantity(given.of(sweep.key).quantity()?),
    };
    let is_meant =
        |value: &&Swept| value.unit() == wanted.unit() && value.cell().text() == wanted.cell().text();
    sweep.values.iter().find(is_meant).ok_or_else(|| {
        let listed: Vec<String> = sweep.values.iter().take(MAX_LISTED).map(Swept::to_string).collect();
        let more = if sweep.values.len() > MAX_LISTED { ", …" } else { "" };
        let message = format!("no point has {} = {wanted}", sweep.key.name);
        let help = format!("accepted: {}{more}", listed.join(", "));
        given.fault(message, "not among the swept values", help)
    })
}
