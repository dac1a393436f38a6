//! Which release this is, and which others it can work with.

use std::sync::LazyLock;

use super::PROTOCOL;

/// The release, what it was built for and from, and the protocol it speaks, in several lines: what a program prints when it is
/// asked for its version.
///
/// ```
/// assert!(selftalk_proto::release().starts_with(env!("CARGO_PKG_VERSION")));
/// ```
#[must_use]
pub fn release() -> &'static str {
    static RELEASE: LazyLock<String> = LazyLock::new(|| {
        let (version, build) = (env!("CARGO_PKG_VERSION"), env!("SELFTALK_BUILD"));
        format!("{version}\nbuilt for {build}\nprotocol {PROTOCOL}")
    });
    &RELEASE
}
