//! The stand-in for virtual drones in a build without the feature `virtual`: asking for them is
//! answered with the command that has them.

use std::convert::Infallible;

use input::InputError;
use serde_json::Value;

use super::VirtualArgs;
use bodies::emulated::Emulated;
use bodies::without_emulator;
use mission::Mission;
use report::Folder;
use scenario::Scenario;

/// Whether the base may be virtual.
pub(super) enum Base {
    OnHost,
    MayBeVirtual,
}

/// The virtual drones of a mission.
pub(super) struct Fleet(Infallible);

impl Fleet {
    pub(super) fn of(
        _: &VirtualArgs,
        _: Option<&str>,
        _: bool,
        _: &Scenario,
        _: Base,
    ) -> Result<Self, InputError> {
        Err(without_emulator("the fidelity \"virtual\""))
    }

    pub(super) fn drones(&self, _: &Scenario, _: u64) -> Result<Vec<Emulated>, InputError> {
        match self.0 {}
    }

    pub(super) fn say(&self, _: &mut Mission<'_>, _: impl FnMut(&str)) {
        match self.0 {}
    }
}

/// The table of the virtual drones, which is empty in this build.
pub(super) struct Aftermath;

impl Aftermath {
    pub(super) fn of(_: &Mission<'_>) -> Self {
        Self
    }

    pub(super) fn is_empty(&self) -> bool {
        true
    }

    pub(super) fn failures(&self) -> impl Iterator<Item = String> {
        std::iter::empty()
    }

    pub(super) fn table(&self) -> String {
        String::new()
    }

    pub(super) fn json(&self) -> Value {
        Value::Null
    }

    pub(super) fn write(&self, _: &mut Folder) -> Result<(), InputError> {
        Ok(())
    }
}

/// The vendor's firmware, which cannot be run in this build.
pub(super) mod stock {
    use std::convert::Infallible;
    use std::sync::atomic::AtomicBool;

    use units::Duration;

    use crate::cli::{Common, Trouble, Verdict, VirtualArgs};
    use bridge::Ports;
    use input::InputError;

    pub(in crate::cli) fn firmware(
        _: &VirtualArgs,
        _: bool,
    ) -> Result<Option<Infallible>, InputError> {
        Ok(None)
    }

    pub(in crate::cli) fn serve(
        firmware: &Infallible,
        _: &Common,
        _: Ports,
        _: (f64, Option<Duration>),
        _: &AtomicBool,
    ) -> Result<Verdict, Trouble> {
        match *firmware {}
    }
}

/// The replay on an emulated Crazyflie.
pub(super) mod replay {
    use std::path::{Path, PathBuf};

    use bodies::without_emulator;
    use replay::chip::{ChipOptions, ChipSummary, Error};

    pub(in crate::cli) fn run(
        _: &[PathBuf],
        _: &ChipOptions,
        _: Option<&Path>,
        _: impl FnMut(),
    ) -> Result<ChipSummary, Error> {
        Err(without_emulator("replay --on virtual").into())
    }
}
