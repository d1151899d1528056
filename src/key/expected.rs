//! What each key of a study holds, for errors about values of the wrong type and about missing keys.

use std::ops::Range;

use toml::de::{DeTable, DeValue};

use crate::kinds::KINDS;

/// What a key holds, and how it may be written.
pub(crate) struct Expected {
    /// From the root, as in `sweep.log.from`; ends with `*` for a table whose keys are free.
    pub(crate) key: &'static str,
    pub(crate) what: &'static str,
    pub(crate) example: &'static str,
}

const fn entry(key: &'static str, what: &'static str, example: &'static str) -> Expected {
    Expected { key, what, example }
}

const TEXT: &str = "a text in quotes";
const QUANTITY: &str = "a number with its unit, in quotes";
const NUMBER: &str = "a whole number";
const RATIO: &str = "a number, or percent in quotes";
const END: &str = "a value of the key that is swept";
const DRAWN_AMPLITUDE: &str = "a number with its unit, in quotes, or a table of uniform or rayleigh";
const DRAWN_FREQUENCY: &str = "a number with its unit, in quotes, or a list of two";
const SPACING: &str = "a table of from, to and points";

const MODES: &str = "modes = [{ frequency = \"380 Hz\", q = 100, response = \"20000 arcsec/s/g\" }]";
const VIBRATION: &str = "random = { psd = [[\"20 Hz\", \"0.01 g^2/Hz\"], [\"2000 Hz\", \"0.01 g^2/Hz\"]] }";

/// Every key of a study file.
pub(crate) static KEYS: &[Expected] = &[
    entry("title", TEXT, "title = \"Error of the gap fillers\""),
    entry("question", TEXT, "question = \"Which filler is good enough?\""),
    entry("kind", TEXT, "kind = \"gap-fill\""),
    entry("seed", NUMBER, "seed = 1"),
    entry("trials", NUMBER, "trials = 1_000_000"),
    entry("precision", "a part in percent in quotes, or a table of rms and q9973", "precision = \"0.5 %\""),
    entry("precision.rms", "a part in percent in quotes", "rms = \"0.5 %\""),
    entry("precision.q9973", "a part in percent in quotes", "q9973 = \"2 %\""),
    entry("streams", TEXT, "streams = \"independent\""),
    entry("gyro", "a table", "[gyro]\ntick = \"5 ms\"\ntick_noise = { std = \"0.53 arcsec\" }"),
    entry("gyro.tick", QUANTITY, "tick = \"5 ms\""),
    entry(
        "gyro.tick_noise",
        "a table of std, three_sigma or angle_random_walk",
        "tick_noise = { std = \"0.53 arcsec\" }   # std = \"0 arcsec\" where there is none, as beside readout_lsb alone",
    ),
    entry("gyro.tick_noise.std", QUANTITY, "std = \"0.53 arcsec\""),
    entry("gyro.tick_noise.three_sigma", QUANTITY, "three_sigma = \"1.6 arcsec\""),
    entry("gyro.tick_noise.angle_random_walk", QUANTITY, "angle_random_walk = \"0.003 deg/sqrt(h)\""),
    entry("gyro.readout_lsb", QUANTITY, "readout_lsb = \"3.2 arcsec\""),
    entry("gyro.relock", "a list in brackets", "relock = [\"20.3 arcsec\", \"14.8 arcsec\"]"),
    entry("motion", "a table", "[motion]\namplitude = \"12000 arcsec/s\"\nfrequency = \"20 Hz\""),
    entry("motion.amplitude", DRAWN_AMPLITUDE, "amplitude = \"12000 arcsec/s\""),
    entry(
        "motion.amplitude.uniform",
        "a list of two ends",
        "uniform = [\"8000 arcsec/s\", \"12000 arcsec/s\"]",
    ),
    entry("motion.amplitude.rayleigh", QUANTITY, "rayleigh = \"8000 arcsec/s\""),
    entry("motion.frequency", DRAWN_FREQUENCY, "frequency = \"20 Hz\""),
    entry("motion.phase", TEXT, "phase = \"uniform\""),
    entry(
        "motion.tones",
        "a list of tables in brackets",
        "tones = [{ amplitude = \"12000 arcsec/s\", frequency = \"20 Hz\" }]",
    ),
    entry("motion.tones.amplitude", DRAWN_AMPLITUDE, "amplitude = \"12000 arcsec/s\""),
    entry(
        "motion.tones.amplitude.uniform",
        "a list of two ends",
        "uniform = [\"8000 arcsec/s\", \"12000 arcsec/s\"]",
    ),
    entry("motion.tones.amplitude.rayleigh", QUANTITY, "rayleigh = \"8000 arcsec/s\""),
    entry("motion.tones.frequency", DRAWN_FREQUENCY, "frequency = \"20 Hz\""),
    entry("motion.tones.phase", TEXT, "phase = \"uniform\""),
    entry(
        "motion.gaussian",
        "a table of rms and band, or of psd",
        "gaussian = { rms = \"8485 arcsec/s\", band = [\"18 Hz\", \"22 Hz\"] }",
    ),
    entry("motion.gaussian.rms", QUANTITY, "rms = \"8485 arcsec/s\""),
    entry("motion.gaussian.band", "a list of two ends", "band = [\"18 Hz\", \"22 Hz\"]"),
    entry(
        "motion.gaussian.psd",
        "a list of pairs, frequency and density",
        "psd = [[\"1 Hz\", \"10 (deg/s)^2/Hz\"], [\"50 Hz\", \"0.1 (deg/s)^2/Hz\"]]",
    ),
    entry("motion.profile", "a table of file and position", "profile = { file = \"base.csv\" }"),
    entry("motion.profile.file", TEXT, "file = \"base.csv\""),
    entry("motion.profile.position", TEXT, "position = \"random\""),
    entry(
        "motion.suspension",
        "a table of gyro or modes, and of sine or random",
        "suspension = { gyro = \"LGK-400\", sine = { acceleration = \"1 g\", frequency = \"700 Hz\" }, alias = true }",
    ),
    entry("motion.suspension.gyro", TEXT, "gyro = \"LGK-400\""),
    entry("motion.suspension.modes", "a list of tables in brackets", MODES),
    entry("motion.suspension.modes.frequency", QUANTITY, "frequency = \"380 Hz\""),
    entry("motion.suspension.modes.q", "a number", "q = 100"),
    entry("motion.suspension.modes.response", QUANTITY, "response = \"20000 arcsec/s/g\""),
    entry(
        "motion.suspension.sine",
        "a table of acceleration and frequency",
        "sine = { acceleration = \"1 g\", frequency = \"700 Hz\" }",
    ),
    entry("motion.suspension.sine.acceleration", QUANTITY, "acceleration = \"1 g\""),
    entry("motion.suspension.sine.frequency", QUANTITY, "frequency = \"700 Hz\""),
    entry("motion.suspension.random", "a table of psd and rms", VIBRATION),
    entry(
        "motion.suspension.random.psd",
        "a list of pairs, frequency and density",
        "psd = [[\"20 Hz\", \"0.01 g^2/Hz\"], [\"2000 Hz\", \"0.01 g^2/Hz\"]]",
    ),
    entry("motion.suspension.random.rms", QUANTITY, "rms = \"5 g\""),
    entry("motion.suspension.alias", "true or false", "alias = true"),
    entry("motion.rate", QUANTITY, "rate = \"10 deg/s\""),
    entry("motion.acceleration", QUANTITY, "acceleration = \"100 deg/s^2\""),
    entry("drift", "a table", "[drift]\nmagnetic = \"14 arcsec/s\"\nwarm_up_time = \"3000 s\""),
    entry("drift.magnetic", QUANTITY, "magnetic = \"14 arcsec/s\""),
    entry("drift.magnetic_spread", QUANTITY, "magnetic_spread = \"1 arcsec/s\""),
    entry("drift.warm_up_time", QUANTITY, "warm_up_time = \"3000 s\""),
    entry("drift.warm_up_time_spread", RATIO, "warm_up_time_spread = \"5 %\""),
    entry("drift.non_magnetic", QUANTITY, "non_magnetic = \"0.05 arcsec/s\""),
    entry("drift.non_magnetic_spread", QUANTITY, "non_magnetic_spread = \"0.01 arcsec/s\""),
    entry("drift.initial_magnetic", QUANTITY, "initial_magnetic = \"1 arcsec/s\""),
    entry("drift.initial_magnetic_spread", QUANTITY, "initial_magnetic_spread = \"0.1 arcsec/s\""),
    entry("drift.angle_random_walk", QUANTITY, "angle_random_walk = \"0.003 deg/sqrt(h)\""),
    entry("drift.residual_max", QUANTITY, "residual_max = \"10 arcsec\""),
    entry("run", "a table", "[run]\nduration = \"1 h\""),
    entry("run.duration", QUANTITY, "duration = \"1 h\""),
    entry("run.times", "a list of times in brackets", "times = [\"10 min\", \"30 min\"]"),
    entry("run.trajectories", NUMBER, "trajectories = 20"),
    entry("switching", "a table", "[switching]\ngap_ticks = 3\nfillers = [\"const\", \"quadratic\"]"),
    entry("switching.interval", QUANTITY, "interval = \"40 s\""),
    entry("switching.first_mode", TEXT, "first_mode = \"positive\""),
    entry("switching.timing", TEXT, "timing = \"random\""),
    entry("switching.gap_ticks", NUMBER, "gap_ticks = 3"),
    entry("switching.fit_ticks", "a list in brackets", "fit_ticks = [-1, 0, \"n+1\", \"n+2\"]"),
    entry("switching.extrapolation_ticks", "a list in brackets", "extrapolation_ticks = [-3, -2, -1, 0]"),
    entry(
        "switching.fillers",
        "a list in brackets",
        "fillers = [\"const\", \"quadratic\", { kind = \"minimum-variance\", name = \"mv8+2\", fit_ticks = [\"-7..0\", \"n+1\", \"n+2\"] }]",
    ),
    entry("switching.fillers.kind", TEXT, "kind = \"minimum-variance\""),
    entry("switching.fillers.name", TEXT, "name = \"mv8+2\""),
    entry("switching.fillers.fit_ticks", "a list in brackets", "fit_ticks = [\"-7..0\", \"n+1\", \"n+2\"]"),
    entry("switching.fillers.extrapolation_ticks", "a list in brackets", "extrapolation_ticks = [\"-7..0\"]"),
    entry("switching.fillers.band", "a list of two ends", "band = [\"18 Hz\", \"22 Hz\"]"),
    entry("switching.fillers.weights", "a list in brackets", "weights = [-1, \"5/2\", \"5/2\", -1]"),
    entry(
        "switching.fillers.extrapolation_weights",
        "a list in brackets",
        "extrapolation_weights = [\"3/4\", \"3/4\", \"3/4\", \"3/4\"]",
    ),
    entry("switching.errors", "a list in brackets", "errors = [\"residual\", \"extrapolation\", \"in-gap\"]"),
    entry(
        "relock",
        "a table",
        "[relock]\nmiss = 0.05\nloop_time = \"12 ms\"\nbias_frequency = \"80 kHz\"\npulse_weight = \"2.6 arcsec\"\ncurvature = 40",
    ),
    entry("relock.compensation", TEXT, "compensation = \"detuning\""),
    entry("relock.miss", RATIO, "miss = 0.05"),
    entry("relock.half_wave_error", RATIO, "half_wave_error = 0.005"),
    entry("relock.dac_step", RATIO, "dac_step = 0.002"),
    entry("relock.hysteresis", RATIO, "hysteresis = 0.005"),
    entry("relock.loop_time", QUANTITY, "loop_time = \"12 ms\""),
    entry("relock.bias_frequency", QUANTITY, "bias_frequency = \"80 kHz\""),
    entry("relock.pulse_weight", QUANTITY, "pulse_weight = \"2.6 arcsec\""),
    entry("relock.curvature", RATIO, "curvature = 40"),
    entry("relock.temperature_error", RATIO, "temperature_error = \"0.1 %\""),
    entry("relock.adc_noise", RATIO, "adc_noise = 0.0001"),
    entry("relock.adc_step", RATIO, "adc_step = 0.0002"),
    entry("relock.count_step", RATIO, "count_step = 1"),
    entry("relock.ticks", NUMBER, "ticks = 4"),
    entry("relock.first_half", TEXT, "first_half = \"negative\""),
    entry("relock.signal_gain", RATIO, "signal_gain = 20"),
    entry("suspension", "a table", "[suspension]\ngyro = \"LGK-400\"\nfrequency = \"380 Hz\""),
    entry("suspension.gyro", TEXT, "gyro = \"LGK-400\""),
    entry("suspension.modes", "a list of tables in brackets", MODES),
    entry("suspension.modes.frequency", QUANTITY, "frequency = \"380 Hz\""),
    entry("suspension.modes.q", "a number", "q = 100"),
    entry("suspension.modes.response", QUANTITY, "response = \"20000 arcsec/s/g\""),
    entry("suspension.frequency", QUANTITY, "frequency = \"380 Hz\""),
    entry("record", "a table", "[record]\nsample = \"1 s\"\nlength = \"9 h\""),
    entry("record.sample", QUANTITY, "sample = \"1 s\""),
    entry("record.length", QUANTITY, "length = \"9 h\""),
    entry("record.rate", QUANTITY, "rate = \"10 deg/h\""),
    entry("noise", "a table", "[noise]\nangle_random_walk = \"0.00048 deg/sqrt(h)\""),
    entry("noise.file", TEXT, "file = \"noise.toml\""),
    entry("noise.quantisation", QUANTITY, "quantisation = \"0.11 arcsec\""),
    entry("noise.readout_lsb", QUANTITY, "readout_lsb = \"0.38 arcsec\""),
    entry("noise.angle_random_walk", QUANTITY, "angle_random_walk = \"0.00048 deg/sqrt(h)\""),
    entry("noise.bias_instability", QUANTITY, "bias_instability = \"0.00164 deg/h\""),
    entry("noise.rate_random_walk", QUANTITY, "rate_random_walk = \"0.001 deg/h/sqrt(h)\""),
    entry("noise.rate_ramp", QUANTITY, "rate_ramp = \"0.0001 deg/h/h\""),
    entry(
        "noise.markov",
        "a table of amplitude and time",
        "markov = { amplitude = \"0.002 deg/h\", time = \"300 s\" }",
    ),
    entry("noise.markov.amplitude", QUANTITY, "amplitude = \"0.002 deg/h\""),
    entry("noise.markov.time", QUANTITY, "time = \"300 s\""),
    entry(
        "noise.sine",
        "a table of amplitude and frequency",
        "sine = { amplitude = \"0.01 deg/h\", frequency = \"0.01 Hz\" }",
    ),
    entry("noise.sine.amplitude", QUANTITY, "amplitude = \"0.01 deg/h\""),
    entry("noise.sine.frequency", QUANTITY, "frequency = \"0.01 Hz\""),
    entry(
        "noise.warm_up",
        "a table of amplitude and time",
        "warm_up = { amplitude = \"0.1 deg/h\", time = \"20 min\" }",
    ),
    entry("noise.warm_up.amplitude", QUANTITY, "amplitude = \"0.1 deg/h\""),
    entry("noise.warm_up.time", QUANTITY, "time = \"20 min\""),
    entry(
        "noise.switching",
        "a table of interval and what switches leave",
        "switching = { interval = \"40 s\", residual = \"10 arcsec\" }",
    ),
    entry("noise.switching.interval", QUANTITY, "interval = \"40 s\""),
    entry("noise.switching.magnetic", QUANTITY, "magnetic = \"14 arcsec/s\""),
    entry("noise.switching.warm_up_time", QUANTITY, "warm_up_time = \"50 min\""),
    entry("noise.switching.initial_magnetic", QUANTITY, "initial_magnetic = \"0.1 deg/h\""),
    entry("noise.switching.residual", QUANTITY, "residual = \"10 arcsec\""),
    entry("noise.switching.residual_noise", QUANTITY, "residual_noise = \"2 arcsec\""),
    entry("allan", "a table", "[allan]\ntau = \"octave\"\nfit = [\"Q\", \"N\", \"B\"]"),
    entry("allan.tau", "a text in quotes, or a list of times", "tau = \"octave\""),
    entry("allan.estimator", TEXT, "estimator = \"overlapping\""),
    entry("allan.overlap", TEXT, "overlap = \"full\""),
    entry("allan.fit", "a text in quotes, or a list of texts", "fit = [\"Q\", \"N\", \"B\"]"),
    entry(
        "sweep",
        "a table [[sweep]], or several",
        "[[sweep]]\nkey = \"motion.frequency\"\nlist = [\"2 Hz\", \"5 Hz\"]",
    ),
    entry("sweep.key", TEXT, "key = \"motion.frequency\""),
    entry("sweep.list", "a list in brackets", "list = [\"2 Hz\", \"5 Hz\"]"),
    entry("sweep.linear", SPACING, "linear = { from = \"2 Hz\", to = \"40 Hz\", points = 20 }"),
    entry("sweep.linear.from", END, "from = \"2 Hz\""),
    entry("sweep.linear.to", END, "to = \"40 Hz\""),
    entry("sweep.linear.points", NUMBER, "points = 20"),
    entry("sweep.log", SPACING, "log = { from = \"2 Hz\", to = \"40 Hz\", points = 24 }"),
    entry("sweep.log.from", END, "from = \"2 Hz\""),
    entry("sweep.log.to", END, "to = \"40 Hz\""),
    entry("sweep.log.points", NUMBER, "points = 24"),
    entry("chart", "one table [chart] or several [[chart]]", "[chart]\nx = \"dt_nu\"\ny = \"rms\""),
    entry("chart.kind", TEXT, "kind = \"heat-map\""),
    entry("chart.table", TEXT, "table = \"coefficients\""),
    entry("chart.title", TEXT, "title = \"Largest error\""),
    entry("chart.x", TEXT, "x = \"dt_nu\""),
    entry("chart.y", TEXT, "y = \"rms\""),
    entry("chart.z", TEXT, "z = \"q9973\""),
    entry("chart.of", TEXT, "of = \"filler\""),
    entry("chart.series", "a list in brackets", "series = [\"filler\", \"gap_ticks\"]"),
    entry("chart.laws", "a list in brackets", "laws = [\"taylor-extremum\", \"noise\"]"),
    entry("chart.where", "a table of columns and values", "where = { error = \"residual\" }"),
    entry("chart.where.*", "one value", "where = { error = \"residual\" }"),
    entry("chart.limit", QUANTITY, "limit = \"10 arcsec\""),
    entry("chart.x_scale", TEXT, "x_scale = \"log\""),
    entry("chart.y_scale", TEXT, "y_scale = \"linear\""),
    entry("chart.z_scale", TEXT, "z_scale = \"log\""),
];

impl Expected {
    /// How a table may be written in a study of this kind.
    pub(crate) fn of_table(table: &str, kind: &str) -> Option<&'static str> {
        match (table, kind) {
            ("switching", "drift-budget" | "switched-run") => Some("[switching]\ninterval = \"40 s\""),
            ("gyro", "relock") => Some("[gyro]\ntick = \"5 ms\""),
            _ => Expected::of(table).map(|expected| expected.example),
        }
    }

    pub(crate) fn of(key: &str) -> Option<&'static Expected> {
        let any_in = |pattern: &str| pattern.strip_suffix('*').is_some_and(|table| key.starts_with(table));
        KEYS.iter().find(|expected| expected.key == key || any_in(expected.key))
    }
}

/// How an axis of a chart may be written in this study: over what it sweeps, and of an estimate that its kind has.
pub(crate) fn axis_of(key: &str, text: &str) -> Option<String> {
    let study: toml::Table = text.parse().ok()?;
    let kind = study.get("kind").and_then(toml::Value::as_str);
    let kind = KINDS.into_iter().find(|known| Some(known.name) == kind)?;
    match key {
        "chart.x" => {
            let swept = || study.get("sweep")?.as_array()?.first()?.get("key")?.as_str();
            Some(format!("x = \"{}\"", kind.look.along.or_else(swept)?))
        }
        "chart.y" => Some(format!("y = \"{}\"", kind.look.estimate)),
        _ => None,
    }
}

/// A value as it stands in a study.
pub(crate) struct Found {
    /// From the root, without the places in lists; empty for the root.
    pub(crate) key: String,
    /// Whether it is an item of the key's list.
    pub(crate) item: bool,
    /// For sentences: `a list`, `the number 5`.
    pub(crate) what: String,
}

/// The values at these bytes of a TOML text: several where tables are written as dotted keys only.
pub(crate) fn found_at(text: &str, place: &Range<usize>) -> Vec<Found> {
    let mut found = Vec::new();
    if let Ok(root) = DeTable::parse(text) {
        let span = root.span();
        search(&DeValue::Table(root.into_inner()), &span, "", false, place, &mut found);
    }
    found
}

fn search(
    value: &DeValue,
    span: &Range<usize>,
    key: &str,
    item: bool,
    place: &Range<usize>,
    found: &mut Vec<Found>,
) {
    if span == place {
        found.push(Found { key: key.to_owned(), item, what: description(value) });
    }
    match value {
        DeValue::Table(table) => {
            for (name, value) in table {
                let key = joined(key, name.get_ref());
                search(value.get_ref(), &value.span(), &key, false, place, found);
            }
        }
        DeValue::Array(items) => {
            for value in items.iter() {
                search(value.get_ref(), &value.span(), key, true, place, found);
            }
        }
        _ => {}
    }
}

/// The name of `key` in the table `table`, whose name is empty for the root.
pub(crate) fn joined(table: &str, key: &str) -> String {
    if table.is_empty() { key.to_owned() } else { format!("{table}.{key}") }
}

fn description(value: &DeValue) -> String {
    match value {
        DeValue::String(text) => format!("the text \"{text}\""),
        DeValue::Integer(number) if i64::from_str_radix(number.as_str(), number.radix()).is_err() => {
            format!("the far too large number {number}")
        }
        DeValue::Integer(number) => format!("the number {number}"),
        DeValue::Float(number) => format!("the number {number}"),
        DeValue::Boolean(value) => value.to_string(),
        DeValue::Datetime(_) => "a date or a time".to_owned(),
        DeValue::Array(_) => "a list".to_owned(),
        DeValue::Table(_) => "a table".to_owned(),
    }
}
