//! The container of a µSD log: its event types, and the events one by one.

use std::path::Path;

use input::InputError;

/// The first byte of a file.
pub(crate) const MAGIC: u8 = 0xBC;
/// The most variables of one event type, against damaged files: ours.
const MOST: usize = 256;

/// The types of a variable.
#[derive(Clone, Copy)]
enum Type {
    Unsigned(usize),
    Signed(usize),
    Single,
    Double,
    /// A value that is passed over.
    Other(usize),
}

impl Type {
    fn of(letter: u8) -> Option<Self> {
        Some(match letter {
            b'B' | b'?' => Self::Unsigned(1),
            b'H' => Self::Unsigned(2),
            b'I' | b'L' => Self::Unsigned(4),
            b'Q' => Self::Unsigned(8),
            b'b' => Self::Signed(1),
            b'h' => Self::Signed(2),
            b'i' | b'l' => Self::Signed(4),
            b'q' => Self::Signed(8),
            b'f' => Self::Single,
            b'd' => Self::Double,
            b'e' => Self::Other(2),
            b'c' | b'x' => Self::Other(1),
            _ => return None,
        })
    }

    fn read(self, bytes: &mut Bytes<'_>) -> Option<f64> {
        let length = match self {
            Self::Unsigned(length) | Self::Signed(length) | Self::Other(length) => length,
            Self::Single => 4,
            Self::Double => 8,
        };
        let field = bytes.take(length)?;
        let mut wide = [0; 8];
        wide.get_mut(..length)?.copy_from_slice(field);
        let unsigned = u64::from_le_bytes(wide);
        Some(match self {
            Self::Unsigned(_) => unsigned as f64,
            Self::Signed(length) => {
                let unused = 64 - 8 * length as u32;
                ((unsigned << unused) as i64 >> unused) as f64
            }
            Self::Single => f64::from(f32::from_bits(unsigned as u32)),
            Self::Double => f64::from_bits(unsigned),
            Self::Other(_) => f64::NAN,
        })
    }
}

/// The bytes of a file that are left to read.
struct Bytes<'a> {
    whole: usize,
    left: &'a [u8],
}

impl<'a> Bytes<'a> {
    fn take(&mut self, length: usize) -> Option<&'a [u8]> {
        let (field, left) = self.left.split_at_checked(length)?;
        self.left = left;
        Some(field)
    }

    fn number<const N: usize>(&mut self) -> Option<u64> {
        let mut wide = [0; 8];
        wide.get_mut(..N)?.copy_from_slice(self.take(N)?);
        Some(u64::from_le_bytes(wide))
    }

    fn text(&mut self) -> Option<&'a str> {
        let length = self.left.iter().position(|byte| *byte == 0)?;
        let text = self.take(length + 1)?;
        std::str::from_utf8(text.get(..length)?).ok()
    }

    const fn place(&self) -> usize {
        self.whole - self.left.len()
    }
}

/// One event type.
pub(crate) struct EventType {
    id: u64,
    pub(crate) names: Vec<String>,
    kinds: Vec<Type>,
}

/// One event.
pub(crate) struct Event {
    /// The place of its type among the types.
    pub(crate) kind: usize,
    pub(crate) micros: u64,
    /// One value for each variable of its type.
    pub(crate) values: Vec<f64>,
}

/// A log whose event types have been read, and whose events are read next.
pub(crate) struct Container<'a> {
    pub(crate) types: Vec<EventType>,
    /// Whether the checksum at the end is the one of the file.
    pub(crate) is_whole: bool,
    version: u64,
    rest: Bytes<'a>,
}

impl<'a> Container<'a> {
    /// Reads the event types of a log.
    ///
    /// # Errors
    /// The file is no such log, or ends within the types.
    pub(crate) fn open(bytes: &'a [u8], file: &Path) -> Result<Self, InputError> {
        let (body, is_whole) = body(bytes);
        let mut rest = Bytes { whole: body.len(), left: body };
        let broken = |rest: &Bytes<'_>, wrong: &str| {
            let wrong = format!("{wrong}, at byte {}", rest.place());
            InputError::new(wrong, "copy the file from the card again").in_file(file)
        };
        let is_log = rest.number::<1>() == Some(u64::from(MAGIC));
        let head = is_log.then(|| Some((rest.number::<2>()?, rest.number::<2>()?))).flatten();
        let Some((version @ 1..=2, count)) = head else {
            return Err(broken(&rest, "this is no µSD log of version 1 or 2"));
        };
        let mut types = Vec::new();
        for _ in 0..count {
            match event_type(&mut rest) {
                Some(kind) => types.push(kind),
                None => return Err(broken(&rest, "an event type cannot be read")),
            }
        }
        Ok(Self { types, is_whole, version, rest })
    }

    /// The next event; `None` at the end of the log.
    pub(crate) fn next(&mut self) -> Option<Result<Event, Unreadable>> {
        let at_end = self.rest.left.is_empty();
        (!at_end).then(|| self.event().ok_or(Unreadable))
    }

    fn event(&mut self) -> Option<Event> {
        let id = self.rest.number::<2>()?;
        let micros = match self.version {
            1 => self.rest.number::<4>()? * 1000,
            _ => self.rest.number::<8>()?,
        };
        let kind = self.types.iter().position(|kind| kind.id == id)?;
        let kinds = &self.types.get(kind)?.kinds;
        let values: Option<Vec<f64>> = kinds.iter().map(|kind| kind.read(&mut self.rest)).collect();
        Some(Event { kind, micros, values: values? })
    }
}

/// An event that cannot be read, and so nothing behind it.
pub(crate) struct Unreadable;

/// The file without its checksum, and whether that is right. A file that was cut short has none.
fn body(bytes: &[u8]) -> (&[u8], bool) {
    match bytes.split_last_chunk::<4>() {
        Some((body, checksum)) if crc32fast::hash(body).to_le_bytes() == *checksum => (body, true),
        _ => (bytes, false),
    }
}

fn event_type(rest: &mut Bytes<'_>) -> Option<EventType> {
    let id = rest.number::<2>()?;
    rest.text()?;
    let count = usize::try_from(rest.number::<2>()?).ok().filter(|count| *count <= MOST)?;
    let mut event = EventType { id, names: Vec::with_capacity(count), kinds: Vec::new() };
    for _ in 0..count {
        let (name, letter) = rest.text()?.strip_suffix(')')?.rsplit_once('(')?;
        let [letter] = *letter.as_bytes() else { return None };
        event.names.push(name.to_owned());
        event.kinds.push(Type::of(letter)?);
    }
    Some(event)
}
