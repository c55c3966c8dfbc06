//! Values of the firmware as values of the host, by serde: each type is asked for by its shape.

use std::fmt;

use serde::de::value::StrDeserializer;
use serde::de::{self, DeserializeSeed, EnumAccess, MapAccess, SeqAccess, VariantAccess, Visitor};

use super::shape::{Kind, Member, Shape, Variant};
use crate::bus::Width;
use crate::memory::Memory;

/// Why a value cannot be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReadError(String);

impl fmt::Display for ReadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for ReadError {}

impl de::Error for ReadError {
    fn custom<T: fmt::Display>(message: T) -> Self {
        Self(message.to_string())
    }
}

/// A value that is about to be read.
#[derive(Clone, Copy)]
pub(super) struct Reader<'m, 's> {
    pub(super) shape: &'s Shape,
    pub(super) address: u32,
    pub(super) memory: &'m Memory,
}

/// Longer slices than this are no slices but a misreading.
const LONGEST: u32 = 65_536;

impl<'s> Reader<'_, 's> {
    fn number(&self, offset: u32, size: u32) -> Result<u64, ReadError> {
        let load = |at: u32, width| {
            let address = self.address.wrapping_add(offset).wrapping_add(at);
            self.memory.load(address, width).ok_or_else(|| {
                ReadError(format!("{}: no memory at {address:#010x}", self.shape.name))
            })
        };
        match size {
            0 => Ok(0),
            1 => load(0, Width::Byte).map(u64::from),
            2 => load(0, Width::Half).map(u64::from),
            4 => load(0, Width::Word).map(u64::from),
            8 => Ok(u64::from(load(0, Width::Word)?) | u64::from(load(4, Width::Word)?) << 32),
            _ => Err(ReadError(format!("{}: a number of {size} bytes", self.shape.name))),
        }
    }

    fn value(&self) -> Result<u64, ReadError> {
        self.number(0, self.shape.size)
    }

    fn signed(&self) -> Result<i64, ReadError> {
        let unused = 64 - 8 * self.shape.size.clamp(1, 8);
        Ok((self.value()? << unused) as i64 >> unused)
    }

    fn member(&self, member: &'s Member) -> Self {
        Self { shape: &member.shape, address: self.address.wrapping_add(member.offset), ..*self }
    }

    fn variant(&self) -> Result<&'s Variant, ReadError> {
        let Kind::Choice { discriminant, variants } = &self.shape.kind else {
            return Err(ReadError(format!("{} is no enum", self.shape.name)));
        };
        let number = match discriminant.0 {
            None => None,
            Some((offset, size)) => Some(self.number(offset, size)?),
        };
        let exact = variants.iter().find(|v| v.number.is_some() && v.number == number);
        exact
            .or_else(|| variants.iter().find(|variant| variant.number.is_none()))
            .ok_or_else(|| ReadError(format!("{}: no variant {number:?}", self.shape.name)))
    }

    /// A slice: where its elements begin, and how many there are.
    fn slice(&self, members: &'s [Member]) -> Option<(&'s Member, &'s Member)> {
        let pointer = members.iter().find(|member| member.name == "data_ptr")?;
        let length = members.iter().find(|member| member.name == "length")?;
        (members.len() == 2).then_some((pointer, length))
    }
}

macro_rules! by_shape {
    ($($name:ident)*) => {
        $(fn $name<V: Visitor<'m>>(self, visitor: V) -> Result<V::Value, ReadError> {
            self.deserialize_any(visitor)
        })*
    };
}

impl<'m> de::Deserializer<'m> for Reader<'m, '_> {
    type Error = ReadError;

    fn deserialize_any<V: Visitor<'m>>(self, visitor: V) -> Result<V::Value, ReadError> {
        match &self.shape.kind {
            Kind::Bool => match self.value()? {
                0 => visitor.visit_bool(false),
                1 => visitor.visit_bool(true),
                other => Err(ReadError(format!("{other} is no bool"))),
            },
            Kind::Char => {
                let code = self.value()? as u32;
                let char = char::from_u32(code);
                visitor.visit_char(char.ok_or_else(|| ReadError(format!("{code} is no char")))?)
            }
            Kind::Unsigned => visitor.visit_u64(self.value()?),
            Kind::Signed => visitor.visit_i64(self.signed()?),
            Kind::Float if self.shape.size == 4 => {
                visitor.visit_f32(f32::from_bits(self.value()? as u32))
            }
            Kind::Float => visitor.visit_f64(f64::from_bits(self.value()?)),
            Kind::Structure { members } => match self.slice(members) {
                Some((pointer, length)) => {
                    let Kind::Pointer { target } = &pointer.shape.kind else {
                        return Err(ReadError(format!("{} is no slice", self.shape.name)));
                    };
                    let shape = target.get().ok_or_else(|| ReadError("a dangling type".into()))?;
                    let count = self.member(length).value()? as u32;
                    if count > LONGEST {
                        return Err(ReadError(format!("a slice of {count}")));
                    }
                    let address = self.member(pointer).value()? as u32;
                    let memory = self.memory;
                    visitor.visit_seq(Elements { shape: &shape, address, left: count, memory })
                }
                None => visitor.visit_map(Fields { of: self, members: members.iter(), next: None }),
            },
            Kind::Choice { .. } | Kind::Names { .. } => visitor.visit_enum(Chosen(self)),
            Kind::Array { element, count } => visitor.visit_seq(Elements {
                shape: element,
                address: self.address,
                left: *count,
                memory: self.memory,
            }),
            Kind::Pointer { target } => {
                let shape = target.get().ok_or_else(|| ReadError("a dangling type".into()))?;
                let address = self.value()? as u32;
                Reader { shape: &shape, address, memory: self.memory }.deserialize_any(visitor)
            }
            Kind::Opaque => Err(ReadError(format!("{} cannot be read", self.shape.name))),
        }
    }

    fn deserialize_option<V: Visitor<'m>>(self, visitor: V) -> Result<V::Value, ReadError> {
        let variant = self.variant()?;
        match (variant.name.as_str(), &variant.shape.kind) {
            ("None", _) => visitor.visit_none(),
            ("Some", Kind::Structure { members }) => match members.first() {
                Some(member) => visitor.visit_some(self.member(member)),
                None => Err(ReadError(format!("{} holds nothing", self.shape.name))),
            },
            _ => Err(ReadError(format!("{} is no Option", self.shape.name))),
        }
    }

    fn deserialize_newtype_struct<V: Visitor<'m>>(
        self,
        _name: &'static str,
        visitor: V,
    ) -> Result<V::Value, ReadError> {
        match &self.shape.kind {
            Kind::Structure { members } if members.len() == 1 => {
                visitor.visit_newtype_struct(self.member(&members[0]))
            }
            _ => Err(ReadError(format!("{} is no newtype", self.shape.name))),
        }
    }

    fn deserialize_tuple<V: Visitor<'m>>(
        self,
        _length: usize,
        visitor: V,
    ) -> Result<V::Value, ReadError> {
        match &self.shape.kind {
            Kind::Structure { members } if self.slice(members).is_none() => {
                visitor.visit_seq(Tuple { of: self, members: members.iter() })
            }
            _ => self.deserialize_any(visitor),
        }
    }

    fn deserialize_tuple_struct<V: Visitor<'m>>(
        self,
        _name: &'static str,
        length: usize,
        visitor: V,
    ) -> Result<V::Value, ReadError> {
        self.deserialize_tuple(length, visitor)
    }

    fn deserialize_unit_struct<V: Visitor<'m>>(
        self,
        _name: &'static str,
        visitor: V,
    ) -> Result<V::Value, ReadError> {
        visitor.visit_unit()
    }

    fn deserialize_unit<V: Visitor<'m>>(self, visitor: V) -> Result<V::Value, ReadError> {
        visitor.visit_unit()
    }

    fn deserialize_ignored_any<V: Visitor<'m>>(self, visitor: V) -> Result<V::Value, ReadError> {
        visitor.visit_unit()
    }

    fn deserialize_struct<V: Visitor<'m>>(
        self,
        _name: &'static str,
        _fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, ReadError> {
        self.deserialize_any(visitor)
    }

    fn deserialize_enum<V: Visitor<'m>>(
        self,
        _name: &'static str,
        _variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, ReadError> {
        visitor.visit_enum(Chosen(self))
    }

    by_shape! {
        deserialize_bool deserialize_i8 deserialize_i16 deserialize_i32 deserialize_i64
        deserialize_u8 deserialize_u16 deserialize_u32 deserialize_u64 deserialize_f32
        deserialize_f64 deserialize_char deserialize_str deserialize_string deserialize_bytes
        deserialize_byte_buf deserialize_seq deserialize_map deserialize_identifier
    }
}

/// The fields of a structure, with their names.
struct Fields<'m, 's> {
    of: Reader<'m, 's>,
    members: std::slice::Iter<'s, Member>,
    next: Option<&'s Member>,
}

impl<'m> MapAccess<'m> for Fields<'m, '_> {
    type Error = ReadError;

    fn next_key_seed<K: DeserializeSeed<'m>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, ReadError> {
        self.next = self.members.next();
        let Some(member) = self.next else { return Ok(None) };
        seed.deserialize(StrDeserializer::new(&member.name)).map(Some)
    }

    fn next_value_seed<S: DeserializeSeed<'m>>(&mut self, seed: S) -> Result<S::Value, ReadError> {
        let member = self.next.take().ok_or_else(|| ReadError("a value without a name".into()))?;
        seed.deserialize(self.of.member(member))
            .map_err(|why| ReadError(format!("{}: {why}", member.name)))
    }
}

/// The fields of a tuple.
struct Tuple<'m, 's> {
    of: Reader<'m, 's>,
    members: std::slice::Iter<'s, Member>,
}

impl<'m> SeqAccess<'m> for Tuple<'m, '_> {
    type Error = ReadError;

    fn next_element_seed<S: DeserializeSeed<'m>>(
        &mut self,
        seed: S,
    ) -> Result<Option<S::Value>, ReadError> {
        let Some(member) = self.members.next() else { return Ok(None) };
        seed.deserialize(self.of.member(member)).map(Some)
    }
}

/// Values of one type, one after the other.
struct Elements<'m, 's> {
    shape: &'s Shape,
    address: u32,
    left: u32,
    memory: &'m Memory,
}

impl<'m> SeqAccess<'m> for Elements<'m, '_> {
    type Error = ReadError;

    fn next_element_seed<S: DeserializeSeed<'m>>(
        &mut self,
        seed: S,
    ) -> Result<Option<S::Value>, ReadError> {
        if self.left == 0 {
            return Ok(None);
        }
        self.left -= 1;
        let reader = Reader { shape: self.shape, address: self.address, memory: self.memory };
        self.address = self.address.wrapping_add(self.shape.size);
        seed.deserialize(reader).map(Some)
    }
}

/// A value of an enum.
struct Chosen<'m, 's>(Reader<'m, 's>);

impl<'m, 's> EnumAccess<'m> for Chosen<'m, 's> {
    type Error = ReadError;
    type Variant = Payload<'m, 's>;

    fn variant_seed<S: DeserializeSeed<'m>>(
        self,
        seed: S,
    ) -> Result<(S::Value, Payload<'m, 's>), ReadError> {
        let (name, payload) = match &self.0.shape.kind {
            Kind::Names { names } => {
                let number = self.0.value()?;
                let name = names.iter().find(|(code, _)| *code == number);
                let name = name.ok_or_else(|| {
                    ReadError(format!("{}: no variant {number}", self.0.shape.name))
                })?;
                (name.1.as_str(), Payload(None))
            }
            _ => {
                let variant = self.0.variant()?;
                let payload = Reader { shape: &variant.shape, ..self.0 };
                (variant.name.as_str(), Payload(Some(payload)))
            }
        };
        Ok((seed.deserialize(StrDeserializer::<ReadError>::new(name))?, payload))
    }
}

/// What a variant holds.
struct Payload<'m, 's>(Option<Reader<'m, 's>>);

impl<'m, 's> Payload<'m, 's> {
    fn reader(self) -> Result<Reader<'m, 's>, ReadError> {
        self.0.ok_or_else(|| ReadError("a variant without a payload".into()))
    }
}

impl<'m> VariantAccess<'m> for Payload<'m, '_> {
    type Error = ReadError;

    fn unit_variant(self) -> Result<(), ReadError> {
        Ok(())
    }

    fn newtype_variant_seed<S: DeserializeSeed<'m>>(self, seed: S) -> Result<S::Value, ReadError> {
        let reader = self.reader()?;
        match &reader.shape.kind {
            Kind::Structure { members } if members.len() == 1 => {
                seed.deserialize(reader.member(&members[0]))
            }
            _ => Err(ReadError(format!("{} does not hold one value", reader.shape.name))),
        }
    }

    fn tuple_variant<V: Visitor<'m>>(
        self,
        length: usize,
        visitor: V,
    ) -> Result<V::Value, ReadError> {
        de::Deserializer::deserialize_tuple(self.reader()?, length, visitor)
    }

    fn struct_variant<V: Visitor<'m>>(
        self,
        _fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, ReadError> {
        de::Deserializer::deserialize_any(self.reader()?, visitor)
    }
}
