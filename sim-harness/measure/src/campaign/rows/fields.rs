//! The metrics of a run by the names of their columns.

use super::{
    Cell, ExploreMetrics, FlightMetrics, HoldMetrics, Kind, NoHold, RunMetrics, SwarmMetrics,
};
use bodies::craft::record::End;
use mission::RadioMetrics;

/// One metric.
pub(super) struct Field {
    pub(super) name: &'static str,
    pub(super) kind: Kind,
    pub(super) get: fn(&RunMetrics) -> Cell,
    /// Takes the value as it is written; `None` where it is none.
    pub(super) set: fn(&mut RunMetrics, &str) -> Option<()>,
}

/// A value of a metric.
trait Value: Copy + std::str::FromStr {
    const KIND: Kind;
    fn cell(self) -> Cell;
}

impl Value for f32 {
    const KIND: Kind = Kind::Number;
    fn cell(self) -> Cell {
        if self.is_nan() { Cell::None } else { Cell::Number(self) }
    }
}

impl Value for u32 {
    const KIND: Kind = Kind::Count;
    fn cell(self) -> Cell {
        Cell::Count(self)
    }
}

const fn kind<V: Value>(_: fn(&mut RunMetrics) -> &mut V) -> Kind {
    V::KIND
}

/// A metric of a part of the metrics that every mission or some missions have: `$get` is that part,
/// if there is one, and `$make` makes it.
macro_rules! field {
    ($get:expr, $make:expr, $name:literal, $field:ident) => {
        Field {
            name: $name,
            kind: kind(|m| &mut $make(m).$field),
            get: |m| $get(m).map_or(Cell::None, |part| part.$field.cell()),
            set: |m, text| {
                $make(m).$field = text.parse().ok()?;
                Some(())
            },
        }
    };
}

macro_rules! fields {
    ($(($get:expr, $make:expr): $($name:literal $field:ident)*;)*) => {
        &[$($(field!($get, $make, $name, $field)),*),*]
    };
}

/// All metrics, in the order of their columns.
pub(super) static FIELDS: &[Field] = fields! {
    (held, hold):
        "hold_from_s" from_s "hold_until_s" until_s "t3_s" t3_s "t1_s" t1_s "t_gap1_s" t_gap1_s
        "t_repair_s" t_repair_s "gap_db" gap_db "difference_db" difference_db
        "hold_spread_db" spread_db "swing_p95_db" swing_p95_db "position_sd_m" position_sd_m
        "path_m" path_m "hold_violation" violation "relays_beyond_need" relays_beyond_need;
    (Some, itself):
        "bound_s" bound_s "launched" launched "needed" needed "violation" violation
        "peak_excess_db" peak_excess_db "cruise_gap_db" cruise_gap_db "farthest_m" farthest_m
        "t_farthest_s" t_farthest_s "head_heard_until_s" head_heard_until_s
        "still_flying" still_flying "order_lost" order_lost "wall_contacts" wall_contacts
        "drone_contacts" drone_contacts "ground_contacts" ground_contacts;
    (|m: &RunMetrics| m.swarm, swarm):
        "covered" covered "lost" lost "surveyed_s" surveyed_s "gathered_s" gathered_s "across_s" across_s
        "closest_drones_m" closest_drones_m "swarm_unfinished" unfinished;
    (|m: &RunMetrics| m.explore, explore):
        "explored" explored "walls_found" walls_found "false_walls" false_walls
        "false_free" false_free "t50_s" t50_s "t99_s" t99_s "ended_s" ended_s
        "explorers_apart_m" closest_drones_m "explore_unfinished" unfinished;
    (|m: &RunMetrics| m.flight, flight):
        "max_tilt_deg" max_tilt_deg "max_rate_dps" max_rate_dps
        "velocity_error_mps" velocity_error_mps "min_battery_v" min_battery_v
        "take_offs" take_offs "landings" landings;
};

fn held(metrics: &RunMetrics) -> Option<&HoldMetrics> {
    metrics.hold.as_ref().ok()
}

const fn itself(metrics: &mut RunMetrics) -> &mut RunMetrics {
    metrics
}

/// The metrics of the hold. Where there is a reason why there is no hold, nothing is kept.
fn hold(metrics: &mut RunMetrics) -> &mut HoldMetrics {
    if metrics.hold.is_err() {
        metrics.hold = Ok(NO_HOLD);
    }
    match &mut metrics.hold {
        Ok(hold) => hold,
        Err(_) => unreachable!("it was made just now"),
    }
}

fn swarm(metrics: &mut RunMetrics) -> &mut SwarmMetrics {
    metrics.swarm.get_or_insert(SwarmMetrics {
        covered: f32::NAN,
        lost: 0,
        surveyed_s: f32::NAN,
        gathered_s: f32::NAN,
        across_s: f32::NAN,
        closest_drones_m: f32::NAN,
        unfinished: 0,
    })
}

fn explore(metrics: &mut RunMetrics) -> &mut ExploreMetrics {
    metrics.explore.get_or_insert(ExploreMetrics {
        explored: f32::NAN,
        walls_found: f32::NAN,
        false_walls: f32::NAN,
        false_free: f32::NAN,
        t50_s: f32::NAN,
        t99_s: f32::NAN,
        ended_s: f32::NAN,
        closest_drones_m: f32::NAN,
        unfinished: 0,
    })
}

pub(super) fn flight(metrics: &mut RunMetrics) -> &mut FlightMetrics {
    metrics.flight.get_or_insert(FlightMetrics {
        max_tilt_deg: f32::NAN,
        max_rate_dps: f32::NAN,
        velocity_error_mps: f32::NAN,
        min_battery_v: f32::NAN,
        take_offs: 0,
        landings: 0,
        ends: [0; End::ALL.len()],
    })
}

const NO_HOLD: HoldMetrics = HoldMetrics {
    from_s: f32::NAN,
    until_s: f32::NAN,
    t3_s: f32::NAN,
    t1_s: f32::NAN,
    t_gap1_s: f32::NAN,
    t_repair_s: f32::NAN,
    gap_db: f32::NAN,
    difference_db: f32::NAN,
    spread_db: f32::NAN,
    swing_p95_db: f32::NAN,
    position_sd_m: f32::NAN,
    path_m: f32::NAN,
    violation: f32::NAN,
    relays_beyond_need: f32::NAN,
};

/// The metrics of which nothing is known yet.
pub(super) const NONE: RunMetrics = RunMetrics {
    hold: Err(NoHold::NeverStill),
    bound_s: f32::NAN,
    launched: f32::NAN,
    needed: f32::NAN,
    violation: f32::NAN,
    peak_excess_db: f32::NAN,
    cruise_gap_db: f32::NAN,
    farthest_m: f32::NAN,
    t_farthest_s: f32::NAN,
    head_heard_until_s: f32::NAN,
    still_flying: f32::NAN,
    order_lost: 0,
    wall_contacts: 0,
    drone_contacts: 0,
    ground_contacts: 0,
    swarm: None,
    explore: None,
    radio: RadioMetrics::NONE,
    flight: None,
};
