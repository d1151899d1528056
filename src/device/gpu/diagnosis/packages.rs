//! What to install, by distribution.

use crate::device::gpu::diagnosis::machine::Machine;

/// Something that a machine may lack.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Package {
    Loader,
    Amd,
    Intel,
    Nouveau,
    Nvidia,
    X11,
}

/// A distribution with the command that installs, and its packages in the order of [`Package`].
struct Distribution {
    id: &'static str,
    install: &'static str,
    packages: [&'static str; 6],
}

const MESA: &str = "mesa-vulkan-drivers";

/// A derived distribution comes before the one from which it is derived. `{}` is the major version of NVIDIA's driver.
const DISTRIBUTIONS: [Distribution; 7] = [
    Distribution {
        id: "ubuntu",
        install: "apt-get install",
        packages: ["libvulkan1", MESA, MESA, MESA, "libnvidia-gl-{}", "libx11-6 libxext6"],
    },
    Distribution {
        id: "debian",
        install: "apt-get install",
        packages: ["libvulkan1", MESA, MESA, MESA, "nvidia-vulkan-icd", "libx11-6 libxext6"],
    },
    Distribution {
        id: "fedora",
        install: "dnf install",
        packages: ["vulkan-loader", MESA, MESA, MESA, "xorg-x11-drv-nvidia-libs", "libX11 libXext"],
    },
    Distribution {
        id: "rhel",
        install: "dnf install",
        packages: ["vulkan-loader", MESA, MESA, MESA, "nvidia-driver-libs", "libX11 libXext"],
    },
    Distribution {
        id: "arch",
        install: "pacman -S",
        packages: [
            "vulkan-icd-loader",
            "vulkan-radeon",
            "vulkan-intel",
            "vulkan-nouveau",
            "nvidia-utils",
            "libx11 libxext",
        ],
    },
    Distribution {
        id: "suse",
        install: "zypper install",
        packages: [
            "libvulkan1",
            "libvulkan_radeon",
            "libvulkan_intel",
            "libvulkan_nouveau",
            "nvidia-gl-G06",
            "libX11-6 libXext6",
        ],
    },
    Distribution {
        id: "alpine",
        install: "apk add",
        packages: ["vulkan-loader", "mesa-vulkan-ati", "mesa-vulkan-intel", "", "", "libx11 libxext"],
    },
];

impl Package {
    /// How to install it on a machine.
    pub(super) fn install(self, machine: &Machine) -> String {
        let release = machine.text("/etc/os-release");
        let value = |key: &str| {
            let value = release.lines().find_map(|line| line.strip_prefix(key));
            value.unwrap_or_default().replace('"', "")
        };
        let ids = format!("{} {}", value("ID="), value("ID_LIKE="));
        let is_own = |known: &&Distribution| ids.split_whitespace().any(|id| id == known.id);
        let name = DISTRIBUTIONS.iter().find(is_own).map(|own| (own, own.packages[self as usize]));
        match name {
            Some((own, name)) if !name.is_empty() => {
                let version = nvidia_version(machine);
                let major = version.split('.').next().filter(|major| !major.is_empty()).unwrap_or("VERSION");
                format!("run `sudo {} {}`", own.install, name.replace("{}", major))
            }
            _ => format!("install {}", self.meaning()),
        }
    }

    fn meaning(self) -> &'static str {
        match self {
            Package::Loader => "the Vulkan loader (libvulkan.so.1)",
            Package::Amd => "Mesa's Vulkan driver for AMD (RADV)",
            Package::Intel => "Mesa's Vulkan driver for Intel (ANV)",
            Package::Nouveau => "Mesa's Vulkan driver for NVIDIA (NVK)",
            Package::Nvidia => "NVIDIA's driver with its libraries for graphics",
            Package::X11 => "libX11 and libXext",
        }
    }
}

/// The version of NVIDIA's kernel module; empty where it is not loaded.
pub(super) fn nvidia_version(machine: &Machine) -> String {
    let text = machine.text("/proc/driver/nvidia/version");
    let is_version = |word: &&str| word.contains('.') && word.starts_with(|c: char| c.is_ascii_digit());
    text.split_whitespace().find(is_version).unwrap_or_default().to_owned()
}
