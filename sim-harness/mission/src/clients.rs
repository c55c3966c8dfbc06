//! The clients of the members' CRTP servers.

use onboard::Snapshot;

use super::Mission;
use super::member::Onboard;

impl Mission<'_> {
    /// Gives a member a packet of a client: one on the host at once, one in an emulator over its
    /// radio chip.
    pub fn client(&mut self, member: usize, packet: &[u8]) {
        let now_us = self.now_us;
        match self.members.get_mut(member).map(|member| &mut member.onboard) {
            Some(Onboard::Hosted(hosted)) => {
                let (drone, now) = hosted.at(now_us);
                drone.client(now, packet);
                hosted.look(now_us);
            }
            Some(Onboard::Emulated(emulated)) => emulated.client(now_us, packet),
            None => {}
        }
    }

    /// Lets what is due by the clock at a member's server happen, and gives `take` the packets that
    /// it then sends to its client. `measured` is what the member's body has to show.
    pub fn poll_client(&mut self, member: usize, measured: &Snapshot, mut take: impl FnMut(&[u8])) {
        /// More packets than a server's queues hold.
        const BURST: usize = 64;
        let now_us = self.now_us;
        let hosted = match self.members.get_mut(member).map(|member| &mut member.onboard) {
            Some(Onboard::Hosted(hosted)) => hosted,
            // Its radio chip answers one packet for each that it is asked for.
            Some(Onboard::Emulated(emulated)) => return emulated.take_answers(take),
            None => return,
        };
        let (drone, now) = hosted.at(now_us);
        drone.attend(now);
        let snapshot = drone.snapshot(now, measured);
        for _ in 0..BURST {
            let Some(packet) = drone.poll_client(now, &snapshot) else { break };
            take(packet.bytes());
        }
        hosted.look(now_us);
    }
}
