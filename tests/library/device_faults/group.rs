//! Groups whose members fail: the others do their part, with the same bits.

use sagnac::device::gpu::adapter::Fault;
use sagnac::device::{Cpu, Device};
use sagnac::study::Study;
use sagnac_kernel::width::Width;

use super::case::{AGAIN, SMALLER, Subject};
use super::left::{Left, run};
use super::script::{Script, Seen, scripted};
use super::{gaps, records, runs};
use crate::devices::{Coverage, adapters};

const ALONE: &str = "the other devices continue without it";
const REPLACED: &str = "from here on CPU";

/// A fault at the third tile, and what follows it.
fn from_third_tile(fault: Fault, mut then: impl FnMut(Seen) -> Option<Fault> + Send + 'static) -> Script {
    let mut tiles = 0;
    Box::new(move |seen| {
        tiles += u32::from(seen.tile.is_some());
        match tiles {
            0..3 => None,
            3 if seen.tile.is_some() => Some(fault),
            _ => then(seen),
        }
    })
}

/// Lost, and not to be had again.
fn gone() -> Script {
    from_third_tile(Fault::LostAfter, |seen| seen.tile.is_none().then_some(Fault::LostAfter))
}

/// Lost, and computing other bits after that.
fn wrong() -> Script {
    from_third_tile(Fault::LostAfter, |seen| seen.tile.is_some().then_some(Fault::WrongBits))
}

fn cpu() -> Device {
    Device::Cpu(Cpu::new(Width::widest(), 1).unwrap())
}

/// A group with the devices of `scripts`, and the processor if `has_cpu`, gives what the processor does alone, says what is
/// expected, and ends with so many members.
fn survives(study: &Study, alone: &Left, scripts: Vec<Script>, has_cpu: bool, said: &[&str], members: usize) {
    let adapter = adapters().remove(0);
    let (gpus, seen): (Vec<_>, Vec<_>) = scripts
        .into_iter()
        .map(|script| {
            let (faults, seen) = scripted(script);
            (Subject::device(&adapter, faults), seen)
        })
        .unzip();
    let mut device = gpus.into_iter().chain(has_cpu.then(cpu)).reduce(Device::and).unwrap();
    let names = device.name();
    let left = run(study, &mut device);
    for seen in seen {
        assert!(seen.lock().unwrap().taken >= 1, "{said:?}: no fault");
    }
    let notes = &left.done.degraded;
    assert_eq!(notes.len(), said.len(), "{notes:#?}");
    for said in said {
        assert!(notes.iter().any(|note| note.contains(said)), "{said}: {notes:#?}");
    }
    assert!(left.devices.iter().all(|device| device.contains(&names)), "{:?}", left.devices);
    assert_eq!(left.rows, alone.rows, "{said:?}");
    assert_eq!(left.tables, alone.tables, "{said:?}");
    assert_eq!(left.done.trials, alone.done.trials, "{said:?}");
    assert_eq!(device.into_devices().len(), members, "{said:?}");
}

#[test]
fn every_study_is_the_same_whatever_happens_to_members_of_a_group() {
    let mut coverage = Coverage::start();
    for study in [gaps(), runs(), records()] {
        let alone = run(&study, &mut cpu());
        let mut survives = |scripts, has_cpu, said: &[&str], members| {
            survives(&study, &alone, scripts, has_cpu, said, members);
            coverage.comparisons += 1;
        };
        let gone_said = format!("cannot open the device: LostAfter, requested by a test; {ALONE}");
        let once = |fault| from_third_tile(fault, |_| None);
        survives(vec![gone()], true, &[&gone_said], 1);
        let wrong_said =
            format!("in philox: it is not used; update its driver, or use `device = cpu`; {ALONE}");
        survives(vec![wrong()], true, &[&wrong_said], 1);
        survives(vec![once(Fault::LostAfter)], true, &[AGAIN], 2);
        survives(vec![once(Fault::OutOfMemory)], true, &[SMALLER], 2);
        survives(vec![gone(), gone()], false, &[&gone_said, REPLACED], 1);
    }
    coverage.end("groups whose members fail");
}
