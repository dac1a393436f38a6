//! Tokens: secrets that a master shares with its workers, and with its operators.

use std::fmt;
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};
use thiserror::Error;
use tonic::metadata::{Ascii, MetadataMap, MetadataValue};

/// The metadata key under which a call carries its token, and the word before it (RFC 6750).
const KEY: &str = "authorization";
const SCHEME: &str = "Bearer ";

/// Characters a token has at least, and at most.
const LENGTH: std::ops::RangeInclusive<usize> = 16..=512;

/// Why a token cannot be used.
#[derive(Debug, Error)]
pub enum TokenError {
    /// The file cannot be read.
    #[error("{}: the token cannot be read: {reason}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Why not.
        reason: std::io::Error,
    },
    /// It is too short, too long, or has characters that are not visible ASCII ones.
    #[error(
        "{from}: a token has 16 to 512 visible ASCII characters, for example what `openssl rand -hex 32` prints"
    )]
    Text {
        /// Where it was given.
        from: String,
    },
}

/// A secret that a master shares with its workers, or with its operators. It is never shown.
#[derive(Clone, PartialEq, Eq)]
pub struct Token(String);

impl Token {
    /// The environment variable that a token can be given by.
    pub const VARIABLE: &str = "SELFTALK_TOKEN";

    /// A token of this text, without white space around it. `from` says where it was given.
    ///
    /// # Errors
    /// [`TokenError::Text`] when it has not 16 to 512 characters of visible ASCII.
    pub fn new(text: &str, from: &str) -> Result<Self, TokenError> {
        let text = text.trim();
        if LENGTH.contains(&text.len()) && text.bytes().all(|byte| byte.is_ascii_graphic()) {
            Ok(Self(text.to_owned()))
        } else {
            Err(TokenError::Text { from: from.to_owned() })
        }
    }

    /// The token in a file, or without one that of the environment (`variable` is the value of [`Self::VARIABLE`]).
    ///
    /// # Errors
    /// [`TokenError`] when there is one that cannot be read or used.
    pub fn given(file: Option<&Path>, variable: Option<&str>) -> Result<Option<Self>, TokenError> {
        if let Some(path) = file {
            let text = std::fs::read_to_string(path)
                .map_err(|reason| TokenError::File { path: path.to_owned(), reason })?;
            return Self::new(&text, &path.display().to_string()).map(Some);
        }
        variable.map(|text| Self::new(text, Self::VARIABLE)).transpose()
    }

    /// Adds it to a call's metadata.
    pub fn attach(&self, metadata: &mut MetadataMap) {
        // Visible ASCII is always a value.
        if let Ok(mut value) = MetadataValue::<Ascii>::try_from(format!("{SCHEME}{}", self.0)) {
            value.set_sensitive(true);
            metadata.insert(KEY, value);
        }
    }

    /// Whether a call's metadata has this token. How long that takes tells nothing about it: hashes are compared, and
    /// all of their bytes.
    #[must_use]
    pub fn admits(&self, metadata: &MetadataMap) -> bool {
        let given = metadata.get(KEY).map(|value| value.as_bytes()).unwrap_or_default();
        let expected = Sha256::digest(format!("{SCHEME}{}", self.0));
        let differing = Sha256::digest(given).iter().zip(&expected).fold(0, |sum, (a, b)| sum | (a ^ b));
        differing == 0
    }
}

impl fmt::Debug for Token {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Token(…)")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "0123456789abcdef";

    #[test]
    fn a_call_is_admitted_with_the_very_token() {
        let token = Token::new(TEXT, "test").unwrap();
        let admitted = |other: &str| {
            let mut metadata = MetadataMap::new();
            Token::new(other, "test").unwrap().attach(&mut metadata);
            token.admits(&metadata)
        };
        assert!(admitted(TEXT) && admitted(" 0123456789abcdef\n"));
        assert!(!admitted("0123456789abcdeF") && !admitted("0123456789abcdef0"));
        assert!(!token.admits(&MetadataMap::new()));
    }

    #[test]
    fn weak_and_unreadable_tokens_are_refused_and_none_is_shown() {
        for text in ["", "short", "with a space in it", "0123456789abcdé", &"x".repeat(513)] {
            let error = Token::new(text, "here").unwrap_err().to_string();
            assert!(error.starts_with("here: a token has 16 to 512"), "{error}");
        }
        let missing = Token::given(Some(Path::new("/nowhere/token")), Some(TEXT)).unwrap_err();
        assert!(missing.to_string().starts_with("/nowhere/token: "), "{missing}");
        assert_eq!(Token::given(None, None).unwrap(), None);
        let token = Token::given(None, Some(TEXT)).unwrap().unwrap();
        assert_eq!(format!("{token:?}"), "Token(…)");
    }
}
