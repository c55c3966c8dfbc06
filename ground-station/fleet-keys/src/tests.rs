//! That no issue is given twice and no file is half there, wherever a command is stopped; and what
//! is refused.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io;

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use storage::Record;
use storage::keys::{KeysRecord, Page};
use storage::ledger::Ledger;
use storage::settings::Limits;

use super::disk::read_private;
use super::*;

const SECRET: [u8; 16] = [
    0x5A, 0x1B, 0x2C, 0x3D, 0x4E, 0x5F, 0x60, 0x71, 0x82, 0x93, 0xA4, 0xB5, 0xC6, 0xD7, 0xE8, 0xF9,
];

fn fleet_path() -> PathBuf {
    PathBuf::from("safe/fleet.toml")
}

fn page_path() -> PathBuf {
    PathBuf::from("stick/page.bin")
}

fn relay(node: u8) -> Request {
    let (policy, limits, mission) = (None, None, None);
    Request { node: NodeId(node), role: None, may_fly: false, policy, limits, mission }
}

/// A disk that can be stopped after any step: what it does not know to be kept may be lost then,
/// names and contents each for itself.
#[derive(Clone, Default)]
struct Paper {
    /// The contents of each file, and how much of it is sure to be kept.
    contents: Vec<(Vec<u8>, usize)>,
    /// Which file a name means, and which it means for sure after a power cut.
    names: BTreeMap<PathBuf, usize>,
    kept: BTreeMap<PathBuf, usize>,
    /// Steps until it stops, or until one goes wrong.
    left: Option<usize>,
    goes_on: bool,
}

impl Paper {
    fn with(path: &Path, bytes: &[u8]) -> Self {
        let mut paper = Self { contents: vec![(bytes.to_vec(), bytes.len())], ..Self::default() };
        paper.names.insert(path.to_owned(), 0);
        paper.kept.insert(path.to_owned(), 0);
        paper
    }

    fn step(&mut self) -> io::Result<()> {
        let stopped = || Err(io::Error::other("stopped"));
        match &mut self.left {
            None => Ok(()),
            Some(0) => {
                if self.goes_on {
                    self.left = None;
                }
                stopped()
            }
            Some(left) => {
                *left -= 1;
                Ok(())
            }
        }
    }

    fn of(&mut self, path: &Path) -> io::Result<&mut (Vec<u8>, usize)> {
        let number = self.names.get(path).ok_or(io::ErrorKind::NotFound)?;
        Ok(&mut self.contents[*number])
    }

    fn read(&self, path: &Path) -> Option<&[u8]> {
        self.names.get(path).map(|number| self.contents[*number].0.as_slice())
    }

    /// The disk after the power cut: each name that was not sure is as it was or as it would have
    /// been, and each content is cut to some length that was not sure either.
    fn after_power_cut(&self, choice: u32) -> Self {
        let mut after = Self::default();
        let all: BTreeSet<_> = self.names.keys().chain(self.kept.keys()).collect();
        assert!(all.len() <= 4, "a bit for each");
        for (i, name) in all.into_iter().enumerate() {
            let new = choice & (1 << i) != 0;
            let Some(number) = (if new { &self.names } else { &self.kept }).get(name) else {
                continue;
            };
            let (bytes, sure) = &self.contents[*number];
            let length = if choice & 0x10 != 0 { (sure + bytes.len()) / 2 } else { *sure };
            after.contents.push((bytes[..length].to_vec(), length));
            after.names.insert(name.clone(), after.contents.len() - 1);
        }
        after.kept = after.names.clone();
        after
    }
}

impl Disk for Paper {
    fn exists(&self, path: &Path) -> bool {
        self.names.contains_key(path)
    }

    fn create(&mut self, path: &Path) -> io::Result<()> {
        self.step()?;
        self.contents.push((Vec::new(), 0));
        self.names.insert(path.to_owned(), self.contents.len() - 1);
        Ok(())
    }

    fn write(&mut self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        let stopped = self.step();
        let half = if stopped.is_ok() { bytes.len() } else { bytes.len() / 2 };
        self.of(path)?.0.extend(&bytes[..half]);
        stopped
    }

    fn sync(&mut self, path: &Path) -> io::Result<()> {
        self.step()?;
        let (bytes, sure) = self.of(path)?;
        *sure = bytes.len();
        Ok(())
    }

    fn rename(&mut self, from: &Path, to: &Path) -> io::Result<()> {
        self.step()?;
        let number = self.names.remove(from).ok_or(io::ErrorKind::NotFound)?;
        self.names.insert(to.to_owned(), number);
        Ok(())
    }

    fn sync_folder(&mut self, folder: &Path) -> io::Result<()> {
        self.step()?;
        self.kept.retain(|name, _| name.parent() != Some(folder));
        for (name, number) in &self.names {
            if name.parent() == Some(folder) {
                self.kept.insert(name.clone(), *number);
            }
        }
        Ok(())
    }

    fn remove(&mut self, path: &Path) {
        if self.step().is_ok() {
            self.names.remove(path);
        }
    }
}

fn fleet_on(paper: &Paper) -> Fleet {
    let text = paper.read(&fleet_path()).expect("the fleet's file is always there");
    Fleet::parse(&fleet_path(), std::str::from_utf8(text).unwrap()).expect("and always whole")
}

/// What is on a disk after a command that was stopped somewhere: the fleet from before or after,
/// a page that is whole or none, and a next issue that is the page's neither.
fn all_is_well(before: &Fleet, paper: &Paper, place: &str) {
    let now = fleet_on(paper);
    assert!(now == *before || now.issued() == before.issued() + 1, "{place}");
    let page = paper.read(&page_path()).map(|page| {
        let (keys, _) = KeysRecord::decode(page).unwrap_or_else(|why| panic!("{place}: {why}"));
        assert!(keys.issue.get() > before.issued() && keys.issue.get() <= now.issued(), "{place}");
        keys.issue
    });
    let mut again = paper.clone();
    (again.left, again.goes_on) = (None, false);
    let other = Path::new("stick/other.bin");
    let made = provision_on(&mut again, &fleet_path(), now, &relay(2), other).unwrap();
    assert!(page.is_none_or(|page| made.drone.issue > page), "{place}: given twice");
    assert_eq!(fleet_on(&again), made.fleet);
}

fn before() -> (Fleet, Paper) {
    let mut fleet = Fleet::new(SECRET, 3);
    fleet.give_out(&relay(0)).unwrap();
    let paper = Paper::with(&fleet_path(), fleet.text().as_bytes());
    (fleet, paper)
}

#[test]
fn a_provisioning_that_stops_after_any_step_gives_no_issue_twice() {
    let (before, whole) = before();
    let mut step = 0;
    loop {
        let mut paper = Paper { left: Some(step), ..whole.clone() };
        let made = provision_on(&mut paper, &fleet_path(), before.clone(), &relay(1), &page_path());
        // The process is gone, and the machine goes on.
        all_is_well(&before, &paper, &format!("stopped after {step}"));
        // The machine is gone, too.
        for choice in 0..0x20 {
            let place = format!("power gone after {step}, {choice:#x} is kept");
            all_is_well(&before, &paper.after_power_cut(choice), &place);
        }
        if made.is_ok() {
            break;
        }
        step += 1;
    }
    assert_eq!(step, 10, "two files: create, write, sync, rename and sync the folder");
}

#[test]
fn a_step_that_goes_wrong_leaves_nothing_unfinished() {
    let (before, whole) = before();
    for step in 0..10 {
        let mut paper = Paper { left: Some(step), goes_on: true, ..whole.clone() };
        let made = provision_on(&mut paper, &fleet_path(), before.clone(), &relay(1), &page_path());
        let complaint = made.unwrap_err().to_string();
        assert!(complaint.contains("cannot be written") && complaint.lines().count() == 1);
        all_is_well(&before, &paper, &format!("step {step} went wrong"));
        for name in paper.names.keys() {
            assert!([fleet_path(), page_path()].contains(name), "{name:?} is left");
        }
    }
}

#[test]
fn what_is_refused_costs_no_issue() {
    let (fleet, mut paper) = before();
    paper.contents.push((b"somebody's".to_vec(), 10));
    paper.names.insert(page_path(), 1);
    let base = |node, may_fly| Request { may_fly, ..relay(node) };
    let two_heads = Request { role: Some(Role::Head), ..relay(4) };
    for (request, out, why) in [
        (relay(1), page_path(), "never overwritten"),
        (relay(16), PathBuf::from("stick/a.bin"), "out of range"),
        (relay(255), PathBuf::from("stick/a.bin"), "out of range"),
        (base(3, true), PathBuf::from("stick/a.bin"), "for the base alone"),
        (two_heads, PathBuf::from("stick/a.bin"), "node 0 is the head of this fleet already"),
        (relay(1), PathBuf::from("/"), "no name for a file"),
    ] {
        let made = provision_on(&mut paper, &fleet_path(), fleet.clone(), &request, &out);
        let complaint = made.unwrap_err().to_string();
        assert!(complaint.contains(why), "{complaint}");
        assert_eq!(fleet_on(&paper), fleet);
        assert_eq!(paper.names.len(), 2);
    }
    assert_eq!(paper.read(&page_path()), Some(&b"somebody's"[..]));
}

#[test]
fn a_fleet_has_254_issues_and_then_no_more() {
    let (mut fleet, mut paper) = before();
    let mut seen = BTreeSet::from([1]);
    for i in 2..=254_u8 {
        let out = PathBuf::from(format!("stick/{i}.bin"));
        let made = provision_on(&mut paper, &fleet_path(), fleet, &relay(1 + i % 14), &out);
        let made = made.unwrap();
        assert!(seen.insert(made.drone.issue.get()));
        fleet = made.fleet;
    }
    let full = provision_on(&mut paper, &fleet_path(), fleet.clone(), &relay(1), &page_path());
    let complaint = full.unwrap_err().to_string();
    assert!(complaint.contains("all 254 issues") && complaint.contains("keys new"), "{complaint}");
    assert_eq!(fleet_on(&paper), fleet);
    // Another generation does not make the numbers good again.
    fleet.rekey(&[]).unwrap();
    assert!(fleet.give_out(&relay(1)).is_err());
}

#[test]
fn there_are_255_generations_and_then_no_more() {
    let mut fleet = Fleet::new(SECRET, 254);
    fleet.rekey(&[]).unwrap();
    let complaint = fleet.rekey(&[]).unwrap_err().to_string();
    assert!(complaint.contains("last generation"), "{complaint}");
    assert_eq!(fleet.generation(), 255);
}

fn fleets() -> impl Strategy<Value = Fleet> {
    let acts = prop::collection::vec((0_u8..16, any::<bool>(), 0_usize..10), 0..40);
    (any::<[u8; 16]>(), 1_u8..200, acts).prop_map(|(secret, generation, acts)| {
        let mut fleet = Fleet::new(secret, generation);
        for (node, may_fly, act) in acts {
            match act {
                0 => fleet.rekey(&[]).unwrap(),
                1 if fleet.drones().contains_key(&node) => fleet.rekey(&[NodeId(node)]).unwrap(),
                _ => {
                    let may_fly = may_fly && node == 15;
                    let policy = chain::policy::REGISTRY.get(act);
                    let _ = fleet.give_out(&Request { may_fly, policy, ..relay(node) });
                }
            }
        }
        fleet
    })
}

proptest! {
    #![proptest_config(ProptestConfig {
        rng_seed: RngSeed::Fixed(1), failure_persistence: None, ..Default::default()
    })]

    #[test]
    fn what_is_written_is_read(fleet in fleets()) {
        let read = Fleet::parse(&fleet_path(), &fleet.text()).unwrap();
        prop_assert_eq!(read.text(), fleet.text());
        prop_assert_eq!(read, fleet);
    }

    #[test]
    fn a_file_that_was_cut_off_is_no_fleet(fleet in fleets(), at in any::<prop::sample::Index>()) {
        let text = fleet.text();
        refused_when_cut_off(&fleet, at.index(text.trim_end().len()));
    }

    #[test]
    fn a_disturbed_file_is_refused_in_one_line_or_has_the_same_secret(
        fleet in fleets(), at in any::<prop::sample::Index>(), byte in 0x20_u8..0x7F,
    ) {
        let mut text = fleet.text().into_bytes();
        let at = at.index(text.len());
        text[at] = byte;
        let text = String::from_utf8(text).unwrap();
        match Fleet::parse(&fleet_path(), &text) {
            Ok(read) => prop_assert_eq!(read.name(), fleet.name()),
            Err(error) => {
                let complaint = error.to_string();
                prop_assert_eq!(complaint.lines().count(), 1, "{}", complaint);
                prop_assert!(complaint.starts_with("safe/fleet.toml:"), "{}", complaint);
                says_nothing_of(fleet.secret(), &complaint);
            }
        }
    }

    #[test]
    fn anything_at_all_is_refused_in_one_line(text in "\\PC{0,200}") {
        let complaint = Fleet::parse(&fleet_path(), &text).unwrap_err().to_string();
        prop_assert_eq!(complaint.lines().count(), 1);
    }
}

fn refused_when_cut_off(fleet: &Fleet, end: usize) {
    let complaint = Fleet::parse(&fleet_path(), &fleet.text()[..end]).unwrap_err().to_string();
    assert_eq!(complaint.lines().count(), 1, "{complaint}");
    says_nothing_of(fleet.secret(), &complaint);
}

#[test]
fn no_place_is_one_where_a_file_may_be_cut_off() {
    let (mut fleet, _) = before();
    fleet.give_out(&Request { may_fly: true, ..relay(15) }).unwrap();
    for end in 0..fleet.text().trim_end().len() {
        refused_when_cut_off(&fleet, end);
    }
}

impl Fleet {
    fn secret(&self) -> [u8; 16] {
        let text = self.text();
        let digits = text.split("secret = \"").nth(1).unwrap();
        std::array::from_fn(|i| u8::from_str_radix(&digits[2 * i..2 * i + 2], 16).unwrap())
    }
}

/// Not 4 of its bytes on end.
fn says_nothing_of(secret: [u8; 16], text: &str) {
    let digits: String = secret.iter().map(|byte| format!("{byte:02x}")).collect();
    let text = text.to_lowercase();
    for at in 0..=24 {
        assert!(!text.contains(&digits[at..at + 8]), "{text}");
    }
}

#[test]
fn what_is_wrong_is_told_with_its_line_and_a_remedy() {
    let (fleet, _) = before();
    let digits = "5a1b2c3d4e5f60718293a4b5c6d7e8f9";
    for (find, put, line, why) in [
        ("version = 1", "version = 2", 4, "version 2, of which nothing is known; use the uchain"),
        ("version = 1", "", 1, "missing field `version`"),
        ("version = 1", "version = 1\ncolour = 3", 5, "unknown field `colour`"),
        ("node = 0", "node = 16", 7, "node = 16 is not within 0 to 15"),
        ("node = 0", "node = -1", 7, "node = -1 is not within 0 to 15"),
        ("\"head\"", "\"boss\"", 8, "unknown variant `boss`"),
        ("cfclient = false", "cfclient = true", 9, "for the base alone"),
        ("issue = 1", "issue = 2", 11, "issue = 2 is not within 1 to 1"),
        ("issued = 1", "issued = 0", 11, "none has been given out"),
        ("issued = 1", "issued = 255", 15, "issued = 255 is not within 0 to 254"),
        ("[fleet]\ngeneration = 3", "[fleet]\ngeneration = 0", 14, "generation = 0 is not within"),
        ("[fleet]\ngeneration = 3", "[fleet]\ngeneration = 2", 10, "3 is not within 1 to 2"),
        (digits, &digits[1..], 16, "the secret is not 32 hexadecimal digits"),
        (digits, "5a1b2c3d4e5f60718293a4b5c6d7e8fg", 16, "the secret is not 32 hexadecimal"),
        (digits, "5b1b2c3d4e5f60718293a4b5c6d7e8f9", 17, "does not go with its secret"),
        (&format!("\"{digits}\""), digits, 16, "no key file"),
        (&format!("secret = \"{digits}\""), digits, 16, "no key file"),
        (&format!("secret = \"{digits}\""), &format!("{digits} = 1"), 16, "unknown field"),
        (&format!("\"{digits}\""), "12345678", 16, "the secret is not 32 hexadecimal digits"),
    ] {
        let text = fleet.text();
        assert!(text.contains(find), "{find}");
        let complaint =
            Fleet::parse(&fleet_path(), &text.replacen(find, put, 1)).unwrap_err().to_string();
        assert!(complaint.contains(why), "{complaint}");
        assert!(complaint.starts_with(&format!("safe/fleet.toml:{line}: ")), "{complaint}");
        assert!(complaint.contains("; "), "{complaint}");
        says_nothing_of(SECRET, &complaint);
    }
}

#[test]
fn two_drones_of_one_number_or_one_issue_are_refused() {
    let (mut fleet, _) = before();
    fleet.give_out(&relay(7)).unwrap();
    for (find, put) in [("node = 7", "node = 0"), ("issue = 2", "issue = 1")] {
        let text = fleet.text().replacen(find, put, 1);
        let complaint = Fleet::parse(&fleet_path(), &text).unwrap_err().to_string();
        assert!(complaint.contains("the same node or the same issue"), "{complaint}");
    }
}

#[test]
fn a_drone_keeps_the_policy_that_it_was_given() {
    let mut fleet = Fleet::new(SECRET, 1);
    let t5 = Policy::named("t5");
    let code = t5.map(|policy| policy.code);
    for (policy, on_page) in [(None, None), (t5, code), (None, code)] {
        let (drone, page) = fleet.give_out(&Request { policy, ..relay(3) }).unwrap();
        let storage::keys::Page::New { keys, policy, .. } =
            KeysRecord::on_page(&page, None, &storage::ledger::Ledger::EMPTY)
        else {
            panic!("{page:x?}");
        };
        assert_eq!((keys.node, policy), (NodeId(3), on_page));
        assert_eq!(drone.policy.map(|policy| policy.code), on_page);
        assert_eq!(Fleet::parse(&fleet_path(), &fleet.text()).unwrap(), fleet);
    }
    let text = fleet.text().replace("\"t5\"", "\"t6\"");
    let complaint = Fleet::parse(&fleet_path(), &text).unwrap_err().to_string();
    assert!(complaint.contains("there is no policy \"t6\"; give one of t0, t5"), "{complaint}");
}

#[test]
fn limits_go_onto_the_page_where_they_fit_each_other() {
    let mut fleet = Fleet::new(SECRET, 1);
    let policy = Policy::named("t5");
    for (policy, limits) in
        [(None, None), (policy, Some([-67.5, -72.0])), (None, Some([-60.0, -65.0]))]
    {
        let limits = limits.map(|limits| limits.map(Dbm));
        let (_, page) = fleet.give_out(&Request { policy, limits, ..relay(3) }).unwrap();
        let Page::New { limits: found, .. } = KeysRecord::on_page(&page, None, &Ledger::EMPTY)
        else {
            panic!("{page:x?}");
        };
        let wanted =
            limits.map(|[launch, retreat]| Limits { launch: Some(launch), retreat: Some(retreat) });
        assert_eq!(found, wanted);
    }
    let before = fleet.issued();
    for (limits, why) in [
        ([-97.0, -98.0], "out of range"),
        ([f32::NAN, -72.0], "out of range"),
        ([-72.0, -72.0], "do not fit"),
        ([-72.0, -67.0], "do not fit"),
    ] {
        let request = Request { limits: Some(limits.map(Dbm)), ..relay(3) };
        let complaint = fleet.give_out(&request).unwrap_err().to_string();
        assert!(complaint.contains(why), "{limits:?}: {complaint}");
    }
    assert_eq!(fleet.issued(), before, "a refused request costs no issue");
}

#[test]
fn a_page_gives_a_drone_the_mission_that_was_asked_for() {
    let swarm = stored_plan(&agent::SwarmConfig::DEFAULT);
    assert!(swarm.is_some(), "the firmware's own plan can be stored");
    let mut fleet = Fleet::new(SECRET, 1);
    for policy in [None, Policy::named("t5")] {
        for kind in units::MissionKind::ALL {
            let swarm = swarm.filter(|_| kind == units::MissionKind::Swarm);
            let fetched = policy.is_some();
            let wanted = Some(PageMission { kind, swarm, fetched });
            let request = Request { policy, mission: wanted, ..relay(3) };
            let (_, page) = fleet.give_out(&request).unwrap();
            let storage::keys::Page::New { keys, mission, .. } =
                KeysRecord::on_page(&page, None, &storage::ledger::Ledger::EMPTY)
            else {
                panic!("{page:x?}");
            };
            assert_eq!((keys.node, mission), (NodeId(3), wanted));
        }
    }
}

#[test]
fn printing_a_fleet_prints_no_key() {
    let fleet = Fleet::new(SECRET, 1);
    says_nothing_of(SECRET, &format!("{fleet:?}"));
    assert_eq!(format!("{fleet:?}"), format!("Fleet {{ name: {:?}, .. }}", fleet.name()));
}

/// A folder of this test's own, gone when dropped.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("uchain-keys-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

#[test]
fn two_fleets_have_different_secrets() {
    let scratch = Scratch::new("two");
    let fleets = ["a", "b"].map(|name| create(&scratch.0.join(name), 1).unwrap());
    assert_ne!(fleets[0].secret(), fleets[1].secret());
    assert_ne!(fleets[0].name(), fleets[1].name());
}

/// Several at once on one fleet: each gets an issue of its own, and none is lost.
#[test]
fn commands_at_the_same_time_give_out_different_issues() {
    let scratch = Scratch::new("at-once");
    let file = scratch.0.join("fleet.toml");
    create(&file, 1).unwrap();
    let issues: Vec<_> = std::thread::scope(|scope| {
        let threads: Vec<_> = (1..=6)
            .map(|node| {
                let (file, out) = (&file, scratch.0.join(format!("{node}.bin")));
                scope.spawn(move || provision(file, &relay(node), &out).unwrap().drone.issue)
            })
            .collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    });
    assert_eq!(issues.iter().collect::<BTreeSet<_>>().len(), 6);
    let fleet = open(&file).unwrap();
    assert_eq!((fleet.issued(), fleet.drones().len()), (6, 6));
}

#[cfg(unix)]
mod on_unix {
    use std::os::unix::fs::{MetadataExt, PermissionsExt, symlink};

    use super::*;

    #[test]
    fn nobody_else_can_read_what_is_written() {
        let scratch = Scratch::new("private");
        let (file, page) = (scratch.0.join("fleet.toml"), scratch.0.join("page.bin"));
        let private = |path: &Path| fs::metadata(path).unwrap().mode() & 0o777 == 0o600;
        create(&file, 1).unwrap();
        assert!(private(&file));
        provision(&file, &relay(1), &page).unwrap();
        assert!(private(&file) && private(&page));
        rekey(&file, &[NodeId(1)]).unwrap();
        assert!(private(&file));
    }

    #[test]
    fn a_file_that_others_can_read_is_refused_with_the_command_that_mends_it() {
        let scratch = Scratch::new("loose");
        let file = scratch.0.join("my fleet.toml");
        create(&file, 1).unwrap();
        for mode in [0o640, 0o604, 0o660, 0o644, 0o601] {
            fs::set_permissions(&file, fs::Permissions::from_mode(mode)).unwrap();
            let complaint = open(&file).unwrap_err().to_string();
            assert!(complaint.ends_with(&format!("chmod 600 '{}'", file.display())), "{complaint}");
            let page = scratch.0.join("page.bin");
            assert!(provision(&file, &relay(1), &page).is_err() && !page.exists());
            assert!(rekey(&file, &[]).is_err());
        }
        fs::set_permissions(&file, fs::Permissions::from_mode(0o600)).unwrap();
        assert_eq!((open(&file).unwrap().issued(), open(&file).unwrap().generation()), (0, 1));
    }

    /// Else there would be two fleets from then on, each with issues of its own.
    #[test]
    fn a_link_to_the_fleet_stays_a_link() {
        let scratch = Scratch::new("link");
        let (file, link) = (scratch.0.join("fleet.toml"), scratch.0.join("link.toml"));
        create(&file, 1).unwrap();
        symlink(&file, &link).unwrap();
        provision(&link, &relay(1), &scratch.0.join("1.bin")).unwrap();
        provision(&file, &relay(2), &scratch.0.join("2.bin")).unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(open(&link).unwrap().issued(), 2);
    }

    /// Each name would give out the same numbers again.
    #[test]
    fn a_fleet_with_two_names_is_refused_until_one_is_deleted() {
        let scratch = Scratch::new("hard-link");
        let (file, copy) = (scratch.0.join("fleet.toml"), scratch.0.join("backup/fleet.toml"));
        fs::create_dir(scratch.0.join("backup")).unwrap();
        create(&file, 1).unwrap();
        fs::hard_link(&file, &copy).unwrap();
        let link = scratch.0.join("link.toml");
        symlink(&copy, &link).unwrap();
        for name in [&file, &copy, &link] {
            let page = scratch.0.join("page.bin");
            for complaint in [
                provision(name, &relay(1), &page).unwrap_err().to_string(),
                rekey(name, &[]).unwrap_err().to_string(),
            ] {
                assert!(complaint.contains("2 names") && complaint.contains("-samefile"));
                assert_eq!(complaint.lines().count(), 1, "{complaint}");
            }
            assert!(!page.exists());
        }
        assert_eq!(open(&file).unwrap().issued(), 0);
        fs::remove_file(&copy).unwrap();
        provision(&file, &relay(1), &scratch.0.join("1.bin")).unwrap();
        assert_eq!(fs::metadata(&file).unwrap().nlink(), 1);
    }

    /// The names of all files in a folder that a listing does not show.
    fn hidden(folder: &Path) -> Vec<String> {
        let names = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name());
        names.map(|n| n.into_string().unwrap()).filter(|name| name.starts_with('.')).collect()
    }

    #[test]
    fn what_a_killed_command_has_left_is_removed_and_nothing_else() {
        let scratch = Scratch::new("killed");
        let (file, stick) = (scratch.0.join("fleet.toml"), scratch.0.join("stick"));
        fs::create_dir(&stick).unwrap();
        create(&file, 1).unwrap();
        let secret = fs::read(&file).unwrap();
        provision(&file, &relay(1), &stick.join("1.bin")).unwrap();
        let page = fs::read(stick.join("1.bin")).unwrap();
        for (left, bytes) in [
            (scratch.0.join(".fleet.toml.4242.keys-unfinished"), &secret[..]),
            (scratch.0.join(".other.toml.17.keys-unfinished"), &secret[..100]),
            (stick.join(".7.bin.99.keys-unfinished"), &page[..10]),
            // As versions before named them.
            (scratch.0.join(".fleet.toml.4242.unfinished"), &secret),
            (stick.join(".7.bin.99.unfinished"), &page),
        ] {
            fs::write(left, bytes).unwrap();
        }
        let kept = [
            (scratch.0.join(".results.99.unfinished"), "another program's"),
            (scratch.0.join(".fleet.toml.keys-unfinished"), "no number"),
            (scratch.0.join("fleet.toml.1.keys-unfinished"), "not hidden"),
        ];
        for (other, text) in &kept {
            fs::write(other, text).unwrap();
        }
        // A command that is still at work holds a lock on its draft.
        let at_work = scratch.0.join(".slow.toml.5.keys-unfinished");
        let slow = fs::File::create(&at_work).unwrap();
        slow.lock().unwrap();
        provision(&file, &relay(2), &stick.join("2.bin")).unwrap();
        assert!(hidden(&stick).is_empty(), "{:?}", hidden(&stick));
        assert!(at_work.exists() && kept.iter().all(|(other, _)| other.exists()));
        assert_eq!(hidden(&scratch.0).len(), 3, "{:?}", hidden(&scratch.0));
        drop(slow);
        rekey(&file, &[]).unwrap();
        assert!(!at_work.exists());
    }

    /// The process is gone before the draft has its name.
    #[test]
    fn a_draft_that_is_not_finished_is_removed_by_the_next_command() {
        let scratch = Scratch::new("draft");
        let file = scratch.0.join("fleet.toml");
        create(&file, 1).unwrap();
        let mut disk = Real::default();
        let draft = Draft::begin(&mut disk, &scratch.0.join("page.bin")).unwrap();
        drop(disk);
        drop(draft);
        if cfg!(target_os = "linux") && on_a_usual_file_system(&scratch.0) {
            assert!(hidden(&scratch.0).is_empty(), "{:?}", hidden(&scratch.0));
        }
        rekey(&file, &[]).unwrap();
        assert!(hidden(&scratch.0).is_empty(), "{:?}", hidden(&scratch.0));
    }

    /// Whether files without a name can be made in a folder.
    fn on_a_usual_file_system(folder: &Path) -> bool {
        #[cfg(target_os = "linux")]
        {
            use rustix::fs::{Mode, OFlags, open};
            open(folder, OFlags::TMPFILE | OFlags::RDWR, Mode::RUSR).is_ok()
        }
        #[cfg(not(target_os = "linux"))]
        {
            let _ = folder;
            false
        }
    }

    #[test]
    fn a_large_file_and_no_file_are_refused() {
        let scratch = Scratch::new("large");
        let file = scratch.0.join("large.toml");
        fs::write(&file, vec![b' '; 1 << 20]).unwrap();
        fs::set_permissions(&file, fs::Permissions::from_mode(0o600)).unwrap();
        assert!(read_private(&file).unwrap().len() <= 1 << 16);
        assert!(open(&file).is_err() && open(&scratch.0).is_err());
        assert!(open(&scratch.0.join("missing.toml")).is_err());
    }
}
