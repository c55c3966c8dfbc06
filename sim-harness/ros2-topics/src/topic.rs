//! Topics whose messages have one kind each, and where they go.

use std::io;
use std::marker::PhantomData;

use byteorder::LittleEndian;

use crate::messages::Message;

/// A topic as a [`Sink`] is told of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct About<'a> {
    /// The name of the topic, `/drone_0/odom`.
    pub name: &'a str,
    /// The package and the name of its messages, `nav_msgs/msg/Odometry`.
    pub kind: &'static str,
    /// Whether the last message is sent to subscribers that join later, too.
    pub is_latched: bool,
}

/// Where messages go: into a file, or to other programs.
pub trait Sink {
    /// Adds a topic, and returns the number by which [`put`](Self::put) knows it.
    ///
    /// # Errors
    /// If the topic cannot be added.
    fn topic(&mut self, about: &About<'_>) -> io::Result<usize>;

    /// Takes a message of the topic with this number, at `at_us` microseconds. `cdr` is the message in CDR,
    /// little-endian, without the encapsulation header.
    ///
    /// # Errors
    /// If the message cannot be written or sent.
    fn put(&mut self, topic: usize, at_us: u64, cdr: &[u8]) -> io::Result<()>;
}

/// A topic with messages of one kind.
#[derive(Debug)]
pub struct Topic<M> {
    index: usize,
    kind: PhantomData<fn(M)>,
}

impl<M> Clone for Topic<M> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<M> Copy for Topic<M> {}

impl<M: Message> Topic<M> {
    /// Adds a topic of this name to a sink.
    ///
    /// # Errors
    /// If the sink does not take it.
    pub fn add<S: Sink + ?Sized>(sink: &mut S, name: &str, is_latched: bool) -> io::Result<Self> {
        let index = sink.topic(&About { name, kind: M::NAME, is_latched })?;
        Ok(Self { index, kind: PhantomData })
    }

    /// Gives the sink a message of this topic, at `at_us` microseconds.
    ///
    /// # Errors
    /// If the sink does not take it.
    pub fn put<S: Sink + ?Sized>(self, sink: &mut S, at_us: u64, message: &M) -> io::Result<()> {
        let cdr = cdr_encoding::to_vec::<M, LittleEndian>(message).map_err(io::Error::other)?;
        sink.put(self.index, at_us, &cdr)
    }
}
