//! Who may connect to the station.

use tokio_tungstenite::connect_async;
use tokio_tungstenite::tungstenite::client::IntoClientRequest;

use crate::page_client::{get, session};
use crate::station_process::{StationProcess, command};

/// No base listens there: these tests need none.
const NO_BASE: &str = "udp://127.0.0.1:9";

fn status(answer: &str) -> &str {
    answer.split(' ').nth(1).unwrap()
}

#[test]
fn requests_of_other_sites_are_refused() {
    let station = StationProcess::start(NO_BASE, &[]);
    let host = format!("Host: {}", station.page);
    let origin = format!("Origin: http://{}", station.page);
    for path in ["/", "/page.js", "/page.css"] {
        assert_eq!(status(&get(station.page, path, &[&host])), "200", "{path}");
        assert_eq!(status(&get(station.page, path, &[&host, &origin])), "200", "{path}");
        for refused in [
            &[host.as_str(), "Origin: http://evil.example"][..],
            &[&host, "Origin: null"],
            &["Host: evil.example"],
        ] {
            assert_eq!(status(&get(station.page, path, refused)), "403", "{path} {refused:?}");
        }
    }
}

#[test]
fn no_other_page_may_show_the_station_in_a_frame() {
    let station = StationProcess::start(NO_BASE, &[]);
    let answer = get(station.page, "/", &[&format!("Host: {}", station.page)]);
    assert!(answer.contains("frame-ancestors 'none'"), "{answer}");
}

#[tokio::test]
async fn the_socket_needs_the_session_token_and_the_origin() {
    let station = StationProcess::start(NO_BASE, &[]);
    let at = station.page;
    let good = format!("ws://{at}/live?session={}", session(at));
    assert!(connect_async(&good).await.is_ok());
    for wrong in [format!("ws://{at}/live"), format!("ws://{at}/live?session=0")] {
        assert!(connect_async(&wrong).await.is_err(), "{wrong}");
    }
    let mut of_another_site = good.into_client_request().unwrap();
    of_another_site.headers_mut().insert("origin", "http://evil.example".parse().unwrap());
    assert!(connect_async(of_another_site).await.is_err());
}

#[test]
fn the_page_needs_the_token_where_one_is_set() {
    let station = StationProcess::start(NO_BASE, &["--token", "fruit bats"]);
    let host = format!("Host: {}", station.page);
    assert_eq!(status(&get(station.page, "/?token=fruit+bats", &[&host])), "200");
    for path in ["/", "/?token=", "/?token=fruit+cats"] {
        let answer = get(station.page, path, &[&host]);
        assert_eq!(status(&answer), "403", "{path}");
        assert!(!answer.contains("name=\"session\""), "{path}");
    }
}

#[test]
fn bad_input_is_refused_with_one_line_and_status_2() {
    let cases: [(&[&str], &str); 4] = [
        (&["udp://127.0.0.1:9", "--host", "0.0.0.0"], "--token"),
        (&["127.0.0.1:9"], "udp://HOST:PORT"),
        (&["radio://0/80/2M/E7E7E7E70F"], "bridge"),
        (&[], "BASE"),
    ];
    for (arguments, remedy) in cases {
        let output = command().args(arguments).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        let text = String::from_utf8(output.stderr).unwrap();
        assert!(text.contains(remedy), "{arguments:?}: {text}");
    }
}
