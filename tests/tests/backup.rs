//! `selftalk backup`: a copy is a whole history, made while a master writes.

use selftalk_tests::{GOLDEN, Place, wait_until};

#[test]
fn a_run_goes_on_from_a_copy_that_was_made_while_it_was_written() {
    let place = Place::disturbed(|place| {
        let master = place.start("run small.toml --workers 2");
        place.wait_half_way();
        let copied = place.run("backup copy.db --format json").objects();
        let in_time = place.is_half_way();
        let in_time = in_time && master.kill();
        let stands = place.run("history replications --db copy.db --format json").objects();
        let generations: u64 = stands.iter().map(|line| line["generations"].as_u64().unwrap()).sum();
        assert_eq!(copied[0]["generations"], generations);
        assert_eq!(copied[0]["bytes"], place.read("copy.db").len() as u64);
        in_time
    });
    place.run("resume small --db copy.db").done();
    let digests = place.run("digest small --db copy.db --format json").objects();
    let digests: Vec<&str> = digests.iter().map(|line| line["sha256"].as_str().unwrap()).collect();
    assert_eq!(digests, GOLDEN);
    place.run("verify --db copy.db").done();
}

#[test]
fn a_copy_replaces_a_copy_and_nothing_else() {
    let place = Place::with_history(1);
    place.run("backup copy.db").done();
    let before = place.read("copy.db");
    place.run("run small.toml --set generations=1 --set name=second").done();
    place.run("backup copy.db").done();
    assert!(place.read("copy.db").len() > before.len());

    place.write("diary.txt", "Dear diary, today I evolved a robot. ".repeat(300));
    let diary = place.read("diary.txt");
    for (to, words) in [
        ("diary.txt", "diary.txt: not a selftalk history"),
        ("history.db", "it is the history that is to be copied"),
        ("./history.db", "it is the history that is to be copied"),
        ("nowhere/copy.db", "nowhere/copy.db"),
    ] {
        let message = place.run(&format!("backup {to}")).refused(4);
        assert!(message.contains(words), "{message}");
    }
    assert_eq!(place.read("diary.txt"), diary);
    let left = std::fs::read_dir(place.path(".")).unwrap();
    assert!(left.map(|file| file.unwrap().file_name()).all(|name| !name.to_string_lossy().contains(".part")));
}

#[test]
#[cfg(unix)]
fn copies_are_made_again_and_again_until_it_is_ended() {
    let place = Place::with_history(1);
    let mut copying = place.start("backup copy.db --every 1");
    wait_until("the first copy", || place.path("copy.db").exists().then_some(()));
    assert!(copying.is_running());
    copying.signal(rustix::process::Signal::INT);
    copying.end().done();
    place.run("digest --db copy.db").done();
}
