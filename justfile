# The commands of everyday work. `just` lists them.

_list:
    @just --list --unsorted

# See it learn: the preset quickstart, into quickstart.db
quickstart:
    cargo run --release -- run quickstart --db quickstart.db

# All tests, or those whose names contain a word
test *words:
    cargo test --workspace -- {{ words }}

# Format everything
fmt:
    cargo fmt --all

# Formatting and lints, as CI has them
lint:
    cargo fmt --all --check
    cargo clippy --workspace --all-targets --all-features -- -D warnings

# The project with what the guide to a new behaviour adds: formatting and lints
guide:
    cargo test --workspace --test system -- --ignored the_guide_to_a_new_behaviour

# Golden digests of the simulator and of a whole run, release build
golden:
    cargo test --release --workspace --test determinism
    SELFTALK_PROFILE=release cargo test --workspace --test system -- digest::

# A short run: the release build with one worker against the debug build with two, as the tests have built them
short-run:
    #!/usr/bin/env bash
    set -euo pipefail
    scratch=$(mktemp -d)
    trap 'rm -rf "$scratch"' EXIT
    run() {
        selftalk="${CARGO_TARGET_DIR:-target}/$1/selftalk"
        "$selftalk" run quickstart --db "$scratch/$1.db" --set generations=3 --workers "$2"
        "$selftalk" digest quickstart --db "$scratch/$1.db" --format csv | tee "$scratch/$1.csv"
    }
    run release 1
    run debug 2
    diff "$scratch/release.csv" "$scratch/debug.csv"

# Spelling, in code and text (needs typos, from crates.io or PyPI)
spelling:
    typos

# The API's documentation: nothing is missing, every link leads somewhere
doc-check:
    RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps

# The API's documentation, in a browser
doc:
    cargo doc --workspace --no-deps --open

# Python with MuJoCo, in target/referee
_mujoco:
    python3 -m venv target/referee
    target/referee/bin/pip install --quiet --requirement sim-core/referee/requirements.txt

# The simulator against MuJoCo (needs Python 3.11 or later)
referee: _mujoco
    cargo test --workspace --lib referee -- --include-ignored --nocapture

# The engines against MuJoCo by speed
compare: _mujoco
    cargo bench --workspace --bench comparison

# What is taken away and what is deployed, read by the programs it is for (needs Python 3.11 or later)
readers:
    python3 -m venv target/readers
    target/readers/bin/pip install --quiet --requirement tests/readers.txt
    SELFTALK_PYTHON="$PWD/target/readers/bin/python" cargo test --workspace --test system -- --nocapture deploy:: export:: hostile:: replay::

# What the service costs beside general task systems (needs Python 3.11 or later)
others:
    python3 -m venv target/others
    target/others/bin/pip install --quiet --requirement tests/benches/service/requirements.txt
    target/others/bin/python tests/benches/service/others.py --generations 5

# How soon a run goes on after its master was killed
recovery:
    cargo bench --workspace --bench recovery

# The documentation as a book, in a browser (needs mdbook)
book:
    mdbook serve --open

# Licences and sources of the dependencies (needs cargo-deny)
licences:
    cargo deny check bans licenses sources

# The same and known vulnerabilities, of which it fetches a list from GitHub
deny:
    cargo deny check

# Everything CI runs
ci:
    .ci/run

# Make the robot's URDF again from its figures; look at the difference before keeping it
urdf:
    cargo run -p selftalk-sim --example make_urdf > target/icub-left-arm.urdf
    mv target/icub-left-arm.urdf sim-core/assets/

# Find the initial postures again; look at the difference before keeping it
starts:
    cargo run --release -p selftalk-sim --example make_starts > target/starts.toml
    mv target/starts.toml sim-core/assets/
