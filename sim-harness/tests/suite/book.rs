//! What the book shows of scenarios is accepted as it stands.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use sim_harness::scenario::Scenario;

/// A scenario of the book.
struct Shown {
    /// The page, and the line at which the scenario begins.
    place: String,
    text: String,
}

/// Every block of TOML in the book that is a whole scenario: it has a title and a tunnel.
fn scenarios() -> Vec<Shown> {
    let book = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/src");
    let mut shown = Vec::new();
    for entry in fs::read_dir(book).unwrap() {
        let path = entry.unwrap().path();
        let Ok(page) = fs::read_to_string(&path) else { continue };
        let mut line = 1;
        for (n, part) in page.split("```").enumerate() {
            // Every second part is a block.
            if let Some(text) = part.strip_prefix("toml\n").filter(|_| n % 2 == 1)
                && text.contains("title = ")
                && text.contains("[tunnel]\n")
            {
                let place = format!("{}:{}", path.display(), line + 1);
                shown.push(Shown { place, text: text.to_owned() });
            }
            line += part.matches('\n').count();
        }
    }
    shown
}

/// A file of this test's own with a scenario.
fn file(name: &str, text: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("book");
    fs::create_dir_all(&folder).unwrap();
    let file = folder.join(name);
    fs::write(&file, text).unwrap();
    file
}

#[test]
fn every_scenario_of_the_book_is_accepted() {
    let shown = scenarios();
    assert!(shown.len() >= 2, "the book has at least two");
    for (n, Shown { place, text }) in shown.iter().enumerate() {
        let file = file(&format!("{n}.toml"), text);
        let opened = Scenario::open(file.to_str().unwrap());
        assert!(opened.is_ok(), "{place}: {}", opened.err().unwrap());
    }
}

#[test]
fn the_books_full_scenario_is_flown_as_it_stands() {
    let shown = scenarios();
    let is_full = |shown: &&Shown| shown.text.starts_with("title = \"A bend, a chamber");
    let file = file("full.toml", &shown.iter().find(is_full).unwrap().text);
    let output = Command::new(env!("CARGO_BIN_EXE_uchain")).arg("run").arg(file).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
}
