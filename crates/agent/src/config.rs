//! Everything about a drone's behaviour that can be chosen, in one `Copy` struct.

use core::fmt;

use crate::{ExploreConfig, SwarmConfig};
use chain::astray::AstrayConfig;
use chain::launch::LaunchConfig;
use chain::perching::PerchConfig;
use chain::policy::PolicyConfig;
use chain::retirement::RetirementConfig;
use chain::retreat::RetreatConfig;
use chain::search::SearchConfig;
use tunnel_nav::{NavConfig, SpotConfig};
use units::{Db, Dbm, Duration, Metres, MetresPerSecond};

/// The agent's constants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AgentConfig {
    /// Filter and movement policy.
    pub policy: PolicyConfig,
    /// The launch of a waiting relay.
    pub launch: LaunchConfig,
    /// The retreat towards the base, and the wait for a lost neighbour.
    pub retreat: RetreatConfig,
    /// The search for a better place where equal links are too weak; the policy `chain` alone searches.
    pub search: SearchConfig,
    /// The return of a relay that is no longer needed; under the policy `chain` alone it retires.
    pub retirement: RetirementConfig,
    /// The signs by which a relay notices that it took a wrong branch; without a pilot's choice it does
    /// not look for them.
    pub astray: AstrayConfig,
    /// The relaying from the ground.
    pub perch: PerchConfig,
    /// The search for a spot at which to land for that.
    pub spot: SpotConfig,
    /// Centring and wall following.
    pub nav: NavConfig,
    /// Heights, speeds and time limits of a flight.
    pub flight: FlightConfig,
    /// The plan of a swarm, and the rules by which it flies.
    pub swarm: SwarmConfig,
    /// The area that drones explore together, and how they fly there.
    pub explore: ExploreConfig,
}

impl AgentConfig {
    /// The constants that are flashed unless others are chosen.
    pub const DEFAULT: Self = Self {
        policy: PolicyConfig::CHAIN,
        launch: LaunchConfig::WHEN_SETTLED,
        retreat: RetreatConfig::DEFAULT,
        search: SearchConfig::DEFAULT,
        retirement: RetirementConfig::DEFAULT,
        astray: AstrayConfig::DEFAULT,
        perch: PerchConfig::DEFAULT,
        spot: SpotConfig::DEFAULT,
        nav: NavConfig::DEFAULT,
        flight: FlightConfig::DEFAULT,
        swarm: SwarmConfig::DEFAULT,
        explore: ExploreConfig::DEFAULT,
    };

    /// The same with other limits for links; `None` leaves one as it is.
    #[must_use]
    pub const fn with_limits(mut self, launch: Option<Dbm>, retreat: Option<Dbm>) -> Self {
        if let Some(limit) = launch {
            self.launch.limit = limit;
        }
        if let Some(limit) = retreat {
            self.retreat.limit = limit;
        }
        self
    }

    /// Whether the parts fit together. Each is sound by itself; what can go wrong is between them.
    ///
    /// # Errors
    /// [`ConfigError::LaunchBehindRetreat`].
    pub fn check(&self) -> Result<(), ConfigError> {
        if self.launch.limit - self.retreat.limit < ConfigError::LEAST_MARGIN {
            return Err(ConfigError::LaunchBehindRetreat);
        }
        Ok(())
    }
}

impl Default for AgentConfig {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// How a configuration can contradict itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ConfigError {
    /// The head would back up before its links become weak enough to call for the next relay:
    /// the chain could never grow. The launch limit must be at least
    /// [`LEAST_MARGIN`](Self::LEAST_MARGIN) stronger than the retreat limit.
    LaunchBehindRetreat,
}

impl ConfigError {
    /// The margin below which a noisy chain locks up, measured by simulation.
    pub const LEAST_MARGIN: Db = Db(1.0);
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::LaunchBehindRetreat => write!(
                f,
                "the launch limit must be at least {} stronger than the retreat limit, \
                 or the head backs up before a relay is called",
                Self::LEAST_MARGIN
            ),
        }
    }
}

impl core::error::Error for ConfigError {}

/// Heights, speeds and time limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlightConfig {
    /// Flying height. DEFAULT_HEIGHT of the authors' firmware.
    pub height: Metres,
    /// Rate of climb and descent. TAKE_OFF_VELOCITY of the authors' firmware.
    pub climb: MetresPerSecond,
    /// After reaching its height a drone settles for this long. Authors' firmware, 1 s.
    pub settle: Duration,
    /// A take-off or a landing that is not over after this long is given up.
    pub patience: Duration,
    /// The head stops when it has had no order for this long. Orders to the head are given 5
    /// times a second, and one packet in five is lost on each hop.
    pub pilot_timeout: Duration,
    /// Speed of the way home.
    pub return_speed: MetresPerSecond,
    /// A drone is home within this distance of where it took off.
    pub home: Metres,
    /// What is kept for the way home beside the time that it takes: waiting for those behind,
    /// and the landing.
    pub reserve: Duration,
    /// Whether a drone turns back, and calls the chain home, while its battery carries it home. Without
    /// it the drones fly until the flight code brings them down, for missions after which they are
    /// fetched.
    pub keeps_way_home: bool,
    /// A drone whose battery lasts for less is not launched: it would have to call the chain home
    /// soon after.
    pub least_endurance: Duration,
}

impl FlightConfig {
    /// The authors' heights and speeds; 1 s of patience with the pilot is five orders missed.
    pub const DEFAULT: Self = Self {
        height: Metres(0.3),
        climb: MetresPerSecond(0.2),
        settle: Duration::from_secs(1),
        patience: Duration::from_secs(10),
        pilot_timeout: Duration::from_secs(1),
        return_speed: MetresPerSecond(0.2),
        home: Metres(0.3),
        reserve: Duration::from_secs(20),
        keeps_way_home: true,
        least_endurance: Duration::from_secs(90),
    };

    /// The time for the way home beside the time that it takes: half as much again, for bends and for
    /// standing in a queue.
    const WAY_HOME: f32 = 1.5;

    /// The endurance in seconds below which a drone turns back whose way home takes `way`
    /// seconds.
    #[must_use]
    pub fn turns_back_below(&self, way: f32) -> f32 {
        Self::WAY_HOME * way + self.reserve.as_secs_f32()
    }

    /// The time of a take-off, s: that of the climb, and that for which a drone settles after it.
    #[must_use]
    pub fn rise_s(&self) -> f32 {
        self.height.0 / self.climb.0 + self.settle.as_secs_f32()
    }

    /// How far from home a drone turns back for its battery that takes off with an `endurance` in
    /// seconds, and flies away at `speed` without waiting.
    #[must_use]
    pub fn turns_back_at(&self, endurance: f32, speed: MetresPerSecond) -> Metres {
        let spare = endurance - self.rise_s() - self.turns_back_below(0.0);
        let a_metre = 1.0 / speed.0 + Self::WAY_HOME / self.return_speed.0;
        Metres((spare / a_metre).max(0.0))
    }

    /// The longest way home, in seconds, for which a battery suffices that lasts for `left`
    /// seconds; negative where it does not suffice for any.
    pub(crate) fn carried_home(&self, left: f32) -> f32 {
        (left - self.reserve.as_secs_f32()) / Self::WAY_HOME
    }

    /// Below this a drone stands on its legs: the down-looking ranger's smallest reading is 4 cm.
    pub(crate) const GROUND: Metres = Metres(0.05);

    /// Where the height set-point of a take-off begins (authors' firmware).
    const FIRST_HEIGHT: Metres = Metres(0.1);

    /// The height to hold `elapsed` after the beginning of a take-off.
    pub(crate) fn climbing(&self, elapsed: Duration) -> Metres {
        let ramp = Self::FIRST_HEIGHT + self.climb * elapsed;
        Metres(ramp.0.min(self.height.0))
    }

    /// The height to hold `elapsed` after the beginning of a landing.
    pub(crate) fn descending(&self, elapsed: Duration) -> Metres {
        let ramp = self.height - self.climb * elapsed;
        Metres(ramp.0.max(0.0))
    }

    /// Whether a drone is high enough for its side beams to see walls: a ranger's cone of 27°
    /// meets the floor 0.8 m off from 0.2 m up, two thirds of the flying height.
    pub(crate) fn sees_walls(&self, height: Option<Metres>) -> bool {
        height.is_some_and(|h| h.0 >= 0.66 * self.height.0)
    }

    /// Whether a drone that climbs has arrived: within a tenth of its height, which covers the
    /// ranger's noise.
    pub(crate) fn is_up(&self, height: Option<Metres>) -> bool {
        height.is_some_and(|h| h.0 >= 0.9 * self.height.0)
    }
}
