//! Machines laid out in a folder, and what the diagnosis finds there.

use std::os::unix::fs::{MetadataExt, symlink};

use super::*;

const NVIDIA: u32 = 0x10de;
const ICD: &str = "/usr/share/vulkan/icd.d";
const LIB: &str = "/usr/lib";

/// A machine in a folder, which is removed with it.
struct Laid {
    machine: Machine,
    _folder: tempfile::TempDir,
}

impl Laid {
    /// With some files and their contents.
    fn out(files: &[(&str, &str)]) -> Laid {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path().to_owned();
        let machine = Machine { root, variables: [].into(), may_open: |_| true };
        let laid = Laid { machine, _folder: folder };
        files.iter().for_each(|(path, text)| laid.add(path, text));
        laid
    }

    fn add(&self, path: &str, text: &str) {
        let path = self.machine.path(path);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }

    fn remove(&self, path: &str) {
        std::fs::remove_file(self.machine.path(path)).unwrap();
    }

    fn set(&mut self, name: &str, value: &str) {
        self.machine.variables.insert(name.to_owned(), value.to_owned());
    }

    /// A card with a render node, as its kernel driver shows it.
    fn add_card(&self, node: &str, vendor: &str, driver: &str) {
        self.add(&format!("/sys/class/drm/{node}/device/vendor"), &format!("{vendor}\n"));
        let link = self.machine.path(&format!("/sys/class/drm/{node}/device/driver"));
        symlink(format!("../../../../bus/pci/drivers/{driver}"), link).unwrap();
    }

    /// All findings where there is no adapter, or only one of a software rasterizer.
    fn findings(&self, no_adapters: bool) -> Vec<(String, String)> {
        let findings = lacking(&self.machine, &[], no_adapters);
        findings.into_iter().map(|Finding { found, remedy }| (found, remedy)).collect()
    }

    /// The only finding.
    fn finding(&self, no_adapters: bool) -> (String, String) {
        let mut findings = self.findings(no_adapters);
        assert_eq!(findings.len(), 1, "{findings:#?}");
        findings.remove(0)
    }
}

fn pair(found: &str, remedy: &str) -> (String, String) {
    (found.to_owned(), remedy.to_owned())
}

fn manifest(library: &str) -> String {
    format!(
        r#"{{"file_format_version": "1.0.0", "ICD": {{"library_path": "{library}", "api_version": "1.3.242"}}}}"#
    )
}

const MODULE: &str =
    "NVRM version: NVIDIA UNIX x86_64 Kernel Module  550.54.14  Thu Feb 22 01:44:30 UTC 2024\n";

/// A container with an NVIDIA card and all that Vulkan needs for it.
fn container() -> Laid {
    let mut laid = Laid::out(&[
        ("/dev/nvidiactl", ""),
        ("/dev/nvidia3", ""),
        ("/proc/driver/nvidia/version", MODULE),
        ("/etc/os-release", "PRETTY_NAME=\"Ubuntu 22.04\"\nID=ubuntu\nID_LIKE=debian\n"),
        ("/usr/lib/libvulkan.so.1", ""),
        ("/usr/share/vulkan/icd.d/nvidia_icd.json", &manifest("libGLX_nvidia.so.0")),
    ]);
    for library in ["libGLX_nvidia.so.0", "libX11.so.6", "libXext.so.6"] {
        laid.add(&format!("{LIB}/{library}"), "");
    }
    for library in ["glcore", "tls", "glvkspirv", "gpucomp"] {
        laid.add(&format!("{LIB}/libnvidia-{library}.so.550.54.14"), "");
    }
    laid.set("NVIDIA_VISIBLE_DEVICES", "all");
    laid
}

/// A workstation with an AMD card and all that Vulkan needs for it.
fn workstation() -> Laid {
    let laid = Laid::out(&[
        ("/dev/dri/renderD128", ""),
        ("/etc/os-release", "ID=fedora\n"),
        ("/usr/lib64/libvulkan.so.1", ""),
        ("/usr/lib64/libvulkan_radeon.so", ""),
        ("/usr/share/vulkan/icd.d/radeon_icd.x86_64.json", &manifest("/usr/lib64/libvulkan_radeon.so")),
    ]);
    laid.add_card("renderD128", "0x1002", "amdgpu");
    laid
}

const GRAPHICS: &str = "start the container with `--env NVIDIA_DRIVER_CAPABILITIES=graphics,compute,utility`, which \
                        mounts them from the host";

#[test]
fn a_machine_whose_cards_all_have_adapters_lacks_nothing() {
    assert_eq!(lacking(&container().machine, &[NVIDIA], false), []);
    assert_eq!(lacking(&workstation().machine, &[0x1002], false), []);
}

#[test]
fn a_card_that_lacks_nothing_and_has_no_adapter_is_left_to_the_loader() {
    for (laid, card) in [(container(), "an NVIDIA card"), (workstation(), "an AMD card")] {
        let (found, remedy) = laid.finding(true);
        let expected = format!(
            "this machine has {card}, but Vulkan does not offer it, although its driver is installed"
        );
        assert_eq!(found, expected);
        assert!(remedy.contains("VK_LOADER_DEBUG=error,warn,driver"), "{remedy}");
    }
}

#[test]
fn a_machine_without_cards_is_told_so_with_what_else_is_missing() {
    let laid = Laid::out(&[("/etc/os-release", "ID=debian\n")]);
    let findings = laid.findings(true);
    let found: Vec<&str> = findings.iter().map(|(found, _)| found.as_str()).collect();
    assert!(found[0].starts_with("no GPU was found: there is neither /dev/nvidia0 nor"), "{found:?}");
    assert_eq!(
        findings[1],
        pair(
            "the Vulkan loader, libvulkan.so.1, is not in the folders of libraries: no GPU can be used",
            "run `sudo apt-get install libvulkan1`"
        )
    );
    assert!(found[2].starts_with("no Vulkan driver is installed: there is no manifest in"), "{found:?}");
    assert!(found[2].contains("/etc/vulkan/icd.d") && found[2].contains(ICD), "{found:?}");
    assert_eq!(found.len(), 3, "{found:?}");
    // With a software rasterizer the loader and a driver are there.
    assert!(laid.finding(false).0.starts_with("no GPU was found"));
}

#[test]
fn a_container_without_the_manifest_is_told_to_ask_for_graphics() {
    let laid = container();
    laid.remove("/usr/share/vulkan/icd.d/nvidia_icd.json");
    let found = "this machine has an NVIDIA card, but no manifest (*_icd.json) of a Vulkan driver for it";
    assert_eq!(laid.finding(true), pair(found, GRAPHICS));
    // The same outside of a container.
    let mut laid = laid;
    laid.machine.variables.clear();
    assert_eq!(laid.finding(true), pair(found, "run `sudo apt-get install libnvidia-gl-550`"));
    let path = "/usr/local/nvidia/share/vulkan/icd.d/nvidia_icd.json";
    laid.add(path, &manifest("libGLX_nvidia.so.0"));
    let elsewhere = format!("{found} where the Vulkan loader looks; one is in {path}");
    assert_eq!(laid.finding(true), pair(&elsewhere, &format!("set VK_DRIVER_FILES={path}")));
    laid.set("VK_DRIVER_FILES", path);
    assert!(laid.finding(true).0.ends_with("although its driver is installed"));
}

#[test]
fn a_library_that_a_manifest_names_in_vain_is_named() {
    let mut laid = container();
    laid.remove("/usr/lib/libGLX_nvidia.so.0");
    let found =
        format!("{ICD}/nvidia_icd.json names libGLX_nvidia.so.0, which is not in the folders of libraries");
    assert_eq!(laid.finding(true), pair(&found, GRAPHICS));
    laid.add("/usr/local/nvidia/lib64/libGLX_nvidia.so.0", "");
    assert_eq!(laid.finding(true).1, "set LD_LIBRARY_PATH=/usr/local/nvidia/lib64, which contains it");
    laid.set("LD_LIBRARY_PATH", "/opt/lib:/usr/local/nvidia/lib64");
    assert!(laid.finding(true).0.ends_with("although its driver is installed"));
    laid.set("LD_LIBRARY_PATH", "");
    laid.add("/etc/ld.so.conf.d/nvidia.conf", "# of the host\n/usr/local/nvidia/lib64\n");
    assert!(laid.finding(true).0.ends_with("although its driver is installed"));

    let laid = workstation();
    laid.remove("/usr/lib64/libvulkan_radeon.so");
    let (found, remedy) = laid.finding(true);
    assert!(
        found.ends_with("names /usr/lib64/libvulkan_radeon.so, which is not in the folders of libraries")
    );
    assert_eq!(remedy, "run `sudo dnf install mesa-vulkan-drivers`");
}

#[test]
fn a_library_is_sought_beside_a_manifest_that_names_it_by_a_relative_path() {
    let laid = workstation();
    laid.add(&format!("{ICD}/radeon_icd.x86_64.json"), &manifest("../../../lib/libvulkan_radeon.so"));
    let library = format!("{ICD}/../../../lib/libvulkan_radeon.so");
    assert!(laid.finding(true).0.contains(&format!("names {library}, which is not")));
    laid.add("/usr/lib/libvulkan_radeon.so", "");
    assert!(laid.finding(true).0.ends_with("although its driver is installed"));
}

#[test]
fn each_library_that_the_nvidia_driver_opens_is_missed() {
    for library in ["glcore", "tls", "glvkspirv", "gpucomp"] {
        let laid = container();
        let name = format!("libnvidia-{library}.so.550.54.14");
        laid.remove(&format!("{LIB}/{name}"));
        let found = format!("libGLX_nvidia.so.0 needs {name}, which the folders of libraries lack");
        assert_eq!(laid.finding(true), pair(&found, GRAPHICS));
    }
    let laid = container();
    laid.remove("/usr/lib/libX11.so.6");
    laid.remove("/usr/lib/libXext.so.6");
    let found = "libGLX_nvidia.so.0 needs libX11.so.6 and libXext.so.6, which the folders of libraries lack";
    assert_eq!(laid.finding(true), pair(found, "run `sudo apt-get install libx11-6 libxext6`"));
    // An older driver has its shader compiler inside, and one without X needs no library of X.
    laid.add("/proc/driver/nvidia/version", &MODULE.replace("550.54.14", "535.104.05"));
    laid.add(&format!("{ICD}/nvidia_icd.json"), &manifest("libEGL_nvidia.so.0"));
    laid.add("/usr/lib/libEGL_nvidia.so.0", "");
    for library in ["eglcore", "tls", "glvkspirv"] {
        laid.add(&format!("{LIB}/libnvidia-{library}.so.535.104.05"), "");
    }
    assert!(laid.finding(true).0.ends_with("although its driver is installed"));
}

#[test]
fn libraries_of_another_version_than_the_kernel_module_are_named() {
    let laid = container();
    laid.add("/proc/driver/nvidia/version", &MODULE.replace("550.54.14", "570.86.15"));
    let (found, remedy) = laid.finding(true);
    assert_eq!(
        found,
        "NVIDIA's kernel module has version 570.86.15, but its libraries have version 550.54.14: they must agree"
    );
    assert!(remedy.starts_with("restart the machine"), "{remedy}");
}

#[test]
fn a_node_that_this_user_may_not_open_is_named_with_its_group() {
    let mut laid = workstation();
    laid.machine.may_open = |path| !path.ends_with("dev/dri/renderD128");
    let group = laid.machine.path("/dev/dri/renderD128").metadata().unwrap().gid();
    let refused = |group: &str| {
        pair(
            &format!(
                "/dev/dri/renderD128 belongs to an AMD card, but this user may not open it: its group is {group}"
            ),
            &format!("run `sudo usermod --append --groups {group} $USER`, then log out and in again"),
        )
    };
    assert_eq!(laid.finding(true), refused(&group.to_string()));
    laid.add("/etc/group", &format!("video:x:{}:\nrender:x:{group}:somebody\n", group + 1));
    assert_eq!(laid.finding(true), refused("render"));
    laid.add("/.dockerenv", "");
    assert!(laid.finding(true).1.contains("--group-add"));
}

#[test]
fn a_card_whose_driver_is_not_installed_leads_to_its_package() {
    let packages = [
        ("debian", "0x1002", "amdgpu", "an AMD card", "run `sudo apt-get install mesa-vulkan-drivers`"),
        ("arch", "0x8086", "i915", "an Intel card", "run `sudo pacman -S vulkan-intel`"),
        ("alpine", "0x1002", "radeon", "an AMD card", "run `sudo apk add mesa-vulkan-ati`"),
        ("plan9", "0x8086", "xe", "an Intel card", "install Mesa's Vulkan driver for Intel (ANV)"),
        ("fedora", "0x10de", "nouveau", "an NVIDIA card", "run `sudo dnf install mesa-vulkan-drivers`"),
    ];
    for (distribution, vendor, driver, card, remedy) in packages {
        let laid = Laid::out(&[
            ("/dev/dri/renderD129", ""),
            ("/etc/os-release", &format!("ID={distribution}\n")),
            ("/usr/lib/libvulkan.so.1", ""),
            ("/usr/share/vulkan/icd.d/lvp_icd.x86_64.json", &manifest("libvulkan_lvp.so")),
        ]);
        laid.add_card("renderD129", vendor, driver);
        let found =
            format!("this machine has {card}, but no manifest (*_icd.json) of a Vulkan driver for it");
        assert_eq!(laid.finding(false), pair(&found, remedy), "{distribution}");
    }
}

#[test]
fn a_card_that_is_not_shown_to_a_container_or_has_no_driver_is_seen_on_the_bus() {
    let laid = Laid::out(&[
        ("/.dockerenv", ""),
        ("/sys/bus/pci/devices/0000:3b:00.0/vendor", "0x10de\n"),
        ("/sys/bus/pci/devices/0000:3b:00.0/class", "0x030200\n"),
        ("/sys/bus/pci/devices/0000:00:1f.0/vendor", "0x8086\n"),
        ("/sys/bus/pci/devices/0000:00:1f.0/class", "0x060100\n"),
    ]);
    let (found, _) = laid.findings(false).remove(0);
    assert_eq!(
        found,
        "this machine has an NVIDIA card on the PCI bus, but no kernel driver for it is loaded"
    );
    let link = laid.machine.path("/sys/bus/pci/devices/0000:3b:00.0/driver");
    symlink("../../../bus/pci/drivers/nvidia", link).unwrap();
    let found = laid.findings(false);
    for (place, node) in ["/dev/nvidiactl", "/dev/nvidia0"].into_iter().enumerate() {
        let expected =
            format!("this machine has an NVIDIA card (kernel driver nvidia), but {node} does not exist here");
        assert_eq!(
            found[place],
            pair(&expected, "start the container with `--gpus all`, or give its pod a GPU")
        );
    }
}

#[test]
fn variables_that_hide_drivers_are_named() {
    for name in ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"] {
        let mut laid = workstation();
        laid.set(name, "/opt/gone.json");
        let findings = laid.findings(true);
        let found = format!(
            "{name} names /opt/gone.json, which does not exist, and hides all drivers that it does not name"
        );
        assert_eq!(findings[0], pair(&found, &format!("unset {name}, or name the manifest of a driver")));
        assert_eq!(findings[1].1, format!("set VK_DRIVER_FILES={ICD}/radeon_icd.x86_64.json"));
        assert_eq!(findings.len(), 2, "{findings:#?}");
        // The loader takes folders too.
        laid.set(name, ICD);
        assert!(laid.finding(true).0.ends_with("although its driver is installed"));
    }
    let mut laid = workstation();
    laid.set("VK_LOADER_DRIVERS_DISABLE", "*radeon*");
    assert_eq!(
        laid.finding(true),
        pair(
            "VK_LOADER_DRIVERS_DISABLE is set to *radeon*, which may hide the driver of a card",
            "unset VK_LOADER_DRIVERS_DISABLE"
        )
    );
}

#[test]
fn a_file_that_is_no_manifest_is_named() {
    let laid = workstation();
    laid.add(&format!("{ICD}/broken.json"), "{");
    let (found, _) = laid.finding(true);
    assert_eq!(
        found,
        format!("{ICD}/broken.json names no library: it is not the manifest of a Vulkan driver")
    );
}

#[test]
fn a_card_that_is_not_used_is_told_in_one_line_and_a_virtual_one_is_not() {
    let said = |card: &str| {
        Some(format!(
            "this machine has {card}, but Vulkan does not offer it (`sagnac device list --why` explains)"
        ))
    };
    assert_eq!(unused(&container().machine, &[]), said("an NVIDIA card"));
    assert_eq!(unused(&workstation().machine, &[]), said("an AMD card"));
    let laid = Laid::out(&[("/dev/dri/renderD128", "")]);
    laid.add_card("renderD128", "0x1af4", "virtio-pci");
    assert_eq!(unused(&laid.machine, &[]), None);
    let (found, _) = laid.finding(false);
    assert!(found.starts_with("this machine has a card with the kernel driver virtio-pci, but"), "{found}");
}
