//! What takes the station's means: connections that say nothing, pages that do not read, tokens
//! that are guessed.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::process::Stdio;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use futures_util::{SinkExt, StreamExt};
use serde_json::json;
use tokio::net::TcpSocket;
use tokio_tungstenite::client_async;
use tokio_tungstenite::tungstenite::Message;

use crate::local_station::{LocalStation, Told};
use crate::page_client::{PageClient, get};
use crate::resilient_page::ResilientPage;
use crate::station_process::{StationProcess, command};

/// No base listens there.
const NO_BASE: &str = "udp://127.0.0.1:9";

/// More connections than the station may have files: it never has so many that a new page finds none
/// left, which would wait until the time of those that say nothing is over.
#[cfg(target_os = "linux")]
#[test]
fn a_new_page_is_let_in_while_connections_that_say_nothing_are_held_open() {
    let station = StationProcess::start_with_files(NO_BASE, 200);
    let (files, is_done) = (station.files(), AtomicBool::new(false));
    let count = || std::fs::read_dir(&files).map_or(0, Iterator::count);
    let mut held: Vec<_> = (0..150).map(|_| TcpStream::connect(station.page).unwrap()).collect();
    for half in held.iter_mut().skip(100) {
        half.write_all(b"GET / HTTP/1.1\r\nHost: 127").unwrap();
    }
    let watch = || {
        let (began, mut most) = (Instant::now(), 0);
        // Where the page is never let in, this ends too.
        while !is_done.load(Ordering::Relaxed) && began.elapsed() < Duration::from_secs(120) {
            most = most.max(count());
            std::thread::sleep(Duration::from_millis(2));
        }
        most
    };
    let most = std::thread::scope(|scope| {
        let watching = scope.spawn(watch);
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        for _ in 0..3 {
            held.extend((0..100).map(|_| TcpStream::connect(station.page).unwrap()));
            runtime.block_on(async {
                let mut page = PageClient::open(station.page).await;
                page.wait_for("state", |_| true).await;
            });
        }
        is_done.store(true, Ordering::Relaxed);
        watching.join().unwrap()
    });
    // Those that wait, the pages', and some of the station's own.
    assert!((129..170).contains(&most), "{most} files");
}

#[test]
fn a_connection_whose_headers_do_not_end_is_closed() {
    let station = StationProcess::start(NO_BASE, &[]);
    let mut slow = TcpStream::connect(station.page).unwrap();
    slow.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
    slow.write_all(b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n").unwrap();
    let mut answer = Vec::new();
    // A reset ends it as well.
    let closed = slow.read_to_end(&mut answer);
    assert!(!matches!(&closed, Err(error) if error.kind() == std::io::ErrorKind::WouldBlock));
    assert!(!String::from_utf8_lossy(&answer).contains("200 OK"));
}

/// The page asks for more states than fit into the line, and reads none of them.
#[tokio::test]
async fn a_page_that_reads_nothing_holds_up_no_other_and_is_heard_for_its_stop() {
    let station = LocalStation::start().await;
    let other = ResilientPage::open(station.at, &station.session, 1);
    other.wait_for("state", |seen| !seen.state.is_null()).await;
    let socket = TcpSocket::new_v4().unwrap();
    socket.set_recv_buffer_size(4 * 1_024).unwrap();
    let stream = socket.connect(station.at).await.unwrap();
    let url = format!("ws://{}/live?session={}&page=2", station.at, station.session);
    let (mut deaf, _) = client_async(url, stream).await.unwrap();
    let refused = json!({ "do": "order", "order": "land" }).to_string();
    for _ in 0..300 {
        for _ in 0..10 {
            deaf.send(Message::Text(refused.as_str().into())).await.unwrap();
        }
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    let stamp = other.seen().state["stamp"].as_u64();
    deaf.send(Message::Text(r#"{"do":"stop","seq":9000}"#.into())).await.unwrap();
    other.wait_for("stop", |seen| seen.state["stop"].is_object()).await;
    assert!(other.seen().state["stamp"].as_u64() > stamp);
    assert!(station.log.lock().unwrap().iter().any(|(_, told)| *told == Told::Stop));
    // It was given some of its states at most, and no more come.
    let mut read = 0;
    while let Ok(Some(Ok(_))) = tokio::time::timeout(Duration::from_secs(3), deaf.next()).await {
        read += 1;
    }
    assert!(read < 3_000, "{read}");
}

#[tokio::test]
async fn a_page_that_neither_reads_nor_writes_is_dropped() {
    let station = LocalStation::start().await;
    let other = ResilientPage::open(station.at, &station.session, 1);
    let url = format!("ws://{}/live?session={}&page=2", station.at, station.session);
    let (silent, _) = tokio_tungstenite::connect_async(url).await.unwrap();
    let number = |n| {
        move |seen: &crate::resilient_page::Seen| {
            seen.state["heard"].as_array().is_some_and(|heard| heard.len() == n)
        }
    };
    other.wait_for("both pages", number(2)).await;
    other.wait_for("its own page alone", number(1)).await;
    drop(silent);
}

fn status(answer: &str) -> &str {
    answer.split(' ').nth(1).unwrap()
}

#[test]
fn wrong_tokens_are_slowed_down_and_told() {
    let mut command = command();
    command.args(["--port", "0", NO_BASE]).env("UCHAIN_TOKEN", "7f3a-99c2-open");
    let mut process = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut said = process.stderr.take().unwrap();
    let station = StationProcess::running(process);
    let host = format!("Host: {}", station.page);
    let began = Instant::now();
    for guess in 0..4 {
        let answer = get(station.page, &format!("/?token=0000000{guess}"), &[&host]);
        assert_eq!(status(&answer), "403");
    }
    assert_eq!(status(&get(station.page, "/?token=7f3a-99c2-open", &[&host])), "200");
    assert!(began.elapsed() >= Duration::from_secs(4), "{:?}", began.elapsed());
    station.kill();
    let mut lines = String::new();
    said.read_to_string(&mut lines).unwrap();
    assert_eq!(lines.lines().count(), 4, "{lines}");
    assert!(lines.contains("a wrong token from 127.0.0.1 (4 so far)"), "{lines}");
}

#[test]
fn a_token_that_is_made_is_printed_with_the_address_and_stands_in_no_argument() {
    let (station, line) = StationProcess::start_and_read(&["--new-token", NO_BASE]);
    let (_, token) = line.split_once("?token=").expect(&line);
    let (token, _) = token.split_once(';').unwrap();
    assert_eq!(token.len(), 32);
    let host = format!("Host: {}", station.page);
    assert_eq!(status(&get(station.page, "/", &[&host])), "403");
    assert_eq!(status(&get(station.page, &format!("/?token={token}"), &[&host])), "200");
}

#[test]
fn a_token_that_can_be_guessed_or_read_is_refused_or_told() {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR"));
    let file = folder.join("loose-token");
    std::fs::write(&file, "a long token").unwrap();
    let path = file.to_str().unwrap();
    for (arguments, why) in [
        (&["--token", "1234"][..], "shorter than 8"),
        (&["--token-file", path], "chmod 600"),
        (&["--token-file", "/does/not/exist"], "give a file"),
        (&["--token-file", path, "--new-token"], "cannot be used with"),
    ] {
        let output = command().arg(NO_BASE).args(arguments).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        let text = String::from_utf8(output.stderr).unwrap();
        assert!(text.contains(why), "{arguments:?}: {text}");
        assert!(!text.contains("1234"), "{text}");
        let is_listed = text.contains("in the list of processes");
        assert_eq!(is_listed, arguments.contains(&"--token"), "{text}");
    }
}
