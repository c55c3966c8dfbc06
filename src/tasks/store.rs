//! The task that keeps settings, keys and epochs in the EEPROM.
//!
//! The settings are read at boot, and written when they change, on the ground only:
//!
//! | EEPROM address | record | used |
//! |---|---|---|
//! | 0x200 and 0x300 | the settings ([`storage::settings`]) | the newer record, if there is one |
//! | 0 | the vendor's configuration block | else: channel, data rate, address, trims; the drone's number is the address's last byte, if there is such a node |
//! | | [`Settings::DEFAULT`] | else |
//! | 0x240 and 0x340 | the keys ([`storage::keys`]) | the newer record; its number and role replace those of the settings |
//! | 0x280 and 0x380 | the epoch ([`storage::epoch`]) | the higher one, and one more for this boot |
//! | 0x2C0 and 0x3C0 | the ledger of the keys that were used ([`storage::ledger`]) | the newer record |
//!
//! New keys come in through a page of the flash ([`crate::board::page`]). They are written into both slots
//! of the EEPROM and read back before anything else happens, and only then wiped from the page. Whatever
//! is read from the EEPROM is read until two readings agree.
//!
//! The drone's link is opened ([`onboard::Drone::open_link`]) when there are keys, and an epoch that
//! was read back from the EEPROM. Otherwise it stays shut until the next boot, and the drone silent and on the ground;
//! [`keys_state`] tells the reason.
//!
//! An image that was built with `UCHAIN_NODE=3` writes that number to the EEPROM, where it stays
//! until an image with another number is flashed. A drone with keys ignores it.

use core::sync::atomic::{AtomicBool, Ordering};

use airlink::keys::{Key, Own};
use airlink::{Schedule, Sealed, keys as link_keys};
use embassy_embedded_hal::shared_bus::asynch::i2c::I2cDevice;
use embassy_stm32::uid;
use embassy_time::{Delay, Duration, Timer};
use onboard::{Config, Keys, Setup, Start, Unsaved};
use sensors::eeprom::Eeprom;
use storage::epoch::{self, EpochError, EpochRecord};
use storage::keys::{self, KeysRecord, Page};
use storage::ledger::{self, Ledger};
use storage::settings::{self, Limits, Settings, Source, Trim};
use storage::{Readings, Record, Slots, vendor};
use units::{Metres, NODES, NodeId, PolicyCode, Role};
use wire::p2p::Epoch;

use crate::board::clock;
use crate::board::{page, random};
use crate::tasks::control;
use crate::tasks::drone::Shared;
use crate::tasks::health::{self, Task};
use crate::tasks::latest::Latest;
use crate::tasks::rangers::{DeckBus, Share};

/// The settings, as far as they are known.
#[derive(Clone, Copy)]
pub(crate) enum Choice {
    /// The EEPROM has not been read yet.
    Unread,
    /// These settings hold until the next boot.
    Settled { settings: Settings, from: Source },
}

/// Whether the drone has keys, and may use them.
#[derive(Clone, Copy, PartialEq, Eq, defmt::Format)]
pub(crate) enum KeysState {
    /// The EEPROM has not been read yet.
    Unread,
    /// The drone has no keys: it was never provisioned.
    Missing,
    /// The drone has keys, and an epoch to use them in.
    Held {
        /// Whether cfclient may fly the head through this drone.
        may_fly: bool,
    },
    /// The drone must not transmit.
    Shut(Why),
}

/// Why a drone that was provisioned must not transmit.
#[derive(Clone, Copy, PartialEq, Eq, defmt::Format)]
pub(crate) enum Why {
    /// The EEPROM cannot be read, or does not keep what is written.
    Memory,
    /// There is no epoch for this boot.
    Epoch(EpochError),
    /// At this data rate the schedule has no slot for the drone's number.
    NoSlot,
}

static CHOICE: Latest<Choice> = Latest::new(Choice::Unread);
static KEYS: Latest<KeysState> = Latest::new(KeysState::Unread);

/// The flying height that an operator has asked for, until the task takes it.
static HEIGHT: Latest<Option<Metres>> = Latest::new(None);
/// The limits that an operator has asked for, until the task takes them.
static LIMITS: Latest<Option<Limits>> = Latest::new(None);

/// The movement policy that an operator has chosen, until the task takes it.
static POLICY: Latest<Option<PolicyCode>> = Latest::new(None);

/// Whether a write has begun and is not over.
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

/// The trims of the settings, once they have been read.
pub(crate) fn trim() -> Option<Trim> {
    settings().map(|settings| settings.trim)
}

/// Whether the drone has keys, and may use them.
pub(crate) fn keys_state() -> KeysState {
    KEYS.get()
}

/// Keeps what a client has set, for the next boot.
pub(crate) fn keep_settings(unsaved: Unsaved) {
    let Unsaved { height, limits, policy } = unsaved;
    if height.is_some() {
        HEIGHT.set(height);
    }
    if let Some([launch, retreat]) = limits {
        LIMITS.set(Some(Limits { launch: Some(launch), retreat: Some(retreat) }));
    }
    if policy.is_some() {
        POLICY.set(policy);
    }
}

/// Whether the supply may be switched off without cutting a write short.
pub(crate) fn is_idle() -> bool {
    !WRITES.load(Ordering::Acquire)
}

/// Attempts at each reading and each writing.
const TRIES: u8 = 3;
/// The pause between attempts.
const PAUSE: Duration = Duration::from_millis(50);
/// The period in which the task looks for changes, and signs.
const ROUND: Duration = Duration::from_millis(500);

/// The number that the image was built with.
const FLASHED: Option<NodeId> = match option_env!("UCHAIN_NODE") {
    None => None,
    Some(text) => node(text.as_bytes()),
};

const _: () = assert!(NODES == 16, "the numbers that `node` accepts");
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

type Memory = Eeprom<Share>;

/// How the last run ended, as the agent needs to know it.
#[derive(Clone, Copy)]
pub(crate) struct LastRun {
    /// It ended by a fault, or in the air.
    pub(crate) failed: bool,
    /// It ended while a stop stood.
    pub(crate) stopped: bool,
}

/// Makes the drone that the settings describe.
fn make(shared: &Shared, settings: &Settings, last_run: LastRun) {
    let config = Config::DEFAULT.with_settings(settings, |unusable| {
        defmt::error!("a setting is not used: {}", unusable);
    });
    let start = if last_run.failed { Start::AfterFault } else { Start::OnGround };
    let stopped = last_run.stopped;
    let mission = settings.mission;
    let mut setup = Setup { start, stopped, mission, ..Setup::new(settings.node, settings.role) };
    for (place, word) in setup.about.unique.iter_mut().zip(uid::uid().as_chunks::<4>().0) {
        *place = u32::from_le_bytes(*word);
    }
    shared.begin(config, &setup);
    defmt::info!("node {=u8}, {}", settings.node.0, settings.role);
}

/// The task.
#[embassy_executor::task]
pub(crate) async fn run(bus: &'static DeckBus, shared: &'static Shared, last_run: LastRun) -> ! {
    let mut memory = Eeprom::new(I2cDevice::new(bus));
    let (mut settings, from, mut unsaved) = boot(&mut memory, shared, last_run).await;
    CHOICE.set(Choice::Settled { settings, from });
    loop {
        health::sign(Task::Store);
        let (height, limits, policy) = (HEIGHT.take(), LIMITS.take(), POLICY.take());
        if height.is_some() || limits.is_some() || policy.is_some() {
            settings.policy = policy.or(settings.policy);
            settings.height = height.or(settings.height);
            settings.limits = limits.unwrap_or(settings.limits);
            CHOICE.set(Choice::Settled { settings, from });
            unsaved = TRIES;
        }
        if unsaved > 0 && !control::is_airborne() {
            unsaved = save(&mut memory, shared, &settings, unsaved).await;
        }
        Timer::after(ROUND).await;
    }
}

/// Reads the settings, takes keys over from the page, makes the drone and opens its link. Returns the settings,
/// their source, and the number of attempts to save them. The drone cannot fly before this function
/// has made it.
async fn boot(memory: &mut Memory, shared: &Shared, last_run: LastRun) -> (Settings, Source, u8) {
    let (mut settings, from) = load(memory).await;
    WRITES.store(true, Ordering::Release);
    let keys = provisioned(memory, &mut settings).await;
    let number = if keys == Ok(None) { FLASHED } else { None };
    let mut unsaved = 0;
    match (&keys, number) {
        (Ok(Some((keys, _))), _) => {
            settings = Settings { node: keys.node, role: keys.role, ..settings };
        }
        (_, Some(node)) if from != Source::Record || settings.node != node => {
            settings = settings.with_node(node);
            unsaved = TRIES;
        }
        _ => {}
    }
    make(shared, &settings, last_run);
    KEYS.set(open(memory, shared, &settings, keys).await);
    WRITES.store(false, Ordering::Release);
    (settings, from, unsaved)
}

/// The settings that hold, as far as the memory can be read.
async fn load(memory: &mut Memory) -> (Settings, Source) {
    let read_slots = read_both(memory, Settings::ADDRESSES).await;
    if let Some(settings) = read_slots.and_then(|read| slots::<Settings>(&read).newest().copied()) {
        return (settings, Source::Record);
    }
    let block = read(memory, vendor::ADDRESS).await;
    Settings::without_record(block.as_ref().map(|block| block.as_slice()))
}

/// Makes one attempt to save the settings; returns how many attempts are left.
async fn save(memory: &mut Memory, shared: &Shared, settings: &Settings, tries: u8) -> u8 {
    WRITES.store(true, Ordering::Release);
    let saved = keep_twice(memory, Keep::Settings(settings)).await.is_ok();
    WRITES.store(false, Ordering::Release);
    if saved {
        defmt::info!("settings saved: node {=u8}", settings.node.0);
        return 0;
    }
    let left = tries - 1;
    defmt::warn!("settings not saved, {=u8} tries left", left);
    if left == 0 {
        shared.with(|drone| drone.say("Not kept: the memory does not take it."));
    }
    left
}

/// Opens the link, if there are keys and an epoch to use them in.
async fn open(
    memory: &mut Memory,
    shared: &Shared,
    settings: &Settings,
    keys: Result<Option<(KeysRecord, Ledger)>, Why>,
) -> KeysState {
    let (state, keys) = match unlock(memory, settings, keys).await {
        Ok(Some((keys, may_fly))) => (KeysState::Held { may_fly }, keys),
        Ok(None) => (KeysState::Missing, Keys::Missing),
        Err(why) => (KeysState::Shut(why), Keys::Unusable),
    };
    open_link(shared, keys);
    state
}

/// Opens the drone's link. It is a function of its own, so that the frame with the link is gone
/// before the task waits for the memory again.
#[inline(never)]
fn open_link(shared: &Shared, keys: Keys<Sealed>) {
    shared.tell(|drone| drone.open_link(clock::now(), keys));
}

/// The keys for the link, if there are usable ones, and whether clients may give orders by them.
async fn unlock(
    memory: &mut Memory,
    settings: &Settings,
    keys: Result<Option<(KeysRecord, Ledger)>, Why>,
) -> Result<Option<(Keys<Sealed>, bool)>, Why> {
    let Some((keys, ledger)) = keys? else { return Ok(None) };
    let schedule = Schedule::new(settings.radio.datarate, keys.node).map_err(|_| Why::NoSlot)?;
    let epoch = begin_epoch(memory, &keys, &ledger).await?;
    defmt::info!("keys of issue {=u8}, epoch {=u32}", keys.issue.get(), epoch.get());
    let (seal, may_fly) = (Sealed::new(for_the_link(&keys)), keys.may_fly);
    Ok(Some((Keys::Held { seal, epoch, schedule, may_fly }, may_fly)))
}

fn for_the_link(keys: &KeysRecord) -> link_keys::Keys {
    let own = Key::from_bytes(*keys.own.expose());
    link_keys::Keys {
        group: Key::from_bytes(*keys.group.expose()),
        own: if keys.role == Role::Base { Own::Base(own) } else { Own::Node(own) },
    }
}

/// The drone's keys, which are then in both slots, and the ledger of those that were used. Policy, limits
/// and mission on the page go into the settings. The page is wiped, unless a later firmware may be able
/// to read it or the EEPROM did not keep its keys.
async fn provisioned(
    memory: &mut Memory,
    settings: &mut Settings,
) -> Result<Option<(KeysRecord, Ledger)>, Why> {
    let read = read_both(memory, Ledger::ADDRESSES).await.ok_or(Why::Memory)?;
    let ledger = slots::<Ledger>(&read).newest().copied().unwrap_or(Ledger::EMPTY);
    let read = read_both(memory, KeysRecord::ADDRESSES).await.ok_or(Why::Memory)?;
    let mut keys = slots::<KeysRecord>(&read).newest().copied();
    let mut wipes = true;
    match KeysRecord::on_page(&page::read(), keys.as_ref(), &ledger) {
        Page::Empty => wipes = false,
        Page::New { keys: new, policy, limits, mission } => {
            let before = *settings;
            settings.policy = policy.or(settings.policy);
            settings.limits = limits.unwrap_or(settings.limits);
            *settings = mission.map_or(*settings, |mission| mission.applied_to(*settings));
            // First, so that after a power cut between the two the page still counts as new.
            if *settings != before {
                keep_twice(memory, Keep::Settings(settings)).await?;
            }
            keys = Some(new);
        }
        Page::Old => defmt::warn!("the page's keys are not newer than the drone's"),
        Page::Unknown(version) => {
            defmt::error!("the page's keys are of the unknown version {=u8}", version);
            wipes = false;
        }
        Page::Damaged(why) => defmt::error!("the page holds no keys: {}", why),
    }
    if let Some(keys) = &keys {
        keep_twice(memory, Keep::Keys(keys)).await?;
    }
    if wipes && !page::wipe() {
        defmt::error!("the page cannot be wiped: its keys are still in the flash");
    }
    Ok(keys.map(|keys| (keys, ledger)))
}

/// A record to keep, so that one function keeps all kinds.
#[derive(Clone, Copy)]
enum Keep<'a> {
    Settings(&'a Settings),
    Keys(&'a KeysRecord),
    Ledger(&'a Ledger),
}

impl Keep<'_> {
    /// The addresses of the record's slots.
    const fn addresses(self) -> [u16; 2] {
        match self {
            Self::Settings(_) => Settings::ADDRESSES,
            Self::Keys(_) => KeysRecord::ADDRESSES,
            Self::Ledger(_) => Ledger::ADDRESSES,
        }
    }

    /// The address and the bytes to write next, and how many they are, so that both slots hold the
    /// record; `None` when they do.
    fn missing(self, read: &[Bytes; 2]) -> Result<Option<(u16, Bytes, usize)>, Why> {
        match self {
            Self::Settings(settings) => missing(settings, read),
            Self::Keys(keys) => missing(keys, read),
            Self::Ledger(ledger) => missing(ledger, read),
        }
    }
}

/// See [`Keep::missing`].
fn missing<R: Record>(record: &R, [a, b]: &[Bytes; 2]) -> Result<Option<(u16, Bytes, usize)>, Why> {
    let slots = Slots::<R>::read(a, b);
    if slots.both_hold(record) {
        return Ok(None);
    }
    let write = slots.write(record).map_err(|_| Why::Memory)?;
    let mut bytes = [0; LONGEST];
    for (place, byte) in bytes.iter_mut().zip(write.bytes()) {
        *place = *byte;
    }
    Ok(Some((write.address(), bytes, R::LENGTH)))
}

/// Writes a record into both slots, unless they hold it.
async fn keep_twice(memory: &mut Memory, record: Keep<'_>) -> Result<(), Why> {
    for _ in 0..2 * TRIES {
        // A slot that cannot be read may hold the newer record, which must not be overwritten.
        let Some(read) = read_both(memory, record.addresses()).await else { continue };
        let Some((address, bytes, length)) = record.missing(&read)? else { return Ok(()) };
        let _ = write(memory, address, bytes.get(..length).unwrap_or_default()).await;
    }
    Err(Why::Memory)
}

/// The epoch of this boot, once it was read back from both slots and the ledger has the keys.
async fn begin_epoch(
    memory: &mut Memory,
    keys: &KeysRecord,
    ledger: &Ledger,
) -> Result<Epoch, Why> {
    let read = read_both(memory, EpochRecord::ADDRESSES).await.ok_or(Why::Memory)?;
    let next = epoch::next(&slots(&read), keys, ledger, random::draw()).map_err(Why::Epoch)?;
    for _ in 0..TRIES {
        let mut read_back = [[0; LONGEST]; 2];
        for (put, read) in next.writes.iter().zip(&mut read_back) {
            if let Some(bytes) = write(memory, put.address(), put.bytes()).await {
                *read = bytes;
            }
        }
        let [first, second] = &read_back;
        if let Some(epoch) = next.kept([first, second]) {
            if !ledger.has(keys) {
                keep_twice(memory, Keep::Ledger(&ledger.with(keys))).await?;
            }
            return Ok(epoch);
        }
        Timer::after(PAUSE).await;
    }
    Err(Why::Memory)
}

/// Carries out a write; returns the bytes that were read back.
async fn write(memory: &mut Memory, address: u16, bytes: &[u8]) -> Option<Bytes> {
    memory.write(address, bytes, &mut Delay).await.ok()?;
    read(memory, address).await
}

/// The bytes of a record's two slots; `None` where one of them cannot be read.
async fn read_both(memory: &mut Memory, addresses: [u16; 2]) -> Option<[Bytes; 2]> {
    let [a, b] = addresses;
    Some([read(memory, a).await?, read(memory, b).await?])
}

/// A record's two slots.
fn slots<R: Record>([a, b]: &[Bytes; 2]) -> Slots<R> {
    Slots::read(a, b)
}

/// The bytes of the longest record, so that one function reads all kinds.
type Bytes = [u8; LONGEST];

const LONGEST: usize = settings::LENGTH;
const _: () = assert!(keys::LENGTH <= LONGEST && epoch::LENGTH <= LONGEST);
const _: () = assert!(ledger::LENGTH <= LONGEST);
const _: () = assert!(vendor::LENGTH <= LONGEST);

/// Reads until two readings agree.
async fn read(memory: &mut Memory, address: u16) -> Option<Bytes> {
    let mut readings = Readings::new();
    for _ in 0..2 * TRIES {
        health::sign(Task::Store);
        let mut bytes = [0; LONGEST];
        if memory.read(address, &mut bytes).await.is_err() {
            Timer::after(PAUSE).await;
        } else if readings.confirm(bytes) {
            return Some(bytes);
        }
    }
    None
}
