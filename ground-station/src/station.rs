//! Runs the station: carries packets between the link and the session, requests of the pages to
//! the session, and the state to the pages and to the recorder.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use radio_model::Reception;
use serde::{Deserialize, Serialize};
use station_log::{ChainLine, Plan};
use tokio::sync::{mpsc, watch};
use tokio::time::MissedTickBehavior;
use units::{Dbm, Instant, NodeId};

use crate::advice::Situation;
use crate::blocks::{Block, DroneReport};
use crate::chain_view::ChainView;
use crate::clock::Clock;
use crate::console::Console;
use crate::fleet::Fleet;
use crate::flight_log::FlightLog;
use crate::freshness::Echo;
use crate::link::Link;
use crate::link_history::LinkHistory;
use crate::live_stream::LiveStream;
use crate::message::{Event, Record};
use crate::order::{Fate, Order, number};
use crate::range_survey::RangeSurvey;
use crate::recorder::Recorder;
use crate::session::{News, Session, Speech};
use crate::status::{Shown, Status};
use crate::steering::{LineId, PageId, Pages, Rejected};

/// The time between two looks at what is due; an order is sent at once, not at the next of them.
const TICK: Duration = Duration::from_millis(10);
/// The time between two states for the pages.
const PUBLISH: units::Duration = units::Duration::from_millis(100);
/// The number of notices that the pages show.
const NOTICES: usize = 50;
/// The number of requests of the pages that may wait.
const WAITING: usize = 64;
/// For how long the pages show that a request was refused.
const SHOW_REFUSED: units::Duration = units::Duration::from_secs(10);

/// A message of a page.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "do")]
pub enum Request {
    /// A sign of life.
    Beat,
    /// An order, which only the page that steers may give.
    Order(Order),
    /// The page's person wants to steer, where no page does or in place of another page.
    Steer,
    /// The emergency stop, which every page may order, and which is never refused.
    Stop,
    /// The operator no longer waits for answers to the stop.
    GiveUp,
    /// A step of the range survey.
    Survey(SurveyStep),
}

/// A step of the range survey.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "step")]
pub enum SurveyStep {
    /// The relay of this number is carried away from the base.
    Begin {
        /// The relay.
        node: u8,
    },
    /// The relay is so far from the base now.
    Mark {
        /// The way from the base in metres.
        #[serde(deserialize_with = "number")]
        metres: f32,
    },
    /// The relay is carried no farther: the samples are written.
    End,
}

/// Something that happened at a page.
#[derive(Clone, Copy, Debug)]
enum FromPage {
    Opened { line: LineId, page: PageId, is_new: bool },
    Sent(PageId, Echo, Request),
    Closed(LineId),
}

/// What a station is started with, beside its link.
#[derive(Debug, Default)]
pub struct Setup {
    /// The recorder, if everything is recorded.
    pub recorder: Option<Recorder>,
    /// The floor plan for the pages, if there is one.
    pub plan: Option<Plan>,
    /// The fleet, which names the drones.
    pub fleet: Fleet,
    /// The least strength that the drones' radio receives, for the range survey.
    pub sensitivity: Option<Dbm>,
}

/// The pages' end of a station. The station runs until the last of them is dropped.
#[derive(Clone, Debug)]
pub struct Handle {
    requests: mpsc::Sender<FromPage>,
    status: watch::Receiver<Arc<str>>,
    stream: Arc<LiveStream>,
    links: Arc<LinkHistory>,
    plan: Arc<str>,
}

impl Handle {
    /// Tells the station of a new line to a page; `is_new` where a person has opened the page.
    pub async fn open(&self, line: LineId, page: PageId, is_new: bool) {
        // A station that has ended takes no requests.
        let _ = self.requests.send(FromPage::Opened { line, page, is_new }).await;
    }

    /// Gives a page's request to the station, with what the page says about its time.
    pub async fn send(&self, page: PageId, echo: Echo, request: Request) {
        let _ = self.requests.send(FromPage::Sent(page, echo, request)).await;
    }

    /// Tells the station that a line to a page was closed.
    pub async fn close(&self, line: LineId) {
        let _ = self.requests.send(FromPage::Closed(line)).await;
    }

    /// The state of the station as JSON, which changes ten times a second.
    #[must_use]
    pub fn status(&self) -> watch::Receiver<Arc<str>> {
        self.status.clone()
    }

    /// Everything that is recorded, as it happens.
    #[must_use]
    pub fn stream(&self) -> &LiveStream {
        &self.stream
    }

    /// The strengths of the drones' links over the last minutes.
    #[must_use]
    pub fn links(&self) -> &LinkHistory {
        &self.links
    }

    /// The floor plan as JSON; `null` where there is none.
    #[must_use]
    pub fn plan(&self) -> &str {
        &self.plan
    }
}

/// Starts a station on a link.
#[must_use]
pub fn start(link: impl Link, setup: Setup) -> Handle {
    let Setup { recorder, plan, fleet, sensitivity } = setup;
    let plan_json = serde_json::to_string(&plan).unwrap_or_else(|_| "null".to_owned());
    let (requests, received) = mpsc::channel(WAITING);
    let (publisher, status) = watch::channel(Arc::from("{}"));
    let stream = Arc::new(LiveStream::default());
    let links = Arc::new(LinkHistory::default());
    let mut station = Station {
        link,
        recorder,
        stream: Arc::clone(&stream),
        links: Arc::clone(&links),
        publisher,
        clock: Clock::begin(),
        began_at: SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default(),
        session: Session::default(),
        chain: ChainView::default(),
        pages: Pages::default(),
        refused: None,
        notices: VecDeque::new(),
        flight_log: FlightLog::default(),
        console: Console::default(),
        published: None,
        line: plan.as_ref().and_then(ChainLine::of),
        fleet,
        survey: None,
        sensitivity: sensitivity.unwrap_or(Reception::NRF51_AT_2_MBIT),
    };
    if let Some(plan) = plan {
        station.record(Instant::ZERO, Event::Map(plan));
    }
    tokio::spawn(station.run(received));
    Handle { requests, status, stream, links, plan: plan_json.into() }
}

/// A request that was refused.
struct Refusal {
    at: Instant,
    page: PageId,
    /// The number that the page gave the request.
    seq: Option<u64>,
    text: String,
}

struct Station<L: Link> {
    link: L,
    recorder: Option<Recorder>,
    stream: Arc<LiveStream>,
    links: Arc<LinkHistory>,
    publisher: watch::Sender<Arc<str>>,
    clock: Clock,
    /// The beginning as the time since 1970.
    began_at: Duration,
    session: Session,
    chain: ChainView,
    pages: Pages,
    /// The last request that was refused.
    refused: Option<Refusal>,
    notices: VecDeque<String>,
    flight_log: FlightLog,
    /// What the base prints, until its line has ended.
    console: Console,
    published: Option<Instant>,
    /// The line of the plan along which drones are shown.
    line: Option<ChainLine>,
    fleet: Fleet,
    /// The range survey, from its beginning until the next.
    survey: Option<RangeSurvey>,
    sensitivity: Dbm,
}

impl<L: Link> Station<L> {
    async fn run(mut self, mut requests: mpsc::Receiver<FromPage>) {
        let mut tick = tokio::time::interval(TICK);
        tick.set_missed_tick_behavior(MissedTickBehavior::Delay);
        loop {
            let packet = tokio::select! {
                request = requests.recv() => match request {
                    Some(request) => {
                        self.heed(request);
                        None
                    }
                    None => return,
                },
                packet = self.link.receive() => Some(packet),
                _ = tick.tick() => None,
            };
            let now = self.clock.now();
            if let Some(packet) = packet {
                self.session.receive(now, &packet);
            }
            self.send(now).await;
            self.tell_news(now).await;
            self.tell_flight(now);
            if self.published.is_none_or(|published| now.since(published) >= PUBLISH) {
                self.published = Some(now);
                self.publish(now);
            }
        }
    }

    fn heed(&mut self, from: FromPage) {
        let now = self.clock.now();
        match from {
            FromPage::Opened { line, page, is_new } => self.pages.open(line, page, is_new),
            FromPage::Closed(line) => self.pages.close(line),
            FromPage::Sent(page, echo, request) => {
                self.pages.hear(now, page, echo);
                if request != Request::Beat {
                    // The page is told at once what has arrived.
                    self.published = None;
                    self.heed_request(now, page, echo, request);
                }
            }
        }
    }

    fn heed_request(&mut self, now: Instant, page: PageId, echo: Echo, request: Request) {
        let judged = match request {
            Request::Beat => return,
            Request::Stop => return self.stop(now, page, echo),
            Request::Steer | Request::GiveUp => self.pages.judge(now, page, echo),
            Request::Order(_) | Request::Survey(_) => self.pages.judge_order(now, page, echo),
        };
        match judged {
            Ok(until) => {
                self.refused = None;
                self.act(now, page, request, until);
            }
            Err(rejected) => self.refuse(now, (page, echo.seq), request, rejected),
        }
    }

    fn stop(&mut self, now: Instant, page: PageId, echo: Echo) {
        if self.pages.take_stop(page, echo) {
            self.record(now, Event::Stop);
            self.session.stopping.order(now, self.chain.drones.keys().copied());
        }
    }

    /// Carries out a request that was not refused.
    fn act(&mut self, now: Instant, page: PageId, request: Request, until: Instant) {
        match request {
            Request::Beat | Request::Stop => {}
            Request::Steer => self.pages.take_over(page),
            Request::GiveUp => {
                self.record(now, Event::GaveUp);
                self.session.stopping.give_up();
            }
            Request::Order(order) => {
                self.record(now, Event::Ordered(order));
                if !self.session.order(order, until) {
                    let text = "Not ordered: the station does not know the base yet.";
                    self.notice(now, text.to_owned());
                }
            }
            Request::Survey(step) => self.survey(now, step),
        }
    }

    /// Tells the pages that a request was refused, and why.
    fn refuse(
        &mut self,
        now: Instant,
        (page, seq): (PageId, Option<u64>),
        request: Request,
        rejected: Rejected,
    ) {
        let what = match request {
            Request::Order(order) => format!("Not ordered to {}", order_in_words(order)),
            Request::Steer => "The page does not steer".to_owned(),
            Request::GiveUp => "The stop is still being sent".to_owned(),
            Request::Survey(_) => "Nothing was noted for the range survey".to_owned(),
            Request::Beat | Request::Stop => return,
        };
        let text = format!("{what}: {rejected}");
        self.notice(now, text.clone());
        self.refused = Some(Refusal { at: now, page, seq, text });
    }

    fn survey(&mut self, now: Instant, step: SurveyStep) {
        match (step, &mut self.survey) {
            (SurveyStep::Begin { node }, survey) => {
                *survey = Some(RangeSurvey::begin(now, NodeId(node)));
            }
            (SurveyStep::Mark { metres }, Some(survey)) => {
                survey.mark(now, metres);
                let node = survey.node;
                self.record(now, Event::Mark(node, metres));
            }
            (SurveyStep::End, Some(survey)) => {
                let (node, samples) = (survey.node, survey.samples());
                let count = samples.len();
                self.record(now, Event::Survey(node, samples));
                let unwritten = match self.recorder {
                    Some(_) => "",
                    None => " Nothing is written: the station was started without --record.",
                };
                self.notice(now, format!("The range survey has {count} samples.{unwritten}"));
            }
            (SurveyStep::Mark { .. } | SurveyStep::End, None) => {}
        }
    }

    /// Gives a report to the survey, if it is one of the relay that is carried, about the base.
    fn note_for_survey(&mut self, node: NodeId, report: &DroneReport) {
        let base = self.session.facts().map(|facts| facts.node);
        let said = self.chain.drones.get(&node).map(|drone| drone.said);
        if let (Some(survey), Some(said), Some((peer, rssi))) =
            (&mut self.survey, said, report.back)
            && survey.node == node
            && base == Some(peer)
        {
            survey.hear(said, rssi);
        }
    }

    /// Keeps the strength of a drone's link for pages that are opened later.
    fn note_link(&self, node: NodeId, report: &DroneReport) {
        if let (Some(drone), Some((_, rssi))) = (self.chain.drones.get(&node), report.back) {
            self.links.note(node, drone.said, rssi);
        }
    }

    async fn send(&mut self, now: Instant) {
        let speech = match self.pages.steering(now) {
            Some(_) => Speech::Steered,
            None => Speech::StopOnly,
        };
        while let Some(packet) = self.session.poll(now, speech) {
            self.link.send(&packet).await;
        }
    }

    async fn tell_news(&mut self, now: Instant) {
        for news in self.session.take_news() {
            match news {
                News::Block(Block::Drone(node, report)) => {
                    if self.chain.hear(now, node, report) {
                        self.note_for_survey(node, &report);
                        self.note_link(node, &report);
                        self.record(now, Event::Drone(node, report));
                    }
                }
                News::Block(Block::Base(base)) => {
                    if self.chain.base.replace(base) != Some(base) {
                        self.record(now, Event::Base(base));
                    }
                }
                News::Console(text) => {
                    for sentence in self.console.take(&text) {
                        self.notice(now, format!("The base says: {sentence}"));
                    }
                    self.record(now, Event::Console(text));
                }
                News::Task(task) => self.chain.task = Some(task),
                News::Order(order, fate) => {
                    self.record(now, Event::Fate(order, fate));
                    self.notice(now, fate_in_words(order, fate));
                }
                News::Ready(facts) => {
                    self.record(now, Event::Limits(facts));
                    self.notice(now, format!("Connected to the base, node {}.", facts.node));
                }
                News::NotBase(node) => self.seek_base(now, node).await,
                News::Missing(name) => self.notice(
                    now,
                    format!("The base's firmware has no {name}: flash the one of this station."),
                ),
            }
        }
    }

    /// Tries the next drone of the chain, of which the base is the last.
    async fn seek_base(&mut self, now: Instant, node: NodeId) {
        if self.link.go_on().await {
            self.session.begin_anew();
            self.console = Console::default();
            self.notice(now, format!("Node {node} is not the base: the next port is tried."));
        } else {
            self.notice(now, format!("Node {node} is not the base: give the base's address."));
        }
    }

    /// Tells what the drones do.
    fn tell_flight(&mut self, now: Instant) {
        let base = self.session.facts();
        for text in self.flight_log.step(now, &self.chain, base, &self.fleet) {
            self.notice(now, text);
        }
    }

    /// Notes what has happened, with the time since the first drone took off, or since the station began.
    fn notice(&mut self, now: Instant, text: String) {
        let at = match self.flight_log.flight() {
            Some(flight) => {
                let seconds = now.since(flight.began).as_secs_f32() as u32;
                format!("{}:{:02}", seconds / 60, seconds % 60)
            }
            None => format!("{:.1} s", now.since(Instant::ZERO).as_secs_f32()),
        };
        self.notices.push_back(format!("{at}: {text}"));
        if self.notices.len() > NOTICES {
            self.notices.pop_front();
        }
        self.record(now, Event::Notice(text));
    }

    fn record(&mut self, now: Instant, event: Event) {
        let at = self.began_at + Duration::from_micros(now.as_micros());
        let record = Record { at, event };
        self.stream.put(&record);
        let Some(recorder) = &self.recorder else { return };
        if !recorder.record(record) {
            self.recorder = None;
            self.notice(now, "Recording has ended: the disk takes no more.".to_owned());
        }
    }

    /// The refusal that the pages show now.
    fn shown_refusal(&self, now: Instant) -> Option<(PageId, Option<u64>, &str)> {
        let Refusal { at, page, seq, text } = self.refused.as_ref()?;
        (now.since(*at) < SHOW_REFUSED).then_some((*page, *seq, text.as_str()))
    }

    fn publish(&self, now: Instant) {
        let situation = Situation {
            now,
            is_steered: self.pages.steering(now).is_some(),
            hears_base: self.session.hears_base(now),
            facts: self.session.facts(),
            chain: &self.chain,
            stopping: &self.session.stopping,
            fleet: &self.fleet,
        };
        let notices = self.notices.iter().cloned().collect();
        let shown = Shown {
            line: self.line.as_ref(),
            survey: self.survey.as_ref().map(|survey| (survey, self.sensitivity)),
            steering: self.pages.steering(now),
            heard: self.pages.heard(),
            refused: self.shown_refusal(now),
            notices,
            flight: self.flight_log.flight(),
        };
        let status = Status::of(&situation, shown);
        if let Ok(json) = serde_json::to_string(&status) {
            self.publisher.send_replace(json.into());
        }
    }
}

fn order_in_words(order: Order) -> String {
    match order {
        Order::Wait => "wait".to_owned(),
        Order::Hold => "hold".to_owned(),
        Order::Explore { speed } => format!("explore at {speed:.2} m/s"),
        Order::Branch { way } => format!("branch {way:?}").to_lowercase(),
        Order::Recall => "recall".to_owned(),
        Order::Land => "land".to_owned(),
        Order::Perch => "perch".to_owned(),
    }
}

fn fate_in_words(order: Order, fate: Fate) -> String {
    let order = order_in_words(order);
    match fate {
        Fate::Taken => format!("The base has taken the order to {order}."),
        Fate::Refused => format!("The base does not follow the order to {order}."),
        Fate::NotAnswered => format!("The base has not answered the order to {order}."),
        Fate::Replaced => format!("A newer order has replaced the order to {order}."),
        Fate::Dropped => format!("The order to {order} was dropped: no page steers."),
    }
}
