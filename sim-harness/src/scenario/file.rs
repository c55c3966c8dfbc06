//! The scenario file: what TOML may say, and the checks between it and a [`Scenario`].
//!
//! Nothing is guessed: an unknown key, a number out of its range or a tunnel that cannot be dug is
//! refused with file, line and remedy.

use std::ops::RangeInclusive;
use std::path::Path;

use agent::{AgentConfig, ConfigError};
use chain::policy::PolicyConfig;
use radio_model::{Attenuation, PathLoss, Reception};
use serde::Deserialize;
use toml::Spanned;
use units::{Db, Dbm, Duration, Metres, MetresPerSecond, Order};

use super::{Criteria, Fidelity, PilotStep, Scenario, Start};
use crate::craft::flow::Ground;
use crate::input_error::InputError;
use crate::suggest;
use crate::trace::Point;
use crate::vehicle::VehicleSpec;
use crate::world::layout::{Corridor, GeometryError, LEAST_WIDTH, Layout, Room, outlines};
use crate::world::{CentreLine, Walls};

/// A value with its place in the file.
type At<T> = Spanned<T>;

/// Two numbers, no more and no fewer.
#[derive(Clone, Copy, Deserialize)]
#[serde(try_from = "Vec<f32>")]
struct Pair([f32; 2]);

impl TryFrom<Vec<f32>> for Pair {
    type Error = String;

    fn try_from(numbers: Vec<f32>) -> Result<Self, String> {
        <[f32; 2]>::try_from(numbers)
            .map(Self)
            .map_err(|numbers| format!("expected two numbers, found {}", numbers.len()))
    }
}

fn points(pairs: &[Pair]) -> Vec<Point> {
    pairs.iter().map(|pair| pair.0).collect()
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    title: At<String>,
    duration_s: At<f32>,
    fidelity: Option<At<String>>,
    tunnel: At<TunnelTable>,
    #[serde(default)]
    radio: RadioTable,
    #[serde(default)]
    vehicle: VehicleTable,
    drones: At<DronesTable>,
    #[serde(default)]
    policy: PolicyTable,
    #[serde(default)]
    launch: LaunchTable,
    #[serde(default)]
    retreat: RetreatTable,
    #[serde(default)]
    pilot: Vec<At<PilotTable>>,
    #[serde(default)]
    ground: GroundTable,
    #[serde(default)]
    criteria: CriteriaTable,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct GroundTable {
    light: Option<At<f32>>,
    texture: Option<At<f32>>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct CriteriaTable {
    hold_spread_db: Option<At<f32>>,
    tilt_deg: Option<At<f32>>,
    launched: Option<At<f32>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TunnelTable {
    width_m: At<f32>,
    centre_line_m: Option<At<Vec<Pair>>>,
    winding: Option<At<WindingTable>>,
    #[serde(default)]
    branch: Vec<At<BranchTable>>,
    #[serde(default)]
    room: Vec<At<RoomTable>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WindingTable {
    length_m: At<f32>,
    amplitude_m: At<f32>,
    wavelength_m: At<f32>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BranchTable {
    width_m: f32,
    centre_line_m: Vec<Pair>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RoomTable {
    centre_m: Pair,
    size_m: Pair,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct RadioTable {
    attenuation: Option<AttenuationKey>,
    walls: Option<WallsKey>,
    loss_at_1m_db: Option<At<f32>>,
    noise_variance_db2: Option<At<f32>>,
    resolution_db: Option<At<f32>>,
    packet_loss: Option<At<f32>>,
    latency_s: Option<At<f32>>,
    polling_hz: Option<At<f32>>,
    sensitivity_dbm: Option<At<f32>>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum AttenuationKey {
    WallCount,
    RockDepth,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum WallsKey {
    Rock,
    Paper,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct VehicleTable {
    charge: Option<At<f32>>,
    lag_s: Option<At<f32>>,
    flow_noise_mps: Option<At<f32>>,
    flow_scale_error: Option<At<f32>>,
    radius_m: Option<At<f32>>,
    reach_m: Option<At<f32>>,
    range_noise_m: Option<At<f32>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct DronesTable {
    relays: At<usize>,
    start: Option<StartKey>,
    head_m: Option<At<f32>>,
    at_m: Option<At<Vec<f32>>>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum StartKey {
    Mouth,
    Random,
    Placed,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct PolicyTable {
    name: Option<At<String>>,
    loss_at_1m_db: Option<At<f32>>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct LaunchTable {
    limit_dbm: Option<At<f32>>,
    settled_db: Option<At<f32>>,
    at_once: Option<bool>,
    hold_s: Option<At<f32>>,
    patience_s: Option<At<f32>>,
    arm_delay_s: Option<At<f32>>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct RetreatTable {
    limit_dbm: Option<At<f32>>,
    speed_mps: Option<At<f32>>,
    max_time_s: Option<At<f32>>,
    max_distance_m: Option<At<f32>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PilotTable {
    at_s: At<f32>,
    order: OrderKey,
    speed_mps: Option<At<f32>>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum OrderKey {
    Wait,
    Explore,
    Return,
    Land,
    Stop,
}

/// The named movement policies.
pub(super) fn policy_named(name: &str) -> Option<PolicyConfig> {
    Some(match name {
        "t0" => PolicyConfig::T0,
        "t5" => PolicyConfig::T5,
        "k" => PolicyConfig::K,
        "authors" => PolicyConfig::AUTHORS,
        "default" => PolicyConfig::DEFAULT,
        _ => return None,
    })
}

/// Reads and checks the text of the scenario file at `path`.
pub(super) fn parse(path: &Path, text: &str) -> Result<Scenario, InputError> {
    let reader = Reader { path, text };
    let file: File = toml::from_str(text).map_err(|error| reader.syntax(&error))?;
    let layout = reader.layout(&file.tunnel)?;
    let length = CentreLine::new(layout.main.centre_line.clone()).length();
    let relays = reader.count(&file.drones.as_ref().relays)?;
    let vehicle = reader.vehicle(&file.vehicle)?;
    let (path_loss, reception) = reader.radio(&file.radio)?;
    let name = path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
    let (policy, assumed_loss_at_1m, agent) =
        reader.agent(&file, path_loss.loss_at_1m, &vehicle)?;
    let duration_us = reader.micros(&file.duration_s, "duration_s", 0.2..=86_400.0)?;
    Ok(Scenario {
        name,
        title: file.title.as_ref().clone(),
        duration_us,
        fidelity: reader.fidelity(file.fidelity.as_ref())?,
        layout,
        path_loss,
        reception,
        walls: match file.radio.walls {
            None | Some(WallsKey::Rock) => Walls::Rock,
            Some(WallsKey::Paper) => Walls::Paper,
        },
        datarate: wire::radio::Datarate::Mbit2,
        polling_hz: reader.or(file.radio.polling_hz.as_ref(), "polling_hz", 0.0..=500.0, 0.0)?,
        latency_us: match &file.radio.latency_s {
            Some(value) => reader.micros(value, "latency_s", 0.0..=10.0)?,
            None => 0,
        },
        vehicle,
        ground: reader.ground(&file.ground)?,
        charge: reader.or(file.vehicle.charge.as_ref(), "charge", 0.0..=1.0, 1.0)?,
        relays,
        start: reader.start(&file.drones, relays, length)?,
        agent,
        assumed_loss_at_1m,
        policy,
        pilot: reader.pilot(&file.pilot, duration_us)?,
        criteria: reader.criteria(&file.criteria)?,
    })
}

/// Words of the parser, and those of a person who does not write Rust.
const PLAIN: [(&str, &str); 6] = [
    ("unknown field", "unknown key"),
    ("missing field", "missing key"),
    ("unknown variant", "unknown value"),
    ("expected f32", "expected a number"),
    ("expected usize", "expected a whole number of 0 or more"),
    (" as i128", ""),
];

/// The file under the reader's eyes.
struct Reader<'a> {
    path: &'a Path,
    text: &'a str,
}

impl Reader<'_> {
    fn line_at(&self, byte: usize) -> usize {
        1 + self.text.bytes().take(byte).filter(|&b| b == b'\n').count()
    }

    fn wrong<T>(&self, at: &At<T>, wrong: String, remedy: impl Into<String>) -> InputError {
        InputError::new(wrong, remedy).at_line(self.path, self.line_at(at.span().start))
    }

    /// What the TOML parser has to say, on one line.
    fn syntax(&self, error: &toml::de::Error) -> InputError {
        let message = error.message().lines().collect::<Vec<_>>().join(" ");
        let meant = suggest::question_about(&message);
        let wrong = PLAIN.iter().fold(message, |text, (theirs, ours)| text.replace(theirs, ours));
        let remedy =
            format!("{meant}see the book's chapter \"Scenarios\" for the keys and their types");
        let line = error.span().map_or(1, |span| self.line_at(span.start));
        InputError::new(wrong, remedy).at_line(self.path, line)
    }

    /// A number within `range`.
    fn number(
        &self,
        value: &At<f32>,
        key: &str,
        range: RangeInclusive<f32>,
    ) -> Result<f32, InputError> {
        let number = *value.as_ref();
        if range.contains(&number) {
            return Ok(number);
        }
        let remedy = format!("give a number from {} to {}", range.start(), range.end());
        Err(self.wrong(value, format!("{key} = {number} is out of range"), remedy))
    }

    /// The same where the key may be left out.
    fn or(
        &self,
        value: Option<&At<f32>>,
        key: &str,
        range: RangeInclusive<f32>,
        default: f32,
    ) -> Result<f32, InputError> {
        value.map_or(Ok(default), |value| self.number(value, key, range))
    }

    fn micros(
        &self,
        value: &At<f32>,
        key: &str,
        range: RangeInclusive<f32>,
    ) -> Result<u64, InputError> {
        Ok((f64::from(self.number(value, key, range)?) * 1e6).round() as u64)
    }

    fn span_of(
        &self,
        value: Option<&At<f32>>,
        key: &str,
        range: RangeInclusive<f32>,
        default: Duration,
    ) -> Result<Duration, InputError> {
        value
            .map_or(Ok(default), |value| Ok(Duration::from_micros(self.micros(value, key, range)?)))
    }

    fn fidelity(&self, key: Option<&At<String>>) -> Result<Fidelity, InputError> {
        let Some(key) = key else { return Ok(Fidelity::Point) };
        let name = key.as_ref().as_str();
        Fidelity::named(name).ok_or_else(|| match name {
            "policy" => {
                let wrong = "the fidelity \"policy\" is now called \"point\"";
                self.wrong(key, wrong.into(), "write fidelity = \"point\"")
            }
            _ => {
                let wrong = format!("there is no fidelity \"{name}\"");
                self.wrong(key, wrong, "give \"point\", \"flight\" or \"virtual\"")
            }
        })
    }

    fn layout(&self, tunnel: &At<TunnelTable>) -> Result<Layout, InputError> {
        let table = tunnel.as_ref();
        let width = self.number(&table.width_m, "width_m", LEAST_WIDTH..=50.0)?;
        let centre_line = match (&table.centre_line_m, &table.winding) {
            (Some(pairs), None) => points(pairs.as_ref()),
            (None, Some(winding)) => self.winding(winding.as_ref())?,
            _ => {
                return Err(self.wrong(
                    tunnel,
                    "a tunnel needs a centre-line, and only one".into(),
                    "give either centre_line_m or winding",
                ));
            }
        };
        let place = table.centre_line_m.as_ref().map_or(tunnel.span().start, |p| p.span().start);
        let mut layout = Layout {
            main: Corridor { centre_line, width },
            branches: Vec::new(),
            rooms: Vec::new(),
        };
        self.diggable(&layout, place)?;
        for branch in &table.branch {
            let BranchTable { width_m, centre_line_m } = branch.as_ref();
            let corridor = Corridor { centre_line: points(centre_line_m), width: *width_m };
            layout.branches.push(corridor);
            self.diggable(&layout, branch.span().start)?;
        }
        for room in &table.room {
            let RoomTable { centre_m, size_m } = room.as_ref();
            layout.rooms.push(Room { centre: centre_m.0, size: size_m.0 });
            self.diggable(&layout, room.span().start)?;
        }
        Ok(layout)
    }

    fn diggable(&self, layout: &Layout, byte: usize) -> Result<(), InputError> {
        let length = CentreLine::new(layout.main.centre_line.clone()).length();
        let error = match outlines(layout) {
            Ok(_) if length <= Self::LONGEST => return Ok(()),
            Ok(_) => {
                let wrong = format!("the tunnel is {length} m long");
                InputError::new(wrong, format!("make it at most {} m", Self::LONGEST))
            }
            Err(error) => {
                let remedy = match error {
                    GeometryError::TooShort => "give at least two points",
                    GeometryError::Repeated(_) => "remove one of them",
                    GeometryError::TooSharp(_) => "make the corridor narrower or the bend wider",
                    GeometryError::TooNarrow => "make it wider",
                    GeometryError::TooLarge => "keep within that of the origin",
                    GeometryError::NotANumber => "give finite coordinates and positive sizes",
                };
                InputError::new(format!("impossible geometry: {error}"), remedy)
            }
        };
        Err(error.at_line(self.path, self.line_at(byte)))
    }

    /// The radio survey of a tunnel grows with the square of its length.
    const LONGEST: f32 = 500.0;

    fn winding(&self, table: &WindingTable) -> Result<Vec<Point>, InputError> {
        let length = self.number(&table.length_m, "length_m", 1.0..=Self::LONGEST)?;
        let amplitude = self.number(&table.amplitude_m, "amplitude_m", 0.0..=50.0)?;
        let wavelength = self.number(&table.wavelength_m, "wavelength_m", 0.5..=Self::LONGEST)?;
        let count = (length / 0.2).ceil().max(1.0) as usize;
        let point = |n: usize| {
            let x = length * n as f32 / count as f32;
            [x, amplitude * libm::sinf(core::f32::consts::TAU * x / wavelength)]
        };
        Ok((0..=count).map(point).collect())
    }

    fn radio(&self, table: &RadioTable) -> Result<(PathLoss, Reception), InputError> {
        let paper = Reception::PAPER;
        let number = |value: &Option<At<f32>>, key, range, default| {
            self.or(value.as_ref(), key, range, default)
        };
        let path_loss = PathLoss {
            attenuation: match table.attenuation {
                Some(AttenuationKey::WallCount) => Attenuation::WallCount,
                None | Some(AttenuationKey::RockDepth) => Attenuation::RockDepth,
            },
            loss_at_1m: Db(number(&table.loss_at_1m_db, "loss_at_1m_db", 0.0..=100.0, 40.0)?),
        };
        let reception = Reception {
            noise_variance: number(
                &table.noise_variance_db2,
                "noise_variance_db2",
                0.0..=400.0,
                paper.noise_variance,
            )?,
            resolution: Db(number(
                &table.resolution_db,
                "resolution_db",
                0.0..=10.0,
                paper.resolution.0,
            )?),
            loss_rate: number(&table.packet_loss, "packet_loss", 0.0..=1.0, paper.loss_rate)?,
            sensitivity: Dbm(number(
                &table.sensitivity_dbm,
                "sensitivity_dbm",
                -300.0..=0.0,
                paper.sensitivity.0,
            )?),
        };
        Ok((path_loss, reception))
    }

    fn vehicle(&self, table: &VehicleTable) -> Result<VehicleSpec, InputError> {
        let usual = VehicleSpec::DEFAULT;
        let number = |value: &Option<At<f32>>, key, range, default| {
            self.or(value.as_ref(), key, range, default)
        };
        Ok(VehicleSpec {
            lag: number(&table.lag_s, "lag_s", 0.0..=5.0, usual.lag)?,
            flow_noise: number(
                &table.flow_noise_mps,
                "flow_noise_mps",
                0.0..=5.0,
                usual.flow_noise,
            )?,
            flow_scale_error: number(
                &table.flow_scale_error,
                "flow_scale_error",
                0.0..=0.5,
                usual.flow_scale_error,
            )?,
            radius: number(&table.radius_m, "radius_m", 0.02..=0.2, usual.radius)?,
            reach: number(&table.reach_m, "reach_m", 0.2..=10.0, usual.reach)?,
            range_noise: number(
                &table.range_noise_m,
                "range_noise_m",
                0.0..=1.0,
                usual.range_noise,
            )?,
        })
    }

    fn ground(&self, table: &GroundTable) -> Result<Ground, InputError> {
        let part = |value: &Option<At<f32>>, key| self.or(value.as_ref(), key, 0.0..=1.0, 1.0);
        Ok(Ground {
            light: part(&table.light, "light")?,
            texture: part(&table.texture, "texture")?,
        })
    }

    fn criteria(&self, table: &CriteriaTable) -> Result<Criteria, InputError> {
        let bound = |value: &Option<At<f32>>, key, range| {
            value.as_ref().map(|value| self.number(value, key, range)).transpose()
        };
        let most = Self::MOST_RELAYS as f32;
        Ok(Criteria {
            hold_spread_db: bound(&table.hold_spread_db, "hold_spread_db", 0.0..=100.0)?,
            tilt_deg: bound(&table.tilt_deg, "tilt_deg", 0.0..=180.0)?,
            launched: bound(&table.launched, "launched", 0.0..=most)?.map(|n| n as u32),
        })
    }

    /// Head, relays and base make a chain of at most 16.
    const MOST_RELAYS: usize = chain::neighbours::MAX_NEIGHBOURS - 1;

    fn count(&self, relays: &At<usize>) -> Result<usize, InputError> {
        let count = *relays.as_ref();
        if count <= Self::MOST_RELAYS {
            return Ok(count);
        }
        let remedy = format!("give at most {}: a chain has 16 members", Self::MOST_RELAYS);
        Err(self.wrong(relays, format!("relays = {count} are too many"), remedy))
    }

    fn start(
        &self,
        drones: &At<DronesTable>,
        relays: usize,
        length: f32,
    ) -> Result<Start, InputError> {
        let table = drones.as_ref();
        match (table.start.unwrap_or(StartKey::Mouth), &table.head_m, &table.at_m) {
            (StartKey::Mouth, None, None) => {
                let row = Start::SPACING * (relays + 1) as f32;
                if row <= length {
                    return Ok(Start::Mouth);
                }
                let wrong = format!("{relays} relays and the head need {row} m in a row");
                Err(self.wrong(drones, wrong, format!("the tunnel has {length} m; use fewer")))
            }
            (StartKey::Random, Some(head), None) => {
                let place = self.number(head, "head_m", 1.0..=length)?;
                if place >= 3.0 * Start::APART * (relays + 1) as f32 {
                    return Ok(Start::Random { head: place });
                }
                let wrong = format!("{relays} relays do not fit before head_m = {place}");
                Err(self.wrong(head, wrong, "move the head farther in or use fewer relays"))
            }
            (StartKey::Placed, None, Some(at)) => self.placed(at, relays, length),
            _ => Err(self.wrong(
                drones,
                "start, head_m and at_m do not go together".into(),
                "start = \"mouth\" takes neither, \"random\" takes head_m, \"placed\" takes at_m",
            )),
        }
    }

    fn placed(&self, at: &At<Vec<f32>>, relays: usize, length: f32) -> Result<Start, InputError> {
        let places = at.as_ref();
        let inside = places.iter().all(|place| *place > 0.0 && *place <= length);
        let in_order = places.windows(2).all(|pair| pair[0] > pair[1]);
        if places.len() == relays + 1 && inside && in_order {
            return Ok(Start::Placed(places.clone()));
        }
        let remedy = format!(
            "give {} distances from the base, falling from the head's, within {length} m",
            relays + 1
        );
        Err(self.wrong(at, "at_m does not place every drone in order".into(), remedy))
    }

    fn agent(
        &self,
        file: &File,
        loss_at_1m: Db,
        vehicle: &VehicleSpec,
    ) -> Result<(String, Db, AgentConfig), InputError> {
        let mut agent = AgentConfig::DEFAULT;
        let table = &file.policy;
        let name = table.name.as_ref().map_or("default", |name| name.as_ref().as_str());
        let Some(policy) = policy_named(name) else {
            let at = table.name.as_ref();
            let error = InputError::new(
                format!("there is no policy \"{name}\""),
                suggest::one_of(name, &super::POLICIES),
            );
            return Err(match at {
                Some(at) => error.at_line(self.path, self.line_at(at.span().start)),
                None => error.in_file(self.path),
            });
        };
        let assumed =
            self.or(table.loss_at_1m_db.as_ref(), "loss_at_1m_db", 0.0..=100.0, loss_at_1m.0)?;
        agent.policy = policy.for_loss_at_1m(Db(assumed));
        agent.nav.reach = Metres(vehicle.reach);
        self.launch(&file.launch, &mut agent)?;
        self.retreat(&file.retreat, &mut agent)?;
        agent.check().map_err(|ConfigError::LaunchBehindRetreat| self.contradiction(file))?;
        Ok((name.to_owned(), Db(assumed), agent))
    }

    fn contradiction(&self, file: &File) -> InputError {
        let at = file.launch.limit_dbm.as_ref().or(file.retreat.limit_dbm.as_ref());
        let line = at.map_or(1, |at| self.line_at(at.span().start));
        InputError::new(
            ConfigError::LaunchBehindRetreat.to_string(),
            "raise launch.limit_dbm or lower retreat.limit_dbm",
        )
        .at_line(self.path, line)
    }

    fn launch(&self, table: &LaunchTable, agent: &mut AgentConfig) -> Result<(), InputError> {
        let launch = &mut agent.launch;
        if table.at_once == Some(true) {
            *launch = chain::launch::LaunchConfig::AT_ONCE;
        }
        let limit = self.or(table.limit_dbm.as_ref(), "limit_dbm", -300.0..=0.0, launch.limit.0)?;
        launch.limit = Dbm(limit);
        if let Some(settled) = &table.settled_db {
            launch.settled = Some(Db(self.number(settled, "settled_db", 0.1..=100.0)?));
        }
        let minute = 0.0..=60.0;
        launch.hold = self.span_of(table.hold_s.as_ref(), "hold_s", minute.clone(), launch.hold)?;
        launch.patience =
            self.span_of(table.patience_s.as_ref(), "patience_s", minute.clone(), launch.patience)?;
        launch.arm_delay =
            self.span_of(table.arm_delay_s.as_ref(), "arm_delay_s", minute, launch.arm_delay)?;
        Ok(())
    }

    fn retreat(&self, table: &RetreatTable, agent: &mut AgentConfig) -> Result<(), InputError> {
        let retreat = &mut agent.retreat;
        retreat.limit =
            Dbm(self.or(table.limit_dbm.as_ref(), "limit_dbm", -300.0..=0.0, retreat.limit.0)?);
        retreat.speed = MetresPerSecond(self.or(
            table.speed_mps.as_ref(),
            "speed_mps",
            0.01..=1.0,
            retreat.speed.0,
        )?);
        retreat.max_time =
            self.span_of(table.max_time_s.as_ref(), "max_time_s", 0.0..=600.0, retreat.max_time)?;
        retreat.max_distance = Metres(self.or(
            table.max_distance_m.as_ref(),
            "max_distance_m",
            0.0..=100.0,
            retreat.max_distance.0,
        )?);
        Ok(())
    }

    fn pilot(
        &self,
        steps: &[At<PilotTable>],
        duration_us: u64,
    ) -> Result<Vec<PilotStep>, InputError> {
        let mut pilot: Vec<PilotStep> = Vec::with_capacity(steps.len());
        for step in steps {
            let table = step.as_ref();
            let at_us = self.micros(&table.at_s, "at_s", 0.0..=86_400.0)?;
            if pilot.last().is_some_and(|before| before.at_us >= at_us) {
                let wrong = "the operator's orders are not in order of time".into();
                return Err(self.wrong(&table.at_s, wrong, "sort them by at_s"));
            }
            if at_us >= duration_us {
                let wrong = format!("at_s = {} is not before the end", table.at_s.as_ref());
                return Err(self.wrong(&table.at_s, wrong, "order it earlier or raise duration_s"));
            }
            let speed = match (table.order, &table.speed_mps) {
                (OrderKey::Explore, Some(speed)) => {
                    MetresPerSecond(self.number(speed, "speed_mps", -1.0..=1.0)?)
                }
                (OrderKey::Explore, None) => {
                    let wrong = "order = \"explore\" needs a speed".into();
                    return Err(self.wrong(step, wrong, "give speed_mps"));
                }
                (_, Some(speed)) => {
                    let wrong = "only order = \"explore\" takes a speed".into();
                    return Err(self.wrong(speed, wrong, "remove speed_mps"));
                }
                (_, None) => MetresPerSecond::ZERO,
            };
            let task = match table.order {
                OrderKey::Wait => Order::Wait,
                OrderKey::Explore => Order::Explore(speed),
                OrderKey::Return => Order::Return,
                OrderKey::Land => Order::Land,
                OrderKey::Stop => Order::Stop,
            };
            pilot.push(PilotStep { at_us, task });
        }
        Ok(pilot)
    }
}
