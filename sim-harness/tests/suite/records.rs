//! `uchain bench NAME --record FILE.md`: the file says what made the table, and no other is lost.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// An empty folder of this test's own.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("records").join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// Runs a benchmark in this folder.
fn bench(folder: &Path, args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_uchain"));
    command.current_dir(folder).arg("bench").args(args).output().unwrap()
}

/// Runs a benchmark that ends well, and returns what it printed.
fn printed(folder: &Path, args: &[&str]) -> String {
    let output = bench(folder, args);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn the_file_has_the_command_the_seeds_the_version_and_the_table() {
    let folder = folder("whole");
    let args = ["estimator", "--runs=2", "--seed", "7", "--record", "the estimator.md"];
    let printed = printed(&folder, &args);
    let table = printed.strip_suffix("\nwrote the estimator.md\n").unwrap();
    let file = fs::read_to_string(folder.join("the estimator.md")).unwrap();
    let version = format!("- version: {}\n- revision: ", env!("CARGO_PKG_VERSION"));
    for part in [
        "# Results of `bench estimator`\n\nWhether the errors of the state estimator",
        "\nuchain bench estimator --runs=2 --seed 7 --record 'the estimator.md'\n",
        "\n- seeds: 7 to 8\n",
        &version,
        &format!("```text\n{table}```\n"),
    ] {
        assert!(file.contains(part), "no {part:?} in {file}");
    }
}

#[test]
fn the_same_command_writes_the_same_bytes_over_its_own_file() {
    let folder = folder("again");
    let [once, again] = [(); 2].map(|()| {
        let args = ["estimator", "--runs", "2", "--record", "estimator.md", "--quiet"];
        assert_eq!(printed(&folder, &args), "");
        fs::read(folder.join("estimator.md")).unwrap()
    });
    assert!(once == again, "the file differs");
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 1, "a draft was left behind");
}

/// A benchmark of so many flights would outlast every patience: the refusal comes before it.
#[test]
fn a_file_that_cannot_be_written_is_refused_before_the_benchmark_runs() {
    let folder = folder("refused");
    fs::create_dir(folder.join("folder.md")).unwrap();
    fs::write(folder.join("notes.md"), "# Notes\n").unwrap();
    fs::write(folder.join("plain"), "").unwrap();
    for (file, wrong) in [
        ("folder.md", "uchain bench estimator did not write what is there"),
        ("notes.md", "uchain bench estimator did not write what is there"),
        ("missing/estimator.md", "cannot be written: "),
        ("plain/estimator.md", "cannot be written: "),
        ("estimator.txt", "--record takes a file whose name ends in .md"),
    ] {
        let output = bench(&folder, &["estimator", "--runs", "100000", "--record", file]);
        let complaint = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{complaint}");
        assert!(output.stdout.is_empty());
        assert_eq!(complaint.lines().count(), 1, "{complaint}");
        assert!(complaint.starts_with(&format!("uchain: {file}: {wrong}")), "{complaint}");
    }
    assert_eq!(fs::read_to_string(folder.join("notes.md")).unwrap(), "# Notes\n");
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 3, "something was written");
}

#[test]
fn the_file_of_another_benchmark_is_not_replaced() {
    let folder = folder("other");
    printed(&folder, &["estimator", "--runs", "2", "--record", "bench.md"]);
    let kept = fs::read(folder.join("bench.md")).unwrap();
    let output = bench(&folder, &["link", "--runs", "1", "--record", "bench.md"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(fs::read(folder.join("bench.md")).unwrap() == kept);
}
