//! The node: publishers that take messages in CDR, and the two topics that it follows.

use std::fmt::Display;
use std::io;

use input::InputError;
use report::bag::{About, Sink};
use ros2_client::qos::{Durability, History, WhenFull};
use ros2_client::{
    Context, ContextOptions, MessageTypeName, Name, NodeName, NodeOptions, Publisher, QosProfile,
    Subscription, WriteError,
};
use serde::ser::SerializeTuple;
use serde::{Deserialize, Serialize, Serializer};

/// The largest number of a domain whose UDP ports exist: 7400 + 250 · 232 and those after it are the last
/// below 65,536 (DDSI-RTPS 2.5, 9.6.2).
pub const LARGEST_DOMAIN: u16 = 232;

/// A node in a domain of DDS.
pub struct Node {
    node: ros2_client::Node,
    publishers: Vec<Publisher<Cdr>>,
    twists: Subscription<Twist>,
    orders: Subscription<Text>,
    lost: u64,
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

/// `geometry_msgs/msg/Twist`.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
struct Twist {
    linear: [f64; 3],
    angular: [f64; 3],
}

/// `std_msgs/msg/String`.
#[derive(Clone, Debug, Deserialize, Serialize)]
struct Text {
    data: String,
}

impl Node {
    /// Joins the domain as the node `/uchain`.
    ///
    /// # Errors
    /// [`InputError`] if the domain has no free port, or the machine no network.
    pub fn open(domain: u16) -> Result<Self, InputError> {
        let unopened = |error: &dyn Display| {
            InputError::new(
                format!("--ros2 {domain}: the node cannot be opened: {error}"),
                "give another domain, or look whether this machine's network is up",
            )
        };
        let options = ContextOptions::new().domain_id(domain);
        let context = Context::with_options(options).map_err(|error| unopened(&error))?;
        let name = NodeName::new("/", "uchain").map_err(|error| unopened(&error))?;
        let options = NodeOptions::new().enable_rosout(false).start_parameter_services(false);
        let mut node = context.new_node(name, options).map_err(|error| unopened(&error))?;
        // A subscriber that is content with any effort hears every publisher.
        let latest = QosProfile::subscription_default().reliability_best_effort().history(LAST_ONE);
        let every = QosProfile::subscription_default();
        let twists = subscribe(&mut node, "/cmd_vel", "geometry_msgs/msg/Twist", &latest);
        let orders = subscribe(&mut node, "/order", "std_msgs/msg/String", &every);
        Ok(Self {
            twists: twists.map_err(|error| unopened(&error))?,
            orders: orders.map_err(|error| unopened(&error))?,
            node,
            publishers: Vec::new(),
            lost: 0,
        })
    }

    /// How many messages the DDS did not take. One that it took may still not reach a subscriber that is
    /// slower than its history lasts.
    #[must_use]
    pub const fn lost(&self) -> u64 {
        self.lost
    }

    /// The forward speed of the last Twist that came since the last call, m/s.
    pub fn take_forward(&self) -> Option<f64> {
        let twists = std::iter::from_fn(|| self.twists.take().ok().flatten());
        twists.last().map(|(twist, _)| twist.linear[0])
    }

    /// The next order that came.
    pub fn take_order(&self) -> Option<String> {
        self.orders.take().ok().flatten().map(|(text, _)| text.data)
    }
}

const LAST_ONE: History = History::KeepLast { depth: 1 };

/// The names of a topic and of its messages, `std_msgs/msg/String`.
fn names(topic: &str, kind: &str) -> io::Result<(Name, MessageTypeName)> {
    let (package, kind) = kind.split_once("/msg/").unwrap_or(("", kind));
    let topic = Name::parse(topic).map_err(io::Error::other)?;
    Ok((topic, MessageTypeName::new(package, kind)))
}

fn subscribe<M: 'static>(
    node: &mut ros2_client::Node,
    topic: &str,
    kind: &str,
    qos: &QosProfile,
) -> io::Result<Subscription<M>> {
    let (name, kind) = names(topic, kind)?;
    let topic = node.create_topic(&name, kind, qos).map_err(io::Error::other)?;
    node.create_subscription(&topic, None).map_err(io::Error::other)
}

impl Sink for Node {
    fn topic(&mut self, about: &About<'_>) -> io::Result<usize> {
        // The mission waits for no subscriber.
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
