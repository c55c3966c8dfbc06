//! Vectors, unit quaternions and rotation matrices: an attitude is the rotation from the body's
//! axes to the world's.

/// A vector in body or world axes, as the name of the variable says.
pub(crate) type Vector = [f32; 3];

pub(crate) fn add([ax, ay, az]: Vector, [bx, by, bz]: Vector) -> Vector {
    [ax + bx, ay + by, az + bz]
}

pub(crate) fn scaled([x, y, z]: Vector, by: f32) -> Vector {
    [x * by, y * by, z * by]
}

pub(crate) fn dot([ax, ay, az]: Vector, [bx, by, bz]: Vector) -> f32 {
    ax * bx + ay * by + az * bz
}

pub(crate) fn cross([ax, ay, az]: Vector, [bx, by, bz]: Vector) -> Vector {
    [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx]
}

/// A rotation matrix, as columns: the body's axes in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rotation {
    /// The body's forward axis in the world.
    pub(crate) x: Vector,
    /// The body's left axis in the world.
    pub(crate) y: Vector,
    /// The body's up axis in the world.
    pub(crate) z: Vector,
}

impl Rotation {
    pub(crate) const IDENTITY: Self =
        Self { x: [1.0, 0.0, 0.0], y: [0.0, 1.0, 0.0], z: [0.0, 0.0, 1.0] };

    pub(crate) fn to_world(self, [x, y, z]: Vector) -> Vector {
        add(add(scaled(self.x, x), scaled(self.y, y)), scaled(self.z, z))
    }

    pub(crate) fn to_body(self, world: Vector) -> Vector {
        [dot(self.x, world), dot(self.y, world), dot(self.z, world)]
    }

    /// Roll, pitch and yaw, rad, to within 10⁻⁶ of what the matrix says. The pitch is an
    /// arctangent, since `libm`'s arcsine works in double precision and loses digits near a
    /// vertical nose.
    pub(crate) fn angles(&self) -> [f32; 3] {
        let Self { x: [xx, xy, xz], y: [_, _, yz], z: [_, _, zz] } = *self;
        let across = libm::sqrtf(xx * xx + xy * xy);
        [libm::atan2f(yz, zz), libm::atan2f(-xz, across), libm::atan2f(xy, xx)]
    }

    /// Cosine of the angle between the body's z and the vertical, R₂₂ of the matrix.
    pub(crate) const fn tilt_cosine(&self) -> f32 {
        let [_, _, cosine] = self.z;
        cosine
    }
}

/// An attitude as a quaternion, of length one up to rounding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Quaternion {
    pub(crate) w: f32,
    pub(crate) x: f32,
    pub(crate) y: f32,
    pub(crate) z: f32,
}

/// Sine and cosine of half an angle in ±π, from its sine and cosine. `libm`'s sine and cosine of an
/// `f32` work in double precision, so they are avoided.
fn half_angle(sin: f32, cos: f32) -> (f32, f32) {
    let half_sin = libm::sqrtf(0.5 * (1.0 - cos).max(0.0));
    (libm::copysignf(half_sin, sin), libm::sqrtf(0.5 * (1.0 + cos).max(0.0)))
}

impl Quaternion {
    pub(crate) const IDENTITY: Self = Self { w: 1.0, x: 0.0, y: 0.0, z: 0.0 };

    /// The attitude with zero yaw in which `up`, in body axes, is vertical; `None` if `up` is zero
    /// or not finite.
    pub(crate) fn from_vertical(up: Vector) -> Option<Self> {
        let [x, y, z] = up;
        let length = libm::sqrtf(dot(up, up));
        if !length.is_finite() || length <= 0.0 {
            return None;
        }
        let across = libm::sqrtf(y * y + z * z);
        let (sin_roll, cos_roll) =
            if across > 0.0 { half_angle(y / across, z / across) } else { (0.0, 1.0) };
        let (sin_pitch, cos_pitch) = half_angle(-x / length, across / length);
        Some(Self {
            w: cos_roll * cos_pitch,
            x: sin_roll * cos_pitch,
            y: cos_roll * sin_pitch,
            z: -sin_roll * sin_pitch,
        })
    }

    /// The level attitude whose x points along this horizontal vector; the identity if the vector
    /// is zero or not finite.
    pub(crate) fn from_heading([x, y]: [f32; 2]) -> Self {
        let length = libm::sqrtf(x * x + y * y);
        if !length.is_finite() || length <= 0.0 {
            return Self::IDENTITY;
        }
        let (z, w) = half_angle(y / length, x / length);
        Self { w, x: 0.0, y: 0.0, z }
    }

    /// The rotation by a rotation vector, whose direction is the axis and whose length the angle.
    /// Its length is one to the last bit for 0.1 rad and within 10⁻³ for 2 rad; it must be
    /// normalised.
    pub(crate) fn from_rotation_vector(turn: Vector) -> Self {
        let square = 0.25 * dot(turn, turn);
        let cosine = 1.0 - square * (0.5 - square * (1.0 / 24.0));
        let sine = 0.5 - square * (1.0 / 12.0 - square * (1.0 / 240.0));
        let [x, y, z] = scaled(turn, sine);
        Self { w: cosine, x, y, z }
    }

    /// The product of two rotations: `other` is applied first, then `self`.
    pub(crate) fn times(self, other: Self) -> Self {
        Self {
            w: self.w * other.w - self.x * other.x - self.y * other.y - self.z * other.z,
            x: self.w * other.x + self.x * other.w + self.y * other.z - self.z * other.y,
            y: self.w * other.y - self.x * other.z + self.y * other.w + self.z * other.x,
            z: self.w * other.z + self.x * other.y - self.y * other.x + self.z * other.w,
        }
    }

    fn norm_squared(self) -> f32 {
        self.w * self.w + self.x * self.x + self.y * self.y + self.z * self.z
    }

    fn scaled(self, by: f32) -> Self {
        Self { w: self.w * by, x: self.x * by, y: self.y * by, z: self.z * by }
    }

    /// The quaternion scaled to length one; the identity if its length is zero or not finite.
    pub(crate) fn normalised(self) -> Self {
        let square = self.norm_squared();
        if (square - 1.0).abs() < 1e-3 {
            // The usual case, once a millisecond: one Newton step, right to 4·10⁻⁷, instead of a
            // square root that `libm` computes in software.
            self.scaled(1.5 - 0.5 * square)
        } else if square > f32::MIN_POSITIVE && square.is_finite() {
            self.scaled(1.0 / libm::sqrtf(square))
        } else {
            Self::IDENTITY
        }
    }

    /// The rotation matrix of this quaternion.
    pub(crate) fn rotation(self) -> Rotation {
        let Self { w, x, y, z } = self;
        let (x2, y2, z2) = (x + x, y + y, z + z);
        let (wx, wy, wz) = (w * x2, w * y2, w * z2);
        let (xx, xy, xz) = (x * x2, x * y2, x * z2);
        let (yy, yz, zz) = (y * y2, y * z2, z * z2);
        Rotation {
            x: [1.0 - (yy + zz), xy + wz, xz - wy],
            y: [xy - wz, 1.0 - (xx + zz), yz + wx],
            z: [xz + wy, yz - wx, 1.0 - (xx + yy)],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(one: Vector, other: Vector, by: f32) -> bool {
        let off = add(one, scaled(other, -1.0));
        dot(off, off) < by * by
    }

    #[test]
    fn rotations_follow_the_right_hand_rule() {
        let quarter = core::f32::consts::FRAC_PI_2;
        let turned = |turn| Quaternion::from_rotation_vector(turn).normalised().rotation();
        assert!(near(turned([0.0, 0.0, quarter]).x, [0.0, 1.0, 0.0], 1e-3));
        // Positive roll raises the left side, positive pitch lowers the nose.
        assert!(near(turned([quarter, 0.0, 0.0]).y, [0.0, 0.0, 1.0], 1e-3));
        assert!(near(turned([0.0, quarter, 0.0]).x, [0.0, 0.0, -1.0], 1e-3));
        assert!(near(Quaternion::from_heading([0.0, 1.0]).rotation().x, [0.0, 1.0, 0.0], 1e-6));
    }

    #[test]
    fn the_second_factor_turns_first() {
        let quarter = core::f32::consts::FRAC_PI_2;
        let roll = Quaternion::from_rotation_vector([quarter, 0.0, 0.0]).normalised();
        let turned = Quaternion::from_heading([0.0, 1.0]).times(roll).rotation();
        assert!(near(turned.y, [0.0, 0.0, 1.0], 1e-3));
        assert!(near(turned.x, [0.0, 1.0, 0.0], 1e-3));
    }

    #[test]
    fn angles_are_those_of_the_matrix_in_double_precision() {
        for roll in -35..=35 {
            for pitch in -314..=314 {
                let (roll, pitch, yaw) = (0.09 * roll as f32, 0.005 * pitch as f32, 0.7);
                let about = |turn: Vector| {
                    let [x, y, z] = turn.map(|angle| libm::sinf(0.5 * angle));
                    let w = libm::cosf(0.5 * (turn[0] + turn[1] + turn[2]));
                    Quaternion { w, x, y, z }
                };
                let turn = about([0.0, 0.0, yaw])
                    .times(about([0.0, pitch, 0.0]))
                    .times(about([roll, 0.0, 0.0]));
                let rotation = turn.rotation();
                let found = rotation.angles().map(f64::from);
                let [xx, xy, xz] = rotation.x.map(f64::from);
                let expected = [
                    f64::from(rotation.y[2]).atan2(rotation.z[2].into()),
                    (-xz).atan2(xx.hypot(xy)),
                    xy.atan2(xx),
                ];
                for (found, expected) in found.into_iter().zip(expected) {
                    assert!((found - expected).abs() < 1e-6, "{roll} {pitch}: {found} {expected}");
                }
                let [_, found, _] = found;
                assert!((found - f64::from(pitch)).abs() < 1e-6, "{roll} {pitch}: {found}");
            }
        }
    }

    #[test]
    fn to_body_and_to_world_are_inverse() {
        let rotation = Quaternion::from_rotation_vector([0.3, -0.5, 0.9]).normalised().rotation();
        let there = [0.1, 2.0, -3.0];
        assert!(near(rotation.to_body(rotation.to_world(there)), there, 1e-5));
        assert!(near(cross(rotation.x, rotation.y), rotation.z, 1e-6));
    }

    #[test]
    fn the_vertical_determines_roll_and_pitch() {
        for turn in [[0.4, 0.0, 0.0], [0.0, -0.7, 0.0], [0.5, 0.6, 0.0], [2.0, 0.0, 0.0]] {
            let up = Quaternion::from_rotation_vector(turn)
                .normalised()
                .rotation()
                .to_body([0.0, 0.0, 1.0]);
            let found = Quaternion::from_vertical(scaled(up, 9.8)).unwrap().rotation();
            assert!(near(found.to_body([0.0, 0.0, 1.0]), up, 1e-5));
            let [_, aside, _] = found.x;
            assert!(aside.abs() < 1e-6, "yaw of {turn:?}");
        }
        assert_eq!(Quaternion::from_vertical([0.0; 3]), None);
        assert_eq!(Quaternion::from_vertical([f32::NAN, 0.0, 1.0]), None);
    }

    #[test]
    fn any_quaternion_can_be_normalised() {
        for w in [0.0, f32::MIN_POSITIVE, 1e-30, 1.0, 1e30, f32::INFINITY, f32::NAN] {
            let unit = Quaternion { w, x: 0.0, y: 0.0, z: 0.0 }.normalised();
            assert!((unit.norm_squared() - 1.0).abs() < 1e-6, "{w}");
        }
    }
}
