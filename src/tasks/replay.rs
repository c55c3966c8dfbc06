//! Replays recorded packets for a host at the other end of a debug probe.
//!
//! The host's requests come in through the down-channel of [`crate::rtt`], and the answers go out
//! through its up-channel; [`onboard::replay`] has their format and carries them out. The drone that
//! replays is the one and only drone of the firmware, so a replay begins only where it can do no harm:
//! with a debugger attached, on the ground, and before the mission has begun. From then on, until the
//! chip is reset, the motors are locked and no other task reaches the drone, so it sends no packet,
//! hears none and answers no client.

use cortex_m::peripheral::{DCB, DWT};
use embassy_time::{Duration, Timer};
use onboard::State;
use onboard::replay::{Answer, Receiver, Refusal, Request, Session, Stopwatch};

use crate::board::motors;
use crate::rtt;
use crate::tasks::control;
use crate::tasks::drone::Shared;
use crate::tasks::health::{self, Task};

/// The pause between two looks at the channel before a replay.
const IDLE: Duration = Duration::from_millis(50);
/// The pause between two looks at the channel during one.
const BUSY: Duration = Duration::from_millis(1);

/// The task.
#[embassy_executor::task]
pub(crate) async fn run(shared: &'static Shared) -> ! {
    let mut receiver = Receiver::new();
    let mut session = Session::new();
    loop {
        health::sign(Task::Replay);
        // One request at a time, and no more than the ring holds, however fast the host writes: other
        // tasks run in between.
        for _ in 0..rtt::REQUESTS {
            let Some(byte) = rtt::take_request() else { break };
            if receive(&mut receiver, byte, &mut session, shared) {
                break;
            }
        }
        Timer::after(if shared.replays() { BUSY } else { IDLE }).await;
    }
}

/// Takes a byte of a request, and answers the request at its end. Returns whether it has answered.
#[inline(never)]
fn receive(
    receiver: &mut Receiver,
    byte: u8,
    session: &mut Session,
    shared: &'static Shared,
) -> bool {
    let request = receiver.push(byte, Request::parse);
    let (number, answer) = match request {
        None => return false,
        // The number of what could not be read is not known.
        Some(Err(why)) => (0, Answer::Refused(why)),
        Some(Ok((number, request))) => (number, answer(session, &request, shared)),
    };
    answer.send(number, rtt::send_answer);
    true
}

fn answer(session: &mut Session, request: &Request, shared: &Shared) -> Answer {
    if let Request::Begin(begin) = request
        && let Err(why) = begin.policy().and_then(|_| reserve(shared))
    {
        defmt::warn!("a replay is refused: {}", why);
        return Answer::Refused(why);
    }
    let answer = shared.replay(|drone| session.answer(drone, request, &Cycles));
    answer.unwrap_or(Answer::Refused(Refusal::NotBegun))
}

/// Locks the motors and reserves the drone for the replay, if that is safe.
fn reserve(shared: &Shared) -> Result<(), Refusal> {
    if shared.replays() {
        return Ok(());
    }
    if !is_debugger_attached() {
        return Err(Refusal::NoDebugger);
    }
    if control::is_airborne() {
        return Err(Refusal::Airborne);
    }
    match shared.with(|drone| drone.state()) {
        None => return Err(Refusal::NotReady),
        Some(State::Idle) => {}
        Some(_) => return Err(Refusal::NotIdle),
    }
    motors::lock();
    shared.reserve_for_replay();
    defmt::warn!("a replay: the motors are locked, and the drone is silent, until the next reset");
    Ok(())
}

/// Whether a debugger is attached: DHCSR.C_DEBUGEN, which only a debugger sets (DDI 0403, C1.6.2).
#[expect(unsafe_code, reason = "reads a register")]
fn is_debugger_attached() -> bool {
    const C_DEBUGEN: u32 = 1;
    // SAFETY: to read the register changes the sticky bits S_RESET_ST and S_RETIRE_ST alone, which
    // nothing here uses. It is read as a word, since this bus knows no other width.
    let dhcsr = unsafe { (*DCB::PTR).dhcsr.read() };
    dhcsr & C_DEBUGEN != 0
}

/// The processor's cycles. Interrupts are disabled meanwhile, so that the round is not charged with
/// theirs; the control loop, whose motors are locked, waits for it.
struct Cycles;

impl Stopwatch for Cycles {
    fn time<R>(&self, round: impl FnOnce() -> R) -> (R, u32) {
        cortex_m::interrupt::free(|_| {
            let begin = DWT::cycle_count();
            let result = round();
            (result, DWT::cycle_count().wrapping_sub(begin))
        })
    }
}
