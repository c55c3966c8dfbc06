//! What a robot knows of the others: who hears whom, what each does, and which of its marks each has.

use heapless::Vec;
use units::{Duration, Instant, Point2};

use crate::board::Board;
use crate::cluster::{MOST_ROBOTS, RobotSet, cluster};
use crate::packet::{Activity, Bid, Body, Changes, Known, MOST_BIDS, MOST_KNOWN, Packet, Status};
use crate::tile::Tile;

/// A robot's place is told once a second, and is reckoned on for so long from there: until the next status, and half
/// as long for one that is late.
const RECKONED: Duration = Duration::from_millis(1_500);
/// A robot that was not heard for so long is not counted on. A status goes out each second; with
/// 30 % of packets lost, five in a row are lost once in 400 times.
pub(crate) const SILENCE: Duration = Duration::from_millis(5_000);
/// A robot that was not heard for so long, while this one waited for it, takes its marks with it: what
/// it has seen is explored anew. It is longer than the minute for which clusters may part.
pub(crate) const TRUST: Duration = Duration::from_millis(90_000);

/// What is known of another robot, or of this one.
#[derive(Clone, Debug)]
pub(crate) struct Member {
    /// When its last status was heard, through whichever robots.
    pub(crate) heard: Option<Instant>,
    /// When a packet was last heard from itself.
    direct: Option<Instant>,
    sequence: Option<u8>,
    pub(crate) position: Point2,
    /// Its velocity over ground by its last two statuses, m/s.
    velocity: [f32; 2],
    pub(crate) activity: Activity,
    pub(crate) goal: Tile,
    /// The robots that it hears itself.
    hears: RobotSet,
    /// The version of its marks that it tells.
    told: u16,
    /// The version of its marks that is on the board.
    held: u16,
    /// The version that it has of this robot's marks.
    has_ours: u16,
    /// Its last bids, and when they were heard.
    pub(crate) bids: Vec<Bid, MOST_BIDS>,
    pub(crate) bids_at: Option<Instant>,
}

impl Member {
    /// A robot that was not heard.
    pub(crate) const UNHEARD: Self = Self {
        heard: None,
        direct: None,
        sequence: None,
        position: Point2::new(0.0, 0.0),
        velocity: [0.0; 2],
        activity: Activity::Waiting,
        goal: Tile::FIRST,
        hears: RobotSet::EMPTY,
        told: 0,
        held: 0,
        has_ours: 0,
        bids: Vec::new(),
        bids_at: None,
    };
}

impl Member {
    /// The velocity with which the robot came from its last place to this one, where both were told in quick
    /// succession.
    fn velocity_to(&self, now: Instant, to: Point2) -> [f32; 2] {
        let age = self.heard.map_or(Duration::ZERO, |at| now.since(at));
        if age <= Duration::ZERO || age > SILENCE {
            return [0.0; 2];
        }
        let seconds = age.as_secs_f32();
        [(to.x - self.position.x) / seconds, (to.y - self.position.y) / seconds]
    }

    /// Where the robot is so long after its last status, if it flies on.
    fn place_after(&self, age: Duration) -> Point2 {
        let seconds = age.min(RECKONED).as_secs_f32();
        let [east, north] = self.velocity;
        Point2::new(self.position.x + seconds * east, self.position.y + seconds * north)
    }
}

/// A robot's view of at most `ROBOTS` robots and `RECORDS` tiles.
#[derive(Clone, Debug)]
pub(crate) struct Team<const ROBOTS: usize, const RECORDS: usize> {
    own: u8,
    /// Whether robots send each other's packets on.
    forwards: bool,
    members: [Member; ROBOTS],
    pub(crate) board: Board<ROBOTS, RECORDS>,
    /// Whether marks of another robot were forgotten since this was last asked.
    lost_marks: bool,
    /// The robot of which the next status begins to speak, where one cannot speak of all.
    first_known: u8,
}

impl<const ROBOTS: usize, const RECORDS: usize> Team<ROBOTS, RECORDS> {
    pub(crate) const fn new(own: u8, forwards: bool) -> Self {
        const { assert!(ROBOTS <= MOST_ROBOTS, "a set holds the number of each robot") };
        Self {
            own,
            forwards,
            members: [const { Member::UNHEARD }; ROBOTS],
            board: Board::new(),
            lost_marks: false,
            first_known: 0,
        }
    }

    /// Forgets everything, and is the view of another robot from now on.
    pub(crate) fn begin(&mut self, own: u8, forwards: bool) {
        let Self { own: number, forwards: forward, members, board, lost_marks, first_known } = self;
        *number = own;
        *forward = forwards;
        members.iter_mut().for_each(|member| *member = Member::UNHEARD);
        board.clear();
        *lost_marks = false;
        *first_known = 0;
    }

    /// Whether marks of another robot were forgotten since this was last asked.
    pub(crate) const fn take_lost_marks(&mut self) -> bool {
        core::mem::replace(&mut self.lost_marks, false)
    }

    pub(crate) fn member(&self, robot: u8) -> Option<&Member> {
        self.members.get(usize::from(robot))
    }

    pub(crate) fn member_mut(&mut self, robot: u8) -> Option<&mut Member> {
        self.members.get_mut(usize::from(robot))
    }

    /// Notes this robot's own state as that of a member.
    pub(crate) fn note_own(&mut self, now: Instant, position: Point2, act: Activity, goal: Tile) {
        if let Some(own) = self.member_mut(self.own) {
            own.heard = Some(now);
            own.position = position;
            own.activity = act;
            own.goal = goal;
        }
    }

    /// Takes in a packet; says whether it is new and for this robot to forward.
    pub(crate) fn hear(&mut self, now: Instant, packet: &Packet) -> Heard {
        let old = Heard { is_new: false, is_to_forward: false };
        let Packet { origin, sender, sequence, .. } = *packet;
        if origin == self.own || sender == self.own {
            return old;
        }
        let Some(from) = self.member_mut(sender) else { return old };
        from.direct = Some(now);
        let Some(maker) = self.member_mut(origin) else { return old };
        let is_silent = maker.heard.is_none_or(|at| now.since(at) > SILENCE);
        let ahead = maker.sequence.map_or(1, |last| sequence.wrapping_sub(last));
        if !is_silent && (ahead == 0 || ahead > u8::MAX / 2) {
            return old;
        }
        maker.sequence = Some(sequence);
        let is_to_forward = self.forwards && self.is_missed(now, origin, sender);
        match &packet.body {
            Body::Status(status) => self.take_status(now, origin, status),
            Body::Changes(changes) => self.take_changes(origin, changes),
            Body::Bids(bids) => {
                if let Some(maker) = self.member_mut(origin) {
                    maker.bids = bids.clone();
                    maker.bids_at = Some(now);
                }
            }
            Body::Orders(_) => {}
        }
        Heard { is_new: true, is_to_forward }
    }

    /// Forgets robots that have been silent for long.
    pub(crate) fn forget_silent(&mut self, now: Instant) {
        for robot in 0..ROBOTS as u8 {
            let is_lost = robot != self.own
                && self.member(robot).and_then(|m| m.heard).is_some_and(|at| now.since(at) > TRUST);
            if is_lost && let Some(member) = self.member_mut(robot) {
                *member = Member::UNHEARD;
                self.board.forget(robot);
                self.lost_marks = true;
            }
        }
    }

    /// Whether a robot is remembered that is silent and had not stopped.
    pub(crate) fn misses_a_robot(&self, now: Instant) -> bool {
        self.members.iter().any(|member| {
            let is_silent = member.heard.is_some_and(|at| now.since(at) > SILENCE);
            is_silent && member.activity != Activity::Stopped
        })
    }

    /// The robots that this one hears itself.
    fn direct(&self, now: Instant) -> RobotSet {
        let is_near = |m: &Member| m.direct.is_some_and(|at| now.since(at) <= SILENCE);
        self.members
            .iter()
            .zip(0_u8..)
            .filter(|(m, _)| is_near(m))
            .map(|(_, robot)| robot)
            .collect()
    }

    /// The robots of this one's cluster, itself included.
    pub(crate) fn cluster(&self, now: Instant) -> RobotSet {
        let direct = self.direct(now);
        cluster(self.own, |robot| match self.member(robot) {
            _ if robot == self.own => direct,
            Some(m) if m.heard.is_some_and(|at| now.since(at) <= SILENCE) => {
                if self.forwards {
                    m.hears
                } else {
                    m.hears.only(self.own)
                }
            }
            _ => RobotSet::EMPTY,
        })
    }

    /// The other robots that are counted on, with their places by their last statuses.
    pub(crate) fn others(&self, now: Instant) -> impl Iterator<Item = (u8, Point2)> {
        let others = self.members.iter().zip(0..).filter(|(_, robot)| *robot != self.own);
        let age = move |m: &Member| m.heard.map(|at| now.since(at)).filter(|age| *age <= SILENCE);
        others.filter_map(move |(m, robot)| Some((robot, m.place_after(age(m)?))))
    }

    /// Where the other robots go.
    pub(crate) fn goals(&self) -> impl Iterator<Item = Tile> {
        let others = self.members.iter().zip(0_u8..).filter(|(_, robot)| *robot != self.own);
        let going = others.filter(|(m, _)| m.heard.is_some() && m.activity == Activity::Going);
        going.map(|(m, _)| m.goal)
    }

    /// The robot that leads: of those of the cluster that have not stopped the one with the lowest
    /// number.
    pub(crate) fn leader(&self, members: RobotSet) -> Option<u8> {
        members.iter().find(|&n| self.member(n).is_some_and(|m| m.activity != Activity::Stopped))
    }

    /// The lowest version that a robot of the set has of this robot's marks.
    pub(crate) fn least_acknowledged(&self, members: RobotSet) -> Option<u16> {
        let others = members.without(self.own);
        others.iter().filter_map(|robot| self.member(robot)).map(|m| m.has_ours).min()
    }

    /// The lowest version of this robot's marks that a robot has which is not forgotten.
    pub(crate) fn known_to_all(&self, version: u16) -> u16 {
        let others = self.members.iter().zip(0_u8..).filter(|(_, robot)| *robot != self.own);
        let heard = others.filter(|(m, _)| m.heard.is_some());
        heard.map(|(m, _)| m.has_ours).min().unwrap_or(version)
    }

    /// Whether all marks are on the board that the robots of a set have told of.
    pub(crate) fn is_up_to_date(&self, members: RobotSet) -> bool {
        let others = members.without(self.own);
        others.iter().filter_map(|robot| self.member(robot)).all(|m| m.held == m.told)
    }

    /// What a status says of the others.
    pub(crate) fn known(&mut self, now: Instant) -> Vec<Known, MOST_KNOWN> {
        let direct = self.direct(now);
        let first = self.first_known;
        let mut known = Vec::new();
        for n in 0..ROBOTS as u8 {
            let robot = (first + n) % ROBOTS as u8;
            let Some(member) = self.member(robot) else { continue };
            if robot == self.own || member.heard.is_none() && !direct.contains(robot) {
                continue;
            }
            let is_direct = direct.contains(robot);
            if known.push(Known { robot, is_direct, version: member.held }).is_err() {
                self.first_known = robot;
                break;
            }
        }
        known
    }

    /// Whether a robot that this one hears does not hear the maker of a packet itself.
    fn is_missed(&self, now: Instant, origin: u8, sender: u8) -> bool {
        let near = self.direct(now).without(origin).without(sender);
        near.iter().filter_map(|robot| self.member(robot)).any(|m| !m.hears.contains(origin))
    }

    fn take_status(&mut self, now: Instant, origin: u8, status: &Status) {
        let own = self.own;
        let Some(member) = self.member_mut(origin) else { return };
        member.velocity = member.velocity_to(now, status.position);
        member.heard = Some(now);
        member.position = status.position;
        member.activity = status.activity;
        member.goal = status.goal;
        member.told = status.version;
        // A status speaks of all robots, or of ten in turn.
        if status.known.len() < MOST_KNOWN {
            member.hears = RobotSet::EMPTY;
            member.has_ours = 0;
        }
        for known in &status.known {
            let with = member.hears.with(known.robot);
            let without = member.hears.without(known.robot);
            member.hears = if known.is_direct { with } else { without };
            if known.robot == own {
                member.has_ours = known.version;
            }
        }
        if status.version < member.held {
            // The robot has begun anew.
            member.held = 0;
            self.board.forget(origin);
            self.lost_marks = true;
        }
    }

    fn take_changes(&mut self, origin: u8, changes: &Changes) {
        let Some(member) = self.member_mut(origin) else { return };
        if !(changes.base..changes.upto).contains(&member.held) {
            return;
        }
        member.held = changes.upto;
        member.told = member.told.max(changes.upto);
        for &(tile, mark) in &changes.marks {
            self.board.apply(origin, tile, mark);
        }
    }
}

/// What became of a packet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Heard {
    /// Whether it was not heard before.
    pub(crate) is_new: bool,
    /// Whether this robot is to send it on.
    pub(crate) is_to_forward: bool,
}
