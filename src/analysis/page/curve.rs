//! The page of a curve that was read from a file.

use crate::analysis::given_curve::Analysis;
use crate::analysis::log::report::MINIMUM;
use crate::analysis::page::{chart, grid, grid_where, minimum, range, texts};
use sagnac_base::quantity::number::significant;
use sagnac_base::table::titled;
use sagnac_report::answer::Answer;
use sagnac_report::chart::Picture;
use sagnac_report::page::{Block, Page, Section};

/// The page of a curve from its fit and its answer.
pub fn of_curve(analysis: &Analysis, answer: Answer) -> Page {
    let [coefficients, curve] = analysis.tables();
    let file = analysis.path.file_name().unwrap_or(analysis.path.as_os_str()).to_string_lossy();
    let charts =
        [Some(("chart", analysis.figure())), analysis.residuals().map(|figure| ("residuals", figure))];
    let charts = charts.into_iter().flatten().map(|(stem, figure)| chart(stem, Picture::Curves(figure)));
    let omitted = ["column", "deviation", "unit", "treatment"];
    let symbol = analysis.file.unit.symbol(analysis.file.deviation);
    let title = format!("{}, with 95 % intervals", titled("Allan deviation", symbol));
    let points = Block::More(title, grid(&curve.1, &omitted));
    let names = texts(&coefficients.1, "coefficient");
    let values =
        grid_where(&coefficients.1, &["column", "intervals", "fit_from", "fit_to", "fitted"], |row| {
            !names[row].starts_with(MINIMUM)
        });
    let fit = analysis.column.noise().map(|noise| {
        let (fit, described) = (&noise.fit, if noise.fit.is_described() { "" } else { "; model rejected" });
        let p = fit.p_value().map_or_else(String::new, |p| format!(", p = {}", significant(p, 2)));
        let (chi_squared, freedom) = (significant(fit.chi_squared, 3), fit.degrees_of_freedom);
        format!("{}, χ² = {chi_squared} of {freedom} degrees of freedom{p}{described}", range(fit))
    });
    let facts = [
        ("Fit", fit),
        ("Errors of the points", Some(analysis.file.errors.clone())),
        ("Curve minimum", minimum(&analysis.column)),
    ];
    let facts = facts.into_iter().filter_map(|(name, text)| Some((name, vec![text?]))).collect();
    Page {
        title: format!("Noise of {file}"),
        scope: String::new(),
        subtitle: format!("Which noise does this curve show? {}", analysis.heading()),
        answer,
        notes: analysis.notes(),
        sections: vec![
            Section::new("deviations", "Deviations", charts.chain([points])),
            Section::new("coefficients", "Coefficients", [Block::Grid(values), Block::Facts(facts)]),
        ],
        tables: vec![coefficients, curve],
    }
}
