//! The results that are kept with the source come out again, as long as the simulator is the one they were made with.

use std::fs;
use std::path::{Path, PathBuf};

use selftalk_tests::Place;

/// A folder and all folders in it.
fn folders(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let below = entries.filter(|path| path.is_dir()).flat_map(|path| folders(&path));
    [folder.to_owned()].into_iter().chain(below).collect()
}

#[test]
fn kept_results_come_out_again() {
    let kept = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/results");
    let fingerprint = selftalk_sim::fingerprint().unwrap();
    let place = Place::new();
    let mut kept_folders = 0;
    for folder in folders(&kept) {
        let Ok(digests) = fs::read_to_string(folder.join("digest.csv")) else { continue };
        kept_folders += 1;
        if !digests.lines().skip(1).all(|line| line.ends_with(&fingerprint)) {
            eprintln!("{}: made with another simulator, not run again", folder.display());
            continue;
        }
        // Its path may have spaces in it, which the words of a command must not.
        let copy = format!("results-{kept_folders}");
        fs::create_dir(place.path(&copy)).unwrap();
        for file in fs::read_dir(&folder).unwrap() {
            let file = file.unwrap();
            if file.path().is_file() {
                fs::copy(file.path(), place.path(&copy).join(file.file_name())).unwrap();
            }
        }
        for verified in place.ask(&format!("verify --results {copy}")) {
            assert_eq!(verified["mismatches"], 0, "{}", folder.display());
            assert!(verified["trials"].as_u64().unwrap() > 0, "{}", folder.display());
        }
    }
    assert!(kept_folders > 0);
}
