//! Measures what a GPU makes of the kernels, piece by piece; CONTRIBUTING.md says which part answers what.
//!
//! ```text
//! gpu_lab PART [--device TEXT] [--seconds S] [--tiny] [--out DIR]
//! ```
//! Each line of the standard output is a JSON object with a key `part`. The same figures for people go to the standard error
//! stream. `--tiny` makes everything small, for a rehearsal on a software adapter.

mod count;
mod counts;
mod dump;
mod edits;
mod engine;
mod expressions;
mod groups;
mod host;
mod kernel;
mod lab;
mod limit;
mod values;

use sagnac::device::Work;
use sagnac::verify::measured;
use sagnac_kernel::launch::Launch;
use serde_json::{Value, json};

struct Options {
    /// Part of the name of the adapter; otherwise the first that is no software adapter.
    device: Option<String>,
    /// How long each figure is repeated at least.
    seconds: f64,
    tiny: bool,
    /// Folder of the part `dump`.
    out: String,
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let part = arguments.next().unwrap_or_else(|| "info".to_owned());
    let mut options = Options { device: None, seconds: 0.4, tiny: false, out: "dump".to_owned() };
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--device" => options.device = Some(arguments.next().expect("--device TEXT")),
            "--seconds" => {
                options.seconds = arguments.next().and_then(|s| s.parse().ok()).expect("--seconds S")
            }
            "--tiny" => options.tiny = true,
            "--out" => options.out = arguments.next().expect("--out DIR"),
            other => panic!("unknown argument {other}"),
        }
    }
    if options.tiny {
        options.seconds = options.seconds.min(0.05);
    }
    match part.as_str() {
        "info" => info(),
        "kernel" => {
            kernel::kernel(&options);
        }
        "host" => host::host(&options),
        "engine" => engine::engine(&options),
        "records" => engine::records(&options),
        "groups" => {
            groups::groups(&options);
        }
        "long" => engine::long(&options),
        "limit" => limit::limit(&options),
        "counts" => counts::counts(),
        "dump" => dump::dump(&options),
        other => {
            panic!(
                "unknown part {other}: info, kernel, host, engine, records, groups, long, limit, counts, dump"
            )
        }
    }
}

fn emit(value: &Value) {
    println!("{value}");
}

/// The adapter that is meant, or the first that is no software one, or the first.
fn chosen<A>(options: &Options, all: Vec<A>, about: impl Fn(&A) -> (String, bool)) -> A {
    let rank = |adapter: &A| {
        let (name, is_software) = about(adapter);
        let is_meant =
            options.device.as_ref().is_none_or(|part| name.to_lowercase().contains(&part.to_lowercase()));
        (!is_meant, is_software)
    };
    all.into_iter().min_by_key(rank).expect("no adapter was found: `sagnac device list` lists them")
}

/// A measured kernel of trials.
struct Bench {
    name: &'static str,
    launch: Launch,
    histogram: bool,
}

/// Those of `sagnac device bench`; the first two are the paper's point without and with histogram.
fn benches() -> Vec<Bench> {
    let of = |measured: sagnac::verify::Measured| match measured.work {
        Work::Trials(launch) => {
            Some(Bench { name: measured.configuration, launch, histogram: measured.histogram })
        }
        Work::Records(_) => None,
    };
    measured().into_iter().filter_map(of).collect()
}

/// Lists adapters with their limits and features.
fn info() {
    for adapter in lab::adapters() {
        let info = adapter.get_info();
        let limits = adapter.limits();
        let features: Vec<&str> = adapter.features().iter_names().map(|(name, _)| name).collect();
        emit(&json!({
            "part": "info", "name": info.name, "backend": info.backend.to_string(), "driver": info.driver,
            "driver_info": info.driver_info, "type": format!("{:?}", info.device_type),
            "subgroup": [info.subgroup_min_size, info.subgroup_max_size],
            "workgroup_storage": limits.max_compute_workgroup_storage_size,
            "invocations": limits.max_compute_invocations_per_workgroup,
            "storage_buffers": limits.max_storage_buffers_per_shader_stage,
            "storage_binding": limits.max_storage_buffer_binding_size, "buffer": limits.max_buffer_size,
            "features": features,
        }));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Keeps the lab in step with the shaders and with the library; the figures mean nothing.
    #[test]
    fn every_part_runs_and_every_edit_that_should_keep_the_sums_keeps_them() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().to_str().unwrap().to_owned();
        let options = Options { device: None, seconds: 0.0, tiny: true, out };
        info();
        assert!(kernel::kernel(&options), "an edit changes the sums");
        host::host(&options);
        engine::engine(&options);
        engine::records(&options);
        assert!(groups::groups(&options), "a workgroup for a record gives other sums");
        limit::limit(&options);
        dump::dump(&options);
        assert!(folder.path().join("1-paper-histogram-u64-64-uniform.wgsl").exists());
    }
}
