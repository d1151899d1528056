use super::*;

#[test]
fn auto_takes_the_cpu_for_a_gpu_that_cannot_be_trusted_and_says_why() {
    let untrusted = SelectError::Untrusted { name: "Some GPU".to_owned(), kernel: "sine" };
    let machine = Machine { adapters: LazyCell::new(Vec::new), threads: 0, self_test: None };
    let lost = || SelectError::Gpu { name: "Another GPU".to_owned(), source: GpuError::OutOfMemory };
    let gpus = [Err(untrusted), Err(lost())];
    let Selection { device, reason, left_out } = machine.first_of(gpus.into_iter()).unwrap();
    assert!(matches!(device, Device::Cpu(_)), "{}", device.name());
    assert!(reason.contains("Some GPU computes other bits than the CPU in sine"), "{reason}");
    assert!(!reason.contains('\n'), "{reason:?}");
    assert!(left_out.len() == 1 && left_out[0].starts_with("Another GPU cannot be used"), "{left_out:?}");

    let second = machine.first_of([Err(lost()), machine.cpu()].into_iter()).unwrap();
    assert_eq!(second.reason, "a GPU that passed its self-test", "the next is tried");
    assert_eq!(second.left_out, left_out);
}

#[test]
fn widths_are_found_however_they_are_spelled() {
    let machine = Machine { adapters: LazyCell::new(Vec::new), threads: 0, self_test: None };
    for width in Width::available() {
        let name = width.name();
        for spelling in
            [name.to_uppercase(), name.to_lowercase(), name.replace('-', ""), name.replace('-', "_")]
        {
            let found = machine.choice(&spelling);
            assert!(matches!(found, Ok(Choice::Cpu(found)) if found == width), "{spelling}");
        }
    }
    assert!(machine.select("CPU").is_ok() && machine.select("Auto").is_ok());
    assert!(matches!(machine.select("cpu, ALL"), Err(SelectError::Alone { .. })));
    assert!(matches!(machine.choice("-"), Err(SelectError::Unknown { .. })));
}

#[test]
fn equal_adapters_are_told_apart_by_their_pci_address() {
    let name = "NVIDIA L4 (Vulkan)";
    let meant = |wanted: &str| {
        ["0000:3b:00.0", "0000:af:00.0", ""].map(|pci_address| means(wanted, name, pci_address))
    };
    assert_eq!(meant("nvidia l4"), [true, true, true]);
    assert_eq!(meant("0000:AF:00.0"), [false, true, false], "as nvidia-smi writes it");
    assert_eq!(meant("00.0"), [false; 3], "a part of an address means none");
    assert_eq!(meant(" "), [false; 3]);
    assert_eq!(meant(""), [false; 3]);
}
