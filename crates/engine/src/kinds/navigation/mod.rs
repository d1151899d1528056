//! Studies of navigation: the errors of heading, velocity and position that the noise of gyros leaves.

pub(crate) mod claims;
pub(crate) mod columns;
pub(crate) mod filter;
pub mod keys;
pub(crate) mod kind;
pub mod lower;
pub(crate) mod parts;
pub(crate) mod point;
pub(crate) mod run;
pub mod verify;

pub use crate::kinds::navigation::point::{Inputs, Point};
pub use crate::noise::{Noise, Switching};

use crate::key::row::{Key, Reading};
use crate::key::sensitivity::{self, Uncertain};
use crate::key::sweep;
use crate::kinds::navigation::keys::{
    ALIGNMENT, CALIBRATION, COURSE, DRAWS, DURATION, FILTER, LATITUDE, NAVIGATION, SAMPLE, SETTINGS,
    SOLUTION, SPEED, Solution,
};
use crate::noise::{self, FILE, WrittenNoise, coefficient_values, swept_files};
use sagnac_base::quantity::number::significant;
use sagnac_base::quantity::units::Quantity;
use sagnac_base::source::diagnose::{Fault, Wrong};

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
}

impl Navigation {
    /// Whether a filter keeps the heading.
    pub(crate) fn has_filter(&self) -> bool {
        self.points.iter().any(|point| point.inputs.filter.is_some())
    }
}

/// Every key of this kind.
pub(crate) fn keys() -> Vec<&'static Key> {
    [keys::KEYS, noise::KEYS].concat()
}

/// The keys that can be swept.
pub(crate) fn sweepable() -> Vec<&'static Key> {
    sweep::keys(&SETTINGS).chain(sweep::keys(&noise::SETTINGS)).chain([&FILE, &FILTER]).collect()
}

/// Reads the part of a study that belongs to this kind.
pub(crate) fn read(reading: &mut Reading) -> Result<Navigation, Wrong> {
    reading.note(&[&NAVIGATION, &FILTER]);
    let solution = Solution::of(reading.get(&SOLUTION));
    let calibrates = reading.get(&CALIBRATION).is_some_and(|given| given.flag());
    check_keys(reading, solution, calibrates)?;
    let mut inputs = Inputs {
        solution,
        duration_s: 0.0,
        alignment_s: 0.0,
        calibrates,
        filter: filter::written(reading)?,
        latitude_arcsec: 0.0,
        speed_m_per_s: 0.0,
        course_arcsec: 0.0,
        sample_s: None,
        noise: Noise::default(),
    };
    reading.set(&mut inputs, &SETTINGS)?;
    let WrittenNoise { noise, written } = noise::read(reading)?;
    let files = swept_files(reading, &written)?;
    let filters = filter::swept(reading)?;
    let (draws, uncertain) = read_draws(reading, &noise)?;
    let base = point::Base {
        inputs: Inputs { noise, ..inputs },
        files,
        filters,
        places: &reading.places,
        sweeps: reading.sweeps,
    };
    base.check_sweeps()?;
    noise::check_switching(base.noises(), &reading.places, reading.sweeps)?;
    let points = base.points()?;
    let gyros = points.iter().filter_map(|point| Some((point.inputs.noise.lock_in?, 0.0)));
    reading.notes.extend(rounded(&points).into_iter().chain(noise::note(gyros)));
    Ok(Navigation { solution, draws, uncertain, points })
}

/// Refuses a key without effect on the solution, and a missing one.
fn check_keys(reading: &Reading, solution: Solution, calibrates: bool) -> Result<(), Fault> {
    let (needed, unused): (&[&'static Key], &[&'static Key]) = match solution {
        Solution::Inertial => (&[&DURATION, &LATITUDE], &[&FILTER]),
        Solution::Heading => (&[&DURATION], &[&LATITUDE, &SPEED, &COURSE]),
        Solution::Gyrocompass => {
            (&[&ALIGNMENT, &LATITUDE], &[&DURATION, &CALIBRATION, &FILTER, &SPEED, &COURSE])
        }
    };
    let name = solution.name();
    let is_given = |key: &'static Key| reading.get(key).is_some() || reading.sweep(key).is_some();
    for key in unused {
        let message = format!("{} has no effect on solution = \"{name}\"", key.name);
        let help = "leave it out, or take another navigation.solution";
        if let Some(given) = reading.get(key) {
            return Err(given.fault(message, "no effect", help));
        }
        if let Some(sweep) = reading.sweep(key) {
            return Err(sweep.fault(message, "no effect", help));
        }
    }
    if let Some(key) = needed.iter().find(|key| !is_given(key)) {
        let table = reading.table.span_of(&NAVIGATION).unwrap_or_default();
        return Err(Fault::missing_key(key.name, key.example, table));
    }
    let no_effect = |key: &'static Key, without: &'static Key, why: &str| match reading.get(key) {
        Some(given) if !is_given(without) => {
            let message = format!("{} has no effect without {}", key.name, without.name);
            Err(given.fault(message, "no effect", format!("{why}, or leave it out")))
        }
        _ => Ok(()),
    };
    no_effect(&COURSE, &SPEED, "give a speed as in speed = \"250 m/s\"")?;
    if is_given(&FILTER) {
        if let Some(given) = reading.get(&CALIBRATION) {
            let message =
                "navigation.calibration has no effect beside navigation.filter, which finds the bias itself";
            return Err(given.fault(message, "no effect", "leave it out, or navigation.filter"));
        }
        if !is_given(&ALIGNMENT) {
            let message = "navigation.filter finds the bias of the gyro in the alignment, and there is none";
            let table = reading.table.span_of(&NAVIGATION).unwrap_or_default();
            let help = "give a time as in alignment = \"10 min\", or leave navigation.filter out";
            return Err(Fault::new(table, message, "without alignment", help));
        }
    } else if calibrates || solution != Solution::Heading {
        no_effect(&CALIBRATION, &ALIGNMENT, "give a time as in alignment = \"10 min\"")?;
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
fn read_draws(reading: &Reading, noise: &Noise) -> Result<(u64, Vec<Uncertain>), Fault> {
    let Some(given) = reading.get(&DRAWS) else { return Ok((1, vec![])) };
    let draws = given.whole()?.cast_unsigned();
    let uncertain = sensitivity::read_all(&reading.table, &keys(), &sweepable(), &[])?;
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
