//! The line from the radio chip: frames are the same in whatever pieces the bytes arrive, each is
//! found again in its own encoding, and a packet that can be sent back means the same.

use wire::syslink::{Counters, Decoder, Frame, Incoming, MAX_FRAME, MAX_P2P, MAX_RAW, Outgoing};

/// Feeds the bytes to a decoder; the first byte chooses the length of the pieces.
pub fn check(data: &[u8]) {
    let Some((&piece, line)) = data.split_first() else { return };
    let (whole, counters) = decoded(line, line.len());
    let in_pieces = decoded(line, 1 + usize::from(piece % 80));
    assert_eq!((&whole, counters), (&in_pieces.0, in_pieces.1));
    assert_eq!(counters.good as usize, whole.len());
    for (kind, data) in whole {
        found_again(kind, &data);
        let frame = Frame { kind, data: &data };
        if let Ok(packet) = Incoming::parse(&frame) {
            sent_back(&packet, &frame);
        }
    }
}

fn decoded(line: &[u8], piece: usize) -> (Vec<(u8, Vec<u8>)>, Counters) {
    let mut decoder = Decoder::new();
    let mut frames = Vec::new();
    for mut piece in line.chunks(piece.max(1)) {
        while let Some(frame) = decoder.next(&mut piece) {
            frames.push((frame.kind, frame.data.to_vec()));
        }
        assert!(piece.is_empty());
    }
    (frames, decoder.counters())
}

/// Checks that the frame is found in an encoding that is made here, not by the code under test.
fn found_again(kind: u8, data: &[u8]) {
    let mut line = vec![0xBC, 0xCF, kind, data.len() as u8];
    line.extend(data);
    let sums = line[2..].iter().fold((0_u8, 0_u8), |(a, b), byte| {
        let a = a.wrapping_add(*byte);
        (a, b.wrapping_add(a))
    });
    line.extend([sums.0, sums.1]);
    let (frames, counters) = decoded(&line, line.len());
    assert_eq!(frames, [(kind, data.to_vec())]);
    assert_eq!(counters, Counters { good: 1, ..Counters::default() });
}

fn sent_back(packet: &Incoming<'_>, frame: &Frame<'_>) {
    let outgoing = match *packet {
        Incoming::Raw(data) if (1..=MAX_RAW).contains(&data.len()) => Outgoing::Raw(data),
        Incoming::Channel(channel) => Outgoing::Channel(channel),
        Incoming::Datarate(rate) => Outgoing::Datarate(rate),
        Incoming::Address(address) => Outgoing::Address(address),
        Incoming::Power(power) => Outgoing::Power(power),
        Incoming::P2pBroadcast { port, data, .. } => {
            assert!(data.len() <= MAX_P2P);
            Outgoing::P2pBroadcast { port, data }
        }
        _ => return,
    };
    let mut out = [0; MAX_FRAME];
    let length = outgoing.encode(&mut out).unwrap();
    let (frames, _) = decoded(&out[..length], length);
    let data = match packet {
        Incoming::P2pBroadcast { data, .. } => [&frame.data[..1], *data].concat(),
        _ => frame.data.to_vec(),
    };
    assert_eq!(frames, [(frame.kind, data)]);
}
