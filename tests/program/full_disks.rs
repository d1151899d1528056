//! Disks that are full or read-only: exit code 6, what was complete is kept, and it goes on when there is room.
#![cfg(target_os = "linux")]

use std::process::{Command, Output};

use crate::desk::{Desk, PROGRAM};
use crate::stores::{MOMENTS, rows};

const RUN: &str = "run study.toml --device cpu --threads 1 --trials 200000";

fn many_points() -> String {
    let list: Vec<String> = (1..=40).map(|i| format!("\"{i} Hz\"")).collect();
    let (top, _) = MOMENTS.split_once("[[sweep]]").unwrap();
    format!("{top}[[sweep]]\nkey = \"motion.frequency\"\nlist = [{}]\n", list.join(", "))
}

/// What a run is that nothing disturbs: its rows, its table, and the bytes of its database.
fn whole(desk: &Desk) -> (Vec<String>, String, u64) {
    desk.done(&format!("{RUN} --out whole"));
    let size = desk.path("whole/tallies.sqlite").metadata().unwrap().len();
    (rows(&desk.path("whole")), desk.read("whole/points.csv"), size)
}

fn said(output: &Output) -> String {
    format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr))
}

#[test]
fn a_limit_on_the_size_of_files_is_a_full_disk() {
    let desk = Desk::with(&many_points());
    let (all, table, size) = whole(&desk);
    let (mut kept, mut refused) = (0, 0);
    for part in 1..=12 {
        // Blocks of 512 bytes, as `ulimit -f` counts them in sh: to a half more than the database, as its journal is too.
        let blocks = size * part / 8 / 512;
        let folder = format!("limited-{part}");
        let script = format!("ulimit -f {blocks}; exec {PROGRAM} {RUN} --out {folder}");
        let output = Command::new("sh").arg("-c").arg(&script).current_dir(desk.0.path()).output().unwrap();
        let found = match output.status.code() {
            Some(0) => continue,
            Some(6) => rows(&desk.path(&folder)),
            code => panic!("{part}: {code:?}\n{}", said(&output)),
        };
        assert!(said(&output).contains("error: "), "{}", said(&output));
        assert!(found.iter().all(|row| all.contains(row)), "{part}: a wrong row");
        kept += usize::from(!found.is_empty());
        refused += 1;
        desk.done(&format!("{RUN} --out {folder}"));
        assert!(rows(&desk.path(&folder)) == all, "{part}: other rows");
        assert_eq!(desk.read(&format!("{folder}/points.csv")), table, "{part}");
        assert_eq!(desk.sagnac(&format!("check {folder}")).code, 0);
    }
    println!("{refused} runs met the limit, {kept} of them had kept rows");
    assert!(refused > 3 && kept > 1, "{refused} runs met the limit, {kept} had kept rows");
}

/// Runs a script as root of a mount namespace of its own; `None`, said, where this machine allows none.
fn with_mounts(desk: &Desk, script: &str) -> Option<String> {
    let unshare = |how: &[&str], script: &str| {
        let shell = ["sh", "-ec", script];
        Command::new("unshare").args(how).args(shell).current_dir(desk.0.path()).output()
    };
    for how in [&["-m"][..], &["-rm"]] {
        if unshare(how, "mount -t tmpfs tmpfs /mnt").is_ok_and(|output| output.status.success()) {
            let output = unshare(how, script).unwrap();
            assert!(output.status.success(), "{script}\n{}", said(&output));
            return Some(said(&output));
        }
    }
    assert!(
        std::env::var_os("SAGNAC_MOUNTS").is_none_or(|mounts| mounts != "required"),
        "this machine lets no test mount a file system, and SAGNAC_MOUNTS=required"
    );
    println!("NOT SHOWN HERE: this machine lets no test mount a file system");
    None
}

#[test]
fn a_full_file_system_keeps_what_was_complete_and_a_run_goes_on_when_there_is_room() {
    let desk = Desk::with(&many_points());
    let (_, table, size) = whole(&desk);
    for part in [0, 1, 2, 4, 7, 9] {
        let kib = (size * part / 8 / 1024).max(16);
        let script = format!(
            "mkdir -p disk; mount -t tmpfs -o size={kib}k tmpfs disk
             code=0; {PROGRAM} {RUN} --out disk/out || code=$?
             echo code $code
             {PROGRAM} check disk/out || true
             mount -o remount,size=256m disk
             {PROGRAM} {RUN} --out disk/out
             {PROGRAM} check disk/out
             cp disk/out/points.csv found-{part}.csv"
        );
        let Some(said) = with_mounts(&desk, &script) else { return };
        assert!(said.contains("code 6"), "{kib} KiB: {said}");
        assert!(said.contains("no space is left") || said.contains("No space left"), "{kib} KiB: {said}");
        assert!(said.contains("complete, points.csv matches them"), "{said}");
        assert_eq!(desk.read(&format!("found-{part}.csv")), table);
    }
}

#[test]
fn a_folder_in_which_no_file_can_be_made_can_be_checked_and_merged() {
    use std::os::unix::fs::PermissionsExt;
    let desk = Desk::with(&many_points());
    let (_, table, _) = whole(&desk);
    let may = |mode: u32| {
        std::fs::set_permissions(desk.path("whole"), std::fs::Permissions::from_mode(mode)).unwrap();
    };
    may(0o555);
    if std::fs::write(desk.path("whole/new"), "").is_ok() {
        println!("NOT SHOWN HERE: permissions do not bind this user");
        may(0o755);
        return;
    }
    desk.done("check whole");
    desk.done("merge whole --out merged");
    assert_eq!(desk.read("merged/points.csv"), table);
    may(0o755);
}

#[test]
fn a_read_only_folder_can_be_checked_and_merged_but_not_run_in() {
    let desk = Desk::with(&many_points());
    let (_, table, _) = whole(&desk);
    desk.done(&format!("{RUN} --out part --shard 1/2"));
    let script = format!(
        "mount --bind whole whole; mount -o remount,bind,ro whole
         mount --bind part part; mount -o remount,bind,ro part
         for folder in whole part whole/new; do
           code=0; {PROGRAM} {RUN} --out $folder || code=$?
           echo code $code
         done
         {PROGRAM} check whole
         {PROGRAM} merge whole part --out merged"
    );
    let Some(said) = with_mounts(&desk, &script) else { return };
    assert_eq!(said.matches("code 6").count(), 3, "{said}");
    assert!(said.contains("read-only") || said.contains("Read-only"), "{said}");
    assert!(said.contains("complete, points.csv matches them"), "{said}");
    assert_eq!(desk.read("merged/points.csv"), table);
}
