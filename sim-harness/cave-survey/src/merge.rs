//! Takes the survey of another format into the one that includes it.

use crate::draft::{Draft, DraftLeg, Fix};
use crate::error::Refusal;
use crate::survey::{CrossSection, Source, StationId};

impl Draft {
    /// Adds all that another draft has. `renamed` gives its stations their names here.
    pub(crate) fn merge(
        &mut self,
        other: Self,
        renamed: impl Fn(&str) -> String,
    ) -> Result<(), Refusal> {
        let offset = u32::try_from(self.files.len()).unwrap_or(u32::MAX);
        let moved = |source: Source| Source { file: source.file.saturating_add(offset), ..source };
        self.files.extend(other.files);
        let mut here: Vec<StationId> = Vec::with_capacity(other.stations.len());
        for station in &other.stations {
            let source = moved(station.source);
            let id = match &*station.name {
                "" => self.anonymous(station.is_wall, source),
                name => self.station(&renamed(name), source).0,
            };
            self.stations[id].is_entrance |= station.is_entrance;
            here.push(id);
        }
        self.end_repeats();
        if let Some(first) = other.first {
            self.first.get_or_insert(here[first]);
        }
        for leg in other.legs {
            let (from, to, source) = (here[leg.from], here[leg.to], moved(leg.source));
            self.leg(DraftLeg { from, to, source, ..leg }, false)?;
            // Repeated legs are averaged already.
            self.end_repeats();
        }
        for (a, b, source) in other.equates {
            self.equate(here[a], here[b], moved(source));
        }
        for (a, b, flags, source) in other.unmeasured {
            self.sight(here[a], here[b], flags, moved(source));
        }
        for fix in other.fixes {
            let (station, source) = (here[fix.station], moved(fix.source));
            self.fix(Fix { station, source, ..fix });
        }
        for passage in other.passages {
            let there = |(section, source): (CrossSection, Source)| {
                (CrossSection { station: here[section.station], ..section }, moved(source))
            };
            self.passages.push(passage.into_iter().map(there).collect());
        }
        let kept = crate::draft::MOST_WARNINGS.saturating_sub(self.warnings.len());
        self.warnings.extend(other.warnings.into_iter().take(kept));
        Ok(())
    }
}
