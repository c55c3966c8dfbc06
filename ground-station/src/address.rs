//! Reads the address of a drone, and opens the way to it.

use std::fmt;
use std::net::{SocketAddr, ToSocketAddrs};
use std::str::FromStr;

use input::InputError;

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
    Radio(String),
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
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text.starts_with("radio://") {
            return Ok(Self::Radio(text.to_owned()));
        }
        let parts = text.strip_prefix("udp://").and_then(|rest| rest.rsplit_once(':'));
        let address = parts.and_then(|(host, port)| {
            let host = host.trim_start_matches('[').trim_end_matches(']');
            let port = port.parse().ok().filter(|port| *port > 0)?;
            (!host.is_empty()).then(|| Self::Udp { host: host.to_owned(), port })
        });
        address.ok_or_else(|| "give udp://HOST:PORT, such as udp://127.0.0.1:19854".to_owned())
    }
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Udp { host, port } if host.contains(':') => write!(f, "udp://[{host}]:{port}"),
            Self::Udp { host, port } => write!(f, "udp://{host}:{port}"),
            Self::Radio(address) => f.write_str(address),
        }
    }
}

impl Address {
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
fn radio(address: &str) -> Result<Way, InputError> {
    let radio = crate::radio::Bridge::open(address)?;
    Ok(Way { port: radio.port(), _radio: Some(radio) })
}

/// The answer of a build without the driver.
#[cfg(not(feature = "crazyradio"))]
fn radio(address: &str) -> Result<Way, InputError> {
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
        let radio = "radio://0/80/2M/E7E7E7E70F";
        assert_eq!(radio.parse(), Ok(Address::Radio(radio.to_owned())));
    }

    #[test]
    fn an_address_is_shown_as_it_is_given() {
        for text in ["udp://127.0.0.1:19854", "udp://[::1]:1", "radio://0/80/2M/E7E7E7E70F"] {
            assert_eq!(text.parse::<Address>().unwrap().to_string(), text);
        }
    }
}
