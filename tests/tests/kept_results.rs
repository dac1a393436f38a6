//! The results that are kept with the source come out again, as long as the simulator is the one they were made with.

use std::fs;
use std::path::Path;

use selftalk_tests::Place;

#[test]
fn kept_results_come_out_again() {
    let kept = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/results");
    let fingerprint = selftalk_sim::fingerprint().unwrap();
    let place = Place::new();
    let mut folders = 0;
    for entry in fs::read_dir(kept).unwrap() {
        let folder = entry.unwrap().path();
        let Ok(digests) = fs::read_to_string(folder.join("digest.csv")) else { continue };
        folders += 1;
        if !digests.lines().skip(1).all(|line| line.ends_with(&fingerprint)) {
            eprintln!("{}: made with another simulator, not run again", folder.display());
            continue;
        }
        // Its path may have spaces in it, which the words of a command must not.
        let copy = format!("results-{folders}");
        fs::create_dir(place.path(&copy)).unwrap();
        for file in fs::read_dir(&folder).unwrap() {
            let file = file.unwrap();
            fs::copy(file.path(), place.path(&copy).join(file.file_name())).unwrap();
        }
        for verified in place.ask(&format!("verify --results {copy}")) {
            assert_eq!(verified["mismatches"], 0, "{}", folder.display());
            assert!(verified["trials"].as_u64().unwrap() > 0, "{}", folder.display());
        }
    }
    assert!(folders > 0);
}
