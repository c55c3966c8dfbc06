//! Holds a client's log blocks: the variables in each, and the time at which each is due.

use heapless::Vec;
use units::{Duration, Instant};
use wire::crtp::{Entries, Errno, LogData, LogType, Packet, Reply};

use crate::{Snapshot, variables};

/// The most blocks (crazyflie-firmware, `log.c`: `LOG_MAX_BLOCKS`).
pub(crate) const BLOCKS: usize = 16;
/// The most variables in all of them (`LOG_MAX_OPS`).
pub(crate) const ENTRIES: usize = 128;

/// All blocks of a client.
#[derive(Debug)]
pub(crate) struct Blocks {
    blocks: [Option<Block>; BLOCKS],
    entries: Vec<Entry, ENTRIES>,
}

#[derive(Clone, Copy, Debug)]
struct Block {
    id: u8,
    run: Option<Run>,
}

/// When a block is sent.
#[derive(Clone, Copy, Debug)]
struct Run {
    due: Instant,
    /// The period; zero sends the block once.
    period: Duration,
}

#[derive(Clone, Copy, Debug)]
struct Entry {
    /// The place of the block.
    block: u8,
    kind: LogType,
    variable: u16,
}

/// A block to send, and how many were missed before it.
pub(crate) struct Sent {
    pub(crate) packet: Packet,
    /// How often the block was due before and could not be sent.
    pub(crate) missed: u32,
}

impl Blocks {
    pub(crate) const fn new() -> Self {
        Self { blocks: [None; BLOCKS], entries: Vec::new() }
    }

    pub(crate) fn reset(&mut self) {
        self.blocks = [None; BLOCKS];
        self.entries.clear();
    }

    pub(crate) fn create(&mut self, id: u8, entries: Entries<'_>) -> Result<(), Errno> {
        if self.place(id).is_some() {
            return Err(Errno::Exists);
        }
        let free = self.blocks.iter_mut().find(|block| block.is_none()).ok_or(Errno::NoRoom)?;
        *free = Some(Block { id, run: None });
        self.append(id, entries)
    }

    /// Adds entry by entry. The entries before a wrong one stay, as in the vendor's firmware.
    pub(crate) fn append(&mut self, id: u8, entries: Entries<'_>) -> Result<(), Errno> {
        let block = self.place(id).ok_or(Errno::Missing)?;
        let mut size: usize = self.entries_of(block).map(|entry| entry.kind.size()).sum();
        for wanted in entries.iter() {
            // The vendor's firmware looks up any number in a table of eight. `ENOENT` is what
            // clients have words for.
            let kind = LogType::from_code(wanted.kind).ok_or(Errno::Missing)?;
            size += kind.size();
            if size > LogData::MAX {
                return Err(Errno::TooBig);
            }
            if self.entries.is_full() {
                return Err(Errno::NoRoom);
            }
            // Raw memory, which is asked for as variable 0xFFFF, is not shown to anyone.
            if variables::row(wanted.variable).is_none() {
                return Err(Errno::Missing);
            }
            let _ = self.entries.push(Entry { block, kind, variable: wanted.variable });
        }
        Ok(())
    }

    pub(crate) fn delete(&mut self, id: u8) -> Result<(), Errno> {
        let place = self.place(id).ok_or(Errno::Missing)?;
        self.entries.retain(|entry| entry.block != place);
        if let Some(block) = self.blocks.get_mut(usize::from(place)) {
            *block = None;
        }
        Ok(())
    }

    pub(crate) fn start(&mut self, id: u8, period: Duration, now: Instant) -> Result<(), Errno> {
        self.block(id)?.run = Some(Run { due: now + period, period });
        Ok(())
    }

    pub(crate) fn stop(&mut self, id: u8) -> Result<(), Errno> {
        self.block(id)?.run = None;
        Ok(())
    }

    /// When the next block is due.
    pub(crate) fn due(&self) -> Option<Instant> {
        self.blocks.iter().flatten().filter_map(|block| block.run).map(|run| run.due).min()
    }

    /// The block that has been due for longest.
    pub(crate) fn poll(&mut self, now: Instant, snapshot: &Snapshot) -> Option<Sent> {
        let due = self.due().filter(|due| *due <= now)?;
        let (place, block) = (0_u8..).zip(&mut self.blocks).find_map(|(place, block)| {
            let block = block.as_mut()?;
            block.run.is_some_and(|run| run.due == due).then_some((place, block))
        })?;
        let missed = block.advance(now);
        let id = block.id;
        let data =
            self.entries_of(place).fold(
                Reply::log_data(id, now),
                |data, entry| match variables::row(entry.variable) {
                    Some(row) => data.with(row.value(snapshot), entry.kind),
                    None => data,
                },
            );
        Some(Sent { packet: data.packet(), missed })
    }

    fn place(&self, id: u8) -> Option<u8> {
        (0_u8..)
            .zip(&self.blocks)
            .find_map(|(place, block)| (block.as_ref()?.id == id).then_some(place))
    }

    fn block(&mut self, id: u8) -> Result<&mut Block, Errno> {
        self.blocks.iter_mut().flatten().find(|block| block.id == id).ok_or(Errno::Missing)
    }

    fn entries_of(&self, place: u8) -> impl Iterator<Item = &Entry> {
        self.entries.iter().filter(move |entry| entry.block == place)
    }
}

impl Block {
    /// Moves on to the next multiple of the period. Blocks that a slow line has missed are not sent
    /// afterwards: they would hold the same values again.
    fn advance(&mut self, now: Instant) -> u32 {
        let Some(Run { due, period }) = self.run else { return 0 };
        if period == Duration::ZERO {
            self.run = None;
            return 0;
        }
        let mut next = due + period;
        let mut missed = 0;
        if next <= now {
            missed = now.since(due).as_micros() / period.as_micros().max(1);
            next = due + Duration::from_micros(period.as_micros().saturating_mul(missed + 1));
        }
        self.run = Some(Run { due: next, period });
        u32::try_from(missed).unwrap_or(u32::MAX)
    }
}
