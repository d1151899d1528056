//! A study on a device that fails in some way, against the same study on the processor.

use std::sync::{Arc, Mutex};

use sagnac::device::gpu::adapter::{Adapter, Fault, Faults, Moment};
use sagnac::device::{Cpu, Device};
use sagnac::study::Study;
use sagnac_kernel::width::Width;

use super::left::{Left, run};
use super::script::{Place, Script, Seen, scripted};
use crate::devices::{adapters, open};

/// What is done to a device, and what is said of it then.
pub struct Case {
    pub name: String,
    pub script: Script,
    /// How often it fails at least.
    pub faults: usize,
    pub said: Vec<&'static str>,
    /// Whether the processor ends the run.
    pub on_cpu: bool,
}

pub const SMALLER: &str = "is out of memory: it continues with smaller tiles";
pub const AGAIN: &str = "was lost: Destroyed; it was opened again, passed its self-test and continues";

/// A study with what an undisturbed run leaves.
pub struct Subject {
    study: Study,
    adapter: Adapter,
    /// On the processor.
    reference: Left,
    /// Of all tiles together.
    pub work: u64,
    pub first_tile: u64,
}

impl Subject {
    pub fn new(study: Study) -> Subject {
        // The number of tiles of a study is that of a software rasterizer, where there is one.
        let mut adapters = adapters();
        let software = adapters.iter().position(|adapter| adapter.is_software());
        let adapter = adapters.remove(software.unwrap_or(0));
        let reference = run(&study, &mut Device::Cpu(Cpu::new(Width::widest(), 0).unwrap()));
        let tiles = Arc::new(Mutex::new(Vec::new()));
        let kept = Arc::clone(&tiles);
        let (faults, _) = scripted(Box::new(move |seen| {
            kept.lock().unwrap().extend(seen.tile);
            None
        }));
        let left = run(&study, &mut Subject::device(&adapter, faults));
        assert_eq!(left.rows, reference.rows, "without any fault");
        let tiles = tiles.lock().unwrap();
        assert!(tiles.len() >= 6, "{tiles:?} are too few tiles to have a middle");
        Subject { study, adapter, reference, work: tiles.iter().sum(), first_tile: tiles[0] }
    }

    pub fn device(adapter: &Adapter, faults: Faults) -> Device {
        let mut gpu = open(adapter, adapter.variant());
        gpu.set_tile(1 << 15);
        gpu.inject(faults);
        Device::Gpu(Box::new(gpu.with_self_test(sagnac::verify::SELF_TEST)))
    }

    pub fn survives(&self, case: Case) {
        let Case { name, script, faults: fewest, said, on_cpu } = case;
        let (faults, seen) = scripted(script);
        let mut device = Subject::device(&self.adapter, faults);
        self.runs_on(&mut device, &name, &said, on_cpu);
        let seen = *seen.lock().unwrap();
        assert!(seen.taken >= fewest, "{name}: {} faults", seen.taken);
    }

    /// The driver never finishes compiling a shader, and the processor does the run.
    pub fn survives_a_stuck_driver(&self) {
        let faults = |moment| (moment == Moment::Pipeline).then_some(Fault::Stuck);
        let mut device = Subject::device(&self.adapter, Arc::new(faults));
        let said = ["its driver did not compile a shader within 5 minutes; from here on CPU"];
        self.runs_on(&mut device, "stuck", &said, true);
    }

    fn runs_on(&self, device: &mut Device, name: &str, said: &[&str], on_cpu: bool) {
        let left = run(&self.study, device);
        let notes = &left.done.degraded;
        assert_eq!(notes.len(), said.len(), "{name}: {notes:#?}");
        for (note, said) in notes.iter().zip(said) {
            assert!(note.contains(said), "{name}: {note}");
            assert!(note.contains(&self.adapter.name()), "{name}: {note}");
        }
        assert_eq!(matches!(device, Device::Cpu(_)), on_cpu, "{name}: {}", device.name());
        for named in &left.devices {
            assert!(named.contains(&self.adapter.name()), "{name}: {named}");
            assert_eq!(named.contains("and CPU"), on_cpu, "{name}: {named}");
        }
        assert_eq!(left.rows, self.reference.rows, "{name}");
        assert_eq!(left.tables, self.reference.tables, "{name}");
        assert_eq!(left.done.trials, self.reference.done.trials, "{name}");
    }

    /// This fault alone.
    pub fn once(&self, place: Place, fault: Fault, said: &'static str) -> Case {
        let work = self.work;
        let script = move |seen: Seen| (seen.taken == 0 && place.is_next(seen, work)).then_some(fault);
        let name = format!("{fault:?} once, {place:?} tile");
        Case { name, script: Box::new(script), faults: 1, said: vec![said], on_cpu: false }
    }

    /// From this tile on memory is never enough.
    pub fn out_of_memory_for_ever(&self, place: Place) -> Case {
        let work = self.work;
        let is_short = move |seen: Seen| seen.taken > 0 || place.is_next(seen, work);
        Case {
            name: format!("out of memory for ever from the {place:?} tile on"),
            script: Box::new(move |seen| is_short(seen).then_some(Fault::OutOfMemory)),
            faults: 2,
            said: vec![SMALLER, "the device is out of memory; from here on CPU"],
            on_cpu: true,
        }
    }

    /// Lost, and then not to be had again.
    pub fn gone(&self, place: Place) -> Case {
        let work = self.work;
        let fails = move |seen: Seen| seen.tile.is_none() || place.is_next(seen, work);
        Case {
            name: format!("gone in the {place:?} tile"),
            script: Box::new(move |seen| fails(seen).then_some(Fault::LostAfter)),
            faults: 2,
            said: vec!["cannot open the device: LostAfter, requested by a test; from here on CPU"],
            on_cpu: true,
        }
    }

    /// Lost, and again in the first tile after it was opened and tested.
    pub fn lost_twice_in_a_batch(&self, first_tile_again: u64) -> Case {
        let script = move |seen: Seen| match (seen.taken, seen.opened) {
            (0, _) => Some(Fault::LostAfter),
            (1, 1) => (seen.tile == Some(first_tile_again)).then_some(Fault::LostBefore),
            _ => None,
        };
        Case {
            name: "lost twice in a batch".to_owned(),
            script: Box::new(script),
            faults: 2,
            said: vec![AGAIN, "the device was lost: Destroyed; from here on CPU"],
            on_cpu: true,
        }
    }

    /// Lost in a tile, and then in every tile that it gets.
    pub fn lost_for_ever(&self, place: Place) -> Case {
        let work = self.work;
        let fails = move |seen: Seen| seen.tile.is_some() && (seen.taken > 0 || place.is_next(seen, work));
        Case {
            name: format!("lost for ever from the {place:?} tile on"),
            script: Box::new(move |seen| fails(seen).then_some(Fault::LostBefore)),
            faults: 2,
            said: vec!["cannot be used: the device was lost: Destroyed; from here on CPU"],
            on_cpu: true,
        }
    }

    /// Lost, and computing other bits after that.
    pub fn wrong_after_a_loss(&self, place: Place) -> Case {
        let work = self.work;
        let script = move |seen: Seen| match seen.opened {
            0 => place.is_next(seen, work).then_some(Fault::LostAfter).filter(|_| seen.tile.is_some()),
            _ => Some(Fault::WrongBits),
        };
        Case {
            name: format!("wrong after a loss in the {place:?} tile"),
            script: Box::new(script),
            faults: 2,
            said: vec!["computes other bits than the CPU in philox: it is not used"],
            on_cpu: true,
        }
    }
}
