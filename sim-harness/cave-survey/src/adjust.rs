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

    /// Whether links lead from a fixed point to each point.
    fn reached(&self) -> Vec<bool> {
        let mut reached: Vec<bool> = self.fixed.iter().map(Option::is_some).collect();
        let mut queue: Vec<usize> = (0..reached.len()).filter(|&point| reached[point]).collect();
        while let Some(point) = queue.pop() {
            self.spread(point, &mut reached, &mut queue);
        }
        reached
    }

    /// The network of the links between points that are `reached`.
    fn of_reached(self, reached: &[bool]) -> Self {
        let at = vec![Vec::new(); self.at.len()];
        let mut network = Self { links: Vec::new(), at, fixed: self.fixed };
        for link in self.links {
            if reached[link.ends[0]] {
                network.add(link);
            }
        }
        network
    }

    /// Notes the points next to one that are not noted yet.
    pub(crate) fn spread(&self, point: usize, noted: &mut [bool], queue: &mut Vec<usize>) {
        for &link in &self.at[point] {
            let other = self.links[link].other(point);
            if !std::mem::replace(&mut noted[other], true) {
                queue.push(other);
            }
        }
    }
}

impl Draft {
    /// Computes the positions.
    pub(crate) fn adjusted(mut self) -> Result<Survey, Refusal> {
        if self.legs.is_empty() && self.equates.is_empty() && self.fixes.is_empty() {
            let source = Source { file: 0, line: 0 };
            return Err(self.wrong(source, "there are no legs in it", "give a survey with legs"));
        }
        let (points, count) = self.points();
        let mut network = self.network(&points, count);
        self.place_fixes(&mut network, &points)?;
        let reached = network.reached();
        self.remark_on_parts(&network, &points, &reached);
        let network = network.of_reached(&reached);
        let Some(positions) = positions(&network) else {
            let wrong = "its loops are too many, and too entangled, to adjust together";
            return Err(self.wrong(Source::default(), wrong, "give a part of it"));
        };
        let (loops, worst) = self.loops(&network, &points);
        Ok(self.finish(&points, &positions, &reached, loops, worst))
    }

    /// The number of the point of each station, and how many points there are.
    fn points(&self) -> (Vec<usize>, usize) {
        let mut sets = Sets::new(self.stations.len());
        for &(a, b, _) in &self.equates {
            sets.join(a, b);
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
        (points, count)
    }

    fn network(&self, points: &[usize], count: usize) -> Network {
        let mut network =
            Network { at: vec![Vec::new(); count], fixed: vec![None; count], ..Network::default() };
        for leg in &self.legs {
            let DraftLeg { from, to, vector, covariance, length, .. } = *leg;
            let ends = [points[from], points[to]];
            network.add(Link { ends, vector, covariance, length });
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
                network.add(Link { ends, vector, covariance, length: 0.0 });
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
            && let Some(first) = self.first
        {
            network.fixed[points[first]] = Some([0.0; 3]);
            if self.is_on_earth {
                let name = self.shown(first);
                let text = format!("no station is fixed, so that {name} is put at 0, 0, 0");
                self.warn(self.stations[first].source, 0, text);
            }
        }
        Ok(())
    }

    /// The number of loops as `cavern` counts them, and the one with the largest closing error.
    fn loops(&self, network: &Network, points: &[usize]) -> (usize, Option<loops::Worst>) {
        let mut sets = Sets::new(network.fixed.len());
        let legs = self.legs.iter().map(|leg| [points[leg.from], points[leg.to]]);
        // A leg closes a loop where its ends hang together without it.
        let loops = legs.filter(|&[from, to]| !sets.join(from, to)).count();
        (loops, loops::worst(network))
    }

    fn finish(
        mut self,
        points: &[usize],
        positions: &[Vector],
        reached: &[bool],
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
            let point = points[number];
            if (!station.is_used && !fixed[number]) || !reached[point] {
                continue;
            }
            numbers[number] = Some(stations.len());
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
            passage.into_iter().filter_map(there).collect::<Vec<_>>()
        });
        let misclosure = worst.map(|worst| {
            worst.named(|point| {
                let station = called.get(point).copied().flatten();
                station.map_or_else(String::new, |n: usize| stations[n].name.clone())
            })
        });
        Survey {
            title: self.title,
            passages: passages.filter(|passage| !passage.is_empty()).collect(),
            stations,
            legs,
            loops,
            misclosure,
            warnings: self.warnings,
            files: self.files,
        }
    }
}
