//! Packets from the air: what is accepted is byte for byte what would have been sent.

use wire::p2p::{Error, Header, Kind, MAX_BODY, Message, TAG};

/// Decodes the bytes as a packet, and as a body of each kind.
pub fn check(data: &[u8]) {
    if let Ok((header, rest)) = Header::decode(data) {
        assert_eq!([&header.encode()[..], rest].concat(), data, "{header:?}");
        assert_eq!(header.counter.epoch().get() >> 24, 0);
        if let Some((body, _)) = rest.split_last_chunk::<TAG>() {
            same(header.kind, body);
        }
    }
    for kind in Kind::ALL {
        same(kind, data);
    }
}

fn same(kind: Kind, body: &[u8]) {
    match Message::decode(kind, body) {
        Ok(message) => {
            assert_eq!(message.kind(), kind);
            let mut out = [0; MAX_BODY];
            let length = message.encode(&mut out);
            assert_eq!(&out[..length], body, "{message:?}");
        }
        Err(Error::Length(length)) => assert_eq!(length, body.len()),
        Err(Error::Code(_) | Error::Reserved) => {}
        Err(error) => panic!("{error} of a body"),
    }
}
