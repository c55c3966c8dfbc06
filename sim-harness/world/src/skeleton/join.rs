//! Joins galleries to edges that meet in nodes.

use units::Point2;

use super::super::polyline::Foot;
use super::{Edge, Gallery, Joint, Node, NodeKind, Polyline};

/// Joints nearer to each other than this are one node, m.
const SAME_NODE: f32 = 1e-3;

/// Edges and nodes of these galleries.
pub(super) fn join(galleries: &[Gallery]) -> (Vec<Edge>, Vec<Node>) {
    let mut graph = Graph::default();
    for gallery in galleries {
        graph.add(gallery);
    }
    for edge in &mut graph.edges {
        edge.joints.sort_by(|a, b| a.along.total_cmp(&b.along));
    }
    (graph.edges, graph.nodes)
}

#[derive(Default)]
struct Graph {
    edges: Vec<Edge>,
    nodes: Vec<Node>,
}

/// The place at which the end of a new gallery meets an earlier one.
#[derive(Clone, Copy)]
struct Contact {
    edge: usize,
    along: f32,
    /// The distance from the end to the earlier gallery's line, m.
    gap: f32,
}

impl Graph {
    fn add(&mut self, gallery: &Gallery) {
        let mut line = Polyline::new(gallery.centre_line.clone());
        let [mut begin, mut end] = [line.at(0.0).0, line.at(line.length()).0]
            .map(|point| self.contact(point).map(|contact| (contact, self.touches(&contact))));
        let crosses = self.edges.iter().any(|edge| !line.crossings(&edge.line).is_empty());
        let touches = |it: &Option<(Contact, bool)>| it.is_some_and(|(_, touches)| touches);
        if !touches(&begin) && !touches(&end) && !crosses {
            // Without a crossing or a near end, the nearer end is joined at any distance.
            let gap = |it: &Option<(Contact, bool)>| it.map_or(f32::INFINITY, |(c, _)| c.gap);
            let nearer = if gap(&end) < gap(&begin) { &mut end } else { &mut begin };
            if let Some((_, touches)) = nearer {
                *touches = true;
            }
        }
        let [begin, end] = [begin, end].map(|it| it.filter(|(_, joins)| *joins).map(|(c, _)| c));
        if let Some(contact) = begin.filter(|contact| contact.gap > SAME_NODE) {
            line = line.prepended(self.edges[contact.edge].line.at(contact.along).0);
        }
        if let Some(contact) = end.filter(|contact| contact.gap > SAME_NODE) {
            line = line.appended(self.edges[contact.edge].line.at(contact.along).0);
        }
        let length = line.length();
        let mut joints = vec![
            self.end_joint(begin, 0.0, line.at(0.0).0),
            self.end_joint(end, length, line.at(length).0),
        ];
        for (number, (mine, theirs)) in self.crossings(&line) {
            // Where an end joins the other gallery, the lines often cross once more beside it.
            let width = 0.5 * (gallery.width + self.edges[number].width);
            let meets = |joint: &Joint| {
                self.edges[number].joints.iter().any(|theirs| theirs.node == joint.node)
            };
            let known = |joint: &Joint| meets(joint) && (joint.along - mine).abs() < width;
            if !joints.iter().any(known) {
                let node = self.junction(number, theirs);
                joints.push(Joint { node, along: mine });
            }
        }
        self.edges.push(Edge {
            name: gallery.name.clone(),
            line,
            width: gallery.width,
            joints,
            has_shortcut: false,
        });
    }

    /// The nearest point of any earlier gallery.
    fn contact(&self, point: Point2) -> Option<Contact> {
        let feet = self.edges.iter().enumerate().map(|(n, edge)| (n, edge.line.nearest(point)));
        let (edge, Foot { along, off_squared }) =
            feet.min_by(|a, b| a.1.off_squared.total_cmp(&b.1.off_squared))?;
        Some(Contact { edge, along, gap: off_squared.sqrt() })
    }

    /// Whether the end lies within the earlier gallery.
    fn touches(&self, contact: &Contact) -> bool {
        contact.gap <= 0.5 * self.edges[contact.edge].width + SAME_NODE
    }

    fn end_joint(&mut self, contact: Option<Contact>, along: f32, at: Point2) -> Joint {
        let node = match contact {
            Some(contact) => self.junction(contact.edge, contact.along),
            None => {
                let kind = if self.nodes.is_empty() { NodeKind::Mouth } else { NodeKind::End };
                self.nodes.push(Node { at, kind });
                self.nodes.len() - 1
            }
        };
        Joint { node, along }
    }

    /// The node at this place of an earlier edge, which another edge joins.
    fn junction(&mut self, edge: usize, along: f32) -> usize {
        let known = |joint: &&Joint| (joint.along - along).abs() < SAME_NODE;
        if let Some(joint) = self.edges[edge].joints.iter().find(known) {
            let node = joint.node;
            if self.nodes[node].kind == NodeKind::End {
                self.nodes[node].kind = NodeKind::Junction;
            }
            return node;
        }
        let node = self.nodes.len();
        let at = self.edges[edge].line.at(along).0;
        self.nodes.push(Node { at, kind: NodeKind::Junction });
        self.edges[edge].joints.push(Joint { node, along });
        node
    }

    fn crossings(&self, line: &Polyline) -> Vec<(usize, (f32, f32))> {
        let of = |(n, edge): (usize, &Edge)| {
            line.crossings(&edge.line).into_iter().map(move |pair| (n, pair)).collect::<Vec<_>>()
        };
        self.edges.iter().enumerate().flat_map(of).collect()
    }
}
