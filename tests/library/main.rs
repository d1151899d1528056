//! Tests of the library `sagnac`. What they share is in `tests/common`.

#[path = "../common/devices.rs"]
mod devices;
#[path = "../common/fitted.rs"]
mod fitted;
#[path = "../common/formats.rs"]
mod formats;
#[path = "../common/generated.rs"]
mod generated;
#[path = "../common/noise.rs"]
mod noise;
#[path = "../common/reference/mod.rs"]
mod reference;
#[path = "../common/stores.rs"]
mod stores;
#[path = "../common/studies.rs"]
mod studies;

mod allan_closed_forms;
mod allan_fit;
mod allan_fit_records;
mod allan_studies;
mod compare_statistics;
mod damage;
mod decision;
mod device_faults;
mod events;
mod filler_memory;
mod filters;
mod fit_beside_model;
mod fit_range;
mod groups;
mod keys;
mod lock_in;
mod lock_in_integrator;
mod lock_in_studies;
mod log_formats;
mod lowering;
mod motions;
mod navigation;
mod pairs;
mod published;
mod record_lowering;
mod record_spectra;
mod record_switching;
mod record_theories;
mod records;
mod relock;
mod simulated_records;
mod spectrum;
mod steps;
mod switched_run;
mod temperature;
mod theories;
mod twins;

/// The root of the repository.
const ROOT: &str = env!("CARGO_MANIFEST_DIR");
