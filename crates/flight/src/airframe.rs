//! The airframe: mass, inertia, and the thrust of its propellers at a voltage.
//!
//! Axes are the board's: x forward, y left, z up. Motors are numbered as on the Crazyflie, M1 to
//! M4: front right, rear right, rear left, front left, in an X. Seen from above, M1 and M3 turn
//! counter-clockwise and M2 and M4 clockwise; each twists the body against its own sense of
//! rotation.

/// The constants of an airframe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Airframe {
    /// Mass with battery and decks, kg.
    pub mass: f32,
    /// Moments of inertia about x, y and z, kg m².
    pub inertia: [f32; 3],
    /// The distance from the centre to a motor along x, which equals that along y, m.
    pub arm: f32,
    /// Coefficients of one motor's thrust in N over its voltage in V: c0 + c1·V + c2·V² + c3·V³.
    pub thrust_curve: [f32; 4],
    /// The torque of a motor about z per thrust, N m / N.
    pub torque_per_thrust: f32,
    /// The smallest thrust of one motor in the air, N.
    pub least_thrust: f32,
    /// The largest thrust of one motor, N.
    pub most_thrust: f32,
}

/// Standard gravity, m/s².
pub const GRAVITY: f32 = 9.806_65;

impl Airframe {
    /// A Crazyflie 2.1 with its first propellers, Flow deck v2 and Multi-ranger deck.
    ///
    /// Mass: 29 g with battery, and 1.6 g and 2.3 g of decks (product pages). Inertia: that of the
    /// bare airframe (crazyflie-firmware, `controller_lee.c`). Arm, thrust curve, torque and least
    /// thrust: `platform_defaults_cf2.h` (of 2025, where `THRUST2TORQUE` was measured for either set
    /// of propellers), with 0.046 m along the diagonal. Most thrust: a number of ours. That file has
    /// 0.12 N, so that an empty battery gives as much as a full one; the curve gives 0.18 N at 3.5 V.
    pub const CRAZYFLIE_2_1: Self = Self {
        mass: 0.0329,
        inertia: [16.571_71e-6, 16.655_602e-6, 29.261_652e-6],
        arm: 0.046 * core::f32::consts::FRAC_1_SQRT_2,
        thrust_curve: [-0.014_830_745, 0.047_244_653, -0.018_473_644, 0.005_960_924],
        torque_per_thrust: 0.007_350_86,
        least_thrust: 0.0128,
        most_thrust: 0.15,
    };

    /// A Crazyflie 2.1 with the propellers of the 2.1+.
    pub const CRAZYFLIE_2_1_PLUS: Self = Self {
        thrust_curve: [-0.024_765_38, 0.065_237_93, -0.026_792_505, 0.006_776_789],
        torque_per_thrust: 0.006_992_89,
        ..Self::CRAZYFLIE_2_1
    };

    /// The weight of the drone, N.
    #[must_use]
    pub const fn weight(&self) -> f32 {
        self.mass * GRAVITY
    }

    /// The thrust of one motor at hover, N.
    #[must_use]
    pub const fn hover_thrust(&self) -> f32 {
        self.weight() / 4.0
    }

    /// The thrust of one motor at this voltage, N, at least zero.
    #[must_use]
    pub const fn thrust_at(&self, volts: f32) -> f32 {
        let [c0, c1, c2, c3] = self.thrust_curve;
        (c0 + volts * (c1 + volts * (c2 + volts * c3))).max(0.0)
    }
}
