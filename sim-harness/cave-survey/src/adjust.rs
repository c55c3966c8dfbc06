//! Gives the stations of a draft their positions.
//!
//! Where legs form loops, or lead from one fixed station to another, they contradict each other a
//! little. The positions are those of least squares, in which each leg counts by the inverse of its
//! covariance: what `cavern` computes too.

use crate::draft::{Draft, DraftLeg};
use crate::error::Refusal;
use crate::loops;
use crate::matrix::{self, Matrix, Vector};
use crate::sets::Sets;
use crate::survey::{CrossSection, Leg, Source, Station, Survey};
use crate::traverse::positions;

/// A leg of the network between points.
#[derive(Clone, Debug)]
pub(crate) struct Link {
    pub(crate) ends: [usize; 2],
    pub(crate) vector: Vector,
    pub(crate) covariance: Matrix,
    pub(crate) length: f64,
    /// Whether it stands for a position that is not exact, and no leg.
    pub(crate) is_tie: bool,
}

impl Link {
    /// The end that is not `point`.
    pub(crate) fn other(&self, point: usize) -> usize {
        if self.ends[0] == point { self.ends[1] } else { self.ends[0] }
    }

    /// The vector from `point` to the other end.
    pub(crate) fn vector_from(&self, point: usize) -> Vector {
        if self.ends[0] == point { self.vector } else { matrix::scaled(self.vector, -1.0) }
    }
}

/// Points and links, with the points that are fixed.
#[derive(Debug, Default)]
pub(crate) struct Network {
    pub(crate) links: Vec<Link>,
    /// The numbers of the links at each point.
    pub(crate) at: Vec<Vec<usize>>,
    pub(crate) fixed: Vec<Option<Vector>>,
}

impl Network {
    fn add(&mut self, link: Link) {
        let number = self.links.len();
        for &end in &link.ends {
            self.at[end].push(number);
        }
        self.links.push(link);
    }
}

impl Draft {
    /// Computes the positions.
    pub(crate) fn adjusted(mut self) -> Result<Survey, Refusal> {
        if self.legs.is_empty() && self.equates.is_empty() && self.fixes.is_empty() {
            let source = Source { file: 0, line: 0 };
            return Err(self.wrong(source, "there are no legs in it", "give a survey with legs"));
        }
        let (points, count, joined) = self.points();
        let mut network = self.network(&points, count);
        self.place_fixes(&mut network, &points)?;
        self.require_connection(&network, &points)?;
        let Some(positions) = positions(&network) else {
            let wrong = "its loops are too many, and too entangled, to adjust together";
            return Err(self.wrong(Source::default(), wrong, "give a part of it"));
        };
        let (loops, worst) = self.loops(&network, joined, &points);
        Ok(self.finish(&points, &positions, loops, worst))
    }

    /// The number of the point of each station, how many points there are, and how many equates
    /// joined what was apart.
    fn points(&self) -> (Vec<usize>, usize, usize) {
        let mut sets = Sets::new(self.stations.len());
        let mut joined = 0;
        for &(a, b, _) in &self.equates {
            joined += usize::from(sets.join(a, b));
        }
        let mut numbers = vec![usize::MAX; self.stations.len()];
        let mut count = 0;
        let mut points = Vec::with_capacity(self.stations.len());
        for station in 0..self.stations.len() {
            let root = sets.root(station);
            if numbers[root] == usize::MAX {
                numbers[root] = count;
                count += 1;
            }
            points.push(numbers[root]);
        }
        (points, count, joined)
    }

    fn network(&self, points: &[usize], count: usize) -> Network {
        let mut network =
            Network { at: vec![Vec::new(); count], fixed: vec![None; count], ..Network::default() };
        for leg in &self.legs {
            let DraftLeg { from, to, vector, covariance, length, .. } = *leg;
            let ends = [points[from], points[to]];
            network.add(Link { ends, vector, covariance, length, is_tie: false });
        }
        network
    }

    fn place_fixes(&mut self, network: &mut Network, points: &[usize]) -> Result<(), Refusal> {
        let mut by: Vec<Option<usize>> = vec![None; network.fixed.len()];
        for number in 0..self.fixes.len() {
            let fix = self.fixes[number].clone();
            let name = self.stations[fix.station].name.clone();
            if !self.stations[fix.station].is_used && !fix.is_reference {
                self.warn(fix.source, 0, format!("the fixed station \"{name}\" is used by no leg"));
            }
            let point = points[fix.station];
            if let Some(covariance) = fix.covariance {
                network.at.push(Vec::new());
                network.fixed.push(Some(fix.at));
                let ends = [network.at.len() - 1, point];
                let vector = [0.0; 3];
                network.add(Link { ends, vector, covariance, length: 0.0, is_tie: true });
                continue;
            }
            match (network.fixed[point], by[point]) {
                (Some(other), Some(first)) if other != fix.at => {
                    let wrong = format!("\"{name}\" is fixed at two places");
                    let first = self.place(self.fixes[first].source, 0);
                    let remedy = match first {
                        Some(place) => format!("remove one of them; the other is at {place}"),
                        None => "remove one of them".into(),
                    };
                    return Err(self.wrong(fix.source, wrong, remedy));
                }
                (Some(_), _) => {
                    self.warn(fix.source, 0, format!("\"{name}\" is fixed twice at one place"));
                }
                (None, _) => {
                    network.fixed[point] = Some(fix.at);
                    by[point] = Some(number);
                }
            }
        }
        if self.fixes.is_empty()
            && !self.is_on_earth
            && let Some(first) = self.first
        {
            network.fixed[points[first]] = Some([0.0; 3]);
        }
        Ok(())
    }

    /// Refuses a network in which some point is joined to no fixed one.
    fn require_connection(&self, network: &Network, points: &[usize]) -> Result<(), Refusal> {
        let mut reached = vec![false; network.at.len()];
        let mut queue: Vec<usize> = Vec::new();
        for (point, _) in network.fixed.iter().enumerate().filter(|(_, fixed)| fixed.is_some()) {
            reached[point] = true;
            queue.push(point);
        }
        while let Some(point) = queue.pop() {
            for &link in &network.at[point] {
                let other = network.links[link].other(point);
                if !std::mem::replace(&mut reached[other], true) {
                    queue.push(other);
                }
            }
        }
        let used = |station: usize| self.stations[station].is_used;
        let mut lost = (0..self.stations.len()).filter(|&n| used(n) && !reached[points[n]]);
        let Some(first) = lost.next() else { return Ok(()) };
        let more = lost.count();
        let station = &self.stations[first];
        let others = if more == 0 { String::new() } else { format!(" and {more} other stations") };
        let what = match self.first.filter(|_| self.fixes.is_empty() && !self.is_on_earth) {
            Some(begin) => format!("\"{}\"", self.stations[begin].name),
            None => "a fixed one".into(),
        };
        let remedy = "add the leg, *equate or *fix that joins them";
        let wrong = format!("no leg joins station \"{}\"{others} to {what}", station.name);
        Err(self.wrong(station.source, wrong, remedy))
    }

    /// The number of loops as `cavern` counts them, and the one with the largest closing error.
    fn loops(
        &self,
        network: &Network,
        joined: usize,
        points: &[usize],
    ) -> (usize, Option<loops::Worst>) {
        let names = self.stations.iter().filter(|station| station.is_used).count();
        let mut fixed: Vec<bool> = network.fixed.iter().map(Option::is_some).collect();
        let ties = network.links.iter().filter(|link| link.is_tie).count();
        // The far end of a tie is no station of the survey: the near one counts for it.
        for tie in network.links.iter().filter(|link| link.is_tie) {
            fixed[tie.ends[1]] = true;
        }
        // A fixed station that nothing uses counts neither as a station nor as a component.
        for (station, point) in self.stations.iter().zip(points) {
            fixed[*point] &= station.is_used;
        }
        let components = self.components(points, &fixed);
        let legs = network.links.len() - ties + joined;
        ((legs + components).saturating_sub(names), loops::worst(network))
    }

    fn finish(
        mut self,
        points: &[usize],
        positions: &[Vector],
        loops: usize,
        worst: Option<loops::Worst>,
    ) -> Survey {
        let mut fixed = vec![false; self.stations.len()];
        for fix in &self.fixes {
            fixed[fix.station] = true;
        }
        let mut numbers = vec![None; self.stations.len()];
        let mut stations = Vec::new();
        let mut called = vec![None; positions.len()];
        for (number, station) in self.stations.iter_mut().enumerate() {
            if !station.is_used && !fixed[number] {
                continue;
            }
            numbers[number] = Some(stations.len());
            let point = points[number];
            called[point].get_or_insert(stations.len());
            stations.push(Station {
                name: std::mem::take(&mut station.name).into(),
                position: positions[point],
                point,
                is_wall: station.is_wall,
                is_entrance: station.is_entrance,
                source: station.source,
            });
        }
        let mut legs = Vec::with_capacity(self.legs.len());
        for leg in &self.legs {
            let (Some(from), Some(to)) = (numbers[leg.from], numbers[leg.to]) else { continue };
            let length = Some(leg.length.abs());
            legs.push(Leg { from, to, flags: leg.flags, length, source: leg.source });
        }
        for &(a, b, flags, source) in &self.unmeasured {
            let (Some(from), Some(to)) = (numbers[a], numbers[b]) else { continue };
            legs.push(Leg { from, to, flags, length: None, source });
        }
        let passages = std::mem::take(&mut self.passages).into_iter().map(|passage| {
            let there = |(section, _): (CrossSection, Source)| {
                let station = numbers[section.station]?;
                Some(CrossSection { station, ..section })
            };
            passage.into_iter().filter_map(there).collect()
        });
        let misclosure = worst.map(|worst| {
            worst.named(|point| {
                let station = called.get(point).copied().flatten();
                station.map_or_else(String::new, |n: usize| stations[n].name.clone())
            })
        });
        Survey {
            title: self.title,
            passages: passages.collect(),
            stations,
            legs,
            loops,
            misclosure,
            warnings: self.warnings,
            files: self.files,
        }
    }
}
