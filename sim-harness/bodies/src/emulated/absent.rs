//! The stand-in for emulated drones in a build without the feature `virtual`: there is none.
#![expect(missing_docs, reason = "the types that it stands for have the documentation")]

use std::convert::Infallible;
use std::fmt;
use std::path::Path;

use agent::{Exploration, Outputs};
use input::InputError;
use onboard::Fix;
use units::{Dbm, Metres, NodeId, Order};
use wire::p2p::Counter;

use crate::craft::{Craft, Surroundings};
use crate::without_emulator;
use scenario::Scenario;

/// An ELF, which cannot be run in this build.
pub enum Firmware {}

impl Firmware {
    /// The file that `cargo fw` makes, seen from the repository.
    pub const DEFAULT: &str = "target/thumbv7em-none-eabihf/firmware/uchain-firmware";

    pub fn open(_: &Path) -> Result<Self, InputError> {
        Err(without_emulator("the fidelity \"virtual\""))
    }

    pub fn with_radio(self, _: Option<&Path>) -> Result<Self, InputError> {
        match self {}
    }

    pub fn fleet(&self, _: &Scenario, _: u64) -> Result<Vec<Emulated>, InputError> {
        match *self {}
    }
}

/// The reason why a mission with emulated drones cannot go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Halted(Infallible);

impl fmt::Display for Halted {
    fn fmt(&self, _: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {}
    }
}

impl std::error::Error for Halted {}

/// One emulated drone.
pub struct Emulated(Infallible);

impl Emulated {
    pub fn node(&self) -> NodeId {
        match self.0 {}
    }

    pub fn run_until(&mut self, _: u64) -> Result<(), Halted> {
        match self.0 {}
    }

    pub fn take_sent(&mut self, _: impl FnMut(u64, Vec<u8>)) {
        match self.0 {}
    }

    pub fn hear(&mut self, _: u64, _: Dbm, _: &[u8]) {
        match self.0 {}
    }

    pub fn client(&mut self, _: u64, _: &[u8]) {
        match self.0 {}
    }

    pub fn locate(&mut self, _: u64, _: &Fix, _: Metres) {
        match self.0 {}
    }

    pub fn take_answers(&mut self, _: impl FnMut(&[u8])) {
        match self.0 {}
    }

    pub fn newly_heeded(&mut self) -> Option<Counter> {
        match self.0 {}
    }

    pub fn outputs(&self) -> Option<Outputs> {
        match self.0 {}
    }

    pub fn order(&self) -> Option<Order> {
        match self.0 {}
    }

    pub fn exploration(&self) -> Option<&Exploration> {
        match self.0 {}
    }

    pub fn fly(&mut self, _: &mut Craft, _: Surroundings<'_>) {
        match self.0 {}
    }
}
