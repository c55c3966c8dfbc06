//! What a program's pilot asks of the station.

use serde_json::json;

use super::*;

const EXPLORE: Request = Request::Order(Order::Explore { speed: 0.25 });
const HOLD: Request = Request::Order(Order::Hold);

/// A state in which this page steers, and the head is in the air or not.
fn state(steering: Option<u64>, airborne: bool) -> State {
    let head = json!({
        "node": 0, "name": "head", "state": "leading", "airborne": airborne, "age_s": 0.1,
        "silent": false, "odometer_m": 0.0,
    });
    let json = json!({
        "stamp": 10_000, "steering": steering, "hears_base": true, "drones": [head],
        "advice": { "text": "" },
    });
    State::read(&json.to_string()).unwrap()
}

fn twist(forward: f64) -> Heard {
    aged_twist(0, forward)
}

fn aged_twist(ms: u64, forward: f64) -> Heard {
    Heard { forward: Some((Age(Some(Duration::from_millis(ms))), forward)), orders: Vec::new() }
}

fn order(text: &str) -> Heard {
    Heard { orders: vec![(Age(Some(Duration::ZERO)), text.to_owned())], forward: None }
}

/// A pilot beside a station, at times in milliseconds.
struct Flight {
    pilot: Pilot,
    began: Instant,
    state: State,
}

impl Flight {
    fn of(state: State) -> Self {
        Self { pilot: Pilot::default(), began: Instant::now(), state }
    }

    fn heed(&mut self, ms: u64, heard: Heard) -> Said {
        self.pilot.heed(self.began + Duration::from_millis(ms), &self.state, heard)
    }

    fn requests(&mut self, ms: u64, heard: Heard) -> Vec<Request> {
        let said = self.heed(ms, heard);
        assert_eq!(said.complaints, Vec::<String>::new());
        said.requests.into_iter().map(|(_, request)| request).collect()
    }
}

#[test]
fn the_head_flies_while_twists_come_and_holds_when_they_stop() {
    let mut flight = Flight::of(state(Some(0), false));
    assert_eq!(flight.requests(0, twist(0.25)), [EXPLORE]);
    assert_eq!(flight.requests(100, twist(0.252)), [Request::Beat]);
    assert_eq!(flight.requests(599, Heard::default()), []);
    assert_eq!(flight.requests(600, Heard::default()), [HOLD]);
    // From then on nothing says that a program is there.
    assert_eq!(flight.requests(700, Heard::default()), []);
    assert_eq!(flight.requests(900, twist(9.0)), [Request::Order(Order::Explore { speed: 0.4 })]);
}

#[test]
fn a_head_on_the_ground_stays_there_at_speed_zero_and_one_in_the_air_hovers() {
    let mut flight = Flight::of(state(Some(0), false));
    assert_eq!(flight.requests(0, twist(0.0)), [Request::Beat]);
    flight.state = state(Some(0), true);
    assert_eq!(flight.requests(100, twist(0.001)), [HOLD]);
}

#[test]
fn an_order_takes_the_head_from_the_twists_until_they_pause() {
    let mut flight = Flight::of(state(Some(0), true));
    assert_eq!(flight.requests(0, twist(0.25)), [EXPLORE]);
    flight.requests(50, order("branch left"));
    assert_eq!(flight.requests(100, twist(0.25)), [Request::Beat]);
    assert_eq!(flight.requests(150, order("return")), [Request::Order(Order::Recall)]);
    for ms in (200..1_000).step_by(100) {
        assert_eq!(flight.requests(ms, twist(0.3)), [Request::Beat]);
    }
    assert_eq!(flight.requests(1_400, Heard::default()), []);
    assert_eq!(flight.requests(1_500, twist(0.25)), [EXPLORE]);
}

#[test]
fn twists_do_nothing_while_a_page_steers_which_is_said_once() {
    let mut flight = Flight::of(state(Some(7), true));
    let said = flight.heed(0, twist(0.25));
    assert_eq!(said.requests, []);
    assert!(said.complaints[0].contains("a page steers"), "{said:?}");
    assert_eq!(flight.heed(100, twist(0.25)), Said::default());
    assert_eq!(flight.requests(200, order("steer")), [Request::Steer]);
}

#[test]
fn a_program_that_steers_no_more_orders_no_hold() {
    for steering in [Some(7), None] {
        let mut flight = Flight::of(state(Some(0), true));
        assert_eq!(flight.requests(0, twist(0.25)), [EXPLORE]);
        flight.state = state(steering, true);
        assert_eq!(flight.requests(2_000, Heard::default()), []);
    }
}

#[test]
fn a_program_that_was_gone_shows_that_it_is_back_before_it_flies() {
    let mut flight = Flight::of(state(None, true));
    assert_eq!(flight.requests(0, twist(0.25)), [Request::Beat]);
    flight.state = state(Some(0), true);
    assert_eq!(flight.requests(100, twist(0.25)), [EXPLORE]);
    // Where it does not come to steer, it has never asked for that.
    flight.state = state(None, true);
    flight.heed(5_000, twist(0.25));
    let said = flight.heed(5_500, twist(0.25));
    assert!(said.complaints[0].contains("send steer"), "{said:?}");
}

#[test]
fn an_old_twist_is_neither_an_order_nor_a_sign_of_life() {
    let mut flight = Flight::of(state(Some(0), true));
    let said = flight.heed(0, aged_twist(500, 0.25));
    assert!(said.requests.is_empty() && said.complaints.len() == 1, "{said:?}");
    // A younger one counts from when it was sent.
    let (echo, request) = flight.heed(0, aged_twist(400, 0.25)).requests[0];
    assert_eq!((echo.stamp, request), (Some(9_600), EXPLORE));
    assert_eq!(flight.requests(100, Heard::default()), [HOLD]);
}

#[test]
fn a_wrong_word_is_told_and_ignored() {
    let mut flight = Flight::of(state(Some(0), true));
    let said = flight.heed(0, order("fly home, please, as fast as you can"));
    assert_eq!(said.requests, []);
    assert!(said.complaints[0].starts_with("/order: \"fly home, please, as fas\" is no order;"));
}

#[test]
fn a_speed_that_the_station_refused_is_told_again() {
    let mut flight = Flight::of(state(Some(0), true));
    assert_eq!(flight.requests(0, twist(0.25)), [EXPLORE]);
    let refused = json!({ "page": 0, "seq": 1 });
    flight.state.refused = serde_json::from_value(refused).unwrap();
    assert_eq!(flight.requests(100, twist(0.25)), [EXPLORE]);
    assert_eq!(flight.requests(200, twist(0.25)), [Request::Beat]);
}
