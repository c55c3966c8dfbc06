//! The covariance of the nine errors: position, velocity and attitude, three each.
//!
//! All three are along the world's axes. With the velocity's error turned into the world together
//! with the attitude's, w = Exp(ξ)·(ŵ + ν) and R = Exp(ξ)·R̂ (the invariant error of Barrau and
//! Bonnabel, "The invariant extended Kalman filter as a stable observer", 2017), the propagation
//! holds nothing but the time, gravity and the velocity,
//!
//! ```text
//!     π' = π + dt·ν + dt·ξ×w        ν' = ν + dt·g·ξ×e_z        ξ' = ξ
//! ```
//!
//! and no measurement can seem to say anything of yaw, which none does. Of the 81 numbers the 45
//! of one triangle are kept, in blocks, so that the matrix is symmetric by construction.

use crate::attitude::{Vector, add, dot, scaled};

type Block = [Vector; 3];

/// A symmetric block.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Symmetric {
    xx: f32,
    xy: f32,
    xz: f32,
    yy: f32,
    yz: f32,
    zz: f32,
}

impl Symmetric {
    const fn diagonal([xx, yy, zz]: Vector) -> Self {
        let (xx, yy, zz) = (xx.max(LEAST), yy.max(LEAST), zz.max(LEAST));
        Self { xx, xy: 0.0, xz: 0.0, yy, yz: 0.0, zz }
    }

    const fn rows(&self) -> Block {
        [[self.xx, self.xy, self.xz], [self.xy, self.yy, self.yz], [self.xz, self.yz, self.zz]]
    }

    /// The upper triangle of a block that is symmetric but for rounding.
    const fn upper([[xx, xy, xz], [_, yy, yz], [_, _, zz]]: Block) -> Self {
        Self { xx, xy, xz, yy, yz, zz }
    }

    /// S − a·aᵀ·by.
    fn less(self, [x, y, z]: Vector, by: f32) -> Self {
        let [x_by, y_by, z_by] = scaled([x, y, z], by);
        Self {
            xx: self.xx - x * x_by,
            xy: self.xy - x * y_by,
            xz: self.xz - x * z_by,
            yy: self.yy - y * y_by,
            yz: self.yz - y * z_by,
            zz: self.zz - z * z_by,
        }
    }

    fn stretched(self, by: Vector) -> Self {
        Self::upper(stretched(self.rows(), by, by))
    }
}

/// The nine errors, or how something depends on them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Errors {
    pub(super) position: Vector,
    pub(super) velocity: Vector,
    pub(super) turn: Vector,
}

impl Errors {
    pub(super) const NONE: Self = Self { position: [0.0; 3], velocity: [0.0; 3], turn: [0.0; 3] };

    /// This and `other` as often as it is said.
    pub(super) fn plus(&self, other: &Self, times: f32) -> Self {
        let sum = |[ax, ay, az]: Vector, [bx, by, bz]: Vector| {
            [ax + times * bx, ay + times * by, az + times * bz]
        };
        Self {
            position: sum(self.position, other.position),
            velocity: sum(self.velocity, other.velocity),
            turn: sum(self.turn, other.turn),
        }
    }
}

/// How a measurement depends on the errors: its row of H. Nothing here measures x, y or yaw.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sight {
    pub(super) height: f32,
    pub(super) velocity: Vector,
    pub(super) tilt: [f32; 2],
}

impl Sight {
    /// H·e.
    pub(super) fn of(&self, errors: &Errors) -> f32 {
        let [_, _, z] = errors.position;
        let [x, y, _] = errors.turn;
        let [tilt_x, tilt_y] = self.tilt;
        self.height * z + dot(self.velocity, errors.velocity) + tilt_x * x + tilt_y * y
    }
}

/// What one millisecond adds to the variances: of the horizontal and the vertical velocity, and of
/// tilt and yaw.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Growth {
    pub(super) velocity: f32,
    pub(super) climb: f32,
    pub(super) tilt: f32,
    pub(super) yaw: f32,
}

/// P. `pv` holds E[π·νᵀ], and so on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Covariance {
    pp: Symmetric,
    pv: Block,
    pt: Block,
    vv: Symmetric,
    vt: Block,
    tt: Symmetric,
}

/// No variance is less: 0.1 mm, 0.1 mm/s, 0.1 mrad. Below that, rounding decides.
const LEAST: f32 = 1e-8;
/// No variance is more: at more than a hundred million times the variance of a measurement, `f32`
/// would lose the measurement. Position, velocity, attitude.
const MOST: [f32; 9] = [1e4, 1e4, 4.0, 25.0, 25.0, 25.0, 0.25, 0.25, 10.0];

impl Covariance {
    /// Independent errors of these variances, but not of less than [`LEAST`].
    pub(super) const fn diagonal(position: Vector, velocity: Vector, turn: Vector) -> Self {
        Self {
            pp: Symmetric::diagonal(position),
            pv: [[0.0; 3]; 3],
            pt: [[0.0; 3]; 3],
            vv: Symmetric::diagonal(velocity),
            vt: [[0.0; 3]; 3],
            tt: Symmetric::diagonal(turn),
        }
    }

    /// F·P·Fᵀ + Q, block by block. What drag does to the errors, 2·10⁻⁴ of them in a step of 1 ms,
    /// is left out.
    pub(super) fn propagate(&mut self, velocity: Vector, gravity: f32, dt: f32, growth: &Growth) {
        let way = scaled(velocity, dt);
        let lean = gravity * dt;
        let Self { pp, pv, pt, vv, vt, tt } = *self;
        let (vv, tt) = (vv.rows(), tt.rows());

        let pt_after = sum(pt, sum(times(vt, dt), swung(tt, way)));
        let pv_half = sum(pv, sum(times(vv, dt), swung(transposed(vt), way)));
        let pp_half = sum(pp.rows(), sum(times(transposed(pv), dt), swung(transposed(pt), way)));
        let vt_after = sum(vt, transposed(leant(tt, lean)));
        let vv_half = sum(vv, transposed(leant(vt, lean)));
        let pt_swung = transposed(swung(transposed(pt_after), way));

        self.pp = Symmetric::upper(sum(pp_half, sum(times(pv_half, dt), pt_swung)));
        self.pv = sum(pv_half, leant(pt_after, lean));
        self.pt = pt_after;
        self.vv = Symmetric::upper(sum(vv_half, leant(vt_after, lean)));
        self.vt = vt_after;
        self.grow(growth);
        self.bound();
    }

    fn grow(&mut self, growth: &Growth) {
        self.vv.xx += growth.velocity;
        self.vv.yy += growth.velocity;
        self.vv.zz += growth.climb;
        self.tt.xx += growth.tilt;
        self.tt.yy += growth.tilt;
        self.tt.zz += growth.yaw;
    }

    /// P·Hᵀ.
    pub(super) fn seen_by(&self, sight: &Sight) -> Errors {
        let Sight { height, velocity, tilt: [x, y] } = *sight;
        let Self { pp, pv, pt, vv, vt, tt } = self;
        let [pv_x, pv_y, pv_z] = *pv;
        let by_height = |[_, _, z]: Vector| z * height;
        let by_tilt = |[tx, ty, _]: Vector| tx * x + ty * y;
        let [pt_x, pt_y, pt_z] = *pt;
        let [vt_x, vt_y, vt_z] = *vt;
        let [pp_x, pp_y, pp_z] = pp.rows();
        let [vv_x, vv_y, vv_z] = vv.rows();
        let [tt_x, tt_y, tt_z] = tt.rows();
        let [vp_x, vp_y, vp_z] = transposed(*pv);
        let [tp_x, tp_y, tp_z] = transposed(*pt);
        let [tv_x, tv_y, tv_z] = transposed(*vt);
        Errors {
            position: [
                by_height(pp_x) + dot(pv_x, velocity) + by_tilt(pt_x),
                by_height(pp_y) + dot(pv_y, velocity) + by_tilt(pt_y),
                by_height(pp_z) + dot(pv_z, velocity) + by_tilt(pt_z),
            ],
            velocity: [
                by_height(vp_x) + dot(vv_x, velocity) + by_tilt(vt_x),
                by_height(vp_y) + dot(vv_y, velocity) + by_tilt(vt_y),
                by_height(vp_z) + dot(vv_z, velocity) + by_tilt(vt_z),
            ],
            turn: [
                by_height(tp_x) + dot(tv_x, velocity) + by_tilt(tt_x),
                by_height(tp_y) + dot(tv_y, velocity) + by_tilt(tt_y),
                by_height(tp_z) + dot(tv_z, velocity) + by_tilt(tt_z),
            ],
        }
    }

    /// P − c·cᵀ/s: what a measurement leaves, with c = P·Hᵀ and s the variance of its innovation.
    pub(super) fn know(&mut self, seen: &Errors, variance: f32) {
        let by = 1.0 / variance;
        let Errors { position, velocity, turn } = *seen;
        self.pp = self.pp.less(position, by);
        self.pv = less(self.pv, scaled(position, by), velocity);
        self.pt = less(self.pt, scaled(position, by), turn);
        self.vv = self.vv.less(velocity, by);
        self.vt = less(self.vt, scaled(velocity, by), turn);
        self.tt = self.tt.less(turn, by);
        self.bound();
    }

    /// The height and the velocity are these again, and nothing ties them to the rest.
    pub(super) fn stand(&mut self, height: f32, velocity: f32, tilt: f32) {
        let [x, y, _] = self.pt;
        let Symmetric { xx, xy, yy, .. } = self.pp;
        let [[_, _, x_yaw], [_, _, y_yaw]] = [x, y];
        let yaw = self.tt.zz;
        *self = Self::diagonal([xx, yy, height], [velocity; 3], [tilt, tilt, yaw]);
        self.pp.xy = xy;
        self.pt = [[0.0, 0.0, x_yaw], [0.0, 0.0, y_yaw], [0.0; 3]];
        self.bound();
    }

    /// The height may be off by so much more, as a variance.
    pub(super) fn doubt_height(&mut self, variance: f32) {
        self.pp.zz += variance;
        self.bound();
    }

    /// The velocity over ground may be off by so much more, as a variance.
    pub(super) fn doubt_velocity(&mut self, variance: f32) {
        self.vv.xx += variance;
        self.vv.yy += variance;
        self.bound();
    }

    /// The variances, in the order of [`Covariance::dense`].
    pub(super) const fn variances(&self) -> [f32; 9] {
        let Self { pp, vv, tt, .. } = self;
        [pp.xx, pp.yy, pp.zz, vv.xx, vv.yy, vv.zz, tt.xx, tt.yy, tt.zz]
    }

    /// The variance of the velocity along a direction.
    pub(super) fn velocity_along(&self, [x, y, z]: Vector) -> f32 {
        let Symmetric { xx, xy, xz, yy, yz, zz } = self.vv;
        let mixed = x * y * xy + x * z * xz + y * z * yz;
        x * x * xx + y * y * yy + z * z * zz + 2.0 * mixed
    }

    /// All 81 of them: position, velocity, attitude.
    pub(super) fn dense(&self) -> [[f32; 9]; 9] {
        let row =
            |[a, b, c]: Vector, [d, e, f]: Vector, [g, h, i]: Vector| [a, b, c, d, e, f, g, h, i];
        let (vp, tp, tv) = (transposed(self.pv), transposed(self.pt), transposed(self.vt));
        let band = |[ax, ay, az]: Block, [bx, by, bz]: Block, [cx, cy, cz]: Block| {
            [row(ax, bx, cx), row(ay, by, cy), row(az, bz, cz)]
        };
        let [px, py, pz] = band(self.pp.rows(), self.pv, self.pt);
        let [vx, vy, vz] = band(vp, self.vv.rows(), self.vt);
        let [tx, ty, tz] = band(tp, tv, self.tt.rows());
        [px, py, pz, vx, vy, vz, tx, ty, tz]
    }

    /// Keeps each variance within [`LEAST`] and [`MOST`]. More on the diagonal keeps a matrix
    /// positive; what is too much is taken from the whole row and column, which does so too.
    fn bound(&mut self) {
        let variances = self.variances();
        if variances.iter().zip(MOST).all(|(is, most)| (LEAST..=most).contains(is)) {
            return;
        }
        let mut scale = [1.0; 9];
        for ((scale, is), most) in scale.iter_mut().zip(variances).zip(MOST) {
            if is > most {
                *scale = libm::sqrtf(most / is);
            }
        }
        let [px, py, pz, vx, vy, vz, tx, ty, tz] = scale;
        let (p, v, t) = ([px, py, pz], [vx, vy, vz], [tx, ty, tz]);
        self.pp = self.pp.stretched(p);
        self.pv = stretched(self.pv, p, v);
        self.pt = stretched(self.pt, p, t);
        self.vv = self.vv.stretched(v);
        self.vt = stretched(self.vt, v, t);
        self.tt = self.tt.stretched(t);
        for is in [&mut self.pp, &mut self.vv, &mut self.tt] {
            for variance in [&mut is.xx, &mut is.yy, &mut is.zz] {
                *variance = variance.max(LEAST);
            }
        }
    }
}

fn transposed([[xx, xy, xz], [yx, yy, yz], [zx, zy, zz]]: Block) -> Block {
    [[xx, yx, zx], [xy, yy, zy], [xz, yz, zz]]
}

fn sum([ax, ay, az]: Block, [bx, by, bz]: Block) -> Block {
    [add(ax, bx), add(ay, by), add(az, bz)]
}

fn times([x, y, z]: Block, by: f32) -> Block {
    [scaled(x, by), scaled(y, by), scaled(z, by)]
}

/// M − a·bᵀ.
fn less([mx, my, mz]: Block, [x, y, z]: Vector, b: Vector) -> Block {
    [add(mx, scaled(b, -x)), add(my, scaled(b, -y)), add(mz, scaled(b, -z))]
}

/// The rows and columns of M, scaled.
fn stretched([mx, my, mz]: Block, [x, y, z]: Vector, columns: Vector) -> Block {
    let row = |[a, b, c]: Vector, by: f32| {
        let [ca, cb, cc] = columns;
        [a * ca * by, b * cb * by, c * cc * by]
    };
    [row(mx, x), row(my, y), row(mz, z)]
}

/// W·M, where W·ξ = ξ×way.
fn swung([mx, my, mz]: Block, [x, y, z]: Vector) -> Block {
    let less = |a: Vector, by: f32, b: Vector, less: f32| add(scaled(a, by), scaled(b, -less));
    [less(my, z, mz, y), less(mz, x, mx, z), less(mx, y, my, x)]
}

/// M·Gᵀ, where G·ξ = lean·ξ×e_z.
fn leant([mx, my, mz]: Block, lean: f32) -> Block {
    let row = |[x, y, _]: Vector| [lean * y, -lean * x, 0.0];
    [row(mx), row(my), row(mz)]
}
