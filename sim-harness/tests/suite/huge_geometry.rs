//! A tunnel of astronomic size was dug before it was measured: the grid of clearances is as large
//! as the floor plan, so a slip of the finger in a coordinate ended in an allocation failure
//! (exit status 134) or an overflow (101), and far from the origin the walls were lost to rounding
//! without a word. All of it is bad input.

use std::fs;
use std::path::Path;
use std::process::Command;

const MAIN: &str = "[[0.0, 0.0], [5.0, 0.0]]";

/// Whether a scenario with this main gallery and this beside it is refused, and how.
fn refused(name: &str, main: &str, beside: &str) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("huge-geometry");
    fs::create_dir_all(&folder).unwrap();
    let file = folder.join(format!("{name}.toml"));
    let text = format!(
        "title = \"Huge\"\nduration_s = 1.0\n[tunnel]\nwidth_m = 1.5\n\
         centre_line_m = {main}\n{beside}\n[drones]\nrelays = 1\n"
    );
    fs::write(&file, text).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_uchain"))
        .args(["run", file.to_str().unwrap(), "--quiet"])
        .env("RUST_BACKTRACE", "0")
        .output()
        .unwrap();
    let complaint = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{name}: {complaint}");
    assert_eq!(complaint.lines().count(), 1, "{name}: {complaint}");
    assert!(complaint.contains(&format!("{name}.toml:")), "{name}: {complaint}");
}

#[test]
fn a_gallery_as_long_as_a_continent() {
    refused("gallery", "[[0.0, 0.0], [1e7, 1e7]]", "");
}

#[test]
fn a_side_gallery_as_long_as_a_continent() {
    let branch = "[[tunnel.branch]]\nwidth_m = 1.0\ncentre_line_m = [[0.0, 0.0], [1e7, 1e7]]";
    refused("branch", MAIN, branch);
}

#[test]
fn a_room_as_large_as_the_sky() {
    refused("room", MAIN, "[[tunnel.room]]\ncentre_m = [0.0, 0.0]\nsize_m = [1e9, 1e9]");
}

/// These flew without walls.
#[test]
fn walls_lost_to_rounding() {
    refused("slab", MAIN, "[[tunnel.room]]\ncentre_m = [0.0, 0.0]\nsize_m = [1e30, 1.0]");
    refused("elsewhere", MAIN, "[[tunnel.room]]\ncentre_m = [1e12, 0.0]\nsize_m = [3.0, 3.0]");
    refused("origin", "[[1e8, 0.0], [1e8, 8.0]]", "");
}
