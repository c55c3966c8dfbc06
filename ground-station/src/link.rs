//! Carries CRTP packets between the station and a base.

use std::future::Future;
use std::io;
use std::net::SocketAddr;

use tokio::net::UdpSocket;
use units::NODES;
use wire::crtp::{MAX_PACKET, Packet};

/// A line to one base.
pub trait Link: Send + 'static {
    /// Sends a packet. A packet that the line cannot take is lost, as on the air.
    fn send(&mut self, packet: &Packet) -> impl Future<Output = ()> + Send;

    /// Waits for the next packet of the base. Where this is given up before a packet has come, no
    /// packet is lost.
    fn receive(&mut self) -> impl Future<Output = Packet> + Send;

    /// Goes on to the next drone of the chain, away from the head. Returns whether the line has
    /// one.
    fn go_on(&mut self) -> impl Future<Output = bool> + Send;
}

/// A base at a UDP port: a simulated one, or a real one behind `uchain bridge`. Each datagram is
/// one packet.
#[derive(Debug)]
pub struct UdpLink {
    socket: UdpSocket,
    base: SocketAddr,
    /// The number of ports that may still be tried.
    left: usize,
}

impl UdpLink {
    /// Opens a socket of this machine that hears the base alone.
    ///
    /// # Errors
    /// If the machine gives no socket, or there is no way to the address.
    pub async fn open(base: SocketAddr) -> io::Result<Self> {
        let any: SocketAddr = if base.is_ipv4() {
            (std::net::Ipv4Addr::UNSPECIFIED, 0).into()
        } else {
            (std::net::Ipv6Addr::UNSPECIFIED, 0).into()
        };
        let socket = UdpSocket::bind(any).await?;
        socket.connect(base).await?;
        Ok(Self { socket, base, left: NODES - 1 })
    }
}

impl Link for UdpLink {
    async fn send(&mut self, packet: &Packet) {
        // Where no server listens, the machine reports that here; the session notices the silence.
        let _ = self.socket.send(packet.bytes()).await;
    }

    async fn receive(&mut self) -> Packet {
        let mut bytes = [0; MAX_PACKET + 1];
        loop {
            match self.socket.recv(&mut bytes).await {
                Ok(length) => {
                    let datagram = bytes.get(..length).unwrap_or_default();
                    if let Ok(packet) = Packet::from_bytes(datagram) {
                        return packet;
                    }
                }
                // "Connection refused" stands for a datagram that no server took.
                Err(_) => tokio::time::sleep(std::time::Duration::from_millis(10)).await,
            }
        }
    }
    /// `uchain serve` gives the drones of a chain one port after the other, the base the last.
    async fn go_on(&mut self) -> bool {
        let (Some(left), Some(port)) = (self.left.checked_sub(1), self.base.port().checked_add(1))
        else {
            return false;
        };
        self.left = left;
        self.base.set_port(port);
        self.socket.connect(self.base).await.is_ok()
    }
}
