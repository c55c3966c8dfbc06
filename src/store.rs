//! What the drone remembers: read once at boot, written when it changes, and then only on the
//! ground.
//!
//! | where | what | used |
//! |---|---|---|
//! | 0x200 and 0x300 | the settings, twice ([`wire::settings`]) | the newer one, if there is one |
//! | 0 | the vendor's configuration block | else: channel, data rate, address, trims; the number is the address's last byte, if that is one |
//! | | nothing readable | else: [`Settings::DEFAULT`] |
//! | 0x240 and 0x340 | the keys, twice ([`keys`]) | the newer one; its number and role go before those of the settings |
//! | 0x280 and 0x380 | the epoch, twice ([`epoch`]) | the higher one, and one more for this boot |
//!
//! New keys come in through a page of the flash ([`crate::page`]). They are taken over before
//! anything else happens: written to the EEPROM, read back, and only then wiped from the page.
//!
//! The link is opened ([`Link::open`]) when there are keys, and an epoch that the EEPROM has been
//! seen to keep. Without, it stays shut until the next boot, the drone silent and on the ground;
//! why, [`keys_state`] tells.
//!
//! An image that was built with `UCHAIN_NODE=3` writes that number to the EEPROM, where it stays
//! until an image with another one is flashed. It is who a drone without keys is.

use core::sync::atomic::{AtomicBool, Ordering};

use airlink::keys::{Key, Keys, Own};
use airlink::{Identity, Schedule};
use embassy_embedded_hal::shared_bus::asynch::i2c::I2cDevice;
use embassy_time::{Delay, Duration, Timer};
use sensors::eeprom::Eeprom;
use units::{Metres, NodeId, Role};
use wire::p2p::Epoch;
use wire::settings::epoch::{self, Provisioned};
use wire::settings::keys::{self, KeysRecord};
use wire::settings::{
    Chosen, LENGTH, Limits, Settings, Slot, Trim, VENDOR_LENGTH, VendorConfig, Write, newest,
};

use crate::health::{self, Task};
use crate::latest::Latest;
use crate::link::{Credentials, Link};
use crate::page::{self, Content};
use crate::rangers::{DeckBus, Share};
use crate::{clock, control};

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

/// How the drone stands with its keys.
#[derive(Clone, Copy, PartialEq, Eq, defmt::Format)]
pub(crate) enum KeysState {
    /// The EEPROM has not been read yet.
    Unread,
    /// It has none: it was never provisioned.
    Missing,
    /// It has them, and an epoch to use them in.
    Held {
        /// Whether cfclient may fly the head through it.
        may_fly: bool,
    },
    /// It must not speak.
    Shut(Why),
}

/// Why a drone that was provisioned must not speak.
#[derive(Clone, Copy, PartialEq, Eq, defmt::Format)]
pub(crate) enum Why {
    /// The EEPROM cannot be read, or does not keep what is written.
    Memory,
    /// There is no epoch for this boot.
    Epoch(epoch::Error),
    /// At this data rate there is no room on the air for its number.
    NoSlot,
}

static CHOICE: Latest<Choice> = Latest::new(Choice::Unread);
static KEYS: Latest<KeysState> = Latest::new(KeysState::Unread);

/// The flying height that was wished for, until it is taken up,
static HEIGHT: Latest<Option<Metres>> = Latest::new(None);
/// and the limits.
static LIMITS: Latest<Option<Limits>> = Latest::new(None);

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

/// How the drone stands with its keys.
pub(crate) fn keys_state() -> KeysState {
    KEYS.get()
}

/// From the next boot on the drone flies at `height`.
pub(crate) fn keep_height(height: Metres) {
    HEIGHT.set(Some(height));
}

/// From the next boot on these limits hold.
pub(crate) fn keep_limits(limits: Limits) {
    LIMITS.set(Some(limits));
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
pub(crate) async fn run(bus: &'static DeckBus, link: &'static Link) -> ! {
    let mut memory = Eeprom::new(I2cDevice::new(bus));
    let (mut settings, from) = load(&mut memory).await;
    // Nothing flies yet: the mind has not been told who it is.
    WRITES.store(true, Ordering::Release);
    let keys = provisioned(&mut memory).await;
    let number = if keys == Ok(None) { FLASHED } else { None };
    let mut unsaved = None;
    match (&keys, number) {
        (Ok(Some((keys, _))), _) => {
            settings = Settings { node: keys.node, role: keys.role, ..settings };
        }
        (_, Some(node)) if from != Source::Record || settings.node != node => {
            settings = Settings { node, role: role_of(node), ..settings };
            unsaved = Some(settings);
        }
        _ => {}
    }
    KEYS.set(open(&mut memory, link, &settings, keys).await);
    WRITES.store(false, Ordering::Release);
    CHOICE.set(Choice::Settled { settings, from });
    let mut tries = TRIES;
    loop {
        health::sign(Task::Store);
        let (height, limits) = (HEIGHT.take(), LIMITS.take());
        if height.is_some() || limits.is_some() {
            settings.height = height.or(settings.height);
            settings.limits = limits.unwrap_or(settings.limits);
            CHOICE.set(Choice::Settled { settings, from });
            (unsaved, tries) = (Some(settings), TRIES);
        }
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

/// Opens the link, if that may be.
async fn open(
    memory: &mut Memory,
    link: &Link,
    settings: &Settings,
    keys: Result<Option<(KeysRecord, Provisioned)>, Why>,
) -> KeysState {
    let (keys, provisioned) = match keys {
        Ok(Some(keys)) => keys,
        Ok(None) => return KeysState::Missing,
        Err(why) => return KeysState::Shut(why),
    };
    let Ok(schedule) = Schedule::new(settings.radio.datarate, keys.node) else {
        return KeysState::Shut(Why::NoSlot);
    };
    let epoch = match begin_epoch(memory, &keys, provisioned).await {
        Ok(epoch) => epoch,
        Err(why) => return KeysState::Shut(why),
    };
    defmt::info!("keys of issue {=u8}, epoch {=u32}", keys.issue.get(), epoch.get());
    let credentials = Credentials {
        identity: Identity { node: keys.node, role: keys.role },
        keys: for_the_link(&keys),
        epoch,
        schedule,
    };
    link.open(credentials, clock::now());
    KeysState::Held { may_fly: keys.may_fly }
}

fn for_the_link(keys: &KeysRecord) -> Keys {
    let own = Key::from_bytes(*keys.own.expose());
    Keys {
        group: Key::from_bytes(*keys.group.expose()),
        own: if keys.role == Role::Base { Own::Base(own) } else { Own::Node(own) },
    }
}

/// The keys that hold, and whether they have just come. What the page holds is taken over or
/// thrown away, but for what a later firmware may know to read, and for what the memory did not
/// keep.
async fn provisioned(memory: &mut Memory) -> Result<Option<(KeysRecord, Provisioned)>, Why> {
    let current = kept_keys(memory).await?;
    let before = current.map(|current| (current.keys, Provisioned::Before));
    let (page, content) = page::read();
    if content == Content::Nothing {
        return Ok(before);
    }
    let news = match KeysRecord::decode(&page) {
        Ok((keys, _)) if keys.supersedes(before.as_ref().map(|(keys, _)| keys)) => {
            keep_keys(memory, &keys).await?;
            Some((keys, Provisioned::Now))
        }
        Ok(_) => {
            defmt::warn!("the page's keys are not newer than the drone's");
            None
        }
        Err(keys::Error::Version(version)) => {
            defmt::error!("the page's keys are of the unknown version {=u8}", version);
            return Ok(before);
        }
        Err(why) => {
            defmt::error!("the page holds no keys: {}", why);
            None
        }
    };
    if !page::wipe() {
        defmt::error!("the page cannot be wiped: its keys are still in the flash");
    }
    Ok(news.or(before))
}

/// The newer record of the keys, if there is one.
async fn kept_keys(memory: &mut Memory) -> Result<Option<keys::Chosen>, Why> {
    let (a, b) = slots(memory, KEY_SLOTS).await.ok_or(Why::Memory)?;
    Ok(keys::newest(&a, &b))
}

/// Writes the older slot and reads both again: only what then turns out to be the newest counts.
async fn keep_keys(memory: &mut Memory, keys: &KeysRecord) -> Result<(), Why> {
    for _ in 0..TRIES {
        let current = kept_keys(memory).await?;
        let write = keys::Write::after(current.as_ref(), keys).map_err(|_| Why::Memory)?;
        let address = keys::address(write.slot);
        if memory.write(address, &write.record, &mut Delay).await.is_ok()
            && let Some(now) = kept_keys(memory).await?
            && now.slot == write.slot
            && now.keys == *keys
        {
            return Ok(());
        }
        Timer::after(PAUSE).await;
    }
    Err(Why::Memory)
}

/// The epoch of this boot, once the memory has been seen to keep it.
async fn begin_epoch(
    memory: &mut Memory,
    keys: &KeysRecord,
    provisioned: Provisioned,
) -> Result<Epoch, Why> {
    let (a, b) = slots(memory, EPOCH_SLOTS).await.ok_or(Why::Memory)?;
    let next = epoch::next(&a, &b, keys, provisioned).map_err(Why::Epoch)?;
    let address = epoch::address(next.slot);
    for _ in 0..TRIES {
        if memory.write(address, &next.record, &mut Delay).await.is_ok()
            && let Some(back) = read(memory, address).await
            && let Some(epoch) = next.kept(&back)
        {
            return Ok(epoch);
        }
        Timer::after(PAUSE).await;
    }
    Err(Why::Memory)
}

/// The settings that hold, as far as the memory can be read.
async fn load(memory: &mut Memory) -> (Settings, Source) {
    if let Some(Chosen { settings, .. }) = current(memory).await {
        return (settings, Source::Record);
    }
    let block = read(memory, 0).await;
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
    let (a, b) = slots(memory, SLOTS).await?;
    newest(&a, &b)
}

/// As many bytes as the longest record has: one way to read is enough for all of them.
type Bytes = [u8; LONGEST];

const LONGEST: usize = {
    let mut longest = VENDOR_LENGTH;
    let mut others: &[usize] = &[LENGTH, keys::LENGTH, epoch::LENGTH];
    while let [length, rest @ ..] = others {
        if *length > longest {
            longest = *length;
        }
        others = rest;
    }
    longest
};

/// What begins where a record has its two places.
async fn slots(memory: &mut Memory, [a, b]: [u16; 2]) -> Option<(Bytes, Bytes)> {
    let a = read(memory, a).await?;
    let b = read(memory, b).await?;
    Some((a, b))
}

/// Where the settings are,
const SLOTS: [u16; 2] = [Slot::A.address(), Slot::B.address()];
/// the keys,
const KEY_SLOTS: [u16; 2] = [keys::address(Slot::A), keys::address(Slot::B)];
/// and the epoch.
const EPOCH_SLOTS: [u16; 2] = [epoch::address(Slot::A), epoch::address(Slot::B)];

async fn read(memory: &mut Memory, address: u16) -> Option<Bytes> {
    let mut bytes = [0; LONGEST];
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
    let (a, b) = slots(memory, SLOTS).await?;
    let write = Write::after(newest(&a, &b).as_ref(), settings).ok()?;
    memory.write(write.slot.address(), &write.record, &mut Delay).await.ok()?;
    let (a, b) = slots(memory, SLOTS).await?;
    newest(&a, &b).filter(|now| now.slot == write.slot && now.settings == *settings)
}

/// The trims of the settings, or none as long as they have not been read.
pub(crate) fn trim() -> Option<Trim> {
    settings().map(|settings| settings.trim)
}
