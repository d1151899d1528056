//! Fillers without a study of their own, and the study made for them.

use std::fmt::Write as _;

use crate::analysis::firmware::{Asked, Firmware, Trade};
use crate::analysis::firmware::{ChoiceError, undetermined};
use miette::Diagnostic;
use sagnac_base::diagnostics::StudyError;
use sagnac_engine::kinds::gap_fill::GapFill;
use sagnac_engine::study::Study;
use sagnac_report::answer::reading::capitalized;

pub use sagnac_engine::filler::{DESIGNED as KINDS, MINIMUM_VARIANCE};

/// The properties of fillers; quantities are texts with units, as in a study.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Alone {
    /// Number of lost ticks n.
    pub gap_ticks: u32,
    /// Length of a tick, such as `5 ms`; without it a tick is the unit of time.
    pub tick: Option<String>,
    /// Ticks to which the residual is fitted, such as `-7..0,n+1,n+2`; by default −1, 0, n + 1, n + 2.
    pub fit_ticks: Option<String>,
    /// Ticks to which the extrapolation is fitted; by default −3 … 0, for minimum variance the fit ticks up to 0.
    pub extrapolation_ticks: Option<String>,
    /// Frequencies of the vibration, such as `18 Hz,22 Hz`, or a single one.
    pub band: Option<String>,
    /// Amplitude of the vibration, of its rate or angle, such as `12000 arcsec/s`.
    pub amplitude: Option<String>,
    /// Standard deviation of the noise of a tick, such as `0.5 arcsec`.
    pub noise: Option<String>,
}

impl Alone {
    /// The text of a gap-fill study of one point with fillers of these [`KINDS`], for
    /// [`Study::parse`](sagnac_engine::study::Study::parse), which reports any faults in them.
    ///
    /// ```
    /// # use sagnac::analysis::firmware::{Alone, Firmware};
    /// # use sagnac::study::Study;
    /// let text = Alone { gap_ticks: 3, ..Alone::default() }.study(&["quadratic"]);
    /// let study = Study::parse("quadratic", &text)?;
    /// let gap_fill = study.asked::<sagnac_engine::kinds::gap_fill::GapFill>().unwrap();
    /// let firmware = Firmware::new(&study, &gap_fill.points[0], &gap_fill.fillers)?;
    /// assert_eq!(firmware.designs[0].interpolation.whole().values().collect::<Vec<_>>(), [-1.0, 2.5, 2.5, -1.0]);
    /// # Ok::<(), sagnac_base::diagnostics::StudyError>(())
    /// ```
    pub fn study<K: AsRef<str>>(&self, kinds: &[K]) -> String {
        let kinds: Vec<&str> = kinds.iter().map(AsRef::as_ref).collect();
        let n = self.gap_ticks;
        let plural = if n == 1 { "" } else { "s" };
        // Without a tick length, a tick is the unit of time.
        let tick = quoted(self.tick.as_deref().unwrap_or("1 s"));
        let noise = quoted(self.noise.as_deref().unwrap_or("0 arcsec"));
        let mut text = format!(
            "title = \"{} over {n} lost tick{plural}\"\nkind = \"gap-fill\"\n\
             [gyro]\ntick = {tick}\ntick_noise = {{ std = {noise} }}\n[motion]\n",
            capitalized(&kinds.join(", "))
        );
        let band = self.band.as_deref().filter(|band| band.contains(',')).map(list);
        // Writing to a String cannot fail.
        let _ = match (&self.amplitude, &self.band) {
            (Some(amplitude), Some(alone)) => {
                let frequency = band.clone().unwrap_or_else(|| quoted(alone));
                writeln!(text, "amplitude = {}\nfrequency = {frequency}", quoted(amplitude))
            }
            _ => writeln!(text, "rate = \"0 arcsec/s\""),
        };
        let fillers = kinds.iter().map(|kind| {
            let mut table = format!("kind = \"{kind}\"");
            let ticks = [("fit_ticks", &self.fit_ticks), ("extrapolation_ticks", &self.extrapolation_ticks)];
            for (key, written) in ticks {
                table +=
                    &written.as_ref().map_or_else(String::new, |ticks| format!(", {key} = {}", list(ticks)));
            }
            if let Some(band) = band.as_ref().filter(|_| *kind == MINIMUM_VARIANCE) {
                table += &format!(", band = {band}");
            }
            format!("{{ {table} }}")
        });
        let fillers = fillers.collect::<Vec<_>>().join(", ");
        let _ = writeln!(text, "[switching]\ngap_ticks = {n}\nfillers = [{fillers}]");
        text
    }

    /// The study of fillers of these [`KINDS`] with its firmware. The fit ticks of the filler of least variance are searched if
    /// that is `asked` for. Without the length of a tick the firmware has none either.
    ///
    /// # Errors
    /// The properties describe no filler, which is an error in the text of the study, or no ticks determine one.
    pub fn firmware<K: AsRef<str>>(
        &self,
        kinds: &[K],
        asked: Option<Asked>,
    ) -> Result<(Study, Firmware), ChoiceError> {
        let mut study = Study::parse("fillers", &self.study(kinds))?;
        let mut trade = None;
        if let Some(asked) = asked {
            let inputs = study.asked::<GapFill>().and_then(|gap_fill| Some(&gap_fill.points.first()?.inputs));
            let found = inputs.and_then(|inputs| Trade::new(inputs, asked, None)).ok_or_else(|| {
                undetermined("give `noise = ANGLE` that the gyro really has, or a wider `band = LOW,HIGH`")
            })?;
            let alone = Alone { fit_ticks: Some(found.fit_ticks()), ..self.clone() };
            study = Study::parse("fillers", &alone.study(kinds))?;
            trade = Some(found);
        }
        let mut firmware = Firmware::choose(&study, &[], &[])?;
        firmware.trade = trade;
        if self.tick.is_none() {
            firmware.tick_s = None;
        }
        Ok((study, firmware))
    }
}

/// Keys of the study of [`Alone`] with the properties that they have, longer keys first.
const PROPERTIES: [(&str, &str); 8] = [
    ("switching.extrapolation_ticks", "extrapolation_ticks"),
    ("switching.fit_ticks", "fit_ticks"),
    ("switching.gap_ticks", "gap_ticks"),
    ("motion.amplitude", "amplitude"),
    ("motion.frequency", "band"),
    ("gyro.tick_noise.std", "noise"),
    ("gyro.tick_noise", "noise"),
    ("gyro.tick", "tick"),
];

/// An error of the study of [`Alone`] in terms of its properties as a front end spells them, because nobody knows its text.
pub fn in_properties(error: &StudyError, spell: impl Fn(&str) -> String) -> String {
    let help = error.help().map_or_else(String::new, |help| format!("\n{help}"));
    let text = format!("{error}{help}").replace("switching.fillers", "the filler");
    PROPERTIES.iter().fold(text, |text, (key, property)| text.replace(key, &spell(property)))
}

/// A text in TOML notation.
fn quoted(text: &str) -> String {
    toml::Value::from(text.trim()).to_string()
}

/// Converts texts separated by commas to a list.
fn list(texts: &str) -> String {
    let each: Vec<String> = texts.split(',').map(quoted).collect();
    format!("[{}]", each.join(", "))
}
