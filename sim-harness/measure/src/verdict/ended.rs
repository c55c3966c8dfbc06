//! Says why the head's exploration ended.

/// Why the exploration of a head ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// By the pilot's order to stop, to return or to land, or at the end of a gallery.
    Pilot,
    /// By the radio: the head stood at the limit, no relay was left, and it was not yet where a
    /// chain of all relays ends.
    Radio,
    /// By a battery, which called the chain home.
    Battery,
    /// By a head that stood while relays were left and none was called.
    Stuck,
    /// By the number of relays: the head stood where even the best chain of all of them ends.
    TooFewRelays,
    /// By a fault that took the head away.
    Fault,
}

impl Ended {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::Pilot, Self::Radio, Self::Battery, Self::Stuck, Self::TooFewRelays, Self::Fault];

    /// The name in JSON.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Pilot => "pilot",
            Self::Radio => "radio",
            Self::Battery => "battery",
            Self::Stuck => "stuck",
            Self::TooFewRelays => "too-few-relays",
            Self::Fault => "fault",
        }
    }

    /// What it was, for the operator.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::Pilot => "by the pilot, or at the end of the gallery",
            Self::Radio => "by the radio, with no relay left",
            Self::Battery => "by a battery",
            Self::Stuck => "stuck, with relays left",
            Self::TooFewRelays => "with too few relays to go on",
            Self::Fault => "by a fault of the head",
        }
    }
}
