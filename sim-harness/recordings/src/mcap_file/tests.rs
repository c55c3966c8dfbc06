use std::borrow::Cow;
use std::io::{Cursor, Write};

use mcap::records::MessageHeader;
use mcap::write::WriteOptions;
use random::{Purpose, Stream};

use super::*;

/// The number of messages of [`written`].
const MESSAGES: usize = 300;

/// A file of several chunks, as the crate `mcap` writes it.
fn written() -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    let mut writer =
        WriteOptions::new().compression(None).chunk_size(Some(2_000)).create(&mut out).unwrap();
    let channel = writer.add_channel(0, "/a", "text", &BTreeMap::new()).unwrap();
    for n in 0..MESSAGES as u64 {
        let header = MessageHeader {
            channel_id: channel,
            sequence: n as u32,
            log_time: n * 1_000_000,
            publish_time: n,
        };
        writer.write_to_known_channel(&header, format!("message {n}").as_bytes()).unwrap();
    }
    writer.finish().unwrap();
    drop(writer);
    out.into_inner()
}

/// The texts of the messages, and what else was found.
fn told(bytes: &[u8]) -> (Vec<String>, Findings) {
    let mut texts = Vec::new();
    let findings = read(bytes, &mut |message| {
        texts.push(String::from_utf8_lossy(message.data).into_owned());
    });
    (texts, findings)
}

/// The same file with its chunks packed by `pack` under this name, as `mcap compress` does it.
fn packed(name: &str, pack: impl Fn(&[u8]) -> Vec<u8>) -> Vec<u8> {
    let whole = written();
    let mut bytes = MAGIC.to_vec();
    for record in Records::of(&whole, MAGIC.len()) {
        let record = record.unwrap();
        let body = match record.opcode {
            opcode::CHUNK => {
                let records = Chunk::of(&record).unwrap().unpacked(MOST_UNPACKED).bytes;
                let packed = pack(&records);
                // Two times, the size and the checksum stay.
                let mut body = record.body[..28].to_vec();
                body.extend((name.len() as u32).to_le_bytes());
                body.extend(name.as_bytes());
                body.extend((packed.len() as u64).to_le_bytes());
                body.extend(packed);
                Cow::Owned(body)
            }
            // Its checksum is over the chunks as they were.
            opcode::DATA_END => Cow::Owned(vec![0; 4]),
            _ => Cow::Borrowed(record.body),
        };
        bytes.push(record.opcode);
        bytes.extend((body.len() as u64).to_le_bytes());
        bytes.extend(&*body);
        if record.opcode == opcode::DATA_END {
            break;
        }
    }
    bytes
}

fn zstd(bytes: &[u8]) -> Vec<u8> {
    ruzstd::encoding::compress_to_vec(bytes, ruzstd::encoding::CompressionLevel::Fastest)
}

fn lz4(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = lz4_flex::frame::FrameEncoder::new(Vec::new());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

#[test]
fn a_sound_file_is_read_whole_and_without_a_remark() {
    let (texts, findings) = told(&written());
    assert_eq!(texts.len(), MESSAGES);
    assert_eq!(texts[299], "message 299");
    assert!(findings.remarks().is_empty(), "{:?}", findings.remarks());
}

#[test]
fn compressed_chunks_are_read() {
    for bytes in [packed("zstd", zstd), packed("lz4", lz4)] {
        let (texts, findings) = told(&bytes);
        assert_eq!((texts.len(), findings.remarks()), (MESSAGES, Vec::new()));
    }
}

#[test]
fn an_unknown_compression_is_named() {
    let (texts, findings) = told(&packed("brotli", zstd));
    assert!(texts.is_empty());
    assert!(findings.remarks()[0].contains("\"brotli\""), "{:?}", findings.remarks());
}

/// A few bytes that unpack to more than a file may have are not unpacked to the end.
#[test]
fn a_chunk_is_not_unpacked_beyond_what_it_claims() {
    for (name, pack) in [("zstd", zstd as fn(&[u8]) -> Vec<u8>), ("lz4", lz4)] {
        let bytes = packed(name, |records| {
            let mut long = records.to_vec();
            long.resize(8 << 20, 0);
            pack(&long)
        });
        let (_, findings) = told(&bytes);
        let why = findings.damage.map(|damage| damage.why).unwrap_or_default();
        assert!(why.ends_with("or more"), "{name}: {why}");
    }
    let record = Record { opcode: opcode::CHUNK, at: 0, body: &[] };
    assert!(Chunk::of(&record).is_err());
}

/// A small file that holds much more when it is unpacked.
#[test]
fn chunks_are_unpacked_up_to_a_bound_for_the_whole_file() {
    for (name, pack) in [("zstd", zstd as fn(&[u8]) -> Vec<u8>), ("lz4", lz4)] {
        let bytes = packed(name, pack);
        let unpacked = |most| {
            let mut messages = 0;
            let findings = read_within(&bytes, most, &mut |_| messages += 1);
            (messages, findings.damage.map(|damage| damage.why))
        };
        assert_eq!(unpacked(MOST_UNPACKED), (MESSAGES, None));
        // Room for the first of its chunks.
        let (messages, why) = unpacked(5_000);
        assert!(0 < messages && messages < MESSAGES, "{name}: {messages}");
        assert!(why.is_some_and(|why| why.contains("when unpacked")), "{name}");
    }
}

#[test]
fn a_chunk_that_does_not_match_its_checksum_is_said() {
    let mut bytes = written();
    let at = bytes.windows(11).position(|some| some == b"message 123").unwrap();
    bytes[at] = b'M';
    let (texts, findings) = told(&bytes);
    assert_eq!((texts.len(), texts[123].as_str()), (MESSAGES, "Message 123"));
    let [remark] = &findings.remarks()[..] else { panic!("{:?}", findings.remarks()) };
    assert!(remark.starts_with("1 of its chunks, the first at byte "), "{remark}");
}

/// The lengths of records and fields, each replaced by one that no file has.
#[test]
fn a_length_that_no_file_has_ends_the_reading_and_is_said() {
    let whole = written();
    let at = whole.windows(11).position(|some| some == b"message 123").unwrap();
    // A message begins with its kind, its length and 22 bytes of other fields.
    let length = at - 30..at - 22;
    for wrong in [0, 5, 1 << 20, u64::from(u32::MAX), u64::MAX - 8, u64::MAX] {
        let mut bytes = whole.clone();
        bytes[length.clone()].copy_from_slice(&wrong.to_le_bytes());
        let (texts, findings) = told(&bytes);
        assert_eq!(texts.len(), 123, "{wrong}");
        let [remark] = &findings.remarks()[..] else { panic!("{:?}", findings.remarks()) };
        assert!(remark.contains("is damaged at byte "), "{remark}");
        assert!(remark.ends_with("what stands before that was read"), "{remark}");
    }
}

#[test]
fn a_file_that_was_cut_gives_what_stands_before_the_cut() {
    let whole = written();
    let mut before = 0;
    for cut in MAGIC.len()..whole.len() {
        let (texts, findings) = told(&whole[..cut]);
        assert!(
            texts.len() >= before
                && texts.iter().enumerate().all(|(n, text)| *text == format!("message {n}"))
        );
        before = texts.len();
        assert!(texts.len() == MESSAGES || findings.damage.is_some(), "{cut}");
    }
    assert_eq!(before, MESSAGES);
}

/// Bytes that are changed, left out and put in: whatever comes, there is an end, and a remark where
/// a message is missing.
#[test]
fn no_damage_goes_unsaid() {
    let mut random = Stream::new(1, Purpose::Level(0, 0));
    for file in [written(), packed("zstd", zstd), packed("lz4", lz4)] {
        for _ in 0..2_000 {
            let mut bytes = file.clone();
            let at = random.below(bytes.len() as u32) as usize;
            match random.below(3) {
                0 => bytes[at] ^= 1 << random.below(8),
                1 => drop(bytes.remove(at)),
                _ => bytes.insert(at, random.below(256) as u8),
            }
            let (texts, findings) = told(&bytes);
            assert!(texts.len() == MESSAGES || !findings.remarks().is_empty(), "byte {at}");
        }
    }
}
