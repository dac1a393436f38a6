//! The jobs in `deploy/slurm/`, under a real Slurm. Without one (`apt install slurm-wlm munge`), or without being root, who
//! alone can set one up, nothing is tested here.

use std::path::Path;
use std::process::Command;

use selftalk_tests::selftalk;

#[test]
fn a_cluster_gives_the_same_history_whatever_its_jobs_go_through() {
    let there = |program: &str| Command::new(program).arg("--version").output().is_ok();
    let root = Command::new("id").arg("-u").output().is_ok_and(|output| output.stdout == b"0\n");
    if !(there("slurmctld") && there("munged") && root) {
        eprintln!("there is no Slurm that this user can set up; nothing is tested");
        return;
    }
    let programs = selftalk().get_program().to_owned();
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/../deploy/slurm/test.sh");
    let output = Command::new(script).arg(Path::new(&programs).parent().unwrap()).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    assert!(output.status.success(), "{}\n{}", text(&output.stdout), text(&output.stderr));
    assert!(text(&output.stdout).contains("the same history under Slurm"));
}
