//! Tests that run the program `sagnac` as a user would. What they share is in `tests/common`.

#[path = "../common/browser.rs"]
mod browser;
#[path = "../common/desk.rs"]
mod desk;
#[path = "../common/devices.rs"]
mod devices;
#[path = "../common/fitted.rs"]
mod fitted;
#[path = "../common/generated.rs"]
mod generated;
#[path = "../common/logs.rs"]
mod logs;
#[path = "../common/noise.rs"]
mod noise;
#[path = "../common/stores.rs"]
mod stores;
#[path = "../common/studies.rs"]
mod studies;

mod accelerometers;
// Windows takes the cache folder from no variable.
#[cfg(unix)]
mod adapters;
mod allan;
mod allan_bootstrap;
mod allan_dynamic;
mod allan_files;
mod allan_navigators;
mod allan_record;
mod answers;
mod bad_logs;
mod bad_motions;
mod bad_relocks;
mod bad_runs;
mod bad_studies;
mod batch;
mod cli;
mod compare;
mod curves_of_rows;
mod damages;
mod decisions;
mod descriptions;
mod design;
mod design_choices;
mod detection;
mod documents;
#[cfg(unix)]
mod escapes;
mod events;
mod exact_studies;
mod filler;
mod folders;
mod full_disks;
mod gallery;
mod given_curves;
mod goldens;
mod groups;
mod help;
mod identity;
mod kills;
mod log_columns;
mod log_pages;
mod manual;
mod messy_logs;
mod model;
mod model_files;
mod psd;
mod reference;
mod report;
mod resumed;
mod sensitivity;
mod shaders;
mod shards;
mod simulate;
mod soak;
mod stops;
#[cfg(unix)]
mod strangers;
mod tables;
mod temperature;
mod terminal;
#[cfg(unix)]
mod written_files;

/// The root of the repository.
const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
