//! Remarks on the parts of a survey that nothing joins to what has a place.

use crate::adjust::Network;
use crate::draft::Draft;
use crate::survey::StationId;

impl Draft {
    /// Says of each part that no leg joins to a fixed point, by the name of one of its stations, that
    /// it is left out. `cavern` does so since its version 1.4.10.
    pub(crate) fn remark_on_parts(
        &mut self,
        network: &Network,
        points: &[usize],
        reached: &[bool],
    ) {
        let mut at: Vec<Vec<StationId>> = vec![Vec::new(); network.at.len()];
        for (station, &point) in points.iter().enumerate() {
            if self.stations[station].is_used && !reached[point] {
                at[point].push(station);
            }
        }
        let mut seen = reached.to_vec();
        for point in 0..at.len() {
            if at[point].is_empty() || std::mem::replace(&mut seen[point], true) {
                continue;
            }
            let mut queue = vec![point];
            let mut part: Vec<StationId> = Vec::new();
            while let Some(point) = queue.pop() {
                part.extend(&at[point]);
                network.spread(point, &mut seen, &mut queue);
            }
            self.remark_on_part(&part);
        }
    }

    fn remark_on_part(&mut self, part: &[StationId]) {
        let is_named = |station: &&StationId| !self.stations[**station].name.is_empty();
        let named = part.iter().filter(is_named).min();
        let Some(&first) = named.or_else(|| part.first()) else { return };
        let others = match part.len() - 1 {
            0 => String::new(),
            1 => " and 1 other".into(),
            more => format!(" and {more} others"),
        };
        let begin = self.first.filter(|_| self.fixes.is_empty());
        let what = begin.map_or_else(|| "a fixed one".into(), |begin| self.shown(begin));
        let text =
            format!("no leg joins {}{others} to {what}: they are left out", self.shown(first));
        let source = self.stations[first].source;
        self.warn(source, 0, text);
    }

    /// A station as remarks call it.
    pub(crate) fn shown(&self, station: StationId) -> String {
        match &*self.stations[station].name {
            "" => "a station without a name".into(),
            name => format!("station \"{name}\""),
        }
    }
}
