//! Shader sources: the files of `shaders/`, put together and specialised as text.
//!
//! Override constants can give invalid modules (wgpu#7793), so shapes and variants are written into the text. Three
//! directives do it, each on a line of its own and closed by `//#end`:
//! `//#for k in 0..N` repeats its lines with the word `k` replaced by 0u, 1u, …; `//#if FLAG` and `//#else` choose.

#[cfg(test)]
mod tests;

use std::collections::HashMap;

use crate::kernel::gap_fill::shape::{self, MARGIN, Shape};
use crate::kernel::launch::Sampled;
use crate::kernel::map::Map;
use crate::kernel::moments::{BIN_BITS, BINS, FLUSH, LEVEL_OFFSET};
use crate::kernel::philox::PURPOSES;
use crate::kernel::power::{EXP2, LOG2};
use crate::kernel::recipe::{self, Recipe};
use crate::kernel::relock::{self, WEIGHT_BITS};
use crate::kernel::relock_ticks::{self, Method};
use crate::kernel::sine::SINE;
use crate::kernel::switched_run;

const WORD: &str = include_str!("../../../../shaders/word.wgsl");
const PHILOX: &str = include_str!("../../../../shaders/philox.wgsl");
const NORMAL: &str = include_str!("../../../../shaders/normal.wgsl");
const SINE_: &str = include_str!("../../../../shaders/sine.wgsl");
const POWER: &str = include_str!("../../../../shaders/power.wgsl");
const MOTION: &str = include_str!("../../../../shaders/motion.wgsl");
const GAP_FILL: &str = include_str!("../../../../shaders/gap_fill.wgsl");
const SWITCHED_RUN: &str = include_str!("../../../../shaders/switched_run.wgsl");
const RELOCK_TICKS: &str = include_str!("../../../../shaders/relock_ticks.wgsl");
const RELOCK: &str = include_str!("../../../../shaders/relock.wgsl");
const MOMENTS: &str = include_str!("../../../../shaders/moments.wgsl");
const NOISE: &str = include_str!("../../../../shaders/noise.wgsl");
const ALLAN: &str = include_str!("../../../../shaders/allan.wgsl");
const MAP: &str = include_str!("../../../../shaders/map.wgsl");

/// Words of a workgroup's partial sums of one estimate: Σ and Σ² of three words each, least, greatest.
pub const PARTIAL_WORDS: usize = 8;

/// Words of an invocation's sums of one estimate: Σ and Σ² of two words each, least, greatest.
const STAGED_WORDS: usize = 6;

/// Workgroups of a row of a dispatch: below every device's limit of a dimension.
pub const GROUPS_PER_ROW: u32 = 32768;

/// How a kernel is built for a device. All variants give the same bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Variant {
    /// Products through 64-bit registers and not from 16-bit parts.
    pub int64: bool,
    /// With the bounds checks of the shader compiler.
    pub checked: bool,
    /// Invocations of a workgroup, a power of two.
    pub workgroup: u32,
}

/// What is its own in the shader of a kernel that samples.
struct OfKernel {
    parts: Vec<&'static str>,
    constants: Vec<(&'static str, usize)>,
    flags: Vec<(&'static str, bool)>,
    /// Places of the parameter words.
    places: String,
    words: usize,
}

/// The shader that samples a launch.
pub fn moments(sampled: Sampled, histogram: bool, variant: Variant) -> String {
    let own = match sampled {
        Sampled::GapFill(shape) => gap_fill(shape),
        Sampled::SwitchedRun(shape) => switched_run(shape),
        Sampled::Relock(shape) => relock(shape),
    };
    let estimates = sampled.estimates();
    let staged = STAGED_WORDS * variant.workgroup as usize;
    let shared_words = estimates * if histogram { BINS.max(staged) } else { staged };
    let mut constants = vec![
        ("ESTIMATES", estimates),
        ("PARAMETER_WORDS", own.words),
        ("PARAMETER_VECTORS", own.words.div_ceil(4)),
        ("SHARED_WORDS", shared_words),
    ];
    constants.extend(own.constants);
    let mut flags = vec![("HISTOGRAM", histogram), ("TABLE", sampled.has_table())];
    flags.extend(own.flags);
    let flags: Vec<&str> = flags.into_iter().filter(|flag| flag.1).map(|flag| flag.0).collect();
    let parts: Vec<&str> = [WORD, PHILOX, NORMAL].into_iter().chain(own.parts).chain([MOMENTS]).collect();
    own.places + &assemble(&parts, &constants, &flags, variant)
}

fn gap_fill(shape: Shape) -> OfKernel {
    let (residuals, extrapolations) =
        (if shape.residual { shape.fillers } else { 0 }, if shape.extrapolation { shape.fillers } else { 0 });
    let constants = vec![
        ("BEFORE", shape.before),
        ("AFTER", shape.after),
        ("SIDES", shape.sides()),
        ("RESIDUAL_BEFORE", shape.residual_before),
        ("EXTRAPOLATION_BEFORE", shape.extrapolation_before),
        ("FILLERS", shape.fillers),
        ("EXTRAPOLATIONS", residuals),
        ("IN_GAPS", residuals + extrapolations),
        ("KEPT", if shape.in_gap { shape.before } else { 1 }),
        ("TONES", shape.tones),
        // There is no array without elements.
        ("TONE_ROOM", shape.tones.max(1)),
        ("ROWS", shape.rows()),
        ("GAP_TICKS", shape.gap_ticks),
        ("GAUSSIANS", shape.gaussians()),
        ("GAUSSIAN_SIDES", shape.gaussian_row(shape.gap_ticks)),
        ("MOTION_TABLE", shape.motion_table()),
        ("MARGIN", MARGIN),
    ];
    let flags = vec![
        ("WIDE", shape.wide),
        ("RESIDUAL", shape.residual),
        ("EXTRAPOLATION", shape.extrapolation),
        ("IN_GAP", shape.in_gap),
        ("AMPLITUDES", shape.amplitudes),
        ("FREQUENCIES", shape.frequencies),
        ("DRAWN", shape.amplitudes || shape.frequencies),
        ("GAUSSIAN", shape.gaussian),
        ("PROFILE", shape.profile),
        ("EVERY", shape.every),
        ("CONSTANTS", shape.constants),
        ("READOUT", shape.readout),
    ];
    OfKernel {
        parts: vec![SINE_, MOTION, GAP_FILL],
        constants,
        flags,
        places: shape::wgsl_places(shape),
        words: shape::word_count(shape),
    }
}

fn switched_run(shape: switched_run::Shape) -> OfKernel {
    let mut own = OfKernel {
        parts: if shape.warm_up || shape.relock.is_some() { vec![SINE_, POWER] } else { vec![SINE_] },
        constants: vec![
            ("TONES", shape.tones),
            // There is no array without elements.
            ("TONE_ROOM", shape.tones.max(1)),
            ("PHASE_BLOCKS", shape.tones.div_ceil(4)),
            ("TIMES", shape.times),
            ("FIRST_TIME", shape.first_time()),
            ("ROW", shape.row()),
        ],
        flags: vec![
            ("ENDS", shape.ends),
            ("WALK", shape.walk),
            ("NOISE", shape.noise),
            ("SPREAD", shape.spreads()),
            ("MAGNETIC", shape.magnetic),
            ("INITIAL", shape.initial),
            ("NON_MAGNETIC", shape.non_magnetic),
            ("MODE", shape.mode),
            ("WARM_UP", shape.warm_up),
            ("RELOCKING", shape.relock.is_some()),
        ],
        places: switched_run::shape::wgsl_places(shape),
        words: switched_run::shape::word_count(shape),
    };
    if let Some(ticks) = shape.relock {
        own.include_relock_ticks(ticks);
    }
    own.parts.push(SWITCHED_RUN);
    own
}

fn relock(shape: relock::Shape) -> OfKernel {
    let mut own = OfKernel {
        parts: vec![POWER],
        constants: vec![("WEIGHT_BITS", WEIGHT_BITS as usize)],
        flags: vec![],
        places: relock::wgsl_places(shape),
        words: relock::word_count(shape),
    };
    own.include_relock_ticks(shape.ticks);
    own.parts.push(RELOCK);
    own
}

impl OfKernel {
    /// Adds what relocks at a switch to a kernel that has a field `relock` for its parameters.
    fn include_relock_ticks(&mut self, shape: relock_ticks::Shape) {
        self.parts.push(RELOCK_TICKS);
        self.constants.extend([("RELOCK_TICKS", shape.ticks), ("RELOCK_BLOCKS", relock_ticks::BLOCKS)]);
        self.flags.push(("RELOCK_BY_FREQUENCY", shape.method == Method::Frequency));
        self.flags.push(("RELOCK_BY_DETUNING", shape.method == Method::Detuning));
        self.places += &relock_ticks::places(shape);
    }
}

/// Words of a record's state before those of its holds.
pub const STATE_WORDS: usize = 11;

/// Vectors of four words for the standard deviations of flicker noise: octave o has place o.
pub fn flicker_vectors(recipe: &Recipe) -> usize {
    recipe.octaves().max(1).div_ceil(4)
}

/// The shader of the Allan kernel for records of a recipe.
pub fn allan(recipe: &Recipe, variant: Variant) -> String {
    let octaves = recipe.octaves();
    let constants = [
        ("CHUNK", recipe::CHUNK),
        ("OCTAVES", octaves),
        ("STREAMS", recipe::STREAMS),
        ("FOUR_STREAMS", recipe::FOUR_STREAMS),
        ("LONG_HOLDS", recipe::LONG_HOLDS),
        ("HOLD_ROOM", recipe::STREAMS * octaves.max(1)),
        ("STATE_WORDS", STATE_WORDS),
        ("FLICKER_VECTORS", flicker_vectors(recipe)),
        ("LEVELS", recipe.levels.len()),
        ("SPAN_VECTORS", recipe.places().div_ceil(4)),
        ("PLACES", recipe.places()),
        ("ORDER", recipe.order as usize),
    ];
    let flags: Vec<&str> = [
        ("FLICKER_HOLDS", octaves > 1),
        ("WALK_STEPS", recipe.walk > 0),
        ("MARKOV_STEPS", recipe.markov.is_some()),
        ("SINE_WAVE", recipe.sine.is_some()),
        ("QUANTISATION_NOISE", recipe.quantisation > 0),
        ("PULSE", recipe.pulse.is_some()),
        ("DRIFT", !recipe.drift.is_empty()),
        ("FILL_RESIDUALS", recipe.switching.is_some()),
        ("THIRD_ORDER", recipe.order == 3),
    ]
    .into_iter()
    .filter(|flag| flag.1)
    .map(|flag| flag.0)
    .collect();
    assemble(&[WORD, PHILOX, NORMAL, SINE_, NOISE, ALLAN], &constants, &flags, variant)
}

/// The shader of a building block.
pub fn map(map: &Map, variant: Variant) -> String {
    let constants = [("INPUTS", map.inputs), ("OUTPUTS", map.outputs)];
    assemble(&[WORD, PHILOX, NORMAL, SINE_, POWER, MAP], &constants, &[], variant)
        .replace("// EVALUATE", map.wgsl)
}

fn assemble(parts: &[&str], constants: &[(&str, usize)], flags: &[&str], variant: Variant) -> String {
    let fixed = [
        ("WORKGROUP", variant.workgroup as usize),
        ("FLUSH", FLUSH as usize),
        ("BINS", BINS),
        ("BIN_BITS", BIN_BITS as usize),
        ("LEVEL_OFFSET", LEVEL_OFFSET as usize),
        ("PARTIAL_WORDS", PARTIAL_WORDS),
        ("STAGED_WORDS", STAGED_WORDS),
        ("GROUPS_PER_ROW", GROUPS_PER_ROW as usize),
    ];
    let purposes = PURPOSES.map(|(name, purpose)| (name, purpose as usize));
    let all: HashMap<&str, usize> =
        constants.iter().chain(&fixed).chain(&purposes).map(|&(name, value)| (name, value)).collect();
    let mut names: Vec<_> = all.iter().collect();
    names.sort();
    let header: String =
        names.iter().map(|(name, value)| format!("const {name}: u32 = {value}u;\n")).collect();
    let polynomials =
        [("SINE", &SINE[..]), ("LOG2", &LOG2[..]), ("EXP2", &EXP2[..])].map(polynomial).concat();
    let mut flags = flags.to_vec();
    if variant.int64 {
        flags.push("INT64");
    }
    let lines: Vec<&str> = parts.iter().flat_map(|part| part.lines()).collect();
    let mut body = String::new();
    let mut at = 0;
    while at < lines.len() {
        at = expand(&lines, at, &all, &flags, &mut body);
    }
    format!("{header}{polynomials}{body}")
}

/// The coefficients of a polynomial as a constant of a shader.
fn polynomial((name, coefficients): (&str, &[u32])) -> String {
    let list: Vec<String> = coefficients.iter().map(|coefficient| format!("{coefficient}u")).collect();
    format!("const {name} = array<u32, {}>({});\n", coefficients.len(), list.join(", "))
}

/// Expands the line `at`, or the directive that starts there, and returns the line behind it.
fn expand(
    lines: &[&str],
    at: usize,
    constants: &HashMap<&str, usize>,
    flags: &[&str],
    to: &mut String,
) -> usize {
    let line = lines[at].trim();
    if let Some(rest) = line.strip_prefix("//#for ") {
        let (name, range) = rest.split_once(" in 0..").expect("for NAME in 0..COUNT");
        let count = constants.get(range).copied().or(range.parse().ok()).expect("a known count");
        let end = block_end(lines, at);
        for value in 0..count {
            let body: Vec<String> = lines[at + 1..end]
                .iter()
                .map(|line| replace_word(line, name, &format!("{value}u")))
                .collect();
            let body: Vec<&str> = body.iter().map(String::as_str).collect();
            let mut inner = 0;
            while inner < body.len() {
                inner = expand(&body, inner, constants, flags, to);
            }
        }
        end + 1
    } else if let Some(flag) = line.strip_prefix("//#if ") {
        let end = block_end(lines, at);
        let middle = (at + 1..end).find(|&i| depth(&lines[at + 1..i]) == 0 && lines[i].trim() == "//#else");
        let (mut inner, stop) = match (flags.contains(&flag), middle) {
            (true, middle) => (at + 1, middle.unwrap_or(end)),
            (false, Some(middle)) => (middle + 1, end),
            (false, None) => (end, end),
        };
        while inner < stop {
            inner = expand(lines, inner, constants, flags, to);
        }
        end + 1
    } else {
        to.push_str(lines[at]);
        to.push('\n');
        at + 1
    }
}

/// The line of the `//#end` that closes the directive at `start`.
fn block_end(lines: &[&str], start: usize) -> usize {
    (start + 1..lines.len())
        .find(|&i| lines[i].trim() == "//#end" && depth(&lines[start + 1..i]) == 0)
        .expect("a directive is closed")
}

/// How many directives `lines` open and do not close.
fn depth(lines: &[&str]) -> i32 {
    lines
        .iter()
        .map(|line| match line.trim() {
            "//#end" => -1,
            line if line.starts_with("//#for ") || line.starts_with("//#if ") => 1,
            _ => 0,
        })
        .sum()
}

/// `line` with the whole word `name` replaced.
fn replace_word(line: &str, name: &str, by: &str) -> String {
    if line.trim().starts_with("//") && !line.trim().starts_with("//#") {
        return line.to_owned();
    }
    let in_word = |c: char| c.is_alphanumeric() || c == '_';
    let mut replaced = String::new();
    let mut rest = line;
    while let Some(found) = rest.find(name) {
        replaced += &rest[..found];
        let whole = !replaced.ends_with(in_word) && !rest[found + name.len()..].starts_with(in_word);
        replaced += if whole { by } else { name };
        rest = &rest[found + name.len()..];
    }
    replaced + rest
}
