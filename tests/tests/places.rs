//! Disks that are full or cannot be written.

#![cfg(unix)]

use std::fs::{Permissions, set_permissions};
use std::os::unix::fs::PermissionsExt;

use selftalk_tests::{Disk, GOLDEN, Place, SMALL};

/// Why a test did nothing.
fn skip(why: &str) {
    eprintln!("skipped: {why}");
}

#[test]
fn a_folder_that_cannot_be_written_can_still_be_read() {
    let disk = Disk::mount(16 * 1024);
    // Without the right to mount one is not root, and permissions hold.
    let place = disk.as_ref().map_or_else(Place::new, |disk| Place::in_folder(disk.path()));
    place.write("small.toml", SMALL);
    place.run("run small.toml --set generations=1").done();
    let digests = place.digests();
    match &disk {
        Some(disk) => disk.remount("ro"),
        None => set_permissions(place.path(""), Permissions::from_mode(0o555)).unwrap(),
    }
    if std::fs::write(place.path("probe"), "").is_ok() {
        return skip("this user can write everywhere, and may not mount a disk");
    }
    for command in ["run small.toml --set generations=1", "resume", "run small.toml --db new.db"] {
        let message = place.run(command).refused(4);
        assert!(message.contains(".db: cannot be written: "), "{message}");
    }
    assert_eq!(place.digests(), digests);
    place.run("history individuals --best").done();
    if disk.is_none() {
        set_permissions(place.path(""), Permissions::from_mode(0o755)).unwrap();
    }
}

#[test]
fn a_full_disk_loses_nothing_that_was_complete() {
    let Some(disk) = Disk::mount(600) else {
        return skip("this user may not mount a disk to fill up");
    };
    let place = Place::in_folder(disk.path());
    place.write("small.toml", SMALL);
    let outcome = place.run("run small.toml --workers 2");
    assert!(outcome.stderr.contains("history.db: the disk has only 0 MiB left"), "{}", outcome.stderr);
    let message = outcome.failed(4);
    assert!(message.contains("history.db: the disk is full; everything"), "{message}");
    let message = place.run("resume").failed(4);
    assert!(message.contains("history.db: the disk is full; everything"), "{message}");
    disk.remount("size=16m");
    let before = place.generations();
    assert!((1..24).contains(&before), "{before}");
    place.run("resume").done();
    assert_eq!(place.digests(), GOLDEN);
}

#[test]
fn a_disk_that_is_full_from_the_start_is_said_to_be() {
    let Some(disk) = Disk::mount(64) else {
        return skip("this user may not mount a disk to fill up");
    };
    let place = Place::in_folder(disk.path());
    place.write("small.toml", SMALL);
    let message = place.run("run small.toml").refused(4);
    assert!(message.contains("history.db: the disk is full"), "{message}");
    disk.remount("size=16m");
    place.run("run small.toml").done();
    assert_eq!(place.digests(), GOLDEN);
}
