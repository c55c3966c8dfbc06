//! What a robot tells the others, and when.

use units::{Duration, Instant, Point2};

use crate::atlas::Ground;
use crate::cluster::RobotSet;
use crate::explorer::{Explorer, PACKETS_A_STEP, is_due};
use crate::packet::{Body, Packet, Status};

/// Changes that a robot of the cluster lacks are sent again where it has got none for so long: a status later,
/// and half.
const RESEND: Duration = Duration::from_millis(1_500);
/// The packets of changes of a step.
const CHANGES_A_STEP: usize = 2;

impl<G: Ground, const ROBOTS: usize, const RECORDS: usize> Explorer<G, ROBOTS, RECORDS> {
    /// Tells what has changed, and how the robot is.
    pub(crate) fn tell(&mut self, now: Instant, position: Point2, members: RobotSet) {
        let activity = self.told_activity();
        let is_new = self.told.is_none_or(|(_, told)| told != activity);
        if is_new || is_due(self.told.map(|(at, _)| at), now) {
            self.told = Some((now, activity));
            let known = self.team.known(now);
            let (goal, version) = (self.last_goal, self.ledger.version());
            self.send(Body::Status(Status { position, activity, goal, version, known }));
        }
        if members.len() > 1 {
            self.tell_changes(now, members);
        }
    }

    fn tell_changes(&mut self, now: Instant, members: RobotSet) {
        let had = self.team.least_acknowledged(members).unwrap_or(self.sent);
        let (acknowledged, since) = self.acknowledged;
        let is_stuck = had < self.sent && had == acknowledged;
        if !is_stuck {
            self.acknowledged = (had, now);
        } else if now.since(since) >= RESEND {
            self.sent = had;
            self.acknowledged = (had, now);
        }
        for _ in 0..CHANGES_A_STEP {
            // Changes wait until the packets before them are out.
            if self.outbox.len() >= PACKETS_A_STEP {
                break;
            }
            let Some(changes) = self.ledger.changes_after(self.sent) else { break };
            self.sent = changes.upto;
            self.send(Body::Changes(changes));
        }
    }

    /// Makes a packet, and sends it.
    pub(crate) fn send(&mut self, body: Body) {
        let number = self.config.number;
        self.sequence = self.sequence.wrapping_add(1);
        let packet = Packet { origin: number, sender: number, sequence: self.sequence, body };
        self.put_out(&packet);
    }

    /// Puts a packet behind those that wait to be sent; one for which there is no room is lost, as on
    /// the air.
    pub(crate) fn put_out(&mut self, packet: &Packet) {
        let _ = self.outbox.push_back(packet.encode());
    }
}
