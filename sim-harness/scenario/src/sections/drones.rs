//! The section `[drones]` of a scenario file: the drones that fly, and where they start.

use input::InputError;
use input::reader::{At, Reader};
use maps::sites::usual_base;
use maps::tunnel::PlaceKey;
use serde::Deserialize;
use units::Role;
use world::{ROW_SPACING_M, Spot, Tunnel};

/// The drones of a mission. Explorers have the lowest numbers, then come the relays; the base has
/// the largest.
#[derive(Clone, Debug)]
pub struct Drones {
    /// How many drones fly as the operator says: the head, which is drone 0, and those after it.
    pub explorers: usize,
    /// How many relays there are between explorers and base.
    pub relays: usize,
    /// Where the base stands.
    pub base: Spot,
    /// Where the drones start.
    pub start: Start,
    /// Whether the drones are fetched after the mission, so that none keeps charge for the way home.
    pub fetched: bool,
}

impl Drones {
    /// The number of drones that fly.
    #[must_use]
    pub const fn flying(&self) -> usize {
        self.explorers + self.relays
    }

    /// How far from the base the head takes off, m: at the far end of the row in which the drones stand
    /// at the mouth. 0 where they begin in the air.
    #[must_use]
    pub fn row_m(&self) -> f32 {
        match self.start {
            Start::Mouth => Start::SPACING * self.flying() as f32,
            Start::Random { .. } | Start::Placed(_) => 0.0,
        }
    }

    /// How many members the mission has, base included.
    #[must_use]
    pub const fn members(&self) -> usize {
        self.flying() + 1
    }

    /// The role of the member of that number.
    #[must_use]
    pub const fn role(&self, member: usize) -> Role {
        if member < self.explorers {
            Role::Head
        } else if member < self.flying() {
            Role::Relay
        } else {
            Role::Base
        }
    }
}

/// Where the drones start.
#[derive(Clone, Debug, PartialEq)]
pub enum Start {
    /// On the ground before the base, in a row along the main gallery.
    Mouth,
    /// In the air: the head here, the relays anywhere on the way between it and the base.
    Random {
        /// The head's place.
        head: Spot,
    },
    /// In the air at these places, in the order of their numbers: explorers first, then relays.
    Placed(Vec<Spot>),
}

impl Start {
    /// Distance between drones that stand in a row at the mouth, in metres.
    pub const SPACING: f32 = ROW_SPACING_M;
    /// The least distance between drones at random places, in metres.
    pub const APART: f32 = 0.5;
}

/// The table `[drones]`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct DronesTable {
    explorers: Option<At<usize>>,
    relays: At<usize>,
    base: Option<At<PlaceKey>>,
    start: Option<StartKey>,
    head_m: Option<At<PlaceKey>>,
    at_m: Option<At<Vec<PlaceKey>>>,
    fetched: Option<bool>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum StartKey {
    Mouth,
    Random,
    Placed,
}

/// The numbers of explorers and relays, and the place of the base.
struct Crew {
    explorers: usize,
    relays: usize,
    base: Spot,
}

/// The most explorers and relays together: a chain without its base.
pub const MOST_DRONES: usize = chain::neighbours::MAX_NEIGHBOURS;

impl DronesTable {
    /// Takes another number of relays than the file's.
    pub(crate) fn change_relays(&mut self, relays: usize) {
        *self.relays.get_mut() = relays;
    }

    /// Checks the section.
    pub(crate) fn read(
        drones: &At<Self>,
        tunnel: &Tunnel,
        reader: &Reader<'_>,
    ) -> Result<Drones, InputError> {
        let table = drones.as_ref();
        let explorers = match &table.explorers {
            None => 1,
            Some(count) if (1..=MOST_DRONES).contains(count.as_ref()) => *count.as_ref(),
            Some(count) => {
                let wrong = format!("explorers = {} is out of range", count.as_ref());
                let remedy = format!("give a number from 1 to {}", MOST_DRONES);
                return Err(reader.wrong(count, wrong, remedy));
            }
        };
        let relays = *table.relays.as_ref();
        let most = MOST_DRONES - explorers;
        if relays > most {
            let remedy = format!("give at most {most}: a chain has 16 members");
            return Err(reader.wrong(
                &table.relays,
                format!("relays = {relays} are too many"),
                remedy,
            ));
        }
        let base = match &table.base {
            None => usual_base(tunnel),
            Some(key) => key.as_ref().spot(key, "base", 0.0, tunnel, reader)?,
        };
        let crew = Crew { explorers, relays, base };
        let start = start(drones, &crew, tunnel, reader)?;
        Ok(Drones { explorers, relays, base, start, fetched: table.fetched.unwrap_or(false) })
    }
}

fn start(
    drones: &At<DronesTable>,
    crew: &Crew,
    tunnel: &Tunnel,
    reader: &Reader<'_>,
) -> Result<Start, InputError> {
    let table = drones.as_ref();
    let flying = crew.explorers + crew.relays;
    match (table.start.unwrap_or(StartKey::Mouth), &table.head_m, &table.at_m) {
        (StartKey::Mouth, None, None) => {
            let row = Start::SPACING * flying as f32;
            let edge = tunnel.skeleton().edge(crew.base.on.edge);
            let length = edge.line().length() - crew.base.on.along;
            if row <= length {
                return Ok(Start::Mouth);
            }
            let wrong = format!("{} relays and the head need {row} m in a row", crew.relays);
            Err(reader.wrong(drones, wrong, format!("the tunnel has {length} m; use fewer")))
        }
        (StartKey::Random, Some(head), None) if crew.explorers == 1 => {
            let spot = head.as_ref().spot(head, "head_m", 1.0, tunnel, reader)?;
            let way = tunnel.skeleton().distance(crew.base.on, spot.on).0;
            if way >= 3.0 * Start::APART * flying as f32 {
                return Ok(Start::Random { head: spot });
            }
            let wrong = format!("{} relays do not fit before head_m = {way}", crew.relays);
            Err(reader.wrong(head, wrong, "move the head farther in or use fewer relays"))
        }
        (StartKey::Random, Some(_), None) => {
            let wrong = "start = \"random\" is for one explorer".into();
            Err(reader.wrong(drones, wrong, "give start = \"placed\" and at_m"))
        }
        (StartKey::Placed, None, Some(at)) => placed(at, crew, tunnel, reader),
        _ => Err(reader.wrong(
            drones,
            "start, head_m and at_m do not go together".into(),
            "start = \"mouth\" takes neither, \"random\" takes head_m, \"placed\" takes at_m",
        )),
    }
}

fn placed(
    at: &At<Vec<PlaceKey>>,
    crew: &Crew,
    tunnel: &Tunnel,
    reader: &Reader<'_>,
) -> Result<Start, InputError> {
    let keys = at.as_ref().iter();
    let spots = keys.map(|key| key.spot(at, "at_m", 0.0, tunnel, reader));
    let spots = spots.collect::<Result<Vec<_>, _>>()?;
    let (base, skeleton) = (crew.base.on, tunnel.skeleton());
    let way = |spot: &Spot| skeleton.distance(base, spot.on).0;
    let falls = |pair: &[Spot]| {
        way(&pair[0]) > way(&pair[1]) || !skeleton.in_line(base, pair[0].on, pair[1].on)
    };
    let in_order = spots.windows(2).all(falls) && spots.iter().all(|spot| way(spot) > 0.0);
    let wanted = crew.explorers + crew.relays;
    if spots.len() == wanted && in_order {
        return Ok(Start::Placed(spots));
    }
    let remedy = format!(
        "give {wanted} places, the head's first, each nearer to the base than the one before \
         it, or in another gallery"
    );
    Err(reader.wrong(at, "at_m does not place every drone in order".into(), remedy))
}
