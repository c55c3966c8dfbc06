//! Turns the code of a drone's state back into the state, for records that show its name.

use agent::{ChainDuty, Duty, LandReason, State, SwarmDuty};
use chain::search::{Place, Search};
use units::{Dbm, Instant, Metres};

/// The state with this code ([`State::code`]). The telemetry does not say since when the drone is in
/// it, or why: these are filled with zero and with an order. A code that no state has is read as
/// idle.
pub(super) fn of_code(code: u8) -> State {
    let since = Instant::ZERO;
    let chain = |duty| State::OnMission(Duty::Chain(duty));
    let swarm = |duty| State::OnMission(Duty::Swarm(duty));
    let why = LandReason::Ordered;
    let nowhere = Place { way: Metres(0.0), weaker: Dbm(0.0) };
    match code {
        1 => State::Armed { since },
        2 => State::TakingOff { since },
        3 => chain(ChainDuty::Leading { patient_until: since }),
        4 => chain(ChainDuty::Relaying { patient_until: since }),
        5 => chain(ChainDuty::Reconnecting { since, from: Metres(0.0) }),
        6 => chain(ChainDuty::BackingUp { since, from: Metres(0.0) }),
        7 => State::Landing { since, why },
        8 => State::Landed { why },
        9 => State::Stopped,
        10 => chain(ChainDuty::Searching { search: Search::begin(since, nowhere) }),
        11 => chain(ChainDuty::Retiring),
        12 => chain(ChainDuty::Rejoining { since, to: Metres(0.0), passed: None }),
        13 => State::Perched,
        14 => State::Rising { since },
        15 => swarm(SwarmDuty::Hovering { since }),
        16 => swarm(SwarmDuty::Surveying),
        17 => swarm(SwarmDuty::Gathering),
        18 => swarm(SwarmDuty::Crossing),
        24 => chain(ChainDuty::Homing),
        25 => swarm(SwarmDuty::Returning),
        _ => State::Idle,
    }
}
