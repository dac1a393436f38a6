//! What others rely on stays as it is: databases that were written once can be read, and messages keep their fields.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use prost::Message;
use prost_types::{DescriptorProto, FieldDescriptorProto, FileDescriptorSet};
use selftalk_tests::Place;
use serde_json::Value;
use sqlx::Connection;

/// What `selftalk digest` says of the history in every `tests/contracts/schema-N.dump`: the database of a finished run with
/// `engine = "null"`, as the release with that schema wrote it, dumped by SQLite.
const FROZEN: &str = "4ffdd0a5f2669a61cce98e02dcc21511c57f07346f4082a5e44f635c1a9ceec3";

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Makes a database of a dump.
fn restore(dump: &Path, database: &Path) {
    let restore = async {
        // A dump is not in the order of its references.
        let options = sqlx::sqlite::SqliteConnectOptions::new();
        let options = options.filename(database).create_if_missing(true).foreign_keys(false);
        let mut connection = sqlx::SqliteConnection::connect_with(&options).await.unwrap();
        let script = fs::read_to_string(dump).unwrap();
        sqlx::raw_sql(sqlx::AssertSqlSafe(script)).execute(&mut connection).await.unwrap();
        connection.close().await.unwrap();
    };
    tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap().block_on(restore);
}

#[test]
fn databases_of_every_schema_can_be_read_and_are_brought_up_to_date() {
    let newest = fs::read_dir(root().join("migrations")).unwrap().count();
    let mut best = BTreeSet::new();
    for schema in 1..=newest {
        let dump = root().join(format!("tests/contracts/schema-{schema}.dump"));
        assert!(dump.exists(), "a database of schema {schema} has to be kept: {}", dump.display());
        let place = Place::new();
        restore(&dump, &place.path("history.db"));
        if schema < newest {
            let message = place.run("digest").refused(4);
            assert!(message.contains("written by an earlier release"), "{message}");
        }
        // There is nothing to go on with; it is opened by a writer.
        place.run("resume").done();
        let digests = place.ask("digest frozen");
        assert_eq!(digests[0]["sha256"], FROZEN, "schema {schema}");
        place.run("verify").done();
        place.run("history lineage").done();
        let of_best = |of: &Value| format!("{} {}", of["best_fitness"], of["best_successes"]);
        let behaviours = place.ask("history behaviours").into_iter().map(|mut of| {
            // A migration adds scores up in another order.
            of.as_object_mut().unwrap().retain(|key, _| !key.ends_with("_score"));
            of.to_string()
        });
        let generations = place.ask("history generations");
        best.insert(generations.iter().map(of_best).chain(behaviours).collect::<Vec<_>>());
    }
    assert_eq!(best.len(), 1, "what an earlier schema did not say is made up for: {best:?}");
}

/// Every field of a message and of those within it: its name, number, type, and whether there may be many.
fn fields(prefix: &str, message: &DescriptorProto, into: &mut BTreeSet<String>) {
    let name = format!("{prefix}.{}", message.name());
    let line = |field: &FieldDescriptorProto| {
        let of = field.type_name.as_deref().unwrap_or_default();
        format!("{name}.{} = {} {:?} {:?} {of}", field.name(), field.number(), field.r#type(), field.label())
            .trim()
            .to_owned()
    };
    into.extend(message.field.iter().map(line));
    message.nested_type.iter().for_each(|nested| fields(&name, nested, into));
    for of in &message.enum_type {
        into.extend(
            of.value
                .iter()
                .map(|value| format!("{name}.{}.{} = {}", of.name(), value.name(), value.number())),
        );
    }
}

#[test]
fn messages_keep_their_fields() {
    let set = FileDescriptorSet::decode(selftalk_proto::DESCRIPTORS).unwrap();
    let mut found = BTreeSet::new();
    for file in set.file.iter().filter(|file| file.package() == "selftalk.v1") {
        file.message_type.iter().for_each(|message| fields("selftalk.v1", message, &mut found));
        for service in &file.service {
            for method in &service.method {
                let (input, output) = (method.input_type(), method.output_type());
                let streams = (method.client_streaming(), method.server_streaming());
                found.insert(format!(
                    "{}.{}({input}) -> {output} {streams:?}",
                    service.name(),
                    method.name()
                ));
            }
        }
    }
    let path = root().join("tests/contracts/wire.txt");
    let kept: BTreeSet<String> =
        fs::read_to_string(&path).unwrap_or_default().lines().map(str::to_owned).collect();
    let gone: Vec<_> = kept.difference(&found).collect();
    assert!(
        gone.is_empty(),
        "workers and masters of other releases rely on these, which are gone or others now: {gone:#?}"
    );
    let new: Vec<_> = found.difference(&kept).cloned().collect();
    assert!(new.is_empty(), "add these lines to {}, in order:\n{}", path.display(), new.join("\n"));
}
