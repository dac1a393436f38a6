//! A disk of its own, for what cannot be tried on a real one.

use std::path::Path;
use std::process::Command;

/// A small file system in memory, unmounted when this is dropped.
#[derive(Debug)]
pub struct Disk {
    folder: tempfile::TempDir,
}

impl Disk {
    /// Mounts one of so many KiB. None where that is not permitted: it takes Linux and usually root.
    ///
    /// # Panics
    /// If the system has no place for temporary files.
    #[must_use]
    pub fn mount(kib: u32) -> Option<Self> {
        let folder = tempfile::tempdir().unwrap();
        let mounted = Command::new("mount")
            .args(["-t", "tmpfs", "-o", &format!("size={kib}k"), "selftalk-test"])
            .arg(folder.path())
            .output()
            .is_ok_and(|output| output.status.success());
        mounted.then_some(Self { folder })
    }

    /// Where it is.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.folder.path()
    }

    /// Changes how it is mounted, such as `ro` or `size=4m`.
    ///
    /// # Panics
    /// If that is not possible.
    pub fn remount(&self, options: &str) {
        let output = Command::new("mount")
            .args(["-o", &format!("remount,{options}")])
            .arg(self.path())
            .output()
            .unwrap();
        assert!(output.status.success(), "{output:?}");
    }
}

impl Drop for Disk {
    fn drop(&mut self) {
        // Lazily: a process of a failed test may still be ending.
        let _ = Command::new("umount").arg("--lazy").arg(self.path()).output();
    }
}
