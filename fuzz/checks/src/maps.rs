//! The readers of robots' maps: no bytes make them panic or take without bound, what is accepted has
//! places that are numbers, and a map that is written is read back.

use cave_survey::Memory;
use robot_maps::{Refusal, map_server, subt};

/// Splits the bytes at the first zero byte, which is in no text, into two files.
fn parts(data: &[u8]) -> (&[u8], &[u8]) {
    let at = data.iter().position(|byte| *byte == 0).unwrap_or(data.len());
    (&data[..at], data.get(at + 1..).unwrap_or_default())
}

/// Reads the bytes as a YAML file and, behind a zero byte, the image `m.pgm`.
pub fn map_server(data: &[u8]) {
    let (yaml, image) = parts(data);
    let files = Memory::default().with("m.yaml", yaml).with("m.pgm", image);
    match map_server::read(&files, "m.yaml") {
        Err(refusal) => refused(&refusal),
        Ok(map) => {
            assert_eq!(map.columns() * map.rows(), map.cells().len());
            assert!(map.place(1.0, 1.0).iter().all(|metres| metres.is_finite()));
            let (mut yaml, mut image) = (Vec::new(), Vec::new());
            map_server::write(&map, &mut yaml, &mut image).unwrap();
            let files = Memory::default().with("m.yaml", yaml).with(map_server::IMAGE, image);
            let again = map_server::read(&files, "m.yaml").unwrap();
            assert_eq!(again.cells(), map.cells());
            assert_eq!((again.origin, again.resolution_m), (map.origin, map.resolution_m));
        }
    }
}

/// Reads the bytes as a `.dot` file and, behind a zero byte, the `.sdf` file.
pub fn subt(data: &[u8]) {
    let (graph, scene) = parts(data);
    let files = Memory::default().with("w.dot", graph).with("w.sdf", scene);
    match subt::read(&files, "w.dot") {
        Err(refusal) => refused(&refusal),
        Ok(world) => {
            assert!(!world.joints.is_empty());
            for joint in &world.joints {
                assert!(joint.tiles.iter().all(|tile| *tile < world.tiles.len()));
                assert!(joint.at.iter().all(|metres| metres.is_finite()));
            }
        }
    }
}

fn refused(refusal: &Refusal) {
    assert!(!refusal.wrong.is_empty() && !refusal.remedy.is_empty());
    assert_eq!(refusal.to_string().lines().count(), 1, "{refusal}");
}
