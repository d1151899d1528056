//! Cards of this machine that Vulkan does not offer.

use std::fs;
use std::path::Path;

use crate::device::gpu::adapter::Adapter;

/// The vendors of GPUs by their numbers on the PCI bus.
const VENDORS: [(u32, &str); 3] =
    [(0x10de, "an NVIDIA card"), (0x1002, "an AMD card"), (0x8086, "an Intel card")];

/// In one line: a card that the kernel of this machine shows, and that is of another vendor than all GPUs among these adapters.
pub fn unused_card(adapters: &[Adapter]) -> Option<String> {
    let real = adapters.iter().filter(|adapter| !adapter.is_software());
    unused(Path::new("/"), &real.map(Adapter::vendor).collect::<Vec<_>>())
}

/// The line for the machine whose files are in the folder `root`, given the vendors of the GPUs that Vulkan offers.
fn unused(root: &Path, offered: &[u32]) -> Option<String> {
    let vendors = |folder: &str, file: &str| -> Vec<u32> {
        let entries = fs::read_dir(root.join(folder)).into_iter().flatten().flatten();
        let number = |text: String| u32::from_str_radix(text.trim().trim_start_matches("0x"), 16).ok();
        entries.filter_map(|entry| number(fs::read_to_string(entry.path().join(file)).ok()?)).collect()
    };
    // A container may hide the bus of a card whose driver it has.
    let nvidia = root.join("dev/nvidia0").exists().then_some(VENDORS[0].0);
    let present: Vec<u32> = vendors("sys/class/drm", "device/vendor").into_iter().chain(nvidia).collect();
    let (_, name) =
        VENDORS.iter().find(|(vendor, _)| present.contains(vendor) && !offered.contains(vendor))?;
    Some(format!(
        "this machine has {name}, but Vulkan does not offer it (see \"A GPU that is not used\" in docs/reference/exit-codes.md)"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_card_without_an_adapter_is_named() {
        let machine = tempfile::tempdir().unwrap();
        let device = machine.path().join("sys/class/drm/renderD128/device");
        fs::create_dir_all(&device).unwrap();
        fs::write(device.join("vendor"), "0x1002\n").unwrap();
        assert!(unused(machine.path(), &[]).unwrap().starts_with("this machine has an AMD card"));
        assert_eq!(unused(machine.path(), &[0x1002]), None);
        fs::create_dir(machine.path().join("dev")).unwrap();
        fs::write(machine.path().join("dev/nvidia0"), "").unwrap();
        assert!(unused(machine.path(), &[0x1002]).unwrap().starts_with("this machine has an NVIDIA card"));
        assert_eq!(unused(&machine.path().join("empty"), &[]), None);
    }
}
