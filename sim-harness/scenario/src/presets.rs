//! Radios by name, for benchmarks that fly the same missions through several.

use radio_model::{Attenuation, LogDistance, PathLoss, Subt, UChain, Walls, Waveguide};
use units::{Db, Metres};

use crate::RadioSpec;

/// A radio that a benchmark puts in place of a scenario's own.
#[derive(Clone, Copy, Debug)]
pub struct RadioPreset {
    /// The name.
    pub name: &'static str,
    /// One line of description.
    pub line: &'static str,
    change: fn(&mut RadioSpec),
}

impl RadioPreset {
    /// The preset of this name.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        PRESETS.iter().find(|preset| preset.name == name)
    }

    /// The scenario's radio with the preset's law and fields. What it says of packets, such as
    /// their loss, stays.
    #[must_use]
    pub fn applied(&self, radio: &RadioSpec) -> RadioSpec {
        let mut radio = radio.clone();
        (self.change)(&mut radio);
        radio
    }
}

const fn u_chain(attenuation: Attenuation) -> PathLoss {
    PathLoss::UChain(UChain { attenuation, walls: Walls::Rock, loss_at_1m: Db(40.0) })
}

/// All presets.
pub const PRESETS: [RadioPreset; 10] = [
    RadioPreset {
        name: "rock-depth",
        line: "equation (19), continuous",
        change: |radio| radio.place.path_loss = u_chain(Attenuation::RockDepth),
    },
    RadioPreset {
        name: "wall-count",
        line: "equation (19) as printed",
        change: |radio| radio.place.path_loss = u_chain(Attenuation::WallCount),
    },
    RadioPreset {
        name: "log-distance",
        line: "free space, 20 dB for each corner",
        change: |radio| radio.place.path_loss = PathLoss::LogDistance(LogDistance::DEFAULT),
    },
    RadioPreset {
        name: "waveguide",
        line: "a gallery of 2 m in concrete as a waveguide",
        change: |radio| radio.place.path_loss = PathLoss::Waveguide(Waveguide::DEFAULT),
    },
    RadioPreset {
        name: "subt",
        line: "the law of the SubT competition, 10 dB of noise",
        change: |radio| {
            radio.place.path_loss = PathLoss::Subt(Subt::DEFAULT);
            radio.reception.noise_variance = Subt::NOISE_VARIANCE;
        },
    },
    RadioPreset {
        name: "noisy",
        line: "the scenario's law, with the noise of recorded packets: 18 dB²",
        change: |radio| radio.reception.noise_variance = 18.0,
    },
    RadioPreset {
        name: "unequal",
        line: "the scenario's law, with each drone's gains off by 3 dB",
        change: |radio| radio.gain_error = Db(3.0),
    },
    RadioPreset {
        name: "shadowed",
        line: "the scenario's law, with shadowing of 3 dB over 2 m",
        change: |radio| radio.place.shadowing = Some((Db(3.0), Metres(2.0))),
    },
    RadioPreset {
        name: "rician",
        line: "the scenario's law, with Rician fading, K = 4",
        change: |radio| radio.place.fading_k = Some(4.0),
    },
    RadioPreset {
        name: "rayleigh",
        line: "the scenario's law, with Rayleigh fading",
        change: |radio| radio.place.fading_k = Some(0.0),
    },
];
