//! Carries CRTP packets between the station and a base.

use std::future::Future;
use std::io;
use std::net::SocketAddr;

use tokio::net::UdpSocket;
use wire::crtp::{MAX_PACKET, Packet};

/// A line to one base.
pub trait Link: Send + 'static {
    /// Sends a packet. A packet that the line cannot take is lost, as on the air.
    fn send(&mut self, packet: &Packet) -> impl Future<Output = ()> + Send;

    /// Waits for the next packet of the base. Where this is given up before a packet has come, no
    /// packet is lost.
    fn receive(&mut self) -> impl Future<Output = Packet> + Send;
}

/// A base at a UDP port: a simulated one, or a real one behind `uchain bridge`. Each datagram is
/// one packet.
#[derive(Debug)]
pub struct UdpLink(UdpSocket);

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
        Ok(Self(socket))
    }
}

impl Link for UdpLink {
    async fn send(&mut self, packet: &Packet) {
        // Where no server listens, the machine reports that here; the session notices the silence.
        let _ = self.0.send(packet.bytes()).await;
    }

    async fn receive(&mut self) -> Packet {
        let mut bytes = [0; MAX_PACKET + 1];
        loop {
            match self.0.recv(&mut bytes).await {
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
}
