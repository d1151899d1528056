//! The Vulkan loader and the drivers that it finds.
//!
//! Paths and variables are those of the Vulkan loader's documents LoaderInterfaceArchitecture.md and
//! LoaderDriverInterface.md.

use crate::device::gpu::diagnosis::Finding;
use crate::device::gpu::diagnosis::cards::Card;
use crate::device::gpu::diagnosis::machine::Machine;
use crate::device::gpu::diagnosis::packages::{Package, nvidia_version};

/// The variables that replace the folders of manifests; the first that is set counts.
const REPLACING: [&str; 2] = ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"];

/// Where some hosts put NVIDIA's files for a container, although neither loader nor linker looks there.
const NVIDIA_FOLDER: &str = "/usr/local/nvidia";

/// NVIDIA's driver loads its shader compiler from a library of its own since this major version.
const SINCE_COMPILER: u32 = 550;

/// The manifest of a driver: a file that names its library.
struct Manifest {
    path: String,
    /// `None` where the file is no manifest.
    library: Option<String>,
}

impl Manifest {
    fn read(machine: &Machine, path: String) -> Manifest {
        let json: Option<serde_json::Value> = serde_json::from_str(&machine.text(&path)).ok();
        let library = json.as_ref().and_then(|json| json.pointer("/ICD/library_path")?.as_str());
        // A path with a folder is relative to the manifest, a bare name is left to the linker.
        let folder = path.rsplit_once('/').map_or("", |(folder, _)| folder);
        let library = library.map(|library| {
            let is_relative = library.contains('/') && !library.starts_with('/');
            if is_relative { format!("{folder}/{library}") } else { library.to_owned() }
        });
        Manifest { path, library }
    }

    /// All manifests in some folders.
    fn in_folders(machine: &Machine, folders: &[String]) -> Vec<Manifest> {
        let files = folders.iter().flat_map(|folder| {
            let names = machine.names(folder).into_iter().filter(|name| name.ends_with(".json"));
            names.map(move |name| format!("{folder}/{name}"))
        });
        files.map(|path| Manifest::read(machine, path)).collect()
    }

    /// All manifests that the loader reads.
    fn all(machine: &Machine) -> Vec<Manifest> {
        let Some((_, paths)) = replacing(machine) else {
            return Manifest::in_folders(machine, &folders(machine));
        };
        let is_folder = |path: &str| machine.path(path).is_dir();
        let paths = paths.into_iter().filter(|path| machine.has(path));
        let manifests = paths.flat_map(|path| {
            if is_folder(&path) {
                Manifest::in_folders(machine, &[path])
            } else {
                vec![Manifest::read(machine, path)]
            }
        });
        manifests.collect()
    }

    fn drives(&self, libraries: &[&str]) -> bool {
        let own = self.library.as_deref().unwrap_or_default();
        libraries.iter().any(|library| own.contains(library))
    }
}

/// The variable that replaces the folders of manifests, if one is set, with the paths in it.
fn replacing(machine: &Machine) -> Option<(&'static str, Vec<String>)> {
    let name = REPLACING.into_iter().find(|name| !machine.variable(name).is_empty())?;
    Some((name, paths(machine.variable(name))))
}

fn paths(list: &str) -> Vec<String> {
    list.split(':').filter(|path| !path.is_empty()).map(str::to_owned).collect()
}

/// The folders in which the loader looks for manifests.
fn folders(machine: &Machine) -> Vec<String> {
    let home = machine.variable("HOME");
    let mut folders = Vec::new();
    for (name, default) in [
        ("XDG_CONFIG_HOME", format!("{home}/.config")),
        ("XDG_CONFIG_DIRS", "/etc/xdg".to_owned()),
        ("", "/usr/local/etc:/etc".to_owned()),
        ("XDG_DATA_HOME", format!("{home}/.local/share")),
        ("XDG_DATA_DIRS", "/usr/local/share:/usr/share".to_owned()),
    ] {
        let value = Some(machine.variable(name)).filter(|value| !value.is_empty()).unwrap_or(&default);
        folders.extend(
            paths(value).iter().map(|folder| format!("{}/vulkan/icd.d", folder.trim_end_matches('/'))),
        );
    }
    folders
}

/// A missing loader.
pub(super) fn loader(machine: &Machine) -> Option<Finding> {
    let found = "the Vulkan loader, libvulkan.so.1, is not in the folders of libraries: no GPU can be used";
    (!machine.has_library("libvulkan.so.1")).then(|| Finding::new(found, Package::Loader.install(machine)))
}

/// The absence of any driver where the loader looks by itself.
pub(super) fn none(machine: &Machine) -> Option<Finding> {
    let is_empty = replacing(machine).is_none() && Manifest::all(machine).is_empty();
    let found =
        format!("no Vulkan driver is installed: there is no manifest in {}", folders(machine).join(", "));
    is_empty.then(|| Finding::new(found, "install the Vulkan driver of the card, if there is one"))
}

/// Variables that hide drivers from the loader.
pub(super) fn overridden(machine: &Machine) -> Vec<Finding> {
    let mut findings = Vec::new();
    if let Some((name, paths)) = replacing(machine) {
        for path in paths.iter().filter(|path| !machine.has(path)) {
            let found = format!(
                "{name} names {path}, which does not exist, and hides all drivers that it does not name"
            );
            findings.push(Finding::new(found, format!("unset {name}, or name the manifest of a driver")));
        }
    }
    for name in ["VK_LOADER_DRIVERS_SELECT", "VK_LOADER_DRIVERS_DISABLE"] {
        let value = machine.variable(name);
        if !value.is_empty() {
            let found = format!("{name} is set to {value}, which may hide the driver of a card");
            findings.push(Finding::new(found, format!("unset {name}")));
        }
    }
    findings
}

/// What a card lacks between the kernel and Vulkan.
pub(super) fn lacking(machine: &Machine, card: &Card) -> Vec<Finding> {
    let Some((libraries, package)) = card.vulkan_driver() else { return vec![] };
    let name = card.name();
    let manifests = Manifest::all(machine);
    let mut findings = Vec::new();
    for manifest in manifests.iter().filter(|manifest| manifest.library.is_none()) {
        let found = format!("{} names no library: it is not the manifest of a Vulkan driver", manifest.path);
        findings.push(Finding::new(found, "install the package again that contains the file"));
    }
    let own: Vec<&Manifest> = manifests.iter().filter(|manifest| manifest.drives(libraries)).collect();
    if own.is_empty() {
        let found =
            format!("this machine has {name}, but no manifest (*_icd.json) of a Vulkan driver for it");
        let mut places = folders(machine);
        places.push(format!("{NVIDIA_FOLDER}/share/vulkan/icd.d"));
        let hidden =
            Manifest::in_folders(machine, &places).into_iter().find(|hidden| hidden.drives(libraries));
        findings.push(match hidden {
            Some(Manifest { path, .. }) => Finding::new(
                format!("{found} where the Vulkan loader looks; one is in {path}"),
                format!("set VK_DRIVER_FILES={path}"),
            ),
            None => Finding::new(found, mounted(machine, card, package)),
        });
        return findings;
    }
    let libraries: Vec<&str> = own.iter().filter_map(|manifest| manifest.library.as_deref()).collect();
    let Some(library) = libraries.iter().find(|library| machine.has_library(library)) else {
        let found =
            format!("{} names {}, which is not in the folders of libraries", own[0].path, libraries[0]);
        findings.push(Finding::new(found, linked(machine, card, package, libraries[0])));
        return findings;
    };
    if card.has_nvidia_driver() {
        findings.extend(needed(machine, card, library));
    }
    findings
}

/// How to bring the files of a driver to a machine.
fn mounted(machine: &Machine, card: &Card, package: Package) -> String {
    if card.has_nvidia_driver() && machine.is_container() {
        "start the container with `--env NVIDIA_DRIVER_CAPABILITIES=graphics,compute,utility`, which mounts them from \
         the host"
            .to_owned()
    } else {
        package.install(machine)
    }
}

/// How to bring a library of a driver to where the linker finds it.
fn linked(machine: &Machine, card: &Card, package: Package, library: &str) -> String {
    let places = ["lib64", "lib"].map(|folder| format!("{NVIDIA_FOLDER}/{folder}"));
    match places.iter().find(|folder| machine.has(&format!("{folder}/{library}"))) {
        Some(folder) => format!("set LD_LIBRARY_PATH={folder}, which contains it"),
        None => mounted(machine, card, package),
    }
}

/// The libraries that NVIDIA's driver opens and that are missing.
fn needed(machine: &Machine, card: &Card, library: &str) -> Vec<Finding> {
    let is_glx = library.contains("libGLX");
    let core = if is_glx { "libnvidia-glcore.so." } else { "libnvidia-eglcore.so." };
    let missing = |names: Vec<String>| -> Vec<String> {
        names.into_iter().filter(|name| !machine.has_library(name)).collect()
    };
    let without = |names: Vec<String>, remedy: String| {
        let found = format!("{library} needs {}, which the folders of libraries lack", names.join(" and "));
        Finding::new(found, remedy)
    };
    let mut findings = Vec::new();
    // Without the version of the kernel module the names of the libraries are not known.
    let version = nvidia_version(machine);
    let major: Option<u32> = version.split('.').next().and_then(|major| major.parse().ok());
    let own = major.map_or(vec![], |major| {
        let mut names = vec![core, "libnvidia-tls.so.", "libnvidia-glvkspirv.so."];
        names.extend((major >= SINCE_COMPILER).then_some("libnvidia-gpucomp.so."));
        missing(names.iter().map(|name| format!("{name}{version}")).collect())
    });
    if !own.is_empty() {
        let others = machine.libraries(core);
        findings.push(match others.first().filter(|_| !others.contains(&version)) {
            Some(other) => Finding::new(
                format!(
                    "NVIDIA's kernel module has version {version}, but its libraries have version {other}: they must \
                     agree"
                ),
                "restart the machine after an update of the driver; start a container again",
            ),
            None => without(own, mounted(machine, card, Package::Nvidia)),
        });
    }
    let x11 = missing(["libX11.so.6", "libXext.so.6"].map(str::to_owned).to_vec());
    if is_glx && !x11.is_empty() {
        findings.push(without(x11, Package::X11.install(machine)));
    }
    findings
}
