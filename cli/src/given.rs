//! Which options stand on the command line, and those of them that a curve does not have.

use std::path::Path;

use clap::parser::ValueSource;
use clap::{ArgMatches, Args, Command, Error, FromArgMatches, Id};

use crate::failure::Failure;

const RANGE: &str = "set the range of the fit by --fit-from and --fit-to";
const LEAVE_OUT: &str = "leave it out";

/// The options that need a log, by their names with underscores, with what to do for a curve.
const OF_LOGS: [(&str, &str); 26] = [
    ("bootstrap", LEAVE_OUT),
    ("compensate", LEAVE_OUT),
    ("decimal", LEAVE_OUT),
    ("detrend", "give the terms of the fit without R, as in --fit Q,N,B,K"),
    ("deviation", "choose the column of an Allan deviation by --column"),
    ("duplicates", LEAVE_OUT),
    ("dynamic", LEAVE_OUT),
    ("hat", "give logs of three units"),
    ("intervals", "give the errors of the points by --curve-interval"),
    ("navigate", LEAVE_OUT),
    ("no_psd", LEAVE_OUT),
    ("position_limit", LEAVE_OUT),
    ("record", LEAVE_OUT),
    ("remove_events", LEAVE_OUT),
    ("remove_outliers", LEAVE_OUT),
    ("scale", "give the unit of the deviations by --unit"),
    ("segment", LEAVE_OUT),
    ("segment_detrend", LEAVE_OUT),
    ("skip", RANGE),
    ("tau", RANGE),
    ("temperature", LEAVE_OUT),
    ("temperature_terms", LEAVE_OUT),
    ("temperature_unit", LEAVE_OUT),
    ("unit_check", LEAVE_OUT),
    ("until", RANGE),
    // Of `model`; that of `allan` is the probability of intervals in a file that does not state it.
    ("band_confidence", "its band is that of the 95 % intervals of its points: leave it out"),
];

/// The options on the command line; a struct of options has it first, because others take theirs away.
#[derive(Debug, Clone, Default)]
pub struct Given(Vec<String>);

impl Given {
    /// Checks that no option needs a log where there is only a curve at `path`.
    ///
    /// # Errors
    /// One does, and the message names it and says what to do.
    pub fn check_curve(&self, path: &Path) -> Result<(), Failure> {
        let is_given = |(name, _): &&(&str, &str)| self.0.iter().any(|given| given == name);
        let Some((name, advice)) = OF_LOGS.iter().find(is_given) else { return Ok(()) };
        let option = name.trim_start_matches("band_").replace('_', "-");
        let message = format!("--{option} needs a log, and {} is a curve\n{advice}", path.display());
        Err(Failure::Usage(message))
    }
}

impl FromArgMatches for Given {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Given, Error> {
        let is_given = |id: &&Id| matches.value_source(id.as_str()) == Some(ValueSource::CommandLine);
        Ok(Given(matches.ids().filter(is_given).map(ToString::to_string).collect()))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), Error> {
        *self = Given::from_arg_matches(matches)?;
        Ok(())
    }
}

impl Args for Given {
    fn augment_args(command: Command) -> Command {
        command
    }

    fn augment_args_for_update(command: Command) -> Command {
        command
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The options that a curve has, and those that make its file a log.
    const OF_CURVES: [&str; 31] = [
        "binary",
        "column",
        "confidence",
        "curve_interval",
        "data",
        "files",
        "file",
        "fit",
        "fit_from",
        "fit_to",
        "filter_rate",
        "force",
        "from",
        "json",
        "kalibr",
        "limit",
        "margin",
        "max_ratio",
        "out",
        "overbound",
        "quantization",
        "quiet",
        "rate",
        "states",
        "time",
        "time_unit",
        "to",
        "unit",
        "verbose",
        "write",
        "table",
    ];

    #[test]
    fn every_option_of_logs_is_of_curves_too_or_refused() {
        let command = crate::program::command();
        for name in ["allan", "compare", "model"] {
            let command = command.find_subcommand(name).unwrap();
            for argument in command.get_arguments() {
                let id = argument.get_id().as_str();
                let is_output = argument.get_help_heading() == Some("Output") && id != "record";
                let is_refused = OF_LOGS.iter().any(|(other, _)| *other == id);
                let is_known = OF_CURVES.contains(&id) || is_output;
                assert!(
                    is_refused != is_known,
                    "{name}: {id} is refused of a curve: {is_refused}, and known: {is_known}"
                );
            }
        }
    }
}
