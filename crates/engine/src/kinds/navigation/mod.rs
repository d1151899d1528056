//! Studies of navigation: the errors of heading, velocity and position that the noise of gyros leaves; their keys, the parts
//! of the error, and the entry in the list of kinds.

pub(crate) mod columns;
pub mod lower;
pub(crate) mod point;
pub(crate) mod run;
pub mod verify;

use std::sync::Arc;

use crate::chart::{Source, TableSchema};
use crate::key::document::SpanMap;
use crate::key::sensitivity::{self, Uncertain};
use crate::key::sweep::{SweepTarget, Sweep};
use crate::key::{Key, ParseContext, ValueType, keys, measure, words};
use crate::kinds::navigation::columns::{LAWS, OF_FILTERS};
use crate::kinds::navigation::point::Base;
pub use crate::kinds::navigation::point::{Inputs, Point};
use crate::noise::{self, WrittenNoise, coefficient_values, swept_files, values};
pub use crate::noise::{Noise, Switching};
use crate::sampling::Planned;
use crate::study::{Ablation, Kind, Part, Study, Subject};
use sagnac_base::diagnostics::{Fault, Wrong};
use sagnac_base::progress::Progress;
use sagnac_base::quantity::number::significant;
use sagnac_base::quantity::{Dimension, Quantity};
use sagnac_base::table::column::abouts;
use sagnac_kernel::navigation::VERSION;
use sagnac_theory::allan::terms::Term;

/// The part of a study that is specific to navigation.
#[derive(Debug, Clone)]
pub struct Navigation {
    /// The task.
    pub solution: Solution,
    /// Number of sets of coefficients; 1 where they have the values of the study.
    pub draws: u64,
    /// The distributions of the coefficients, where several sets are drawn.
    pub uncertain: Vec<Uncertain>,
    /// All points, in order; without a sweep, a single one.
    pub points: Vec<Point>,
    /// The inputs that all points have in common.
    base: Base,
}

impl Navigation {
    /// A study of one navigator with these inputs, without sweeps and with the coefficients as they are.
    pub fn new(inputs: Inputs) -> Navigation {
        let points = vec![Point { swept: vec![], inputs: inputs.clone(), lack: None }];
        let base = Base { inputs, files: Arc::default(), filters: Arc::default() };
        Navigation { solution: base.inputs.solution, draws: 1, uncertain: vec![], points, base }
    }

    /// Whether a filter keeps the heading.
    pub(crate) fn has_filter(&self) -> bool {
        self.points.iter().any(|point| point.inputs.filter.is_some())
    }
}

/// Every key of this kind.
pub(crate) fn keys() -> Vec<&'static Key> {
    [KEYS, noise::KEYS].concat()
}

/// Reads the part of a study that belongs to this kind.
pub(crate) fn read(reading: &mut ParseContext) -> Result<Navigation, Wrong> {
    reading.note(&[&NAVIGATION_TABLE, &FILTER]);
    let solution = Solution::from_value(reading.get(&SOLUTION));
    let calibrates = reading.get(&CALIBRATION).is_some_and(|given| given.flag());
    check_keys(reading, solution, calibrates)?;
    let mut inputs = Inputs {
        solution,
        duration_s: 0.0,
        alignment_s: 0.0,
        calibrates,
        filter: point::written(reading)?,
        latitude_arcsec: 0.0,
        speed_m_per_s: 0.0,
        course_arcsec: 0.0,
        sample_s: None,
        noise: Noise::default(),
    };
    reading.set(&mut inputs, &SETTINGS)?;
    let WrittenNoise { noise, written } = noise::read(reading)?;
    let files = swept_files(reading, &written)?;
    let filters = point::swept(reading)?;
    let (draws, uncertain) = read_draws(reading, &noise)?;
    let base = Base { inputs: Inputs { noise, ..inputs }, files, filters };
    let points = base.points(reading.sweeps, &reading.places)?;
    let gyros = points.iter().filter_map(|point| Some((point.inputs.noise.lock_in?, 0.0)));
    reading.notes.extend(rounded(&points).into_iter().chain(noise::note(gyros)));
    Ok(Navigation { solution, draws, uncertain, points, base })
}

impl Solution {
    /// The keys without effect on it.
    fn unused(self) -> Vec<&'static Key> {
        match self {
            Solution::Inertial => vec![&FILTER],
            Solution::Heading => vec![&LATITUDE, &SPEED, &COURSE],
            Solution::Gyrocompass => vec![&DURATION, &CALIBRATION, &FILTER, &SPEED, &COURSE],
        }
    }
}

/// The message of a key without effect on the solution, and what to do about it.
fn no_effect(solution: Solution, key: &Key) -> (String, &'static str) {
    let message = format!("{} has no effect on solution = \"{}\"", key.name, solution.name());
    (message, "leave it out, or take another navigation.solution")
}

/// Refuses a sweep without effect on the solution.
fn check_swept(solution: Solution, sweeps: &[Sweep]) -> Result<(), Fault> {
    let is_unused = |sweep: &&Sweep| solution.unused().iter().any(|key| std::ptr::eq(*key, sweep.key));
    let Some(sweep) = sweeps.iter().find(is_unused) else { return Ok(()) };
    let (message, help) = no_effect(solution, sweep.key);
    Err(sweep.fault(message, "no effect", help))
}

/// Refuses a key without effect on the solution, and a missing one.
fn check_keys(reading: &ParseContext, solution: Solution, calibrates: bool) -> Result<(), Fault> {
    let needed: &[&'static Key] = match solution {
        Solution::Inertial => &[&DURATION, &LATITUDE],
        Solution::Heading => &[&DURATION],
        Solution::Gyrocompass => &[&ALIGNMENT, &LATITUDE],
    };
    let is_given = |key: &'static Key| reading.get(key).is_some() || reading.sweep(key).is_some();
    if let Some(given) = solution.unused().iter().find_map(|key| reading.get(key)) {
        let (message, help) = no_effect(solution, given.key);
        return Err(given.fault(message, "no effect", help));
    }
    check_swept(solution, reading.sweeps)?;
    if let Some(key) = needed.iter().find(|key| !is_given(key)) {
        let table = reading.table.span_of(&NAVIGATION_TABLE).unwrap_or_default();
        return Err(Fault::missing_key(key.name, key.example, table));
    }
    let needs = |key: &'static Key, without: &'static Key, why: &str| match reading.get(key) {
        Some(given) if !is_given(without) => {
            let message = format!("{} has no effect without {}", key.name, without.name);
            Err(given.fault(message, "no effect", format!("{why}, or leave it out")))
        }
        _ => Ok(()),
    };
    needs(&COURSE, &SPEED, "give a speed as in speed = \"250 m/s\"")?;
    if is_given(&FILTER) {
        if let Some(given) = reading.get(&CALIBRATION) {
            let message =
                "navigation.calibration has no effect beside navigation.filter, which finds the bias itself";
            return Err(given.fault(message, "no effect", "leave it out, or navigation.filter"));
        }
        if !is_given(&ALIGNMENT) {
            let message = "navigation.filter finds the bias of the gyro in the alignment, and there is none";
            let table = reading.table.span_of(&NAVIGATION_TABLE).unwrap_or_default();
            let help = "give a time as in alignment = \"10 min\", or leave navigation.filter out";
            return Err(Fault::new(table, message, "without alignment", help));
        }
    } else if calibrates || solution != Solution::Heading {
        needs(&CALIBRATION, &ALIGNMENT, "give a time as in alignment = \"10 min\"")?;
    } else if let Some(given) = reading.get(&ALIGNMENT) {
        let message = "navigation.alignment of solution = \"heading\" is for a calibration or a filter, and there is none";
        return Err(given.fault(
            message,
            "no effect",
            "write calibration = true too, or filter = \"model.json\", or leave it out",
        ));
    }
    Ok(())
}

/// Reads the number of sets of coefficients, and their distributions, which must be those of the noise of the study.
fn read_draws(reading: &ParseContext, noise: &Noise) -> Result<(u64, Vec<Uncertain>), Fault> {
    let Some(given) = reading.get(&DRAWS) else { return Ok((1, vec![])) };
    let draws = given.whole()?.cast_unsigned();
    let uncertain = sensitivity::read_all(&reading.table, &keys(), &point::sweepable().keys(), &[])?;
    let help = "add the interval of a coefficient as `sagnac allan` gives it:\n[[sensitivity]]\nkey = \"noise.bias_instability\"\n\
                interval = { value = \"0.0016 deg/h\", low = \"0.0012 deg/h\", high = \"0.0022 deg/h\" }";
    if uncertain.is_empty() {
        let message = "navigation.draws is given, but there are no distributions to draw from";
        return Err(given.fault(message, "nothing to draw", help));
    }
    let is_noise = |key: &Key| key.name.starts_with("noise.");
    if let Some(other) = uncertain.iter().find(|input| !is_noise(input.key)) {
        let message = format!("navigation.draws: {} is no coefficient of the noise", other.key.name);
        let help = "leave its distribution out, or navigation.draws";
        return Err(Fault::new(other.span.clone(), message, "not of [noise]", help));
    }
    uncertain.iter().try_for_each(|input| is_of(input, noise))?;
    Ok((draws, uncertain))
}

/// Refuses the distribution of a coefficient that the noise has with a value beyond it: it is that of another gyro.
fn is_of(input: &Uncertain, noise: &Noise) -> Result<(), Fault> {
    let own = coefficient_values(noise)
        .into_iter()
        .find(|(key, own)| key.name == input.key.name && own.value > 0.0);
    let [low, high] = WITHIN.map(|level| input.at(level).quantity());
    let (Some((key, own)), Some(low), Some(high)) = (own, low, high) else { return Ok(()) };
    if (low.value..=high.value).contains(&own.value) {
        return Ok(());
    }
    let [own, least, most] =
        [own, low, high].map(|one| significant(Quantity { dimension: low.dimension, ..one }.shown(), 3));
    let (name, unit) = (key.name, low.dimension.unit().symbol);
    let message = format!(
        "the study has {name} = {own} {unit}, and its distribution goes from {least} to {most} {unit}"
    );
    let help =
        "write the value and the 95 % interval of this gyro, which `sagnac allan` writes into noise.toml";
    Err(Fault::new(input.span.clone(), message, "of another gyro", help))
}

/// Parts of a distribution below its ends, as far as the noise of a study may lie from the median.
const WITHIN: [f64; 2] = [0.001, 0.999];

/// Relative rounding of a time that needs no note.
const ROUNDED: f64 = 1e-9;

/// A note on times that are not whole numbers of samples.
fn rounded(points: &[Point]) -> Option<String> {
    let of_point = |point: &Point| {
        let (inputs, times) = (&point.inputs, point.inputs.times());
        let switching = inputs.noise.switching;
        let interval =
            switching.map_or((0.0, 0), |one| (one.interval_s, one.interval(times.sample_s) as usize));
        [
            (DURATION.name, inputs.duration_s, times.duration),
            (ALIGNMENT.name, inputs.alignment_s, times.alignment),
            ("noise.switching.interval", interval.0, interval.1),
        ]
        .into_iter()
        .find_map(|(name, asked_s, samples)| {
            let taken_s = samples as f64 * times.sample_s;
            ((taken_s - asked_s).abs() > ROUNDED * asked_s).then_some((
                name,
                asked_s,
                taken_s,
                times.sample_s,
            ))
        })
    };
    let (name, asked_s, taken_s, sample_s) = points.iter().find_map(of_point)?;
    let [asked, taken, sample] = [asked_s, taken_s, sample_s].map(|time| significant(time, 6));
    Some(format!(
        "times are taken as whole samples: {name} = {asked} s as {taken} s, with samples of {sample} s ({})",
        SAMPLE.name
    ))
}

/// Errors of navigators.
pub(crate) static NAVIGATION: Kind = Kind {
    name: "navigation",
    subject: "The error of heading, velocity and position that the noise of its gyros leaves a navigator.",
    about: "Simulates records of the gyros of a navigator with the noise of [noise] and sums their increments with the weights \
            that follow from its error equations. points.csv has the error of the position over the ground after the time of \
            navigation, `position_cep` and `position_p95`, below which half and 95 % of the trials stay, in nautical miles, and \
            likewise those of velocity, tilt and heading; for solution = \"heading\" and \"gyrocompass\" the heading alone. With \
            navigation.filter a Kalman filter keeps the heading, and the table has its consistency, `nees` and `within95`.",
    template: include_str!("template.toml"),
    is_exact: false,
    trials: 1000,
    needs: &["navigation", "noise"],
    keys,
    sweepable: || point::sweepable().keys(),
    columns: &[(Source::Points, columns::described)],
    kernels: || format!("navigation {VERSION}"),
    loads: crate::kinds::navigation::verify::loads,
    read: |reading| Ok(Arc::new(read(reading)?)),
};

impl Subject for Navigation {
    fn plan<'a>(&'a self, study: &'a Study, progress: &dyn Progress) -> Planned<'a> {
        let plan = run::plan(study, self, progress)?;
        Ok(plan.map(|plan| Box::new(plan) as _))
    }

    fn dissected(&self, point: usize) -> Option<Ablation> {
        let (parts, points) = dissected(self.points.get(point)?);
        Some(Ablation { parts, subject: Arc::new(Navigation { points, ..self.clone() }) })
    }

    fn with_points(&self, sweeps: &[Sweep], places: &SpanMap) -> Result<Arc<dyn Subject>, Fault> {
        check_swept(self.solution, sweeps)?;
        let points = self.base.points(sweeps, places)?;
        Ok(Arc::new(Navigation { points, ..self.clone() }))
    }

    fn values(&self, point: usize) -> Vec<(&'static Key, Quantity)> {
        self.points.get(point).map(|point| values(&point.inputs.noise)).unwrap_or_default()
    }

    fn grounds(&self) -> Vec<TableSchema> {
        let columns = abouts(&columns::columns(self.solution, self.has_filter()));
        let limits: &[Dimension] = match self.solution {
            Solution::Inertial => &[Dimension::Distance, Dimension::Angle, Dimension::Speed],
            Solution::Heading | Solution::Gyrocompass => &[Dimension::Angle],
        };
        let laws = match self.solution {
            Solution::Inertial => &LAWS[..],
            Solution::Heading if self.has_filter() => &OF_FILTERS[..],
            Solution::Heading | Solution::Gyrocompass => &[],
        };
        vec![TableSchema { laws, ..TableSchema::new(Source::Points, columns, [], limits) }]
    }
}

/// The parts besides the terms of the noise.
static OTHERS: [Part<Noise>; 3] = [
    Part { name: "lock-in", off: |noise| noise.lock_in = None },
    Part {
        name: "magnetic drift of the modes",
        off: |noise| {
            switched(noise, |switching| Switching { magnetic: 0.0, initial_magnetic: 0.0, ..switching })
        },
    },
    Part {
        name: "fill residuals",
        off: |noise| {
            switched(noise, |switching| Switching { residual: 0.0, residual_noise: 0.0, ..switching })
        },
    },
];

/// Changes the switching, where there is some.
fn switched(noise: &mut Noise, change: impl Fn(Switching) -> Switching) {
    noise.switching = noise.switching.map(change);
}

/// What a point lacks of its noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Lack {
    /// One of the terms.
    Term(Term),
    /// One of the other parts, by its place.
    Other(usize),
}

impl Lack {
    /// The noise without what is lacking.
    pub(crate) fn of(self, mut noise: Noise) -> Noise {
        match self {
            Lack::Term(term) => noise.without(term),
            Lack::Other(place) => {
                (OTHERS[place].off)(&mut noise);
                noise
            }
        }
    }
}

/// A point as it is, and without each other part and each term of its noise in turn. A point remembers what it lacks, because
/// swept and drawn coefficients are set anew for each set.
fn dissected(point: &Point) -> (Vec<&'static str>, Vec<Point>) {
    let noise = &point.inputs.noise;
    let others = OTHERS.iter().enumerate().map(|(place, part)| (part.name, Lack::Other(place)));
    let has = |term: &Term| noise.has(*term);
    let terms = Term::EVERY.into_iter().filter(has).map(|term| (term.row().name[1], Lack::Term(term)));
    let (mut names, mut points) = (vec![], vec![point.clone()]);
    for (name, lack) in others.chain(terms) {
        let without = lack.of(noise.clone());
        // An angle random walk by lock-in alone is the part above.
        if without != *noise {
            names.push(name);
            let inputs = Inputs { noise: without, ..point.inputs.clone() };
            points.push(Point { inputs, lack: Some(lack), ..point.clone() });
        }
    }
    (names, points)
}

words! {
    /// The task of a navigator.
    pub enum Solution {
        /// Attitude, velocity and position by three gyros along north, east and down, from the start on.
        Inertial = "inertial",
        /// The heading of a strapdown at rest, kept by the vertical gyro.
        Heading = "heading",
        /// The heading at rest that the east gyro finds from the rate of the Earth in the alignment.
        Gyrocompass = "gyrocompass",
    }
}

const DURATIONS: ValueType = measure(&[Dimension::Time], 1.0, 1e7, "1 s to 1e7 s");
const SAMPLES: ValueType = measure(&[Dimension::Time], 1e-4, 120.0, "0.1 ms to 120 s");
const LATITUDES: ValueType = measure(&[Dimension::Bearing], -306_000.0, 306_000.0, "-85 deg to 85 deg");
const COURSES: ValueType = measure(&[Dimension::Bearing], -1_296_000.0, 1_296_000.0, "-360 deg to 360 deg");
// 1000 m/s in g·s.
const SPEEDS: ValueType = measure(&[Dimension::Speed], 0.0, 101.971_621_298, "0 to 1000 m/s");

keys! {
    /// The keys of the navigator.
    pub(crate) static KEYS;
    /// The navigator: its task, its times, its place on the Earth and its leg.
    pub(crate) NAVIGATION_TABLE = "navigation", "", Fixed, ValueType::Table, "[navigation]\nlatitude = \"60 deg\"\nduration = \"1 h\"";
    /// Task of the navigator; "inertial" if absent.
    pub(crate) SOLUTION = "navigation.solution", "", Fixed, ValueType::Word(Solution::WORDS), r#"solution = "inertial""#;
    /// Time from the start to the end, for "inertial" and "heading": "1 h".
    pub(crate) DURATION = "navigation.duration", "time of navigation", Question, DURATIONS, r#"duration = "1 h""#;
    /// Time at rest before the start, for "inertial" and "gyrocompass", in which the east gyro finds the heading from the
    /// rate of the Earth. If absent, "inertial" starts without errors. "heading" may have it for its calibration.
    pub ALIGNMENT = "navigation.alignment", "time of alignment", Fixed, DURATIONS, r#"alignment = "10 min""#;
    /// Whether the mean rates of the other gyros in the alignment are taken as their biases and removed; false if absent.
    pub(crate) CALIBRATION = "navigation.calibration", "", Fixed, ValueType::Flag, "calibration = true";
    /// Path of the noise model of a Kalman filter, relative to the folder of the study, for "heading": a document of
    /// `sagnac model --json` with one column. The filter finds the bias of the gyro in the alignment and predicts it from the
    /// start on; calibration is that of a filter that knows white noise only.
    pub(crate) FILTER = "navigation.filter", "filter", Fixed, ValueType::File, r#"filter = "model.json""#;
    /// Latitude at the start, for "inertial" and "gyrocompass": "60 deg".
    pub LATITUDE = "navigation.latitude", "latitude", Question, LATITUDES, r#"latitude = "60 deg""#;
    /// Speed on a straight leg, for "inertial"; at rest if absent: "250 m/s".
    pub SPEED = "navigation.speed", "speed", Question, SPEEDS, r#"speed = "250 m/s""#;
    /// Course of the leg from north over east; north if absent: "90 deg".
    pub(crate) COURSE = "navigation.course", "course", Question, COURSES, r#"course = "90 deg""#;
    /// Time from one sample of the gyros to the next. If absent, it is chosen so that a record has more than 2000 samples
    /// and switches of modes fall on samples; the responses are averaged over each sample.
    pub SAMPLE = "navigation.sample", "sampling time", Question, SAMPLES, r#"sample = "1 s""#;
    /// Number of sets of coefficients that are drawn from the distributions of [[sensitivity]], each for an equal part of
    /// the trials, so that the errors contain the uncertainty of the coefficients; if absent, they have the values of the
    /// study.
    pub DRAWS = "navigation.draws", "", Fixed, ValueType::Whole(2, 1000), "draws = 16";
}

/// The settings of these keys.
pub(crate) static SETTINGS: [SweepTarget<Inputs>; 6] = [
    SweepTarget::new(&DURATION, |inputs, time| inputs.duration_s = time.value),
    SweepTarget::new(&ALIGNMENT, |inputs, time| inputs.alignment_s = time.value),
    SweepTarget::new(&LATITUDE, |inputs, latitude| inputs.latitude_arcsec = latitude.value),
    SweepTarget::new(&SPEED, |inputs, speed| inputs.speed_m_per_s = speed.shown()),
    SweepTarget::new(&COURSE, |inputs, course| inputs.course_arcsec = course.value),
    SweepTarget::new(&SAMPLE, |inputs, sample| inputs.sample_s = Some(sample.value)),
];
