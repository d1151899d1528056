//! Simulated records of gyros, at rest or on a moving base, from the kernels and the random numbers of studies.

use std::collections::BTreeMap;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use super::added::{AXES, Added, MotionText, Sensitivity, Warming};
use super::switched::Switches;
use crate::analysis::firmware::{find, swept, value_of};
use sagnac_base::diagnostics::{StudyError, listed};
use sagnac_base::quantity::number::short;
use sagnac_base::text_file::{MAX_TOML, read_text};
use sagnac_engine::device::samples::SharedDevice;
use sagnac_engine::device::{Device, GpuError};
use sagnac_engine::drift::Drift;
use sagnac_engine::key::sweep::SweepValue;
use sagnac_engine::kinds::allan::lower::theory::made_records;
use sagnac_engine::kinds::allan::lower::{MAX_MADE, MAX_SAMPLES, Records};
use sagnac_engine::kinds::allan::{Allan, Inputs, Point};
use sagnac_engine::kinds::gap_fill::GapFill;
use sagnac_engine::kinds::gap_fill::inputs::Inputs as TickInputs;
use sagnac_engine::kinds::lock_in::LockInStudy;
use sagnac_engine::kinds::lock_in::lower::Gyros;
use sagnac_engine::kinds::switched_run::SwitchedRun;
use sagnac_engine::motion::Motion;
use sagnac_engine::motion::record::{RecordMotion, Samples};
use sagnac_engine::study::Study;
use sagnac_records::record::write::{self, Column, Form, Head, write};

/// Fewest samples of a record.
const MIN_SAMPLES: f64 = 16.0;

/// The refusal of mode switches of records that have none.
const NO_SWITCHES: &str =
    "`switch_every = TIME` is for gap-fill studies, of which records have the gaps then\nleave it out";

/// Records that can be made of a point of a study of Allan curves.
#[derive(Debug)]
pub struct Simulation {
    study: Study,
    records: Records,
    sample_s: f64,
    samples: u64,
    /// Angle of a pulse, ″; 0 where no whole pulses are read.
    pulse: f64,
    added: Added,
    /// Paths of the files that the study names.
    files: Vec<PathBuf>,
    /// Whether records have columns of the true motion.
    has_truth: bool,
    /// The device that makes the noise; absent where the processor makes it sample by sample.
    device: Option<SharedDevice>,
}

/// Why nothing can be simulated.
#[derive(Debug, thiserror::Error)]
pub enum SimulateError {
    /// The study or the noise is not valid, or cannot be represented in the kernel's fixed point.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// The file cannot be read, the study is of another kind or does not have the point that is asked for, a setting is missing or
    /// out of place, or a record is too short or too long.
    #[error("{0}")]
    Request(String),
}

/// The records that are asked for.
#[derive(Debug, Clone, Default)]
pub struct SimulateRequest {
    /// Time from one sample to the next, s, for a noise.
    pub sample_s: Option<f64>,
    /// Length, s, for a noise or a gap-fill study, or in place of the run time of a study of runs.
    pub length_s: Option<f64>,
    /// Time between mode switches, s, for a gap-fill study; without it there are none.
    pub switch_every_s: Option<f64>,
    /// Values of swept keys, each as `key=value`, for a study with sweeps.
    pub at: Vec<String>,
    /// Seed; by default that of the study, or 1 for a noise.
    pub seed: Option<u64>,
    /// Whether there are three axes, each with noise of its own, instead of one.
    pub three_axes: bool,
    /// Motions of the base.
    pub motions: Vec<MotionText>,
    /// Misalignments and errors of scale factors.
    pub sensitivities: Vec<Sensitivity>,
    /// A temperature on which the rate depends.
    pub warming: Option<Warming>,
    /// Whether the true motion is a column beside what the gyro reads.
    pub has_truth: bool,
}

/// A column of a record.
#[derive(Debug, Clone, Copy)]
enum Content {
    /// The numbers that the gyro of an axis reads.
    Reading(usize),
    /// The motion about an axis.
    Truth(usize),
    Temperature,
}

/// The meaning of the numbers of a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Numbers {
    /// Mean rate of each sample, °/h.
    Rate,
    /// Angle of each sample, ″.
    Increment,
    /// Angle from the start of the record to the end of each sample, ″.
    Angle,
    /// Pulses of each sample.
    Pulses,
}

impl Numbers {
    /// Every meaning, by its name.
    pub const NAMED: [(&str, Numbers); 4] = [
        ("rate", Numbers::Rate),
        ("increment", Numbers::Increment),
        ("angle", Numbers::Angle),
        ("pulses", Numbers::Pulses),
    ];

    /// The name, with the unit.
    pub fn title(self) -> &'static str {
        match self {
            Numbers::Rate => "rates in °/h",
            Numbers::Increment => "angles of each sample in ″",
            Numbers::Angle => "angles from the start in ″",
            Numbers::Pulses => "pulses of each sample",
        }
    }
}

impl Simulation {
    /// Records of the noise file or of the study at `path`.
    ///
    /// # Errors
    /// The file cannot be read, or the request does not fit it.
    pub fn read(path: &Path, request: &SimulateRequest) -> Result<Simulation, SimulateError> {
        let text = read_text(path, MAX_TOML)
            .map_err(|error| SimulateError::Request(format!("cannot read {}: {error}", path.display())))?;
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        Simulation::build(&name, &text, || Study::read(path), request)
    }

    /// Records of the text of a noise file or of a study, which is called `name` in errors.
    ///
    /// # Errors
    /// The text is invalid, or the request does not fit it.
    pub fn parse(name: &str, text: &str, request: &SimulateRequest) -> Result<Simulation, SimulateError> {
        Simulation::build(name, text, || Study::parse(name, text), request)
    }

    fn build(
        name: &str,
        text: &str,
        study: impl FnOnce() -> Result<Study, StudyError>,
        request: &SimulateRequest,
    ) -> Result<Simulation, SimulateError> {
        let refused = |message: &str| Err(SimulateError::Request(message.to_owned()));
        // What is no TOML is refused with its place.
        let is_study = text.parse::<toml::Table>().map_or(true, |table| table.contains_key("kind"));
        if is_study {
            let mut study = study()?;
            study.seed = request.seed.unwrap_or(study.seed);
            let files = study.inputs().into_iter().map(|input| input.path.clone()).collect();
            let simulation = if let Some(gap_fill) = study.asked::<GapFill>() {
                Simulation::of_gap_fill(&study, gap_fill, request)
            } else if let Some(run) = study.asked::<SwitchedRun>() {
                Simulation::of_run(&study, run, request)
            } else if let Some(lock_in) = study.asked::<LockInStudy>() {
                Simulation::of_lock_in(&study, lock_in, request)
            } else if request.switch_every_s.is_some() {
                refused(NO_SWITCHES)
            } else if request.sample_s.or(request.length_s).is_some() {
                refused(
                    "`rate = HZ` and `length = TIME` are for noise files; a study has `record.sample` and `record.length`\nleave them out",
                )
            } else {
                Simulation::of_study(&study, &request.at, None)?.with(request, None)
            };
            return Ok(Simulation { files, ..simulation? });
        }
        let (Some(sample_s), Some(length_s)) = (request.sample_s, request.length_s) else {
            return refused(
                "a noise file does not say at which rate its records are sampled, and how long they are\ngive `rate = HZ` and `length = TIME`",
            );
        };
        if request.switch_every_s.is_some() {
            return refused(NO_SWITCHES);
        }
        if let Some(at) = request.at.first() {
            return refused(&format!("`at = {at}` selects from a study, but none is given\nleave it out"));
        }
        Simulation::of_noise(name, text, sample_s, length_s, request.seed.unwrap_or(1))?.with(request, None)
    }

    /// The records with the motion of their study, if it has one, about the last axis, and those that are asked for.
    fn with(
        self,
        request: &SimulateRequest,
        own: Option<(RecordMotion, String)>,
    ) -> Result<Simulation, SimulateError> {
        let SimulateRequest { three_axes, motions, sensitivities, warming, has_truth, .. } = request;
        let axes = if *three_axes { AXES.len() } else { 1 };
        let samples = self.added.samples();
        let mut all = Vec::from_iter(own.map(|(motion, truth)| (axes - 1, motion, truth)));
        for MotionText { axis, name, text } in motions {
            let truth = format!("{name}:\n{}", text.trim());
            all.push((*axis, RecordMotion::parse(name, text, samples)?, truth));
        }
        if *has_truth && all.is_empty() {
            let message = "columns of the true motion are asked for, but there is no motion\ngive `motion = FILE`, or a study that has a motion";
            return Err(SimulateError::Request(message.to_owned()));
        }
        let added = Added::new(axes, all, sensitivities, *warming, samples)?;
        Ok(Simulation { added, has_truth: *has_truth, ..self })
    }

    /// Records of a point of a gap-fill study: the noise, the pulses and the motion of its ticks, with switches where they are asked for.
    fn of_gap_fill(
        study: &Study,
        gap_fill: &GapFill,
        request: &SimulateRequest,
    ) -> Result<Simulation, SimulateError> {
        let refused = |message: &str| Err(SimulateError::Request(message.to_owned()));
        if request.sample_s.is_some() {
            return refused("`rate = HZ` is for noise files; a gap-fill study has `gyro.tick`\nleave it out");
        }
        let Some(length_s) = request.length_s else {
            return refused("a gap-fill study does not say how long records are\ngive `length = TIME`");
        };
        let point = chosen(study, &request.at, &gap_fill.points, |point| &point.swept)?;
        let inputs = &point.inputs;
        let simulation = Simulation::of_ticks(study, inputs, inputs.sigma_arcsec(), length_s)?;
        let simulation = simulation.of_kind(study, &point.swept, &inputs.motion, request)?;
        match request.switch_every_s {
            None => Ok(simulation),
            Some(every_s) => {
                let interval = libm::round(every_s / inputs.tick_s) as u64;
                simulation.switching(Switches::of_gap_fill(inputs, interval))
            }
        }
    }

    /// Records of a point of a study of runs: its ticks, with its switches, relock and drift.
    fn of_run(
        study: &Study,
        run: &SwitchedRun,
        request: &SimulateRequest,
    ) -> Result<Simulation, SimulateError> {
        let refused = |message: &str| Err(SimulateError::Request(message.to_owned()));
        if request.sample_s.is_some() || request.switch_every_s.is_some() {
            return refused(
                "`rate = HZ` is for noise files, and `switch_every = TIME` for gap-fill studies; a study of runs has `gyro.tick` and `switching.interval`\nleave them out",
            );
        }
        let point = chosen(study, &request.at, &run.points, |point| &point.swept)?;
        let Some(fill) = &point.fill else {
            return refused(
                "the study has no fillers, and so no ticks of which a record could be made\nadd [gyro], [motion] and switching.fillers to it",
            );
        };
        let switches = Switches::of_run(point, &fill.inputs, run.first_mode);
        let switches = switches.map_err(|refusal| study.refused(&point.swept, &refusal))?;
        let walk = point.drift.angle_random_walk * libm::sqrt(fill.inputs.tick_s);
        let sigma = libm::hypot(fill.inputs.sigma_arcsec(), walk);
        let length_s = request.length_s.unwrap_or(point.schedule.duration_s);
        let simulation = Simulation::of_ticks(study, &fill.inputs, sigma, length_s)?;
        simulation.of_kind(study, &point.swept, &fill.inputs.motion, request)?.switching(switches)
    }

    /// Records of the ticks of a gyro at rest, each with a noise of `sigma` ″.
    fn of_ticks(
        study: &Study,
        inputs: &TickInputs,
        sigma: f64,
        length_s: f64,
    ) -> Result<Simulation, SimulateError> {
        let walk = sigma / libm::sqrt(inputs.tick_s);
        let mut noise = format!("angle_random_walk = \"{walk} arcsec/sqrt(s)\"\n");
        if inputs.readout_lsb > 0.0 {
            noise += &format!("readout_lsb = \"{} arcsec\"\n", inputs.readout_lsb);
        }
        Simulation::of_noise("noise.toml", &noise, inputs.tick_s, length_s, study.seed)
    }

    /// Records of a gyro of a study of lock-in, which reads whole pulses.
    fn of_lock_in(
        study: &Study,
        lock_in: &LockInStudy,
        request: &SimulateRequest,
    ) -> Result<Simulation, SimulateError> {
        let refused = |message: &str| Err(SimulateError::Request(message.to_owned()));
        let SimulateRequest { sample_s, length_s, switch_every_s, motions, sensitivities, .. } = request;
        let has_times = sample_s.or(*length_s).or(*switch_every_s).is_some();
        let has_more = !motions.is_empty() || !sensitivities.is_empty() || request.warming.is_some();
        if has_times || has_more || request.three_axes {
            return refused(
                "a study of lock-in has its own times and input, in [record], [input] and [motion], and one axis\nleave out times, axes, motions, scale factors and temperatures",
            );
        }
        let point = chosen(study, &request.at, &lock_in.points, |point| &point.swept)?;
        let gyros = Gyros::new(point, lock_in.estimator, study.seed, study.streams);
        let gyros = gyros.map_err(|refusal| study.refused(&point.swept, &refusal))?;
        let noise = format!("readout_lsb = \"{} arcsec\"\n", point.inputs.scale_factor);
        let (sample_s, length_s) = (point.times.sample_s, point.times.length_s());
        let simulation = Simulation::of_noise("noise.toml", &noise, sample_s, length_s, study.seed)?;
        let mut simulation = simulation.of_kind(study, &point.swept, &point.inputs.input(), request)?;
        simulation.added.motions.iter_mut().flatten().for_each(RecordMotion::start_with_profile);
        simulation.added.lock_in = Some(gyros);
        Ok(simulation)
    }

    /// These records with the mode switches of their ticks.
    fn switching(self, switches: Switches) -> Result<Simulation, SimulateError> {
        let Switches { interval, lost, .. } = switches;
        let least = switches.least_interval();
        if !(least..self.samples).contains(&interval) {
            let [least, most, found] =
                [least, self.samples - 1, interval].map(|samples| short(samples as f64 * self.sample_s));
            let message = format!(
                "a switch every {found} s leaves no samples between gaps, or none in the record\naccepted: {least} s to {most} s"
            );
            return Err(SimulateError::Request(message));
        }
        let mut added = self.added;
        added.truth +=
            &format!("The modes switch after every {interval} samples, and the next {lost} are lost: NaN.\n");
        added.switches = Some(switches);
        Ok(Simulation { added, ..self })
    }

    /// These records as those of a study of another kind, at a point with this motion.
    fn of_kind(
        self,
        study: &Study,
        swept: &[(&'static str, SweepValue)],
        motion: &Motion,
        request: &SimulateRequest,
    ) -> Result<Simulation, SimulateError> {
        let has_motion = *motion != Motion::default();
        let own = has_motion.then(|| RecordMotion::new(motion, self.added.samples())).transpose();
        let own = own.map_err(|refusal| study.refused(swept, &refusal))?;
        let mut simulation = self.with(request, own.map(|own| (own, "the study.".to_owned())))?;
        let about = format!("The gyro is that of the study:\n{}\n", study.text().trim());
        simulation.added.truth.insert_str(0, &about);
        Ok(simulation)
    }

    /// Records of a study of Allan curves: those of its trials, which have the same numbers. A study with sweeps has them at the point
    /// with the values `at`, each given as `key=value`. Records may have another length than those of the study.
    ///
    /// # Errors
    /// The study is of another kind, has no such point or several, or its noise cannot be represented.
    fn of_study(study: &Study, at: &[String], length_s: Option<f64>) -> Result<Simulation, SimulateError> {
        let allan = study.asked::<Allan>().ok_or_else(|| {
            SimulateError::Request(format!(
                "`kind = \"{}\"` has no records of a gyro\ngive a study of kind \"allan\", \"gap-fill\", \"switched-run\" or \"lock-in\", or a noise file",
                study.kind().name
            ))
        })?;
        let point = chosen(study, at, &allan.points, |point| &point.swept)?;
        let length_s = length_s.unwrap_or(point.inputs.length_s);
        let point = Point { inputs: Inputs { length_s, ..point.inputs.clone() }, ..point.clone() };
        let records = made_records(&point, allan.estimator, study.seed, study.streams)
            .map_err(|refusal| study.refused(&point.swept, &refusal))?;
        let (sample_s, samples) = (point.inputs.sample_s, point.inputs.samples());
        let (lsb_arcsec, key) = (records.lsb_arcsec(), records.recipe().key);
        let of_records = Samples { sample_s, count: samples, lsb_arcsec, key };
        Ok(Simulation {
            study: study.clone(),
            records,
            sample_s,
            samples,
            pulse: point.inputs.noise.readout_lsb,
            added: Added::new(1, vec![], &[], None, of_records)?,
            files: vec![],
            has_truth: false,
            device: None,
        })
    }

    /// Records of the noise in the text of a noise file, which is called `name`.
    ///
    /// # Errors
    /// The text is no noise, or the record or the noise cannot be represented.
    fn of_noise(
        name: &str,
        text: &str,
        sample_s: f64,
        length_s: f64,
        seed: u64,
    ) -> Result<Simulation, SimulateError> {
        let samples = libm::round(length_s / sample_s);
        if !(MIN_SAMPLES..=MAX_MADE as f64).contains(&samples) {
            let message = format!(
                "`length = {length_s} s` has {samples} samples of {sample_s} s\naccepted: {MIN_SAMPLES} to {MAX_MADE} samples"
            );
            return Err(SimulateError::Request(message));
        }
        let quoted = toml::Value::from(name);
        let longest_s = MAX_SAMPLES as f64 * sample_s;
        let (written_s, length_s) = match samples > MAX_SAMPLES as f64 {
            true => (longest_s, Some(length_s)),
            false => (length_s, None),
        };
        let study = format!(
            "title = \"Simulated records\"\nkind = \"allan\"\ntrials = 1\nseed = {seed}\n\n[record]\nsample = \"{sample_s} s\"\n\
             length = \"{written_s} s\"\n\n[noise]\nfile = {quoted}\n"
        );
        let files = BTreeMap::from([(name.to_owned(), text.as_bytes().to_vec())]);
        Simulation::of_study(&Study::parse_with("simulated.toml", &study, &files)?, &[], length_s)
    }

    /// Lets `device` make the noise of the records, with the same bits.
    #[must_use]
    pub fn on(self, device: Device) -> Simulation {
        let device = (!matches!(device, Device::Cpu(_))).then(|| SharedDevice::new(device));
        Simulation { device, ..self }
    }

    /// Why the device has failed, if it has.
    pub fn failure(&self) -> Option<&GpuError> {
        self.device.as_ref().and_then(SharedDevice::failure)
    }

    /// The study whose trials the records are, with the truth about their noise; one with sweeps has other points too.
    pub fn study(&self) -> &Study {
        &self.study
    }

    /// Number of samples of a record.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// Time from one sample to the next, s.
    pub fn sample_s(&self) -> f64 {
        self.sample_s
    }

    /// Angle of a pulse, ″; 0 where no whole pulses are read.
    pub fn pulse_arcsec(&self) -> f64 {
        self.pulse
    }

    /// The number of axes.
    pub fn axes(&self) -> usize {
        self.added.motions.len()
    }

    /// A description of all that the records have besides the noise of the study, in lines.
    pub fn truth(&self) -> &str {
        &self.added.truth
    }

    /// The files that the study and the motions name, none of which may be written.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        let motions = self.added.motions.iter().flatten().filter_map(RecordMotion::file);
        self.files.iter().map(PathBuf::as_path).chain(motions)
    }

    /// Tables in CSV, with their names, of the random values of the record `number`: the tones of the motion and the drift of runs of
    /// each axis, if there are some.
    pub fn drawn(&self, number: u64) -> Vec<(&'static str, String)> {
        let [mut tones, mut drifts] = [const { String::new() }; 2];
        for (axis, motion) in self.added.motions.iter().enumerate() {
            let number = self.added.number(number, axis);
            let axis = if self.axes() == 1 { "" } else { AXES[axis] };
            for tone in motion.iter().flat_map(|motion| motion.tones(number)) {
                let degrees = 360.0 * tone.turns;
                tones += &format!("{axis},{},{},{degrees}\n", tone.frequency_hz, tone.amplitude);
            }
            let key = self.added.samples().key;
            let drawn = self.added.switches.as_ref().and_then(|switches| switches.drawn(key, number));
            if let Some((sign, Drift { magnetic, initial_magnetic, warm_up_s, non_magnetic, .. })) = drawn {
                drifts +=
                    &format!("{axis},{sign},{magnetic},{initial_magnetic},{warm_up_s},{non_magnetic}\n");
            }
        }
        let tables = [
            ("tones", "axis,frequency_hz,amplitude_arcsec_per_s,phase_deg", tones),
            (
                "drift",
                "axis,first_mode,magnetic_arcsec_per_s,initial_magnetic_arcsec_per_s,warm_up_time_s,non_magnetic_arcsec_per_s",
                drifts,
            ),
        ];
        let tables = tables.into_iter().filter(|(.., rows)| !rows.is_empty());
        tables.map(|(name, titles, rows)| (name, format!("{titles}\n{rows}"))).collect()
    }

    /// Number of columns of a record: what the gyro of each axis reads, then the true motion about each axis that has one, where it
    /// is asked for, and the temperature if there is one.
    pub fn columns(&self) -> usize {
        self.contents().len()
    }

    /// The numbers of a column of the record `number`, sample by sample.
    pub fn numbers(&self, number: u64, column: usize, numbers: Numbers) -> write::Numbers<'_> {
        self.column(number, self.contents()[column], numbers)
    }

    fn column(&self, record: u64, content: Content, numbers: Numbers) -> write::Numbers<'_> {
        let (sample_s, pulse, records) = (self.sample_s, self.pulse, &self.records);
        let increments: write::Numbers<'_> = match content {
            Content::Temperature => {
                return Box::new(self.added.temperatures().into_iter().flatten());
            }
            Content::Truth(axis) => Box::new(self.added.true_angles(record, axis).into_iter().flatten()),
            Content::Reading(axis) => {
                let number = self.added.number(record, axis);
                let made = self.device.as_ref().map(|device| device.angles(records.recipe(), number));
                let turned = (!self.added.is_nothing()).then(|| self.added.angles(record, axis));
                match (made, turned) {
                    (None, None) => Box::new(records.increments(number)),
                    (None, Some(turned)) => Box::new(records.turned_increments(number, turned)),
                    (Some(made), None) => Box::new(records.increments_of(number, made)),
                    (Some(made), Some(turned)) => {
                        Box::new(records.turned_increments_of(number, made, turned))
                    }
                }
            }
        };
        let numbers: write::Numbers<'_> = match (numbers, content) {
            // 1 ″/s is 1 °/h.
            (Numbers::Rate, _) => Box::new(increments.map(move |increment| increment / sample_s)),
            (Numbers::Angle, _) => Box::new(increments.scan(0.0, |sum, increment| {
                *sum += increment;
                Some(*sum)
            })),
            (Numbers::Pulses, Content::Reading(_)) => {
                Box::new(increments.map(move |increment| libm::round(increment / pulse)))
            }
            (Numbers::Increment | Numbers::Pulses, _) => increments,
        };
        match (&self.added.switches, content) {
            (Some(switches), Content::Reading(_)) => Box::new(
                (0..)
                    .zip(numbers)
                    .map(|(sample, number)| if switches.is_lost(sample) { f64::NAN } else { number }),
            ),
            _ => numbers,
        }
    }

    /// Whether the form takes such numbers, and so many.
    ///
    /// # Errors
    /// It does not.
    pub fn check(&self, numbers: Numbers, form: Form) -> Result<(), SimulateError> {
        if numbers == Numbers::Pulses && self.pulse == 0.0 {
            let message = "there are no pulses to read\ngive their angle in the noise, as in readout_lsb = \"0.5 arcsec\"";
            return Err(SimulateError::Request(message.to_owned()));
        }
        if numbers == Numbers::Angle && self.added.switches.is_some() {
            let message = "the angle from the start is not known after a gap\ntake the rates, angles or pulses of each sample";
            return Err(SimulateError::Request(message.to_owned()));
        }
        match form.refusal(&self.head(numbers)) {
            Some(refusal) => Err(SimulateError::Request(format!("{refusal}\nchoose another form"))),
            None => Ok(()),
        }
    }

    /// Writes the record `number`; it need not fit into memory.
    ///
    /// # Errors
    /// `to` or the device fails, or the form does not take such numbers, or so many.
    pub fn write(&self, number: u64, numbers: Numbers, form: Form, to: &mut dyn Write) -> io::Result<()> {
        let mut to = BufWriter::new(WhileMade { to, simulation: self });
        let contents = self.contents();
        let column = |place: usize| self.column(number, contents[place], numbers);
        write(form, &self.head(numbers), &column, &mut to)?;
        to.flush()
    }

    fn contents(&self) -> Vec<Content> {
        let axes = 0..self.axes();
        let mut contents: Vec<Content> = axes.clone().map(Content::Reading).collect();
        if self.has_truth {
            contents.extend(axes.filter(|axis| self.added.motions[*axis].is_some()).map(Content::Truth));
        }
        contents.extend(self.added.temperatures().map(|_| Content::Temperature));
        contents
    }

    fn head(&self, numbers: Numbers) -> Head {
        let (name, unit, rad_per_s) = match numbers {
            Numbers::Rate => ("rate", "deg/h", Some(1_f64.to_radians() / 3600.0)),
            Numbers::Increment | Numbers::Pulses => ("increment", "arcsec", None),
            Numbers::Angle => ("angle", "arcsec", None),
        };
        let about = |content: &Content| {
            let (before, name, unit, axis) = match content {
                Content::Reading(axis) if numbers == Numbers::Pulses => {
                    ("", "pulses", format!("{} arcsec/pulse", self.pulse), axis)
                }
                Content::Reading(axis) => ("", name, unit.to_owned(), axis),
                Content::Truth(axis) => ("true_", name, unit.to_owned(), axis),
                Content::Temperature => {
                    return Column {
                        name: "temperature".to_owned(),
                        unit: "degC".to_owned(),
                        rad_per_s: None,
                    };
                }
            };
            let after = if self.axes() == 1 { String::new() } else { format!("_{}", AXES[*axis]) };
            Column { name: format!("{before}{name}{after}"), unit, rad_per_s }
        };
        let columns = self.contents().iter().map(about).collect();
        Head { columns, samples: self.samples, step_s: self.sample_s }
    }
}

/// An output that takes nothing more once the device has failed.
struct WhileMade<'t> {
    to: &'t mut dyn Write,
    simulation: &'t Simulation,
}

impl WhileMade<'_> {
    fn check(&self) -> io::Result<()> {
        self.simulation.failure().map_or(Ok(()), |failure| Err(io::Error::other(failure.clone())))
    }
}

impl Write for WhileMade<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.check()?;
        self.to.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.check()?;
        self.to.flush()
    }
}

/// The point of a study with the values `at`, each given as `key=value`.
fn chosen<'p, P>(
    study: &Study,
    at: &[String],
    points: &'p [P],
    swept_of: impl Fn(&P) -> &[(&'static str, SweepValue)],
) -> Result<&'p P, SimulateError> {
    let mut chosen = vec![None; study.sweeps.len()];
    for asked in at {
        let refused = |why: String| SimulateError::Request(format!("`at = {asked}`: {why}"));
        let (place, value) = find(study, asked).map_err(refused)?;
        let sweep = &study.sweeps[place];
        let by_name = sweep.values.iter().find(|own| own.to_string() == value.trim_matches('"'));
        let by_size = || match sweep.values[0].quantity() {
            Some(_) => value_of(sweep, value).and_then(|value| swept(sweep, value)),
            None => {
                let names: Vec<String> = sweep.values.iter().map(SweepValue::to_string).collect();
                Err(format!("the values of {} are {}", sweep.key.name, listed(&names)))
            }
        };
        if chosen[place].is_some() {
            return Err(refused(format!("{} has a value already", sweep.key.name)));
        }
        chosen[place] = Some(match by_name {
            Some(own) => own.clone(),
            None => SweepValue::Quantity(by_size().map_err(refused)?),
        });
    }
    let mut points = points.iter().filter(|point| {
        let mut values = swept_of(point).iter().zip(&chosen);
        values.all(|((_, own), chosen)| chosen.as_ref().is_none_or(|chosen| own == chosen))
    });
    let (Some(point), None) = (points.next(), points.next()) else {
        let open = study.sweeps.iter().zip(&chosen).filter(|(_, chosen)| chosen.is_none());
        let open: Vec<&str> = open.map(|(sweep, _)| sweep.key.name).collect();
        let message =
            format!("the study has several points\nchoose one: `at = KEY=VALUE` for {}", open.join(", "));
        return Err(SimulateError::Request(message));
    };
    Ok(point)
}
