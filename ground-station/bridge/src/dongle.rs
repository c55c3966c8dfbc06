//! The Crazyradio itself, through Bitcraze's driver.
//!
//! `crazyradio` is the driver under `crazyflie-link`. The latter (0.5.1) polls without a limit, which
//! the bridge is there to set, and at 2 Mbit/s whatever its address says.

use crazyradio::{Channel, Datarate, Error};
use input::InputError;

use super::{Radio, RadioAddress, RadioLost};

/// A Crazyradio that is set to one drone.
pub struct Crazyradio(crazyradio::Crazyradio);

impl Crazyradio {
    /// Opens the Crazyradio of an address and sets it to the drone.
    ///
    /// # Errors
    /// If it is not plugged in, or cannot be used.
    pub fn open(to: &RadioAddress) -> Result<Self, InputError> {
        // The driver panics where the system's USB cannot be used at all (rusb 0.9.4, `context.rs`).
        if let Err(error) = rusb::Context::new() {
            let wrong = format!("this machine's USB cannot be used ({error})");
            return Err(InputError::new(wrong, "start the bridge where the Crazyradio is"));
        }
        let open = || {
            let mut radio = crazyradio::Crazyradio::open_nth(to.dongle)?;
            radio.set_datarate(match to.datarate {
                wire::radio::Datarate::Kbit250 => Datarate::Dr250K,
                wire::radio::Datarate::Mbit1 => Datarate::Dr1M,
                wire::radio::Datarate::Mbit2 => Datarate::Dr2M,
            })?;
            radio.set_channel(Channel::from_number(to.channel.number())?)?;
            radio.set_address(&to.address.0)?;
            Ok(Self(radio))
        };
        open().map_err(|error| match error {
            Error::NotFound => {
                let wrong = format!("there is no Crazyradio {} at this machine", to.dongle);
                InputError::new(wrong, "plug one in; 0 is the first")
            }
            error => InputError::new(
                format!("the Crazyradio {} cannot be used ({error})", to.dongle),
                "end the program that has it, and on Linux install Bitcraze's udev rules for it",
            ),
        })
    }
}

impl Radio for Crazyradio {
    fn exchange(&mut self, packet: &[u8]) -> Result<Option<Vec<u8>>, RadioLost> {
        let mut answer = [0; 32];
        match self.0.send_packet(packet, &mut answer) {
            Ok(ack) if ack.received => {
                Ok(Some(answer.get(..ack.length).unwrap_or(&answer).to_vec()))
            }
            Ok(_) => Ok(None),
            Err(error) => Err(RadioLost(error.to_string())),
        }
    }
}
