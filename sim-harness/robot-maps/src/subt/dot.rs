//! Reads visibility graphs: of the language DOT, what SubT's tools write.
//!
//! A vertex is `id [label="id::model::name"];`, an edge `id -- id [label=cost];`. Comments are those
//! of C, and lines that begin with `#`.

use cave_survey::{Refusal, Warning};

use super::MOST_TILES;
use crate::open::{line_of, whole};

/// A vertex of the graph.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Vertex {
    pub(super) id: u32,
    pub(super) name: String,
    pub(super) line: usize,
}

/// An edge of the graph.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Edge {
    pub(super) ends: [u32; 2],
    pub(super) cost: Option<f64>,
    pub(super) line: usize,
}

/// A graph.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Graph {
    pub(super) vertices: Vec<Vertex>,
    pub(super) edges: Vec<Edge>,
    pub(super) warnings: Vec<Warning>,
}

/// Reads the text of a `.dot` file.
pub(super) fn read(text: &str, file: &str) -> Result<Graph, Refusal> {
    let body = without_comments(text);
    let Some((head, rest)) = body.split_once('{') else {
        let remedy = "give the .dot file of a SubT world";
        return Err(Refusal::new("this is no graph", remedy).at(whole(file)));
    };
    let mut graph = Graph::default();
    let mut line = 1 + head.matches('\n').count();
    for statement in statements(rest) {
        let begins = line + statement.len_of_blank_lines();
        line += statement.0.matches('\n').count();
        let told = |refusal: Refusal| refusal.at(line_of(file, begins));
        graph.add(statement.0.trim(), begins, file).map_err(told)?;
    }
    if graph.vertices.is_empty() {
        let remedy = "give the .dot file of a SubT world";
        return Err(Refusal::new("the graph has no vertices", remedy).at(whole(file)));
    }
    Ok(graph)
}

/// The text with blanks for comments, so that lines keep their numbers.
fn without_comments(text: &str) -> String {
    let mut kept = String::with_capacity(text.len());
    let mut rest = text;
    let mut begins_line = true;
    while let Some(next) = rest.chars().next() {
        let end = match rest.as_bytes() {
            [b'/', b'*', ..] => rest.find("*/").map_or(rest.len(), |end| end + 2),
            [b'/', b'/', ..] => rest.find('\n').unwrap_or(rest.len()),
            [b'#', ..] if begins_line => rest.find('\n').unwrap_or(rest.len()),
            [b'"', ..] => rest[1..].find('"').map_or(rest.len(), |end| end + 2),
            _ => next.len_utf8(),
        };
        let (piece, after) = rest.split_at(end);
        if next == '/' && end > 1 || next == '#' && begins_line {
            kept.extend(piece.chars().filter(|it| *it == '\n'));
        } else {
            kept.push_str(piece);
        }
        begins_line = piece.ends_with('\n');
        rest = after;
    }
    kept
}

/// A statement with the white space around it.
struct Statement<'a>(&'a str);

impl Statement<'_> {
    /// The number of lines before its first word.
    fn len_of_blank_lines(&self) -> usize {
        let blank = self.0.len() - self.0.trim_start().len();
        self.0[..blank].matches('\n').count()
    }
}

/// The statements, which end at a semicolon, a brace or, outside of brackets, a line.
fn statements(text: &str) -> impl Iterator<Item = Statement<'_>> {
    let (mut quoted, mut depth) = (false, 0u32);
    text.split_inclusive(move |it: char| {
        match it {
            '"' => quoted = !quoted,
            '[' if !quoted => depth += 1,
            ']' if !quoted => depth = depth.saturating_sub(1),
            _ => {}
        }
        !quoted && (it == ';' || it == '}' || it == '\n' && depth == 0)
    })
    .map(Statement)
}

impl Graph {
    fn add(&mut self, statement: &str, line: usize, file: &str) -> Result<(), Refusal> {
        let statement = statement.trim_end_matches([';', '}']).trim();
        let (what, label) = match statement.split_once('[') {
            Some((what, rest)) => (what.trim(), label(rest)),
            None => (statement, None),
        };
        if what.is_empty() {
            return Ok(());
        }
        if let Some((from, to)) = what.split_once("--").or_else(|| what.split_once("->")) {
            let ends = [id(from)?, id(to)?];
            let cost = label.and_then(|label| label.trim().parse().ok());
            self.edges.push(Edge { ends, cost: cost.filter(|it: &f64| it.is_finite()), line });
        } else if let Some(label) = label.filter(|_| what.as_bytes()[0].is_ascii_digit()) {
            let name = label.rsplit("::").next().unwrap_or_default();
            // The base station's vertex is called BaseStation, its model in the scene base_station.
            let name = if name == "BaseStation" { "base_station" } else { name };
            self.vertices.push(Vertex { id: id(what)?, name: name.to_owned(), line });
        } else {
            let text = format!("\"{}\" is passed over", shortened(what));
            self.warnings.push(Warning { place: Some(line_of(file, line)), text });
        }
        if self.vertices.len() > MOST_TILES || self.edges.len() > 8 * MOST_TILES {
            let wrong = format!("the graph has more than {MOST_TILES} tiles");
            return Err(Refusal::new(wrong, "give a smaller world"));
        }
        Ok(())
    }
}

fn shortened(text: &str) -> String {
    text.chars().take(40).filter(|it| !it.is_control()).collect()
}

fn id(text: &str) -> Result<u32, Refusal> {
    text.trim().parse().map_err(|_| {
        let wrong = format!("\"{}\" is no vertex", shortened(text.trim()));
        Refusal::new(wrong, "give the number of one")
    })
}

/// The value of the attribute `label`.
fn label(attributes: &str) -> Option<&str> {
    let (_, rest) = attributes.split_once("label")?;
    let value = rest.trim_start().strip_prefix('=')?.trim_start();
    match value.strip_prefix('"') {
        Some(quoted) => quoted.split('"').next(),
        None => value.split([']', ',', ';', ' ']).next(),
    }
}
