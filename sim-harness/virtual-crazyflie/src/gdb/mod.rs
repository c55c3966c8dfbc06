//! Serves GDB's remote protocol over TCP, for one machine.
//!
//! [`Debugger`] owns the machine and stands in for it: the simulator runs the debugger instead of
//! the machine to the next moment. While GDB has stopped the machine, that call does not return,
//! so that the time of the whole simulation stands still.
//!
//! | module | what it holds |
//! |---|---|
//! | `arch` | the registers, as GDB expects them described |
//! | `machine` | what a debugger needs of a machine |
//! | `stub` | GDB's requests, one by one |

mod arch;
mod machine;
mod stub;

use std::fmt;
use std::io;
use std::net::{SocketAddr, TcpListener, TcpStream};

use gdbstub::common::Signal;
use gdbstub::conn::ConnectionExt;
use gdbstub::stub::state_machine::GdbStubStateMachine;
use gdbstub::stub::{GdbStub, MultiThreadStopReason, SingleThreadStopReason};

use crate::log::{Log, LogLine};
use crate::machine::Pause;
use crate::soc::Nanos;

pub use arch::Register;
pub use machine::Debuggee;
use stub::{Resume, Stub};

/// The time that the machine runs between two polls of GDB.
const SLICE: Nanos = 1_000_000;
/// The instructions between two polls, when GDB steps.
const STEPS: usize = 20_000;

type State<M> = GdbStubStateMachine<'static, Stub<M>, TcpStream>;
type Reason = SingleThreadStopReason<u32>;

/// A machine that a GDB may take hold of.
pub struct Debugger<M: Debuggee> {
    stub: Stub<M>,
    listener: TcpListener,
    session: Option<State<M>>,
}

impl<M: Debuggee> fmt::Debug for Debugger<M> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Debugger")
            .field("listener", &self.listener)
            .field("attached", &self.is_attached())
            .finish_non_exhaustive()
    }
}

impl<M: Debuggee> Debugger<M> {
    /// Stands in for `machine` and waits for a GDB at `listener`. With a log, `monitor log` shows
    /// what is new in it.
    ///
    /// # Errors
    /// If the listener cannot be looked at without waiting.
    pub fn new(mut machine: M, listener: TcpListener, log: Option<Log>) -> io::Result<Self> {
        listener.set_nonblocking(true)?;
        machine.set_debugger(true);
        Ok(Self { stub: Stub::new(machine, log), listener, session: None })
    }

    /// The address for GDB's `target remote`.
    ///
    /// # Errors
    /// If the listener does not know.
    pub fn address(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }

    /// The machine.
    pub const fn machine(&self) -> &M {
        &self.stub.machine
    }

    /// The machine, to be given inputs between two runs.
    pub const fn machine_mut(&mut self) -> &mut M {
        &mut self.stub.machine
    }

    /// The machine, alone again, without breakpoints.
    #[must_use]
    pub fn into_machine(mut self) -> M {
        self.stub.forget_breakpoints();
        self.stub.machine.set_debugger(false);
        self.stub.machine
    }

    /// The log, without the lines that were taken.
    pub fn take_log(&mut self) -> Vec<LogLine> {
        self.stub.take_log()
    }

    /// Whether a GDB is connected.
    #[must_use]
    pub const fn is_attached(&self) -> bool {
        self.session.is_some()
    }

    /// Waits until a GDB is connected.
    ///
    /// # Errors
    /// If the connection fails.
    pub fn wait_for_gdb(&mut self) -> io::Result<()> {
        self.listener.set_nonblocking(false)?;
        let accepted = self.listener.accept();
        self.listener.set_nonblocking(true)?;
        self.begin(accepted?.0);
        Ok(())
    }

    /// Runs the machine up to a moment, as GDB allows: it does not return while GDB holds the
    /// machine. A GDB that connects holds it until it says `continue`.
    ///
    /// # Errors
    /// If the machine cannot go on and no GDB is connected to report it to.
    pub fn run_until(&mut self, moment: Nanos) -> Result<(), M::Halt> {
        if self.session.is_none()
            && let Ok((stream, _)) = self.listener.accept()
        {
            self.begin(stream);
        }
        self.attend(moment);
        self.stub.run_free(moment)
    }

    /// Does what GDB wants, until the moment has come or GDB is gone.
    fn attend(&mut self, moment: Nanos) {
        while let Some(session) = self.session.take() {
            match session {
                State::Running(running) if self.stub.machine.now() >= moment => {
                    self.session = Some(State::Running(running));
                    return;
                }
                session => self.session = self.advance(session, moment),
            }
        }
        self.stub.forget_breakpoints();
    }

    fn begin(&mut self, stream: TcpStream) {
        let state = GdbStub::new(stream).run_state_machine(&mut self.stub);
        self.session = state.ok();
    }

    /// One step of the session; nothing is left when it has ended, one way or another.
    fn advance(&mut self, session: State<M>, moment: Nanos) -> Option<State<M>> {
        let stub = &mut self.stub;
        let next = match session {
            State::Idle(mut idle) => {
                let byte = idle.borrow_conn().read().ok()?;
                idle.incoming_data(stub, byte)
            }
            State::Running(mut running) => match running.borrow_conn().peek().ok()? {
                Some(_) => {
                    let byte = running.borrow_conn().read().ok()?;
                    running.incoming_data(stub, byte)
                }
                None => match stub.run_slice(moment) {
                    None => return Some(State::Running(running)),
                    Some(reason) => running.report_stop(stub, reason),
                },
            },
            State::CtrlCInterrupt(interrupt) => {
                let reason = MultiThreadStopReason::Signal(Signal::SIGINT);
                interrupt.interrupt_handled(stub, Some(reason))
            }
            State::Disconnected(_) => return None,
        };
        next.ok()
    }
}

impl<M: Debuggee> Stub<M> {
    /// Runs up to a moment without a debugger connected.
    fn run_free(&mut self, moment: Nanos) -> Result<(), M::Halt> {
        while self.machine.now() < moment {
            if self.machine.advance_to(moment)? == Pause::Trap {
                self.machine.step(moment)?;
            }
        }
        self.drain_log();
        Ok(())
    }

    /// Runs for a little while, and not beyond the moment. Says why, if it stops for GDB.
    fn run_slice(&mut self, moment: Nanos) -> Option<Reason> {
        let stop = if self.resume == Resume::Step || !self.watches.is_empty() {
            self.run_by_steps(moment)
        } else {
            self.run_at_full_speed(moment)
        };
        self.drain_log();
        stop
    }

    fn run_at_full_speed(&mut self, moment: Nanos) -> Option<Reason> {
        let until = moment.min(self.machine.now().saturating_add(SLICE));
        // The first instruction may be the one with the breakpoint that it stopped at.
        let mut result =
            if self.fresh { self.machine.step(until) } else { self.machine.advance_to(until) };
        self.fresh = false;
        loop {
            match result {
                Ok(Pause::Trap) => match self.breakpoint_here() {
                    Some(reason) => return Some(reason),
                    None => result = self.machine.step(until),
                },
                Ok(Pause::Breakpoint) => return Some(Reason::Signal(Signal::SIGTRAP)),
                Ok(Pause::Until) if self.machine.now() >= until => return None,
                Ok(Pause::Until) => result = self.machine.advance_to(until),
                Err(halt) => return Some(self.halted(&halt)),
            }
        }
    }

    fn run_by_steps(&mut self, moment: Nanos) -> Option<Reason> {
        for _ in 0..STEPS {
            if self.machine.now() >= moment {
                return None;
            }
            let before = self.machine.register(Register::R(15));
            if !std::mem::take(&mut self.fresh)
                && let Some(reason) = self.breakpoint_here()
            {
                return Some(reason);
            }
            match self.machine.step(moment) {
                Ok(Pause::Breakpoint) => return Some(Reason::Signal(Signal::SIGTRAP)),
                Ok(Pause::Trap | Pause::Until) => {}
                Err(halt) => return Some(self.halted(&halt)),
            }
            if let Some(reason) = self.changed_watch() {
                return Some(reason);
            }
            let asleep =
                self.machine.register(Register::R(15)) == before && self.machine.now() >= moment;
            if self.resume == Resume::Step && !asleep {
                return Some(Reason::DoneStep);
            }
        }
        None
    }

    /// The machine cannot go on: GDB gets a signal, and the reason by `monitor why`.
    fn halted(&mut self, halt: &M::Halt) -> Reason {
        self.halt = Some(halt.to_string());
        Reason::Signal(Signal::SIGSEGV)
    }
}

/// Lets the first GDB that connects have the machine, until it goes away again or the moment has
/// come; returns the machine, as GDB has left it.
///
/// # Errors
/// If the port cannot be listened on.
pub fn serve<M: Debuggee>(
    machine: M,
    listener: TcpListener,
    log: Option<Log>,
    until: Nanos,
) -> io::Result<M> {
    let mut debugger = Debugger::new(machine, listener, log)?;
    debugger.wait_for_gdb()?;
    debugger.attend(until);
    Ok(debugger.into_machine())
}
