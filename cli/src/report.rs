//! `sagnac report`.

use std::io;
use std::path::{Component, Path, PathBuf};

use clap::Args;
use sagnac::report::page::html::gallery;
use sagnac::report::page::{Card, FILE as REPORT, MARKS};
use sagnac::run::{Plan, RESOLVED, Tables, complete};
use sagnac::store::CARD;
use sagnac::store::folder::{Folder, write_marked};
use sagnac::study::Study;
use sagnac::tally::Share;
use sagnac::use_cases::{Sampled, absolute, once, study_outcome};
use sagnac::view::incomplete;
use sagnac_base::text_file::read_bytes;

use crate::chart::{Redraw, redraw};
use crate::failure::{Failure, in_options};
use crate::output::unwritten;
use crate::progress::{self, Shown};
use crate::results::{self, held, left_out};

/// The page of several results.
const GALLERY: &str = "gallery.html";

/// Most bytes of a card that is read, several times as many as a picture has.
const MAX_BYTES: u64 = 4 << 20;

#[derive(Debug, Args)]
#[command(after_long_help = EXAMPLES)]
pub struct Options {
    /// Results folders, or folders that contain them
    #[arg(required = true, value_name = "DIR")]
    folders: Vec<PathBuf>,
    /// File of the gallery of several results [default: gallery.html in the folder given, or in that in which those given are]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    #[command(flatten)]
    redraw: Redraw,
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
  sagnac report results
  sagnac report results/error_vs_dtnu --y rms --limit \"rms=5 arcsec\"
  sagnac report results/error_vs_dtnu --kind heat-map --x frequency --y gap_ticks --z p99_73 \\
    --where filler=quadratic

Results are those of run, allan, compare, model, design, sensitivity and filler. Of the results of a study the
page is made again; the other commands have written theirs, and its card for the gallery beside it.
In a folder of folders, what design, sensitivity and filler wrote into the folders of studies is found too.
A redrawn chart is written to DIR as an SVG and a PNG; the page keeps the charts of the study.";

/// Redraws a chart of one folder with other keys than the study's.
pub fn chart(options: &Options) -> Result<(), Failure> {
    let [folder] = &options.folders[..] else {
        let message = "a chart is redrawn in one folder\ngive one DIR";
        return Err(Failure::Usage(message.to_owned()));
    };
    redraw(folder, &options.redraw, options.quiet, &options.progress)
}

/// Rebuilds the pages of studies, with a gallery for several results. A damaged folder does not affect the others.
pub fn report(options: &Options) -> Result<(), Failure> {
    if options.redraw.is_asked() {
        return chart(options);
    }
    let folders = results_in(&options.folders)?;
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

/// Writes the gallery of all results that have a page.
fn write_gallery(
    reports: Vec<(PathBuf, Card)>,
    folders: &[PathBuf],
    options: &Options,
) -> Result<(), Failure> {
    let path = options.out.clone().unwrap_or_else(|| beside(&options.folders).join(GALLERY));
    let here = path.parent().map_or_else(PathBuf::new, absolute);
    let cards: Vec<Card> = reports
        .into_iter()
        .map(|(report, card)| Card { report: link(&here, &absolute(&report)), ..card })
        .collect();
    let all_studies = folders.iter().all(|folder| results::is_study(folder));
    let called = if all_studies { ["study", "studies"] } else { ["result", "results"] };
    write_marked(&path, &MARKS, gallery(&cards, called).as_bytes())?;
    if !options.quiet {
        let here = std::env::current_dir().unwrap_or_default();
        say!("{}", path.strip_prefix(here).unwrap_or(&path).display());
    }
    Ok(())
}

/// The card of results for a gallery, without the link. The page of a study is rebuilt.
fn of_folder(folder: &Path, options: &Options) -> Result<Card, Failure> {
    let card = if results::is_study(folder) { rebuilt(folder, options)? } else { kept(folder)? };
    Ok(Card { folder: folder.display().to_string(), ..card })
}

/// Rebuilds the page of a study from its results.
fn rebuilt(folder: &Path, options: &Options) -> Result<Card, Failure> {
    let study = Study::read(&folder.join(RESOLVED))?;
    // Its charts are drawn at once, so nothing needs to be checked before.
    let plan = Plan::new(&study)?;
    let results_folder = Folder::open(folder)?;
    let store = held(&results_folder, &plan)?;
    complete(&study, &results_folder)?;
    let progress = Shown::new(options.progress.how(options.quiet));
    let lacking = plan.lacks(&store, Share::WHOLE)?;
    if let Some(sentence) = incomplete(lacking) {
        note!("{}: {sentence}", folder.display());
    }
    let digest =
        |tables: &Tables| tables.points.write_csv(io::sink()).map_err(unwritten(&folder.join(REPORT)));
    let mut results = study_outcome(&plan, &store, &Sampled { run: None, lacking }, digest, &progress)?;
    results.complete(&progress)?;
    let page = results.outcome.page;
    progress.clear();
    let spell = |text: &str| in_options(&text);
    results_folder.write(REPORT, page.html(&spell).as_bytes())?;
    results_folder.commit()?;
    Ok(page.card(&spell))
}

/// The card that another command than `run` has written beside its page.
fn kept(folder: &Path) -> Result<Card, Failure> {
    let again = |path: PathBuf, why: &str| {
        let command = results::writer(folder).unwrap_or("allan");
        let message = format!("{} {why}\nrun `sagnac {command}` again to write it anew", path.display());
        Failure::Usage(message)
    };
    let [page, path] = [REPORT, CARD].map(|name| folder.join(name));
    if !page.is_file() {
        return Err(again(page, "is missing"));
    }
    let size = std::fs::metadata(&path).map_or(0, |found| found.len());
    if size > MAX_BYTES {
        return Err(again(path, &format!("has {size} bytes, more than any card")));
    }
    let text = read_bytes(&path, MAX_BYTES + 1)
        .map_err(|error| again(path.clone(), &format!("cannot be read: {error}")))?;
    serde_json::from_slice(&text).map_err(|error| again(path, &format!("is no card of results: {error}")))
}

/// The folders of results: those given, and those inside other given folders.
fn results_in(named: &[PathBuf]) -> Result<Vec<PathBuf>, Failure> {
    let mut results: Vec<PathBuf> = Vec::new();
    for folder in named {
        if results::is_study(folder) || results::is_carded(folder) {
            results.push(folder.clone());
            continue;
        }
        if folder.is_file() {
            let message = format!("{} is a file, not a folder of results", folder.display());
            return Err(Failure::Usage(message));
        }
        let failed = |error: std::io::Error| {
            Failure::Usage(format!("cannot read {}: {error}\ngive folders of results", folder.display()))
        };
        let found = results::results_within(folder).map_err(failed)?;
        let found: Vec<PathBuf> =
            found.into_iter().filter(|(_, lacks)| lacks.is_none()).map(|(path, _)| path).collect();
        if found.is_empty() {
            let shown = folder.display();
            return Err(Failure::Usage(match results::writer(folder) {
                Some(command) => format!(
                    "{shown} holds output of `sagnac {command}` of an earlier version, without {CARD}\nrun the command again"
                ),
                None => format!(
                    "neither {shown} nor a folder in it has a {RESOLVED} or a {CARD}\ngive folders that `sagnac run`, allan, \
                     compare, model, design, sensitivity or filler wrote results to"
                ),
            }));
        }
        results.extend(found);
    }
    let mut is_new = once(&[]);
    results.retain(|folder| is_new(folder));
    Ok(results)
}

/// The folder of a gallery: the one that contains all those of results, as they are `named`; the present one where only the
/// root of the file system does.
fn beside(named: &[PathBuf]) -> PathBuf {
    let holder = |folder: &PathBuf| match results::is_study(folder) || results::is_carded(folder) {
        true if folder.file_name().is_some() => folder.parent().unwrap_or(Path::new("")).to_owned(),
        true => folder.join(".."),
        false => folder.clone(),
    };
    let mut holders = named.iter().map(holder);
    let first = holders.next().unwrap_or_default();
    let common = holders.fold(first, |common, path| {
        common.ancestors().find(|ancestor| path.starts_with(ancestor)).unwrap_or(Path::new("")).to_owned()
    });
    if common.parent().is_none() { PathBuf::new() } else { common }
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
        let of = |paths: &[&str]| beside(&paths.iter().map(PathBuf::from).collect::<Vec<_>>());
        assert_eq!(of(&["no/results"]), PathBuf::from("no/results"));
        assert_eq!(of(&["/no/results/x", "/no/results/y"]), PathBuf::from("/no/results"));
        assert_eq!(of(&["/no/a/x", "/no/b/c/y"]), PathBuf::from("/no"));
        // Nothing is written to a folder that only leads there.
        assert_eq!(of(&["no/a", "/no/b"]), PathBuf::new());
        assert_eq!(of(&["/a", "/b"]), PathBuf::new());
    }
}
