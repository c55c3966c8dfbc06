//! A point-level drone that flies as the navigator says.

use tunnel_nav::{Bearings, Diagonals, Guide, NavConfig, Navigator, Range};
use units::{Branch, Metres, MetresPerSecond, Radians};

use crate::world::{Place, Tunnel, Vec2, add, unit, wrapped};

/// The time of one round, s.
pub(crate) const ROUND: f32 = 0.2;
const STEPS: u32 = 10;
/// Half the drone's width with its guards, m.
const RADIUS: f32 = 0.08;

/// Random numbers: xorshift64*.
#[derive(Clone, Debug)]
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        let mut random = Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
        for _ in 0..8 {
            random.uniform();
        }
        random
    }

    /// Between 0 and 1.
    pub(crate) fn uniform(&mut self) -> f32 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 40) as f32 / (1u64 << 24) as f32
    }

    pub(crate) fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.uniform()
    }

    /// With mean 0 and standard deviation 1.
    pub(crate) fn normal(&mut self) -> f32 {
        (0..12).map(|_| self.uniform()).sum::<f32>() - 6.0
    }
}

/// The errors of a drone's sensors.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Errors {
    /// Standard deviation of a range, m.
    pub(crate) range: f32,
    /// The part of ranges that are missing.
    pub(crate) missing: f32,
    /// Standard deviation of a round's mean velocity, m/s.
    pub(crate) flow: f32,
    /// The velocity that the flow sensor sees at rest, m/s.
    pub(crate) bias: Vec2,
    /// The factor of the flow sensor.
    pub(crate) scale: f32,
    /// The drift of the gyro, rad/s.
    pub(crate) drift: f32,
    /// Standard deviation of a disturbance of the yaw rate, rad/s.
    pub(crate) yaw: f32,
}

impl Errors {
    /// The errors of an ordinary drone.
    pub(crate) fn ordinary(random: &mut Random) -> Self {
        Self {
            range: 0.02,
            missing: 0.03,
            flow: 0.02,
            bias: [0.003 * random.normal(), 0.003 * random.normal()],
            scale: 1.0 + 0.03 * random.normal(),
            drift: random.between(-5.0, 5.0).to_radians() / 60.0,
            yaw: 0.02,
        }
    }
}

/// A drone in a tunnel.
pub(crate) struct Flight<'a> {
    tunnel: &'a Tunnel,
    errors: Errors,
    random: Random,
    config: NavConfig,
    navigator: Navigator,
    at: Vec2,
    yaw: f32,
    velocity: Vec2,
    yaw_rate: f32,
    odometer: f32,
    aside: f32,
    gyro: f32,
    /// A lower bound of the distance to the nearest wall.
    clear: f32,
    touches: bool,
}

impl<'a> Flight<'a> {
    /// A drone that hovers at this way, along the tunnel.
    pub(crate) fn new(tunnel: &'a Tunnel, way: f32, errors: Errors, random: Random) -> Self {
        let (at, yaw) = tunnel.at(way);
        Self {
            tunnel,
            errors,
            random,
            config: NavConfig::DEFAULT,
            navigator: Navigator::new(),
            at,
            yaw,
            velocity: [0.0; 2],
            yaw_rate: 0.0,
            odometer: 0.0,
            aside: 0.0,
            gyro: 0.0,
            clear: 0.0,
            touches: false,
        }
    }

    /// The same drone with rangers that reach so far, m.
    #[allow(dead_code, reason = "not every test has another reach")]
    pub(crate) fn with_reach(mut self, reach: f32) -> Self {
        self.config.reach = Metres(reach);
        self
    }

    /// Tells the drone which branch to take.
    #[allow(dead_code, reason = "not every test has a junction")]
    pub(crate) fn choose(&mut self, branch: Option<Branch>) {
        self.navigator.guide(Guide { branch, ..Guide::NONE });
    }

    /// Tells the drone that from here on it is to take this branch, and not the one before.
    #[allow(dead_code, reason = "not every test changes its choice")]
    pub(crate) fn changes_to(&mut self, branch: Option<Branch>) {
        let changed_from = Some(Metres(self.odometer));
        self.navigator.guide(Guide { branch, changed_from, ..Guide::NONE });
        self.choose(branch);
    }

    /// Measures its way along another centre-line from here on.
    #[allow(dead_code, reason = "not every test has two ways")]
    pub(crate) fn moves_to(&mut self, tunnel: &'a Tunnel) {
        self.tunnel = tunnel;
    }

    /// Flies at this speed until it is there.
    ///
    /// # Errors
    /// What goes wrong before, and where it stands after three minutes.
    #[allow(dead_code, reason = "not every test flies so")]
    pub(crate) fn until(
        &mut self,
        speed: f32,
        when: &str,
        is_there: impl Fn(&Self) -> bool,
    ) -> Result<(), String> {
        for _ in 0..900 {
            if is_there(self) {
                return match self.off() > 0.7 * self.tunnel.width() {
                    true => Err(format!("is in another gallery {when}")),
                    false => Ok(()),
                };
            }
            self.round(speed);
            self.check(when)?;
        }
        let (way, length) = (self.way(), self.length());
        Err(format!("stands at {way:.1} of {length:.1} m {when}, {:.1} m beside", self.off()))
    }

    /// The distance from the centre-line.
    #[allow(dead_code, reason = "not every test asks for it")]
    pub(crate) fn off(&self) -> f32 {
        let on = self.tunnel.at(self.way()).0;
        libm::hypotf(self.at[0] - on[0], self.at[1] - on[1])
    }

    /// The place of the drone.
    fn place(&self) -> Place {
        self.tunnel.place(self.at)
    }

    /// The way from the mouth along the tunnel.
    pub(crate) fn way(&self) -> f32 {
        self.place().way
    }

    /// What the beams measure now, for a message.
    #[allow(dead_code, reason = "not every test says it")]
    pub(crate) fn beams(&mut self) -> String {
        let Diagonals { nw, ne, sw, se } = self.ranges();
        format!("{nw:?} {ne:?} {sw:?} {se:?}, nose {:.0}°", self.astray().to_degrees())
    }

    /// The length of the tunnel.
    pub(crate) fn length(&self) -> f32 {
        self.tunnel.length()
    }

    /// Whether all is well: no wall touched, and the nose towards the end of the tunnel.
    ///
    /// # Errors
    /// What is wrong.
    pub(crate) fn check(&self, when: &str) -> Result<(), String> {
        if self.touches {
            return Err(format!("touches a wall {when}"));
        }
        // Across the tunnel, and 10° for the noise: a drone turns by right angles.
        if self.astray().to_degrees() > 100.0 {
            return Err(format!("is reversed {when}"));
        }
        Ok(())
    }

    /// Whether all is well in a tunnel of several widths: no wall touched and, farther than this from any
    /// bend, the nose towards the end of the tunnel.
    ///
    /// # Errors
    /// What is wrong.
    #[allow(dead_code, reason = "not every test has several widths")]
    pub(crate) fn check_in_legs(&self, bend: f32, when: &str) -> Result<(), String> {
        let way = self.way();
        let is_in_bend = self.tunnel.bends().iter().any(|at| (way - at).abs() < bend);
        match self.check(when) {
            Err(_) if is_in_bend && !self.touches => Ok(()),
            result => result,
        }
    }

    /// Whether it has touched a wall.
    #[allow(dead_code, reason = "not every test asks for it")]
    pub(crate) const fn touches(&self) -> bool {
        self.touches
    }

    /// Where it is.
    #[allow(dead_code, reason = "not every test asks for it")]
    pub(crate) const fn at(&self) -> Vec2 {
        self.at
    }

    /// The angle between the nose and the tunnel's direction towards its end.
    fn astray(&self) -> f32 {
        wrapped(self.yaw - self.place().direction).abs()
    }

    /// Flies for one round at this speed along the tunnel.
    pub(crate) fn round(&mut self, speed: f32) {
        let ranges = self.ranges();
        let bearings = Bearings {
            way: Metres(self.odometer),
            aside: Metres(self.aside),
            heading: Some(Radians(wrapped(self.yaw + self.gyro))),
        };
        let command = self.navigator.step(&self.config, &ranges, MetresPerSecond(speed), &bearings);
        let mut moved = [0.0; 2];
        let yaw_error = self.errors.yaw * self.random.normal();
        for _ in 0..STEPS {
            let dt = ROUND / STEPS as f32;
            let wanted = [command.forward.0, command.lateral.0];
            for (axis, (is, wanted)) in self.velocity.iter_mut().zip(wanted).enumerate() {
                *is += (dt / 0.3) * (wanted - self.errors.bias[axis] - *is);
                moved[axis] += *is * dt;
            }
            self.yaw_rate += (dt / 0.1) * (command.yaw_rate.0 + yaw_error - self.yaw_rate);
            let ahead = unit(self.yaw);
            let to = add(self.at, ahead, self.velocity[0] * dt);
            let to = add(to, [-ahead[1], ahead[0]], self.velocity[1] * dt);
            // The clearance shrinks by no more than the way flown.
            self.clear -= libm::hypotf(self.velocity[0], self.velocity[1]) * dt;
            if self.clear < RADIUS + 0.01 {
                self.clear = self.tunnel.clearance(to);
            }
            self.touches |= self.clear < RADIUS;
            self.at = to;
            self.yaw += self.yaw_rate * dt;
        }
        self.odometer += self.errors.bias[0] * ROUND
            + moved[0] * self.errors.scale
            + ROUND * self.errors.flow * self.random.normal();
        self.aside += self.errors.bias[1] * ROUND
            + moved[1] * self.errors.scale
            + ROUND * self.errors.flow * self.random.normal();
        self.gyro += self.errors.drift * ROUND;
    }

    fn ranges(&mut self) -> Diagonals {
        let reach = self.config.reach;
        let mut beam = |degrees: f32| {
            if self.random.uniform() < self.errors.missing {
                return Range::Invalid;
            }
            let free = self.tunnel.cast(self.at, unit(self.yaw + degrees.to_radians()));
            let noisy = (free + self.errors.range * self.random.normal()).max(0.01);
            Range::measured(Metres(if free > reach.0 { free } else { noisy }), reach)
        };
        Diagonals { nw: beam(45.0), ne: beam(-45.0), sw: beam(135.0), se: beam(-135.0) }
    }
}
