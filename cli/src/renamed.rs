//! Names of earlier versions among the arguments.

use std::ffi::OsString;

use sagnac::key::docs::{note, present};

/// Options whose values are names of columns, or of what has a limit, by themselves or before an equals sign.
const OF_NAMES: [&str; 8] = ["--by", "--limit", "--of", "--series", "--where", "--x", "--y", "--z"];

/// The arguments with present names for the former ones, and a note on each.
pub fn replaced(arguments: Vec<OsString>) -> (Vec<OsString>, Vec<String>) {
    let mut notes = vec![];
    let mut take = |former: &str| match present(former) {
        Some(present) => {
            notes.push(note(former, &present));
            present
        }
        None => former.to_owned(),
    };
    let mut names = |value: &str| {
        let (list, rest) = value.find('=').map_or((value, ""), |at| value.split_at(at));
        list.split(',').map(&mut take).collect::<Vec<_>>().join(",") + rest
    };
    let mut before = String::new();
    let mut replaced = vec![];
    for argument in arguments {
        let present = argument.to_str().map(|text| match text.split_once('=') {
            _ if OF_NAMES.contains(&&*before) => names(text),
            Some((option, value)) if OF_NAMES.contains(&option) => format!("{option}={}", names(value)),
            Some((option, value)) if option.starts_with("--") => format!("{}={value}", names(option)),
            None if text.starts_with("--") => names(text),
            _ => text.to_owned(),
        });
        before = argument.to_string_lossy().into_owned();
        replaced.push(present.map_or(argument, OsString::from));
    }
    (replaced, notes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn former_options_and_columns_are_replaced_and_names_of_files_are_not() {
        for (former, present, count) in [
            ("sensitivity oracle_rms.toml --by oracle_rms", "sensitivity oracle_rms.toml --by theory_rms", 1),
            ("report r --y=rms,oracle_rms --where q95=law", "report r --y=rms,theory_rms --where p95=law", 2),
            ("model a.csv --bound=repeat --out law", "model a.csv --overbound=repeat --out law", 1),
        ] {
            let (found, notes) = replaced(former.split(' ').map(OsString::from).collect());
            assert_eq!(found.join(" ".as_ref()), OsString::from(present));
            assert_eq!(notes.len(), count, "{notes:?}");
        }
    }
}
