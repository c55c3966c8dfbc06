//! The rigid body: where it is, how it moves, and what pushes it.
//!
//! World axes are x east, y north, z up, the floor at zero; body axes are the board's, x forward,
//! y left, z up. Time moves in steps of a millisecond by the semi-implicit Euler rule, without a
//! sine: the attitude is a unit quaternion that is turned by a small rotation and set right by one
//! Newton step.

use flight::{Airframe, GRAVITY};

/// Three numbers along x, y and z.
pub type Vector = [f32; 3];
/// Rows of a rotation from body to world.
pub type Rotation = [Vector; 3];

/// Length of a step, s.
pub const STEP: f32 = 1e-3;

/// A machine's constants, ready for use in every step.
#[derive(Clone, Copy, Debug)]
pub struct BodySpec {
    inverse_mass: f32,
    inertia: Vector,
    inverse_inertia: Vector,
    arm: f32,
    torque_per_thrust: f32,
    /// The torque with all motors alike, per thrust of all together, m.
    twist: Vector,
}

/// Drag per speed of the air and per rotor speed, along x and y, and along z, N / (m/s · rad/s):
/// linear in both. Förster, "System Identification of the Crazyflie 2.0", ETH Zürich 2015.
const DRAG: [f32; 2] = [9.1785e-7, 10.311e-7];
/// Radius of a propeller, m (45 mm propellers; Förster 2015 measured 23.1 mm).
pub const PROPELLER_RADIUS: f32 = 0.0231;
/// The centre of mass above the feet, m (`physical_constants.c` of IDSC's fork of
/// crazyflie-firmware).
pub const STANDING: f32 = 0.02;
/// The propellers above the centre of mass, m: the motors' top edge.
pub(super) const PROPELLER_ABOVE: f32 = 0.008;

/// The points at which the body can touch the floor: four feet under the motors, and the
/// propellers' outer edges, for a body on its back.
const FEET: [Vector; 8] = {
    const F: f32 = 0.0325;
    const P: f32 = 0.048;
    [
        [F, -F, -STANDING],
        [-F, -F, -STANDING],
        [-F, F, -STANDING],
        [F, F, -STANDING],
        [P, -P, PROPELLER_ABOVE],
        [-P, -P, PROPELLER_ABOVE],
        [-P, P, PROPELLER_ABOVE],
        [P, P, PROPELLER_ABOVE],
    ]
};
/// No foot reaches lower than this below the centre of mass, m.
const FOOT_REACH: f32 = 0.07;
/// Stiffness of one foot, N/m: a body at rest sinks in by a millimetre. No source, like the next:
/// soft enough for steps of a millisecond, hard enough for a floor.
const STIFFNESS: f32 = 75.0;
/// Damping of one foot, N s/m: seven tenths of critical, so that a landing hardly bounces.
const DAMPING: f32 = 1.1;
/// Coefficient of friction, of plastic on concrete.
const FRICTION: f32 = 0.6;
/// Slower than this the friction grows with the speed, m/s.
const STICTION: f32 = 0.02;

impl BodySpec {
    /// The constants of this machine.
    #[must_use]
    pub fn of(airframe: &Airframe) -> Self {
        Self {
            inverse_mass: 1.0 / airframe.mass,
            inertia: airframe.inertia,
            inverse_inertia: airframe.inertia.map(|moment| 1.0 / moment),
            arm: airframe.arm,
            torque_per_thrust: airframe.torque_per_thrust,
            twist: [0.0; 3],
        }
    }

    /// These constants for a machine whose propellers twist it by `torque` N m at hover, as unequal
    /// ones do.
    #[must_use]
    pub fn twisted_by(self, torque: Vector) -> Self {
        Self { twist: torque.map(|part| part * self.inverse_mass / GRAVITY), ..self }
    }
}

/// The forces of one step: thrusts, rotor speeds, wind.
#[derive(Clone, Copy, Debug, Default)]
pub struct Drive {
    /// Thrust of each motor far from the floor, N.
    pub thrust: [f32; 4],
    /// All rotors' speeds together, rad/s.
    pub spin: f32,
    /// The air's own velocity, world axes, m/s.
    pub wind: Vector,
}

/// A rigid body.
#[derive(Clone, Debug)]
pub struct RigidBody {
    position: Vector,
    velocity: Vector,
    /// The attitude: w, x, y, z.
    attitude: [f32; 4],
    rates: Vector,
    rotation: Rotation,
    /// The angular velocity about the body's axes.
    velocity_body: Vector,
    specific_force: Vector,
    on_floor: bool,
}

impl RigidBody {
    /// A body at rest on its feet here, its x axis along the unit vector `heading`.
    #[must_use]
    pub fn standing(at: [f32; 2], heading: [f32; 2]) -> Self {
        // Half the angle from the whole: exact but where the heading is due west.
        let [c, s] = heading;
        let w = libm::sqrtf(((1.0 + c) * 0.5).max(0.0));
        let z = if w > 1e-3 { s / (2.0 * w) } else { 1.0 };
        let mut body = Self {
            position: [at[0], at[1], STANDING - 1e-3],
            velocity: [0.0; 3],
            attitude: [w, 0.0, 0.0, z],
            rates: [0.0; 3],
            rotation: [[0.0; 3]; 3],
            velocity_body: [0.0; 3],
            specific_force: [0.0, 0.0, GRAVITY],
            on_floor: true,
        };
        body.unite();
        body
    }

    /// The centre of mass, m.
    #[must_use]
    pub const fn position(&self) -> Vector {
        self.position
    }

    /// The height of the feet above the floor, m, as if the body were level.
    #[must_use]
    pub const fn height(&self) -> f32 {
        self.position[2] - STANDING
    }

    /// The velocity, world axes, m/s.
    #[must_use]
    pub const fn velocity(&self) -> Vector {
        self.velocity
    }

    /// The velocity, body axes, m/s.
    #[must_use]
    pub const fn velocity_body(&self) -> Vector {
        self.velocity_body
    }

    /// The velocity over ground, along the level direction in which the body's x axis points, and
    /// to the left of it, m/s.
    #[must_use]
    pub fn velocity_ahead(&self) -> [f32; 2] {
        let [x, y] = [self.rotation[0][0], self.rotation[1][0]];
        let length = libm::sqrtf(x * x + y * y).max(1e-6);
        let (c, s) = (x / length, y / length);
        let [u, v, _] = self.velocity;
        [c * u + s * v, c * v - s * u]
    }

    /// The angular velocity, body axes, rad/s.
    #[must_use]
    pub const fn rates(&self) -> Vector {
        self.rates
    }

    /// The rotation from body to world.
    #[must_use]
    pub const fn rotation(&self) -> &Rotation {
        &self.rotation
    }

    /// The attitude: w, x, y, z.
    #[must_use]
    pub const fn attitude(&self) -> [f32; 4] {
        self.attitude
    }

    /// Cosine of the angle between the body's z axis and the vertical.
    #[must_use]
    pub const fn uprightness(&self) -> f32 {
        self.rotation[2][2]
    }

    /// The specific force, as an accelerometer in the middle measures it, body axes, m/s².
    #[must_use]
    pub const fn specific_force(&self) -> Vector {
        self.specific_force
    }

    /// Whether any part of it touches the floor.
    #[must_use]
    pub const fn is_on_floor(&self) -> bool {
        self.on_floor
    }

    /// Sets the body's velocity and rates: for tests and studies that begin in mid-air.
    pub fn launch(&mut self, position: Vector, velocity: Vector, rates: Vector) {
        (self.position, self.velocity, self.rates) = (position, velocity, rates);
        self.on_floor = false;
        self.unite();
    }

    /// Lets a wall stop the body: puts it at this place of the floor plan and takes the part of its
    /// velocity that leads into the wall.
    pub fn stop_at(&mut self, place: [f32; 2]) {
        let away = [place[0] - self.position[0], place[1] - self.position[1]];
        let length2 = away[0] * away[0] + away[1] * away[1];
        if length2 > 0.0 {
            let into = (self.velocity[0] * away[0] + self.velocity[1] * away[1]).min(0.0) / length2;
            let stopped = [-into * away[0], -into * away[1]];
            self.velocity[0] += stopped[0];
            self.velocity[1] += stopped[1];
            // The accelerometer feels it like any other force.
            let knock = [stopped[0] / STEP, stopped[1] / STEP, 0.0];
            let felt = turned_back(&self.rotation, knock);
            for (force, felt) in self.specific_force.iter_mut().zip(felt) {
                *force += felt;
            }
        }
        (self.position[0], self.position[1]) = (place[0], place[1]);
    }

    /// One millisecond.
    pub fn advance(&mut self, spec: &BodySpec, drive: &Drive) {
        let (mut force, mut torque) = self.air(spec, drive);
        self.on_floor = false;
        if self.position[2] < FOOT_REACH {
            self.floor(&mut force, &mut torque);
        }

        let scale = spec.inverse_mass;
        self.specific_force = [force[0] * scale, force[1] * scale, force[2] * scale];
        let pushed = turned(&self.rotation, self.specific_force);
        self.velocity[0] += pushed[0] * STEP;
        self.velocity[1] += pushed[1] * STEP;
        self.velocity[2] += (pushed[2] - GRAVITY) * STEP;

        let [p, q, r] = self.rates;
        let [jx, jy, jz] = spec.inertia;
        // Euler's equations in principal axes.
        let twist = [
            torque[0] - (jz - jy) * q * r,
            torque[1] - (jx - jz) * r * p,
            torque[2] - (jy - jx) * p * q,
        ];
        for ((rate, twist), ease) in self.rates.iter_mut().zip(twist).zip(spec.inverse_inertia) {
            *rate += twist * ease * STEP;
        }
        for (place, speed) in self.position.iter_mut().zip(self.velocity) {
            *place += speed * STEP;
        }
        self.turn();
        self.unite();
    }

    /// Force and torque of the propellers in the air, body axes.
    #[inline]
    fn air(&self, spec: &BodySpec, drive: &Drive) -> (Vector, Vector) {
        let [t1, t2, t3, t4] = drive.thrust;
        let lift = (t1 + t2 + t3 + t4) * self.ground_effect();
        // The velocity of the air, in body axes.
        let wind = turned_back(&self.rotation, drive.wind);
        let [u, v, w] = self.velocity_body;
        let (across, along) = (DRAG[0] * drive.spin, DRAG[1] * drive.spin);
        let force =
            [-across * (u - wind[0]), -across * (v - wind[1]), lift - along * (w - wind[2])];
        // A rotor at the end of its arm moves through the air when the body turns.
        let (tip, round) = (along * spec.arm * spec.arm, 2.0 * across * spec.arm * spec.arm);
        let [p, q, r] = self.rates;
        let [twist_x, twist_y, twist_z] = spec.twist;
        let torque = [
            spec.arm * (t3 + t4 - t1 - t2) + twist_x * lift - tip * p,
            spec.arm * (t2 + t3 - t1 - t4) + twist_y * lift - tip * q,
            spec.torque_per_thrust * (t2 + t4 - t1 - t3) + twist_z * lift - round * r,
        ];
        (force, torque)
    }

    /// The factor by which a propeller lifts more near the floor: Cheeseman and Bennett, "The
    /// Effect of the Ground on a Helicopter Rotor in Forward Flight", ARC R&M 3021, 1955.
    #[inline]
    fn ground_effect(&self) -> f32 {
        let above = self.position[2] + PROPELLER_ABOVE;
        // Standing, the propellers are 27 mm up; no nearer than a radius the law holds.
        let ratio = PROPELLER_RADIUS / (4.0 * above.max(PROPELLER_RADIUS));
        // 1/(1 - x²) to second order: x² is below a sixteenth.
        let square = ratio * ratio;
        1.0 + square * (1.0 + square)
    }

    /// The forces of the floor on every part of the body that sinks into it.
    fn floor(&mut self, force: &mut Vector, torque: &mut Vector) {
        for foot in FEET {
            let down = turned(&self.rotation, foot);
            let depth = -(self.position[2] + down[2]);
            if depth <= 0.0 {
                continue;
            }
            self.on_floor = true;
            let moving = turned(&self.rotation, cross(self.rates, foot));
            let [u, v, w] = self.velocity;
            let slip = [u + moving[0], v + moving[1], w + moving[2]];
            let push = (STIFFNESS * depth - DAMPING * slip[2]).max(0.0);
            let speed = libm::sqrtf(slip[0] * slip[0] + slip[1] * slip[1]).max(STICTION);
            let hold = -FRICTION * push / speed;
            let part = turned_back(&self.rotation, [hold * slip[0], hold * slip[1], push]);
            let lever = cross(foot, part);
            for axis in 0..3 {
                force[axis] += part[axis];
                torque[axis] += lever[axis];
            }
        }
    }

    /// Turns the attitude by the rates. The rotation of a step is taken to second order, and its
    /// length set right by one Newton step towards one.
    #[inline]
    fn turn(&mut self) {
        let [p, q, r] = self.rates;
        let [x, y, z] = [0.5 * STEP * p, 0.5 * STEP * q, 0.5 * STEP * r];
        let w = 1.0 - 0.5 * (x * x + y * y + z * z);
        let [a, b, c, d] = self.attitude;
        let q = [
            a * w - b * x - c * y - d * z,
            a * x + b * w + c * z - d * y,
            a * y - b * z + c * w + d * x,
            a * z + b * y - c * x + d * w,
        ];
        let length2 = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
        let scale = 1.5 - 0.5 * length2;
        self.attitude = [q[0] * scale, q[1] * scale, q[2] * scale, q[3] * scale];
    }

    /// Updates the values that follow from position, attitude and velocity.
    #[inline]
    fn unite(&mut self) {
        let [w, x, y, z] = self.attitude;
        self.rotation = [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ];
        self.velocity_body = turned_back(&self.rotation, self.velocity);
    }
}

/// Rotates from body to world.
#[inline]
#[must_use]
pub fn turned(by: &Rotation, v: Vector) -> Vector {
    [dot(by[0], v), dot(by[1], v), dot(by[2], v)]
}

/// Rotates from world to body.
#[inline]
#[must_use]
pub fn turned_back(by: &Rotation, v: Vector) -> Vector {
    let [a, b, c] = by;
    [
        a[0] * v[0] + b[0] * v[1] + c[0] * v[2],
        a[1] * v[0] + b[1] * v[1] + c[1] * v[2],
        a[2] * v[0] + b[2] * v[1] + c[2] * v[2],
    ]
}

#[inline]
fn dot(a: Vector, b: Vector) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline]
fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
