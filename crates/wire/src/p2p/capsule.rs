//! Messages that travel end to end, between the base and one node, sealed for those two alone.

use units::{Dbm, Duration, Metres, MetresPerSecond, NodeId, Volts};

use super::{Counter, Error, MAX_BODY, ORDER, TAG, exactly, fill, steps};

/// Bytes of telemetry in clear.
pub const TELEMETRY: usize = 14;

/// Bytes of node and counter.
const OPEN: usize = 7;

const _: () = assert!(OPEN + TELEMETRY + TAG <= MAX_BODY && ORDER <= TELEMETRY, "it is one packet");

/// A sealed message on its way: 15 bytes and the `N` of the message.
///
/// | byte | type | field | what | unit |
/// |---|---|---|---|---|
/// | 0 | `u8` | `node` | the end that is not the base, 0 to 15 | |
/// | 1 | `u24` | `count` | of the writer's packet: the time since the writer's boot in steps of 8.192 ms | |
/// | 4 | `u24` | `epoch` | number of the writer's boots, from 1 | |
/// | 7 | `N` bytes | `sealed` | the message, encrypted | |
/// | 7 + `N` | 8 bytes | `tag` | tag of the message | |
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Capsule<const N: usize> {
    /// The end that is not the base: the recipient of a command, the sender of telemetry.
    pub node: NodeId,
    /// The number that the node that sealed the message gave it.
    pub counter: Counter,
    /// The message, encrypted.
    pub sealed: [u8; N],
    /// The tag of the message.
    pub tag: [u8; TAG],
}

impl<const N: usize> Capsule<N> {
    pub(super) fn encode(&self, out: &mut [u8; MAX_BODY]) -> usize {
        let node = [steps::nearest_name(self.node)];
        fill(out, [&node, &self.counter.to_bytes(), &self.sealed, &self.tag])
    }

    pub(super) fn decode(body: &[u8]) -> Result<Self, Error> {
        let short = || Error::Length(body.len());
        let (&[node, c0, c1, c2, c3, c4, c5], rest) =
            body.split_first_chunk::<OPEN>().ok_or_else(short)?;
        let (&sealed, tag) = rest.split_first_chunk().ok_or_else(short)?;
        let tag = tag.try_into().map_err(|_| short())?;
        let node = steps::of_name(node)?;
        let counter = Counter::from_bytes([c0, c1, c2, c3, c4, c5]).ok_or(Error::Reserved)?;
        Ok(Self { node, counter, sealed, tag })
    }
}

/// Steps of each quantity in one of its unit.
mod per {
    pub(super) const WAY: f32 = 10.0;
    pub(super) const VELOCITY: f32 = 100.0;
    pub(super) const HEIGHT: f32 = 50.0;
}

/// A step of the endurance, in µs.
const ENDURANCE_STEP: u64 = 4_000_000;

/// The byte that stands for no number.
const NONE: u8 = u8::MAX;

/// The bit that says that there is a neighbour.
const THERE: u8 = 1 << 4;

/// The state of a node, which it tells the base, in 14 bytes.
///
/// | byte | type | field | what | unit |
/// |---|---|---|---|---|
/// | 0 | `u8` | `state` | state of the node's agent, by its code | |
/// | 1 | `u8` | `fault` | the node's fault by its code, 0 none | |
/// | 2 | `u8` | `battery` | 0 none | 20 mV |
/// | 3 | `u8` | `endurance` | time that the battery still carries the node, 255 none | 4 s |
/// | 4 | bits 0–3 | `front_node` | neighbour towards the head, 0 to 15 | |
/// | 4 | bit 4 | `front` | 0 absent, 1 present | |
/// | 4 | bits 5–7 | zero | | |
/// | 5 | `u8` | `front_link` | strength of the link to it | −1 dBm |
/// | 6 | bits 0–3 | `back_node` | neighbour towards the base, 0 to 15 | |
/// | 6 | bit 4 | `back` | 0 absent, 1 present | |
/// | 6 | bits 5–7 | zero | | |
/// | 7 | `u8` | `back_link` | strength of the link to it | −1 dBm |
/// | 8 | `i16` | `odometer` | way along the tunnel | 0.1 m |
/// | 10 | `i8` | `velocity` | along the tunnel | 1 cm/s |
/// | 11 | `u8` | `height` | 255 none | 2 cm |
/// | 12 | `u16` | `heeded` | low half of the count of the last command that the node obeyed in the last two minutes, or 0 | |
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Telemetry {
    /// The state of the node's agent: `agent::State::code`.
    pub state: u8,
    /// The node's fault, 0 for none.
    pub fault: u8,
    /// The node's battery, to 20 mV.
    pub battery: Option<Volts>,
    /// The time that the battery still carries the node, to 4 s, at most 1016 s.
    pub endurance: Option<Duration>,
    /// The neighbour towards the head, and the strength of the link to it.
    pub front: Option<(NodeId, Dbm)>,
    /// The neighbour towards the base, and the strength of the link to it.
    pub back: Option<(NodeId, Dbm)>,
    /// The node's way along the tunnel, to 0.1 m.
    pub odometer: Metres,
    /// The node's velocity along the tunnel, to 1 cm/s.
    pub velocity: MetresPerSecond,
    /// The node's height, to 2 cm, at most 5.08 m: the ranger that measures it sees 4 m.
    pub height: Option<Metres>,
    /// The last 16 bits of the count of the last command that the node obeyed in the last two
    /// minutes, or zero.
    pub heeded: u16,
}

impl Telemetry {
    /// The telemetry's bytes, in clear.
    #[must_use]
    pub fn encode(&self) -> [u8; TELEMETRY] {
        let [front, front_link] = neighbour(self.front);
        let [back, back_link] = neighbour(self.back);
        let [o0, o1] = steps::short(self.odometer.0 * per::WAY).to_le_bytes();
        let velocity = self.velocity.0 * per::VELOCITY;
        let [velocity] =
            (steps::within(velocity, i8::MIN.into(), i8::MAX.into()) as i8).to_le_bytes();
        let height =
            self.height.and_then(|height| steps::number(height.0)).map_or(NONE, |height| {
                steps::within(height * per::HEIGHT, 0, i32::from(NONE) - 1) as u8
            });
        let [h0, h1] = self.heeded.to_le_bytes();
        [
            self.state,
            self.fault,
            steps::voltage(self.battery),
            self.endurance.map_or(NONE, endurance),
            front,
            front_link,
            back,
            back_link,
            o0,
            o1,
            velocity,
            height,
            h0,
            h1,
        ]
    }

    /// The telemetry in these bytes.
    ///
    /// # Errors
    /// [`Error::Length`] or [`Error::Reserved`].
    pub fn decode(bytes: &[u8]) -> Result<Self, Error> {
        let [state, fault, battery, endurance, f0, f1, b0, b1, o0, o1, velocity, height, h0, h1] =
            exactly::<TELEMETRY>(bytes)?;
        Ok(Self {
            state,
            fault,
            battery: steps::of_voltage(battery),
            endurance: (endurance != NONE)
                .then(|| Duration::from_micros(u64::from(endurance) * ENDURANCE_STEP)),
            front: of_neighbour([f0, f1])?,
            back: of_neighbour([b0, b1])?,
            odometer: Metres(f32::from(i16::from_le_bytes([o0, o1])) / per::WAY),
            velocity: MetresPerSecond(f32::from(i8::from_le_bytes([velocity])) / per::VELOCITY),
            height: (height != NONE).then(|| Metres(f32::from(height) / per::HEIGHT)),
            heeded: u16::from_le_bytes([h0, h1]),
        })
    }
}

fn endurance(endurance: Duration) -> u8 {
    let steps = endurance.as_micros().saturating_add(ENDURANCE_STEP / 2) / ENDURANCE_STEP;
    steps.min(u64::from(NONE) - 1) as u8
}

/// The bytes of a neighbour and its link. A neighbour that cannot be named on the air is left out.
fn neighbour(neighbour: Option<(NodeId, Dbm)>) -> [u8; 2] {
    let named = neighbour.and_then(|(node, link)| Some((steps::name(node)?, link)));
    named.map_or([0, 0], |(name, link)| [THERE | name, steps::weakness(link)])
}

fn of_neighbour([who, link]: [u8; 2]) -> Result<Option<(NodeId, Dbm)>, Error> {
    match (who & THERE != 0, who & !THERE, link) {
        (true, name, link) => Ok(Some((steps::of_name(name)?, steps::of_weakness(link)))),
        (false, 0, 0) => Ok(None),
        (false, ..) => Err(Error::Reserved),
    }
}
