//! Reads the address of a drone, and opens the way to it.

use std::fmt;
use std::net::{SocketAddr, ToSocketAddrs};
use std::str::FromStr;

use bridge::RadioAddress;
use input::InputError;
use units::NODES;

/// The address of a drone.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Address {
    /// A drone at a UDP port.
    Udp {
        /// The machine.
        host: String,
        /// The port.
        port: u16,
    },
    /// A drone at a Crazyradio, by the address that Bitcraze's tools use.
    Radio(RadioAddress),
}

/// The port behind which a drone is. Where the drone is at a Crazyradio, this ends with the value.
#[derive(Debug)]
pub struct Way {
    /// The port.
    pub port: SocketAddr,
    #[cfg(feature = "crazyradio")]
    _radio: Option<crate::radio::Bridge>,
}

impl FromStr for Address {
    type Err = InputError;

    fn from_str(text: &str) -> Result<Self, InputError> {
        if text.starts_with("radio://") {
            return text.parse().map(Self::Radio);
        }
        let parts = text.strip_prefix("udp://").and_then(|rest| rest.rsplit_once(':'));
        let address = parts.and_then(|(host, port)| {
            let host = host.trim_start_matches('[').trim_end_matches(']');
            let port = port.parse().ok().filter(|port| *port > 0)?;
            (!host.is_empty()).then(|| Self::Udp { host: host.to_owned(), port })
        });
        address.ok_or_else(|| {
            let remedy = "give udp://HOST:PORT, such as udp://127.0.0.1:19854, or \
                          radio://0/80/2M/E7E7E7E70F";
            InputError::new(format!("{text:?} is no address"), remedy)
        })
    }
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Udp { host, port } if host.contains(':') => write!(f, "udp://[{host}]:{port}"),
            Self::Udp { host, port } => write!(f, "udp://{host}:{port}"),
            Self::Radio(address) => {
                write!(f, "{address}")?;
                address.rate.map_or(Ok(()), |rate| write!(f, "?rate_limit={}", rate.polls()))
            }
        }
    }
}

impl Address {
    /// Whether two addresses are those of the same drone, through whichever Crazyradio and at
    /// whichever limit of polls.
    #[must_use]
    pub fn is_same_drone(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Radio(own), Self::Radio(other)) => {
                let key = |at: &RadioAddress| (at.channel, at.datarate, at.address);
                key(own) == key(other)
            }
            _ => self == other,
        }
    }

    /// Whether drones with these addresses can hear each other: on the radio they need the same
    /// channel and data rate. Nothing is known of drones at UDP ports.
    #[must_use]
    pub fn shares_channel(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Radio(own), Self::Radio(other)) => {
                (own.channel, own.datarate) == (other.channel, other.datarate)
            }
            _ => true,
        }
    }

    /// The number in which a radio address ends, if it is a drone's number, 0 to 15.
    #[must_use]
    pub fn number(&self) -> Option<u8> {
        let Self::Radio(RadioAddress { address, .. }) = self else { return None };
        let [.., last] = address.0;
        Some(last).filter(|last| usize::from(*last) < NODES)
    }

    /// Opens the way to the drone.
    ///
    /// # Errors
    /// If there is no such machine, or no Crazyradio that can be used.
    pub fn open(&self) -> Result<Way, InputError> {
        match self {
            Self::Udp { host, port } => {
                let found = (host.as_str(), *port).to_socket_addrs().ok();
                let port = found.and_then(|mut found| found.next()).ok_or_else(|| {
                    InputError::new(
                        format!("there is no machine {host}"),
                        "check the name in the drone's address",
                    )
                })?;
                Ok(Way {
                    port,
                    #[cfg(feature = "crazyradio")]
                    _radio: None,
                })
            }
            Self::Radio(address) => radio(address),
        }
    }
}

#[cfg(feature = "crazyradio")]
fn radio(address: &RadioAddress) -> Result<Way, InputError> {
    let radio = crate::radio::Bridge::open(address)?;
    Ok(Way { port: radio.port(), _radio: Some(radio) })
}

/// The answer of a build without the driver.
#[cfg(not(feature = "crazyradio"))]
fn radio(address: &RadioAddress) -> Result<Way, InputError> {
    Err(InputError::new(
        "this uchain-ground was built without the Crazyradio's driver",
        format!(
            "build it with --features crazyradio, or start `cargo sim-radio bridge {address}` and \
             give udp://127.0.0.1:19850"
        ),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_udp_with_host_and_port() {
        let address = |host: &str, port| Ok(Address::Udp { host: host.to_owned(), port });
        assert_eq!("udp://127.0.0.1:19854".parse(), address("127.0.0.1", 19_854));
        assert_eq!("udp://[::1]:1".parse(), address("::1", 1));
        for wrong in
            ["", "127.0.0.1:19854", "udp://127.0.0.1", "udp://:1", "udp://a:0", "udp://a:b"]
        {
            assert!(wrong.parse::<Address>().is_err(), "{wrong}");
        }
        for wrong in
            ["radio://0/80/2M", "radio://0/126/2M/E7E7E7E70F", "radio://0/80/3M/E7E7E7E70F"]
        {
            assert!(wrong.parse::<Address>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_drone_on_the_radio_is_known_by_channel_data_rate_and_address() {
        let address = |text: &str| text.parse::<Address>().unwrap();
        let own = address("radio://0/80/2M/E7E7E7E70F");
        assert!(own.is_same_drone(&address("radio://1/80/2M/e7e7e7e70f?rate_limit=50")));
        assert!(!own.is_same_drone(&address("radio://0/80/2M/E7E7E7E70E")));
        assert!(own.shares_channel(&address("radio://1/80/2M/E7E7E7E700")));
        assert!(!own.shares_channel(&address("radio://0/81/2M/E7E7E7E700")));
        assert!(!own.shares_channel(&address("radio://0/80/1M/E7E7E7E700")));
        assert!(own.shares_channel(&address("udp://127.0.0.1:19854")));
        assert_eq!(own.number(), Some(15));
        assert_eq!(address("radio://0/80/2M/E7E7E7E7E7").number(), None);
    }

    #[test]
    fn an_address_is_shown_as_it_is_given() {
        let radio = "radio://0/80/2M/E7E7E7E70F";
        let limited = "radio://0/80/2M/E7E7E7E70F?rate_limit=50";
        for text in ["udp://127.0.0.1:19854", "udp://[::1]:1", radio, limited] {
            assert_eq!(text.parse::<Address>().unwrap().to_string(), text);
        }
    }
}
