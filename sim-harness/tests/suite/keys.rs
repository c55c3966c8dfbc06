//! `uchain keys` as a user meets it: that nothing it prints has anything of a secret, and what it
//! leaves on the disk.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const UCHAIN: &str = env!("CARGO_BIN_EXE_uchain");

/// A new folder of this test's own.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("keys").join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

fn keys(folder: &Path, args: &[&str]) -> Output {
    Command::new(UCHAIN).arg("keys").args(args).current_dir(folder).output().unwrap()
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The fleet's secret and the keys of each page in the folder, as hexadecimal digits.
fn secrets(folder: &Path) -> Vec<String> {
    let mut secrets = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let bytes = fs::read(&path).unwrap();
        if path.extension().is_some_and(|extension| extension == "bin") {
            secrets.extend([hex(&bytes[20..36]), hex(&bytes[36..52])]);
        } else if let Ok(text) = String::from_utf8(bytes)
            && let Some((_, rest)) = text.split_once("secret = \"")
        {
            secrets.push(rest[..32].to_owned());
        }
    }
    secrets
}

/// Whatever is asked of a fleet, and however wrongly: nowhere are there 4 bytes of a key on end.
#[test]
fn nothing_printed_has_anything_of_a_secret() {
    let folder = folder("silent");
    let mut printed = String::new();
    let mut ask = |args: &[&str], status: i32| {
        let output = keys(&folder, args);
        assert_eq!(output.status.code(), Some(status), "{args:?}");
        for stream in [output.stdout, output.stderr] {
            printed += &String::from_utf8(stream).unwrap().to_lowercase();
        }
    };
    for json in [&[][..], &["--json"]] {
        let mut ask = |args: &[&str], status| ask(&[args, json].concat(), status);
        let name = |name: &str| format!("{name}{}", json.len());
        let fleet = &name("fleet.toml");
        ask(&["new", fleet], 0);
        ask(&["new", fleet], 2);
        for (node, more) in [("0", None), ("3", None), ("15", Some("--allow-cfclient"))] {
            let page = format!("{}-{node}.bin", name("page"));
            let args = ["provision", fleet, "--node", node, "--out", &page];
            let more: Vec<_> = more.into_iter().collect();
            ask(&[&args[..], &more].concat(), 0);
            ask(&[&args[..], &more].concat(), 2);
        }
        ask(&["show", fleet], 0);
        ask(&["rekey", fleet, "--without", "3"], 0);
        ask(&["rekey", fleet, "--without", "3"], 2);
        ask(&["show", fleet], 0);
        let whole = fs::read_to_string(folder.join(fleet)).unwrap();
        let secret = &secrets(&folder)[..];
        let secret = secret.iter().find(|secret| whole.contains(*secret)).unwrap();
        let quoted = format!("\"{secret}\"");
        for broken in [secret.clone(), format!("\"{secret}"), format!("\"{}\"", &secret[2..])] {
            let file = &name("broken.toml");
            fs::copy(folder.join(fleet), folder.join(file)).unwrap();
            fs::write(folder.join(file), whole.replace(&quoted, &broken)).unwrap();
            for args in [&["show", file][..], &["rekey", file]] {
                ask(args, 2);
            }
            fs::remove_file(folder.join(file)).unwrap();
        }
    }
    let secrets = secrets(&folder);
    assert!(secrets.len() >= 2 * 7 && printed.len() > 2_000);
    for secret in secrets {
        for at in 0..=24 {
            assert!(!printed.contains(&secret[at..at + 8]), "{printed}");
        }
    }
}

#[test]
fn every_verb_speaks_json_and_can_be_quiet() {
    let folder = folder("json");
    let json = |args: &[&str]| -> serde_json::Value {
        let output = keys(&folder, &[args, &["--json"]].concat());
        assert_eq!(output.status.code(), Some(0), "{args:?}");
        serde_json::from_slice(&output.stdout).unwrap()
    };
    assert_eq!(json(&["new", "fleet.toml", "--generation", "4"])["generation"], 4);
    let made = json(&["provision", "fleet.toml", "--node", "15", "--allow-cfclient", "--out", "b"]);
    assert_eq!(
        (&made["role"], &made["cfclient"], &made["issue"]),
        (&"base".into(), &true.into(), &1.into())
    );
    assert!(made["load"]["usb"].as_str().unwrap().contains("-s 0x080E0000 -D b"));
    assert_eq!(json(&["rekey", "fleet.toml"])["provision_anew"], serde_json::json!([15]));
    assert_eq!(json(&["show", "fleet.toml"])["drones"][0]["stale"], true);
    for args in [
        &["show", "fleet.toml", "--quiet"][..],
        &["provision", "fleet.toml", "--node", "1", "--out", "1.bin", "--quiet"],
        &["rekey", "fleet.toml", "--quiet"],
        &["new", "other.toml", "--quiet"],
    ] {
        let output = keys(&folder, args);
        assert!(output.status.success() && output.stdout.is_empty() && output.stderr.is_empty());
    }
    let mut names: Vec<_> =
        fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["1.bin", "b", "fleet.toml", "other.toml"], "nothing unfinished is left");
}
