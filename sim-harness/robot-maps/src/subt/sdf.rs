//! Reads scenes in SDFormat: of each model that a world includes, its name, its pose and its URI.

use std::collections::HashMap;

use cave_survey::Refusal;
use roxmltree::{Document, Node, ParsingOptions};

use super::Tile;
use crate::open::{line_of, whole};

/// The most elements of a scene.
const MOST_ELEMENTS: u32 = 2_000_000;

/// A scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Scene {
    pub(super) title: String,
    models: HashMap<String, Tile>,
}

impl Scene {
    /// The model of that name.
    pub(super) fn tile(&self, name: &str) -> Option<Tile> {
        self.models.get(name).cloned()
    }
}

/// Reads the text of a `.sdf` file.
pub(super) fn read(text: &str, file: &str) -> Result<Scene, Refusal> {
    let options = ParsingOptions { nodes_limit: MOST_ELEMENTS, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options).map_err(|error| {
        let line = error.pos().row as usize;
        Refusal::new(format!("this is no XML: {error}"), "give the .sdf file of a SubT world")
            .at(line_of(file, line))
    })?;
    let mut nodes = document.root_element().descendants();
    let Some(world) = nodes.find(|node| node.has_tag_name("world")) else {
        let remedy = "give the .sdf file of a SubT world";
        return Err(Refusal::new("it has no world", remedy).at(whole(file)));
    };
    let mut scene = Scene {
        title: world.attribute("name").unwrap_or_default().to_owned(),
        models: HashMap::new(),
    };
    for include in world.children().filter(|node| node.has_tag_name("include")) {
        let Some(name) = child(include, "name") else { continue };
        let pose = match child(include, "pose") {
            None => [0.0; 6],
            Some(text) => pose(text).ok_or_else(|| {
                let line = document.text_pos_at(include.range().start).row as usize;
                let wrong = format!("the pose of {name} is not six numbers");
                Refusal::new(wrong, "give x y z roll pitch yaw").at(line_of(file, line))
            })?,
        };
        let [x, y, z, roll, pitch, yaw] = pose;
        let uri = child(include, "uri").unwrap_or_default().trim_end_matches('/');
        let model = uri.rsplit('/').next().unwrap_or_default().to_owned();
        let tile = Tile { name: name.to_owned(), model, at: [x, y, z], turned: [roll, pitch, yaw] };
        scene.models.insert(name.to_owned(), tile);
    }
    Ok(scene)
}

/// The text of the child of that name.
fn child<'a>(node: Node<'a, '_>, name: &str) -> Option<&'a str> {
    node.children().find(|child| child.has_tag_name(name))?.text().map(str::trim)
}

/// The six numbers of a pose; no coordinate of a world is farther from its origin than 100 km.
fn pose(text: &str) -> Option<[f64; 6]> {
    let numbers: Vec<f64> =
        text.split_whitespace().map(str::parse).collect::<Result<_, _>>().ok()?;
    let pose: [f64; 6] = numbers.try_into().ok()?;
    pose.iter().all(|number| number.abs() < 1e5).then_some(pose)
}
