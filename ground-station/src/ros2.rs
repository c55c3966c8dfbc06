//! The station as a node of ROS 2: a page for programs.
//!
//! It reads the states that the pages read, publishes them, and, where that was asked for, turns
//! `/cmd_vel` and `/order` into the requests of a page, [`PageId::PROGRAM`]. So the station judges them
//! as it judges those of any page: who steers, how old an act may be, who is gone.
//!
//! ```text
//!   station ──state, 10 Hz──▶ Published ──▶ Node ──DDS──▶ ros2 topic echo, rqt, PlotJuggler …
//!      ▲                                     │
//!      └── requests of a page ◀── Pilot ◀────┘◀── /cmd_vel, /order
//! ```
//! The node has a thread of its own, so that a DDS that is busy holds up no order of a page.

mod commands;
mod pilot;
mod publish;
mod state;

use std::time::{Duration, Instant, SystemTime};
use std::{io, thread};

use ros2_topics::{Commands, Node};
use station_log::Line;
use tokio::sync::broadcast::Receiver;
use tokio::sync::broadcast::error::TryRecvError;

use crate::live_stream::Sample;
use crate::station::Handle;
use crate::steering::{LineId, PageId};
use commands::Heard;
use pilot::Pilot;
use publish::Published;
use state::State;

/// The time between two looks at what has come.
const TICK: Duration = Duration::from_millis(20);

/// Begins to publish what the station knows, and to follow the commands, where there are some. It ends
/// with the station.
///
/// # Errors
/// If the topics cannot be published, or the machine starts no thread.
pub fn start(mut node: Node, commands: Option<Commands>, station: Handle) -> io::Result<()> {
    let published = Published::new(&mut node)?;
    let runtime = tokio::runtime::Builder::new_current_thread().enable_time().build()?;
    let companion = Companion {
        node,
        published,
        pilot: commands.map(|commands| (commands, Pilot::default())),
        has_failed: false,
    };
    let run = move || runtime.block_on(companion.run(station));
    thread::Builder::new().name("ros2".into()).spawn(run).map(drop)
}

struct Companion {
    node: Node,
    published: Published,
    pilot: Option<(Commands, Pilot)>,
    /// Whether a message could not be published, which is said once.
    has_failed: bool,
}

impl Companion {
    async fn run(mut self, station: Handle) {
        let (mut status, (_, mut samples)) = (station.status(), station.stream().join());
        let mut tick = tokio::time::interval(TICK);
        let mut state = None;
        if self.pilot.is_some() {
            station.open(LineId::PROGRAM, PageId::PROGRAM, false).await;
        }
        loop {
            tick.tick().await;
            let Ok(is_new) = status.has_changed() else { return };
            if is_new {
                state = State::read(&status.borrow_and_update()).or(state);
            }
            let Some(state) = &state else { continue };
            let notices = lines(&mut samples);
            if let Err(error) = self.published.put(&mut self.node, state, &notices) {
                self.fail(&error.to_string());
            } else if self.node.lost() > 0 {
                self.fail("the DDS did not take a message");
            }
            let Some((commands, pilot)) = &mut self.pilot else { continue };
            let heard = Heard::take(commands, SystemTime::now());
            let said = pilot.heed(Instant::now(), state, heard);
            for (echo, request) in said.requests {
                station.send(PageId::PROGRAM, echo, request).await;
            }
            said.complaints.iter().for_each(|line| eprintln!("uchain-ground: {line}"));
        }
    }

    fn fail(&mut self, wrong: &str) {
        if !std::mem::replace(&mut self.has_failed, true) {
            eprintln!("uchain-ground: not everything is published to ROS 2: {wrong}");
        }
    }
}

/// The notices of the station since the last call.
fn lines(samples: &mut Receiver<Sample>) -> Vec<String> {
    let mut lines = Vec::new();
    loop {
        match samples.try_recv() {
            Ok(sample) if sample.channel.topic == Line::NOTICE => {
                let line = serde_json::from_slice::<Line>(&sample.json);
                lines.extend(line.ok().map(|line| line.text));
            }
            // What a slow node has missed is gone.
            Ok(_) | Err(TryRecvError::Lagged(_)) => {}
            Err(TryRecvError::Empty | TryRecvError::Closed) => return lines,
        }
    }
}
