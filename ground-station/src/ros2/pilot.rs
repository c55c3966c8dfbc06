//! Turns what programs ask for into the requests of a page.
//!
//! A stream of Twists is to the head what a gamepad's stick is, whose button is held while Twists come:
//! where they stop for half a second, the head stops and hovers. Each is also a sign of life, and there is
//! no other: a program that is silent is gone, like a page that hangs.

use std::time::{Duration, Instant};

use super::commands::{Age, Heard, request};
use super::state::{State, Steering};
use crate::freshness::{Echo, LIMIT};
use crate::order::{MAX_SPEED, Order};
use crate::station::Request;

/// For so long the head flies by a Twist: the greatest age of an order.
const LAPSE: Duration = Duration::from_micros(LIMIT.as_micros());
/// Speeds are rounded to such steps, m/s, so that a stick that trembles gives no new order each time.
const STEP: f64 = 0.01;

/// What a look at the commands comes to.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Said {
    /// What goes to the station.
    pub(super) requests: Vec<(Echo, Request)>,
    /// What the terminal is told, a line each.
    pub(super) complaints: Vec<String>,
}

/// The pilot who gives orders by ROS 2.
#[derive(Debug, Default)]
pub(super) struct Pilot {
    flying: Flying,
    /// The number of the last request.
    seq: u64,
    /// Since when Twists have come while neither a page nor a program steered.
    unsteered: Option<Instant>,
    /// The last complaint, which is not repeated.
    complaint: Option<String>,
}

/// Whether the head flies by Twists.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Flying {
    #[default]
    No,
    /// It does: the last Twist was sent then, and the station was told of this speed by the request of
    /// this number.
    Told { twist: Instant, speed: f32, seq: u64 },
    /// An order was given instead. Twists do nothing until they have stopped.
    Overruled { twist: Instant },
}

impl Pilot {
    /// Decides what is sent to the station.
    pub(super) fn heed(&mut self, now: Instant, state: &State, heard: Heard) -> Said {
        let mut said = Said::default();
        self.lapse(now, state, &mut said);
        for (age, text) in heard.orders {
            self.order(state, (age, &text), &mut said);
        }
        if let Some((age, forward)) = heard.forward {
            self.twist(now, state, (age, forward), &mut said);
        }
        said
    }

    /// Has the head hover where Twists have stopped.
    fn lapse(&mut self, now: Instant, state: &State, said: &mut Said) {
        let (Flying::Told { twist, .. } | Flying::Overruled { twist }) = self.flying else {
            return;
        };
        let was_told = matches!(self.flying, Flying::Told { .. });
        let has_stopped = now.saturating_duration_since(twist) >= LAPSE;
        if has_stopped || (was_told && state.steering() == Steering::Page) {
            self.flying = Flying::No;
        }
        // Where the program counts as gone by now, perhaps because this machine slept, the head hovers
        // without it, or has landed since and must not take off.
        if has_stopped && was_told && state.steering() == Steering::Program {
            let at_once = Age(Some(Duration::ZERO));
            self.send(state, at_once, Request::Order(Order::Hold), said);
        }
    }

    fn order(&mut self, state: &State, (age, text): (Age, &str), said: &mut Said) {
        let Some(request) = request(text) else {
            let start: String = text.chars().take(24).collect();
            self.complain(
                format!(
                    "/order: {start:?} is no order; give steer, wait, hold, return, land, perch, \
                     stop or branch left|right|straight|none"
                ),
                said,
            );
            return;
        };
        let is_beside = matches!(request, Request::Steer | Request::Order(Order::Branch { .. }));
        if let (false, Flying::Told { twist, .. }) = (is_beside, self.flying) {
            self.flying = Flying::Overruled { twist };
        }
        self.complaint = None;
        self.send(state, age, request, said);
    }

    fn twist(&mut self, now: Instant, state: &State, twist: (Age, f64), said: &mut Said) {
        let (age, forward) = twist;
        let Some(old) = age.0.filter(|age| *age < LAPSE) else {
            let wrong = "/cmd_vel is not followed: its messages are old or say no time; set the clocks \
                         of both machines";
            return self.complain(wrong.to_owned(), said);
        };
        if !forward.is_finite() {
            return self.complain("/cmd_vel is not followed: linear.x is no number".into(), said);
        }
        let sent = now.checked_sub(old).unwrap_or(now);
        match state.steering() {
            Steering::Program => {
                (self.unsteered, self.complaint) = (None, None);
                self.fly(state, age, (sent, forward), said);
            }
            Steering::Page => {
                let wrong =
                    "/cmd_vel is not followed: a page steers; send steer to /order to take over";
                self.complain(wrong.to_owned(), said);
            }
            Steering::Nobody => {
                // A program that had steered, and was gone, steers again by it.
                self.send(state, age, Request::Beat, said);
                let since = *self.unsteered.get_or_insert(now);
                if now.saturating_duration_since(since) >= LAPSE {
                    let wrong = "/cmd_vel is not followed: send steer to /order first";
                    self.complain(wrong.to_owned(), said);
                }
            }
        }
    }

    /// Flies the head by a Twist, when it was sent and its speed.
    fn fly(&mut self, state: &State, age: Age, (sent, forward): (Instant, f64), said: &mut Said) {
        let most = f64::from(MAX_SPEED.0);
        let speed = ((forward / STEP).round() * STEP).clamp(-most, most) as f32;
        match &mut self.flying {
            Flying::Overruled { twist } => *twist = sent,
            // No head takes off at the zeros of a stick at rest.
            Flying::No if speed == 0.0 && !state.drones.iter().any(|drone| drone.airborne) => {}
            Flying::Told { twist, speed: told, seq }
                if *told == speed && state.refused() != Some(*seq) =>
            {
                *twist = sent;
            }
            Flying::No | Flying::Told { .. } => {
                let order = if speed == 0.0 { Order::Hold } else { Order::Explore { speed } };
                self.send(state, age, Request::Order(order), said);
                self.flying = Flying::Told { twist: sent, speed, seq: self.seq };
                return;
            }
        }
        self.send(state, age, Request::Beat, said);
    }

    fn send(&mut self, state: &State, age: Age, request: Request, said: &mut Said) {
        self.seq += 1;
        said.requests.push((age.echo(state.stamp, self.seq), request));
    }

    fn complain(&mut self, wrong: String, said: &mut Said) {
        if self.complaint.as_ref() != Some(&wrong) {
            self.complaint = Some(wrong.clone());
            said.complaints.push(wrong);
        }
    }
}

#[cfg(test)]
mod tests;
