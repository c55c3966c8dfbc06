//! The address of a drone on the radio, as Bitcraze's tools write it.

use std::fmt;
use std::str::FromStr;

use input::InputError;
use wire::radio::{Address, Channel, Datarate};

use super::Rate;

/// The address of a drone: `radio://0/80/2M/E7E7E7E7E7?rate_limit=100`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RadioAddress {
    /// The Crazyradio, 0 for the first that is plugged in.
    pub dongle: usize,
    /// The channel.
    pub channel: Channel,
    /// The bits per second.
    pub datarate: Datarate,
    /// The drone's address.
    pub address: Address,
    /// The `rate_limit`, where there is one.
    pub rate: Option<Rate>,
}

impl FromStr for RadioAddress {
    type Err = InputError;

    fn from_str(text: &str) -> Result<Self, InputError> {
        let wrong = |what: String| {
            let wrong = format!("the address \"{text}\" {what}");
            InputError::new(wrong, "give one such as radio://0/80/2M/E7E7E7E703")
        };
        let Some(rest) = text.strip_prefix("radio://") else {
            return Err(wrong("does not begin with radio://".into()));
        };
        let (path, options) = rest.split_once('?').unwrap_or((rest, ""));
        let parts: Vec<_> = path.split('/').collect();
        let [dongle, channel, datarate, address] = parts[..] else {
            return Err(wrong("is not a dongle, a channel, a data rate and an address".into()));
        };
        Ok(Self {
            dongle: dongle
                .parse()
                .map_err(|_| wrong(format!("has \"{dongle}\" for a dongle's number")))?,
            channel: channel
                .parse()
                .ok()
                .and_then(Channel::new)
                .ok_or_else(|| wrong(format!("has \"{channel}\" for a channel of 0 to 125")))?,
            datarate: datarate_named(datarate)
                .ok_or_else(|| wrong(format!("has \"{datarate}\" for 250K, 1M or 2M")))?,
            address: hexadecimal(address)
                .ok_or_else(|| wrong(format!("has \"{address}\" for ten hexadecimal digits")))?,
            rate: rate(options).map_err(wrong)?,
        })
    }
}

impl fmt::Display for RadioAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { dongle, channel, datarate, address, .. } = self;
        let datarate = DATARATES.iter().find(|(_, rate)| rate == datarate).map_or("", |row| row.0);
        write!(f, "radio://{dongle}/{}/{datarate}/", channel.number())?;
        address.0.iter().try_for_each(|byte| write!(f, "{byte:02X}"))
    }
}

const DATARATES: [(&str, Datarate); 3] =
    [("250K", Datarate::Kbit250), ("1M", Datarate::Mbit1), ("2M", Datarate::Mbit2)];

fn datarate_named(name: &str) -> Option<Datarate> {
    DATARATES.iter().find(|(is, _)| is.eq_ignore_ascii_case(name)).map(|(_, rate)| *rate)
}

fn hexadecimal(digits: &str) -> Option<Address> {
    if digits.len() != 10 || !digits.bytes().all(|digit| digit.is_ascii_hexdigit()) {
        return None;
    }
    let [.., a, b, c, d, e] = u64::from_str_radix(digits, 16).ok()?.to_be_bytes();
    Some(Address([a, b, c, d, e]))
}

/// The rate among the options. `safelink` and `ackfilter`, which other tools know, are refused: the
/// bridge asks the drone for a safelink, and hands on no empty packets.
fn rate(options: &str) -> Result<Option<Rate>, String> {
    let mut rate = None;
    for option in options.split('&').filter(|option| !option.is_empty()) {
        let Some(limit) = option.strip_prefix("rate_limit=") else {
            return Err(format!("has the option \"{option}\", of which only rate_limit is known"));
        };
        let polls = limit.parse().ok().and_then(Rate::per_second).ok_or_else(|| {
            format!("has the rate_limit \"{limit}\" for {} to {}", Rate::LEAST, Rate::MOST)
        })?;
        rate = Some(polls);
    }
    Ok(rate)
}
