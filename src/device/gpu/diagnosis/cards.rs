//! The cards of a machine, as its kernel shows them.

use crate::device::gpu::diagnosis::Finding;
use crate::device::gpu::diagnosis::machine::Machine;
use crate::device::gpu::diagnosis::packages::Package;

const NVIDIA: u32 = 0x10de;
const AMD: u32 = 0x1002;
const INTEL: u32 = 0x8086;

/// A card.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Card {
    /// Number of its vendor on the PCI bus; 0 where it is not on that bus.
    vendor: u32,
    /// Its kernel driver; empty where it has none.
    driver: String,
    /// Its render node in `/dev/dri`, where the kernel has one.
    node: Option<String>,
}

/// The cards of a machine, one of each vendor and driver.
pub(super) fn cards(machine: &Machine) -> Vec<Card> {
    let of = |device: &str, node: Option<String>| {
        let vendor = machine.text(&format!("{device}/vendor"));
        let vendor = u32::from_str_radix(vendor.trim().trim_start_matches("0x"), 16).unwrap_or(0);
        Card { vendor, driver: machine.link(&format!("{device}/driver")).unwrap_or_default(), node }
    };
    let nodes = machine.names("/sys/class/drm").into_iter().filter(|name| name.starts_with("renderD"));
    let rendering = nodes.map(|name| of(&format!("/sys/class/drm/{name}/device"), Some(name)));
    let mut cards: Vec<Card> = rendering.collect();
    if machine.has("/dev/nvidiactl") || machine.has("/dev/nvidia0") {
        cards.push(Card { vendor: NVIDIA, driver: "nvidia".to_owned(), node: None });
    }
    // A card without a driver, or one that is not shown to this container. Class 3 is that of displays.
    const BUS: &str = "/sys/bus/pci/devices";
    for address in machine.names(BUS) {
        let device = format!("{BUS}/{address}");
        let card = of(&device, None);
        if machine.text(&format!("{device}/class")).starts_with("0x03") && card.is_known() {
            cards.push(card);
        }
    }
    let mut kinds: Vec<Card> = Vec::new();
    for card in cards {
        let is_same = |known: &Card| known.driver == card.driver || card.node.is_none();
        if !kinds.iter().any(|known| known.vendor == card.vendor && is_same(known)) {
            kinds.push(card);
        }
    }
    kinds
}

impl Card {
    /// Whether its vendor is known.
    pub(super) fn is_known(&self) -> bool {
        [NVIDIA, AMD, INTEL].contains(&self.vendor)
    }

    /// Whether it is one of NVIDIA's with NVIDIA's own kernel driver.
    pub(super) fn has_nvidia_driver(&self) -> bool {
        self.vendor == NVIDIA && self.driver == "nvidia"
    }

    /// Whether there is an adapter for it, given the vendors of all adapters.
    pub(super) fn is_among(&self, vendors: &[u32]) -> bool {
        // A card that is not on the PCI bus has another number in Vulkan.
        if self.is_known() { vendors.contains(&self.vendor) } else { !vendors.is_empty() }
    }

    /// Its name in messages.
    pub(super) fn name(&self) -> String {
        match self.vendor {
            NVIDIA => "an NVIDIA card".to_owned(),
            AMD => "an AMD card".to_owned(),
            INTEL => "an Intel card".to_owned(),
            _ => format!("a card with the kernel driver {}", self.driver),
        }
    }

    /// Parts of the names of libraries that drive it in Vulkan, with the package of the usual one.
    pub(super) fn vulkan_driver(&self) -> Option<(&'static [&'static str], Package)> {
        match (self.vendor, self.driver.as_str()) {
            (NVIDIA, "nouveau") => Some((&["nouveau"], Package::Nouveau)),
            (NVIDIA, _) => Some((&["nvidia"], Package::Nvidia)),
            (AMD, _) => Some((&["radeon", "amdvlk"], Package::Amd)),
            (INTEL, _) => Some((&["intel"], Package::Intel)),
            _ => None,
        }
    }

    /// The nodes that its driver opens.
    fn nodes(&self, machine: &Machine) -> Vec<String> {
        if !self.has_nvidia_driver() {
            return self.node.iter().map(|node| format!("/dev/dri/{node}")).collect();
        }
        // A container may have any of several cards.
        let is_card =
            |name: &String| name.strip_prefix("nvidia").is_some_and(|rest| rest.parse::<u32>().is_ok());
        let card = machine.names("/dev").into_iter().find(is_card).unwrap_or_else(|| "nvidia0".to_owned());
        vec!["/dev/nvidiactl".to_owned(), format!("/dev/{card}")]
    }

    /// Why the kernel does not let this process use the card.
    pub(super) fn refused(&self, machine: &Machine) -> Vec<Finding> {
        let name = self.name();
        if ["", "vfio-pci"].contains(&self.driver.as_str()) {
            return vec![Finding::new(
                format!("this machine has {name} on the PCI bus, but no kernel driver for it is loaded"),
                "install its driver and restart the machine; in a virtual machine or a container, do so on the host",
            )];
        }
        self.nodes(machine).iter().filter_map(|node| self.refused_at(node, machine)).collect()
    }

    fn refused_at(&self, node: &str, machine: &Machine) -> Option<Finding> {
        let (name, driver) = (self.name(), &self.driver);
        if !machine.has(node) {
            let remedy = match (machine.is_container(), self.has_nvidia_driver()) {
                (true, true) => "start the container with `--gpus all`, or give its pod a GPU",
                (true, false) => "start the container with `--device /dev/dri`",
                (false, true) => "run `sudo nvidia-modprobe -c 0 -u`, or restart the machine",
                (false, false) => "restart the machine",
            };
            let found =
                format!("this machine has {name} (kernel driver {driver}), but {node} does not exist here");
            return Some(Finding::new(found, remedy));
        }
        if (machine.may_open)(&machine.path(node)) {
            return None;
        }
        let group = machine.group(node).unwrap_or_default();
        let found = format!("{node} belongs to {name}, but this user may not open it: its group is {group}");
        let remedy = if machine.is_container() {
            format!("start the container with `--group-add` and the number of the group {group} of the host")
        } else {
            format!("run `sudo usermod --append --groups {group} $USER`, then log out and in again")
        };
        Some(Finding::new(found, remedy))
    }
}
