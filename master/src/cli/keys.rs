//! `selftalk keys`.

use std::fmt::{Display, Write as _};
use std::fs::{DirBuilder, OpenOptions};
use std::io::{ErrorKind, Write as _};
use std::path::Path;

use rcgen::{
    BasicConstraints, CertificateParams, CertifiedIssuer, DnType, ExtendedKeyUsagePurpose, IsCa, KeyPair,
    KeyUsagePurpose,
};
use rustls_pki_types::ServerName;
use selftalk_proto::keys::{AUTHORITY, CERTIFICATE, KEY, OPERATOR_TOKEN, TOKEN};

use super::args::{KeysArgs, KeysCommand};
use crate::exit::{Exit, Failure};

/// Bytes of a token, before they are written as hexadecimal digits.
const SECRET: usize = 32;

/// Carries out the command.
///
/// # Errors
/// [`Failure`] with the exit code and the line to print.
pub fn run(args: &KeysArgs) -> Result<(), Failure> {
    let KeysCommand::Init(args) = &args.what;
    let files = make(&args.hosts)?;
    write(&args.folder, &files)?;
    let folder = args.folder.display();
    eprintln!(
        "{folder}/master is for `selftalk serve --keys`, {folder}/worker for `selftalk-worker --keys`, {folder}/operator for \
         `selftalk operate --keys`."
    );
    eprintln!("{folder}/authority signs further certificates and need not be on any of their machines.");
    Ok(())
}

/// The folders' files, with what is in each. The authority signs one certificate for the master, one that all workers
/// share and one for operators; each side trusts what the authority signed. What workers and operators may do, their tokens
/// tell.
fn make(hosts: &[String]) -> Result<Vec<(&'static str, &'static str, String)>, Failure> {
    for host in hosts {
        ServerName::try_from(host.as_str()).map_err(|_| {
            Failure::new(Exit::Usage, format!("--host {host}: expected a host name or an IP address"))
        })?;
    }
    let (authority, authority_key) = authority().map_err(unexpected)?;
    let master = signed("selftalk master", &names(hosts), ExtendedKeyUsagePurpose::ServerAuth, &authority);
    let (master, master_key) = master.map_err(unexpected)?;
    let worker = signed("selftalk worker", &[], ExtendedKeyUsagePurpose::ClientAuth, &authority);
    let (worker, worker_key) = worker.map_err(unexpected)?;
    let operator = signed("selftalk operator", &[], ExtendedKeyUsagePurpose::ClientAuth, &authority);
    let (operator, operator_key) = operator.map_err(unexpected)?;
    let (token, operator_token) = (token()?, token()?);
    let authority = authority.pem();
    Ok(vec![
        ("authority", CERTIFICATE, authority.clone()),
        ("authority", KEY, authority_key),
        ("master", AUTHORITY, authority.clone()),
        ("master", CERTIFICATE, master),
        ("master", KEY, master_key),
        ("master", TOKEN, token.clone()),
        ("master", OPERATOR_TOKEN, operator_token.clone()),
        ("worker", AUTHORITY, authority.clone()),
        ("worker", CERTIFICATE, worker),
        ("worker", KEY, worker_key),
        ("worker", TOKEN, token),
        ("operator", AUTHORITY, authority),
        ("operator", CERTIFICATE, operator),
        ("operator", KEY, operator_key),
        ("operator", TOKEN, operator_token),
    ])
}

fn names(hosts: &[String]) -> Vec<String> {
    let mut names: Vec<String> = ["localhost", "127.0.0.1", "::1"].map(str::to_owned).into();
    names.extend(hosts.iter().cloned());
    names
}

fn authority() -> Result<(CertifiedIssuer<'static, KeyPair>, String), rcgen::Error> {
    let mut params = CertificateParams::default();
    params.distinguished_name.push(DnType::CommonName, "selftalk authority");
    params.is_ca = IsCa::Ca(BasicConstraints::Constrained(0));
    params.key_usages = vec![KeyUsagePurpose::KeyCertSign, KeyUsagePurpose::CrlSign];
    let key = KeyPair::generate()?;
    let secret = key.serialize_pem();
    Ok((CertifiedIssuer::self_signed(params, key)?, secret))
}

/// A certificate for these names that the authority signed, and its key, in PEM.
fn signed(
    who: &str,
    names: &[String],
    purpose: ExtendedKeyUsagePurpose,
    authority: &CertifiedIssuer<'static, KeyPair>,
) -> Result<(String, String), rcgen::Error> {
    let mut params = CertificateParams::new(names)?;
    params.distinguished_name.push(DnType::CommonName, who);
    params.key_usages = vec![KeyUsagePurpose::DigitalSignature];
    params.extended_key_usages = vec![purpose];
    params.use_authority_key_identifier_extension = true;
    let key = KeyPair::generate()?;
    Ok((params.signed_by(&key, authority)?.pem(), key.serialize_pem()))
}

fn token() -> Result<String, Failure> {
    let mut secret = [0; SECRET];
    getrandom::fill(&mut secret).map_err(unexpected)?;
    let mut text = String::with_capacity(2 * SECRET + 1);
    for byte in secret {
        // Writing to a string cannot fail.
        let _ = write!(text, "{byte:02x}");
    }
    text.push('\n');
    Ok(text)
}

/// Writes the files where nobody else can read them; all or none.
fn write(folder: &Path, files: &[(&str, &str, String)]) -> Result<(), Failure> {
    let fail = |path: &Path, error: std::io::Error| {
        let hint =
            if error.kind() == ErrorKind::AlreadyExists { "; choose a folder that does not" } else { "" };
        Failure::new(Exit::Usage, format!("{}: {error}{hint}", path.display()))
    };
    private_folder(folder).map_err(|error| fail(folder, error))?;
    let written = files.iter().try_for_each(|(part, name, content)| {
        let part = folder.join(part);
        if !part.exists() {
            private_folder(&part).map_err(|error| fail(&part, error))?;
        }
        let path = part.join(name);
        private_file(&path, content).map_err(|error| fail(&path, error))
    });
    if written.is_err() {
        // What was written is of no use without the rest. If that cannot be removed either, the failure says where it is.
        let _ = std::fs::remove_dir_all(folder);
    }
    written
}

fn private_folder(path: &Path) -> std::io::Result<()> {
    let mut builder = DirBuilder::new();
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.create(path)
}

fn private_file(path: &Path, content: &str) -> std::io::Result<()> {
    let mut options = OpenOptions::new();
    options.write(true).create_new(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    let mut file = options.open(path)?;
    file.write_all(content.as_bytes())?;
    file.sync_all()
}

fn unexpected(error: impl Display) -> Failure {
    Failure::new(Exit::Unexpected, format!("keys cannot be made: {error}"))
}
