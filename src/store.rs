//! What the drone remembers: read once at boot, written when it changes, and then only on the
//! ground.
//!
//! | where | what | used |
//! |---|---|---|
//! | 0x200 and 0x300 | this firmware's record, twice ([`wire::settings`]) | the newer one, if there is one |
//! | 0 | the vendor's configuration block | else: channel, data rate, address, trims; the number is the address's last byte, if that is one |
//! | | nothing readable | else: [`Settings::DEFAULT`] |
//!
//! An image that was built with `UCHAIN_NODE=3` writes that number to the EEPROM, where it stays
//! until an image with another one is flashed.

use core::sync::atomic::{AtomicBool, Ordering};

use embassy_embedded_hal::shared_bus::asynch::i2c::I2cDevice;
use embassy_time::{Delay, Duration, Timer};
use sensors::eeprom::Eeprom;
use units::NodeId;
use wire::settings::{
    Chosen, LENGTH, Role, Settings, Slot, Trim, VENDOR_LENGTH, VendorConfig, Write, newest,
};

use crate::control;
use crate::health::{self, Task};
use crate::latest::Latest;
use crate::rangers::{DeckBus, Share};

/// What the settings are.
#[derive(Clone, Copy)]
pub(crate) enum Choice {
    /// The EEPROM has not been read yet.
    Unread,
    /// These, until the next boot.
    Settled { settings: Settings, from: Source },
}

/// Where the settings come from.
#[derive(Clone, Copy, PartialEq, Eq, defmt::Format)]
pub(crate) enum Source {
    /// From this firmware's record.
    Record,
    /// From the vendor's configuration block.
    Vendor,
    /// From nowhere.
    Default,
}

static CHOICE: Latest<Choice> = Latest::new(Choice::Unread);

/// A write has begun and is not over.
static WRITES: AtomicBool = AtomicBool::new(false);

/// The settings and where they come from.
pub(crate) fn choice() -> Choice {
    CHOICE.get()
}

/// The settings, once they have been read.
pub(crate) fn settings() -> Option<Settings> {
    match choice() {
        Choice::Unread => None,
        Choice::Settled { settings, .. } => Some(settings),
    }
}

/// Whether power may go.
pub(crate) fn is_idle() -> bool {
    !WRITES.load(Ordering::Acquire)
}

/// Attempts at each reading, and at a write.
const TRIES: u8 = 3;
/// Between attempts.
const PAUSE: Duration = Duration::from_millis(50);
/// How often the task shows that it is alive.
const ROUND: Duration = Duration::from_millis(500);

/// Numbers of a chain (crates/chain, `MAX_NEIGHBOURS` and itself).
const NODES: u8 = 16;

/// The number that the image was built with.
const FLASHED: Option<NodeId> = match option_env!("UCHAIN_NODE") {
    None => None,
    Some(text) => node(text.as_bytes()),
};

const _: () = assert!(
    option_env!("UCHAIN_NODE").is_none() || FLASHED.is_some(),
    "UCHAIN_NODE must be a number from 0 (the head) to 15 (the base)"
);

const fn node(text: &[u8]) -> Option<NodeId> {
    match text {
        [digit @ b'0'..=b'9'] => Some(NodeId(*digit - b'0')),
        [b'1', digit @ b'0'..=b'5'] => Some(NodeId(10 + *digit - b'0')),
        _ => None,
    }
}

/// The head has the smallest number, the base the largest.
const fn role_of(node: NodeId) -> Role {
    match node.0 {
        0 => Role::Head,
        1..15 => Role::Relay,
        _ => Role::Base,
    }
}

type Memory = Eeprom<Share>;

/// The task.
#[embassy_executor::task]
pub(crate) async fn run(bus: &'static DeckBus) -> ! {
    let mut memory = Eeprom::new(I2cDevice::new(bus));
    let (settings, from) = load(&mut memory).await;
    CHOICE.set(Choice::Settled { settings, from });
    let mut unsaved = match FLASHED {
        Some(node) if from != Source::Record || settings.node != node => {
            let settings = Settings { node, role: role_of(node), ..settings };
            CHOICE.set(Choice::Settled { settings, from });
            Some(settings)
        }
        _ => None,
    };
    let mut tries = TRIES;
    loop {
        health::sign(Task::Store);
        if let Some(settings) = unsaved
            && tries > 0
            && !control::is_airborne()
        {
            WRITES.store(true, Ordering::Release);
            let saved = save(&mut memory, &settings).await;
            WRITES.store(false, Ordering::Release);
            if saved.is_some() {
                unsaved = None;
                defmt::info!("settings saved: node {=u8}", settings.node.0);
            } else {
                tries -= 1;
                defmt::warn!("settings not saved, {=u8} tries left", tries);
            }
        }
        Timer::after(ROUND).await;
    }
}

/// The settings that hold, as far as the memory can be read.
async fn load(memory: &mut Memory) -> (Settings, Source) {
    if let Some(Chosen { settings, .. }) = current(memory).await {
        return (settings, Source::Record);
    }
    let block = read::<VENDOR_LENGTH>(memory, 0).await;
    match block.and_then(|block| VendorConfig::decode(&block).ok()) {
        Some(vendor) => (by_vendor(&vendor), Source::Vendor),
        None => (Settings::DEFAULT, Source::Default),
    }
}

/// What the vendor's tools have set, and the number that the address ends in.
fn by_vendor(vendor: &VendorConfig) -> Settings {
    let settings = Settings::DEFAULT.with_vendor(vendor);
    let [.., last] = vendor.address.0;
    if last < NODES {
        Settings { node: NodeId(last), role: role_of(NodeId(last)), ..settings }
    } else {
        settings
    }
}

/// The newer record. `None` where there is none, or where one of the slots cannot be read: what is
/// not known to be the newer one is not to be used, nor the other overwritten.
async fn current(memory: &mut Memory) -> Option<Chosen> {
    let (a, b) = slots(memory).await?;
    newest(&a, &b)
}

async fn slots(memory: &mut Memory) -> Option<([u8; LENGTH], [u8; LENGTH])> {
    let a = read(memory, Slot::A.address()).await?;
    let b = read(memory, Slot::B.address()).await?;
    Some((a, b))
}

async fn read<const N: usize>(memory: &mut Memory, address: u16) -> Option<[u8; N]> {
    let mut bytes = [0; N];
    for _ in 0..TRIES {
        health::sign(Task::Store);
        if memory.read(address, &mut bytes).await.is_ok() {
            return Some(bytes);
        }
        Timer::after(PAUSE).await;
    }
    None
}

/// Writes the older slot and reads both again: only what then turns out to be the newest counts.
async fn save(memory: &mut Memory, settings: &Settings) -> Option<Chosen> {
    let (a, b) = slots(memory).await?;
    let write = Write::after(newest(&a, &b).as_ref(), settings).ok()?;
    memory.write(write.slot.address(), &write.record, &mut Delay).await.ok()?;
    let (a, b) = slots(memory).await?;
    newest(&a, &b).filter(|now| now.slot == write.slot && now.settings == *settings)
}

/// The trims of the settings, or none as long as they have not been read.
pub(crate) fn trim() -> Option<Trim> {
    settings().map(|settings| settings.trim)
}
