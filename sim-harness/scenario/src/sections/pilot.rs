//! The section `[[pilot]]` of a scenario file: the operator's orders.

use input::InputError;
use input::reader::{At, Reader};
use serde::Deserialize;
use units::{Branch, Course, MetresPerSecond, Order};

/// One entry of the operator's script.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PilotStep {
    /// The moment from which on the order stands.
    pub at_us: u64,
    /// The order.
    pub task: Order,
}

/// One entry of `[[pilot]]`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PilotTable {
    at_s: At<f32>,
    order: OrderKey,
    speed_mps: Option<At<f32>>,
    branch: Option<At<BranchKey>>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum OrderKey {
    Wait,
    Explore,
    Return,
    Land,
    Perch,
    Stop,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum BranchKey {
    Left,
    Right,
    Straight,
}

impl From<BranchKey> for Branch {
    fn from(key: BranchKey) -> Self {
        match key {
            BranchKey::Left => Self::Left,
            BranchKey::Right => Self::Right,
            BranchKey::Straight => Self::Straight,
        }
    }
}

impl PilotTable {
    /// Checks all entries.
    pub(crate) fn read(
        steps: &[At<Self>],
        duration_us: u64,
        reader: &Reader<'_>,
    ) -> Result<Vec<PilotStep>, InputError> {
        let mut pilot: Vec<PilotStep> = Vec::with_capacity(steps.len());
        for step in steps {
            let table = step.as_ref();
            let at_us = reader.micros(&table.at_s, "at_s", 0.0..=86_400.0)?;
            if pilot.last().is_some_and(|before| before.at_us >= at_us) {
                let wrong = "the operator's orders are not in order of time".into();
                return Err(reader.wrong(&table.at_s, wrong, "sort them by at_s"));
            }
            if at_us >= duration_us {
                let wrong = format!("at_s = {} is not before the end", table.at_s.as_ref());
                let remedy = "order it earlier or raise duration_s";
                return Err(reader.wrong(&table.at_s, wrong, remedy));
            }
            let speed = match (table.order, &table.speed_mps) {
                (OrderKey::Explore, Some(speed)) => {
                    MetresPerSecond(reader.number(speed, "speed_mps", -1.0..=1.0)?)
                }
                (OrderKey::Explore, None) => {
                    let wrong = "order = \"explore\" needs a speed".into();
                    return Err(reader.wrong(step, wrong, "give speed_mps"));
                }
                (_, Some(speed)) => {
                    let wrong = "only order = \"explore\" takes a speed".into();
                    return Err(reader.wrong(speed, wrong, "remove speed_mps"));
                }
                (_, None) => MetresPerSecond::ZERO,
            };
            if let (
                OrderKey::Wait
                | OrderKey::Return
                | OrderKey::Land
                | OrderKey::Perch
                | OrderKey::Stop,
                Some(branch),
            ) = (table.order, &table.branch)
            {
                let wrong = "only order = \"explore\" takes a branch".into();
                return Err(reader.wrong(branch, wrong, "remove branch"));
            }
            let branch = table.branch.as_ref().map(|key| Branch::from(*key.as_ref()));
            let task = match table.order {
                OrderKey::Wait => Order::Wait,
                OrderKey::Explore => Order::Explore(Course { speed, branch }),
                OrderKey::Return => Order::Return,
                OrderKey::Land => Order::Land,
                OrderKey::Perch => Order::Perch,
                OrderKey::Stop => Order::Stop,
            };
            pilot.push(PilotStep { at_us, task });
        }
        Ok(pilot)
    }
}
