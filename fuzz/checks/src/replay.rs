//! The requests of a replay: whatever bytes come, the next frame is received; a request that is
//! accepted is word for word what its encoder sends; and a drone carries out any.

use airlink::Sealed;
use onboard::Drone;
use onboard::replay::{Answer, NoStopwatch, Receiver, Refusal, Request, Session, VERSION};
use storage::crc32;

/// The head of a frame of this version with this kind of record.
fn head(kind: u8) -> u32 {
    0x5552_0000 | u32::from(VERSION) << 8 | u32::from(kind)
}

/// Takes the bytes as those of the line, and as the words of a request; the first byte chooses its
/// kind.
pub fn check(data: &[u8]) {
    let Some((&choice, rest)) = data.split_first() else { return };
    let mut receiver = Receiver::new();
    received(&mut receiver, rest);
    received(&mut receiver, &[0]);
    let body = rest.as_chunks::<4>().0.iter().copied().map(u32::from_le_bytes);
    // A beginning or a step.
    let frame = framed(head(1 + choice % 2 * 2), body);
    let mut requests = received(&mut receiver, &frame);
    assert_eq!(requests.len(), 1, "a whole frame is one request or one error");
    let Some(Ok((number, request))) = requests.pop() else { return };
    let mut sent = Vec::new();
    request.send(number, |byte| sent.push(byte));
    assert_eq!(sent, frame);
    carried_out(&request);
}

fn received(receiver: &mut Receiver, bytes: &[u8]) -> Vec<Result<(u32, Request), Refusal>> {
    bytes.iter().filter_map(|byte| receiver.push(*byte, Request::parse)).collect()
}

/// A frame that is made here, not by the code under test.
fn framed(head: u32, body: impl Iterator<Item = u32>) -> Vec<u8> {
    let mut bytes: Vec<u8> = [head, 7].into_iter().chain(body).flat_map(u32::to_le_bytes).collect();
    bytes.extend(crc32(bytes.iter().copied()).to_le_bytes());
    let mut stuffed = Vec::new();
    let mut runs = bytes.split(|byte| *byte == 0).peekable();
    while let Some(run) = runs.next() {
        let mut rest = run;
        // A run of 254 bytes stands for no zero behind it.
        while rest.len() >= 254 {
            stuffed.push(255);
            stuffed.extend(&rest[..254]);
            rest = &rest[254..];
            if rest.is_empty() && runs.peek().is_none() {
                stuffed.push(0);
                return stuffed;
            }
        }
        stuffed.push(rest.len() as u8 + 1);
        stuffed.extend(rest);
    }
    stuffed.push(0);
    stuffed
}

/// Carries a request out on a drone in the air that was told nothing else, twice.
fn carried_out(request: &Request) {
    let begin = Request::Begin(onboard::replay::Begin {
        node: units::NodeId(1),
        role: units::Role::Relay,
        in_air: Some(units::Instant::ZERO),
        policy: units::PolicyCode::new(6).expect("it is not zero"),
        is_filtered: false,
        links: 2,
    });
    let (mut session, mut drone) = (Session::new(), Box::new(Drone::<Sealed>::switched_off()));
    for request in [&begin, request, request] {
        let answer = session.answer(&mut drone, request, &NoStopwatch);
        let mut bytes = Vec::new();
        answer.send(7, |byte| bytes.push(byte));
        let mut receiver = Receiver::new();
        let found = bytes.iter().find_map(|byte| {
            receiver.push(*byte, |frame| Answer::parse(&frame.expect("the answer is a frame")))
        });
        assert!(found.flatten().is_some(), "{answer:?}");
    }
}
