//! Writes the state of the station as the JSON object that the pages show.

use serde::Serialize;
use station_log::ChainLine;
use units::{Dbm, Instant, NodeId, Pose2};

use crate::advice::{self, SILENT, Situation, Urgency};
use crate::battery;
use crate::chain_view::{ChainView, Drone, Trend};
use crate::checklist::{self, Check};
use crate::fleet::Fleet;
use crate::flight_log::Flight;
use crate::freshness;
use crate::grade::Grade;
use crate::range_survey::{Proposal, RangeSurvey};
use crate::session::Facts;
use crate::steering::{PageId, Receipt};
use crate::stopping::{Sending, Stopping};
use crate::words;

/// The state of the station.
#[derive(Debug, Serialize)]
pub struct Status {
    /// The time of the state in ms, which a page says with each of its requests.
    stamp: u64,
    /// The page that steers.
    steering: Option<PageId>,
    /// What was heard of each open page.
    heard: Vec<Receipt>,
    /// The last request that was refused, for some seconds.
    refused: Option<RefusedStatus>,
    hears_base: bool,
    /// The base's number and the state of its radio, once they are known.
    base: Option<Base>,
    /// The flight that goes on or was the last; `None` before the first take-off.
    flight: Option<FlightStatus>,
    /// The order that the base gives, in words.
    task: Option<&'static str>,
    /// The drones, head first.
    drones: Vec<DroneStatus>,
    /// Where the chain is.
    map: MapStatus,
    /// The checklist before a flight; empty in flight.
    checks: Vec<Check>,
    stop: Option<StopStatus>,
    survey: Option<SurveyStatus>,
    advice: AdviceStatus,
    /// The last lines of the station's log, the newest last.
    notices: Vec<String>,
}

/// What the pages show beside the situation.
#[derive(Debug)]
pub struct Shown<'a> {
    /// The line of the plan along which drones are shown; without it, a straight one.
    pub line: Option<&'a ChainLine>,
    /// The range survey, with the sensitivity of the drones' radio.
    pub survey: Option<(&'a RangeSurvey, Dbm)>,
    /// The page that steers.
    pub steering: Option<PageId>,
    /// What was heard of each open page.
    pub heard: Vec<Receipt>,
    /// The last request that was refused: the page that made it, its number, and why.
    pub refused: Option<(PageId, Option<u64>, &'a str)>,
    /// The last lines of the station's log, the newest last.
    pub notices: Vec<String>,
    /// The flight that goes on or was the last.
    pub flight: Option<Flight>,
}

#[derive(Debug, Serialize)]
struct RefusedStatus {
    page: PageId,
    /// The number that the page gave the request.
    seq: Option<u64>,
    text: String,
}

#[derive(Debug, Serialize)]
struct SurveyStatus {
    name: String,
    /// The last mark.
    place_m: f32,
    /// The number of samples whose place is known.
    samples: usize,
    proposal: Option<Proposal>,
}

impl SurveyStatus {
    fn of(survey: &RangeSurvey, sensitivity: Dbm, fleet: &Fleet) -> Self {
        Self {
            name: fleet.name(survey.node),
            place_m: survey.place_m(),
            samples: survey.samples().len(),
            proposal: survey.propose(sensitivity),
        }
    }
}

#[derive(Debug, Serialize)]
struct Base {
    node: u8,
    radio: &'static str,
    recalled: bool,
    launch_limit_dbm: f32,
    retreat_limit_dbm: f32,
}

#[derive(Debug, Serialize)]
struct FlightStatus {
    lasts_s: f32,
    is_over: bool,
}

#[derive(Debug, Serialize)]
struct DroneStatus {
    node: u8,
    name: String,
    state: &'static str,
    fault: Option<&'static str>,
    airborne: bool,
    age_s: f32,
    silent: bool,
    battery_v: Option<f32>,
    endurance_s: Option<f32>,
    /// The time until the drone turns back for its battery.
    turns_back_s: Option<f32>,
    link: Option<LinkStatus>,
    odometer_m: f32,
    /// How far the drone is from the base, along the line.
    way_m: f32,
    /// Where the drone is on the map, in metres.
    at: [f32; 2],
}

/// The line along which the drones are shown.
#[derive(Debug, Serialize)]
struct MapStatus {
    /// The base's place.
    base: [f32; 2],
    /// The end of the straight line from the base where there is no plan.
    end: Option<[f32; 2]>,
}

/// How far a drone is from the base, and its place on the map.
#[derive(Clone, Copy, Debug)]
struct Place {
    way_m: f32,
    at: [f32; 2],
}

impl MapStatus {
    /// The line, and the place of each drone.
    fn of(chain: &ChainView, line: Option<&ChainLine>) -> (Self, Vec<Place>) {
        let drones = chain.drones.len();
        let ways = || chain.drones.values().map(|drone| drone.report.odometer.0);
        let straight = ChainLine::straight(drones, ways().fold(0.0, f32::max));
        let end = line.is_none().then(|| straight.points().last().map(|end| [end.x, end.y]));
        let line = line.unwrap_or(&straight);
        let point = |pose: Pose2| [pose.at.x, pose.at.y];
        let place = |(rank, odometer)| {
            let way_m = line.way(rank, drones, odometer);
            Place { way_m, at: point(line.at(way_m)) }
        };
        let places = ways().enumerate().map(place).collect();
        (Self { base: point(line.base()), end: end.flatten() }, places)
    }
}

#[derive(Debug, Serialize)]
struct LinkStatus {
    to: u8,
    dbm: f32,
    grade: &'static str,
    trend: &'static str,
}

#[derive(Debug, Serialize)]
struct StopStatus {
    sending: &'static str,
    since_s: f32,
    base_s: Option<f32>,
    drones: Vec<Answer>,
}

#[derive(Debug, Serialize)]
struct Answer {
    node: u8,
    name: String,
    /// The time from the order to the answer; `None` where there is no answer.
    answered_s: Option<f32>,
}

#[derive(Debug, Serialize)]
struct AdviceStatus {
    urgent: bool,
    text: String,
}

impl Status {
    /// The state of the station in a situation.
    #[must_use]
    pub fn of(situation: &Situation<'_>, shown: Shown<'_>) -> Self {
        let Shown { line, survey, steering, heard, refused, notices, flight } = shown;
        let Situation { now, is_steered: _, hears_base, facts, chain, stopping, fleet } =
            *situation;
        let advice = advice::advise(situation);
        let (map, places) = MapStatus::of(chain, line);
        Self {
            stamp: freshness::stamp(now),
            steering,
            heard,
            refused: refused.map(|(page, seq, text)| RefusedStatus {
                page,
                seq,
                text: text.to_owned(),
            }),
            hears_base,
            base: facts.zip(chain.base).map(|(facts, base)| Base {
                node: facts.node.0,
                radio: words::link(base.link),
                recalled: base.recalled,
                launch_limit_dbm: facts.launch_limit.0,
                retreat_limit_dbm: facts.retreat_limit.0,
            }),
            flight: flight.map(|flight| FlightStatus {
                lasts_s: flight.lasts(now).as_secs_f32(),
                is_over: flight.ended.is_some(),
            }),
            task: chain.task.map(words::task),
            drones: chain
                .drones
                .iter()
                .zip(places)
                .map(|((node, drone), place)| {
                    let name = fleet.name(*node);
                    DroneStatus::of(now, (*node, name), drone, facts, place)
                })
                .collect(),
            map,
            checks: checklist::checks(situation),
            stop: StopStatus::of(now, stopping, fleet),
            survey: survey
                .map(|(survey, sensitivity)| SurveyStatus::of(survey, sensitivity, fleet)),
            advice: AdviceStatus { urgent: advice.urgency == Urgency::Urgent, text: advice.text },
            notices,
        }
    }
}

impl DroneStatus {
    fn of(
        now: Instant,
        (node, name): (NodeId, String),
        drone: &Drone,
        base: Option<Facts>,
        place: Place,
    ) -> Self {
        let report = &drone.report;
        Self {
            node: node.0,
            name,
            state: words::state(report.state),
            fault: words::fault(report.fault),
            airborne: words::is_airborne(report.state),
            age_s: drone.age(now).as_secs_f32(),
            silent: drone.age(now) > SILENT,
            battery_v: report.battery.map(|volts| volts.0),
            endurance_s: report.endurance.map(units::Duration::as_secs_f32),
            turns_back_s: battery::seconds_to_turning_back(report),
            link: report.back.map(|(to, rssi)| LinkStatus {
                to: to.0,
                dbm: rssi.0,
                grade: base.map_or("unknown", |base| Grade::of(rssi, base).name()),
                trend: match drone.trend() {
                    Trend::Unknown => "unknown",
                    Trend::Rising => "rising",
                    Trend::Steady => "steady",
                    Trend::Falling => "falling",
                },
            }),
            odometer_m: report.odometer.0,
            way_m: place.way_m,
            at: place.at,
        }
    }
}

impl StopStatus {
    fn of(now: Instant, stopping: &Stopping, fleet: &Fleet) -> Option<Self> {
        let Stopping::Ordered(stop) = stopping else { return None };
        let answer = |(node, answered): (&NodeId, &Option<units::Duration>)| Answer {
            node: node.0,
            name: fleet.name(*node),
            answered_s: answered.map(units::Duration::as_secs_f32),
        };
        Some(Self {
            sending: match stop.sending {
                Sending::Repeating => "repeating",
                Sending::Answered => "answered",
                Sending::GivenUp => "given up",
            },
            since_s: now.since(stop.since).as_secs_f32(),
            base_s: stop.base.map(units::Duration::as_secs_f32),
            drones: stop.drones.iter().map(answer).collect(),
        })
    }
}
