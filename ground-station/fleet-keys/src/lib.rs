//! Makes the keys of a fleet: the file from which all keys are derived, and the pages with which
//! drones are provisioned.
//!
//! A [`Fleet`] is a file that holds the fleet's secret and which number was given to which drone.
//! Everything else follows from the secret ([`airlink::keys`]), so a page is made, loaded into its
//! drone and deleted.
//!
//! Two things must never happen, wherever a command is interrupted: that two pages have the same
//! [`Issue`] (their drones would use the same nonces), and that half a file lies where a whole one
//! is expected. So the key file says that an issue is given before its page is there, and is on
//! the disk by then; each file is written under another name first; and one command at a time works
//! on a fleet. A key file that has two names by a hard link is refused, since each name would go on
//! giving out numbers by itself; and a command that is killed leaves no draft with a secret in it.

mod disk;
mod fleet;
mod limits;
mod plan;

use std::path::{Path, PathBuf};

use chain::policy::Policy;
use input::InputError;
use storage::epoch::Issue;
use storage::keys::{PAGE_ADDRESS, PageMission};
use units::{Dbm, NodeId, Role};

use self::disk::{Disk, Draft, Lock, Real};
pub use self::fleet::page;
pub use self::fleet::{Fleet, FleetEntry};
pub use self::plan::stored_plan;

/// The drone for which a page is to be made.
#[derive(Clone, Copy, Debug)]
pub struct Request {
    /// The number of the drone.
    pub node: NodeId,
    /// The role of the drone; where left out it follows from the number: 0 is the head, 15 the
    /// base, and any other a relay.
    pub role: Option<Role>,
    /// Whether cfclient may fly the head through this drone.
    pub may_fly: bool,
    /// The movement policy that the drone uses from now on; `None` leaves the drone's policy as it
    /// is.
    pub policy: Option<&'static Policy>,
    /// The launch limit and the retreat limit that the drone uses from now on; `None` leaves the
    /// drone's limits as they are.
    pub limits: Option<[Dbm; 2]>,
    /// The mission that the drone flies from now on; `None` leaves the drone's mission as it is.
    pub mission: Option<PageMission>,
}

/// A page that was made.
#[derive(Clone, Debug)]
pub struct Provisioned {
    /// The fleet as it is now.
    pub fleet: Fleet,
    /// The number of the drone.
    pub node: NodeId,
    /// The drone's entry in the key file.
    pub drone: FleetEntry,
    /// Whether another drone may have keys of this number and generation.
    pub replaces: bool,
    /// The mission that the page gives the drone.
    pub mission: Option<PageMission>,
    /// The path of the page.
    pub page: PathBuf,
}

impl Provisioned {
    /// Returns the two commands that load the page into a drone: with a probe, and by USB.
    ///
    /// `dfu-util`'s `:leave` is not among its options on purpose: it would start the program at
    /// this address, where the keys are.
    #[must_use]
    pub fn commands(&self) -> [String; 2] {
        let (address, page) = (format!("0x{PAGE_ADDRESS:08X}"), quoted(&self.page));
        [
            format!(
                "probe-rs download --chip STM32F405RGTx --binary-format bin --base-address \
                 {address} {page}"
            ),
            format!("dfu-util -d 0483:df11 -a 0 -s {address} -D {page}"),
        ]
    }
}

/// A path, quoted for a shell.
fn quoted(path: &Path) -> String {
    let text = path.display().to_string();
    let plain = |c: char| c.is_ascii_alphanumeric() || "/._-+,=:@%".contains(c);
    if text.chars().all(plain) { text } else { format!("'{}'", text.replace('\'', r"'\''")) }
}

/// Makes a fleet with a secret of the operating system's random source, and its file.
///
/// # Errors
/// If there is such a file already, it cannot be written, or the random source fails.
pub fn create(path: &Path, generation: u8) -> Result<Fleet, InputError> {
    if generation == 0 {
        return Err(InputError::new("--generation 0 is out of range", "give 1 to 255"));
    }
    let _lock = Lock::of(path)?;
    disk::clean(path);
    let disk = &mut Real::default();
    if disk.exists(path) {
        return Err(InputError::new(
            "there is something here already, and a key file is never overwritten",
            "give another name, or move it away",
        )
        .in_file(path));
    }
    let mut secret = [0; 16];
    getrandom::fill(&mut secret).map_err(|error| {
        InputError::new(
            format!("the operating system gives no random bytes ({error})"),
            "try again later, or on another machine",
        )
    })?;
    let fleet = Fleet::new(secret, generation);
    disk::replace(disk, path, fleet.text().as_bytes())?;
    Ok(fleet)
}

/// Reads a key file.
///
/// # Errors
/// If it cannot be read, if others can read it, too, or if it is not a key file.
pub fn open(path: &Path) -> Result<Fleet, InputError> {
    Fleet::parse(path, &disk::read_private(path)?)
}

/// Gives out an issue and writes its page to `out`.
///
/// # Errors
/// If the fleet cannot be read or written, has no number left, or there is something at `out`.
pub fn provision(path: &Path, request: &Request, out: &Path) -> Result<Provisioned, InputError> {
    let path = &disk::only(path)?;
    let _lock = Lock::of(path)?;
    disk::clean(path);
    disk::clean(out);
    provision_on(&mut Real::default(), path, open(path)?, request, out)
}

fn provision_on(
    disk: &mut impl Disk,
    path: &Path,
    mut fleet: Fleet,
    request: &Request,
    out: &Path,
) -> Result<Provisioned, InputError> {
    let Request { node, mission, .. } = *request;
    let before = fleet.drones().get(&node.0);
    let replaces = before.is_some_and(|drone| drone.generation == fleet.generation());
    let (drone, record) = fleet.give_out(request).map_err(|e| e.in_file(path))?;
    if disk.exists(out) {
        return Err(InputError::new(
            "there is something here already, and a page is never overwritten",
            "give --out another name, or delete it if its drone has it",
        )
        .in_file(out));
    }
    // First, so that a place where nothing can be written costs no issue.
    let draft = Draft::begin(disk, out)?;
    if let Err(error) = disk::replace(disk, path, fleet.text().as_bytes()) {
        draft.abandon(disk);
        return Err(error);
    }
    draft.finish(disk, &record)?;
    Ok(Provisioned { fleet, node, drone, replaces, mission, page: out.to_owned() })
}

/// Begins the fleet's next generation, without the drones of these numbers. Returns the fleet as it
/// is now.
///
/// # Errors
/// If the fleet cannot be read or written, has no such drone, or no generation left.
pub fn rekey(path: &Path, without: &[NodeId]) -> Result<Fleet, InputError> {
    let path = &disk::only(path)?;
    let _lock = Lock::of(path)?;
    disk::clean(path);
    let mut fleet = open(path)?;
    fleet.rekey(without).map_err(|error| error.in_file(path))?;
    disk::replace(&mut Real::default(), path, fleet.text().as_bytes())?;
    Ok(fleet)
}

/// The number of issues of a fleet.
#[must_use]
pub const fn issues() -> u8 {
    Issue::LAST.get()
}

#[cfg(test)]
mod tests;
