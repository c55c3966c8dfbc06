//! Straightens centre-lines that turn back within one open space.
//!
//! Cavers shoot from wall to wall of a chamber and over the same floor on several levels, so that the
//! line of a survey may be metres from where it was with tens of metres of line between. In a floor
//! plan that is one space, which a drone crosses: two drones in it that see one another would be far
//! apart along the line. Where two places of a centre-line see one another and the line between them
//! is much longer than the straight one, the centre-line leads straight.

use units::Point2;

use super::{Edge, Polyline, Skeleton};

/// The distance between the places that are compared, m.
const STEP_M: f32 = 0.5;

/// The farthest places that are compared, m: no chamber of a survey is wider than two of the widest
/// sides that count there, 8 m each.
const FARTHEST_M: f32 = 16.0;

/// A line is too long when it is more than this many straight lines and a width: that of a right angle
/// is shorter.
const TOO_LONG: f32 = 1.5;

/// Points of a line nearer to each other than this are one, m.
const SAME_M: f32 = 1e-3;

/// Two places of an edge, the earlier first.
type Stretch = [f32; 2];

impl Skeleton {
    /// The skeleton with centre-lines that do not turn back in the open, where `sees` says whether two
    /// points see one another.
    pub(crate) fn straightened(self, sees: impl Fn(Point2, Point2) -> bool) -> Self {
        let Self { mut edges, mut nodes, .. } = self;
        for n in 0..edges.len() {
            while let Some(stretch) = longest(&edges[n], |stretch| {
                let [from, to] = stretch.map(|along| edges[n].line.at(along).0);
                sees(from, to) && are_ends(&edges, n, stretch)
            }) {
                cut(&mut edges, n, stretch);
                for joint in &edges[n].joints {
                    nodes[joint.node].at = edges[n].line.at(joint.along).0;
                }
                attach(&mut edges, n);
            }
        }
        Self::finished(edges, nodes)
    }
}

/// The stretch of an edge that is too long by the most, of those that may be cut.
fn longest(edge: &Edge, may_be_cut: impl Fn(Stretch) -> bool) -> Option<Stretch> {
    let count = (edge.line.length() / STEP_M) as usize;
    let places: Vec<f32> = (0..=count).map(|n| n as f32 * STEP_M).collect();
    let points: Vec<Point2> = places.iter().map(|along| edge.line.at(*along).0).collect();
    let mut best: (f32, Option<Stretch>) = (0.0, None);
    for to in 0..places.len() {
        for from in 0..to {
            let straight = points[from].distance(points[to]).0;
            let excess = places[to] - places[from] - TOO_LONG * straight - edge.width;
            let stretch = [places[from], places[to]];
            let is_far = !(SAME_M..FARTHEST_M).contains(&straight);
            if excess > best.0 && !is_far && may_be_cut(stretch) {
                best = (excess, Some(stretch));
            }
        }
    }
    best.1
}

/// Whether every other gallery that joins this stretch of an edge begins or ends there.
fn are_ends(edges: &[Edge], edge: usize, [from, to]: Stretch) -> bool {
    let inner = edges[edge].joints.iter().filter(|joint| from < joint.along && joint.along < to);
    inner.into_iter().all(|joint| {
        let others = edges.iter().enumerate().filter(|(n, _)| *n != edge);
        others.into_iter().all(|(_, other)| {
            let here = other.joints.iter().filter(|it| it.node == joint.node);
            let length = other.line.length();
            here.into_iter().all(|it| it.along <= SAME_M || it.along >= length - SAME_M)
        })
    })
}

/// Replaces a stretch of an edge by the straight line.
fn cut(edges: &mut [Edge], edge: usize, [from, to]: Stretch) {
    let Edge { line, joints, .. } = &mut edges[edge];
    let (a, b) = (line.at(from).0, line.at(to).0);
    let straight = a.distance(b).0;
    let part = |at: Point2| {
        let along = (at.x - a.x) * (b.x - a.x) + (at.y - a.y) * (b.y - a.y);
        (along / (straight * straight)).clamp(0.0, 1.0)
    };
    for joint in joints.iter_mut() {
        if joint.along >= to {
            joint.along += straight - (to - from);
        } else if joint.along > from {
            joint.along = from + part(line.at(joint.along).0) * straight;
        }
    }
    joints.sort_by(|a, b| a.along.total_cmp(&b.along));
    let lengths = (0..line.points().len()).map(|n| line.length_at(n));
    let known = lengths.zip(line.points().iter().copied());
    let before = known.clone().filter(|(along, _)| *along < from).map(|(_, at)| at);
    let after = known.filter(|(along, _)| *along > to).map(|(_, at)| at);
    let mut points: Vec<Point2> = before.chain([a, b]).chain(after).collect();
    points.dedup_by(|a, b| a.distance(*b).0 < SAME_M);
    *line = Polyline::new(points);
}

/// Lets the galleries that end at the nodes of an edge end where these are now.
fn attach(edges: &mut [Edge], edge: usize) {
    let nodes: Vec<_> =
        edges[edge].joints.iter().map(|it| (it.node, edges[edge].line.at(it.along).0)).collect();
    let others = edges.iter_mut().enumerate().filter(|(n, _)| *n != edge);
    for (_, other) in others {
        for (node, at) in &nodes {
            let Some(n) = other.joints.iter().position(|joint| joint.node == *node) else {
                continue;
            };
            let gap = other.line.at(other.joints[n].along).0.distance(*at).0;
            if gap <= SAME_M {
                continue;
            }
            if other.joints[n].along <= SAME_M {
                other.line = other.line.prepended(*at);
                other.joints.iter_mut().for_each(|joint| joint.along += gap);
                other.joints[n].along = 0.0;
            } else {
                other.line = other.line.appended(*at);
                other.joints[n].along = other.line.length();
            }
        }
    }
}
