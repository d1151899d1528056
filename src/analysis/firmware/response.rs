//! The frequency response of fillers, as a chart.

use crate::analysis::firmware::design::{Firmware, Mark, response};
use sagnac_base::quantity::number::significant;
use sagnac_engine::filler::LISTED;
use sagnac_engine::filler::read::Error;
use sagnac_report::chart::figure::{Axis, Entry, Figure, Grouping, Law, LawLine, Series, SeriesPoint};
use sagnac_report::chart::styles::of_names;
use sagnac_theory::gap::Weights;

/// Decades below the Nyquist frequency at which the chart begins, which is 1 Hz for ticks of 5 ms. Below it the errors
/// fall on straight lines.
const DECADES: f64 = 2.0;
/// Upper end of the chart relative to the highest frequency of a specification.
const BEYOND: f64 = 1.25;
/// Steps of a curve and of its markers.
const STEPS: usize = 720;
const MARKER_STEPS: usize = 60;
/// Lower end of the chart relative to the angle of the gap at a constant rate; smaller errors are lost in any noise.
const MIN_RELATIVE: f64 = 1e-4;

/// The styles of fillers, which are those of other charts.
fn styles_of(names: &[String]) -> Vec<usize> {
    let mut sorted = names.to_vec();
    sorted.sort_unstable();
    let styles = of_names(LISTED, &sorted);
    names.iter().filter_map(|name| Some(styles[sorted.binary_search(name).ok()?])).collect()
}

impl Firmware {
    /// The amplitude of the error per amplitude of the rate as a function of the vibration frequency, up to half the
    /// tick rate or beyond what is specified: a colour for each filler, solid for the residual and dashed for the
    /// extrapolation. The chart also has the angle of the gap itself, which is the error without any filler, and the
    /// frequency of a motion that is a single tone, or the lines and bands of a specification.
    pub fn response(&self) -> Figure {
        let tick_s = self.tick_s.unwrap_or(1.0);
        let nyquist = 0.5 / tick_s;
        let beyond = if self.shift.is_none() { BEYOND } else { 0.0 };
        let top = self.marks.iter().map(|mark| beyond * mark.ends_hz[1]).fold(nyquist, f64::max);
        let decades = DECADES + libm::log10(top / nyquist);
        let frequency = |i: usize| top * libm::pow(10.0, decades * (i as f64 / STEPS as f64 - 1.0));
        let of = |weights: &Weights, nu: f64| response(weights, self.gap_ticks, tick_s, nu);
        let mut series = Vec::new();
        let names: Vec<String> = self.designs.iter().map(|design| design.name.clone()).collect();
        let styles = styles_of(&names);
        for (&colour, design) in styles.iter().zip(&self.designs) {
            for (error, rule, _) in design.rules() {
                let weights = rule.whole();
                let point = |i: usize| SeriesPoint {
                    x: frequency(i),
                    y: of(&weights, frequency(i)),
                    band: None,
                    key: None,
                };
                let visible =
                    |point: &SeriesPoint| point.y >= MIN_RELATIVE * tick_s * f64::from(self.gap_ticks);
                series.push(Series {
                    colour,
                    dash: usize::from(error == Error::Extrapolation),
                    points: (0..=STEPS).step_by(MARKER_STEPS).map(point).filter(visible).collect(),
                    law: (0..=STEPS).map(|i| (frequency(i), of(&weights, frequency(i)))).collect(),
                });
            }
        }
        let law =
            |label, points| Law { label, lines: vec![LawLine { colours: vec![], points }], is_area: false };
        let nothing = Weights { ticks: vec![], numerators: vec![], denominator: 1 };
        let gap = (0..=STEPS).map(|i| (frequency(i), of(&nothing, frequency(i)))).collect();
        let mut laws = vec![law("the gap itself, not filled".to_owned(), gap)];
        let markers = || series.iter().flat_map(|series| &series.points).map(|point| point.y);
        let curves = series.iter().flat_map(|series| &series.law).map(|place| place.1);
        // The lower end of the axis, which for curves is a decade below the markers.
        let low = curves.fold(f64::INFINITY, f64::min).max(0.1 * markers().fold(f64::INFINITY, f64::min));
        let high = markers().fold(0.0, f64::max);
        for Mark { name, ends_hz: [from, to] } in &self.marks {
            if *to < frequency(0) || *from > top {
                continue;
            }
            let [begin, end] = [from, to].map(|nu| significant(*nu, 4));
            let (label, places) = match from == to {
                true => (format!("{name}, {begin} Hz"), vec![(*from, low), (*from, high)]),
                false => {
                    let from = from.max(frequency(0));
                    let places = vec![(from, low), (from, high), (*to, high), (*to, low)];
                    (format!("{name}, {begin} to {end} Hz"), places)
                }
            };
            laws.push(law(label, places));
        }
        let entries = names.into_iter().zip(styles).map(|(name, style)| Entry { style, name });
        let extrapolates = self.designs.iter().any(|design| design.extrapolation.is_some());
        let errors: &[Error] =
            if extrapolates { &[Error::Residual, Error::Extrapolation] } else { &[Error::Residual] };
        let errors = errors.iter().map(|error| error.name().to_owned());
        let plural = if self.gap_ticks == 1 { "" } else { "s" };
        let of = self.tick_s.map_or_else(String::new, |t| format!(" of {} ms", significant(1e3 * t, 6)));
        let (frequency_unit, error_unit) = if self.tick_s.is_some() {
            ("Hz", "″ per ″/s")
        } else {
            ("cycles per tick", "″ per ″ a tick")
        };
        let mut figure = Figure {
            title: format!("Response to vibration of a gap of {} tick{plural}{of}", self.gap_ticks),
            subtitle: Some(self.title.clone()),
            x: Axis::new("vibration frequency", frequency_unit),
            y: Axis::new("error amplitude per rate amplitude", error_unit),
            colours: Grouping { title: "filler".to_owned(), entries: entries.collect() },
            dashes: Grouping::of("error", errors),
            lines: "closed form".to_owned(),
            series,
            laws,
            ..Figure::default()
        };
        figure.merge_coincident();
        figure
    }
}
