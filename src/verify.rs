//! Identity: the same bits from every width and device, shown on the user's own machine.

use sha2::{Digest, Sha256};

use crate::backend::cpu::{Cpu, Width};
use crate::backend::gpu::GpuError;
use crate::backend::{Device, Job};
use crate::block::{base_log2, cover};
use crate::kernel::gap_fill::{Launch, MAX_FILLERS};
use crate::kernel::map::Map;
use crate::kernel::moments::Moments;
use crate::kernel::word::Scalar;
use crate::kernel::{Form, KERNELS, Kernel, philox};
use crate::lower::Lowered;
use crate::study::{Amplitude, Filler, Inputs, Phase, Point, Streams, TickNoise};

/// A gap-fill point that identity is checked on.
#[derive(Debug, Clone)]
pub struct Configuration {
    pub name: &'static str,
    pub point: Point,
    pub fillers: Vec<Filler>,
}

impl Configuration {
    /// The paper's point with some other inputs, ticks or fillers.
    pub fn new(name: &'static str, change: impl FnOnce(&mut Configuration)) -> Configuration {
        let inputs = Inputs {
            tick_s: 0.005,
            tick_noise: TickNoise::Std(1.6 / 3.0),
            amplitude: Amplitude::Rate(12000.0),
            frequency_hz: 20.0,
            phase: Phase::Uniform,
            gap_ticks: 3,
        };
        let point = Point {
            index: 0,
            swept: vec![],
            inputs,
            fit_ticks: vec![],
            extrapolation_ticks: vec![-3, -2, -1, 0],
        };
        let mut configuration = Configuration { name, point, fillers: Filler::ALL.to_vec() };
        change(&mut configuration);
        if configuration.point.fit_ticks.is_empty() {
            let n = configuration.point.inputs.gap_ticks as i32;
            configuration.point.fit_ticks = vec![-1, 0, n + 1, n + 2];
        }
        configuration
    }

    /// The launches that sample it.
    pub fn launches(&self) -> Vec<Launch> {
        let lowered = Lowered::new(&self.point, &self.fillers, 1, Streams::Independent)
            .unwrap_or_else(|error| panic!("{} does not lower: {error}", self.name));
        let all: Vec<usize> = (0..self.fillers.len()).collect();
        all.chunks(MAX_FILLERS).map(|fillers| lowered.launch(fillers)).collect()
    }
}

/// Points that differ in all that the kernel distinguishes.
pub fn configurations() -> Vec<Configuration> {
    vec![
        Configuration::new("paper", |_| {}),
        Configuration::new("one-tick-gap", |c| c.point.inputs.gap_ticks = 1),
        Configuration::new("five-tick-gap", |c| c.point.inputs.gap_ticks = 5),
        Configuration::new("zero-crossing", |c| c.point.inputs.phase = Phase::ZeroCrossing),
        Configuration::new("extremum-without-noise", |c| {
            c.point.inputs.phase = Phase::Extremum;
            c.point.inputs.tick_noise = TickNoise::Std(0.0);
        }),
        Configuration::new("noise-without-motion", |c| {
            c.point.inputs.amplitude = Amplitude::Angle(0.0);
            c.point.inputs.tick_noise = TickNoise::AngleRandomWalk(2.0);
        }),
        Configuration::new("many-fit-ticks", |c| {
            c.point.fit_ticks = (-9..=0).chain(4..=9).collect();
            c.point.extrapolation_ticks = (-6..=0).collect();
            c.fillers = vec![Filler::Quadratic];
        }),
        Configuration::new("sparse-fit-ticks", |c| {
            c.point.fit_ticks = vec![-5, -2, 0, 4, 7];
            c.point.extrapolation_ticks = vec![-12, -4, 0];
            c.fillers = vec![Filler::Quadratic, Filler::Const];
        }),
    ]
}

/// What a check of one kernel found.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Verdict {
    pub kernel: &'static str,
    /// The first 64 bits of a SHA-256 over all results of the reference: the same on every machine.
    pub digest: u64,
    /// Which width or device differs from the reference, and where.
    pub differences: Vec<String>,
}

/// Runs every kernel for `units` trials or items on the portable width, on every other width of this machine and on
/// `device`, and compares bit for bit; `report` hears each verdict as it is reached.
///
/// # Errors
/// The device is lost or refuses.
pub fn verify(device: &mut Device, units: u64, mut report: impl FnMut(&Verdict)) -> Result<bool, GpuError> {
    let mut identical = true;
    for kernel in KERNELS {
        let verdict = verify_kernel(&kernel, device, units)?;
        identical &= verdict.differences.is_empty();
        report(&verdict);
    }
    Ok(identical)
}

fn verify_kernel(kernel: &Kernel, device: &mut Device, units: u64) -> Result<Verdict, GpuError> {
    let mut hasher = Sha256::new();
    let mut differences = Vec::new();
    match kernel.form {
        Form::Map(map) => {
            let items = items(&map, units.min(1 << 20) as usize);
            let reference = (map.cpu)(Width::Portable, &items);
            for width in Width::available() {
                if (map.cpu)(width, &items) != reference {
                    differences.push(width.name().to_owned());
                }
            }
            if device.map(&map, &items)? != reference {
                differences.push(device.name());
            }
            hasher.update(bytemuck::cast_slice::<u32, u8>(&reference));
        }
        Form::GapFill => {
            for configuration in configurations() {
                for launch in configuration.launches() {
                    let reference = on_cpu(Width::Portable, &launch, units);
                    for width in Width::available() {
                        if on_cpu(width, &launch, units) != reference {
                            differences.push(format!("{} ({})", width.name(), configuration.name));
                        }
                    }
                    if tally(device, &launch, units)? != reference {
                        differences.push(format!("{} ({})", device.name(), configuration.name));
                    }
                    reference.iter().for_each(|tally| digest(tally, &mut hasher));
                }
            }
        }
    }
    let hash = hasher.finalize();
    let digest = hash[..8].iter().fold(0, |digest, &byte| digest << 8 | u64::from(byte));
    Ok(Verdict { kernel: kernel.name, digest, differences })
}

/// The first kernel, if any, in which a device differs from the portable CPU on a small load.
///
/// # Errors
/// The device is lost or refuses.
pub fn self_test(device: &mut Device) -> Result<Option<&'static str>, GpuError> {
    for kernel in KERNELS {
        let same = match kernel.form {
            Form::Map(map) => {
                let items = items(&map, 4096);
                device.map(&map, &items)? == (map.cpu)(Width::Portable, &items)
            }
            Form::GapFill => {
                let launch = &Configuration::new("paper", |_| {}).launches()[0];
                tally(device, launch, 5000)? == on_cpu(Width::Portable, launch, 5000)
            }
        };
        if !same {
            return Ok(Some(kernel.name));
        }
    }
    Ok(None)
}

/// Input words for so many items of a building block, from the generator itself.
fn items(map: &Map, count: usize) -> Vec<u32> {
    let words = (count * map.inputs) as u32;
    let block =
        |counter| philox::philox([counter, 0, 0, u32::MAX].map(Scalar), philox::schedule([Scalar(0); 2]));
    let random = (0..words.div_ceil(4)).flat_map(|counter| block(counter).map(|word| word.0));
    random.take(words as usize).collect()
}

fn on_cpu(width: Width, launch: &Launch, trials: u64) -> Vec<Moments> {
    match Cpu::new(width, 0) {
        Ok(cpu) => fold(launch, cpu.tally(&jobs(launch, trials), true, &|_| {})),
        // Without threads the kernel still runs here.
        Err(_) => crate::kernel::gap_fill::tally(width, launch, 0, trials, true),
    }
}

fn tally(device: &mut Device, launch: &Launch, trials: u64) -> Result<Vec<Moments>, GpuError> {
    Ok(fold(launch, device.tally(&jobs(launch, trials), true, &|_| {})?))
}

fn jobs(launch: &Launch, trials: u64) -> Vec<Job<'_>> {
    cover(0..trials, base_log2(trials)).into_iter().map(|block| Job { launch, block }).collect()
}

fn fold(launch: &Launch, parts: Vec<Vec<Moments>>) -> Vec<Moments> {
    let mut total = vec![Moments::empty(true); 2 * launch.shape.fillers];
    for part in parts {
        for (total, part) in total.iter_mut().zip(&part) {
            total.merge(part);
        }
    }
    total
}

fn digest(tally: &Moments, hasher: &mut Sha256) {
    hasher.update(tally.count.to_le_bytes());
    hasher.update(tally.sum.to_le_bytes());
    hasher.update(tally.square.to_le_bytes());
    hasher.update(tally.least.to_le_bytes());
    hasher.update(tally.greatest.to_le_bytes());
    tally.bins.iter().for_each(|bin| hasher.update(bin.to_le_bytes()));
}
