//! A station in the test's own process, beside a base that notes what it is ordered, and when.

use std::net::{Ipv4Addr, SocketAddr};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use crtp::{Access as Rights, Event, OperatorTask, Outcome, Parameters, Server, Snapshot};
use ground_station::access::Access;
use ground_station::link::Link;
use ground_station::station::{self, Setup};
use ground_station::{listener, server};
use tokio::task::JoinHandle;
use units::{NodeId, Role};
use wire::crtp::Packet;

/// What the station told the base.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Told {
    /// The speed of an order to explore, in m/s.
    Speed(f32),
    Stop,
}

/// What the base was told, in its order.
pub(crate) type Log = Arc<Mutex<Vec<(Instant, Told)>>>;

/// The drones' own CRTP server as a base without drones.
struct NotingBase {
    server: Server,
    parameters: Parameters,
    snapshot: Snapshot,
    began: Instant,
    log: Log,
}

impl NotingBase {
    fn now(&self) -> units::Instant {
        units::Instant::from_micros(self.began.elapsed().as_micros() as u64)
    }
}

impl Link for NotingBase {
    async fn send(&mut self, packet: &Packet) {
        let (at, now, log) = (Instant::now(), self.now(), Arc::clone(&self.log));
        let before = self.parameters.speed;
        self.server.receive(
            now,
            packet.bytes(),
            Rights::Full,
            &mut self.parameters,
            |event, parameters| {
                if event == Event::EmergencyStop {
                    // A stop is never replaced by another order.
                    parameters.task = OperatorTask::Stop;
                    log.lock().unwrap().push((at, Told::Stop));
                }
                Outcome::Done
            },
        );
        if self.parameters.speed != before {
            log.lock().unwrap().push((at, Told::Speed(self.parameters.speed.0)));
        }
    }

    async fn receive(&mut self) -> Packet {
        loop {
            let now = self.now();
            self.snapshot.taken = now;
            if let Some(packet) = self.server.poll(now, &self.snapshot, &self.parameters) {
                return packet;
            }
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
    }

    async fn go_on(&mut self) -> bool {
        false
    }
}

/// A station; it ends when it is dropped.
pub(crate) struct LocalStation {
    pub(crate) at: SocketAddr,
    pub(crate) session: String,
    pub(crate) log: Log,
    serving: JoinHandle<()>,
}

impl LocalStation {
    pub(crate) async fn start() -> Self {
        let mut parameters = Parameters::DEFAULT;
        (parameters.about.node, parameters.about.role) = (NodeId(4), Role::Base);
        let log = Log::default();
        let base = NotingBase {
            server: Server::new(),
            parameters,
            snapshot: Snapshot::DEFAULT,
            began: Instant::now(),
            log: Arc::clone(&log),
        };
        let access = Access::new(Ipv4Addr::LOCALHOST.into(), None).unwrap();
        let session = access.session().to_owned();
        let socket = listener::open((Ipv4Addr::LOCALHOST, 0).into()).unwrap();
        let at = socket.local_addr().unwrap();
        let routes = server::router(access, station::start(base, Setup::default()));
        let serving = tokio::spawn(listener::serve(socket, routes));
        Self { at, session, log, serving }
    }
}

impl Drop for LocalStation {
    fn drop(&mut self) {
        self.serving.abort();
    }
}
