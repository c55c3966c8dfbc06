//! Sends requests to a chip and receives its answers, one at a time.

use std::fmt;

use input::InputError;
use onboard::replay::{Answer, Begin, FrameError, Receiver, Refusal, Request, Step, VERSION};
use units::{Duration, Instant};

use super::target::{BUILD, Lost, Target};

/// The chip runs for so long between two looks at its channels.
const SLICE: Duration = Duration::from_micros(250);
/// An answer takes a few milliseconds: the firmware looks at its channel every millisecond, and
/// before a replay every 50.
const PATIENCE: Duration = Duration::from_secs(2);
/// The firmware has read its settings within 2 s of a reset.
const BOOT: Duration = Duration::from_secs(5);
/// The pause before a firmware that has not booted is asked again.
const PAUSE: Duration = Duration::from_millis(50);

/// Why a replay ended early.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Error {
    /// The log, the firmware or the probe cannot be used.
    Input(InputError),
    /// The chip went away, or answered what no firmware answers.
    Lost(String),
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Input(error) => error.fmt(f),
            Self::Lost(what) => f.write_str(what),
        }
    }
}

impl std::error::Error for Error {}

impl From<InputError> for Error {
    fn from(error: InputError) -> Self {
        Self::Input(error)
    }
}

impl From<Lost> for Error {
    fn from(lost: Lost) -> Self {
        Self::Lost(format!("the chip was lost in the middle of the replay: {lost}"))
    }
}

/// An answer with the number of its request, or the version of a frame of another version.
type Came = Result<(u32, Answer), u8>;

/// The line to a chip.
pub struct Link<T> {
    target: T,
    receiver: Receiver,
    number: u32,
}

impl<T: Target> Link<T> {
    /// A line to this chip. A frame that the host before has left half sent is ended.
    ///
    /// # Errors
    /// When the chip cannot be reached.
    pub fn new(target: T) -> Result<Self, Error> {
        let mut link = Self { target, receiver: Receiver::new(), number: 0 };
        link.send(&[0])?;
        link.wait_until(link.now() + PAUSE)?;
        link.target.read()?;
        Ok(link)
    }

    /// The time by the chip's clock.
    pub fn now(&self) -> Instant {
        self.target.now()
    }

    /// Lets the chip run up to a moment of its clock.
    ///
    /// # Errors
    /// When the chip cannot be reached.
    pub fn wait_until(&mut self, moment: Instant) -> Result<(), Error> {
        while self.now() < moment {
            self.target.run(moment.since(self.now()))?;
        }
        Ok(())
    }

    /// The chip, for observation.
    pub const fn target_mut(&mut self) -> &mut T {
        &mut self.target
    }

    /// Begins a run. A firmware that has just booted is waited for.
    ///
    /// # Errors
    /// When the chip cannot be reached, or does not replay.
    pub fn begin(&mut self, begin: Begin) -> Result<Answer, Error> {
        let until = self.now() + BOOT;
        loop {
            match self.ask(&Request::Begin(begin))? {
                Answer::Refused(Refusal::NotReady) if self.now() < until => {
                    self.wait_until(self.now() + PAUSE)?;
                }
                Answer::Refused(why) => return Err(refused(why).into()),
                answer => return Ok(answer),
            }
        }
    }

    /// Runs a round.
    ///
    /// # Errors
    /// When the chip cannot be reached.
    pub fn step(&mut self, step: Step) -> Result<Answer, Error> {
        self.ask(&Request::Step(step))
    }

    /// Sends a request and waits for its answer.
    ///
    /// # Errors
    /// When the chip cannot be reached, or does not answer.
    pub fn ask(&mut self, request: &Request) -> Result<Answer, Error> {
        self.number += 1;
        let mut frame = Vec::new();
        request.send(self.number, |byte| frame.push(byte));
        let until = self.now() + PATIENCE;
        self.send(&frame)?;
        while self.now() < until {
            for byte in self.target.read()? {
                match self.receive(byte) {
                    Some(Ok((number, answer))) if number == self.number => return Ok(answer),
                    // A frame that could not be read has no number.
                    Some(Ok((0, Answer::Refused(why)))) => return Err(refused(why).into()),
                    Some(Err(theirs)) => return Err(other_version(theirs).into()),
                    Some(Ok(_)) | None => {}
                }
            }
            self.target.run(SLICE)?;
        }
        Err(self.silence())
    }

    fn send(&mut self, bytes: &[u8]) -> Result<(), Error> {
        let until = self.now() + PATIENCE;
        let mut rest = bytes;
        loop {
            let count = self.target.write(rest)?;
            rest = rest.get(count..).unwrap_or_default();
            if rest.is_empty() {
                return Ok(());
            }
            if self.now() >= until {
                return Err(self.silence());
            }
            self.target.run(SLICE)?;
        }
    }

    /// Takes a byte of the chip; what is damaged, or no answer, is passed over.
    fn receive(&mut self, byte: u8) -> Option<Came> {
        self.receiver.push(byte, |frame| match frame {
            Ok(frame) => Answer::parse(&frame).map(Ok),
            Err(FrameError::Version(theirs)) => Some(Err(theirs)),
            Err(FrameError::Damaged | FrameError::TooLong) => None,
        })?
    }

    /// The error for a chip that does not answer: before the first answer it has another firmware.
    fn silence(&self) -> Error {
        if self.number <= 1 {
            let wrong = "the firmware on the chip does not answer to a replay";
            return InputError::new(wrong, "flash the one that --elf names, and reset the chip")
                .into();
        }
        Error::Lost(format!("the chip did not answer to request {}", self.number))
    }

    /// The error for an answer that does not fit its request.
    pub(super) fn unexpected(&self, answer: &Answer) -> Error {
        match answer {
            Answer::Refused(why) => {
                Error::Lost(format!("the chip refused request {}: {why:?}", self.number))
            }
            other => Error::Lost(format!("the chip answered request {} by {other:?}", self.number)),
        }
    }
}

fn other_version(theirs: u8) -> InputError {
    let wrong =
        format!("the firmware replays by version {theirs} of the records, uchain by {VERSION}");
    InputError::new(wrong, BUILD)
}

/// The error for a chip that does not replay.
fn refused(why: Refusal) -> InputError {
    let (wrong, remedy) = match why {
        Refusal::Malformed => ("took the request for damaged", "try again, with a shorter cable"),
        Refusal::Version => ("has another version of the records", BUILD),
        Refusal::NotBegun => ("has been reset since the replay began", "try again"),
        Refusal::UnknownPolicy => ("does not know the policy", BUILD),
        Refusal::NoDebugger => ("sees no debugger", "attach a probe to the debug connector"),
        Refusal::Airborne => ("is not on the ground", "land it, and take its propellers off"),
        Refusal::NotIdle => ("is on a mission, or has landed from one", "switch it off and on"),
        Refusal::NotReady => ("has not read its settings in 5 s", "reset it, and look at its log"),
    };
    InputError::new(format!("the chip does not replay: it {wrong}"), remedy)
}
