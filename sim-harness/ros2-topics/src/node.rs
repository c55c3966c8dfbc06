//! The node: publishers that take messages in CDR, and the two topics by which an operator gives orders.

use std::fmt::Display;
use std::io;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use input::InputError;
use ros2_client::qos::{Durability, History, WhenFull};
use ros2_client::{
    Context, ContextOptions, MessageInfo, MessageTypeName, Name, NodeName, NodeOptions, Publisher,
    QosProfile, Subscription, WriteError,
};
use serde::ser::SerializeTuple;
use serde::{Serialize, Serializer};

use crate::domain::Domain;
use crate::messages::{Message, Text, Twist};
use crate::topic::{About, Sink};

/// A node in a domain of DDS. It publishes what it is given as a [`Sink`], and hears nothing.
pub struct Node {
    node: ros2_client::Node,
    domain: Domain,
    publishers: Vec<Publisher<Cdr>>,
    lost: u64,
}

/// What an operator asks for by `/cmd_vel`, `geometry_msgs/msg/Twist`, and by `/order`,
/// `std_msgs/msg/String`.
pub struct Commands {
    twists: Subscription<Twist>,
    orders: Subscription<Text>,
}

/// A message that came.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Received<T> {
    /// What the message says.
    pub what: T,
    /// When the publisher has sent it, by the clock of its machine, if it says so.
    pub sent: Option<SystemTime>,
}

/// A message in CDR: the serializer takes its bytes as they are.
#[derive(Debug)]
struct Cdr(Vec<u8>);

impl Serialize for Cdr {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        // A tuple of bytes has no length in front and no padding.
        let mut bytes = serializer.serialize_tuple(self.0.len())?;
        self.0.iter().try_for_each(|byte| bytes.serialize_element(byte))?;
        bytes.end()
    }
}

impl Node {
    /// Joins the domain as the node `/NAME`.
    ///
    /// # Errors
    /// [`InputError`] if the domain has no free port, or the machine no network.
    pub fn open(domain: Domain, name: &str) -> Result<Self, InputError> {
        let options = ContextOptions::new().domain_id(domain.number());
        let context = Context::with_options(options).map_err(|error| unopened(domain, &error))?;
        let name = NodeName::new("/", name).map_err(|error| unopened(domain, &error))?;
        let options = NodeOptions::new().enable_rosout(false).start_parameter_services(false);
        let node = context.new_node(name, options).map_err(|error| unopened(domain, &error))?;
        Ok(Self { node, domain, publishers: Vec::new(), lost: 0 })
    }

    /// Follows the two topics of an operator from now on.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn follow(&mut self) -> Result<Commands, InputError> {
        // A subscriber that is content with any effort hears every publisher.
        let latest = QosProfile::subscription_default().reliability_best_effort().history(LAST_ONE);
        let every = QosProfile::subscription_default();
        let twists = subscribe(&mut self.node, "/cmd_vel", &latest);
        let orders = subscribe(&mut self.node, "/order", &every);
        Ok(Commands {
            twists: twists.map_err(|error| unopened(self.domain, &error))?,
            orders: orders.map_err(|error| unopened(self.domain, &error))?,
        })
    }

    /// How many messages the DDS did not take. One that it took may still not reach a subscriber that is
    /// slower than its history lasts.
    #[must_use]
    pub const fn lost(&self) -> u64 {
        self.lost
    }
}

impl Commands {
    /// The forward speed, m/s, of the last Twist that came since the last call.
    pub fn take_forward(&mut self) -> Option<Received<f64>> {
        let twists = std::iter::from_fn(|| self.twists.take().ok().flatten());
        let (twist, info) = twists.last()?;
        Some(Received { what: twist.linear.x, sent: sent(&info) })
    }

    /// The next order that came.
    pub fn take_order(&mut self) -> Option<Received<String>> {
        let (text, info) = self.orders.take().ok().flatten()?;
        Some(Received { what: text.data, sent: sent(&info) })
    }
}

fn sent(info: &MessageInfo) -> Option<SystemTime> {
    let nanos = u64::try_from(info.source_timestamp()?.to_nanos()).ok()?;
    Some(UNIX_EPOCH + Duration::from_nanos(nanos))
}

fn unopened(domain: Domain, error: &dyn Display) -> InputError {
    InputError::new(
        format!("--ros2 {}: the node cannot be opened: {error}", domain.number()),
        "give another domain, or look whether this machine's network is up",
    )
}

const LAST_ONE: History = History::KeepLast { depth: 1 };

/// The names of a topic and of its messages, `std_msgs/msg/String`.
fn names(topic: &str, kind: &str) -> io::Result<(Name, MessageTypeName)> {
    let (package, kind) = kind.split_once("/msg/").unwrap_or(("", kind));
    let topic = Name::parse(topic).map_err(io::Error::other)?;
    Ok((topic, MessageTypeName::new(package, kind)))
}

fn subscribe<M: Message + 'static>(
    node: &mut ros2_client::Node,
    topic: &str,
    qos: &QosProfile,
) -> io::Result<Subscription<M>> {
    let (name, kind) = names(topic, M::NAME)?;
    let topic = node.create_topic(&name, kind, qos).map_err(io::Error::other)?;
    node.create_subscription(&topic, None).map_err(io::Error::other)
}

impl Sink for Node {
    fn topic(&mut self, about: &About<'_>) -> io::Result<usize> {
        // A publisher waits for no subscriber.
        let qos = QosProfile::publisher_default().reliability_reliable(WhenFull::Fail);
        let qos = if about.is_latched {
            qos.durability(Durability::TransientLocal).history(LAST_ONE)
        } else {
            qos
        };
        let (name, kind) = names(about.name, about.kind)?;
        let topic = self.node.create_topic(&name, kind, &qos).map_err(io::Error::other)?;
        let publisher = self.node.create_publisher(&topic, None).map_err(io::Error::other)?;
        self.publishers.push(publisher);
        Ok(self.publishers.len() - 1)
    }

    fn put(&mut self, topic: usize, _: u64, cdr: &[u8]) -> io::Result<()> {
        let Some(publisher) = self.publishers.get(topic) else { return Ok(()) };
        match publisher.publish(Cdr(cdr.to_vec())) {
            Ok(()) => Ok(()),
            Err(WriteError::WouldBlock { .. } | WriteError::Io(_)) => {
                self.lost += 1;
                Ok(())
            }
            Err(error) => Err(io::Error::other(error.to_string())),
        }
    }
}
