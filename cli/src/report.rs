//! `sagnac report`.

use std::path::{Component, Path, PathBuf};

use clap::Args;
use sagnac::analysis::decision::Sheet;
use sagnac::run::{Plan, RESOLVED, keep};
use sagnac::study::Study;
use sagnac::view::report::FILE as REPORT;
use sagnac::view::report::gallery::{Card, gallery};
use sagnac::view::results::Results;

use crate::failure::Failure;
use crate::folders::{self, left_out, whole};
use crate::output::write;
use crate::progress::{self, Shown};
use crate::results::{decision, held, lacking};

/// The page of several studies.
const GALLERY: &str = "gallery.html";

#[derive(Debug, Args)]
#[command(after_long_help = EXAMPLES)]
pub struct Options {
    /// Results folders, or folders that contain them
    #[arg(required = true, value_name = "DIR")]
    folders: Vec<PathBuf>,
    /// File of the gallery of several studies [default: gallery.html in the common parent folder]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Print only errors
    #[arg(long, short)]
    quiet: bool,
    #[command(flatten)]
    progress: progress::Options,
}

const EXAMPLES: &str = "\
Examples:
  sagnac report results/error_vs_dtnu
  sagnac report results/my results/error_vs_dtnu --out both.html
  sagnac report results";

/// Rebuilds the reports of results, with a gallery for several. A damaged folder does not affect the others.
pub fn report(options: &Options) -> Result<(), Failure> {
    let folders = studies_in(&options.folders)?;
    for left_out in options.folders.iter().filter(|_| !options.quiet).filter_map(|folder| left_out(folder)) {
        say!("{left_out}");
    }
    let (mut reports, mut failures) = (Vec::new(), Vec::new());
    for folder in &folders {
        match of_folder(folder, options) {
            Ok(card) => {
                if !options.quiet {
                    say!("{}", folder.join(REPORT).display());
                }
                reports.push((folder.join(REPORT), card));
            }
            // The other folders still get their reports.
            Err(failure) => failures.push(failure),
        }
    }
    if reports.len() > 1 || (options.out.is_some() && !reports.is_empty()) {
        write_gallery(reports, &folders, options)?;
    }
    let last = failures.pop();
    for failure in &failures {
        let _ = failure.report();
    }
    last.map_or(Ok(()), Err)
}

/// Writes the page of all studies that have a report.
fn write_gallery(
    reports: Vec<(PathBuf, Card)>,
    folders: &[PathBuf],
    options: &Options,
) -> Result<(), Failure> {
    let path = options.out.clone().unwrap_or_else(|| common(folders).join(GALLERY));
    let here = path.parent().map_or_else(PathBuf::new, whole);
    let cards: Vec<Card> = reports
        .into_iter()
        .map(|(report, card)| Card { report: link(&here, &whole(&report)), ..card })
        .collect();
    write(&path, gallery(&cards).as_bytes())?;
    if !options.quiet {
        let here = std::env::current_dir().unwrap_or_default();
        say!("{}", path.strip_prefix(here).unwrap_or(&path).display());
    }
    Ok(())
}

/// Rebuilds the report of existing results, and returns its card for a gallery, without the link.
fn of_folder(folder: &Path, options: &Options) -> Result<Card, Failure> {
    let study = Study::read(&folder.join(RESOLVED))?;
    // Its charts are drawn at once, so nothing needs to be checked before.
    let plan = Plan::new(&study)?;
    let store = held(folder, &plan)?;
    // Folders of earlier versions lack the input files of the study.
    keep(&study, folder)?;
    let tables = plan.tables(&store, &Shown::new(options.progress.how(options.quiet)))?;
    let lacking = lacking(&study, &plan, &store, &tables)?;
    let results = Results::of::<Failure>(&study, &plan, &store, &tables, lacking, &[])?;
    let mut answer = results.answer(&results.verdicts()?)?;
    answer.sheet = decision(&study, &tables, lacking)?.as_ref().map(Sheet::lines).unwrap_or_default();
    let headline = answer.headline.clone();
    write(&folder.join(REPORT), results.page(answer).as_bytes())?;
    let picture = results.charts.into_iter().next().map(|drawn| drawn.picture);
    let (title, question) = (study.title.clone(), study.question.clone());
    let (folder, report) = (folder.display().to_string(), REPORT.to_owned());
    Ok(Card { title, question, headline, picture, folder, report })
}

/// The folders of studies: those given, and those inside other given folders.
fn studies_in(named: &[PathBuf]) -> Result<Vec<PathBuf>, Failure> {
    let mut studies: Vec<PathBuf> = Vec::new();
    for folder in named {
        if folders::is_study(folder) {
            studies.push(folder.clone());
            continue;
        }
        if folder.is_file() {
            let message = format!("{} is a file, not a folder of results", folder.display());
            return Err(Failure::Usage(message));
        }
        let failed = |error: std::io::Error| {
            Failure::Usage(format!("cannot read {}: {error}\ngive folders of results", folder.display()))
        };
        let mut found = folders::within(folder).map_err(failed)?;
        found.retain(|path| folders::is_study(path));
        if found.is_empty() {
            return Err(Failure::Usage(format!(
                "neither {} nor a folder in it has a {RESOLVED}\ngive folders that `sagnac run` wrote results to",
                folder.display()
            )));
        }
        studies.append(&mut found);
    }
    let mut is_new = folders::once(&[]);
    studies.retain(|folder| is_new(folder));
    Ok(studies)
}

/// The common parent folder of `folders`.
fn common(folders: &[PathBuf]) -> PathBuf {
    let mut paths = folders.iter().map(|folder| whole(folder));
    let first = paths.next().unwrap_or_default();
    let parent = first.parent().map(Path::to_owned).unwrap_or(first);
    paths.fold(parent, |common, path| {
        let shared = |ancestor: &&Path| path.starts_with(ancestor);
        common.ancestors().find(shared).map_or(common.clone(), Path::to_owned)
    })
}

/// The link to a file from pages in a folder, both as absolute paths.
fn link(from: &Path, to: &Path) -> String {
    let shared = from.components().zip(to.components()).take_while(|(a, b)| a == b).count();
    let ups = from.components().skip(shared).map(|_| "..".to_owned());
    let downs = to.components().skip(shared).map(|component| match component {
        Component::Normal(name) => escaped(&name.to_string_lossy()),
        other => other.as_os_str().to_string_lossy().into_owned(),
    });
    ups.chain(downs).collect::<Vec<_>>().join("/")
}

/// A name escaped for a link.
fn escaped(name: &str) -> String {
    let one = |byte: u8| match byte {
        b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'_' | b'.' | b'~' => char::from(byte).to_string(),
        other => format!("%{other:02X}"),
    };
    name.bytes().map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_lead_from_the_gallery_to_the_reports() {
        let of = |from: &str, to: &str| link(Path::new(from), Path::new(to));
        assert_eq!(of("/a/results", "/a/results/x/report.html"), "x/report.html");
        assert_eq!(
            of("/a/site", "/a/results/x y/100 %/report.html"),
            "../results/x%20y/100%20%25/report.html"
        );
    }

    #[test]
    fn the_gallery_stands_in_the_folder_that_holds_all() {
        let of = |paths: &[&str]| common(&paths.iter().map(PathBuf::from).collect::<Vec<_>>());
        assert_eq!(of(&["/no/results/x", "/no/results/y"]), PathBuf::from("/no/results"));
        assert_eq!(of(&["/no/a/x", "/no/b/c/y"]), PathBuf::from("/no"));
        assert_eq!(of(&["/no/a/x"]), PathBuf::from("/no/a"));
    }
}
