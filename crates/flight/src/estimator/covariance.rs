//! The covariance of the nine errors: position, velocity and attitude, three each.
//!
//! All errors are along the world's axes. The velocity's error is rotated together with the
//! attitude's, w = Exp(ξ)·(ŵ + ν) and R = Exp(ξ)·R̂ (the invariant error of Barrau and Bonnabel,
//! "The invariant extended Kalman filter as a stable observer", 2017). The propagation then depends
//! only on the time step, gravity and the velocity:
//!
//! ```text
//!     π' = π + dt·ν + dt·ξ×w        ν' = ν + dt·g·ξ×e_z        ξ' = ξ
//! ```
//!
//! No sensor measures yaw, and with these errors no linearised measurement changes its estimate
//! either. Of the 81 numbers of the matrix the 45 of one triangle are stored, in blocks, so it is
//! symmetric by construction.

use crate::attitude::{Vector, add, dot, scaled};

type Block = [Vector; 3];

/// A symmetric 3 × 3 block, stored as its upper triangle.
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
        let (xx, yy, zz) = (xx.max(MIN_VARIANCE), yy.max(MIN_VARIANCE), zz.max(MIN_VARIANCE));
        Self { xx, xy: 0.0, xz: 0.0, yy, yz: 0.0, zz }
    }

    const fn rows(&self) -> Block {
        [[self.xx, self.xy, self.xz], [self.xy, self.yy, self.yz], [self.xz, self.yz, self.zz]]
    }

    /// The upper triangle of a block that is symmetric up to rounding.
    const fn upper([[xx, xy, xz], [_, yy, yz], [_, _, zz]]: Block) -> Self {
        Self { xx, xy, xz, yy, yz, zz }
    }

    /// Returns S − a·aᵀ·by.
    fn minus_outer_product(self, [x, y, z]: Vector, by: f32) -> Self {
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

    fn rescaled(self, by: Vector) -> Self {
        Self::upper(rescaled(self.rows(), by, by))
    }
}

/// An error of position, velocity and attitude, or a column of the same nine components.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ErrorState {
    pub(super) position: Vector,
    pub(super) velocity: Vector,
    pub(super) turn: Vector,
}

impl ErrorState {
    pub(super) const NONE: Self = Self { position: [0.0; 3], velocity: [0.0; 3], turn: [0.0; 3] };

    /// Returns `self` + `times` · `other`.
    pub(super) fn plus_scaled(&self, other: &Self, times: f32) -> Self {
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

/// A row of the measurement matrix H. No measurement depends on x, y or yaw.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MeasurementRow {
    pub(super) height: f32,
    pub(super) velocity: Vector,
    pub(super) tilt: [f32; 2],
}

impl MeasurementRow {
    /// Returns H·e for the errors e.
    pub(super) fn times(&self, errors: &ErrorState) -> f32 {
        let [_, _, z] = errors.position;
        let [x, y, _] = errors.turn;
        let [tilt_x, tilt_y] = self.tilt;
        self.height * z + dot(self.velocity, errors.velocity) + tilt_x * x + tilt_y * y
    }
}

/// The variances that one step adds to the horizontal velocity, the climb rate, the tilt and the
/// yaw.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ProcessNoise {
    pub(super) velocity: f32,
    pub(super) climb: f32,
    pub(super) tilt: f32,
    pub(super) yaw: f32,
}

/// The covariance matrix P in blocks: `pv` is E[π·νᵀ], `t` stands for the attitude error ξ (turn).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Covariance {
    pp: Symmetric,
    pv: Block,
    pt: Block,
    vv: Symmetric,
    vt: Block,
    tt: Symmetric,
}

/// Lower bound of each variance: 0.1 mm, 0.1 mm/s, 0.1 mrad. Below it rounding errors dominate.
const MIN_VARIANCE: f32 = 1e-8;
/// Upper bound of each variance, for position, velocity and attitude. A prior of more than a
/// hundred million times a measurement's variance would lose the measurement in `f32`.
const MAX_VARIANCES: [f32; 9] = [1e4, 1e4, 4.0, 25.0, 25.0, 25.0, 0.25, 0.25, 10.0];

impl Covariance {
    /// A covariance of independent errors with these variances, each at least [`MIN_VARIANCE`].
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

    /// Replaces P by F·P·Fᵀ + Q, block by block. The effect of drag on the errors, 2·10⁻⁴ of them
    /// in a step of 1 ms, is neglected.
    pub(super) fn propagate(
        &mut self,
        velocity: Vector,
        gravity: f32,
        dt: f32,
        process_noise: &ProcessNoise,
    ) {
        let displacement = scaled(velocity, dt);
        let g_dt = gravity * dt;
        let Self { pp, pv, pt, vv, vt, tt } = *self;
        let (vv, tt) = (vv.rows(), tt.rows());

        let pt_after = sum(pt, sum(times(vt, dt), w_times(tt, displacement)));
        let pv_half = sum(pv, sum(times(vv, dt), w_times(transposed(vt), displacement)));
        let pp_half =
            sum(pp.rows(), sum(times(transposed(pv), dt), w_times(transposed(pt), displacement)));
        let vt_after = sum(vt, transposed(times_g_transpose(tt, g_dt)));
        let vv_half = sum(vv, transposed(times_g_transpose(vt, g_dt)));
        let pt_w = transposed(w_times(transposed(pt_after), displacement));

        self.pp = Symmetric::upper(sum(pp_half, sum(times(pv_half, dt), pt_w)));
        self.pv = sum(pv_half, times_g_transpose(pt_after, g_dt));
        self.pt = pt_after;
        self.vv = Symmetric::upper(sum(vv_half, times_g_transpose(vt_after, g_dt)));
        self.vt = vt_after;
        self.add_noise(process_noise);
        self.bound();
    }

    fn add_noise(&mut self, process_noise: &ProcessNoise) {
        self.vv.xx += process_noise.velocity;
        self.vv.yy += process_noise.velocity;
        self.vv.zz += process_noise.climb;
        self.tt.xx += process_noise.tilt;
        self.tt.yy += process_noise.tilt;
        self.tt.zz += process_noise.yaw;
    }

    /// Returns P·Hᵀ for one measurement.
    pub(super) fn p_h_transpose(&self, row: &MeasurementRow) -> ErrorState {
        let MeasurementRow { height, velocity, tilt: [x, y] } = *row;
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
        ErrorState {
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

    /// Replaces P by P − c·cᵀ/s, where c = P·Hᵀ and s is the variance of the innovation.
    pub(super) fn update(&mut self, p_ht: &ErrorState, variance: f32) {
        let by = 1.0 / variance;
        let ErrorState { position, velocity, turn } = *p_ht;
        self.pp = self.pp.minus_outer_product(position, by);
        self.pv = minus_outer_product(self.pv, scaled(position, by), velocity);
        self.pt = minus_outer_product(self.pt, scaled(position, by), turn);
        self.vv = self.vv.minus_outer_product(velocity, by);
        self.vt = minus_outer_product(self.vt, scaled(velocity, by), turn);
        self.tt = self.tt.minus_outer_product(turn, by);
        self.bound();
    }

    /// Sets the variances of height, velocity and tilt, and clears their correlations; x, y and yaw
    /// keep theirs.
    pub(super) fn reset_at_rest(&mut self, height: f32, velocity: f32, tilt: f32) {
        let [x, y, _] = self.pt;
        let Symmetric { xx, xy, yy, .. } = self.pp;
        let [[_, _, x_yaw], [_, _, y_yaw]] = [x, y];
        let yaw = self.tt.zz;
        *self = Self::diagonal([xx, yy, height], [velocity; 3], [tilt, tilt, yaw]);
        self.pp.xy = xy;
        self.pt = [[0.0, 0.0, x_yaw], [0.0, 0.0, y_yaw], [0.0; 3]];
        self.bound();
    }

    /// Adds to the variance of the height.
    pub(super) fn inflate_height(&mut self, variance: f32) {
        self.pp.zz += variance;
        self.bound();
    }

    /// Adds to the variance of the horizontal velocity.
    pub(super) fn inflate_velocity(&mut self, variance: f32) {
        self.vv.xx += variance;
        self.vv.yy += variance;
        self.bound();
    }

    /// The nine variances, in the order of [`Covariance::dense`].
    pub(super) const fn variances(&self) -> [f32; 9] {
        let Self { pp, vv, tt, .. } = self;
        [pp.xx, pp.yy, pp.zz, vv.xx, vv.yy, vv.zz, tt.xx, tt.yy, tt.zz]
    }

    /// The variance of the velocity along this unit vector.
    pub(super) fn velocity_along(&self, [x, y, z]: Vector) -> f32 {
        let Symmetric { xx, xy, xz, yy, yz, zz } = self.vv;
        let mixed = x * y * xy + x * z * xz + y * z * yz;
        x * x * xx + y * y * yy + z * z * zz + 2.0 * mixed
    }

    /// The full 9 × 9 matrix, in the order position, velocity, attitude.
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

    /// Keeps each variance between [`MIN_VARIANCE`] and [`MAX_VARIANCES`]. Adding to the diagonal
    /// keeps the matrix positive definite. A variance that is too large is reduced by scaling its
    /// row and its column, which keeps it positive definite as well.
    fn bound(&mut self) {
        let variances = self.variances();
        if variances.iter().zip(MAX_VARIANCES).all(|(is, most)| (MIN_VARIANCE..=most).contains(is))
        {
            return;
        }
        let mut scale = [1.0; 9];
        for ((scale, is), most) in scale.iter_mut().zip(variances).zip(MAX_VARIANCES) {
            if is > most {
                *scale = libm::sqrtf(most / is);
            }
        }
        let [px, py, pz, vx, vy, vz, tx, ty, tz] = scale;
        let (p, v, t) = ([px, py, pz], [vx, vy, vz], [tx, ty, tz]);
        self.pp = self.pp.rescaled(p);
        self.pv = rescaled(self.pv, p, v);
        self.pt = rescaled(self.pt, p, t);
        self.vv = self.vv.rescaled(v);
        self.vt = rescaled(self.vt, v, t);
        self.tt = self.tt.rescaled(t);
        for is in [&mut self.pp, &mut self.vv, &mut self.tt] {
            for variance in [&mut is.xx, &mut is.yy, &mut is.zz] {
                *variance = variance.max(MIN_VARIANCE);
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

/// Returns M − a·bᵀ.
fn minus_outer_product([mx, my, mz]: Block, [x, y, z]: Vector, b: Vector) -> Block {
    [add(mx, scaled(b, -x)), add(my, scaled(b, -y)), add(mz, scaled(b, -z))]
}

/// Scales the rows of M by (x, y, z) and its columns by `columns`.
fn rescaled([mx, my, mz]: Block, [x, y, z]: Vector, columns: Vector) -> Block {
    let row = |[a, b, c]: Vector, by: f32| {
        let [ca, cb, cc] = columns;
        [a * ca * by, b * cb * by, c * cc * by]
    };
    [row(mx, x), row(my, y), row(mz, z)]
}

/// Returns W·M, where W·ξ = ξ×displacement.
fn w_times([mx, my, mz]: Block, [x, y, z]: Vector) -> Block {
    let difference =
        |a: Vector, by: f32, b: Vector, less: f32| add(scaled(a, by), scaled(b, -less));
    [difference(my, z, mz, y), difference(mz, x, mx, z), difference(mx, y, my, x)]
}

/// Returns M·Gᵀ, where G·ξ = g_dt·ξ×e_z.
fn times_g_transpose([mx, my, mz]: Block, g_dt: f32) -> Block {
    let row = |[x, y, _]: Vector| [g_dt * y, -g_dt * x, 0.0];
    [row(mx), row(my), row(mz)]
}
