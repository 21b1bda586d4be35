//! Builds `crates/rtec` for a control's servo thread, so that whoever installs the corrector needs no Rust: one object file
//! with its C interface, put into this module by realtime.rs.

use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

/// What an outer cargo sets for its own crates: flags of coverage, of a fuzzer, of clippy.
const NOT_HANDED_DOWN: [&str; 5] = [
    "CARGO_ENCODED_RUSTFLAGS",
    "CARGO_TARGET_DIR",
    "RUSTC_WORKSPACE_WRAPPER",
    "RUSTC_WRAPPER",
    "RUSTFLAGS",
];

fn main() {
    let crates = PathBuf::from(set("CARGO_MANIFEST_DIR")).join("..");
    for part in ["rtec", "error-eval", "../Cargo.toml", "../Cargo.lock"] {
        println!("cargo::rerun-if-changed={}", crates.join(part).display());
    }
    let folder = PathBuf::from(set("OUT_DIR"));
    let mut build = command(&crates.join("rtec"), &folder);
    let done = build.status();
    assert!(
        done.as_ref().is_ok_and(|status| status.success()),
        "{build:?} ended with {done:?}"
    );
}

/// With a target folder of its own: the outer cargo holds the lock of the usual one.
fn command(rtec: &Path, folder: &Path) -> Command {
    let mut build = Command::new(set("CARGO"));
    build
        .args(["rustc", "--quiet", "--locked", "--offline"])
        .args(["--profile", "realtime", "--features", "c-library"])
        .args(["--crate-type", "staticlib"])
        .arg("--manifest-path")
        .arg(rtec.join("Cargo.toml"))
        .arg("--target-dir")
        .arg(folder.join("realtime"));
    if set("TARGET") != set("HOST") {
        build.args(["--target", &set("TARGET")]);
    }
    build.arg("--");
    build.arg(format!("--emit=obj={}", folder.join("rtec.o").display()));
    for name in NOT_HANDED_DOWN {
        build.env_remove(name);
    }
    build
}

fn set(name: &str) -> String {
    env::var(name).unwrap_or_else(|_| panic!("cargo sets {name}"))
}
