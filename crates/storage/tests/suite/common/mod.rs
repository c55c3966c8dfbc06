//! A memory that loses power in the middle of a write, and records to be written into it.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use storage::epoch::{EpochRecord, Issue};
use storage::keys::{KeysRecord, Secret};
use storage::ledger::Ledger;
use storage::settings::{Limits, Radio, Settings, SwarmPlan, Trim};
use storage::{Record, Slots};
use units::{Dbm, Metres, MissionKind, NodeId, Point2, PolicyCode, Radians, Role};
use wire::radio::{Address, Channel, Datarate, TxPower};

pub(crate) fn seeded(cases: u32) -> ProptestConfig {
    ProptestConfig {
        rng_seed: RngSeed::Fixed(1),
        failure_persistence: None,
        cases,
        ..Default::default()
    }
}

/// A memory that is written page by page.
pub(crate) struct Memory {
    pub(crate) bytes: Vec<u8>,
    /// Bytes in a page: 32 in the Crazyflie's 24AA64.
    pub(crate) page: usize,
}

/// Power that lasts for so many bytes.
pub(crate) struct Power {
    pub(crate) left: Option<usize>,
    pub(crate) random: u64,
    /// The percentage of readings in which the bus turns a bit over.
    pub(crate) misreads: u8,
}

/// The power went during a write.
#[derive(Debug, PartialEq)]
pub(crate) struct Cut;

impl Power {
    pub(crate) fn draw(&mut self) -> u64 {
        self.random = self
            .random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        self.random >> 33
    }

    pub(crate) fn misreads(&mut self) -> bool {
        self.misreads > 0 && self.draw() % 100 < u64::from(self.misreads)
    }

    /// Whether another byte gets written.
    pub(crate) fn spend(&mut self) -> bool {
        match &mut self.left {
            None => true,
            Some(0) => false,
            Some(left) => {
                *left -= 1;
                true
            }
        }
    }
}

impl Memory {
    pub(crate) fn filled_with(byte: u8, page: usize) -> Self {
        Self { bytes: vec![byte; 0x2000], page }
    }

    pub(crate) fn slots<R: Record>(&self) -> Slots<R> {
        let [a, b] = R::ADDRESSES.map(|address| self.at(address, R::LENGTH));
        Slots::read(a, b)
    }

    pub(crate) fn at(&self, address: u16, length: usize) -> &[u8] {
        &self.bytes[usize::from(address)..][..length]
    }

    /// Writes page by page, the bytes of each page in any order.
    pub(crate) fn write(
        &mut self,
        address: u16,
        bytes: &[u8],
        power: &mut Power,
    ) -> Result<(), Cut> {
        for (number, piece) in bytes.chunks(self.page).enumerate() {
            let start = usize::from(address) + self.page * number;
            let mut order: Vec<usize> = (0..piece.len()).collect();
            for i in (1..order.len()).rev() {
                order.swap(i, power.draw() as usize % (i + 1));
            }
            for at in order {
                if !power.spend() {
                    self.tear(start, power);
                    return Err(Cut);
                }
                self.bytes[start + at] = piece[at];
            }
        }
        Ok(())
    }

    /// The page in which the power went: left as it is, or each of its bytes disturbed by chance,
    /// also those where nothing was to be written.
    fn tear(&mut self, start: usize, power: &mut Power) {
        let disturbed = power.draw() % 4;
        for byte in &mut self.bytes[start..start + self.page] {
            if power.draw() % 3 < disturbed {
                *byte = power.draw() as u8;
            }
        }
    }
}

pub(crate) fn settings() -> impl Strategy<Value = Settings> {
    let role = prop::sample::select(&[Role::Head, Role::Relay, Role::Base]);
    let rate = prop::sample::select(&[Datarate::Kbit250, Datarate::Mbit1, Datarate::Mbit2]);
    let radio = (0_u8..126, rate, any::<[u8; 5]>(), prop::sample::select(&TxPower::ALL)).prop_map(
        |(channel, datarate, address, power)| Radio {
            channel: Channel::new(channel).unwrap(),
            datarate,
            address: Address(address),
            power,
        },
    );
    let trim = (-0.35f32..0.35, -0.35f32..0.35)
        .prop_map(|(pitch, roll)| Trim { pitch: Radians(pitch), roll: Radians(roll) });
    let height = prop::option::of((0.01f32..4.0).prop_map(Metres));
    let limit = || prop::option::of((-96.0f32..=-20.0).prop_map(Dbm));
    let limits = (limit(), limit()).prop_map(|(launch, retreat)| Limits { launch, retreat });
    let policy = any::<u8>().prop_map(PolicyCode::new);
    let mission = prop::sample::select(&MissionKind::ALL[..]);
    let after = (mission, prop::option::of(plans()), any::<bool>());
    (any::<u8>(), role, radio, trim, height, limits, policy, after).prop_map(
        |(node, role, radio, trim, height, limits, policy, (mission, swarm, fetched))| Settings {
            mission,
            swarm,
            fetched,
            node: NodeId(node),
            role,
            radio,
            trim,
            height,
            limits,
            policy,
        },
    )
}

/// Plans to the centimetre and the degree.
fn plans() -> impl Strategy<Value = SwarmPlan> {
    let metres = |least: i16, most: i16| (least..=most).prop_map(|cm| f32::from(cm) / 100.0);
    let point = move || (metres(-999, 999), metres(-999, 999)).prop_map(|(x, y)| Point2::new(x, y));
    let length = move |least, most| metres(least, most).prop_map(Metres);
    let area = (length(100, 10_000), length(100, 10_000));
    let passage = (length(50, 2_000), -180_i16..=180, length(0, 10_000));
    (1_u8..16, point(), area, point(), passage, any::<bool>()).prop_map(
        |(drones, corner, area, entrance, (width, degrees, length), both)| SwarmPlan {
            drones,
            corner,
            area,
            entrance,
            width,
            direction: Radians(f32::from(degrees).to_radians()),
            length,
            both,
        },
    )
}

pub(crate) fn keys() -> impl Strategy<Value = KeysRecord> {
    let role = prop::sample::select(&[Role::Head, Role::Relay, Role::Base]);
    (any::<u32>(), 1_u8.., 1_u8..=254, 0_u8..16, role, any::<bool>(), any::<[[u8; 16]; 2]>())
        .prop_map(|(fleet, generation, issue, node, role, may_fly, [group, own])| KeysRecord {
            fleet,
            generation,
            issue: Issue::new(issue).unwrap(),
            node: NodeId(node),
            role,
            may_fly: may_fly && role == Role::Base,
            group: Secret::new(group),
            own: Secret::new(own),
        })
}

pub(crate) fn epochs() -> impl Strategy<Value = EpochRecord> {
    any::<u32>().prop_map(|fleet| EpochRecord { fleet })
}

pub(crate) fn ledgers() -> impl Strategy<Value = Ledger> {
    prop::collection::vec(keys(), 0..12)
        .prop_map(|all| all.iter().fold(Ledger::EMPTY, |ledger, keys| ledger.with(keys)))
}

/// CRC-32, put together here and not by the code under test.
pub(crate) fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| {
            (crc >> 1) ^ (0xEDB8_8320 & (crc & 1_u32).wrapping_neg())
        })
    })
}

/// The record with the CRC that it should have.
pub(crate) fn mended(mut record: Vec<u8>) -> Vec<u8> {
    if let Some((body, crc)) = record.split_last_chunk_mut::<4>() {
        *crc = crc32(body).to_le_bytes();
    }
    record
}
