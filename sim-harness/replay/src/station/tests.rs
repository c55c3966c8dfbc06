use units::Point2;

use super::*;
use station_log::{Plan, PlanLine};

fn report(node: u8, state_code: u8, odometer_m: f32) -> Message {
    Message::Report(DroneReport {
        node,
        state: String::new(),
        state_code,
        fault: String::new(),
        battery_v: Some(3.9),
        endurance_s: None,
        odometer_m,
        back: Some(4),
        rssi_dbm: Some(-60.0),
    })
}

fn at(seconds: f64, message: Message) -> Heard {
    // Recordings have the time since 1970.
    Heard { micros: 1_700_000_000_000_000 + (seconds * 1e6) as u64, message }
}

fn given(order: &str, speed: Option<f32>, way: Option<&str>) -> Message {
    let way = way.map(str::to_owned);
    Message::Ordered(GivenOrder { order: order.to_owned(), speed, way })
}

#[test]
fn every_code_of_a_state_is_read_back() {
    for code in 0..=18 {
        assert_eq!(state::of_code(code).code(), code);
    }
}

#[test]
fn a_drone_stands_as_far_along_the_plan_as_it_has_flown() {
    let line = PlanLine { name: "main".into(), points: vec![[1.0, 0.0], [5.0, 0.0], [5.0, 9.0]] };
    let plan = Plan { lines: vec![line], base_m: 0.65, ..Plan::default() };
    let heard =
        [at(0.0, Message::Plan(plan)), at(1.0, report(0, 3, 6.0)), at(2.0, report(0, 3, 3.0))];
    let trace = record_of("flight".into(), &heard).trace;
    let head = |frame: usize| trace.frames[frame].drones[0];
    let is_at = |frame, x, y| head(frame).pose.at.distance(Point2::new(x, y)).0 < 1e-3;
    assert!(head(0).way.is_nan());
    assert!(is_at(5, 5.0, 3.0) && is_at(10, 5.0, 0.0), "{:?}", trace.frames);
    assert_eq!(trace.nodes.last().unwrap().role, Role::Base);
    assert_eq!(trace.nodes.last().unwrap().id, NodeId(4));
}

#[test]
fn a_link_of_a_silent_drone_ends() {
    let heard = [at(0.0, report(1, 4, 1.0)), at(9.0, report(0, 3, 2.0))];
    let trace = record_of("flight".into(), &heard).trace;
    let links = trace.frames.iter().filter(|frame| frame.drones[1].back.is_some()).count();
    assert_eq!(links, 26, "5 s, both ends counted");
    assert_eq!(trace.frames.len(), 46);
}

#[test]
fn an_order_stands_once_the_base_has_taken_it() {
    let heard = [
        at(0.0, report(0, 0, 0.0)),
        at(1.0, given("explore", Some(0.25), None)),
        at(2.0, given("branch", None, Some("left"))),
        at(3.0, given("recall", None, None)),
        at(4.0, Message::Stop),
    ];
    let trace = record_of("flight".into(), &heard).trace;
    let order = |second: usize| mission::trace::order_words(trace.frames[second * 5].order);
    assert_eq!(
        [0, 1, 2, 3, 4].map(order),
        ["wait", "explore at 0.25 m/s", "explore at 0.25 m/s, left at junctions", "return", "stop"]
    );
}

#[test]
fn a_report_can_be_made_of_little() {
    let heard = [at(0.0, report(2, 4, 9_999.0))];
    let StationRecord { trace, summary } = record_of("flight".into(), &heard);
    let page = report::report::html(&trace, &summary).unwrap();
    assert!(page.contains("recorded") && !page.contains("seed"));
}
